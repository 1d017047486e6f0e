//! Registers of a device by byte address: the port through which the CPU reaches the FPGA.

use memmap2::{MmapOptions, MmapRaw};
use std::fs::OpenOptions;
use std::io;
use std::path::{Path, PathBuf};
use std::ptr;

/// Bytes of the register block: the hardware decodes six bits of the word address.
pub const SPAN: u32 = 0x100;

/// 32-bit registers by byte address.
pub trait Bus {
    /// Why an access fails.
    type Error: std::error::Error;

    /// The value of a register.
    ///
    /// # Errors
    /// Where the access fails.
    fn read(&mut self, address: u32) -> Result<u32, Self::Error>;

    /// Writes a register.
    ///
    /// # Errors
    /// Where the access fails.
    fn write(&mut self, address: u32, value: u32) -> Result<(), Self::Error>;
}

/// Why a device cannot be mapped, or an access to it is refused.
#[derive(Debug, thiserror::Error)]
pub enum BusError {
    /// The device cannot be opened.
    #[error("{}: cannot open the registers: {source}", path.display())]
    Open {
        /// The device.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The device cannot be mapped.
    #[error("{}: cannot map {SPAN} bytes at offset 0x{offset:x}: {source}", path.display())]
    Map {
        /// The device.
        path: PathBuf,
        /// Byte offset in it.
        offset: u64,
        /// Why.
        source: io::Error,
    },
    /// A regular file ends before the block does.
    #[error("{}: {bytes} bytes, too few for {SPAN} bytes of registers at offset 0x{offset:x}", path.display())]
    Short {
        /// The file.
        path: PathBuf,
        /// Byte offset in it.
        offset: u64,
        /// Its length.
        bytes: u64,
    },
    /// The block does not begin at a multiple of four bytes.
    #[error("{}: offset 0x{offset:x} of the registers is no multiple of 4", path.display())]
    Offset {
        /// The device.
        path: PathBuf,
        /// Byte offset in it.
        offset: u64,
    },
    /// No register has this address.
    #[error("0x{0:x} is no register address: a multiple of 4 below 0x{SPAN:x}")]
    Address(u32),
}

/// A register block mapped from a device: `/dev/uioN`, or `/dev/mem` at the block's physical address.
///
/// The kernel maps addresses that are no RAM uncached and in order, so an access here is one access on the bus. A
/// regular file may be mapped too; it remembers what is written and does nothing.
#[derive(Debug)]
pub struct Mapped(MmapRaw);

impl Mapped {
    /// The block at byte `offset` of a device.
    ///
    /// # Errors
    /// Where the device cannot be opened for reading and writing or cannot be mapped, a file is too short, or the
    /// offset is no multiple of 4.
    pub fn open(device: &Path, offset: u64) -> Result<Self, BusError> {
        let path = || device.to_owned();
        if !offset.is_multiple_of(4) {
            return Err(BusError::Offset { path: path(), offset });
        }
        let opened = OpenOptions::new().read(true).write(true).open(device);
        let file = opened.map_err(|source| BusError::Open { path: path(), source })?;
        let about = file.metadata().map_err(|source| BusError::Open { path: path(), source })?;
        // A device tells no length. An access beyond the end of a file would end the program by a signal.
        let end = offset.saturating_add(SPAN.into());
        if about.is_file() && about.len() < end {
            return Err(BusError::Short { path: path(), offset, bytes: about.len() });
        }
        let mapped = MmapOptions::new().offset(offset).len(SPAN as usize).map_raw(&file);
        mapped.map(Self).map_err(|source| BusError::Map { path: path(), offset, source })
    }

    fn register(&self, address: u32) -> Result<*mut u32, BusError> {
        if address >= SPAN || !address.is_multiple_of(4) {
            return Err(BusError::Address(address));
        }
        Ok(self.0.as_mut_ptr().wrapping_add(address as usize).cast())
    }
}

impl Bus for Mapped {
    type Error = BusError;

    fn read(&mut self, address: u32) -> Result<u32, BusError> {
        let register = self.register(address)?;
        // SAFETY: the four bytes lie in the mapping, which lives as long as `self`, and are aligned: pages, offset and
        // address are multiples of 4. No reference to the mapping is ever made.
        Ok(unsafe { ptr::read_volatile(register) })
    }

    fn write(&mut self, address: u32, value: u32) -> Result<(), BusError> {
        let register = self.register(address)?;
        // SAFETY: as above; the mapping is writable.
        unsafe { ptr::write_volatile(register, value) };
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mapped_file_holds_what_is_written_at_its_offset() {
        let path = std::env::temp_dir().join(format!("hoverlock-bus-{}", std::process::id()));
        // Beyond the first page, and not at the beginning of one.
        let offset = 8192 + 0x40;
        std::fs::write(&path, vec![0; offset + SPAN as usize]).unwrap();
        let mut bus = Mapped::open(&path, offset as u64).unwrap();
        for (address, value) in [(0, 0x0403_0201), (SPAN - 4, 0xdead_beef)] {
            bus.write(address, value).unwrap();
            assert_eq!(bus.read(address).unwrap(), value);
        }
        for address in [2, SPAN, u32::MAX - 3] {
            assert!(matches!(bus.read(address), Err(BusError::Address(a)) if a == address));
            assert!(matches!(bus.write(address, 1), Err(BusError::Address(a)) if a == address));
        }
        drop(bus);
        let bytes = std::fs::read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(bytes[offset..offset + 4], [1, 2, 3, 4]);
        assert_eq!(bytes[offset + SPAN as usize - 4..], 0xdead_beef_u32.to_le_bytes());
        assert_eq!(bytes.iter().filter(|byte| **byte != 0).count(), 8);
    }
}
