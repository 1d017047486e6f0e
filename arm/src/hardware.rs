//! The FPGA's registers, and the check that it is the one this program was built for.

use std::borrow::Cow;

use crate::message::Registers;
use hoverlock_fixed_point::model::design::KT27;

/// Byte addresses and masks, as the hardware's sources emit them.
#[path = "../../rtl/registers/hoverlock_registers.rs"]
pub mod registers;

pub use registers::{EMISSION_VALUE as EMISSION, IDENTIFICATION_VALUE as IDENTIFICATION, VERSION_VALUE as VERSION};

/// What the design of an FPGA decides.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fpga {
    /// What `version` reads.
    pub version: u32,
    /// What `emission` reads.
    pub emission: u32,
    /// Most columns of a frame.
    pub columns: u32,
    /// Scale pairs, 1 to 3.
    pub pairs: u32,
    /// Features of a scale pair in a frame that automatic thresholds aim at.
    pub target: u32,
    /// Byte address and value of each coefficient.
    pub coefficients: Cow<'static, [(u32, u32)]>,
}

impl Default for Fpga {
    /// That of the Verilog that this program was built with.
    fn default() -> Self {
        Self {
            version: VERSION,
            emission: EMISSION,
            columns: KT27.width,
            pairs: KT27.scale_pairs,
            target: KT27.threshold.target,
            coefficients: Cow::Borrowed(&registers::COEFFICIENTS),
        }
    }
}

/// Columns and rows of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Columns, from 64 to the most of the design.
    pub width: u16,
    /// Rows, 64 to 2048.
    pub height: u16,
}

impl Size {
    /// A size.
    ///
    /// # Errors
    /// Where the hardware does not take it.
    pub fn new(fpga: &Fpga, width: u32, height: u32) -> Result<Self, HardwareError> {
        if !(64..=fpga.columns).contains(&width) || !(64..=2048).contains(&height) {
            return Err(HardwareError::Size { width, height, columns: fpga.columns });
        }
        Ok(Self { width: width as u16, height: height as u16 })
    }
}

/// Why the FPGA cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum HardwareError {
    /// A register is missing from the block.
    #[error("the register block has no address 0x{address:02x} ({name}); read all registers at start")]
    Missing {
        /// Its name.
        name: &'static str,
        /// Its byte address.
        address: u32,
    },
    /// A read-only register has another value than in the Verilog this program was built with.
    #[error("register {name} reads 0x{read:08x}, not 0x{built:08x}: {advice}")]
    Different {
        /// Its name.
        name: &'static str,
        /// As read.
        read: u32,
        /// As built.
        built: u32,
        /// What to do.
        advice: &'static str,
    },
    /// The frame size is not one that the hardware takes.
    #[error("a frame of {width} x {height} pixels; the hardware takes 64 x 64 to {columns} x 2048")]
    Size {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Most columns.
        columns: u32,
    },
}

/// Checks that it is the FPGA that is expected; `read` takes a register's name and byte address.
///
/// # Errors
/// Where identification, version or emission hash are not as expected, or cannot be read.
pub fn identify<E: From<HardwareError>>(
    fpga: &Fpga,
    mut read: impl FnMut(&'static str, u32) -> Result<u32, E>,
) -> Result<(), E> {
    let expected = [
        (
            "identification",
            registers::IDENTIFICATION,
            IDENTIFICATION,
            "no Hoverlock core at this address; correct the base address",
        ),
        (
            "version",
            registers::VERSION,
            fpga.version,
            "the register map is another; load the FPGA image of this program's release",
        ),
        (
            "emission",
            registers::EMISSION,
            fpga.emission,
            "the FPGA holds other Verilog; build the FPGA image and this program from one release",
        ),
    ];
    for (name, address, built, advice) in expected {
        let read = read(name, address)?;
        if read != built {
            return Err(HardwareError::Different { name, read, built, advice }.into());
        }
    }
    Ok(())
}

/// The frame size of the FPGA, where it is the one that is expected.
///
/// # Errors
/// Where identification, version, emission hash or size are missing or not as expected.
pub fn check(fpga: &Fpga, block: &Registers) -> Result<Size, HardwareError> {
    let read = |name, address| block.get(address).ok_or(HardwareError::Missing { name, address });
    identify(fpga, read)?;
    let size = read("size", registers::SIZE)?;
    let field = |mask: u32| (size & mask) >> mask.trailing_zeros();
    Size::new(fpga, field(registers::SIZE_WIDTH), field(registers::SIZE_HEIGHT))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::encode_registers;

    fn block(change: impl Fn(u32, u32) -> u32) -> Result<Size, HardwareError> {
        let registers = [
            (registers::IDENTIFICATION, IDENTIFICATION),
            (registers::VERSION, VERSION),
            (registers::EMISSION, EMISSION),
            (registers::SIZE, 768 << 16 | 1024),
        ];
        let payload = encode_registers(&registers.map(|(address, value)| (address, change(address, value))));
        check(&Fpga::default(), &Registers::parse(&payload).unwrap())
    }

    #[test]
    fn the_emitted_hardware_passes_and_any_other_is_named() {
        assert_eq!(&IDENTIFICATION.to_be_bytes(), b"HLCK");
        assert_eq!(block(|_, value| value), Ok(Size { width: 1024, height: 768 }));
        for (address, name) in [
            (registers::IDENTIFICATION, "identification"),
            (registers::VERSION, "version"),
            (registers::EMISSION, "emission"),
        ] {
            let outcome = block(|a, value| if a == address { value ^ 1 } else { value });
            assert!(matches!(outcome, Err(HardwareError::Different { name: n, .. }) if n == name), "{outcome:?}");
        }
        let small = block(|a, value| if a == registers::SIZE { 63 << 16 | 64 } else { value });
        assert_eq!(small, Err(HardwareError::Size { width: 64, height: 63, columns: 1024 }));
        let payload = encode_registers(&[(registers::IDENTIFICATION, IDENTIFICATION)]);
        let missing = check(&Fpga::default(), &Registers::parse(&payload).unwrap());
        assert_eq!(missing, Err(HardwareError::Missing { name: "version", address: registers::VERSION }));
    }
}
