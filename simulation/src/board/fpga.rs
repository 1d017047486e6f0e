//! The Verilated top with a camera at its pixel port and a DMA behind its feature port, one clock for all of them.

use std::collections::VecDeque;

use hoverlock_fixed_point::model::record::record_words;
use hoverlock_harness::model::{InstanceOptions, Model};
use hoverlock_reference::image::plane::Plane;

use super::dma::Dma;
use crate::{Ports, SimulationError, Simulator, bench::RESET_CYCLES};

/// Clock cycles from the last pixel of a frame to the first of the next, beside 100 lines: long enough for the frame
/// to leave the pipeline and for its packet to reach the memory, so that automatic thresholds follow the frame before.
/// A camera of 15 frames a second leaves more: 58.8 of 66.7 ms at 100 MHz.
const GAP: usize = 40_000;

/// The camera: frames one after the other, as they are given.
struct Camera {
    frames: VecDeque<Plane<u16>>,
    pixel: usize,
    gap: usize,
}

impl Camera {
    /// The beat on offer.
    fn offer(&self) -> Option<(u16, bool, bool)> {
        let pixels = self.frames.front().filter(|_| self.gap == 0)?.as_slice();
        Some((pixels[self.pixel], self.pixel == 0, self.pixel + 1 == pixels.len()))
    }

    /// A clock edge; `accepted` says that the beat on offer was taken.
    fn clock(&mut self, accepted: bool) {
        self.gap = self.gap.saturating_sub(1);
        if !accepted {
            return;
        }
        self.pixel += 1;
        let ended = self.frames.front().is_some_and(|frame| self.pixel == frame.as_slice().len());
        if ended && let Some(sent) = self.frames.pop_front() {
            (self.pixel, self.gap) = (0, GAP + 100 * sent.width());
        }
    }
}

/// The FPGA and what it is wired to.
pub struct Fpga {
    model: Model,
    ports: Ports,
    camera: Camera,
    /// The DMA of the features.
    pub dma: Dma,
    /// Clock cycles since the reset.
    pub cycles: u64,
}

impl Fpga {
    /// After its reset, with a camera that sends what it is given once it is switched on.
    pub fn new(simulator: &Simulator, memory: usize) -> Result<Self, SimulationError> {
        let options = InstanceOptions { seed: 1, plusargs: simulator.plusargs().to_vec() };
        let model = simulator.library().instance_with(&options)?;
        let ports = Ports::find(&model)?;
        let camera = Camera { frames: VecDeque::new(), pixel: 0, gap: usize::MAX };
        let mut fpga = Self {
            model,
            ports,
            camera,
            dma: Dma::new(4 * record_words(simulator.design().pairs()), memory),
            cycles: 0,
        };
        fpga.set_reset(true);
        for _ in 0..RESET_CYCLES {
            fpga.clock()?;
        }
        fpga.set_reset(false);
        fpga.clock()?;
        fpga.cycles = 0;
        Ok(fpga)
    }

    fn set_reset(&mut self, reset: bool) {
        // SAFETY: the model lives in the same structure and never leaves this thread.
        unsafe { self.ports.reset.set(u8::from(reset)) };
    }

    /// Switches the camera on.
    pub fn expose(&mut self) {
        self.camera.gap = 0;
    }

    /// Gives the camera a frame to send after those it has.
    pub fn send(&mut self, frame: Plane<u16>) {
        self.camera.frames.push_back(frame);
    }

    /// The interrupt line.
    pub fn interrupt(&self) -> bool {
        // SAFETY: the model lives in the same structure and never leaves this thread.
        unsafe { self.ports.irq.get() == 1 }
    }

    /// One clock cycle of everything.
    pub fn clock(&mut self) -> Result<(), SimulationError> {
        let offered = self.camera.offer();
        let taking = self.dma.ready();
        let ports = &self.ports;
        // SAFETY: the model lives in the same structure and never leaves this thread; the values fit the signals.
        unsafe {
            ports.valid.set(u8::from(offered.is_some()));
            if let Some((data, first, last)) = offered {
                ports.data.set(data.into());
                ports.first.set(u8::from(first));
                ports.last.set(u8::from(last));
            }
            ports.feature_ready.set(u8::from(taking));
            ports.clock.set(0);
        }
        self.model.eval()?;
        // SAFETY: as above.
        let (accepted, record, last) = unsafe {
            (
                offered.is_some() && ports.ready.get() == 1,
                taking && ports.feature_valid.get() == 1,
                ports.feature_last.get() == 1,
            )
        };
        let record = record.then(|| {
            let words = self.model.get_words(self.ports.feature_data);
            (std::array::from_fn(|i| words.get(i).copied().unwrap_or_default()), last)
        });
        // SAFETY: as above.
        unsafe { self.ports.clock.set(1) };
        self.model.eval()?;
        self.camera.clock(accepted);
        self.dma.clock(record);
        self.cycles += 1;
        Ok(())
    }

    /// A register write, by byte address.
    pub fn write(&mut self, address: u32, value: u32) -> Result<(), SimulationError> {
        // SAFETY: as above; the address has six bits.
        unsafe {
            self.ports.csr_address.set((address >> 2 & 0x3f) as u8);
            self.ports.csr_writedata.set(value);
            self.ports.csr_write.set(1);
        }
        self.clock()?;
        // SAFETY: as above.
        unsafe { self.ports.csr_write.set(0) };
        Ok(())
    }

    /// A register read, by byte address: the data comes one cycle after `csr_read`.
    pub fn read(&mut self, address: u32) -> Result<u32, SimulationError> {
        // SAFETY: as above; the address has six bits.
        unsafe {
            self.ports.csr_address.set((address >> 2 & 0x3f) as u8);
            self.ports.csr_read.set(1);
        }
        self.clock()?;
        // SAFETY: as above.
        unsafe {
            self.ports.csr_read.set(0);
            Ok(self.ports.csr_readdata.get())
        }
    }
}
