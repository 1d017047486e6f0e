//! The reference frame: its position relative to the origin of the displacement, and when it is replaced.
//!
//! ```text
//! displacement of a frame = offset of the reference + displacement from the reference
//! covariance              = covariance of the offset + covariance from the reference
//! ```
//!
//! The command to capture makes the next frame the reference and the origin: its offset is 0. Later a frame with an
//! estimate may become the reference without moving the origin ("renewal"): its own displacement becomes the offset, so
//! that the estimates continue without a jump. Each renewal adds the error of one estimate. It therefore happens only
//! when the old reference is about to become useless:
//!
//! - on command ([`Command::Renew`](crate::message::Command::Renew)),
//! - the frame overlaps less than [`MIN_OVERLAP`] of the reference's picture,
//! - the field of view differs by more than [`RENEWAL_ZOOM_CHANGE`], because features are not invariant to scale,
//! - the quality has fallen below half of the best with this reference, once that is [`QUALITY_RENEWAL_AGE_US`] old.
//!
//! **The reference is refined by later frames.** Its attitude starts as one noisy reading; each pose fit estimates it
//! again. The ground below it is a plane through the laser points ([`crate::ground`]). Both can be wrong, for example
//! if the laser hit the crown of a tree. They are discarded when the ground plane is replaced, and when the fit rejects
//! [`MAX_REJECTED_FRAMES`] frames in a row. The reference then returns to its initial reading, over ground with a large
//! standard error.
//!
//! **Confirmation.** Waves look like ground until they have moved on. So no estimate is published until a captured
//! reference has been matched again [`CONFIRMATION_AGE_US`] after its capture. A reference that replaces a confirmed
//! one is confirmed.
//!
//! A frame whose displacement from the reference has a standard error above [`MAX_REFERENCE_ERROR_M`] does not become
//! the reference.

use crate::ground::{GroundPlane, PlaneUpdate};
use crate::line::Estimate;
use crate::message::Telemetry;
use hoverlock_reference::motion::model::transfer;
use hoverlock_reference::motion::observation::{FittedView, Observation, SensorErrors, ViewErrors};
use hoverlock_reference::motion::orthophoto::View;
use hoverlock_reference::motion::pose::Pose;
use nalgebra::{Matrix3, Vector2};

/// Smallest overlap of a frame with the reference, as a fraction of the reference's picture; below it the reference is
/// renewed.
const MIN_OVERLAP: f64 = 0.6;

/// Relative change of the field of view above which the reference is renewed.
const RENEWAL_ZOOM_CHANGE: f64 = 0.02;

/// Relative change of the field of view above which there is no estimate. At 5 %, 96 % of the descriptors still match.
pub const MAX_ZOOM_CHANGE: f64 = 0.08;

/// Age from which a fall of quality renews the reference, microseconds.
const QUALITY_RENEWAL_AGE_US: u64 = 1_000_000;

/// Age at which a captured reference must be matched again to be confirmed, microseconds. By then waves of 6 m or less
/// have moved by at least an eighth of their length.
const CONFIRMATION_AGE_US: u64 = 500_000;

/// Largest standard error, relative to the present reference, of a frame that may replace it, m.
const MAX_REFERENCE_ERROR_M: f64 = 0.3;

/// Rejected frames in a row after which the refined attitude and ground are discarded: a third of a second.
const MAX_REJECTED_FRAMES: u32 = 5;

/// Standard error of the height after the ground plane was discarded, m.
const UNKNOWN_GROUND_ERROR_M: f64 = 3.0;

/// Smallest standard error of the refined attitude, as a fraction of that of one reading: bias and drift do not
/// average out.
const MIN_ATTITUDE_ERROR_RATIO: f64 = 0.2;

/// Columns and rows of the points by which the overlap is counted.
const OVERLAP_GRID: (u32, u32) = (16, 12);

/// The position of a reference relative to the origin, with its covariance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OriginOffset {
    /// Along `X_e` and `Y_e`, m.
    pub displacement: Vector2<f64>,
    /// Downwards, m.
    pub descent: f64,
    /// Covariance of the displacement, xx, xy, yx, yy, m^2.
    pub covariance: [f64; 4],
}

impl OriginOffset {
    /// Converts an estimate relative to the reference into one relative to the origin.
    pub fn add(&self, estimate: Estimate) -> Estimate {
        Estimate {
            x_e_m: self.displacement.x + estimate.x_e_m,
            y_e_m: self.displacement.y + estimate.y_e_m,
            z_e_m: self.descent + estimate.z_e_m,
            covariance_m2: std::array::from_fn(|i| self.covariance[i] + estimate.covariance_m2[i]),
            ..estimate
        }
    }

    fn from_estimate(estimate: &Estimate) -> Self {
        Self {
            displacement: Vector2::new(estimate.x_e_m, estimate.y_e_m),
            descent: estimate.z_e_m,
            covariance: estimate.covariance_m2,
        }
    }
}

/// The frame with which others are matched.
#[derive(Debug, Clone, Copy)]
pub struct Reference {
    /// Frame number; `None` if it was not readable.
    pub frame: Option<u32>,
    /// View of its camera, refined by later frames.
    pub sight: Observation,
    /// Estimated ground plane below it.
    pub ground: GroundPlane,
    /// Field of view across the columns, radians.
    pub field_of_view: f64,
    /// Position relative to the origin.
    pub offset: OriginOffset,
    since_us: u64,
    best_quality: u8,
    confirmed: bool,
    sensors: SensorErrors,
    /// The view by its own sensor readings.
    initial: Observation,
    /// Rejected frames since the last accepted one.
    rejected_frames: u32,
}

impl Reference {
    /// Creates a reference that is the origin.
    pub fn origin(frame: Option<u32>, view: View, telemetry: &Telemetry) -> Self {
        let (field_of_view, since_us) = (telemetry.field_of_view, telemetry.time_us);
        let initial = Observation { view, errors: ViewErrors::from(telemetry.sensors) };
        Self {
            frame,
            sight: initial,
            ground: GroundPlane::new(&initial),
            field_of_view,
            offset: OriginOffset::default(),
            since_us,
            best_quality: 0,
            confirmed: false,
            sensors: telemetry.sensors,
            initial,
            rejected_frames: 0,
        }
    }

    /// Creates a reference that replaces `before`. `estimate` is the position of the new frame relative to the origin,
    /// `pose` its pose relative to `before`.
    pub fn renewed(
        frame: Option<u32>,
        view: View,
        telemetry: &Telemetry,
        estimate: &Estimate,
        pose: &Pose,
        before: &Self,
    ) -> Self {
        let mut new = Self {
            offset: OriginOffset::from_estimate(estimate),
            confirmed: true,
            ..Self::origin(frame, view, telemetry)
        };
        new.ground = before.ground.moved(pose);
        new.refine(&pose.current);
        new
    }

    /// Sets the view to the fitted attitude at the present height of the ground. Poses above the horizon are ignored.
    fn refine(&mut self, found: &FittedView) {
        let view = View::at_height(*self.sight.view.camera(), found.attitude, self.ground.height());
        let Ok(view) = view else { return };
        self.sight.view = view;
        self.sight.errors.tilt = found.tilt.max(MIN_ATTITUDE_ERROR_RATIO * self.sensors.tilt);
        self.sight.errors.heading = found.heading.max(MIN_ATTITUDE_ERROR_RATIO * self.sensors.heading);
    }

    /// Refines attitude and ground by an accepted frame: its pose, and its laser range with standard error, both in m.
    /// Returns `Replaced`, with the attitude reset, if the ground plane has changed.
    pub fn update(&mut self, pose: &Pose, range: f64, error: f64) -> PlaneUpdate {
        self.rejected_frames = 0;
        let update = self.ground.update(pose, range, error);
        match update {
            PlaneUpdate::Unchanged => self.refine(&pose.reference),
            PlaneUpdate::Replaced => self.reset_attitude(),
        }
        update
    }

    /// Counts a frame that the fit has rejected. After [`MAX_REJECTED_FRAMES`] in a row, resets the attitude, assumes
    /// level ground `height` m below the camera, and returns `Replaced`.
    pub fn reject(&mut self, height: f64) -> PlaneUpdate {
        self.rejected_frames += 1;
        if self.rejected_frames < MAX_REJECTED_FRAMES {
            return PlaneUpdate::Unchanged;
        }
        self.ground = GroundPlane::level(height, UNKNOWN_GROUND_ERROR_M);
        self.reset_attitude();
        PlaneUpdate::Replaced
    }

    /// Returns to the attitude of the initial reading, at the present height of the ground.
    fn reset_attitude(&mut self) {
        self.rejected_frames = 0;
        let initial = self.initial.view;
        let view = View::at_height(*initial.camera(), *initial.attitude(), self.ground.height()).unwrap_or(initial);
        self.sight = Observation { view, ..self.initial };
    }

    /// Returns the relative difference of a field of view (radians) from the reference's, at least 0.
    pub fn zoom_change(&self, field_of_view: f64) -> f64 {
        (field_of_view / self.field_of_view - 1.0).abs()
    }

    /// Marks the reference as confirmed if it is old enough at `time_us`, at which it was matched; returns `true` if it
    /// is confirmed. A clock that has jumped back confirms it, too.
    pub fn confirm(&mut self, time_us: u64) -> bool {
        self.confirmed |= time_us.checked_sub(self.since_us).is_none_or(|age| age >= CONFIRMATION_AGE_US);
        self.confirmed
    }

    /// Returns `true` if the frame of `estimate` should replace the reference. `homography` maps pixels of the
    /// reference to pixels of that frame; `size` is columns and rows.
    pub fn is_expired(
        &mut self,
        estimate: &Estimate,
        homography: &Matrix3<f64>,
        size: (u16, u16),
        telemetry: &Telemetry,
    ) -> bool {
        self.best_quality = self.best_quality.max(estimate.quality);
        let settled = telemetry.time_us.checked_sub(self.since_us).is_none_or(|age| age >= QUALITY_RENEWAL_AGE_US);
        let faded = settled && 2 * u16::from(estimate.quality) < u16::from(self.best_quality);
        faded
            || self.zoom_change(telemetry.field_of_view) > RENEWAL_ZOOM_CHANGE
            || overlap(homography, size) < MIN_OVERLAP
    }
}

/// Returns `true` if an estimate relative to the reference is accurate enough for its frame to become the reference.
pub fn is_accurate(estimate: &Estimate) -> bool {
    let [xx, xy, _, yy] = estimate.covariance_m2;
    let largest = (xx + yy) / 2.0 + ((xx - yy) * (xx - yy) / 4.0 + xy * xy).sqrt();
    largest <= MAX_REFERENCE_ERROR_M * MAX_REFERENCE_ERROR_M
}

/// Returns the fraction of a picture that `homography` maps into another of the same size.
fn overlap(homography: &Matrix3<f64>, (width, height): (u16, u16)) -> f64 {
    let (right, bottom) = (f64::from(width) - 1.0, f64::from(height) - 1.0);
    let place = |i: u32, n: u32, side: f64| side * (f64::from(i) + 0.5) / f64::from(n);
    let inside = |p: Vector2<f64>| (0.0..=right).contains(&p.x) && (0.0..=bottom).contains(&p.y);
    let points = (0..OVERLAP_GRID.1).flat_map(|y| (0..OVERLAP_GRID.0).map(move |x| (x, y)));
    let seen = points.filter(|&(x, y)| {
        let point = Vector2::new(place(x, OVERLAP_GRID.0, right), place(y, OVERLAP_GRID.1, bottom));
        transfer(homography, point).is_some_and(inside)
    });
    seen.count() as f64 / f64::from(OVERLAP_GRID.0 * OVERLAP_GRID.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_reference::motion::orthophoto::{Attitude, Camera};
    use nalgebra::Matrix2;

    #[test]
    fn rejected_frames_in_a_row_discard_attitude_and_ground() {
        let sensors = SensorErrors { tilt: 0.0035, heading: 0.01, range: 0.1 };
        let (attitude, range, field_of_view) = (Attitude { roll: 0.02, pitch: -0.01, yaw: 0.3 }, 44.0, 0.87);
        let camera = Camera::with_field_of_view(1024, 768, field_of_view).unwrap();
        let telemetry = Telemetry { frame: 0, time_us: 0, attitude, range, field_of_view, sensors };
        let view = View::new(camera, attitude, range).unwrap();
        let mut reference = Reference::origin(Some(0), view, &telemetry);
        let refined = FittedView {
            attitude: Attitude { roll: 0.05, ..attitude },
            height: reference.ground.height(),
            tilt: 1e-3,
            heading: 1e-3,
        };
        let pose = Pose {
            displacement: Vector2::zeros(),
            descent: 0.0,
            reference: refined,
            current: refined,
            covariance: Matrix2::identity() * 1e-4,
            residual: 0.1,
            relief: 0.0,
            quality: 255,
        };
        let reject = |reference: &mut Reference, count: u32| {
            (0..count).for_each(|_| {
                reference.reject(50.0);
            });
        };
        reference.update(&pose, range, sensors.range);
        reject(&mut reference, MAX_REJECTED_FRAMES - 1);
        reference.update(&pose, range, sensors.range);
        reject(&mut reference, MAX_REJECTED_FRAMES - 1);
        assert_eq!(reference.sight.view.attitude().roll, 0.05);
        assert!(reference.ground.height() < 45.0);
        reject(&mut reference, 1);
        assert_eq!(reference.sight.view.attitude(), &attitude);
        assert_eq!(reference.sight.errors, ViewErrors::from(sensors));
        assert_eq!(reference.ground.height(), 50.0);
        assert!((reference.sight.view.height() - 50.0).abs() < 1e-9);
        assert!(reference.ground.terrain().covariance[(0, 0)] > 2.0 && !reference.ground.terrain().slope_is_measured);
    }

    #[test]
    fn the_overlap_is_that_of_the_rectangles() {
        let moved = |x: f64, y: f64| Matrix3::new(1.0, 0.0, x, 0.0, 1.0, y, 0.0, 0.0, 1.0);
        assert_eq!(overlap(&moved(0.0, 0.0), (1024, 768)), 1.0);
        // A quarter of the columns and a half of the rows are lost.
        assert_eq!(overlap(&moved(256.0, -384.0), (1024, 768)), 0.375);
        assert_eq!(overlap(&moved(1100.0, 0.0), (1024, 768)), 0.0);
    }
}
