//! The top between camera, DMA and CPU: what the CPU finds in memory is what `bit_true` lists, however late the CPU is.

use hoverlock_fixed_point::model::bit_true::{FeatureRecord, ThresholdController, counts};
use hoverlock_fixed_point::model::design::KT27;
use hoverlock_fixed_point::model::simd::SimdBitTrue;
use hoverlock_reference::image::plane::Plane;
use hoverlock_rtl::simulation::board::{Driver, RegisterPort};
use hoverlock_rtl::simulation::{SimulationError, Simulator};

/// Hashed blocks of 5 pixels, another picture for each seed.
fn frame(seed: usize) -> Plane<u16> {
    Plane::from_fn(200, 140, |x, y| {
        let hash = (x / 5 + 977 * seed).wrapping_mul(0x9E37_79B9) ^ (y / 5).wrapping_mul(0x85EB_CA6B);
        ((hash.wrapping_mul(0x27D4_EB2F) >> 24) & 0xff) as u16 * 257
    })
}

/// The records of a packet, and its trailer.
fn records(bytes: &[u8]) -> (Vec<[u32; 8]>, [u32; 8]) {
    let word = |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().unwrap());
    let mut records: Vec<[u32; 8]> =
        bytes.chunks_exact(32).map(|record| std::array::from_fn(|i| word(&record[4 * i..4 * i + 4]))).collect();
    let trailer = records.pop().unwrap();
    (records, trailer)
}

/// `bit_true` of the frames, the thresholds following the counts.
fn expected(frames: &[Plane<u16>], thresholds: [u32; 2]) -> Vec<(Vec<FeatureRecord>, [u32; 2])> {
    let mut model = SimdBitTrue::new(&KT27).unwrap();
    let mut control = ThresholdController::resumed(&KT27, &thresholds);
    let of_frame = |frame: &Plane<u16>| {
        let thresholds = control.thresholds().try_into().expect("two scale pairs");
        let records = model.frame(frame, control.thresholds()).to_vec();
        control.finish_frame(&counts(&records));
        (records, thresholds)
    };
    frames.iter().map(of_frame).collect()
}

/// Size, thresholds of the first frame, automatic; commit; enabled, with the interrupt.
fn set_up(port: &mut RegisterPort<'_>, thresholds: [u32; 2]) -> Result<(), SimulationError> {
    let [fine, coarse] = thresholds;
    let writes = [(0x14, 140 << 16 | 200), (0x18, coarse << 16 | fine), (0x0c, 0b010), (0x30, 1), (0x0c, 0b111)];
    writes.into_iter().try_for_each(|(address, value)| port.write(address, value))
}

#[test]
fn the_memory_holds_the_list_of_the_model() {
    let frames: Vec<_> = (0..5).map(frame).collect();
    let thresholds = [40, 30];
    let simulator = Simulator::new().unwrap();
    // At once, later than the DMA, and later than three frames, so that the ring is full.
    for latency in [0, 3_000, 300_000] {
        let mut driver = Driver::start(&simulator, latency, |port| set_up(port, thresholds)).unwrap();
        frames.iter().cloned().for_each(|frame| driver.send(frame));
        let register = |address: u32| driver.registers().iter().find(|(at, _)| *at == address).unwrap().1;
        assert_eq!((register(0x00), register(0x14)), (u32::from_be_bytes(*b"HLCK"), 140 << 16 | 200));
        let mut dropped = 0;
        for (number, (list, thresholds)) in expected(&frames, thresholds).into_iter().enumerate() {
            let packet = driver.packet().unwrap().unwrap();
            let (found, trailer) = records(&packet.bytes);
            let mut rest = list.iter().map(FeatureRecord::pack);
            assert!(
                found.iter().all(|record| rest.any(|other| other[..8] == *record)),
                "latency {latency}, frame {number}"
            );
            assert!(found.len() > 100, "latency {latency}, frame {number}: {} features", found.len());
            assert_eq!((trailer[0], trailer[1]), (number as u32, 1 << 31), "latency {latency}");
            assert_eq!((trailer[2], trailer[4]), (found.len() as u32, thresholds[1] << 16 | thresholds[0]));
            assert_eq!(found.len() + trailer[3] as usize, list.len(), "latency {latency}, frame {number}");
            dropped += trailer[3];
        }
        assert!(driver.packet().unwrap().is_none());
        assert_eq!(driver.status() & 0x1e, 0, "no error of a frame");
        assert_eq!(dropped > 0, latency == 300_000, "latency {latency}: {dropped} dropped");
    }
}
