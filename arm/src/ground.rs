//! The ground plane below the reference, estimated from laser ranges by recursive least squares.
//!
//! ```text
//! depth + slope . (x, y) = height,    (x, y, depth) = t + r R e_z
//! ```
//!
//! `(x, y, depth)` is the point that the laser hits in a frame, relative to the camera of the reference: `t` is the
//! displacement of the frame's pose, `R` its attitude, `r` the range. All lengths are in metres; depth is positive
//! downwards.
//!
//! A point whose residual is outside [`GATE_SIGMAS`] is an outlier. Buildings and trees stand on the ground, and the
//! ground is never above them. So a plane that several points agree with is replaced by a deeper one as soon as
//! [`CANDIDATE_POINTS`] points agree on that, and never by a higher one, however long the laser points at a roof or at
//! the crown of a tree.
//!
//! The laser is needed because two pictures of a slope, one taken a metre lower, differ as if the camera had moved by
//! the slope times a metre. Ranges at different tilts separate slope from motion.

use hoverlock_reference::motion::observation::{Observation, TerrainPrior};
use hoverlock_reference::motion::pose::Pose;
use nalgebra::{Matrix3, Vector2, Vector3};

/// Standard deviation of the ground about the plane, m. An assumption for meadows and fields.
const ROUGHNESS_M: f64 = 0.3;

/// Prior standard deviation of each slope, m/m: 6 degrees.
const PRIOR_SLOPE_SIGMA: f64 = 0.1;

/// Largest residual of an inlier, in standard deviations.
const GATE_SIGMAS: f64 = 3.0;

/// Points from which on the slopes count as measured: a plane has three unknowns.
const MIN_MEASURED_POINTS: u32 = 4;

/// Points that must agree on a candidate plane before it replaces the present one: half a second of frames.
const CANDIDATE_POINTS: u32 = 8;

/// Variances of height (m^2) and of both slopes that are added to the plane's covariance: the features of a frame are
/// elsewhere on the ground than the laser points.
const UNSAMPLED_VARIANCES: [f64; 3] = [0.04, 1e-4, 1e-4];

/// The state of the estimator: height and slopes with their covariance.
#[derive(Debug, Clone, Copy)]
struct PlaneEstimate {
    mean: Vector3<f64>,
    covariance: Matrix3<f64>,
    /// Laser points that were used.
    points: u32,
}

/// A point on the ground that the laser has hit, as a measurement of the plane.
#[derive(Debug, Clone, Copy)]
struct LaserPoint {
    /// Row of the measurement matrix, `(1, -x, -y)`: times height and slopes it is the expected depth.
    row: Vector3<f64>,
    depth: f64,
    /// Variance of the depth about the plane, m^2: laser noise and roughness.
    variance: f64,
}

impl PlaneEstimate {
    /// Creates a level plane through one point; `variance` of the height in m^2.
    fn level(height: f64, variance: f64) -> Self {
        let slope_variance = PRIOR_SLOPE_SIGMA * PRIOR_SLOPE_SIGMA;
        let covariance = Matrix3::from_diagonal(&Vector3::new(variance, slope_variance, slope_variance));
        Self { mean: Vector3::new(height, 0.0, 0.0), covariance, points: 1 }
    }

    /// Returns the depth of the point below the plane, m.
    fn residual(&self, point: &LaserPoint) -> f64 {
        point.depth - point.row.dot(&self.mean)
    }

    /// Returns the variance of the residual, m^2.
    fn residual_variance(&self, point: &LaserPoint) -> f64 {
        point.row.dot(&(self.covariance * point.row)) + point.variance
    }

    /// Returns the residual in standard deviations, positive below the plane.
    fn normalized_residual(&self, point: &LaserPoint) -> f64 {
        self.residual(point) / self.residual_variance(point).sqrt()
    }

    /// Updates the plane with an inlier.
    fn update(&mut self, point: &LaserPoint) {
        let gain = self.covariance * point.row / self.residual_variance(point);
        self.mean += gain * self.residual(point);
        self.covariance -= gain * (point.row.transpose() * self.covariance);
        self.covariance = (self.covariance + self.covariance.transpose()) * 0.5;
        self.points += 1;
    }

    /// Returns the same plane relative to the camera of a frame.
    fn moved(&self, pose: &Pose) -> Self {
        let by = Matrix3::new(1.0, -pose.displacement.x, -pose.displacement.y, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
        let mean = by * self.mean - Vector3::x() * pose.descent;
        Self { mean, covariance: by * self.covariance * by.transpose(), ..*self }
    }
}

/// The estimated ground plane below a reference, and a candidate to replace it.
#[derive(Debug, Clone, Copy)]
pub struct GroundPlane {
    plane: PlaneEstimate,
    /// The plane on which the latest outliers agree.
    candidate: Option<PlaneEstimate>,
}

/// The effect of a measurement on the ground plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlaneUpdate {
    /// The plane is the same, possibly refined.
    Unchanged,
    /// Another plane has taken its place. What was derived from the old one is invalid.
    Replaced,
}

impl GroundPlane {
    /// Creates a level plane at the height that the reference's own laser reading gives.
    pub fn new(sight: &Observation) -> Self {
        Self::level(sight.view.height(), sight.errors.plane_height.hypot(ROUGHNESS_M))
    }

    /// Creates a level plane at `height` below the camera, with a standard error, both in m.
    pub fn level(height: f64, error: f64) -> Self {
        Self { plane: PlaneEstimate::level(height, error * error), candidate: None }
    }

    /// Updates the plane with the laser range of a frame and its standard error, both in m. Returns `Replaced` if a
    /// deeper plane has taken its place.
    pub fn update(&mut self, pose: &Pose, range: f64, error: f64) -> PlaneUpdate {
        let beam = pose.current.attitude.rotation().column(2) * range;
        let (x, y) = (pose.displacement.x + beam.x, pose.displacement.y + beam.y);
        let variance = error * error + ROUGHNESS_M * ROUGHNESS_M;
        let point = LaserPoint { row: Vector3::new(1.0, -x, -y), depth: pose.descent + beam.z, variance };
        let residual = self.plane.normalized_residual(&point);
        if residual.abs() <= GATE_SIGMAS {
            self.plane.update(&point);
            return PlaneUpdate::Unchanged;
        }
        // A point above the plane is on a building or a tree, unless the plane itself rests on a single reading.
        if residual < 0.0 && self.plane.points >= MIN_MEASURED_POINTS {
            return PlaneUpdate::Unchanged;
        }
        let mut candidate = match self.candidate {
            Some(candidate) if candidate.normalized_residual(&point).abs() <= GATE_SIGMAS => candidate,
            _ => {
                self.candidate = Some(PlaneEstimate::level(point.depth, variance));
                return PlaneUpdate::Unchanged;
            }
        };
        candidate.update(&point);
        if candidate.points < CANDIDATE_POINTS {
            self.candidate = Some(candidate);
            return PlaneUpdate::Unchanged;
        }
        *self = Self { plane: candidate, candidate: None };
        PlaneUpdate::Replaced
    }

    /// Returns the same plane relative to the camera of a frame.
    pub fn moved(&self, pose: &Pose) -> Self {
        Self { plane: self.plane.moved(pose), candidate: self.candidate.map(|candidate| candidate.moved(pose)) }
    }

    /// Height of the reference's camera over the plane, vertically, m.
    pub fn height(&self) -> f64 {
        self.plane.mean.x
    }

    /// Returns the plane as a prior for the pose fit.
    pub fn terrain(&self) -> TerrainPrior {
        let unsampled = Matrix3::from_diagonal(&Vector3::from(UNSAMPLED_VARIANCES));
        let [height, along_x, along_y] = self.plane.mean.into();
        TerrainPrior {
            height,
            slope: Vector2::new(along_x, along_y),
            covariance: self.plane.covariance + unsampled,
            slope_is_measured: self.plane.points >= MIN_MEASURED_POINTS,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_reference::motion::observation::{FittedView, SensorErrors};
    use hoverlock_reference::motion::orthophoto::{Attitude, Camera, View};
    use nalgebra::Matrix2;

    const SENSORS: SensorErrors = SensorErrors { tilt: 0.0035, heading: 0.01, range: 0.1 };

    fn pose(number: u32) -> Pose {
        let phase = f64::from(number) * 0.4;
        let attitude = Attitude { roll: 0.08 * phase.sin(), pitch: 0.08 * (1.3 * phase).cos(), yaw: 0.0 };
        let found = FittedView { attitude, height: 50.0, tilt: 1e-3, heading: 1e-3 };
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

    /// Returns the range from a pose to the plane `depth + slope . (x, y) = height`, m.
    fn range(pose: &Pose, height: f64, slope: Vector2<f64>) -> f64 {
        let axis = pose.current.attitude.rotation().column(2).into_owned();
        (height - pose.descent - slope.dot(&pose.displacement)) / (axis.z + slope.dot(&axis.xy()))
    }

    fn plane(first: f64) -> GroundPlane {
        let camera = Camera::with_field_of_view(1024, 768, 0.87).unwrap();
        let view = View::new(camera, Attitude::default(), first).unwrap();
        GroundPlane::new(&Observation { view, errors: SENSORS.into() })
    }

    /// Ranges at different tilts determine height and slope; the covariance bounds the error.
    #[test]
    fn a_slope_is_estimated() {
        let (mut ground, slope) = (plane(50.0), Vector2::new(0.2, -0.1));
        for pose in (1..200).map(pose) {
            ground.update(&pose, range(&pose, 50.0, slope), SENSORS.range);
        }
        let terrain = ground.terrain();
        assert!((terrain.height - 50.0).abs() < 0.05 && (terrain.slope - slope).norm() < 0.01, "{terrain:?}");
        assert!(terrain.covariance[(1, 1)].sqrt() < 0.02);
    }

    /// Returns the estimate after laser points at the given poses; `height` is that of the ground at each point, m.
    fn after_points(first: f64, points: std::ops::Range<u32>, height: impl Fn(u32) -> f64) -> GroundPlane {
        let mut ground = plane(first);
        for number in points {
            let pose = pose(number);
            ground.update(&pose, range(&pose, height(number), Vector2::zeros()), SENSORS.range);
        }
        ground
    }

    fn assert_level_at(ground: &GroundPlane, height: f64) {
        assert!((ground.height() - height).abs() < 0.1 && ground.terrain().slope.norm() < 0.01, "{ground:?}");
    }

    #[test]
    fn roofs_do_not_change_the_plane() {
        assert_level_at(&after_points(50.0, 1..200, |i| if i % 30 < 10 { 38.0 } else { 50.0 }), 50.0);
        // However long the laser points at one.
        assert_level_at(&after_points(50.0, 1..1000, |i| if i < 20 { 50.0 } else { 38.0 }), 50.0);
    }

    /// The reference was captured over a roof or a tree, and few laser points pass it.
    #[test]
    fn a_deeper_plane_replaces_the_first() {
        assert_level_at(&after_points(38.0, 1..100, |_| 50.0), 50.0);
        assert_level_at(&after_points(44.0, 1..400, |i| if i % 12 == 0 { 50.0 } else { 44.0 }), 50.0);
    }

    /// The range of the reference itself was wrong, and too long.
    #[test]
    fn a_plane_from_one_reading_can_be_replaced_by_a_higher_one() {
        assert_level_at(&after_points(70.0, 1..100, |_| 50.0), 50.0);
    }

    /// Wrong ranges, too long, that do not agree with each other.
    #[test]
    fn scattered_outliers_replace_nothing() {
        let far = |i: u32| 60.0 + f64::from(i * 7 % 40);
        assert_level_at(&after_points(50.0, 1..500, |i| if i % 5 == 0 { far(i) } else { 50.0 }), 50.0);
    }

    #[test]
    fn the_last_of_the_candidate_points_reports_the_replacement() {
        let mut ground = plane(44.0);
        let mut update = |pose| ground.update(&pose, range(&pose, 50.0, Vector2::zeros()), 0.1);
        let updates: Vec<PlaneUpdate> = (1..=CANDIDATE_POINTS).map(pose).map(&mut update).collect();
        let replaced = updates.iter().position(|update| *update == PlaneUpdate::Replaced);
        assert_eq!(replaced, Some(CANDIDATE_POINTS as usize - 1));
    }

    #[test]
    fn a_moved_plane_is_the_same_ground_below_another_camera() {
        let (mut ground, slope) = (plane(50.0), Vector2::new(0.2, -0.1));
        for pose in (1..200).map(pose) {
            ground.update(&pose, range(&pose, 50.0, slope), SENSORS.range);
        }
        let to = Pose { displacement: Vector2::new(10.0, 5.0), descent: 2.0, ..pose(3) };
        // 50 - 2 - 0.2 * 10 + 0.1 * 5
        let moved = ground.moved(&to);
        assert!((moved.height() - 46.5).abs() < 0.15, "{moved:?}");
        assert_eq!(moved.terrain().slope, ground.terrain().slope);
    }
}
