//! The Verilated top with a camera at its pixel port and a DMA behind its feature port, one clock for all of them.

use hoverlock_harness::model::{InstanceOptions, Model, RawSignal, SignalId};
use hoverlock_reference::image::plane::Plane;

use super::super::{SimulationError, Simulator, bench::RESET_CYCLES};
use super::dma::Dma;

/// Clock cycles from the last pixel of a frame to the first of the next, beside 100 lines: long enough for the frame
/// to leave the pipeline and for its packet to reach the memory, so that automatic thresholds follow the frame before.
/// A camera of 15 frames a second leaves more: 58.8 of 66.7 ms at 100 MHz.
const GAP: usize = 40_000;

/// The camera: frames one after the other.
struct Camera<'a> {
    frames: &'a [Plane<u16>],
    frame: usize,
    pixel: usize,
    gap: usize,
}

impl Camera<'_> {
    /// The beat on offer.
    fn offer(&self) -> Option<(u16, bool, bool)> {
        let pixels = self.frames.get(self.frame).filter(|_| self.gap == 0)?.as_slice();
        Some((pixels[self.pixel], self.pixel == 0, self.pixel + 1 == pixels.len()))
    }

    /// A clock edge; `accepted` says that the beat on offer was taken.
    fn clock(&mut self, accepted: bool) {
        self.gap = self.gap.saturating_sub(1);
        if accepted {
            self.pixel += 1;
            if self.pixel == self.frames[self.frame].as_slice().len() {
                self.gap = GAP + 100 * self.frames[self.frame].width();
                (self.frame, self.pixel) = (self.frame + 1, 0);
            }
        }
    }
}

struct Pins {
    clock: RawSignal<u8>,
    valid: RawSignal<u8>,
    data: RawSignal<u16>,
    first: RawSignal<u8>,
    last: RawSignal<u8>,
    ready: RawSignal<u8>,
    feature_ready: RawSignal<u8>,
    feature_valid: RawSignal<u8>,
    feature_last: RawSignal<u8>,
    feature_data: SignalId,
    address: RawSignal<u8>,
    read: RawSignal<u8>,
    readdata: RawSignal<u32>,
    write: RawSignal<u8>,
    writedata: RawSignal<u32>,
    irq: RawSignal<u8>,
}

/// The FPGA and what it is wired to.
pub struct Fpga<'a> {
    model: Model,
    pins: Pins,
    camera: Camera<'a>,
    /// The DMA of the features.
    pub dma: Dma,
    /// Clock cycles since the reset.
    pub cycles: u64,
}

impl<'a> Fpga<'a> {
    /// After its reset, with a camera that sends `frames` once it is switched on.
    pub fn new(simulator: &Simulator, frames: &'a [Plane<u16>], memory: usize) -> Result<Self, SimulationError> {
        let options = InstanceOptions { seed: 1, plusargs: simulator.plusargs().to_vec() };
        let mut model = simulator.library().instance_with(&options)?;
        let reset = model.find("reset")?;
        let pins = Pins {
            clock: model.raw("clock")?,
            valid: model.raw("video_valid")?,
            data: model.raw("video_data")?,
            first: model.raw("video_startofpacket")?,
            last: model.raw("video_endofpacket")?,
            ready: model.raw("video_ready")?,
            feature_ready: model.raw("feature_ready")?,
            feature_valid: model.raw("feature_valid")?,
            feature_last: model.raw("feature_endofpacket")?,
            feature_data: model.find("feature_data")?,
            address: model.raw("csr_address")?,
            read: model.raw("csr_read")?,
            readdata: model.raw("csr_readdata")?,
            write: model.raw("csr_write")?,
            writedata: model.raw("csr_writedata")?,
            irq: model.raw("irq")?,
        };
        model.set(reset, 1)?;
        let camera = Camera { frames, frame: 0, pixel: 0, gap: usize::MAX };
        let mut fpga = Self { model, pins, camera, dma: Dma::new(memory), cycles: 0 };
        for _ in 0..RESET_CYCLES {
            fpga.clock()?;
        }
        fpga.model.set(reset, 0)?;
        fpga.clock()?;
        fpga.cycles = 0;
        Ok(fpga)
    }

    /// Switches the camera on.
    pub fn expose(&mut self) {
        self.camera.gap = 0;
    }

    /// The interrupt line.
    pub fn interrupt(&self) -> bool {
        // SAFETY: the model lives in the same structure and never leaves this thread.
        unsafe { self.pins.irq.get() == 1 }
    }

    /// One clock cycle of everything.
    pub fn clock(&mut self) -> Result<(), SimulationError> {
        let offered = self.camera.offer();
        let taking = self.dma.ready();
        let pins = &self.pins;
        // SAFETY: the model lives in the same structure and never leaves this thread; the values fit the signals.
        unsafe {
            pins.valid.set(u8::from(offered.is_some()));
            if let Some((data, first, last)) = offered {
                pins.data.set(data);
                pins.first.set(u8::from(first));
                pins.last.set(u8::from(last));
            }
            pins.feature_ready.set(u8::from(taking));
            pins.clock.set(0);
        }
        self.model.eval()?;
        // SAFETY: as above.
        let (accepted, record, last) = unsafe {
            (
                offered.is_some() && pins.ready.get() == 1,
                taking && pins.feature_valid.get() == 1,
                pins.feature_last.get() == 1,
            )
        };
        let record = record.then(|| {
            let words = self.model.get_words(self.pins.feature_data);
            (std::array::from_fn(|i| words[i]), last)
        });
        // SAFETY: as above.
        unsafe { self.pins.clock.set(1) };
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
            self.pins.address.set((address >> 2 & 0x3f) as u8);
            self.pins.writedata.set(value);
            self.pins.write.set(1);
        }
        self.clock()?;
        // SAFETY: as above.
        unsafe { self.pins.write.set(0) };
        Ok(())
    }

    /// A register read, by byte address: the data comes one cycle after `csr_read`.
    pub fn read(&mut self, address: u32) -> Result<u32, SimulationError> {
        // SAFETY: as above; the address has six bits.
        unsafe {
            self.pins.address.set((address >> 2 & 0x3f) as u8);
            self.pins.read.set(1);
        }
        self.clock()?;
        // SAFETY: as above.
        unsafe {
            self.pins.read.set(0);
            Ok(self.pins.readdata.get())
        }
    }
}
