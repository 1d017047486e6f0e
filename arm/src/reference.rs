//! The reference frame: where it lies from the origin of the displacement, and when another takes its place.
//!
//! ```text
//! displacement of a frame = base of the reference + displacement from the reference
//! covariance              = base covariance       + covariance from the reference
//! ```
//!
//! The command to capture makes the next frame the origin: base 0. A frame with an estimate may take the reference's
//! place without moving the origin. Its own displacement becomes the base, so the estimate goes on without a jump; the
//! price is that errors add up, hence it happens only where the old reference is about to be of no use:
//!
//! - on command ([`Command::Renew`](crate::message::Command::Renew)),
//! - the frames have less than [`LEAST_SHARED`] of the reference's picture in common,
//! - the field of view differs by more than [`ZOOM_RENEWS`], because features are not invariant to scale,
//! - quality is below half of the best with this reference, for [`SETTLING_US`] at least.
//!
//! **What is known of it** grows with the frames. Its attitude is not that of one noisy reading: each pose fit says
//! what is known of it after one more frame. The ground below it is a plane through the points that the laser has met
//! ([`crate::ground`]). What was learnt may be wrong, where the laser met the crown of a tree: it is forgotten when the
//! ground turns out to be another, and when the pictures contradict it in [`DOUBTS`] frames in a row. Then the
//! reference is what its own reading says, over ground of which little is known, and learns anew.
//!
//! **Proof.** Waves look like ground until they have moved on. So a captured reference has to be found again after
//! [`PROVING_US`] before any estimate from it is believed; a reference that a proved one was renewed by is proved.
//!
//! A frame whose displacement from the reference is known to more than [`ANCHOR`] only is not taken.

use crate::ground::{GroundPlane, Told};
use crate::line::Estimate;
use crate::message::Telemetry;
use hoverlock_reference::motion::model::transfer;
use hoverlock_reference::motion::orthophoto::View;
use hoverlock_reference::motion::pose::{Errors, Found, Pose, Sensors, Sight};
use nalgebra::{Matrix3, Vector2};

/// Part of the reference's picture that a frame sees, below which the frame takes its place.
pub const LEAST_SHARED: f64 = 0.6;

/// Part by which the field of view may differ from the reference's before the reference is renewed.
pub const ZOOM_RENEWS: f64 = 0.02;

/// Part by which the field of view may differ from the reference's at all: at 5 % some 96 % of the descriptors are
/// still found again.
pub const ZOOM_TOLERANCE: f64 = 0.08;

/// Time that a reference is kept before a fall of quality renews it, microseconds.
pub const SETTLING_US: u64 = 1_000_000;

/// Age at which a captured reference must be found again to be believed, microseconds. Waves of 6 m, and shorter ones
/// more so, have moved by an eighth of their length and more.
pub const PROVING_US: u64 = 500_000;

/// Largest standard error, from the reference before it, of a frame that becomes the reference, m.
pub const ANCHOR: f64 = 0.3;

/// Frames in a row that contradict what was learnt, after which it is forgotten: a third of a second.
pub const DOUBTS: u32 = 5;

/// Standard error of the height over ground that is not known, m.
const UNKNOWN_GROUND: f64 = 3.0;

/// Part of the error of one reading of attitude, below which the readings of many frames are not believed to bring it:
/// bias and drift are in all of them.
const LEARNT: f64 = 0.2;

/// Columns and rows of points at which the common part is counted.
const GRID: (u32, u32) = (16, 12);

/// A displacement and how well it is known.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Base {
    /// Along `X_e` and `Y_e`, m.
    pub displacement: Vector2<f64>,
    /// Downwards, m.
    pub descent: f64,
    /// Covariance of the displacement, xx, xy, yx, yy, m^2.
    pub covariance: [f64; 4],
}

impl Base {
    /// The estimate from the reference, seen from the origin.
    pub fn add(&self, estimate: Estimate) -> Estimate {
        Estimate {
            x_e_m: self.displacement.x + estimate.x_e_m,
            y_e_m: self.displacement.y + estimate.y_e_m,
            z_e_m: self.descent + estimate.z_e_m,
            covariance_m2: std::array::from_fn(|i| self.covariance[i] + estimate.covariance_m2[i]),
            ..estimate
        }
    }

    /// Where an estimate is.
    fn of(estimate: &Estimate) -> Self {
        Self {
            displacement: Vector2::new(estimate.x_e_m, estimate.y_e_m),
            descent: estimate.z_e_m,
            covariance: estimate.covariance_m2,
        }
    }
}

/// The frame that others are compared with.
#[derive(Debug, Clone, Copy)]
pub struct Reference {
    /// Number of the frame.
    pub frame: Option<u32>,
    /// Where its camera looked, as far as is known by now.
    pub sight: Sight,
    /// The ground below it.
    pub ground: GroundPlane,
    /// Its field of view, radians.
    pub field_of_view: f64,
    /// Where it lies from the origin.
    pub base: Base,
    since_us: u64,
    best_quality: u8,
    proved: bool,
    sensors: Sensors,
    /// Its own reading.
    own: Sight,
    /// Frames in a row that contradict what was learnt.
    doubts: u32,
}

impl Reference {
    /// The origin.
    pub fn origin(frame: Option<u32>, view: View, telemetry: &Telemetry) -> Self {
        let (field_of_view, since_us) = (telemetry.field_of_view, telemetry.time_us);
        let own = Sight { view, errors: Errors::from(telemetry.sensors) };
        Self {
            frame,
            sight: own,
            ground: GroundPlane::new(&own),
            field_of_view,
            base: Base::default(),
            since_us,
            best_quality: 0,
            proved: false,
            sensors: telemetry.sensors,
            own,
            doubts: 0,
        }
    }

    /// The frame of `estimate`, which is seen from the origin, and of the pose that it comes from.
    pub fn renewed(
        frame: Option<u32>,
        view: View,
        telemetry: &Telemetry,
        estimate: &Estimate,
        pose: &Pose,
        before: &Self,
    ) -> Self {
        let mut new = Self { base: Base::of(estimate), proved: true, ..Self::origin(frame, view, telemetry) };
        new.ground = before.ground.moved(pose);
        new.learn(&pose.current);
        new
    }

    /// Takes the attitude that a fit has found, over the ground as it is known by now.
    fn learn(&mut self, found: &Found) {
        let view = View::at_height(*self.sight.view.camera(), found.attitude, self.ground.height());
        // A pose that is no view of the ground teaches nothing.
        let Ok(view) = view else { return };
        self.sight.view = view;
        self.sight.errors.tilt = found.tilt.max(LEARNT * self.sensors.tilt);
        self.sight.errors.heading = found.heading.max(LEARNT * self.sensors.heading);
    }

    /// Takes what a frame tells of this one: its pose, and what the laser has met (m). Another ground is told, and what
    /// was learnt over the first is forgotten.
    pub fn improve(&mut self, pose: &Pose, range: f64, error: f64) -> Told {
        self.doubts = 0;
        let told = self.ground.meet(pose, range, error);
        match told {
            Told::Same => self.learn(&pose.reference),
            Told::Another => self.forget(),
        }
        told
    }

    /// Takes that a frame, `height` (m) over what its laser meets, contradicts what was learnt.
    pub fn doubt(&mut self, height: f64) -> Told {
        self.doubts += 1;
        if self.doubts < DOUBTS {
            return Told::Same;
        }
        self.ground = GroundPlane::about(height, UNKNOWN_GROUND);
        self.forget();
        Told::Another
    }

    /// The attitude of its own reading again, over the ground as it is known by now.
    fn forget(&mut self) {
        self.doubts = 0;
        let own = self.own.view;
        let view = View::at_height(*own.camera(), *own.attitude(), self.ground.height()).unwrap_or(own);
        self.sight = Sight { view, ..self.own };
    }

    /// Part by which a field of view differs from this one's.
    pub fn zoom(&self, field_of_view: f64) -> f64 {
        (field_of_view / self.field_of_view - 1.0).abs()
    }

    /// Whether this has been found again late enough, now at `time_us`. A clock that jumped back proves nothing wrong.
    pub fn is_proved(&mut self, time_us: u64) -> bool {
        self.proved |= time_us.checked_sub(self.since_us).is_none_or(|age| age >= PROVING_US);
        self.proved
    }

    /// Whether the frame of `estimate`, `moved` from this one, should take its place. `homography` maps this picture to
    /// that one, of `size` pixels.
    pub fn is_worn(
        &mut self,
        estimate: &Estimate,
        homography: &Matrix3<f64>,
        size: (u16, u16),
        telemetry: &Telemetry,
    ) -> bool {
        self.best_quality = self.best_quality.max(estimate.quality);
        let settled = telemetry.time_us.checked_sub(self.since_us).is_none_or(|age| age >= SETTLING_US);
        let faded = settled && 2 * u16::from(estimate.quality) < u16::from(self.best_quality);
        faded || self.zoom(telemetry.field_of_view) > ZOOM_RENEWS || shared(homography, size) < LEAST_SHARED
    }
}

/// Whether the frame of an estimate from the reference is known well enough to take its place.
pub fn is_anchor(estimate: &Estimate) -> bool {
    let [xx, xy, _, yy] = estimate.covariance_m2;
    let largest = (xx + yy) / 2.0 + ((xx - yy) * (xx - yy) / 4.0 + xy * xy).sqrt();
    largest <= ANCHOR * ANCHOR
}

/// Part of a picture of `size` pixels that `homography` maps into another of that size.
fn shared(homography: &Matrix3<f64>, (width, height): (u16, u16)) -> f64 {
    let (right, bottom) = (f64::from(width) - 1.0, f64::from(height) - 1.0);
    let place = |i: u32, n: u32, side: f64| side * (f64::from(i) + 0.5) / f64::from(n);
    let inside = |p: Vector2<f64>| (0.0..=right).contains(&p.x) && (0.0..=bottom).contains(&p.y);
    let points = (0..GRID.1).flat_map(|y| (0..GRID.0).map(move |x| (x, y)));
    let seen = points.filter(|&(x, y)| {
        let point = Vector2::new(place(x, GRID.0, right), place(y, GRID.1, bottom));
        transfer(homography, point).is_some_and(inside)
    });
    seen.count() as f64 / f64::from(GRID.0 * GRID.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_reference::motion::orthophoto::{Attitude, Camera};
    use nalgebra::Matrix2;

    /// Frames that contradict what was learnt take it back, in a row only.
    #[test]
    fn what_is_contradicted_is_forgotten() {
        let sensors = Sensors { tilt: 0.0035, heading: 0.01, range: 0.1 };
        let (attitude, range, field_of_view) = (Attitude { roll: 0.02, pitch: -0.01, yaw: 0.3 }, 44.0, 0.87);
        let camera = Camera::with_field_of_view(1024, 768, field_of_view).unwrap();
        let telemetry = Telemetry { frame: 0, time_us: 0, attitude, range, field_of_view, sensors };
        let view = View::new(camera, attitude, range).unwrap();
        let mut reference = Reference::origin(Some(0), view, &telemetry);
        let learnt = Found {
            attitude: Attitude { roll: 0.05, ..attitude },
            height: reference.ground.height(),
            tilt: 1e-3,
            heading: 1e-3,
        };
        let pose = Pose {
            displacement: Vector2::zeros(),
            descent: 0.0,
            reference: learnt,
            current: learnt,
            covariance: Matrix2::identity() * 1e-4,
            residual: 0.1,
            relief: 0.0,
            quality: 255,
        };
        let doubts = |reference: &mut Reference, count: u32| {
            (0..count).for_each(|_| {
                reference.doubt(50.0);
            });
        };
        reference.improve(&pose, range, sensors.range);
        doubts(&mut reference, DOUBTS - 1);
        reference.improve(&pose, range, sensors.range);
        doubts(&mut reference, DOUBTS - 1);
        assert_eq!(reference.sight.view.attitude().roll, 0.05);
        assert!(reference.ground.height() < 45.0);
        doubts(&mut reference, 1);
        assert_eq!(reference.sight.view.attitude(), &attitude);
        assert_eq!(reference.sight.errors, Errors::from(sensors));
        assert_eq!(reference.ground.height(), 50.0);
        assert!((reference.sight.view.height() - 50.0).abs() < 1e-9);
        assert!(reference.ground.terrain().covariance[(0, 0)] > 2.0 && !reference.ground.terrain().measured);
    }

    #[test]
    fn the_common_part_is_that_of_the_rectangles() {
        let moved = |x: f64, y: f64| Matrix3::new(1.0, 0.0, x, 0.0, 1.0, y, 0.0, 0.0, 1.0);
        assert_eq!(shared(&moved(0.0, 0.0), (1024, 768)), 1.0);
        // A quarter of the columns and a half of the rows are lost.
        assert_eq!(shared(&moved(256.0, -384.0), (1024, 768)), 0.375);
        assert_eq!(shared(&moved(1100.0, 0.0), (1024, 768)), 0.0);
    }
}
