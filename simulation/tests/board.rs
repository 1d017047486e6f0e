//! The top between camera, DMA and CPU: what the CPU finds in memory is what `bit_true` lists, however late the CPU is.

use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::model::design::camera_samples;
use hoverlock_fixed_point::model::record::FeatureRecord;
use hoverlock_fixed_point::model::record_limit::RecordLimit;
use hoverlock_fixed_point::model::simd::SimdBitTrue;
use hoverlock_fixed_point::model::threshold::ThresholdController;
use hoverlock_reference::image::plane::Plane;
use hoverlock_simulation::board::{Driver, RegisterPort};
use hoverlock_simulation::{SimulationError, Simulator, Trace};

/// Hashed blocks of 5 pixels, another picture for each seed.
fn frame(seed: usize) -> Plane<u16> {
    Plane::from_fn(200, 140, |x, y| {
        let hash = (x / 5 + 977 * seed).wrapping_mul(0x9E37_79B9) ^ (y / 5).wrapping_mul(0x85EB_CA6B);
        ((hash.wrapping_mul(0x27D4_EB2F) >> 24) & 0xff) as u16 * 257
    })
}

/// The records of a packet, and its trailer.
fn records(design: &DesignPoint, bytes: &[u8]) -> (Vec<Vec<u32>>, Vec<u32>) {
    let word = |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().unwrap());
    let size = if design.pairs() > 2 { 40 } else { 32 };
    let mut records: Vec<Vec<u32>> =
        bytes.chunks_exact(size).map(|record| record.chunks_exact(4).map(word).collect()).collect();
    let trailer = records.pop().unwrap();
    (records, trailer)
}

/// Records sent, number of features withheld, and thresholds of a frame.
type Sent = (Vec<FeatureRecord>, usize, Vec<u32>);

/// `bit_true` of the frames, the thresholds following the responses.
fn expected(design: &DesignPoint, frames: &[Plane<u16>], thresholds: &[u32], limit: u32) -> Vec<Sent> {
    let mut model = SimdBitTrue::new(design).unwrap();
    let mut control = ThresholdController::resumed(design, thresholds);
    let of_frame = |frame: &Plane<u16>| {
        let thresholds = control.thresholds().to_vec();
        let features = model.frame(frame, &thresholds).to_vec();
        control.finish_frame(model.maxima());
        let records = RecordLimit::sent(limit, &thresholds, design.max_dog(), frame.height(), &features);
        let withheld = features.len() - records.len();
        (records, withheld, thresholds)
    };
    frames.iter().map(of_frame).collect()
}

/// Size, thresholds of the first frame, record limit, automatic; commit; enabled, with the interrupt.
fn set_up(port: &mut RegisterPort<'_>, thresholds: &[u32], limit: u32) -> Result<(), SimulationError> {
    let third = thresholds.get(2).map(|coarsest| (0x34, *coarsest));
    let writes = [(0x14, 140 << 16 | 200), (0x18, thresholds[1] << 16 | thresholds[0])].into_iter().chain(third);
    writes
        .chain([(0x3c, limit), (0x0c, 0b010), (0x30, 1), (0x0c, 0b111)])
        .try_for_each(|(address, value)| port.write(address, value))
}

#[test]
fn the_memory_holds_the_list_of_the_model() {
    // In LSB of the responses: of 0.5, 32 and 1 DN.
    for (design, thresholds) in [("kt27", &[40u32, 30][..]), ("small", &[1, 1]), ("three_scales", &[20, 15, 10])] {
        let design = DesignPoint::shipped(design).unwrap();
        let frames: Vec<_> = (0..5).map(|seed| camera_samples(&design, &frame(seed))).collect();
        let simulator = Simulator::of_design(&design, None, Trace::None).unwrap();
        // At once, later than the DMA, and later than three frames, so that the ring is full.
        for (latency, limit) in [(0, 2046), (0, 150), (3_000, 2046), (300_000, 2046)] {
            late(&simulator, latency, &frames, thresholds, limit);
        }
    }
}

fn late(simulator: &Simulator, latency: u64, frames: &[Plane<u16>], thresholds: &[u32], limit: u32) {
    let design = simulator.design();
    let mut driver = Driver::start(simulator, latency, |port| set_up(port, thresholds, limit)).unwrap();
    frames.iter().for_each(|frame| driver.send(frame).unwrap());
    let register = |address: u32| driver.registers().iter().find(|(at, _)| *at == address).unwrap().1;
    assert_eq!((register(0x00), register(0x14)), (u32::from_be_bytes(*b"HLCK"), 140 << 16 | 200));
    let flags = if design.pairs() > 2 { 0x9000 } else { 0x8000 };
    let mut dropped = 0;
    let expected = expected(design, frames, thresholds, limit);
    assert!(limit == 2046 || expected.iter().any(|(_, withheld, _)| *withheld > 100));
    for (number, (list, withheld, thresholds)) in expected.into_iter().enumerate() {
        let what = format!("{} pairs, latency {latency}, frame {number}", design.pairs());
        let packet = driver.packet().unwrap().unwrap();
        let (found, trailer) = records(design, &packet.bytes);
        let mut rest = list.iter().map(FeatureRecord::pack);
        assert!(found.iter().all(|record| rest.any(|other| other[..record.len()] == record[..])), "{what}");
        // Of the latest CPU the queue of the small design may hold none of a frame.
        assert!(found.len() > 70 || latency == 300_000, "{what}: {} features", found.len());
        assert_eq!((trailer[0], trailer[1]), (number as u32, flags << 16), "{what}");
        assert_eq!((trailer[2], trailer[4]), (found.len() as u32, thresholds[1] << 16 | thresholds[0]), "{what}");
        assert_eq!(trailer[5], thresholds.get(2).copied().unwrap_or_default(), "{what}");
        assert_eq!(found.len() + trailer[3] as usize, list.len(), "{what}");
        assert_eq!(trailer[6] as usize, withheld, "{what}");
        dropped += trailer[3];
    }
    assert!(driver.packet().unwrap().is_none());
    assert_eq!(driver.status() & 0x1e, 0, "no error of a frame");
    assert_eq!(dropped > 0, latency == 300_000, "latency {latency}: {dropped} dropped");
}
