//! What the CPU does, in its order, but for the registers' set-up, which belongs to the flight program.
//!
//! **At start.** Give the DMA the buffers of the ring. The flight program sets the registers up, through a
//! [`RegisterPort`]. Read every register, for the program to check. Then the camera may send.
//!
//! **For each frame.** The interrupt. Read `status` and write the same bits back, so that a frame that ends from now on
//! raises the interrupt again. Read `frames`, the number of packets due since the start. The interrupt comes when the
//! trailer enters the FIFO, so the DMA may still be writing, and several frames may share one interrupt. For each
//! packet that is due, wait for the DMA's response; only then read the buffer, copy it, and give the descriptor back.

use std::collections::VecDeque;

use hoverlock_harness::{Error, SimError, Time};
use hoverlock_reference::image::plane::Plane;
use hoverlock_registers::kt27 as map;
use hoverlock_registers::record::BUFFER_BYTES;
use hoverlock_rtl::registers::registers;

use super::dma::Descriptor;
use super::fpga::Fpga;
use crate::top::HALF_CYCLE;
use crate::{SimulationError, Simulator, Top};

/// Buffers in the ring.
const BUFFERS: usize = 2;

/// Clock cycles of one register access over the bridge, beside the access itself.
const BRIDGE_CYCLES: u64 = 20;

/// Clock cycles without an interrupt, beside those of a frame, after which the hardware is considered stuck.
const TIMEOUT_CYCLES: u64 = 1_000_000;

/// A frame as the CPU finds it in memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Packet {
    /// The records, the trailer last, 32 or 40 bytes each.
    pub bytes: Vec<u8>,
}

/// The registers as the CPU reaches them, over the bridge.
pub struct RegisterPort<'f>(&'f mut Fpga);

impl RegisterPort<'_> {
    /// Reads the register at a byte address.
    ///
    /// # Errors
    /// If the model fails.
    pub fn read(&mut self, address: u32) -> Result<u32, SimulationError> {
        // The data come in the cycle after the request, which is one of the bridge's.
        Ok(self.0.run(async |top| {
            top.clock.cycles(BRIDGE_CYCLES - 1).await;
            top.read(address).await
        })?)
    }

    /// Writes the register at a byte address.
    ///
    /// # Errors
    /// If the model fails.
    pub fn write(&mut self, address: u32, value: u32) -> Result<(), SimulationError> {
        Ok(self.0.run(async |top| {
            top.clock.cycles(BRIDGE_CYCLES).await;
            top.write(address, value).await
        })?)
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
    /// Clock cycles without an interrupt or a response, after which the hardware is considered stuck.
    timeout: u64,
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
    /// If the bench does not fit the model, or `set_up` fails.
    pub fn start<E: From<SimulationError>>(
        simulator: &Simulator,
        latency: u64,
        set_up: impl FnOnce(&mut RegisterPort<'_>) -> Result<(), E>,
    ) -> Result<Self, E> {
        let mut fpga = Fpga::new(simulator, BUFFERS * BUFFER_BYTES)?;
        let descriptor = |i: usize| Descriptor { offset: i * BUFFER_BYTES, bytes: BUFFER_BYTES };
        let ring: VecDeque<_> = (0..BUFFERS).map(descriptor).collect();
        ring.iter().for_each(|descriptor| fpga.give(*descriptor));
        let mut port = RegisterPort(&mut fpga);
        set_up(&mut port)?;
        let map = registers(simulator.design()).map_err(SimulationError::from)?;
        let block = map.iter().map(|register| Ok((register.offset, port.read(register.offset)?)));
        let block = block.collect::<Result<Vec<_>, SimulationError>>()?;
        fpga.expose();
        let timeout = latency + TIMEOUT_CYCLES;
        Ok(Self { fpga, latency, block, ring, sent: 0, timeout, copied: 0, finished: 0, status: 0 })
    }

    /// Gives the camera a frame, which it sends after those it has. All are of the size that was set up.
    ///
    /// # Errors
    /// If the frame has no pixels, or one that does not fit the port.
    pub fn send(&mut self, frame: &Plane<u16>) -> Result<(), SimulationError> {
        self.timeout = self.latency + TIMEOUT_CYCLES + 4 * frame.as_slice().len() as u64;
        self.sent += 1;
        Ok(self.fpga.send(frame)?)
    }

    /// Returns all registers as they were read before the first frame: byte address and value.
    pub fn registers(&self) -> &[(u32, u32)] {
        &self.block
    }

    /// Returns the clock cycles since the reset.
    pub fn cycles(&self) -> u64 {
        self.fpga.cycles()
    }

    /// Returns the status bits that were set at any interrupt, see `registers/REGISTERS.md`.
    pub fn status(&self) -> u32 {
        self.status
    }

    /// Returns the packet of the next frame; `None` if all that were sent have come.
    ///
    /// # Errors
    /// If the hardware is stuck.
    pub fn packet(&mut self) -> Result<Option<Packet>, SimulationError> {
        if self.copied == self.sent {
            return Ok(None);
        }
        while self.finished == self.copied {
            self.interrupt()?;
            let mut port = RegisterPort(&mut self.fpga);
            let status = port.read(map::STATUS)?;
            port.write(map::STATUS, status)?;
            self.status |= status;
            self.finished = port.read(map::FRAMES)? as usize;
        }
        let mut bytes = Vec::new();
        loop {
            let response = match self.fpga.answer() {
                Ok(response) => response,
                Err(answered) => {
                    self.wait(async |_| answered.wait().await)?;
                    continue;
                }
            };
            let Some(descriptor) = self.ring.pop_front() else { continue };
            self.fpga.copy(descriptor, response.bytes, &mut bytes);
            self.fpga.give(descriptor);
            self.ring.push_back(descriptor);
            if response.ended {
                break;
            }
        }
        self.copied += 1;
        Ok(Some(Packet { bytes }))
    }

    /// Waits for the interrupt, and for the CPU to answer it.
    fn interrupt(&mut self) -> Result<(), SimulationError> {
        let latency = self.latency;
        self.wait(async |top| {
            if !top.irq.is_high() {
                top.irq.rising_edge().await;
            }
            if latency > 0 {
                top.clock.cycles(latency).await;
            }
        })
    }

    /// Waits for something, but no longer than the timeout.
    fn wait(&mut self, until: impl AsyncFnOnce(&Top)) -> Result<(), SimulationError> {
        let limit = Time::fs(2 * HALF_CYCLE.as_fs() * (self.timeout + self.latency));
        let waited = self.fpga.run(async |top| Ok(top.dut.with_timeout(limit, until(top)).await?));
        waited.map_err(|error| match error {
            Error::Sim(SimError::Timeout { .. }) => SimulationError::Hangs { frame: self.copied, cycles: self.timeout },
            other => other.into(),
        })
    }
}
