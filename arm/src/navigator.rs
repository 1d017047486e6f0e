//! The navigator: messages in, one line per frame out.
//!
//! A frame needs two messages, its feature records and its telemetry. Then follow the gate from attitude, range and the
//! last displacement; the search of [`hoverlock_reference::motion::estimate`]; and the pose fit of
//! [`hoverlock_reference::motion::pose`].
//!
//! **The gate.** `H = G_c^-1 T(-t) G_r` predicts where a feature of the reference is now. `G` is the homography from
//! pixels to metres by the telemetry of each view, `t` the last displacement. The gate is used if that displacement is
//! at most `MAX_PREDICTION_AGE_US` old, and not after the clock has jumped.
//!
//! **Faulty links.** A message that repeats one of the last `HISTORY_MESSAGES` is ignored. Telemetry belongs to the
//! frame with its number. A frame whose telemetry comes later waits for it until the next frame arrives, and then gets
//! no estimate. A register block means that the source has restarted: earlier telemetry and messages are discarded. The
//! reference is kept, as the ground has not moved.

use crate::arinc429::{self, Camera as Addressee, Control, WordError};
use crate::framing::RawMessage;
use crate::ground::PlaneUpdate;
use crate::hardware::{self, Fpga, HardwareError, Size, registers};
use crate::line::{Estimate, Line, Reason, Status};
use crate::message::{self, Command, Frame, MessageError, Registers, Telemetry};
use crate::off_plane::OffPlaneMask;
use crate::reference::{MAX_ZOOM_CHANGE, Reference, is_accurate};
use hoverlock_fixed_point::model::record::FeatureRecord;
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::motion::budget::Budget;
use hoverlock_reference::motion::estimator::{Estimator, Workspace};
use hoverlock_reference::motion::mark::{Part, mark};
use hoverlock_reference::motion::matching::{GATE_RADIUS_PX, Gate};
use hoverlock_reference::motion::model::Pair;
use hoverlock_reference::motion::observation::Observation;
use hoverlock_reference::motion::orthophoto::{Camera, View};
use hoverlock_reference::motion::pose::{self, ConsensusPairs, PoseBuffers, PoseError};
use nalgebra::{Matrix3, Vector2};

/// Features of a frame that are used at most: those with the largest responses.
const MAX_FEATURES: usize = 1024;

/// Work units that a frame may spend. A unit is at most twelve instructions of the Cortex-A9, counted by
/// `make bench-arm`, so this is up to 26 million; records and output take one million more. Three rounds of matching
/// take 0.9 million units if the features are spread evenly over scales and polarities.
const WORK_UNITS: u64 = 2_200_000;

/// Part of `WORK_UNITS` that is reserved for the pose fit. An iteration over 600 pairs takes 27 thousand units; a fit
/// takes seven iterations, over hills twenty, and further ones over fewer pairs.
pub const POSE_WORK_UNITS: u64 = 700_000;

/// Pairs that the pose fit uses at most; of more, every second, third and so on. Over hills the fit to a thousand pairs
/// does not converge within [`POSE_WORK_UNITS`].
const MAX_POSE_PAIRS: usize = 600;

/// Age up to which a displacement is used to predict the next, microseconds. From 10 m or higher, a helicopter that
/// gains 2 m/s within that time moves the ground by less than the gate's radius.
const MAX_PREDICTION_AGE_US: u64 = 1_000_000;

/// Messages, and telemetry of frames, that are kept to recognise repetitions and to match frames.
const HISTORY_MESSAGES: usize = 16;

/// Late telemetry is accepted if its sequence number is at most this much above that of the message before its frame.
const MAX_TELEMETRY_LAG: u32 = 4;

/// Field of view after [`Command::Wide`].
const WIDE_VIEW_DEGREES: f64 = 50.0;

/// Field of view after [`Command::Narrow`]. The camera reaches 5.4 degrees, but there a tilt of 5 degrees would leave
/// nothing of the reference in view.
const NARROW_VIEW_DEGREES: f64 = 10.0;

/// Error bits of a trailer with which the features of its frame are unusable.
const DAMAGE_BITS: u32 = registers::STATUS_SHORT_FRAME
    | registers::STATUS_INTERRUPTED
    | registers::STATUS_REFUSED
    | registers::STATUS_LONG_FRAME;

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
    reference: Option<Reference>,
    last: Option<LastDisplacement>,
    telemetry: [Option<Telemetry>; HISTORY_MESSAGES],
    telemetry_next: usize,
    seen: [Option<(u32, u32)>; HISTORY_MESSAGES],
    seen_next: usize,
    /// Sequence number and line of a frame that has no telemetry yet.
    waiting: Option<(u32, Line)>,
    zoom: Option<f64>,
    counts: Counts,
    buffers: Buffers,
    work: u64,
}

#[derive(Clone, Copy)]
struct LastDisplacement {
    time_us: u64,
    displacement: Vector2<f64>,
    /// Downwards, m.
    descent: f64,
}

/// Memory that is allocated once and used for every frame.
struct Buffers {
    records: Vec<FeatureRecord>,
    reference: Vec<Feature>,
    off_plane: OffPlaneMask,
    current: Vec<Feature>,
    inliers: Vec<Pair>,
    workspace: Workspace,
    pose: PoseBuffers,
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

    /// Creates a navigator that may spend `work` units on each frame; the default is 2.2 million.
    pub fn with_work(work: u64) -> Self {
        Self {
            fpga: Fpga::default(),
            size: None,
            capture: false,
            renew: false,
            reference: None,
            last: None,
            telemetry: [None; HISTORY_MESSAGES],
            telemetry_next: 0,
            seen: [None; HISTORY_MESSAGES],
            seen_next: 0,
            waiting: None,
            zoom: None,
            counts: Counts::default(),
            buffers: Buffers {
                records: Vec::with_capacity(crate::framing::MAX_PAYLOAD_BYTES / message::MIN_RECORD_BYTES),
                reference: Vec::with_capacity(MAX_FEATURES),
                off_plane: OffPlaneMask::with_capacity(MAX_FEATURES),
                current: Vec::with_capacity(MAX_FEATURES),
                inliers: Vec::with_capacity(MAX_FEATURES),
                workspace: Workspace::with_capacity(MAX_FEATURES),
                pose: PoseBuffers::with_capacity(MAX_FEATURES),
            },
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
        &self.buffers.inliers
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
            message::REGISTERS => false,
            message::FRAME => {
                self.frame(raw, out);
                false
            }
            message::TELEMETRY => self.telemetry(raw, out).is_err(),
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
            self.reference = None;
        }
        self.size = Some(size);
        self.telemetry = [None; HISTORY_MESSAGES];
        self.seen = [None; HISTORY_MESSAGES];
        self.last = None;
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

    /// Unpacks the features of a frame into `buffers.current`.
    fn unpack_features(&mut self, frame: &Frame<'_>, line: &mut Line) -> Result<(), Reason> {
        let size = self.size.ok_or(Reason::Registers)?;
        if u32::from(frame.trailer.errors) & DAMAGE_BITS != 0 {
            return Err(Reason::Damaged(frame.trailer.errors));
        }
        let Buffers { records, current, .. } = &mut self.buffers;
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

    /// Processes the frame whose features are in `buffers.current`, now that its telemetry is known.
    fn finish_frame(&mut self, line: Line, telemetry: &Telemetry, out: &mut impl FnMut(&Line)) {
        let mut line = Line { time_us: Some(telemetry.time_us), ..line };
        let (mut search, mut fit) = (Budget::new(self.work.saturating_sub(POSE_WORK_UNITS)), Budget::new(0));
        // Before the estimate, as this frame may become the reference.
        line.reference = self.reference.filter(|_| !self.capture).and_then(|reference| reference.frame);
        let outcome = self.estimate(line.frame, telemetry, &mut search, &mut fit);
        mark(Part::Frame);
        match outcome {
            Ok(Some(estimate)) => {
                line.estimate = Some(estimate);
                line.status = if search.is_exhausted() { Status::Late } else { Status::Estimate };
            }
            Ok(None) => line.status = Status::Reference,
            Err(reason) => line.reason = Some(reason),
        }
        line.work = search.spent() + fit.spent();
        self.emit(line, out);
    }

    /// Returns the estimate relative to the origin, or `None` if the frame was captured as the reference.
    fn estimate(
        &mut self,
        frame: Option<u32>,
        telemetry: &Telemetry,
        search: &mut Budget,
        fit: &mut Budget,
    ) -> Result<Option<Estimate>, Reason> {
        let size = self.size.ok_or(Reason::Registers)?;
        let camera =
            Camera::with_field_of_view(usize::from(size.width), usize::from(size.height), telemetry.field_of_view)?;
        let view = View::new(camera, telemetry.attitude, telemetry.range)?;
        let Buffers {
            reference: reference_features, off_plane, current, inliers, workspace, pose: pose_buffers, ..
        } = &mut self.buffers;
        if self.capture {
            self.capture = false;
            self.renew = false;
            self.reference = Some(Reference::origin(frame, view, telemetry));
            self.last =
                Some(LastDisplacement { time_us: telemetry.time_us, displacement: Vector2::zeros(), descent: 0.0 });
            std::mem::swap(reference_features, current);
            off_plane.clear();
            return Ok(None);
        }
        let reference = self.reference.as_mut().ok_or(Reason::Reference)?;
        if reference.zoom_change(telemetry.field_of_view) > MAX_ZOOM_CHANGE {
            return Err(Reason::Zoom);
        }
        let fresh = |last: &LastDisplacement| {
            telemetry.time_us.checked_sub(last.time_us).is_some_and(|age| age <= MAX_PREDICTION_AGE_US)
        };
        let last = self.last.filter(fresh);
        // The laser range may be to a roof, so the predicted height over the ground is used instead where there is one.
        let at_height = |height| View::at_height(camera, telemetry.attitude, height).unwrap_or(view);
        let expected = last.map(|last| reference.sight.view.height() - (last.descent - reference.offset.descent));
        let gate = last.map(|last| {
            let moved = last.displacement - reference.offset.displacement;
            let level = expected.map_or(view, at_height);
            Gate { prediction: ground_homography(&reference.sight.view, &level, moved), radius: GATE_RADIUS_PX }
        });
        let mut estimator = Estimator::default();
        estimator.matching.gate = gate;
        mark(Part::Search);
        let motion = estimator.estimate_in(workspace, search, reference_features, current);
        mark(Part::Pose);
        let motion = motion?;
        *fit = Budget::new(self.work - search.spent());
        let stride = motion.inliers.len().div_ceil(MAX_POSE_PAIRS).max(1);
        let pairs = motion.inliers.iter().step_by(stride).map(|&i| (motion.matches[i].reference, motion.pairs[i]));
        let masked = off_plane.sort(pairs, fit, inliers);
        let consensus = ConsensusPairs { pairs: inliers, off_plane: masked, quality: motion.quality };
        let mut sight = Observation { view, errors: telemetry.sensors.into() };
        if let Some(expected) = expected {
            // The laser may have hit a building or a tree: the larger its residual, the less it constrains the height.
            sight.errors.relief_height = sight.errors.relief_height.max((view.height() - expected).abs() / 2.0);
        }
        let terrain = reference.ground.terrain();
        let pose = match pose::fit_in(pose_buffers, fit, &reference.sight, &terrain, &sight, consensus) {
            Ok(pose) => pose,
            Err(error) => {
                let rejected = matches!(error, PoseError::Disagreement { .. } | PoseError::Unexplained { .. });
                if rejected && reference.reject(view.height()) == PlaneUpdate::Replaced {
                    off_plane.clear();
                }
                return Err(error.into());
            }
        };
        off_plane.update(pose_buffers.off_plane());
        if reference.update(&pose, telemetry.range, telemetry.sensors.range) == PlaneUpdate::Replaced {
            off_plane.clear();
        }
        let step = Estimate::from_pose(&pose, motion.inliers.len(), motion.matches.len(), telemetry.sensors);
        let estimate = reference.offset.add(step);
        let displacement = Vector2::new(estimate.x_e_m, estimate.y_e_m);
        self.last = Some(LastDisplacement { time_us: telemetry.time_us, displacement, descent: estimate.z_e_m });
        if !reference.confirm(telemetry.time_us) {
            return Err(Reason::Unconfirmed);
        }
        let level = at_height(pose.current.height);
        let homography = ground_homography(&reference.sight.view, &level, pose.displacement);
        let expired = reference.is_expired(&estimate, &homography, (size.width, size.height), telemetry);
        if (expired || self.renew) && is_accurate(&step) {
            self.renew = false;
            *reference = Reference::renewed(frame, level, telemetry, &estimate, &pose, reference);
            std::mem::swap(reference_features, current);
            off_plane.clear();
        }
        Ok(Some(estimate))
    }
}

/// Returns the homography from pixels of the reference to pixels of the current view, for a camera that has moved by
/// `displacement` (m) over level ground.
fn ground_homography(reference: &View, current: &View, displacement: Vector2<f64>) -> Matrix3<f64> {
    current.from_ground() * Matrix3::new_translation(&-displacement) * reference.to_ground()
}
