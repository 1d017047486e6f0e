//! The navigator: messages in, one line per frame out.
//!
//! A frame needs two messages, its feature records and its telemetry; samples of the IMU precede them. The estimate is
//! that of the module `tracker`.
//!
//! **Faulty links.** A message that repeats one of the last `HISTORY_MESSAGES` is ignored. Telemetry belongs to the
//! frame with its number. A frame whose telemetry comes later waits for it until the next frame arrives, and then gets
//! no estimate. A register block means that the source has restarted: earlier telemetry and messages are discarded. The
//! reference is kept, as the ground has not moved.

use crate::arinc429::{self, Camera as Addressee, Control, WordError};
use crate::calibration::Calibration;
use crate::framing::RawMessage;
use crate::hardware::{self, Fpga, HardwareError, Size};
use crate::line::{Estimate, Line, Reason, Status};
use crate::message::{self, Command, Frame, Inertial, MessageError, Registers, Telemetry};
use crate::pixels::Pixels;
use crate::tracker::{Seen, Tracker};
use hoverlock_fixed_point::model::record::FeatureRecord;
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::motion::budget::{Budget, UNIT_INSTRUCTIONS};
use hoverlock_reference::motion::mark::{Part, mark};
use hoverlock_reference::motion::model::Pair;

/// Features of a frame that are used at most: those with the largest responses.
pub(crate) const MAX_FEATURES: usize = 1024;

/// Instructions of the Cortex-A9 that a frame may take.
pub const MAX_FRAME_INSTRUCTIONS: u64 = 25_000_000;

/// Work units that a frame may spend.
pub const WORK_UNITS: u64 = MAX_FRAME_INSTRUCTIONS / UNIT_INSTRUCTIONS;

/// Work units of a record: check, unpacking, and the choice of the strongest.
pub const RECORD_WORK: usize = 60;

/// Work units of a frame without its records, its prediction and its keyframes: parsing, views, line of output.
pub const LINE_WORK: usize = 8_000;

/// Messages, and telemetry of frames, that are kept to recognise repetitions and to match frames.
const HISTORY_MESSAGES: usize = 16;

/// Late telemetry is accepted if its sequence number is at most this much above that of the message before its frame.
const MAX_TELEMETRY_LAG: u32 = 4;

/// Field of view after [`Command::Wide`].
const WIDE_VIEW_DEGREES: f64 = 50.0;

/// Field of view after [`Command::Narrow`]. The camera reaches 5.4 degrees, but there a tilt of 5 degrees would leave
/// nothing of the reference in view.
const NARROW_VIEW_DEGREES: f64 = 10.0;

/// The counters that the program prints when it ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Frames, each with one line of output.
    pub frames: u64,
    /// Messages ignored because they repeat an earlier one.
    pub repeated: u64,
    /// Invalid messages other than frames.
    pub refused: u64,
}

/// How the caller of [`Navigator::take`] goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next {
    /// Pass the next message.
    Continue,
    /// The command to stop was received: end the program.
    Stop,
}

/// The estimator with its state between messages.
pub struct Navigator {
    fpga: Fpga,
    size: Option<Size>,
    capture: bool,
    renew: bool,
    calibration: Calibration,
    telemetry: [Option<Telemetry>; HISTORY_MESSAGES],
    telemetry_next: usize,
    seen: [Option<(u32, u32)>; HISTORY_MESSAGES],
    seen_next: usize,
    /// Sequence number and line of a frame that has no telemetry yet.
    waiting: Option<(u32, Line)>,
    zoom: Option<f64>,
    counts: Counts,
    tracker: Tracker,
    records: Vec<FeatureRecord>,
    /// The features of the present frame.
    current: Vec<Feature>,
    pixels: Option<Pixels>,
    work: u64,
}

impl Default for Navigator {
    fn default() -> Self {
        Self::with_work(WORK_UNITS)
    }
}

impl Navigator {
    /// Creates a navigator for an FPGA whose Verilog is not the one of this build.
    pub fn for_fpga(fpga: Fpga) -> Self {
        Self { fpga, ..Self::default() }
    }

    /// Creates a navigator that may spend `work` units on each frame; the default is [`WORK_UNITS`].
    pub fn with_work(work: u64) -> Self {
        Self {
            fpga: Fpga::default(),
            size: None,
            capture: false,
            renew: false,
            calibration: Calibration::default(),
            telemetry: [None; HISTORY_MESSAGES],
            telemetry_next: 0,
            seen: [None; HISTORY_MESSAGES],
            seen_next: 0,
            waiting: None,
            zoom: None,
            counts: Counts::default(),
            tracker: Tracker::with_capacity(MAX_FEATURES),
            records: Vec::with_capacity(crate::framing::MAX_PAYLOAD_BYTES / message::MIN_RECORD_BYTES),
            current: Vec::with_capacity(MAX_FEATURES),
            pixels: None,
            work,
        }
    }

    /// Returns the ARINC 429 word for the last command to zoom, once, and `None` until the next such command.
    ///
    /// # Errors
    /// If the field of view is outside the camera's range.
    pub fn camera_word(&mut self) -> Result<Option<u32>, WordError> {
        self.zoom.take().map(|degrees| arinc429::encode(Addressee::All, Control::Zoom(degrees))).transpose()
    }

    /// Returns the counters since the start.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Returns the inliers of the last estimate. Valid only if the last line has an estimate.
    pub fn inliers(&self) -> &[Pair] {
        self.tracker.inliers()
    }

    /// Processes a message. `out` is called with each line that it completes, at most two.
    ///
    /// # Errors
    /// If a register block shows that the FPGA is not the one this program was built for.
    pub fn take(&mut self, raw: &RawMessage<'_>, out: &mut impl FnMut(&Line)) -> Result<Next, HardwareError> {
        if raw.kind == message::REGISTERS {
            self.start(raw, out)?;
        }
        let this = Some((raw.sequence, raw.check));
        if self.seen.contains(&this) {
            self.counts.repeated += 1;
            return Ok(Next::Continue);
        }
        self.seen[self.seen_next] = this;
        self.seen_next = (self.seen_next + 1) % HISTORY_MESSAGES;
        let refused = match raw.kind {
            message::REGISTERS => Registers::parse(raw.payload).is_err(),
            message::FRAME => {
                self.frame(raw, out);
                false
            }
            message::TELEMETRY => self.telemetry(raw, out).is_err(),
            message::INERTIAL => match Inertial::parse(raw.payload) {
                Ok(inertial) => {
                    inertial.samples().for_each(|sample| self.tracker.take_sample(sample));
                    false
                }
                Err(_) => true,
            },
            message::CALIBRATION => self.calibrate(raw.payload).is_err(),
            // Before the registers their size is not known.
            message::PIXELS => self.pixels.as_mut().is_none_or(|pixels| pixels.take(raw.payload).is_err()),
            message::COMMAND => match Command::parse(raw.payload) {
                Ok(Command::Stop) => {
                    self.finish(out);
                    return Ok(Next::Stop);
                }
                Ok(command) => {
                    self.command(command);
                    false
                }
                Err(_) => true,
            },
            _ => true,
        };
        self.counts.refused += u64::from(refused);
        Ok(Next::Continue)
    }

    /// Takes the calibration of camera and IMU. With another one the reference is forgotten.
    fn calibrate(&mut self, payload: &[u8]) -> Result<(), MessageError> {
        let calibration = Calibration::parse(payload)?;
        if calibration != self.calibration {
            self.calibration = calibration;
            self.tracker.calibrate(&calibration);
        }
        Ok(())
    }

    /// Emits the line of a frame that still waits for its telemetry. Call it at the end of the stream.
    pub fn finish(&mut self, out: &mut impl FnMut(&Line)) {
        if let Some((_, line)) = self.waiting.take() {
            self.emit(Line { reason: Some(Reason::Telemetry), ..line }, out);
        }
    }

    fn emit(&mut self, line: Line, out: &mut impl FnMut(&Line)) {
        self.counts.frames += 1;
        out(&line);
    }

    fn start(&mut self, raw: &RawMessage<'_>, out: &mut impl FnMut(&Line)) -> Result<(), HardwareError> {
        let Ok(block) = Registers::parse(raw.payload) else { return Ok(()) };
        let size = hardware::check(&self.fpga, &block)?;
        self.finish(out);
        if self.size.is_some_and(|before| before != size) {
            self.tracker.clear();
        }
        self.size = Some(size);
        self.pixels = Some(Pixels::with_size(size.width.into(), size.height.into()));
        self.telemetry = [None; HISTORY_MESSAGES];
        self.seen = [None; HISTORY_MESSAGES];
        self.tracker.restart_clock();
        Ok(())
    }

    fn command(&mut self, command: Command) {
        match command {
            Command::Capture => self.capture = true,
            Command::Renew => self.renew = true,
            Command::Wide => self.zoom = Some(WIDE_VIEW_DEGREES),
            Command::Narrow => self.zoom = Some(NARROW_VIEW_DEGREES),
            Command::Stop => (),
        }
    }

    fn telemetry(&mut self, raw: &RawMessage<'_>, out: &mut impl FnMut(&Line)) -> Result<(), MessageError> {
        let telemetry = Telemetry::parse(raw.payload)?;
        // A restarted source repeats frame numbers; close sequence numbers show that both come from the same source.
        let belongs = |(sequence, line): &mut (u32, Line)| {
            line.frame == Some(telemetry.frame)
                && raw.sequence.wrapping_sub(sequence.wrapping_sub(1)) <= MAX_TELEMETRY_LAG
        };
        if let Some((_, line)) = self.waiting.take_if(belongs) {
            self.finish_frame(line, &telemetry, out);
        } else {
            // Telemetry with the same frame number is from before a restart.
            let same = |slot: &Option<Telemetry>| slot.is_some_and(|before| before.frame == telemetry.frame);
            let slot = self.telemetry.iter().position(same).unwrap_or_else(|| {
                self.telemetry_next = (self.telemetry_next + 1) % HISTORY_MESSAGES;
                self.telemetry_next
            });
            self.telemetry[slot] = Some(telemetry);
        }
        Ok(())
    }

    fn frame(&mut self, raw: &RawMessage<'_>, out: &mut impl FnMut(&Line)) {
        self.finish(out);
        let frame = match Frame::parse(raw.payload) {
            Ok(frame) => frame,
            Err(error) => return self.emit(Line { reason: Some(error.into()), ..Line::new(None) }, out),
        };
        let mut line = Line::new(Some(&frame.trailer));
        if let Err(reason) = self.unpack_features(&frame, &mut line) {
            return self.emit(Line { reason: Some(reason), ..line }, out);
        }
        let number = frame.trailer.frame;
        match self.telemetry.iter_mut().find_map(|slot| slot.take_if(|telemetry| telemetry.frame == number)) {
            Some(telemetry) => self.finish_frame(line, &telemetry, out),
            None => self.waiting = Some((raw.sequence, line)),
        }
    }

    /// Unpacks the features of a frame into `current`.
    fn unpack_features(&mut self, frame: &Frame<'_>, line: &mut Line) -> Result<(), Reason> {
        let size = self.size.ok_or(Reason::Registers)?;
        if frame.trailer.errors != 0 {
            return Err(Reason::Damaged(frame.trailer.errors));
        }
        let Self { records, current, .. } = self;
        records.clear();
        for (i, record) in frame.features().enumerate() {
            let record = record?;
            if record.x >= size.width || record.y >= size.height {
                return Err(Reason::Outside(i));
            }
            records.push(record);
        }
        if records.len() > MAX_FEATURES {
            line.dropped += records.len() - MAX_FEATURES;
            // Of equally strong ones the first in raster order is kept, so that the choice is the same everywhere.
            let place = |r: &FeatureRecord| (r.y, r.x, r.scale);
            records.select_nth_unstable_by_key(MAX_FEATURES, |r| (u16::MAX - r.response, place(r)));
            records.truncate(MAX_FEATURES);
            records.sort_unstable_by_key(place);
        }
        line.features = records.len();
        current.clear();
        current.extend(records.iter().map(Feature::from));
        Ok(())
    }

    /// Processes the frame whose features are in `current`, now that its telemetry is known.
    fn finish_frame(&mut self, line: Line, telemetry: &Telemetry, out: &mut impl FnMut(&Line)) {
        let mut line = Line { time_us: Some(telemetry.time_us), ..line };
        let mut budget = Budget::new(self.work);
        let records = line.features + line.dropped;
        line.reference = if self.capture { None } else { self.tracker.origin() };
        let outcome = if budget.spend(LINE_WORK + RECORD_WORK * records) {
            self.estimate(line.frame, telemetry, &mut budget)
        } else {
            Err(Reason::Work)
        };
        mark(Part::Frame);
        match outcome {
            Ok(Some(estimate)) => {
                line.reference = estimate.keyframe;
                line.estimate = Some(estimate);
                line.status = if budget.is_late() { Status::Late } else { Status::Estimate };
            }
            Ok(None) => line.status = Status::Reference,
            Err(reason) => line.reason = Some(reason),
        }
        line.work = budget.spent();
        self.emit(line, out);
    }

    /// Returns the estimate relative to the origin, or `None` if the frame was captured as the reference.
    fn estimate(
        &mut self,
        frame: Option<u32>,
        telemetry: &Telemetry,
        budget: &mut Budget,
    ) -> Result<Option<Estimate>, Reason> {
        let size = self.size.ok_or(Reason::Registers)?;
        let (camera, telemetry) = self.calibration.seen_by([size.width, size.height].map(usize::from), telemetry)?;
        let pixels = self.pixels.as_ref().zip(frame).and_then(|(pixels, number)| pixels.of_frame(number));
        let seen = Seen { frame, telemetry: &telemetry, camera, features: &self.current, pixels };
        if self.capture {
            self.tracker.capture(&seen, budget)?;
            (self.capture, self.renew) = (false, false);
            return Ok(None);
        }
        let estimate = self.tracker.estimate(&seen, &mut self.renew, budget)?;
        Ok(Some(self.calibration.of_sensor(estimate)))
    }
}
