//! What the CPU does, in its order. This module alone knows it.
//!
//! **At start.** Give the DMA the buffers of the ring. Write the set: `size`, `threshold`, `control.automatic`; then 1
//! to `commit`; then switch on `control.enable` and the interrupt. Read every register, for the program to check. Then
//! the camera may send.
//!
//! **For each frame.** The interrupt. Read `status` and write the same bits back, so that a frame that ends from now on
//! raises the interrupt again. Read `frames`: so many packets are due since the start; the interrupt comes when the
//! trailer enters the FIFO, so the DMA may still be writing, and several frames may share one interrupt. For each
//! packet that is due, wait for the DMA's response; only then read the buffer, copy it, and give the descriptor back.

use std::collections::VecDeque;

use hoverlock_reference::image::plane::Plane;

use super::super::{SimulationError, Simulator};
use super::dma::Descriptor;
use super::fpga::Fpga;
use crate::registers::registers;

/// Byte addresses and masks, as software has them.
#[path = "../../../registers/hoverlock_registers.rs"]
#[allow(dead_code)] // the driver uses a part of the map
mod map;

/// Buffers in the ring.
const BUFFERS: usize = 2;

/// Bytes of a buffer: 2047 features and the trailer.
const BUFFER: usize = 64 << 10;

/// Clock cycles of one register access over the bridge, beside the access itself.
const BRIDGE: usize = 20;

/// Clock cycles without an interrupt, beside those of a frame, after which the hardware is taken to hang.
const PATIENCE: u64 = 1_000_000;

/// How the hardware is set up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Thresholds of the first frame, 0.5 DN; the following frames' follow the counts.
    pub thresholds: [u32; 2],
    /// Clock cycles from an interrupt to the first access of the CPU.
    pub latency: u64,
}

/// A frame as the CPU finds it in memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Packet {
    /// The records, the trailer last, 32 bytes each.
    pub bytes: Vec<u8>,
    /// Clock cycle at which the CPU had copied it.
    pub cycle: u64,
}

/// The CPU's side of the FPGA.
pub struct Driver<'a> {
    fpga: Fpga<'a>,
    settings: Settings,
    /// Registers at start: byte address and value.
    block: Vec<(u32, u32)>,
    /// The descriptors that the DMA has, the oldest first.
    ring: VecDeque<Descriptor>,
    frames: usize,
    patience: u64,
    /// Packets copied, and frames that the hardware has finished.
    copied: usize,
    finished: usize,
    /// Status bits seen at interrupts.
    status: u32,
}

impl<'a> Driver<'a> {
    /// Starts the hardware; the camera sends `frames`, all of one size.
    ///
    /// # Errors
    /// Where the bench does not fit the model.
    pub fn start(simulator: &Simulator, frames: &'a [Plane<u16>], settings: Settings) -> Result<Self, SimulationError> {
        let mut fpga = Fpga::new(simulator, frames, BUFFERS * BUFFER)?;
        let mut block = Vec::new();
        let (width, height) = frames.first().map_or((0, 0), |frame| (frame.width(), frame.height()));
        let [fine, coarse] = settings.thresholds;
        let writes = [
            (map::SIZE, (height as u32) << map::SIZE_HEIGHT.trailing_zeros() | width as u32),
            (map::THRESHOLD, coarse << map::THRESHOLD_COARSE.trailing_zeros() | fine),
            (map::CONTROL, map::CONTROL_AUTOMATIC),
            (map::COMMIT, 1),
            (map::CONTROL, map::CONTROL_AUTOMATIC | map::CONTROL_ENABLE | map::CONTROL_INTERRUPT_FRAME),
        ];
        let ring: VecDeque<_> = (0..BUFFERS).map(|i| Descriptor { offset: i * BUFFER, bytes: BUFFER }).collect();
        ring.iter().for_each(|descriptor| fpga.dma.give(*descriptor));
        for (address, value) in writes {
            wait(&mut fpga, BRIDGE)?;
            fpga.write(address, value)?;
        }
        for register in registers()? {
            block.push((register.offset, fpga.read(register.offset)?));
        }
        fpga.expose();
        let patience = settings.latency + PATIENCE + 4 * (width * height) as u64;
        let frames = frames.len();
        Ok(Self { fpga, settings, block, ring, frames, patience, copied: 0, finished: 0, status: 0 })
    }

    /// All registers as they were read before the first frame: byte address and value.
    pub fn registers(&self) -> &[(u32, u32)] {
        &self.block
    }

    /// Clock cycles since the reset.
    pub fn cycles(&self) -> u64 {
        self.fpga.cycles
    }

    /// Status bits that were set at any interrupt, see `registers/REGISTERS.md`.
    pub fn status(&self) -> u32 {
        self.status
    }

    /// The packet of the next frame; nothing after the last.
    ///
    /// # Errors
    /// Where the hardware hangs.
    pub fn packet(&mut self) -> Result<Option<Packet>, SimulationError> {
        if self.copied == self.frames {
            return Ok(None);
        }
        while self.finished == self.copied {
            self.until(|fpga| fpga.interrupt())?;
            wait(&mut self.fpga, self.settings.latency as usize)?;
            let status = self.read(map::STATUS)?;
            self.write(map::STATUS, status)?;
            self.status |= status;
            self.finished = self.read(map::FRAMES)? as usize;
        }
        let mut bytes = Vec::new();
        loop {
            let mut response = None;
            self.until(|fpga| {
                response = fpga.dma.answer();
                response.is_some()
            })?;
            let (Some(response), Some(descriptor)) = (response, self.ring.pop_front()) else { continue };
            bytes.extend_from_slice(self.fpga.dma.read(descriptor, response.bytes));
            self.fpga.dma.give(descriptor);
            self.ring.push_back(descriptor);
            if response.ended {
                break;
            }
        }
        self.copied += 1;
        Ok(Some(Packet { bytes, cycle: self.fpga.cycles }))
    }

    /// Clocks until something is so.
    fn until(&mut self, mut so: impl FnMut(&mut Fpga<'a>) -> bool) -> Result<(), SimulationError> {
        let from = self.fpga.cycles;
        while !so(&mut self.fpga) {
            self.fpga.clock()?;
            if self.fpga.cycles - from > self.patience {
                return Err(SimulationError::Hangs { frame: self.copied, cycles: self.patience });
            }
        }
        Ok(())
    }

    fn read(&mut self, address: u32) -> Result<u32, SimulationError> {
        wait(&mut self.fpga, BRIDGE)?;
        self.fpga.read(address)
    }

    fn write(&mut self, address: u32, value: u32) -> Result<(), SimulationError> {
        wait(&mut self.fpga, BRIDGE)?;
        self.fpga.write(address, value)
    }
}

fn wait(fpga: &mut Fpga<'_>, cycles: usize) -> Result<(), SimulationError> {
    (0..cycles).try_for_each(|_| fpga.clock())
}
