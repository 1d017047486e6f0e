//! The ground below the reference: a plane through what the laser has met, by recursive least squares.
//!
//! ```text
//! depth + slope . (x, y) = height,    (x, y, depth) = t + r R e_z
//! ```
//!
//! `(x, y, depth)` is the point that the laser meets in a frame, from the camera of the reference: `t` is the
//! displacement that the frame's pose has, `R` its attitude, `r` the range. A point that is far off the plane lies on a
//! house or a tree and is left out; where most points are, they are the ground, and the plane begins anew.
//!
//! Why the laser: two pictures of a slope, one taken a metre lower, differ as if the camera had moved by the slope
//! times a metre. Beams at different tilts tell slope and motion apart.

use hoverlock_reference::motion::pose::{Pose, Sight, Terrain};
use nalgebra::{Matrix3, Vector2, Vector3};

/// Standard deviation of the ground about the plane, m.
const ROUGHNESS: f64 = 0.3;

/// Standard deviation of a slope, before a second beam tells: 6 degrees.
const SLOPE: f64 = 0.1;

/// A point that is further off the plane, in standard deviations, lies on something else.
const GATE: f64 = 3.0;

/// Beams that a slope takes: a plane has three unknowns.
const FEW: u32 = 4;

/// By how many the beams that met something else must be more than those on the plane to be the ground.
const MAJORITY: u32 = 30;

/// Part of the plane that laser points never tell, as variances of height (m^2) and slopes: features lie elsewhere.
const LEAST: [f64; 3] = [0.04, 1e-4, 1e-4];

/// The plane below a reference.
#[derive(Debug, Clone, Copy)]
pub struct GroundPlane {
    /// Height and slopes.
    mean: Vector3<f64>,
    covariance: Matrix3<f64>,
    /// Beams that met it, and others.
    ground: u32,
    others: u32,
}

/// Of one point, with the variance of its height.
fn start(variance: f64) -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(variance, SLOPE * SLOPE, SLOPE * SLOPE))
}

impl GroundPlane {
    /// What the laser tells with the reference itself.
    pub fn new(sight: &Sight) -> Self {
        let mean = Vector3::new(sight.view.height(), 0.0, 0.0);
        Self { mean, covariance: start(sight.errors.level.powi(2) + ROUGHNESS * ROUGHNESS), ground: 1, others: 0 }
    }

    /// With what the laser meets in a frame of a pose.
    pub fn meet(&mut self, pose: &Pose, range: f64, error: f64) {
        let beam = pose.current.attitude.rotation().column(2) * range;
        let (x, y) = (pose.displacement.x + beam.x, pose.displacement.y + beam.y);
        let depth = pose.descent + beam.z;
        let row = Vector3::new(1.0, -x, -y);
        let off = depth - row.dot(&self.mean);
        let sigma2 = error * error + ROUGHNESS * ROUGHNESS;
        let predicted = row.dot(&(self.covariance * row));
        if off * off > GATE * GATE * (predicted + sigma2) {
            self.others += 1;
            if self.others <= self.ground + MAJORITY {
                return;
            }
            // Most beams meet something else than the plane: that is the ground.
            let mean = Vector3::new(depth, 0.0, 0.0);
            *self = Self { mean, covariance: start(sigma2), ground: 1, others: 0 };
            return;
        }
        self.ground += 1;
        let gain = self.covariance * row / (predicted + sigma2);
        self.mean += gain * off;
        self.covariance -= gain * (row.transpose() * self.covariance);
        self.covariance = (self.covariance + self.covariance.transpose()) * 0.5;
    }

    /// The same plane below the camera of a frame.
    pub fn moved(&self, pose: &Pose) -> Self {
        let by = Matrix3::new(1.0, -pose.displacement.x, -pose.displacement.y, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
        let mean = by * self.mean - Vector3::x() * pose.descent;
        Self { mean, covariance: by * self.covariance * by.transpose(), ..*self }
    }

    /// Height over it, m.
    pub fn height(&self) -> f64 {
        self.mean.x
    }

    /// What the fit is told.
    pub fn terrain(&self) -> Terrain {
        let least = Matrix3::from_diagonal(&Vector3::from(LEAST));
        let [height, along_x, along_y] = self.mean.into();
        Terrain {
            height,
            slope: Vector2::new(along_x, along_y),
            covariance: self.covariance + least,
            measured: self.ground >= FEW,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_reference::motion::orthophoto::{Attitude, Camera, View};
    use hoverlock_reference::motion::pose::{Found, Sensors};
    use nalgebra::Matrix2;

    const SENSORS: Sensors = Sensors { tilt: 0.0035, heading: 0.01, range: 0.1 };

    fn pose(number: u32) -> Pose {
        let phase = f64::from(number) * 0.4;
        let attitude = Attitude { roll: 0.08 * phase.sin(), pitch: 0.08 * (1.3 * phase).cos(), yaw: 0.0 };
        let found = Found { attitude, height: 50.0, tilt: 1e-3, heading: 1e-3 };
        Pose {
            displacement: Vector2::new(0.3 * phase.cos(), 0.2 * phase.sin()),
            descent: 0.5 * (0.3 * phase).sin(),
            reference: found,
            current: found,
            covariance: Matrix2::identity() * 1e-4,
            residual: 0.1,
            relief: 0.0,
            quality: 255,
        }
    }

    /// Range to ground `depth + slope . (x, y) = height`, from a pose.
    fn range(pose: &Pose, height: f64, slope: Vector2<f64>) -> f64 {
        let axis = pose.current.attitude.rotation().column(2).into_owned();
        (height - pose.descent - slope.dot(&pose.displacement)) / (axis.z + slope.dot(&axis.xy()))
    }

    fn plane(first: f64) -> GroundPlane {
        let camera = Camera::with_field_of_view(1024, 768, 0.87).unwrap();
        let view = View::new(camera, Attitude::default(), first).unwrap();
        GroundPlane::new(&Sight { view, errors: SENSORS.into() })
    }

    /// Beams at different tilts give height and slope; the covariance says to how much.
    #[test]
    fn a_slope_is_found() {
        let (mut ground, slope) = (plane(50.0), Vector2::new(0.2, -0.1));
        for pose in (1..200).map(pose) {
            ground.meet(&pose, range(&pose, 50.0, slope), SENSORS.range);
        }
        let terrain = ground.terrain();
        assert!((terrain.height - 50.0).abs() < 0.05 && (terrain.slope - slope).norm() < 0.01, "{terrain:?}");
        assert!(terrain.covariance[(1, 1)].sqrt() < 0.02);
    }

    #[test]
    fn roofs_are_not_ground() {
        let mut ground = plane(50.0);
        for (i, pose) in (1..200).map(pose).enumerate() {
            let roof = if i % 30 < 10 { 12.0 } else { 0.0 };
            ground.meet(&pose, range(&pose, 50.0 - roof, Vector2::zeros()), SENSORS.range);
        }
        assert!((ground.height() - 50.0).abs() < 0.05 && ground.terrain().slope.norm() < 0.01, "{ground:?}");
    }

    /// The reference was captured over a roof.
    #[test]
    fn what_most_beams_meet_is_the_ground() {
        let mut ground = plane(38.0);
        for pose in (1..100).map(pose) {
            ground.meet(&pose, range(&pose, 50.0, Vector2::zeros()), SENSORS.range);
        }
        assert!((ground.height() - 50.0).abs() < 0.1, "{ground:?}");
    }

    /// The same plane from another camera: a beam from there meets it.
    #[test]
    fn a_renewed_reference_stands_over_the_same_ground() {
        let (mut ground, slope) = (plane(50.0), Vector2::new(0.2, -0.1));
        for pose in (1..200).map(pose) {
            ground.meet(&pose, range(&pose, 50.0, slope), SENSORS.range);
        }
        let to = Pose { displacement: Vector2::new(10.0, 5.0), descent: 2.0, ..pose(3) };
        // 50 - 2 - 0.2 * 10 + 0.1 * 5
        let moved = ground.moved(&to);
        assert!((moved.height() - 46.5).abs() < 0.15, "{moved:?}");
        assert_eq!(moved.terrain().slope, ground.terrain().slope);
    }
}
