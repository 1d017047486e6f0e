//! Messages in, one line per frame out.
//!
//! For each frame: features and telemetry; the gate from attitude, range and the last displacement; the search of
//! [`hoverlock_reference::motion::estimate`]; the pose fit of [`hoverlock_reference::motion::pose`].
//!
//! **The gate.** `H = G_c^-1 T(-t) G_r`, with `G` the homography from pixels to metres that each view's telemetry
//! gives and `t` the last
//! displacement, predicts where a feature of the reference is now. It is used while the last displacement is at most
//! [`FRESH_US`] old.
//! After that, and after a clock that jumped, there is no gate.
//!
//! **Links that fail.** A message that repeats one of the last [`REMEMBERED`] is left out. Telemetry belongs to the
//! frame of its
//! number; a frame waits for its telemetry, a few messages, until the next frame comes; then it has none. A register
//! block means a source that
//! starts: telemetry and messages from before it are forgotten, the reference is kept, as the ground has not moved.

use crate::arinc429::{self, Camera as Addressee, Control, WordError};
use crate::framing::Raw;
use crate::ground::Told;
use crate::hardware::{self, Fpga, HardwareError, Size, registers};
use crate::line::{Estimate, Line, Reason, Status};
use crate::message::{self, Command, Frame, MessageError, Registers, Telemetry};
use crate::reference::{Reference, ZOOM_TOLERANCE, is_anchor};
use crate::things::Things;
use hoverlock_fixed_point::model::bit_true::FeatureRecord;
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::motion::budget::Budget;
use hoverlock_reference::motion::estimate::{Estimator, Workspace};
use hoverlock_reference::motion::mark::{Part, mark};
use hoverlock_reference::motion::matching::{GATE_RADIUS, Gate};
use hoverlock_reference::motion::model::Pair;
use hoverlock_reference::motion::orthophoto::{Camera, View};
use hoverlock_reference::motion::pose::{self, Agreed, PoseBuffers, PoseError, Sight};
use nalgebra::{Matrix3, Vector2};

/// Features of a frame that are used; of more, those with the largest responses.
pub const MAX_FEATURES: usize = 1024;

/// Work units of a frame. Three rounds of matching take 0.9 million where the features are spread evenly over scales
/// and polarities. A unit is at most twelve instructions of the Cortex-A9, counted by `make bench-arm`, so that these
/// are up to 26 million; one more goes to records and output.
pub const WORK: u64 = 2_200_000;

/// What the search leaves of these to the pose fit at least: 600 pairs take 27 thousand an iteration, and a fit takes
/// seven of them, over hills twenty, and some among fewer pairs.
pub const POSE_WORK: u64 = 700_000;

/// Pairs of which the pose is fitted at most; of more, every second, third, ..: over hills a thousand pairs would not
/// settle in the work that is left.
pub const POSE_PAIRS: usize = 600;

/// Age up to which a displacement predicts the next, microseconds. A helicopter that gains 2 m/s in a second moves
/// the ground by less than
/// the gate at 10 m height and more.
pub const FRESH_US: u64 = 1_000_000;

/// Messages and telemetry that are remembered.
pub const REMEMBERED: usize = 16;

/// From the message before its frame, telemetry that comes late is among so many further ones.
const LATE: u32 = 4;

/// Field of view of the wide view, degrees.
pub const WIDE: f64 = 50.0;

/// Field of view of the narrow view, degrees: 5 to each side. The camera goes down to 5.4, but a tilt of 5 degrees
/// would then leave nothing of the reference in view.
pub const NARROW: f64 = 10.0;

/// Error bits of a trailer after which the features are not those of the scene.
const DAMAGED: u32 = registers::STATUS_SHORT_FRAME
    | registers::STATUS_INTERRUPTED
    | registers::STATUS_REFUSED
    | registers::STATUS_LONG_FRAME;

/// What the program counts beside its lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Lines written.
    pub frames: u64,
    /// Messages left out because they repeat one.
    pub repeated: u64,
    /// Messages other than frames that were refused.
    pub refused: u64,
}

/// Whether the program goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next {
    /// With the next message.
    Continue,
    /// The command to stop has come.
    Stop,
}

/// The state between messages.
pub struct Navigator {
    fpga: Fpga,
    size: Option<Size>,
    capture: bool,
    renew: bool,
    reference: Option<Reference>,
    last: Option<Last>,
    telemetry: [Option<Telemetry>; REMEMBERED],
    telemetry_next: usize,
    seen: [Option<(u32, u32)>; REMEMBERED],
    seen_next: usize,
    /// A frame without telemetry yet, and the sequence number of its message.
    waiting: Option<(u32, Line)>,
    zoom: Option<f64>,
    counts: Counts,
    memory: Memory,
    work: u64,
}

#[derive(Clone, Copy)]
struct Last {
    time_us: u64,
    displacement: Vector2<f64>,
    /// Down, m.
    descent: f64,
}

/// Allocated once.
struct Memory {
    records: Vec<FeatureRecord>,
    reference: Vec<Feature>,
    things: Things,
    current: Vec<Feature>,
    inliers: Vec<Pair>,
    workspace: Workspace,
    pose: PoseBuffers,
}

impl Default for Navigator {
    fn default() -> Self {
        Self::with_work(WORK)
    }
}

impl Navigator {
    /// For another FPGA than that of the Verilog this was built with.
    pub fn of(fpga: Fpga) -> Self {
        Self { fpga, ..Self::default() }
    }

    /// With `work` units for each frame.
    pub fn with_work(work: u64) -> Self {
        Self {
            fpga: Fpga::default(),
            size: None,
            capture: false,
            renew: false,
            reference: None,
            last: None,
            telemetry: [None; REMEMBERED],
            telemetry_next: 0,
            seen: [None; REMEMBERED],
            seen_next: 0,
            waiting: None,
            zoom: None,
            counts: Counts::default(),
            memory: Memory {
                records: Vec::with_capacity(crate::framing::MAX_PAYLOAD / message::RECORD),
                reference: Vec::with_capacity(MAX_FEATURES),
                things: Things::with_capacity(MAX_FEATURES),
                current: Vec::with_capacity(MAX_FEATURES),
                inliers: Vec::with_capacity(MAX_FEATURES),
                workspace: Workspace::with_capacity(MAX_FEATURES),
                pose: PoseBuffers::with_capacity(MAX_FEATURES),
            },
            work,
        }
    }

    /// The word that has become due for the camera, once.
    ///
    /// # Errors
    /// Where the camera does not take the field of view.
    pub fn camera_word(&mut self) -> Result<Option<u32>, WordError> {
        self.zoom.take().map(|degrees| arinc429::encode(Addressee::All, Control::Zoom(degrees))).transpose()
    }

    /// What was counted so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The pairs that agreed for the last estimate; without a meaning where the last line has no estimate.
    pub fn inliers(&self) -> &[Pair] {
        &self.memory.inliers
    }

    /// Takes a message; `out` gets the lines that it completes, at most two.
    ///
    /// # Errors
    /// Where a register block shows that the FPGA is not the one this program was built for.
    pub fn take(&mut self, raw: &Raw<'_>, out: &mut impl FnMut(&Line)) -> Result<Next, HardwareError> {
        if raw.kind == message::REGISTERS {
            self.start(raw, out)?;
        }
        let this = Some((raw.sequence, raw.check));
        if self.seen.contains(&this) {
            self.counts.repeated += 1;
            return Ok(Next::Continue);
        }
        self.seen[self.seen_next] = this;
        self.seen_next = (self.seen_next + 1) % REMEMBERED;
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

    /// The end of the stream: a frame that waits for its telemetry gets none.
    pub fn finish(&mut self, out: &mut impl FnMut(&Line)) {
        if let Some((_, line)) = self.waiting.take() {
            self.emit(Line { reason: Some(Reason::Telemetry), ..line }, out);
        }
    }

    fn emit(&mut self, line: Line, out: &mut impl FnMut(&Line)) {
        self.counts.frames += 1;
        out(&line);
    }

    fn start(&mut self, raw: &Raw<'_>, out: &mut impl FnMut(&Line)) -> Result<(), HardwareError> {
        let Ok(block) = Registers::parse(raw.payload) else { return Ok(()) };
        let size = hardware::check(&self.fpga, &block)?;
        self.finish(out);
        if self.size.is_some_and(|before| before != size) {
            self.reference = None;
        }
        self.size = Some(size);
        self.telemetry = [None; REMEMBERED];
        self.seen = [None; REMEMBERED];
        self.last = None;
        Ok(())
    }

    fn command(&mut self, command: Command) {
        match command {
            Command::Capture => self.capture = true,
            Command::Renew => self.renew = true,
            Command::Wide => self.zoom = Some(WIDE),
            Command::Narrow => self.zoom = Some(NARROW),
            Command::Stop => (),
        }
    }

    fn telemetry(&mut self, raw: &Raw<'_>, out: &mut impl FnMut(&Line)) -> Result<(), MessageError> {
        let telemetry = Telemetry::parse(raw.payload)?;
        // Next to its frame in the source's own count, so that it is not that of a source that starts with the same
        // numbers.
        let belongs = |(sequence, line): &mut (u32, Line)| {
            line.frame == Some(telemetry.frame) && raw.sequence.wrapping_sub(sequence.wrapping_sub(1)) <= LATE
        };
        if let Some((_, line)) = self.waiting.take_if(belongs) {
            self.located(line, &telemetry, out);
        } else {
            // The newest of a number replaces one of a source before it.
            let same = |slot: &Option<Telemetry>| slot.is_some_and(|before| before.frame == telemetry.frame);
            let slot = self.telemetry.iter().position(same).unwrap_or_else(|| {
                self.telemetry_next = (self.telemetry_next + 1) % REMEMBERED;
                self.telemetry_next
            });
            self.telemetry[slot] = Some(telemetry);
        }
        Ok(())
    }

    fn frame(&mut self, raw: &Raw<'_>, out: &mut impl FnMut(&Line)) {
        self.finish(out);
        let frame = match Frame::parse(raw.payload) {
            Ok(frame) => frame,
            Err(error) => return self.emit(Line { reason: Some(error.into()), ..Line::of(None) }, out),
        };
        let mut line = Line::of(Some(&frame.trailer));
        if let Err(reason) = self.features(&frame, &mut line) {
            return self.emit(Line { reason: Some(reason), ..line }, out);
        }
        let number = frame.trailer.frame;
        match self.telemetry.iter_mut().find_map(|slot| slot.take_if(|telemetry| telemetry.frame == number)) {
            Some(telemetry) => self.located(line, &telemetry, out),
            None => self.waiting = Some((raw.sequence, line)),
        }
    }

    /// The frame's features into the memory.
    fn features(&mut self, frame: &Frame<'_>, line: &mut Line) -> Result<(), Reason> {
        let size = self.size.ok_or(Reason::Registers)?;
        if u32::from(frame.trailer.errors) & DAMAGED != 0 {
            return Err(Reason::Damaged(frame.trailer.errors));
        }
        let Memory { records, current, .. } = &mut self.memory;
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
            // The strongest, and of equal ones the first; then in raster order again.
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

    /// The frame whose features are in the memory, with its telemetry.
    fn located(&mut self, line: Line, telemetry: &Telemetry, out: &mut impl FnMut(&Line)) {
        let mut line = Line { time_us: Some(telemetry.time_us), ..line };
        let (mut search, mut fit) = (Budget::new(self.work.saturating_sub(POSE_WORK)), Budget::new(0));
        // The frame it is compared with, before it may take that one's place.
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

    /// The estimate, from the origin; nothing where the frame became the origin.
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
        let Memory { reference: reference_features, things, current, inliers, workspace, pose: buffers, .. } =
            &mut self.memory;
        if self.capture {
            self.capture = false;
            self.renew = false;
            self.reference = Some(Reference::origin(frame, view, telemetry));
            self.last = Some(Last { time_us: telemetry.time_us, displacement: Vector2::zeros(), descent: 0.0 });
            std::mem::swap(reference_features, current);
            things.forget();
            return Ok(None);
        }
        let reference = self.reference.as_mut().ok_or(Reason::Reference)?;
        if reference.zoom(telemetry.field_of_view) > ZOOM_TOLERANCE {
            return Err(Reason::Zoom);
        }
        let fresh = |last: &Last| telemetry.time_us.checked_sub(last.time_us).is_some_and(|age| age <= FRESH_US);
        let last = self.last.filter(fresh);
        // What the laser reads may be the height over a roof.
        let at_height = |height| View::at_height(camera, telemetry.attitude, height).unwrap_or(view);
        let expected = last.map(|last| reference.sight.view.height() - (last.descent - reference.base.descent));
        let gate = last.map(|last| {
            let moved = last.displacement - reference.base.displacement;
            let level = expected.map_or(view, at_height);
            Gate { prediction: predicted(&reference.sight.view, &level, moved), radius: GATE_RADIUS }
        });
        let mut estimator = Estimator::default();
        estimator.matching.gate = gate;
        mark(Part::Search);
        let motion = estimator.estimate_in(workspace, search, reference_features, current);
        mark(Part::Pose);
        let motion = motion?;
        *fit = Budget::new(self.work - search.spent());
        let stride = motion.inliers.len().div_ceil(POSE_PAIRS).max(1);
        let pairs = motion.inliers.iter().step_by(stride).map(|&i| (motion.matches[i].reference, motion.pairs[i]));
        let on_things = things.sort(pairs, fit, inliers);
        let agreed = Agreed { pairs: inliers, things: on_things, quality: motion.quality };
        let mut sight = Sight { view, errors: telemetry.sensors.into() };
        if let Some(expected) = expected {
            // The laser may have met what stands on the ground: the further off, the less it says of the ground.
            sight.errors.hills = sight.errors.hills.max((view.height() - expected).abs() / 2.0);
        }
        let terrain = reference.ground.terrain();
        let pose = match pose::fit_in(buffers, fit, &reference.sight, &terrain, &sight, agreed) {
            Ok(pose) => pose,
            Err(error) => {
                let contradicted = matches!(error, PoseError::Disagreement { .. } | PoseError::Unexplained { .. });
                if contradicted && reference.doubt(view.height()) == Told::Another {
                    things.forget();
                }
                return Err(error.into());
            }
        };
        things.learn(buffers.off());
        if reference.improve(&pose, telemetry.range, telemetry.sensors.range) == Told::Another {
            things.forget();
        }
        let step = Estimate::of(&pose, motion.inliers.len(), motion.matches.len(), telemetry.sensors);
        let estimate = reference.base.add(step);
        let displacement = Vector2::new(estimate.x_e_m, estimate.y_e_m);
        self.last = Some(Last { time_us: telemetry.time_us, displacement, descent: estimate.z_e_m });
        if !reference.is_proved(telemetry.time_us) {
            return Err(Reason::Unproved);
        }
        let level = at_height(pose.current.height);
        let homography = predicted(&reference.sight.view, &level, pose.displacement);
        let worn = reference.is_worn(&estimate, &homography, (size.width, size.height), telemetry);
        if (worn || self.renew) && is_anchor(&step) {
            self.renew = false;
            *reference = Reference::renewed(frame, level, telemetry, &estimate, &pose, reference);
            std::mem::swap(reference_features, current);
            things.forget();
        }
        Ok(Some(estimate))
    }
}

/// REF pixel -> CUR pixel, when the camera has moved by `displacement` (m) over level ground.
fn predicted(reference: &View, current: &View, displacement: Vector2<f64>) -> Matrix3<f64> {
    current.from_ground() * Matrix3::new_translation(&-displacement) * reference.to_ground()
}
