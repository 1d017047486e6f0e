//! The Verilated top with a camera at its pixel port and a DMA behind its feature port, one clock for all of them.

use std::cell::RefCell;
use std::rc::Rc;

use hoverlock_harness::Error;
use hoverlock_harness::bus::stream::{Frame, Rules};
use hoverlock_harness::bus::{Pause, Switch};
use hoverlock_harness::sim::{Dut, Edge, Event, Sim};
use hoverlock_reference::image::plane::Plane;
use hoverlock_registers::record::record_words;

use super::dma::{Descriptor, Dma, Response};
use crate::top::{HALF_CYCLE, RESET_CYCLES};
use crate::{SimulationError, Simulator, Top, simulation};

/// Clock cycles from the last pixel of a frame to the first of the next, beside 100 lines: long enough for the frame
/// to leave the pipeline and for its packet to reach the memory, so that automatic thresholds follow the frame before.
/// A camera of 15 frames a second leaves more: 58.8 of 66.7 ms at 100 MHz.
const FRAME_GAP: u64 = 40_000;

/// Lines in which the pipeline drains after the last pixel of a frame, and some to spare.
const DRAIN_LINES: u64 = 100;

/// The pauses of the camera between its frames.
struct Camera {
    /// Cycles until the next frame may begin; no frame begins while the camera is off.
    gap: Option<u64>,
    /// The gap after each frame.
    gap_after_frame: u64,
    pause: Switch,
}

impl Camera {
    /// A clock edge; `ended` says that it takes the last pixel of a frame.
    fn clock(&mut self, ended: bool) {
        let left = self.gap.map(|gap| gap.saturating_sub(1));
        self.gap = if ended { Some(self.gap_after_frame) } else { left };
        self.pause.set(self.gap != Some(0));
    }
}

/// The DMA with the event of its responses.
struct DmaPort {
    dma: Dma,
    answered: Event,
    pause: Switch,
}

impl DmaPort {
    fn clock(&mut self, record: Option<(crate::records::Words, bool)>) {
        self.dma.clock(record);
        if self.dma.has_answer() {
            self.answered.set();
        }
        self.pause.set(!self.dma.ready());
    }
}

/// The FPGA and what it is wired to.
pub struct Fpga {
    sim: Sim,
    pub top: Top,
    camera: Rc<RefCell<Camera>>,
    dma: Rc<RefCell<DmaPort>>,
}

impl Fpga {
    /// After its reset, with a camera that sends what it is given once it is switched on, and a DMA with `memory`
    /// bytes.
    pub fn new(simulator: &Simulator, memory: usize) -> Result<Self, SimulationError> {
        let sim = simulation(simulator, 1)?;
        let dut = sim.dut();
        let camera = Camera { gap: None, gap_after_frame: 0, pause: Switch::default() };
        let camera = Rc::new(RefCell::new(camera));
        let dma = Dma::new(4 * record_words(simulator.design().pairs()), memory);
        let dma = DmaPort { dma, answered: dut.event("response of the DMA"), pause: Switch::default() };
        let dma = Rc::new(RefCell::new(dma));
        connect(&dut, &camera, &dma)?;
        let top = Top::new(&dut, simulator.design(), Rules::Strict)?;
        top.video.set_pause(Pause::while_on(&camera.borrow().pause));
        top.features.set_pause(Pause::while_on(&dma.borrow().pause));
        let mut fpga = Self { sim, top, camera, dma };
        fpga.run(async |top| {
            // The sink leaves its reset when the camera is switched on.
            top.feature_reset.set(true);
            top.reset.set(1)?;
            top.clock.cycles(RESET_CYCLES).await;
            Ok(top.reset.set(0)?)
        })?;
        Ok(fpga)
    }

    /// Runs what the CPU does.
    pub fn run<T>(&mut self, cpu: impl AsyncFnOnce(&Top) -> Result<T, Error>) -> Result<T, Error> {
        let top = &self.top;
        self.sim.run(async { cpu(top).await })
    }

    /// Switches the camera on.
    pub fn expose(&mut self) {
        self.camera.borrow_mut().gap = Some(0);
        self.top.feature_reset.set(false);
    }

    /// Gives the camera a frame to send after those it has.
    pub fn send(&mut self, frame: &Plane<u16>) -> Result<(), Error> {
        self.camera.borrow_mut().gap_after_frame = FRAME_GAP + DRAIN_LINES * frame.width() as u64;
        self.top.video.send(&Frame::new(frame.as_slice()))
    }

    /// Gives the DMA a descriptor.
    pub fn give(&mut self, descriptor: Descriptor) {
        self.dma.borrow_mut().dma.give(descriptor);
    }

    /// Takes the oldest response of the DMA. If there is none, the event is set when one comes.
    pub fn answer(&mut self) -> Result<Response, Event> {
        let mut port = self.dma.borrow_mut();
        port.dma.answer().ok_or_else(|| {
            port.answered.clear();
            port.answered.clone()
        })
    }

    /// Appends the first `bytes` bytes of a buffer to `to`, and drops the packets that the sink has recorded.
    pub fn copy(&mut self, descriptor: Descriptor, bytes: usize, to: &mut Vec<u8>) {
        to.extend_from_slice(self.dma.borrow().dma.read(descriptor, bytes));
        self.top.features.clear();
    }

    /// Clock cycles since the first after the reset.
    pub fn cycles(&self) -> u64 {
        let edges = (self.top.dut.now().as_fs() + HALF_CYCLE.as_fs()) / (2 * HALF_CYCLE.as_fs());
        edges.saturating_sub(RESET_CYCLES + 1)
    }
}

/// Connects camera and DMA to the streams, ahead of their source and sink.
fn connect(dut: &Dut, camera: &Rc<RefCell<Camera>>, dma: &Rc<RefCell<DmaPort>>) -> Result<(), Error> {
    let (camera, dma) = (camera.clone(), dma.clone());
    let (video_valid, video_ready) = (dut.signal("video_valid")?, dut.signal("video_ready")?);
    let video_last = dut.signal("video_endofpacket")?;
    let (valid, ready) = (dut.signal("feature_valid")?, dut.signal("feature_ready")?);
    let (last, data) = (dut.signal("feature_endofpacket")?, dut.wide("feature_data")?);
    dut.on_edge(&dut.signal("clock")?, Edge::Rising, move || {
        camera.borrow_mut().clock(video_valid.is_high() && video_ready.is_high() && video_last.is_high());
        let is_taken = valid.is_high() && ready.is_high();
        dma.borrow_mut().clock(is_taken.then(|| (data.get_array(), last.is_high())));
        Ok::<_, Error>(())
    });
    Ok(())
}
