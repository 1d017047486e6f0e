//! What the CPU does, in its order, but for the registers' set-up, which belongs to the flight program.
//!
//! **At start.** Give the DMA the buffers of the ring. The flight program sets the registers up, through a
//! [`RegisterPort`]. Read every register, for the program to check. Then the camera may send.
//!
//! **For each frame.** The interrupt. Read `status` and write the same bits back, so that a frame that ends from now on
//! raises the interrupt again. Read `frames`: so many packets are due since the start; the interrupt comes when the
//! trailer enters the FIFO, so the DMA may still be writing, and several frames may share one interrupt. For each
//! packet that is due, wait for the DMA's response; only then read the buffer, copy it, and give the descriptor back.

use std::collections::VecDeque;

use hoverlock_reference::image::plane::Plane;

use super::dma::Descriptor;
use super::fpga::Fpga;
use crate::{SimulationError, Simulator};
use hoverlock_rtl::registers::registers;

/// Byte addresses and masks, as software has them.
#[path = "../../../rtl/registers/hoverlock_registers.rs"]
#[allow(dead_code)] // the driver uses a part of the map
mod map;

/// Buffers in the ring.
const BUFFERS: usize = 2;

/// Bytes of a buffer: 2047 features of 32 bytes and the trailer.
const BUFFER: usize = 64 << 10;

/// Clock cycles of one register access over the bridge, beside the access itself.
const BRIDGE: usize = 20;

/// Clock cycles without an interrupt, beside those of a frame, after which the hardware is taken to hang.
const PATIENCE: u64 = 1_000_000;

/// A frame as the CPU finds it in memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Packet {
    /// The records, the trailer last, 32 or 40 bytes each.
    pub bytes: Vec<u8>,
    /// Clock cycle at which the CPU had copied it.
    pub cycle: u64,
}

/// The registers as the CPU reaches them, over the bridge.
pub struct RegisterPort<'f>(&'f mut Fpga);

impl RegisterPort<'_> {
    /// The register at a byte address.
    ///
    /// # Errors
    /// Where the model fails.
    pub fn read(&mut self, address: u32) -> Result<u32, SimulationError> {
        wait(self.0, BRIDGE)?;
        self.0.read(address)
    }

    /// Writes the register at a byte address.
    ///
    /// # Errors
    /// Where the model fails.
    pub fn write(&mut self, address: u32, value: u32) -> Result<(), SimulationError> {
        wait(self.0, BRIDGE)?;
        self.0.write(address, value)
    }
}

/// The CPU's side of the FPGA.
pub struct Driver {
    fpga: Fpga,
    /// Clock cycles from an interrupt to the first access of the CPU.
    latency: u64,
    /// Registers at start: byte address and value.
    block: Vec<(u32, u32)>,
    /// The descriptors that the DMA has, the oldest first.
    ring: VecDeque<Descriptor>,
    /// Frames given to the camera.
    sent: usize,
    patience: u64,
    /// Packets copied, and frames that the hardware has finished.
    copied: usize,
    finished: usize,
    /// Status bits seen at interrupts.
    status: u32,
}

impl Driver {
    /// Starts the hardware. `set_up` commits the size of the frames and the thresholds, and enables frames and their
    /// interrupt. The CPU's first access comes `latency` clock cycles after an interrupt.
    ///
    /// # Errors
    /// Where the bench does not fit the model, or `set_up` fails.
    pub fn start<E: From<SimulationError>>(
        simulator: &Simulator,
        latency: u64,
        set_up: impl FnOnce(&mut RegisterPort<'_>) -> Result<(), E>,
    ) -> Result<Self, E> {
        let mut fpga = Fpga::new(simulator, BUFFERS * BUFFER)?;
        let ring: VecDeque<_> = (0..BUFFERS).map(|i| Descriptor { offset: i * BUFFER, bytes: BUFFER }).collect();
        ring.iter().for_each(|descriptor| fpga.dma.give(*descriptor));
        let mut port = RegisterPort(&mut fpga);
        set_up(&mut port)?;
        let map = registers(simulator.design()).map_err(SimulationError::from)?;
        let block = map.iter().map(|register| Ok((register.offset, port.read(register.offset)?)));
        let block = block.collect::<Result<Vec<_>, SimulationError>>()?;
        fpga.expose();
        let patience = latency + PATIENCE;
        Ok(Self { fpga, latency, block, ring, sent: 0, patience, copied: 0, finished: 0, status: 0 })
    }

    /// Gives the camera a frame, which it sends after those it has. All are of the size that was set up.
    pub fn send(&mut self, frame: Plane<u16>) {
        self.patience = self.latency + PATIENCE + 4 * frame.as_slice().len() as u64;
        self.sent += 1;
        self.fpga.send(frame);
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

    /// The packet of the next frame; nothing where all that were sent have come.
    ///
    /// # Errors
    /// Where the hardware hangs.
    pub fn packet(&mut self) -> Result<Option<Packet>, SimulationError> {
        if self.copied == self.sent {
            return Ok(None);
        }
        while self.finished == self.copied {
            self.until(|fpga| fpga.interrupt())?;
            wait(&mut self.fpga, self.latency as usize)?;
            let status = RegisterPort(&mut self.fpga).read(map::STATUS)?;
            RegisterPort(&mut self.fpga).write(map::STATUS, status)?;
            self.status |= status;
            self.finished = RegisterPort(&mut self.fpga).read(map::FRAMES)? as usize;
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
    fn until(&mut self, mut so: impl FnMut(&mut Fpga) -> bool) -> Result<(), SimulationError> {
        let from = self.fpga.cycles;
        while !so(&mut self.fpga) {
            self.fpga.clock()?;
            if self.fpga.cycles - from > self.patience {
                return Err(SimulationError::Hangs { frame: self.copied, cycles: self.patience });
            }
        }
        Ok(())
    }
}

fn wait(fpga: &mut Fpga, cycles: usize) -> Result<(), SimulationError> {
    (0..cycles).try_for_each(|_| fpga.clock())
}
