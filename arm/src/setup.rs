//! Configuration of the FPGA before the first frame: checks, writes and read-backs in this order.
//!
//! | step | access |
//! |---|---|
//! | 1 | read `identification`, `version`, `emission`; stop if they differ |
//! | 2 | `control`: not enabled, `automatic` as wanted; `size`, coefficients, `threshold`, `target`, `record_limit` |
//! | 3 | 1 to `commit`: the next frame captures the whole set |
//! | 4 | read the set and `commit` back |
//! | 5 | `control`: `enable` and `interrupt_frame` too, and read back |
//!
//! So `control.enable` reads 1 only once all other registers hold their values.

use crate::bus::Bus;
use crate::hardware::{Fpga, HardwareError, Size, identify, registers as map};
use hoverlock_design::KT27;
use hoverlock_reference::features::feature::MAX_PAIRS;
use hoverlock_registers::record::default_limit;

/// Byte address of the threshold of scale pair 2, in register maps of three scale pairs.
const THRESHOLD_2: u32 = 0x34;

/// The thresholds of the scale pairs, finest first, in LSB of the response, at least 1. Elements for pairs that the
/// design does not have are ignored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Thresholds {
    /// The same thresholds for all frames.
    Fixed([u32; MAX_PAIRS]),
    /// Initial thresholds; the FPGA then adjusts them so that the feature count approaches [`Fpga::target`].
    Automatic([u32; MAX_PAIRS]),
}

impl Default for Thresholds {
    /// Automatic thresholds that start at the initial threshold of the default design.
    fn default() -> Self {
        Self::Automatic([KT27.threshold.initial; MAX_PAIRS])
    }
}

/// The reason why the FPGA was not configured. It is not enabled then.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SetupError<E: std::error::Error> {
    /// A bus access failed.
    #[error(transparent)]
    Bus(E),
    /// The FPGA is not the one this program was built for.
    #[error(transparent)]
    Hardware(#[from] HardwareError),
    /// A register does not hold the value written to it.
    #[error("the register at 0x{address:02x} reads 0x{read:08x} after 0x{wrote:08x} was written; correct the bridge")]
    ReadBack {
        /// Byte address of the register.
        address: u32,
        /// Value written.
        wrote: u32,
        /// Value read back.
        read: u32,
    },
}

/// Configures the FPGA for frames of `size` and enables it and its frame interrupt.
///
/// # Errors
/// If the FPGA is another one, an access fails, or a register does not hold the value written to it.
pub fn set_up<B: Bus>(
    bus: &mut B,
    fpga: &Fpga,
    size: Size,
    thresholds: Thresholds,
) -> Result<(), SetupError<B::Error>> {
    identify(fpga, |_, address| bus.read(address).map_err(SetupError::Bus))?;
    let (automatic, [fine, coarse, coarsest]) = match thresholds {
        Thresholds::Fixed(thresholds) => (0, thresholds),
        Thresholds::Automatic(thresholds) => (map::CONTROL_AUTOMATIC, thresholds),
    };
    let set = [
        (map::CONTROL, automatic),
        (map::SIZE, field(map::SIZE_WIDTH, size.width.into()) | field(map::SIZE_HEIGHT, size.height.into())),
    ]
    .into_iter()
    .chain(fpga.coefficients.iter().copied())
    .chain([(map::THRESHOLD, field(map::THRESHOLD_FINE, fine) | if fpga.pairs > 1 { coarse << 16 } else { 0 })])
    .chain((fpga.pairs > 2).then_some((THRESHOLD_2, coarsest)))
    .chain([(map::TARGET, field(map::TARGET_COUNT, fpga.target))])
    .chain([(map::RECORD_LIMIT, field(map::RECORD_LIMIT_COUNT, default_limit(fpga.pairs as usize)))]);
    let commit = (map::COMMIT, map::COMMIT_PENDING);
    for (address, value) in set.clone().chain([commit]) {
        bus.write(address, value).map_err(SetupError::Bus)?;
    }
    for (address, wrote) in set.chain([commit]) {
        read_back(bus, address, wrote)?;
    }
    let enabled = automatic | map::CONTROL_ENABLE | map::CONTROL_INTERRUPT_FRAME;
    bus.write(map::CONTROL, enabled).map_err(SetupError::Bus)?;
    read_back(bus, map::CONTROL, enabled)
}

fn field(mask: u32, value: u32) -> u32 {
    value << mask.trailing_zeros() & mask
}

fn read_back<B: Bus>(bus: &mut B, address: u32, wrote: u32) -> Result<(), SetupError<B::Error>> {
    let read = bus.read(address).map_err(SetupError::Bus)?;
    if read == wrote { Ok(()) } else { Err(SetupError::ReadBack { address, wrote, read }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hardware::{EMISSION, IDENTIFICATION, VERSION};
    use hoverlock_fixed_point::model::coefficients::LerpCoefficients;
    use hoverlock_fixed_point::model::stages::StageCoefficients;
    use std::collections::BTreeMap;
    use std::convert::Infallible;

    const SIZE: Size = Size { width: 640, height: 480 };

    /// A register file that records all writes; bit 0 of the register at `stuck` reads inverted.
    struct Recorded {
        registers: BTreeMap<u32, u32>,
        writes: Vec<(u32, u32)>,
        stuck: Option<u32>,
    }

    impl Recorded {
        fn new() -> Self {
            let built = [(map::IDENTIFICATION, IDENTIFICATION), (map::VERSION, VERSION), (map::EMISSION, EMISSION)];
            Self { registers: built.into(), writes: Vec::new(), stuck: None }
        }
    }

    impl Bus for Recorded {
        type Error = Infallible;

        fn read(&mut self, address: u32) -> Result<u32, Infallible> {
            let stuck = u32::from(self.stuck == Some(address));
            Ok(self.registers.get(&address).copied().unwrap_or_default() ^ stuck)
        }

        fn write(&mut self, address: u32, value: u32) -> Result<(), Infallible> {
            self.writes.push((address, value));
            self.registers.insert(address, value);
            Ok(())
        }
    }

    /// Returns the coefficients that the model computes for the design point, with their addresses.
    fn coefficients() -> Vec<(u32, u32)> {
        let stages = KT27.sigmas.iter().zip(&*KT27.look_ahead).flat_map(|(&sigma, &look_ahead)| {
            let designed = LerpCoefficients::design(sigma, look_ahead, KT27.coefficient.bits()).unwrap();
            let stages = StageCoefficients::from(designed);
            [stages.g].into_iter().chain(stages.g_j).collect::<Vec<_>>()
        });
        (0x40..).step_by(4).zip(stages).collect()
    }

    #[test]
    fn the_set_is_written_then_committed_then_enabled() {
        for (thresholds, automatic) in
            [(Thresholds::Fixed([700, 900, 1]), 0), (Thresholds::Automatic([700, 900, 1]), 2)]
        {
            let mut bus = Recorded::new();
            set_up(&mut bus, &Fpga::default(), SIZE, thresholds).unwrap();
            let mut expected = vec![(0x0c, automatic), (0x14, 480 << 16 | 640)];
            expected.extend(coefficients());
            expected.extend([(0x18, 900 << 16 | 700), (0x1c, 512), (0x3c, 2046), (0x30, 1), (0x0c, automatic | 0b101)]);
            assert_eq!(bus.writes, expected);
        }
        assert_eq!(Thresholds::default(), Thresholds::Automatic([2048; 3]));
    }

    #[test]
    fn another_fpga_is_never_written() {
        for (address, wanted) in [(0x00, "identification"), (0x04, "version"), (0x08, "emission")] {
            let mut bus = Recorded { stuck: Some(address), ..Recorded::new() };
            let outcome = set_up(&mut bus, &Fpga::default(), SIZE, Thresholds::default());
            let Err(SetupError::Hardware(HardwareError::Different { name, .. })) = outcome else {
                panic!("{outcome:?}")
            };
            assert_eq!((name, bus.writes.len()), (wanted, 0));
        }
    }

    #[test]
    fn a_register_that_does_not_keep_its_value_is_named_and_nothing_is_enabled() {
        let all = [map::CONTROL, map::SIZE, map::THRESHOLD, map::TARGET, map::RECORD_LIMIT, map::COMMIT];
        for address in all.into_iter().chain(map::COEFFICIENTS.map(|(address, _)| address)) {
            let mut bus = Recorded { stuck: Some(address), ..Recorded::new() };
            let outcome = set_up(&mut bus, &Fpga::default(), SIZE, Thresholds::default());
            assert!(matches!(outcome, Err(SetupError::ReadBack { address: a, .. }) if a == address), "{outcome:?}");
            let enabled = bus.registers[&map::CONTROL] & map::CONTROL_ENABLE;
            assert_eq!(enabled, 0, "0x{address:02x}");
        }
    }
}
