//! The FPGA's registers, and the check that it is the one this program was built for.

use std::borrow::Cow;

use crate::message::Registers;
use hoverlock_design::KT27;

pub use hoverlock_registers::kt27 as registers;
pub use hoverlock_registers::kt27::{
    EMISSION_VALUE as EMISSION, IDENTIFICATION_VALUE as IDENTIFICATION, VERSION_VALUE as VERSION,
};

/// The parameters of an FPGA image that the program checks or writes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fpga {
    /// Expected value of the register `version`.
    pub version: u32,
    /// Expected value of the register `emission`, a hash of the Verilog.
    pub emission: u32,
    /// Largest number of columns of a frame.
    pub columns: u32,
    /// Scale pairs, 1 to 3.
    pub pairs: u32,
    /// Features per scale pair and frame at which automatic thresholds settle.
    pub target: u32,
    /// Byte address and value of each filter coefficient.
    pub coefficients: Cow<'static, [(u32, u32)]>,
}

impl Default for Fpga {
    /// The FPGA image of the Verilog that this program was built with.
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
    /// Columns, 64 to [`Fpga::columns`].
    pub width: u16,
    /// Rows, 64 to 2048.
    pub height: u16,
}

impl Size {
    /// Checks columns and rows against the limits of the hardware.
    ///
    /// # Errors
    /// If either is out of range.
    pub fn new(fpga: &Fpga, width: u32, height: u32) -> Result<Self, HardwareError> {
        if !(64..=fpga.columns).contains(&width) || !(64..=2048).contains(&height) {
            return Err(HardwareError::Size { width, height, columns: fpga.columns });
        }
        Ok(Self { width: width as u16, height: height as u16 })
    }
}

/// The reason why the FPGA cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum HardwareError {
    /// The register block does not contain this register.
    #[error("the register block has no address 0x{address:02x} ({name}); read all registers at start")]
    Missing {
        /// Name of the register.
        name: &'static str,
        /// Byte address of the register.
        address: u32,
    },
    /// A read-only register differs from the Verilog that this program was built with.
    #[error("register {name} reads 0x{read:08x}, not 0x{built:08x}: {advice}")]
    Different {
        /// Name of the register.
        name: &'static str,
        /// Value in the FPGA.
        read: u32,
        /// Value that this program was built with.
        built: u32,
        /// Remedy for the user.
        advice: &'static str,
    },
    /// The frame size is outside the limits of the hardware.
    #[error("a frame of {width} x {height} pixels; the hardware takes 64 x 64 to {columns} x 2048")]
    Size {
        /// Columns of the frame.
        width: u32,
        /// Rows of the frame.
        height: u32,
        /// Largest number of columns.
        columns: u32,
    },
}

/// Checks that the registers belong to the expected FPGA image. `read` is called with name and byte address of each
/// register.
///
/// # Errors
/// If identification, version or emission hash differ or cannot be read.
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

/// Checks that a register block belongs to the expected FPGA image, and returns the frame size set in it.
///
/// # Errors
/// If identification, version, emission hash or size are missing or not as expected.
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
