//! The ground below the reference: a plane through what the laser has met, by recursive least squares.
//!
//! ```text
//! depth + slope . (x, y) = height,    (x, y, depth) = t + r R e_z
//! ```
//!
//! `(x, y, depth)` is the point that the laser meets in a frame, from the camera of the reference: `t` is the
//! displacement that the frame's pose has, `R` its attitude, `r` the range.
//!
//! A point that is far off the plane lies on something else and is left out. Things stand on the ground, and the ground
//! is never above them: so a plane that some beams have met is replaced by a deeper one as soon as [`PROOF`] beams
//! agree on it, and by a higher one never, however long the laser rests on a roof or on the crown of a tree.
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

/// Beams off the plane that must agree with each other to be the ground: half a second of frames.
pub const PROOF: u32 = 8;

/// Part of the plane that laser points never tell, as variances of height (m^2) and slopes: features lie elsewhere.
const LEAST: [f64; 3] = [0.04, 1e-4, 1e-4];

/// Height and slopes with their covariance.
#[derive(Debug, Clone, Copy)]
struct Plane {
    mean: Vector3<f64>,
    covariance: Matrix3<f64>,
    /// Beams that met it.
    beams: u32,
}

/// A point that the laser has met.
#[derive(Debug, Clone, Copy)]
struct Point {
    /// `1, -x, -y`: what a plane's height and slopes give the depth by.
    row: Vector3<f64>,
    depth: f64,
    /// Of the depth about a plane, m^2.
    variance: f64,
}

impl Plane {
    /// Level, through one point.
    fn level(height: f64, variance: f64) -> Self {
        let covariance = Matrix3::from_diagonal(&Vector3::new(variance, SLOPE * SLOPE, SLOPE * SLOPE));
        Self { mean: Vector3::new(height, 0.0, 0.0), covariance, beams: 1 }
    }

    /// How far the point is below it, m.
    fn off(&self, point: &Point) -> f64 {
        point.depth - point.row.dot(&self.mean)
    }

    /// Variance of that, m^2.
    fn spread(&self, point: &Point) -> f64 {
        point.row.dot(&(self.covariance * point.row)) + point.variance
    }

    /// How far the point is below it, in standard deviations.
    fn below(&self, point: &Point) -> f64 {
        self.off(point) / self.spread(point).sqrt()
    }

    fn meet(&mut self, point: &Point) {
        let gain = self.covariance * point.row / self.spread(point);
        self.mean += gain * self.off(point);
        self.covariance -= gain * (point.row.transpose() * self.covariance);
        self.covariance = (self.covariance + self.covariance.transpose()) * 0.5;
        self.beams += 1;
    }

    /// The same plane below the camera of a frame.
    fn moved(&self, pose: &Pose) -> Self {
        let by = Matrix3::new(1.0, -pose.displacement.x, -pose.displacement.y, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
        let mean = by * self.mean - Vector3::x() * pose.descent;
        Self { mean, covariance: by * self.covariance * by.transpose(), ..*self }
    }
}

/// The plane below a reference.
#[derive(Debug, Clone, Copy)]
pub struct GroundPlane {
    plane: Plane,
    /// What the last beams off the plane agree on.
    rival: Option<Plane>,
}

/// What a beam, or a frame, has told of the ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Told {
    /// The plane as before, better known or not.
    Same,
    /// The plane was not the ground; another one is.
    Another,
}

impl GroundPlane {
    /// What the laser tells with the reference itself.
    pub fn new(sight: &Sight) -> Self {
        Self::about(sight.view.height(), sight.errors.level.hypot(ROUGHNESS))
    }

    /// Known to a standard error, m.
    pub fn about(height: f64, error: f64) -> Self {
        Self { plane: Plane::level(height, error * error), rival: None }
    }

    /// With what the laser meets in a frame of a pose.
    pub fn meet(&mut self, pose: &Pose, range: f64, error: f64) -> Told {
        let beam = pose.current.attitude.rotation().column(2) * range;
        let (x, y) = (pose.displacement.x + beam.x, pose.displacement.y + beam.y);
        let variance = error * error + ROUGHNESS * ROUGHNESS;
        let point = Point { row: Vector3::new(1.0, -x, -y), depth: pose.descent + beam.z, variance };
        let below = self.plane.below(&point);
        if below.abs() <= GATE {
            self.plane.meet(&point);
            return Told::Same;
        }
        // A thing on the ground, unless the plane is no more than a single reading.
        if below < 0.0 && self.plane.beams >= FEW {
            return Told::Same;
        }
        let mut rival = match self.rival {
            Some(rival) if rival.below(&point).abs() <= GATE => rival,
            _ => {
                self.rival = Some(Plane::level(point.depth, variance));
                return Told::Same;
            }
        };
        rival.meet(&point);
        if rival.beams < PROOF {
            self.rival = Some(rival);
            return Told::Same;
        }
        *self = Self { plane: rival, rival: None };
        Told::Another
    }

    /// The same plane below the camera of a frame.
    pub fn moved(&self, pose: &Pose) -> Self {
        Self { plane: self.plane.moved(pose), rival: self.rival.map(|rival| rival.moved(pose)) }
    }

    /// Height over it, m.
    pub fn height(&self) -> f64 {
        self.plane.mean.x
    }

    /// What the fit is told.
    pub fn terrain(&self) -> Terrain {
        let least = Matrix3::from_diagonal(&Vector3::from(LEAST));
        let [height, along_x, along_y] = self.plane.mean.into();
        Terrain {
            height,
            slope: Vector2::new(along_x, along_y),
            covariance: self.plane.covariance + least,
            measured: self.plane.beams >= FEW,
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

    /// The ground as beams of some poses tell it, each over a height that the number of the beam gives.
    fn told(first: f64, beams: std::ops::Range<u32>, height: impl Fn(u32) -> f64) -> GroundPlane {
        let mut ground = plane(first);
        for number in beams {
            let pose = pose(number);
            ground.meet(&pose, range(&pose, height(number), Vector2::zeros()), SENSORS.range);
        }
        ground
    }

    fn assert_level_at(ground: &GroundPlane, height: f64) {
        assert!((ground.height() - height).abs() < 0.1 && ground.terrain().slope.norm() < 0.01, "{ground:?}");
    }

    #[test]
    fn roofs_are_not_ground() {
        assert_level_at(&told(50.0, 1..200, |i| if i % 30 < 10 { 38.0 } else { 50.0 }), 50.0);
        // However long the beam rests on one.
        assert_level_at(&told(50.0, 1..1000, |i| if i < 20 { 50.0 } else { 38.0 }), 50.0);
    }

    /// The reference was captured over a roof or a tree, and few beams pass it.
    #[test]
    fn what_is_deeper_is_the_ground() {
        assert_level_at(&told(38.0, 1..100, |_| 50.0), 50.0);
        assert_level_at(&told(44.0, 1..400, |i| if i % 12 == 0 { 50.0 } else { 44.0 }), 50.0);
    }

    /// The reading of the reference itself was false, and too long.
    #[test]
    fn a_single_reading_is_no_proof() {
        assert_level_at(&told(70.0, 1..100, |_| 50.0), 50.0);
    }

    /// False readings, too long, agree on nothing.
    #[test]
    fn what_no_beams_agree_on_is_not_the_ground() {
        let far = |i: u32| 60.0 + f64::from(i * 7 % 40);
        assert_level_at(&told(50.0, 1..500, |i| if i % 5 == 0 { far(i) } else { 50.0 }), 50.0);
    }

    /// The crown of a tree is no plane: what is learnt of it is of no use for the ground.
    #[test]
    fn another_ground_is_told() {
        let mut ground = plane(44.0);
        let told: Vec<Told> =
            (1..=PROOF).map(pose).map(|pose| ground.meet(&pose, range(&pose, 50.0, Vector2::zeros()), 0.1)).collect();
        assert_eq!(told.iter().position(|told| *told == Told::Another), Some(PROOF as usize - 1));
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
