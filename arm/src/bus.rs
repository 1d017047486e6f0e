//! The bus from the CPU to the registers of the FPGA, by byte address.

use memmap2::{MmapOptions, MmapRaw};
use std::fs::OpenOptions;
use std::io;
use std::path::{Path, PathBuf};
use std::ptr;

/// Size of the register block, bytes: the hardware decodes six bits of the word address.
const BLOCK_BYTES: u32 = 0x100;

/// A device with 32-bit registers by byte address.
pub trait Bus {
    /// The error of a failed access.
    type Error: std::error::Error;

    /// Reads a register.
    ///
    /// # Errors
    /// If the access fails.
    fn read(&mut self, address: u32) -> Result<u32, Self::Error>;

    /// Writes a register.
    ///
    /// # Errors
    /// If the access fails.
    fn write(&mut self, address: u32, value: u32) -> Result<(), Self::Error>;
}

/// The error of mapping a device or of an access to it.
#[derive(Debug, thiserror::Error)]
pub enum BusError {
    /// The device cannot be opened.
    #[error("{}: cannot open the registers: {source}", path.display())]
    Open {
        /// Path of the device.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The device cannot be mapped.
    #[error("{}: cannot map {BLOCK_BYTES} bytes at offset 0x{offset:x}: {source}", path.display())]
    Map {
        /// Path of the device.
        path: PathBuf,
        /// Byte offset of the block in the device.
        offset: u64,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A regular file ends before the end of the block.
    #[error("{}: {bytes} bytes, too few for {BLOCK_BYTES} bytes of registers at offset 0x{offset:x}", path.display())]
    Short {
        /// Path of the file.
        path: PathBuf,
        /// Byte offset of the block in the device.
        offset: u64,
        /// Length of the file.
        bytes: u64,
    },
    /// The offset of the block is not a multiple of four bytes.
    #[error("{}: offset 0x{offset:x} of the registers is not a multiple of 4", path.display())]
    Offset {
        /// Path of the device.
        path: PathBuf,
        /// Byte offset of the block in the device.
        offset: u64,
    },
    /// The address is outside the block or not a multiple of four.
    #[error("0x{0:x} is not a register address: a multiple of 4 below 0x{BLOCK_BYTES:x}")]
    Address(u32),
}

/// A register block mapped from a device: `/dev/uioN`, or `/dev/mem` at the block's physical address.
///
/// The kernel maps addresses outside RAM uncached and in order, so each access here is one access on the bus. A regular
/// file can be mapped for tests; it stores what is written and has no other effect.
#[derive(Debug)]
pub struct Mapped(MmapRaw);

impl Mapped {
    /// Maps the block at byte `offset` of a device.
    ///
    /// # Errors
    /// If the device cannot be opened for reading and writing or cannot be mapped, if a file is too short, or if the
    /// offset is not a multiple of 4.
    pub fn open(device: &Path, offset: u64) -> Result<Self, BusError> {
        let path = || device.to_owned();
        if !offset.is_multiple_of(4) {
            return Err(BusError::Offset { path: path(), offset });
        }
        let opened = OpenOptions::new().read(true).write(true).open(device);
        let file = opened.map_err(|source| BusError::Open { path: path(), source })?;
        let about = file.metadata().map_err(|source| BusError::Open { path: path(), source })?;
        // A device has no length. An access beyond the end of a file would end the program by a signal.
        let end = offset.saturating_add(BLOCK_BYTES.into());
        if about.is_file() && about.len() < end {
            return Err(BusError::Short { path: path(), offset, bytes: about.len() });
        }
        let mapped = MmapOptions::new().offset(offset).len(BLOCK_BYTES as usize).map_raw(&file);
        mapped.map(Self).map_err(|source| BusError::Map { path: path(), offset, source })
    }

    fn register(&self, address: u32) -> Result<*mut u32, BusError> {
        if address >= BLOCK_BYTES || !address.is_multiple_of(4) {
            return Err(BusError::Address(address));
        }
        Ok(self.0.as_mut_ptr().wrapping_add(address as usize).cast())
    }
}

impl Bus for Mapped {
    type Error = BusError;

    fn read(&mut self, address: u32) -> Result<u32, BusError> {
        let register = self.register(address)?;
        // SAFETY: the four bytes are in the mapping, which lives as long as `self`, and are aligned: pages, offset and
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
    fn a_mapped_file_stores_writes_at_its_offset() {
        let path = std::env::temp_dir().join(format!("hoverlock-bus-{}", std::process::id()));
        // Beyond the first page, and not at the beginning of one.
        let offset = 8192 + 0x40;
        std::fs::write(&path, vec![0; offset + BLOCK_BYTES as usize]).unwrap();
        let mut bus = Mapped::open(&path, offset as u64).unwrap();
        for (address, value) in [(0, 0x0403_0201), (BLOCK_BYTES - 4, 0xdead_beef)] {
            bus.write(address, value).unwrap();
            assert_eq!(bus.read(address).unwrap(), value);
        }
        for address in [2, BLOCK_BYTES, u32::MAX - 3] {
            assert!(matches!(bus.read(address), Err(BusError::Address(a)) if a == address));
            assert!(matches!(bus.write(address, 1), Err(BusError::Address(a)) if a == address));
        }
        drop(bus);
        let bytes = std::fs::read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(bytes[offset..offset + 4], [1, 2, 3, 4]);
        assert_eq!(bytes[offset + BLOCK_BYTES as usize - 4..], 0xdead_beef_u32.to_le_bytes());
        assert_eq!(bytes.iter().filter(|byte| **byte != 0).count(), 8);
    }
}
