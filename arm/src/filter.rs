//! The state of the estimator and its covariance: an error-state Kalman filter with cloned keyframe poses.
//!
//! | rows | state | error |
//! |---|---|---|
//! | 0..3 | position `p` in the level frame, m; the mean ground is `z = 0`, down is positive | `p - p^` |
//! | 3..6 | velocity `v`, m/s | `v - v^` |
//! | 6..9 | rotation `R`, camera to level frame | `t` in `R = exp(t) R^`, rad |
//! | 9..12, 12..15 | bias of the gyroscopes, rad/s, and of the accelerometers, m/s^2 | difference |
//! | 15..18 | wander `w` of the attitude reading, `R_read = exp(w) R` | difference |
//! | 18 | radial distortion `k1` of the lens, normalised coordinates | difference |
//! | 19 | read-out time `T` from the first row to the last, s | difference |
//! | 20 | relative error `e` of the stated focal length | difference |
//! | 21..23 | slope of the mean ground along both axes of the level frame, `z = slope . (x, y)` | difference |
//! | 23 + 6 k | position and rotation of the camera in keyframe `k` | as above |
//!
//! ```text
//! dp/dt = v,    dv/dt = R (f - b_a) + g,    dR/dt = R [w - b_g]
//! ```
//!
//! **Errors of the camera.** A direction with normalised coordinates `u` is seen at `c + f (1 + e) u (1 + k1 |u|^2)`.
//! Row `y` of `n` is exposed `T y / (n - 1)` after the time stamp, at the pose that velocity and angular velocity
//! predict. Two frames from one pose have the same errors, so only motion makes the errors observable.
//!
//! **Heights are considered, not estimated** (Schmidt 1966): each cell of a grid on the ground has a height with the
//! standard deviation `min(10 m, 0.2 h)` that no measurement reduces. The filter keeps its correlation with the state,
//! so that the same unknown height does not average out over frames. In `y = (pose, keyframe pose, errors of the
//! camera, heights of the cells in view)` all sightings of a frame have an information matrix `L` and vector `n`, and
//!
//! ```text
//! M = P_xy (I + L P_yy)^-1,    dx = M n,    P_xx -= M L P_yx,    P_xh -= M L P_yh,    P_hh unchanged
//! ```
//!
//! **Heights are eliminated** before a system is solved, as each has its own prior and none is seen with another: with
//! `L = [A B; B^T D]`, `P_yy = [P C; C^T s^2]`, `n = (n_1, n_2)` and the diagonal `E = I + s^2 D`
//!
//! ```text
//! F = B E^-1 C^T,    A' = A - s^2 B E^-1 B^T,    P' = P - C D E^-1 C^T,    K = [I + F, A'; -P', (I + F)^T]
//! K (z, u) = (n_1 - s^2 B E^-1 n_2, C E^-1 n_2)                          u: change of poses and errors
//! K (-t, w) = (-B E^-1 p_2, p_1 - C D E^-1 p_2)                          p: covariance of a state with y
//! v = E^-1 (p_2 - C^T t - s^2 B^T w),    (w, v) = M^T,    (t, B^T w + D v) = (M L)^T
//! ```
//!
//! Nothing here allocates after [`Filter::new`].

use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reference::motion::orthophoto::{Attitude, Camera};
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Matrix6, SMatrix, Vector2, Vector3, Vector6};

/// Keyframes at most.
pub const MAX_KEYFRAMES: usize = 8;
/// States of the vehicle, which move.
const VEHICLE: usize = 18;
/// All states but those of keyframes.
const CORE: usize = VEHICLE + COMMON;
/// States of a keyframe.
const POSE: usize = 6;
/// All states.
const STATES: usize = CORE + POSE * MAX_KEYFRAMES;
/// States that the images of a keyframe's landmarks depend on: two poses, the errors of the camera, and the slope.
const PAIR: usize = 2 * POSE + COMMON;
/// Unknowns of the system of an update.
const SYSTEM: usize = 2 * PAIR;
/// Errors of the camera.
const ERRORS: usize = 3;
/// Errors of the camera, and the slope of the ground.
const COMMON: usize = ERRORS + 2;
/// Cells of the grid along each axis.
const GRID_SIDE: usize = 24;
/// Cells of the grid.
const CELLS: usize = GRID_SIDE * GRID_SIDE;
/// Cells that the sightings of one frame may touch; sightings of further cells are not used.
const MAX_TOUCHED_CELLS: usize = 96;
/// Cells across the first picture's columns: 6 m from 50 m with the wide view.
const CELLS_ACROSS: f64 = 8.0;

const POSITION: usize = 0;
const VELOCITY: usize = 3;
const ROTATION: usize = 6;
const GYRO_BIAS: usize = 9;
const FORCE_BIAS: usize = 12;
const WANDER: usize = 15;
const CAMERA: usize = VEHICLE;
const SLOPE: usize = CAMERA + ERRORS;

/// Standard gravity, m/s^2.
const GRAVITY: f64 = 9.80665;
/// Largest standard deviation of the height of a cell over the mean ground, m: houses and trees, and hills.
const MAX_HEIGHT_SIGMA_M: f64 = 10.0;
/// The same, as a part of the height over the ground: a picture from nearby shows less of a hill.
const HEIGHT_SIGMA: f64 = 0.2;
/// The same without samples of the IMU: RANSAC has left out what is not on one plane.
const FREE_HEIGHT_SIGMA: f64 = 0.05;
/// Standard deviation of the slope of the mean ground: a row of houses along one side of a picture from 20 m is one.
const SLOPE_SIGMA: f64 = 0.15;
/// Standard error of the height over the mean ground from one laser reading, as a part of that of a cell.
const GROUND_SIGMA: f64 = 0.3;
/// Standard error of a laser reading as a measurement of the ground, as a part of the same. Neighbouring readings hit
/// the same hill, so it is larger than the roughness.
const LASER_SIGMA: f64 = 0.4;

/// White noise of the gyroscopes, rad/sqrt(s): a tactical-grade IMU in vibration. An assumption.
const GYRO_NOISE: f64 = 2e-4;
/// White noise of the accelerometers, m/s/sqrt(s). An assumption.
const FORCE_NOISE: f64 = 1e-2;
/// Standard error of the bias of a gyroscope at the start, rad/s.
const GYRO_BIAS_SIGMA: f64 = 1e-3;
/// Standard error of the bias of an accelerometer at the start, m/s^2.
const FORCE_BIAS_SIGMA: f64 = 0.04;
/// Random walk of the bias of a gyroscope, rad/s/sqrt(s). It is wide enough to follow a bias that steps by 1e-3 rad/s
/// within seconds; a narrower one takes the step for a tilt, and the tilt for a displacement.
const GYRO_BIAS_WALK: f64 = 1e-4;
/// Random walk of the bias of an accelerometer, m/s^2/sqrt(s).
const FORCE_BIAS_WALK: f64 = 1e-3;
/// Time constant of the wander of the attitude reading, s.
const WANDER_TIME_S: f64 = 10.0;
/// Share of the variance of an attitude reading that is white.
const WHITE_ATTITUDE_SHARE: f64 = 0.25;
/// Age of an attitude reading, s. Its error in a turn is treated as noise.
const ATTITUDE_AGE_S: f64 = 0.01;
/// Standard deviations of the errors of a camera that nobody has calibrated: distortion of normalised coordinates,
/// read-out time (s) and relative error of the focal length. Assumptions.
const CAMERA_SIGMAS: [f64; ERRORS] = [0.05, 0.015, 0.01];
/// Standard deviation of the distortion without samples of the IMU: the camera is taken as calibrated. A distortion
/// `k1` moves pairs like a tilt of `3 k1 d / h`, and without the IMU nothing else says which of them it is.
const FREE_DISTORTION_SIGMA: f64 = 0.01;
/// States with their standard deviations without samples of the IMU. The ground is level then: a slope looks like tilt.
const FREE_SIGMAS: [(usize, f64); 3] = [(CAMERA, FREE_DISTORTION_SIGMA), (SLOPE, 0.0), (SLOPE + 1, 0.0)];
/// Newton's steps of the inverse of the lens: 1e-6 of the radius at a distortion of 10 %.
const LENS_STEPS: usize = 3;
/// Standard error of the velocity at the start, m/s.
const VELOCITY_SIGMA: f64 = 1.0;
/// Without samples of the IMU: velocity that the camera may have, m/s.
const FREE_VELOCITY: f64 = 30.0;
/// Without samples of the IMU: angular velocity that the camera may have, rad/s.
const FREE_RATE: f64 = 0.3;

/// Part of the information of a sighting that counts: errors of position persist over frames and neighbours.
const INFORMATION_SHARE: f64 = 1.0 / 16.0;
/// The same without samples of the IMU: each frame then has a new pose, and only the keyframe's errors persist.
const FREE_INFORMATION_SHARE: f64 = 1.0 / 4.0;
/// Iterations of an update near the prediction, and without samples of the IMU, where the prediction is far.
const ITERATIONS: [usize; 2] = [4, 8];
/// Sightings at most in an iteration, evenly chosen; the update itself has all.
const ITERATED_SIGHTINGS: usize = 128;
/// Work units of a sighting in an iteration.
const SIGHTING_WORK: usize = 40;
/// Work units of an iteration besides.
const ITERATION_WORK: usize = 40_000;
/// Scale of the Geman-McClure loss, in chi squared of two degrees of freedom.
const LOSS_CHI2: f64 = 4.0;

/// Chi squared (two degrees of freedom) up to which a sighting is an inlier; noise exceeds it once in 90.
const MAX_INLIER_CHI2: f64 = 9.0;
/// Chi squared (six degrees of freedom) up to which a change of the relative pose is possible for the vehicle: noise
/// exceeds it once in ten million.
const MAX_INNOVATION_CHI2: f64 = 43.0;

type Vehicle = SMatrix<f64, VEHICLE, VEHICLE>;

/// A sample of the IMU with its interval.
#[derive(Debug, Clone, Copy)]
pub struct Step {
    /// Angular velocity about the camera's axes, rad/s.
    pub rates: Vector3<f64>,
    /// Specific force along the camera's axes, m/s^2.
    pub force: Vector3<f64>,
    /// Duration, s.
    pub seconds: f64,
}

/// Position and rotation of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPose {
    /// In the level frame, m.
    pub position: Vector3<f64>,
    /// Camera to level frame.
    pub rotation: Matrix3<f64>,
}

/// A camera with its motion while it is read out.
#[derive(Debug, Clone, Copy)]
struct MovingCamera {
    pose: CameraPose,
    /// In the level frame, m/s.
    velocity: Vector3<f64>,
    /// About the camera's axes, rad/s.
    rates: Vector3<f64>,
}

impl MovingCamera {
    /// Returns the pose after `seconds`.
    fn after(&self, seconds: f64) -> CameraPose {
        // To first order: a read-out turns the camera by milliradians.
        CameraPose {
            position: self.pose.position + self.velocity * seconds,
            rotation: self.pose.rotation * (Matrix3::identity() + skew(&(self.rates * seconds))),
        }
    }
}

/// Errors of the camera, as in the [module](self).
#[derive(Debug, Clone, Copy, Default)]
struct CameraErrors {
    distortion: f64,
    readout_s: f64,
    focal: f64,
}

impl CameraErrors {
    /// Adds errors in the order of the states.
    fn add(&mut self, change: &Vector3<f64>) {
        self.distortion += change.x;
        self.readout_s += change.y;
        self.focal += change.z;
    }

    /// Returns the normalised coordinates at which a direction appears, and their derivative.
    fn distorted(&self, u: &Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
        let stretch = 1.0 + self.distortion * u.norm_squared();
        (u * stretch, Matrix2::identity() * stretch + u * u.transpose() * (2.0 * self.distortion))
    }

    /// Returns the normalised coordinates of the direction that appears at `seen`.
    fn straight(&self, seen: &Vector2<f64>) -> Vector2<f64> {
        let k = self.distortion * seen.norm_squared();
        let mut ratio = 1.0;
        for _ in 0..LENS_STEPS {
            // The bound keeps the result finite beyond the fold of a lens.
            let rate = (1.0 + 3.0 * k * ratio * ratio).max(0.1);
            ratio -= (ratio * (1.0 + k * ratio * ratio) - 1.0) / rate;
        }
        seen * ratio
    }
}

/// What the images of a keyframe's landmarks in the present frame depend on.
#[derive(Debug, Clone, Copy)]
struct PairState {
    then: MovingCamera,
    now: MovingCamera,
    errors: CameraErrors,
    slope: Vector2<f64>,
}

impl PairState {
    /// Returns the state changed by errors in the order of [`pair_states`].
    fn moved(&self, change: &[f64; PAIR]) -> Self {
        let three = |first: usize| Vector3::new(change[first], change[first + 1], change[first + 2]);
        let mut other = *self;
        for (camera, first) in [(&mut other.now, 0), (&mut other.then, POSE)] {
            camera.pose.position += three(first);
            camera.pose.rotation = exponential(&three(first + 3)) * camera.pose.rotation;
        }
        other.errors.add(&three(2 * POSE));
        other.slope += Vector2::new(change[PAIR - 2], change[PAIR - 1]);
        other
    }
}

/// A ground point of a keyframe in the present frame.
#[derive(Debug, Clone, Copy)]
pub struct Sighting {
    /// Index of the landmark in its keyframe.
    pub landmark: usize,
    /// Position in the keyframe, px.
    pub reference: Vector2<f64>,
    /// Position in the present frame, px.
    pub current: Vector2<f64>,
    /// Covariance of the difference of both positions, px^2.
    pub covariance: Matrix2<f64>,
    /// The sighting counts in the update; others are only judged by it.
    pub counts: bool,
    /// Chi squared of the residual after the update, two degrees of freedom; heights are considered.
    pub chi2: f64,
    /// Residual after the update, px.
    pub residual: Vector2<f64>,
}

impl Sighting {
    /// Returns `true` if the sighting counts and agrees with the fitted poses.
    pub fn is_inlier(&self) -> bool {
        self.counts && self.is_consistent()
    }

    /// Returns `true` if the sighting agrees with the fitted poses.
    pub fn is_consistent(&self) -> bool {
        self.chi2 <= MAX_INLIER_CHI2
    }
}

/// The result of an update by sightings.
#[derive(Debug, Clone, Copy)]
pub struct Fitted {
    /// Chi squared of the change of the relative pose over its predicted covariance; six degrees of freedom.
    pub innovation: f64,
    /// Sightings that agree.
    pub inliers: usize,
    /// The state was changed.
    pub is_applied: bool,
}

/// The predicted image of a landmark with its covariance.
#[derive(Debug, Clone, Copy)]
pub struct Prediction {
    /// Position, px.
    pub image: Vector2<f64>,
    /// Covariance from poses, errors of the camera and height, px^2.
    pub covariance: Matrix2<f64>,
}

/// The image of a landmark and its derivatives.
struct Projection {
    image: Vector2<f64>,
    /// By position and rotation of the present camera, and of the keyframe's.
    by_pose: [Matrix2x3<f64>; 4],
    /// By the errors of the camera.
    by_camera: Matrix2x3<f64>,
    by_slope: Matrix2<f64>,
    /// By the height of the cell.
    by_height: Vector2<f64>,
    cell: usize,
}

impl Projection {
    /// Returns the derivatives in the order of [`pair_states`].
    fn by_pair(&self) -> SMatrix<f64, 2, PAIR> {
        let mut by = SMatrix::<f64, 2, PAIR>::zeros();
        for (part, block) in self.by_pose.iter().chain([&self.by_camera]).enumerate() {
            by.fixed_view_mut::<2, 3>(0, 3 * part).copy_from(block);
        }
        by.fixed_view_mut::<2, 2>(0, PAIR - 2).copy_from(&self.by_slope);
        by
    }
}

/// The filter.
pub struct Filter {
    /// Pose of the camera now.
    pub pose: CameraPose,
    /// Velocity, m/s.
    pub velocity: Vector3<f64>,
    gyro_bias: Vector3<f64>,
    force_bias: Vector3<f64>,
    wander: Vector3<f64>,
    errors: CameraErrors,
    slope: Vector2<f64>,
    keyframes: [Option<MovingCamera>; MAX_KEYFRAMES],
    /// The last prediction had a sample of the IMU.
    has_rates: bool,
    /// The keyframe of the last frame if there were no samples of the IMU before it: the next one has its rates.
    without_rates: Option<usize>,
    /// Row-major, symmetric.
    covariance: Vec<f64>,
    /// Correlation of states and heights, `STATES` rows.
    cross: Vec<f64>,
    cell_m: f64,
    /// Standard deviation of the height of a cell, m.
    height_sigma: f64,
    /// The same where nothing is known of the relief, m.
    max_height_sigma: f64,
    /// Variances that are left out without samples of the IMU, in the order of [`FREE_SIGMAS`].
    withheld: [f64; FREE_SIGMAS.len()],
    /// Angular velocity of the last step, rad/s.
    rates: Vector3<f64>,
    /// The last prediction had no samples of the IMU.
    is_free: bool,
    scratch: Scratch,
}

/// A row for each touched cell, with an element for each state of a pair.
type CellRows = Vec<[f64; PAIR]>;

/// Memory of an update, with the letters of the [module](self).
struct Scratch {
    cells: Vec<usize>,
    /// Place of a cell in `cells`, or `usize::MAX`.
    place: Vec<usize>,
    /// `A`, upper triangle.
    poses: [[f64; PAIR]; PAIR],
    /// `B^T`.
    coupling: CellRows,
    /// `D`.
    heights: Vec<f64>,
    /// `n_1`.
    pose_vector: [f64; PAIR],
    /// `n_2`.
    height_vector: Vec<f64>,
    /// `C^T`.
    correlation: CellRows,
    /// `K`, row-major.
    system: Vec<f64>,
    /// Right-hand sides and solutions, a column for each state: `-t` above `w`.
    gain: Vec<f64>,
    /// `v`, a row for each touched cell.
    height_gain: Vec<f64>,
    /// `P_yx`, a row for each element of `y`.
    columns: Vec<f64>,
    /// `(M L)^T`, a row for each element of `y`.
    product: Vec<f64>,
}

fn skew(v: &Vector3<f64>) -> Matrix3<f64> {
    v.cross_matrix()
}

/// Returns the rotation by a vector, rad (Rodrigues).
pub fn exponential(v: &Vector3<f64>) -> Matrix3<f64> {
    let angle = v.norm();
    let k = skew(v);
    if angle < 1e-9 {
        return Matrix3::identity() + k;
    }
    let (sin, cos) = libm::sincos(angle);
    Matrix3::identity() + k * (sin / angle) + k * k * ((1.0 - cos) / (angle * angle))
}

/// Returns the vector of a small rotation, rad: exact to second order, which 0.1 rad needs.
fn logarithm(r: &Matrix3<f64>) -> Vector3<f64> {
    let v = Vector3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]) / 2.0;
    let sine = v.norm().min(1.0);
    if sine < 1e-6 { v } else { v * (libm::asin(sine) / sine) }
}

impl Filter {
    /// Allocates a filter. Its state is that of the next [`Filter::restart`].
    pub fn new() -> Self {
        let mut covariance = vec![0.0; STATES * STATES];
        for (error, sigma) in CAMERA_SIGMAS.iter().enumerate() {
            covariance[(CAMERA + error) * (STATES + 1)] = sigma * sigma;
        }
        Self {
            pose: CameraPose { position: Vector3::zeros(), rotation: Matrix3::identity() },
            velocity: Vector3::zeros(),
            gyro_bias: Vector3::zeros(),
            force_bias: Vector3::zeros(),
            wander: Vector3::zeros(),
            keyframes: [None; MAX_KEYFRAMES],
            has_rates: false,
            without_rates: None,
            errors: CameraErrors::default(),
            slope: Vector2::zeros(),
            covariance,
            cross: vec![0.0; STATES * CELLS],
            cell_m: 1.0,
            height_sigma: MAX_HEIGHT_SIGMA_M,
            max_height_sigma: MAX_HEIGHT_SIGMA_M,
            withheld: [0.0; FREE_SIGMAS.len()],
            rates: Vector3::zeros(),
            is_free: true,
            scratch: Scratch {
                cells: Vec::with_capacity(MAX_TOUCHED_CELLS),
                place: vec![usize::MAX; CELLS],
                poses: [[0.0; PAIR]; PAIR],
                coupling: Vec::with_capacity(MAX_TOUCHED_CELLS),
                heights: Vec::with_capacity(MAX_TOUCHED_CELLS),
                pose_vector: [0.0; PAIR],
                height_vector: Vec::with_capacity(MAX_TOUCHED_CELLS),
                correlation: Vec::with_capacity(MAX_TOUCHED_CELLS),
                system: vec![0.0; SYSTEM * SYSTEM],
                gain: vec![0.0; SYSTEM * STATES],
                height_gain: vec![0.0; MAX_TOUCHED_CELLS * STATES],
                columns: vec![0.0; (PAIR + MAX_TOUCHED_CELLS) * STATES],
                product: vec![0.0; (PAIR + MAX_TOUCHED_CELLS) * STATES],
            },
        }
    }

    /// Makes the present place the origin, `height` m over the ground, without keyframes. `width_m` is the ground that
    /// the picture spans. With `keep`, velocity, attitude and biases stay; otherwise the attitude is the reading.
    /// The errors of the camera stay in either case. Nothing stays of a state that is not sound.
    pub fn restart(&mut self, height: f64, attitude: &Attitude, sensors: &SensorErrors, width_m: f64, keep: bool) {
        let is_sound = self.is_sound();
        self.keyframes = [None; MAX_KEYFRAMES];
        self.cross.fill(0.0);
        self.cell_m = (width_m / CELLS_ACROSS).max(1e-3);
        self.pose.position = Vector3::new(0.0, 0.0, -height);
        self.max_height_sigma = MAX_HEIGHT_SIGMA_M.min(HEIGHT_SIGMA * height);
        self.height_sigma = self.max_height_sigma;
        self.slope = Vector2::zeros();
        self.withheld[1..].fill(0.0);
        let ground = (GROUND_SIGMA * self.max_height_sigma).hypot(sensors.range);
        if keep && is_sound {
            for row in 0..STATES {
                for column in 0..STATES {
                    if row.min(column) < VELOCITY || row.max(column) >= SLOPE {
                        self.covariance[row * STATES + column] = 0.0;
                    }
                }
            }
            self.covariance[2 * STATES + 2] = ground * ground;
            (SLOPE..CORE).for_each(|i| self.covariance[i * (STATES + 1)] = SLOPE_SIGMA * SLOPE_SIGMA);
            return;
        }
        self.pose.rotation = attitude.rotation();
        self.velocity = Vector3::zeros();
        (self.gyro_bias, self.force_bias, self.wander) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
        let of_camera = if is_sound {
            Matrix3::from_fn(|row, column| self.at(CAMERA + row, CAMERA + column))
        } else {
            (self.errors, self.withheld) = (CameraErrors::default(), [0.0; FREE_SIGMAS.len()]);
            Matrix3::from_diagonal(&Vector3::from(CAMERA_SIGMAS.map(|sigma| sigma * sigma)))
        };
        self.covariance.fill(0.0);
        let mut set = |row: usize, column: usize, value: f64| self.covariance[row * STATES + column] = value;
        set(2, 2, ground * ground);
        for (axis, reading) in attitude_errors(sensors).into_iter().enumerate() {
            let variance = reading * reading;
            set(VELOCITY + axis, VELOCITY + axis, VELOCITY_SIGMA * VELOCITY_SIGMA);
            set(ROTATION + axis, ROTATION + axis, variance * (1.0 + WHITE_ATTITUDE_SHARE));
            set(GYRO_BIAS + axis, GYRO_BIAS + axis, GYRO_BIAS_SIGMA * GYRO_BIAS_SIGMA);
            set(FORCE_BIAS + axis, FORCE_BIAS + axis, FORCE_BIAS_SIGMA * FORCE_BIAS_SIGMA);
            // The rotation is the reading, so its error is the opposite of the wander.
            set(WANDER + axis, WANDER + axis, variance);
            set(ROTATION + axis, WANDER + axis, -variance);
            set(WANDER + axis, ROTATION + axis, -variance);
            (0..ERRORS).for_each(|error| set(CAMERA + axis, CAMERA + error, of_camera[(axis, error)]));
        }
        (SLOPE..CORE).for_each(|i| set(i, i, SLOPE_SIGMA * SLOPE_SIGMA));
    }

    fn at(&self, row: usize, column: usize) -> f64 {
        self.covariance[row * STATES + column]
    }

    /// Predicts over samples of the IMU.
    pub fn predict(&mut self, steps: impl Iterator<Item = Step>, sensors: &SensorErrors) {
        let (mut transition, mut noise, mut slope_noise) = (Vehicle::identity(), Vehicle::zeros(), 0.0);
        self.set_free(false);
        self.has_rates = false;
        for step in steps {
            let h = step.seconds;
            let rates = step.rates - self.gyro_bias;
            if let Some(keyframe) = self.without_rates.take().and_then(|k| self.keyframes[k].as_mut()) {
                keyframe.rates = rates;
            }
            let force = self.pose.rotation * (step.force - self.force_bias);
            let acceleration = force + Vector3::new(0.0, 0.0, GRAVITY);
            let mut f = Vehicle::identity();
            f.fixed_view_mut::<3, 3>(POSITION, VELOCITY).copy_from(&(Matrix3::identity() * h));
            f.fixed_view_mut::<3, 3>(VELOCITY, ROTATION).copy_from(&(-skew(&force) * h));
            f.fixed_view_mut::<3, 3>(VELOCITY, FORCE_BIAS).copy_from(&(-self.pose.rotation * h));
            f.fixed_view_mut::<3, 3>(POSITION, FORCE_BIAS).copy_from(&(-self.pose.rotation * (h * h / 2.0)));
            f.fixed_view_mut::<3, 3>(ROTATION, GYRO_BIAS).copy_from(&(-self.pose.rotation * h));
            let decay = libm::exp(-h / WANDER_TIME_S);
            for axis in WANDER..CAMERA {
                f[(axis, axis)] = decay;
            }
            transition = f * transition;
            noise = f * noise * f.transpose();
            for (axis, reading) in attitude_errors(sensors).into_iter().enumerate() {
                noise[(VELOCITY + axis, VELOCITY + axis)] += FORCE_NOISE * FORCE_NOISE * h;
                noise[(ROTATION + axis, ROTATION + axis)] += GYRO_NOISE * GYRO_NOISE * h;
                noise[(GYRO_BIAS + axis, GYRO_BIAS + axis)] += GYRO_BIAS_WALK * GYRO_BIAS_WALK * h;
                noise[(FORCE_BIAS + axis, FORCE_BIAS + axis)] += FORCE_BIAS_WALK * FORCE_BIAS_WALK * h;
                noise[(WANDER + axis, WANDER + axis)] += reading * reading * (1.0 - decay * decay);
            }
            // Other ground has another slope.
            slope_noise += self.velocity.xy().norm() * h / (CELLS_ACROSS * self.cell_m);
            self.pose.position += self.velocity * h + acceleration * (h * h / 2.0);
            self.velocity += acceleration * h;
            self.pose.rotation *= exponential(&(rates * h));
            self.wander *= decay;
            (self.rates, self.has_rates) = (rates, true);
        }
        self.pose.rotation = orthonormal(&self.pose.rotation);
        self.propagate(&transition, &noise);
        let variance = SLOPE_SIGMA * SLOPE_SIGMA;
        for i in SLOPE..CORE {
            let walked = self.at(i, i) + variance * slope_noise;
            self.covariance[i * (STATES + 1)] = self.at(i, i).max(walked.min(variance));
        }
    }

    /// Changes the prior to that of frames with or without samples of the IMU.
    fn set_free(&mut self, is_free: bool) {
        let share = if is_free { FREE_HEIGHT_SIGMA / HEIGHT_SIGMA } else { 1.0 };
        self.set_height_sigma(self.max_height_sigma * share);
        for (index, (state, known)) in FREE_SIGMAS.into_iter().enumerate() {
            let sigma = self.at(state, state).max(0.0).sqrt();
            if is_free && sigma > known {
                let share = known / sigma;
                (0..STATES).for_each(|i| self.covariance[state * STATES + i] *= share);
                (0..STATES).for_each(|i| self.covariance[i * STATES + state] *= share);
                self.cross[state * CELLS..(state + 1) * CELLS].iter_mut().for_each(|value| *value *= share);
                self.withheld[index] += sigma * sigma - known * known;
            }
            if !is_free {
                self.covariance[state * (STATES + 1)] += std::mem::take(&mut self.withheld[index]);
            }
        }
        self.is_free = is_free;
    }

    /// Sets the standard deviation of heights. The correlation of the state with lower heights is lower in proportion;
    /// the covariance of the state stays.
    fn set_height_sigma(&mut self, sigma: f64) {
        if sigma < self.height_sigma {
            let share = sigma / self.height_sigma;
            self.cross.iter_mut().for_each(|value| *value *= share);
        }
        self.height_sigma = sigma;
    }

    /// Predicts without samples of the IMU: the camera may have moved and turned at any rate that is possible.
    pub fn predict_free(&mut self, seconds: f64) {
        let mut noise = Vehicle::zeros();
        self.set_free(true);
        (self.has_rates, self.without_rates) = (false, None);
        for axis in 0..3 {
            let [moved, turned] = [FREE_VELOCITY, FREE_RATE].map(|rate| rate * seconds);
            noise[(POSITION + axis, POSITION + axis)] = moved * moved;
            noise[(ROTATION + axis, ROTATION + axis)] = turned * turned;
        }
        let mut transition = Vehicle::identity();
        for axis in VELOCITY..ROTATION {
            transition[(axis, axis)] = 0.0;
            noise[(axis, axis)] = VELOCITY_SIGMA * VELOCITY_SIGMA;
        }
        self.velocity = Vector3::zeros();
        self.rates = Vector3::zeros();
        self.propagate(&transition, &noise);
    }

    fn propagate(&mut self, transition: &Vehicle, noise: &Vehicle) {
        let own = Vehicle::from_fn(|row, column| self.at(row, column));
        let own = transition * own * transition.transpose() + noise;
        for row in 0..VEHICLE {
            for column in 0..VEHICLE {
                self.covariance[row * STATES + column] = (own[(row, column)] + own[(column, row)]) / 2.0;
            }
        }
        let moved = |values: &mut [f64], stride: usize, column: usize| {
            let before: [f64; VEHICLE] = std::array::from_fn(|row| values[row * stride + column]);
            if before.iter().all(|value| *value == 0.0) {
                return;
            }
            for row in 0..VEHICLE {
                values[row * stride + column] = (0..VEHICLE).map(|k| transition[(row, k)] * before[k]).sum();
            }
        };
        for column in VEHICLE..STATES {
            moved(&mut self.covariance, STATES, column);
            for row in 0..VEHICLE {
                self.covariance[column * STATES + row] = self.covariance[row * STATES + column];
            }
        }
        for column in 0..CELLS {
            moved(&mut self.cross, CELLS, column);
        }
    }

    /// Updates by an attitude reading. One that contradicts the state is ignored.
    pub fn update_attitude(&mut self, attitude: &Attitude, sensors: &SensorErrors) {
        let turned = logarithm(&(attitude.rotation() * self.pose.rotation.transpose()));
        let innovation = turned - self.wander;
        let age = ATTITUDE_AGE_S * self.rates.norm();
        for (axis, reading) in attitude_errors(sensors).into_iter().enumerate() {
            let noise = WHITE_ATTITUDE_SHARE * reading * reading + age * age;
            self.update_scalar(&[(ROTATION + axis, 1.0), (WANDER + axis, 1.0)], None, innovation[axis], noise);
        }
    }

    /// Updates by the range (m) of the laser along the optical axis and its standard error.
    pub fn update_range(&mut self, range: f64, error: f64) {
        let axis = self.pose.rotation.column(2).into_owned();
        let normal = normal(&self.slope);
        let towards = normal.dot(&axis);
        if towards < 0.5 {
            return;
        }
        let expected = -normal.dot(&self.pose.position) / towards;
        let hit = self.pose.position + axis * expected;
        let cell = self.cell(&hit);
        let noise = (LASER_SIGMA * self.max_height_sigma).powi(2) + error * error;
        // Higher ground and a lower camera have a shorter range.
        let by = -1.0 / towards;
        let by_states = [(POSITION + 2, by), (SLOPE, -by * hit.x), (SLOPE + 1, -by * hit.y)];
        self.update_scalar(&by_states, Some((cell, by)), range - expected, noise);
    }

    /// Schmidt's update by one scalar with derivatives by some states and the height of a cell.
    fn update_scalar(&mut self, by: &[(usize, f64)], height: Option<(usize, f64)>, innovation: f64, noise: f64) {
        let height_variance = self.height_variance();
        let mut column = [0.0; STATES];
        for (row, value) in column.iter_mut().enumerate() {
            *value = by.iter().map(|(state, factor)| factor * self.at(row, *state)).sum::<f64>()
                + height.map_or(0.0, |(cell, factor)| factor * self.cross[row * CELLS + cell]);
        }
        let own: f64 = by.iter().map(|(state, factor)| factor * column[*state]).sum();
        let of_height = height.map_or(0.0, |(cell, factor)| {
            let cross: f64 = by.iter().map(|(state, k)| k * self.cross[state * CELLS + cell]).sum();
            factor * (cross + factor * height_variance)
        });
        let variance = own + of_height + noise;
        // Five standard deviations: not by chance.
        if innovation * innovation > 25.0 * variance {
            return;
        }
        let gain = column.map(|value| value / variance);
        for cell in 0..CELLS {
            let mut along: f64 = by.iter().map(|(state, factor)| factor * self.cross[state * CELLS + cell]).sum();
            if let Some((_, factor)) = height.filter(|(touched, _)| *touched == cell) {
                along += factor * height_variance;
            }
            if along != 0.0 {
                (0..STATES).for_each(|row| self.cross[row * CELLS + cell] -= gain[row] * along);
            }
        }
        for (row, gain) in self.covariance.chunks_exact_mut(STATES).zip(&gain) {
            row.iter_mut().zip(&column).for_each(|(value, other)| *value -= gain * other);
        }
        self.correct(&gain.map(|value| value * innovation));
    }

    /// Adds errors to all states.
    fn correct(&mut self, by: &[f64; STATES]) {
        let three = |first: usize| Vector3::new(by[first], by[first + 1], by[first + 2]);
        self.pose.position += three(POSITION);
        self.velocity += three(VELOCITY);
        self.pose.rotation = exponential(&three(ROTATION)) * self.pose.rotation;
        self.gyro_bias += three(GYRO_BIAS);
        self.force_bias += three(FORCE_BIAS);
        self.wander += three(WANDER);
        self.errors.add(&three(CAMERA));
        self.slope += Vector2::new(by[SLOPE], by[SLOPE + 1]);
        for (k, keyframe) in self.keyframes.iter_mut().enumerate() {
            if let Some(MovingCamera { pose, .. }) = keyframe {
                pose.position += three(CORE + POSE * k);
                pose.rotation = exponential(&three(CORE + POSE * k + 3)) * pose.rotation;
            }
        }
    }

    fn present(&self) -> MovingCamera {
        MovingCamera { pose: self.pose, velocity: self.velocity, rates: self.rates }
    }

    /// Makes the present pose keyframe `k`.
    pub fn clone_pose(&mut self, k: usize) {
        self.keyframes[k] = Some(self.present());
        self.without_rates = (!self.has_rates).then_some(k);
        let source = |i: usize| if i < 3 { POSITION + i } else { ROTATION + i - 3 };
        let first = CORE + POSE * k;
        for i in 0..POSE {
            for column in 0..STATES {
                self.covariance[(first + i) * STATES + column] = self.at(source(i), column);
            }
            self.cross.copy_within(source(i) * CELLS..(source(i) + 1) * CELLS, (first + i) * CELLS);
        }
        for i in 0..POSE {
            for row in 0..STATES {
                let value = if (first..first + POSE).contains(&row) {
                    self.at(source(row - first), source(i))
                } else {
                    self.at(row, source(i))
                };
                self.covariance[row * STATES + first + i] = value;
            }
        }
    }

    /// Returns `true` if the state is finite and no variance is negative beyond rounding.
    pub fn is_sound(&self) -> bool {
        let CameraErrors { distortion, readout_s, focal } = &self.errors;
        let vehicle = self.pose.position.iter().chain(&self.velocity).chain(&self.pose.rotation);
        let finite = vehicle.chain([distortion, readout_s, focal]).chain(&self.slope).all(|value| value.is_finite());
        finite && (0..CORE).all(|i| self.at(i, i) > -1e-9)
    }

    /// Returns the pose of a keyframe.
    pub fn keyframe(&self, k: usize) -> Option<&CameraPose> {
        self.keyframes[k].as_ref().map(|camera| &camera.pose)
    }

    /// Returns displacement (m) from a keyframe and its covariance.
    pub fn displacement(&self, k: usize) -> Option<(Vector3<f64>, Matrix3<f64>)> {
        let first = CORE + POSE * k;
        let covariance = Matrix3::from_fn(|i, j| {
            self.at(i, j) - self.at(i, first + j) - self.at(first + i, j) + self.at(first + i, first + j)
        });
        self.keyframe(k).map(|pose| (self.pose.position - pose.position, covariance))
    }

    /// Sets the height over the mean ground, m, where the laser of the first frame was wrong. Keyframes keep their
    /// height relative to the camera; the horizontal displacement so far is scaled, with its change as its error.
    pub fn scale_height(&mut self, height: f64) {
        let ratio = -height / self.pose.position.z;
        let change = height + self.pose.position.z;
        self.pose.position.z = -height;
        self.keyframes.iter_mut().flatten().for_each(|camera| camera.pose.position.z -= change);
        for axis in 0..2 {
            let moved = self.pose.position[axis] * ratio.abs();
            self.covariance[axis * STATES + axis] += moved * moved;
            self.pose.position[axis] *= ratio.abs();
        }
    }

    fn height_variance(&self) -> f64 {
        self.height_sigma * self.height_sigma
    }

    fn cell(&self, point: &Vector3<f64>) -> usize {
        let index = |value: f64| {
            let cell = (value / self.cell_m).floor() + GRID_SIDE as f64 / 2.0;
            cell.clamp(0.0, GRID_SIDE as f64 - 1.0) as usize
        };
        index(point.y) * GRID_SIDE + index(point.x)
    }

    /// Projects a pixel of a keyframe into the present camera; `None` if it is not seen.
    fn project(&self, state: &PairState, [from, to]: [&Camera; 2], pixel: &Vector2<f64>) -> Option<Projection> {
        let PairState { then, now, errors, slope } = state;
        let normal = normal(slope);
        // The time stamp is that of the first row.
        let part = |camera: &Camera, pixel: &Vector2<f64>| pixel.y / camera.last_pixel().y.max(1.0);
        let focals = [from, to].map(|camera| camera.focal() * (1.0 + errors.focal));
        let was_seen = (pixel - from.principal()) / focals[0];
        let u = errors.straight(&was_seen);
        let then_part = part(from, pixel);
        let read = then.after(errors.readout_s * then_part);
        let ray = read.rotation * u.push(1.0);
        let towards = normal.dot(&ray);
        if towards < 1e-3 {
            return None;
        }
        let s = -normal.dot(&read.position) / towards;
        let point = read.position + ray * s;
        let direction = |pose: &CameraPose| {
            let q = pose.rotation.transpose() * (point - pose.position);
            (q.z >= 1e-3 * s).then_some(q)
        };
        let image = |q: &Vector3<f64>| {
            let (seen, by) = errors.distorted(&(q.xy() / q.z));
            (seen, to.principal() + seen * focals[1], by)
        };
        // The row decides on the time; that of the pose at the time stamp is near enough.
        let now_part = part(to, &image(&direction(&now.pose)?).1);
        let pose = now.after(errors.readout_s * now_part);
        let q = direction(&pose)?;
        let (is_seen, image, by_straight) = image(&q);
        let f = focals[1] / q.z;
        let by_direction = by_straight * Matrix2x3::new(f, 0.0, -f * q.x / q.z, 0.0, f, -f * q.y / q.z);
        let a = by_direction * pose.rotation.transpose();
        let along = a * (Matrix3::identity() - ray * normal.transpose() / towards);
        let by_pose = [-a, a * skew(&(point - pose.position)), along, -along * skew(&ray) * s];
        let by_reference =
            (along * read.rotation * s).fixed_view::<2, 2>(0, 0) * errors.distorted(&u).1.try_inverse()?;
        let cubic = |u: &Vector2<f64>| u * u.norm_squared();
        let turning = |camera: &MovingCamera| camera.pose.rotation * camera.rates;
        let by_now = by_pose[0] * now.velocity + by_pose[1] * turning(now);
        let by_then = by_pose[2] * then.velocity + by_pose[3] * turning(then);
        let by_camera = Matrix2x3::from_columns(&[
            cubic(&(q.xy() / q.z)) * focals[1] - by_reference * cubic(&u),
            by_now * now_part + by_then * then_part,
            is_seen * to.focal() - by_reference * was_seen / (1.0 + errors.focal),
        ]);
        let by_height = -a * ray / towards;
        let by_slope = -by_height * point.xy().transpose();
        Some(Projection { image, by_pose, by_camera, by_slope, by_height, cell: self.cell(&point) })
    }

    /// Returns what the images of the landmarks of keyframe `k` depend on.
    fn pair_state(&self, k: usize) -> Option<PairState> {
        Some(PairState { then: self.keyframes[k]?, now: self.present(), errors: self.errors, slope: self.slope })
    }

    /// Returns the covariance of the poses of the present camera and keyframe `k`, and of the errors of the camera.
    fn pair_covariance(&self, k: usize) -> SMatrix<f64, PAIR, PAIR> {
        let states = pair_states(k);
        SMatrix::from_fn(|i, j| self.at(states[i], states[j]))
    }

    /// Predicts the images of pixels of keyframe `k`; `out` is called with the index of each that is seen.
    pub fn images(
        &self,
        k: usize,
        cameras: [&Camera; 2],
        pixels: impl Iterator<Item = Vector2<f64>>,
        mut out: impl FnMut(usize, Prediction),
    ) {
        let Some(state) = self.pair_state(k) else { return };
        let pair = self.pair_covariance(k);
        for (index, pixel) in pixels.enumerate() {
            if let Some(seen) = self.project(&state, cameras, &pixel) {
                let by = seen.by_pair();
                let g = seen.by_height * self.height_sigma;
                out(
                    index,
                    Prediction { image: seen.image, covariance: by * pair * by.transpose() + g * g.transpose() },
                );
            }
        }
    }

    /// Returns the number of states up to the last keyframe; the others have no covariance.
    fn active(&self) -> usize {
        CORE + POSE * self.keyframes.iter().rposition(Option::is_some).map_or(0, |last| last + 1)
    }

    fn iterations(&self) -> usize {
        ITERATIONS[usize::from(self.is_free)]
    }

    /// Returns the work units of [`Filter::update_sightings`] with a number of sightings.
    pub fn work(&self, sightings: usize) -> usize {
        self.iterations() * (ITERATION_WORK + SIGHTING_WORK * sightings.min(ITERATED_SIGHTINGS))
            + SIGHTING_WORK * sightings
    }

    /// Fits present pose, keyframe `k` and the errors of the camera to sightings: iterated, with Geman-McClure's loss.
    /// Residual and chi squared of each sighting are written into it. The change is applied if at least `min_inliers`
    /// sightings agree and its chi squared is possible. Returns `None` without sightings that count, or if the system
    /// is singular.
    pub fn update_sightings(
        &mut self,
        k: usize,
        cameras: [&Camera; 2],
        sightings: &mut [Sighting],
        min_inliers: usize,
    ) -> Option<Fitted> {
        let prior = self.pair_state(k)?;
        let mut change = [0.0; PAIR];
        let states = pair_states(k);
        for iteration in 0..self.iterations() {
            let chosen = sightings.len().div_ceil(ITERATED_SIGHTINGS).max(1);
            self.linearise(&prior.moved(&change), cameras, sightings, chosen, &change, iteration > 0)?;
            self.fill_system(&states);
            change = self.solve_change()?;
        }
        let innovation = self.innovation(k, &change)?;
        // The residuals at the solution.
        self.linearise(&prior.moved(&change), cameras, sightings, 1, &change, true)?;
        let inliers = sightings.iter().filter(|sighting| sighting.is_inlier()).count();
        let is_applied = innovation <= MAX_INNOVATION_CHI2 && inliers >= min_inliers;
        if is_applied {
            self.apply(&states)?;
        }
        Some(Fitted { innovation, inliers, is_applied })
    }

    /// Returns chi squared of a change of the relative pose.
    fn innovation(&self, k: usize, change: &[f64; PAIR]) -> Option<f64> {
        let relative = Vector6::from_fn(|i, _| change[i] - change[6 + i]);
        let pair = self.pair_covariance(k);
        let mut covariance =
            Matrix6::from_fn(|i, j| pair[(i, j)] - pair[(i, 6 + j)] - pair[(6 + i, j)] + pair[(6 + i, 6 + j)]);
        for i in 0..6 {
            // A centimetre, and a tenth of a milliradian: the errors of pictures that no prediction knows.
            covariance[(i, i)] += if i < 3 { 1e-4 } else { 1e-8 };
        }
        Some(relative.dot(&(covariance.try_inverse()? * relative)))
    }

    /// Fills information matrix and vector at a state that differs from the prediction by `change`, from one of
    /// `chosen` sightings with as many times the weight.
    fn linearise(
        &mut self,
        state: &PairState,
        cameras: [&Camera; 2],
        sightings: &mut [Sighting],
        chosen: usize,
        change: &[f64; PAIR],
        weighted: bool,
    ) -> Option<()> {
        for cell in self.scratch.cells.drain(..) {
            self.scratch.place[cell] = usize::MAX;
        }
        let Scratch { poses, coupling, heights, pose_vector, height_vector, .. } = &mut self.scratch;
        (*poses, *pose_vector) = ([[0.0; PAIR]; PAIR], [0.0; PAIR]);
        coupling.clear();
        heights.clear();
        height_vector.clear();
        let share = chosen as f64 * if self.is_free { FREE_INFORMATION_SHARE } else { INFORMATION_SHARE };
        let height_variance = self.height_variance();
        let mut any = false;
        for sighting in sightings.iter_mut().step_by(chosen) {
            let Some(seen) = self.project(state, cameras, &sighting.reference) else {
                sighting.chi2 = f64::INFINITY;
                continue;
            };
            let residual = sighting.current - seen.image;
            let g = seen.by_height;
            let spread = sighting.covariance + g * g.transpose() * height_variance;
            let chi2 = spread.try_inverse().map_or(f64::INFINITY, |inverse| residual.dot(&(inverse * residual)));
            (sighting.residual, sighting.chi2) = (residual, chi2);
            let Some(inverse) = sighting.covariance.try_inverse().filter(|_| sighting.counts && chi2.is_finite())
            else {
                continue;
            };
            let loss = LOSS_CHI2 / (LOSS_CHI2 + chi2);
            let weight = inverse * (share * if weighted { loss * loss } else { 1.0 });
            let Scratch { cells, place, poses, coupling, heights, pose_vector, height_vector, .. } = &mut self.scratch;
            if place[seen.cell] == usize::MAX {
                if cells.len() == MAX_TOUCHED_CELLS {
                    continue;
                }
                place[seen.cell] = cells.len();
                cells.push(seen.cell);
                coupling.push([0.0; PAIR]);
                heights.push(0.0);
                height_vector.push(0.0);
            }
            any = true;
            let height = place[seen.cell];
            let by = seen.by_pair();
            let target = residual + by * SMatrix::<f64, PAIR, 1>::from_column_slice(change);
            let weighted_by = weight * by;
            let (weighted_g, weighted_target) = (weight * g, weight * target);
            for (i, row) in poses.iter_mut().enumerate() {
                let column = by.column(i);
                for (j, value) in row.iter_mut().enumerate().skip(i) {
                    *value += column.dot(&weighted_by.column(j));
                }
                coupling[height][i] += column.dot(&weighted_g);
                pose_vector[i] += column.dot(&weighted_target);
            }
            heights[height] += g.dot(&weighted_g);
            height_vector[height] += g.dot(&weighted_target);
        }
        any.then_some(())
    }

    /// Fills `system` with `K`, and `correlation`.
    fn fill_system(&mut self, states: &[usize; PAIR]) {
        let variance = self.height_variance();
        let Self { covariance, cross, scratch, .. } = self;
        let Scratch { cells, poses, coupling, heights, correlation, system, .. } = scratch;
        correlation.clear();
        correlation.extend(cells.iter().map(|cell| states.map(|state| cross[state * CELLS + cell])));
        for i in 0..PAIR {
            for j in 0..PAIR {
                let unit = f64::from(u8::from(i == j));
                system[i * SYSTEM + j] = unit;
                system[i * SYSTEM + PAIR + j] = poses[i.min(j)][i.max(j)];
                system[(PAIR + i) * SYSTEM + j] = -covariance[states[i] * STATES + states[j]];
                system[(PAIR + i) * SYSTEM + PAIR + j] = unit;
            }
        }
        for ((b, c), d) in coupling.iter().zip(correlation).zip(heights) {
            let inverse = 1.0 / (1.0 + variance * *d);
            let is_correlated = c.iter().any(|value| *value != 0.0);
            for i in 0..PAIR {
                let [of_b, of_c] = [b[i] * inverse, c[i] * inverse];
                let row = &mut system[i * SYSTEM..(i + 1) * SYSTEM];
                row[PAIR..].iter_mut().zip(b).for_each(|(value, other)| *value -= variance * of_b * other);
                if is_correlated {
                    row[..PAIR].iter_mut().zip(&*c).for_each(|(value, other)| *value += of_b * other);
                    let row = &mut system[(PAIR + i) * SYSTEM..(PAIR + i + 1) * SYSTEM];
                    row[..PAIR].iter_mut().zip(&*c).for_each(|(value, other)| *value += *d * of_c * other);
                    row[PAIR..].iter_mut().zip(b).for_each(|(value, other)| *value += of_c * other);
                }
            }
        }
    }

    /// Returns `u`, the change of the states of the pair; destroys `system`.
    fn solve_change(&mut self) -> Option<[f64; PAIR]> {
        let variance = self.height_variance();
        let Scratch { coupling, heights, pose_vector, height_vector, correlation, system, gain, .. } =
            &mut self.scratch;
        let right = &mut gain[..SYSTEM];
        right[..PAIR].copy_from_slice(pose_vector);
        right[PAIR..].fill(0.0);
        for (((b, c), d), n) in coupling.iter().zip(correlation).zip(heights).zip(height_vector) {
            let scaled = *n / (1.0 + variance * *d);
            for i in 0..PAIR {
                right[i] -= variance * b[i] * scaled;
                right[PAIR + i] += c[i] * scaled;
            }
        }
        solve(system, right, SYSTEM, 1)?;
        Some(std::array::from_fn(|i| right[PAIR + i]))
    }

    /// Applies the update of the last linearisation to all states and their covariance.
    fn apply(&mut self, states: &[usize; PAIR]) -> Option<()> {
        self.fill_system(states);
        self.solve_gain(states)?;
        let active = self.active();
        let Self { covariance, cross, scratch, .. } = self;
        let Scratch { cells, place, gain, height_gain, columns, product, pose_vector, height_vector, .. } = scratch;
        let mut by = [0.0; STATES];
        let gains = gain[PAIR * STATES..].chunks_exact(STATES).zip(&*pose_vector);
        for (row, n) in gains.chain(height_gain.chunks_exact(STATES).zip(&*height_vector)) {
            by.iter_mut().zip(row).for_each(|(value, gain)| *value += gain * n);
        }
        let size = PAIR + cells.len();
        for row in 0..active {
            for column in 0..=row {
                let less: f64 = (0..size).map(|j| product[j * STATES + row] * columns[j * STATES + column]).sum();
                let value = covariance[row * STATES + column] - less;
                covariance[row * STATES + column] = value;
                covariance[column * STATES + row] = value;
            }
        }
        let variance = self.height_sigma * self.height_sigma;
        for cell in 0..CELLS {
            let touched = place[cell];
            // P_yh of this cell, before the update.
            let before: [f64; PAIR] = std::array::from_fn(|i| cross[states[i] * CELLS + cell]);
            if touched == usize::MAX && before.iter().all(|value| *value == 0.0) {
                continue;
            }
            for row in 0..active {
                let mut less: f64 = (0..PAIR).map(|j| product[j * STATES + row] * before[j]).sum();
                if touched != usize::MAX {
                    less += product[(PAIR + touched) * STATES + row] * variance;
                }
                cross[row * CELLS + cell] -= less;
            }
        }
        self.correct(&by);
        Some(())
    }

    /// Fills `columns`, `gain`, `height_gain` and `product` for all states; destroys `system`.
    fn solve_gain(&mut self, states: &[usize; PAIR]) -> Option<()> {
        let (variance, active) = (self.height_variance(), self.active());
        let Self { covariance, cross, scratch, .. } = self;
        let Scratch { cells, coupling, heights, correlation, system, gain, height_gain, columns, product, .. } =
            scratch;
        let (poses, rest) = columns.split_at_mut(PAIR * STATES);
        for (row, state) in poses.chunks_exact_mut(STATES).zip(states) {
            row.copy_from_slice(&covariance[state * STATES..(state + 1) * STATES]);
        }
        for (row, cell) in rest.chunks_exact_mut(STATES).zip(&*cells) {
            row.iter_mut().enumerate().for_each(|(state, value)| *value = cross[state * CELLS + cell]);
        }
        let add = |to: &mut [f64], factor: f64, from: &[f64]| {
            to.iter_mut().zip(from).take(active).for_each(|(value, other)| *value += factor * other);
        };
        let (above, below) = gain.split_at_mut(PAIR * STATES);
        above.fill(0.0);
        below.copy_from_slice(poses);
        for (place, p) in rest.chunks_exact(STATES).enumerate().take(cells.len()) {
            let inverse = 1.0 / (1.0 + variance * heights[place]);
            for i in 0..PAIR {
                add(&mut above[i * STATES..(i + 1) * STATES], -inverse * coupling[place][i], p);
                let factor = -inverse * heights[place] * correlation[place][i];
                add(&mut below[i * STATES..(i + 1) * STATES], factor, p);
            }
        }
        solve(system, gain, SYSTEM, STATES)?;
        let (above, below) = gain.split_at(PAIR * STATES);
        let (of_poses, of_heights) = product.split_at_mut(PAIR * STATES);
        of_poses.iter_mut().zip(above).for_each(|(value, solved)| *value = -solved);
        for (place, p) in rest.chunks_exact(STATES).enumerate().take(cells.len()) {
            let v = &mut height_gain[place * STATES..(place + 1) * STATES];
            let seen = &mut of_heights[place * STATES..(place + 1) * STATES];
            v.copy_from_slice(p);
            seen.fill(0.0);
            for i in 0..PAIR {
                let w = &below[i * STATES..(i + 1) * STATES];
                add(v, correlation[place][i], &above[i * STATES..(i + 1) * STATES]);
                add(seen, coupling[place][i], w);
            }
            let inverse = 1.0 / (1.0 + variance * heights[place]);
            for (v, seen) in v.iter_mut().zip(seen) {
                *v = inverse * (*v - variance * *seen);
                *seen += heights[place] * *v;
            }
        }
        Some(())
    }
}

/// Returns the rows of position and rotation of the present camera and of keyframe `k`, and of the camera's errors.
fn pair_states(k: usize) -> [usize; PAIR] {
    let first = CORE + POSE * k;
    std::array::from_fn(|i| match i {
        0..3 => POSITION + i,
        3..6 => ROTATION + i - 3,
        _ if i < 2 * POSE => first + i - POSE,
        _ => CAMERA + i - 2 * POSE,
    })
}

/// Returns the standard errors of an attitude reading about the axes of the level frame, rad.
fn attitude_errors(sensors: &SensorErrors) -> [f64; 3] {
    [sensors.tilt, sensors.tilt, sensors.heading]
}

/// Returns a normal of the ground with a slope, downwards.
fn normal(slope: &Vector2<f64>) -> Vector3<f64> {
    Vector3::new(-slope.x, -slope.y, 1.0)
}

/// Returns the rotation next to a matrix that rounding has disturbed.
fn orthonormal(r: &Matrix3<f64>) -> Matrix3<f64> {
    let x = r.column(0).normalize();
    let y = r.column(1) - x * x.dot(&r.column(1));
    let y = y.normalize();
    Matrix3::from_columns(&[x, y, x.cross(&y)])
}

/// Solves `A X = B` by elimination with row pivots: `a` is `size` x `size` and is destroyed, `b` has `columns` columns
/// and becomes `X`, both row-major. Returns `None` if `A` is singular.
fn solve(a: &mut [f64], b: &mut [f64], size: usize, columns: usize) -> Option<()> {
    for i in 0..size {
        let magnitude = |row: &usize| a[row * size + i].abs();
        let pivot = (i..size).max_by(|one, other| magnitude(one).total_cmp(&magnitude(other)))?;
        if magnitude(&pivot).is_nan() || magnitude(&pivot) < 1e-12 {
            return None;
        }
        if pivot != i {
            (0..size).for_each(|j| a.swap(i * size + j, pivot * size + j));
            (0..columns).for_each(|j| b.swap(i * columns + j, pivot * columns + j));
        }
        let (upper, lower) = a.split_at_mut((i + 1) * size);
        let (b_upper, b_lower) = b.split_at_mut((i + 1) * columns);
        let (row, b_row) = (&upper[i * size..], &b_upper[i * columns..]);
        for (other, b_other) in lower.chunks_exact_mut(size).zip(b_lower.chunks_exact_mut(columns)) {
            let factor = other[i] / row[i];
            if factor != 0.0 {
                (i..size).for_each(|j| other[j] -= factor * row[j]);
                b_other.iter_mut().zip(b_row).for_each(|(value, above)| *value -= factor * above);
            }
        }
    }
    for i in (0..size).rev() {
        let (upper, lower) = b.split_at_mut((i + 1) * columns);
        let row = &mut upper[i * columns..];
        for (j, below) in (i + 1..size).zip(lower.chunks_exact(columns)) {
            let factor = a[i * size + j];
            row.iter_mut().zip(below).for_each(|(value, other)| *value -= factor * other);
        }
        row.iter_mut().for_each(|value| *value /= a[i * size + i]);
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const SENSORS: SensorErrors = SensorErrors { tilt: 0.0035, heading: 0.01, range: 0.1 };

    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
    }

    fn camera() -> Camera {
        Camera::with_field_of_view(1024, 768, 0.87).unwrap()
    }

    fn started() -> Filter {
        let mut filter = Filter::new();
        filter.restart(50.0, &Attitude::default(), &SENSORS, 46.0, false);
        filter.clone_pose(0);
        filter
    }

    fn hovering(seconds: f64) -> impl Iterator<Item = Step> {
        let count = (seconds * 200.0).round() as usize;
        std::iter::repeat_n(
            Step { rates: Vector3::zeros(), force: Vector3::new(0.0, 0.0, -GRAVITY), seconds: 0.005 },
            count,
        )
    }

    /// Returns sightings of points on flat ground from a place `moved` m beside the keyframe, with noise of 0.3 px.
    fn sightings(filter: &Filter, moved: Vector3<f64>, errors: CameraErrors, rng: &mut ChaCha8Rng) -> Vec<Sighting> {
        let camera = camera();
        let mut state = filter.pair_state(0).unwrap();
        state.then.pose.rotation = Matrix3::identity();
        state.now.pose.position = state.then.pose.position + moved;
        state.now.pose.rotation = Matrix3::identity();
        state.errors = errors;
        (0..200)
            .map(|landmark| {
                let reference = Vector2::new(1023.0 * rng.random::<f64>(), 767.0 * rng.random::<f64>());
                let image = filter.project(&state, [&camera, &camera], &reference).unwrap().image;
                Sighting {
                    landmark,
                    reference,
                    current: image + 0.3 * Vector2::new(normal(rng), normal(rng)),
                    covariance: Matrix2::identity() * 0.09,
                    counts: true,
                    chi2: 0.0,
                    residual: Vector2::zeros(),
                }
            })
            .collect()
    }

    #[test]
    fn a_system_is_solved_with_pivots() {
        let mut a = [0.0, 2.0, 1.0, 1.0, 1.0, 0.0, 3.0, 0.0, 1.0];
        let mut b = [7.0, 3.0, 6.0];
        solve(&mut a, &mut b, 3, 1).unwrap();
        assert!(b.iter().zip([1.0, 2.0, 3.0]).all(|(found, expected)| (found - expected).abs() < 1e-12), "{b:?}");
        assert_eq!(solve(&mut [1.0, 2.0, 2.0, 4.0], &mut [1.0, 2.0], 2, 1), None);
    }

    /// The equations of the module without the elimination of heights, on dense matrices, after updates that correlate
    /// the state with heights.
    #[test]
    fn eliminated_heights_give_the_dense_update() {
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        let mut filter = started();
        let camera = camera();
        for step in 0..4 {
            filter.predict(hovering(0.1), &SENSORS);
            let moved = Vector3::new(0.1 * f64::from(step), -0.2, 0.3);
            let mut seen = sightings(&filter, moved, CameraErrors::default(), &mut rng);
            filter.update_sightings(0, [&camera, &camera], &mut seen, 8).unwrap();
        }
        filter.predict(hovering(0.1), &SENSORS);
        let mut seen = sightings(&filter, Vector3::new(1.0, 0.5, -0.5), CameraErrors::default(), &mut rng);
        let (prior, states) = (filter.pair_state(0).unwrap(), pair_states(0));
        filter.linearise(&prior, [&camera, &camera], &mut seen, 1, &[0.0; PAIR], false).unwrap();

        let Scratch { cells, poses, coupling, heights, pose_vector, height_vector, .. } = &filter.scratch;
        let size = PAIR + cells.len();
        assert!(cells.len() > 20);
        let information = DMatrix::from_fn(size, size, |i, j| match (i.min(j), i.max(j)) {
            (i, j) if j < PAIR => poses[i][j],
            (i, j) if i < PAIR => coupling[j - PAIR][i],
            (i, j) => f64::from(u8::from(i == j)) * heights[i - PAIR],
        });
        let vector = DVector::from_fn(size, |i, _| if i < PAIR { pose_vector[i] } else { height_vector[i - PAIR] });
        let with_y = DMatrix::from_fn(STATES, size, |x, j| match j {
            j if j < PAIR => filter.at(x, states[j]),
            j => filter.cross[x * CELLS + cells[j - PAIR]],
        });
        let of_y = DMatrix::from_fn(size, size, |i, j| match (i.min(j), i.max(j)) {
            (i, j) if i < PAIR => with_y[(states[i], j)],
            (i, j) => f64::from(u8::from(i == j)) * filter.height_variance(),
        });
        let inverse = (DMatrix::identity(size, size) + &information * of_y).try_inverse().unwrap();
        let gain = &with_y * inverse;
        let covariance = DMatrix::from_fn(STATES, STATES, |i, j| filter.at(i, j));
        let with_heights = DMatrix::from_row_slice(STATES, CELLS, &filter.cross);
        let of_heights = DMatrix::from_fn(size, CELLS, |i, cell| match i {
            i if i < PAIR => filter.cross[states[i] * CELLS + cell],
            i => f64::from(u8::from(cells[i - PAIR] == cell)) * filter.height_variance(),
        });
        let expected = covariance - &gain * &information * with_y.transpose();
        let expected_heights = with_heights - &gain * &information * of_heights;
        let moved = &gain * vector;

        filter.fill_system(&states);
        let change = filter.solve_change().unwrap();
        let before = filter.pose.position;
        filter.apply(&states).unwrap();
        let near = |found: f64, expected: f64, scale: f64| (found - expected).abs() <= 1e-7 * scale;
        for axis in 0..3 {
            assert!(near(change[axis], moved[axis], 1.0), "{change:?} {moved}");
            assert!(near(filter.pose.position[axis] - before[axis], moved[axis], 1.0));
        }
        let (largest, largest_height) = (expected.amax(), expected_heights.amax());
        for i in 0..STATES {
            (0..STATES).for_each(|j| assert!(near(filter.at(i, j), expected[(i, j)], largest), "{i} {j}"));
            for cell in 0..CELLS {
                assert!(
                    near(filter.cross[i * CELLS + cell], expected_heights[(i, cell)], largest_height),
                    "{i} {cell}"
                );
            }
        }
    }

    #[test]
    fn the_prediction_follows_force_and_rates() {
        let mut filter = started();
        let push = Step { rates: Vector3::z() * 0.5, force: Vector3::new(0.0, 0.0, -GRAVITY - 2.0), seconds: 0.005 };
        filter.predict(std::iter::repeat_n(push, 200), &SENSORS);
        // A second of 2 m/s^2 upwards: 1 m.
        assert!((filter.pose.position - Vector3::new(0.0, 0.0, -51.0)).norm() < 1e-9, "{}", filter.pose.position);
        assert!((filter.pose.rotation - exponential(&(Vector3::z() * 0.5))).norm() < 1e-9);
        assert!((logarithm(&filter.pose.rotation) - Vector3::z() * 0.5).norm() < 1e-9);
    }

    /// The first frame of a flight has no sample before it.
    #[test]
    fn a_keyframe_takes_its_rates_from_the_samples_before_or_after_it() {
        let turn = |rate: f64| Step { rates: Vector3::x() * rate, force: -Vector3::z() * GRAVITY, seconds: 0.005 };
        let mut filter = Filter::new();
        filter.predict(std::iter::empty(), &SENSORS);
        filter.restart(50.0, &Attitude::default(), &SENSORS, 46.0, false);
        filter.clone_pose(0);
        filter.predict([turn(0.1), turn(0.2)].into_iter(), &SENSORS);
        filter.clone_pose(1);
        filter.predict([turn(0.3)].into_iter(), &SENSORS);
        let rates = [0, 1].map(|k| filter.keyframes[k].unwrap().rates.x);
        assert_eq!(rates, [0.1, 0.2]);
        filter.predict_free(0.1);
        filter.clone_pose(1);
        filter.predict_free(0.1);
        filter.predict([turn(0.3)].into_iter(), &SENSORS);
        assert_eq!(filter.keyframes[1].unwrap().rates.x, 0.0);
    }

    /// Central differences agree with the derivatives of a projection.
    #[test]
    fn derivatives_are_those_of_the_projection() {
        let (filter, camera) = (started(), camera());
        let zoomed = Camera::with_field_of_view(1024, 768, 0.8).unwrap();
        let moving = |position: Vector3<f64>, turned: Vector3<f64>, velocity: Vector3<f64>| MovingCamera {
            pose: CameraPose { position, rotation: exponential(&turned) },
            velocity,
            rates: Vector3::new(0.05, -0.03, 0.04) * velocity.x,
        };
        let state = PairState {
            then: moving(Vector3::new(1.0, 2.0, -50.0), Vector3::new(0.02, 0.03, 0.4), Vector3::new(1.0, 2.0, 0.5)),
            now: moving(Vector3::new(3.0, 1.0, -48.0), Vector3::new(-0.03, 0.01, 0.5), Vector3::new(-2.0, 1.0, 0.3)),
            errors: CameraErrors { distortion: -0.09, readout_s: 0.005, focal: 0.02 },
            slope: Vector2::new(0.05, -0.1),
        };
        let pixel = Vector2::new(300.0, 600.0);
        let at = |change: &[f64; PAIR]| filter.project(&state.moved(change), [&camera, &zoomed], &pixel).unwrap();
        let exact = at(&[0.0; PAIR]).by_pair();
        for i in 0..PAIR {
            let [plus, minus] = [1e-5, -1e-5].map(|h| {
                let mut change = [0.0; PAIR];
                change[i] = h;
                at(&change).image
            });
            let numeric = (plus - minus) / 2e-5;
            let found = exact.column(i).into_owned();
            // The row at which the time is taken is not differentiated: 1e-3 here.
            assert!((numeric - found).norm() < 2e-3 * (1.0 + numeric.norm()), "{i}: {numeric} {found}");
        }
    }

    /// A pixel that the lens has moved comes back, and the sign of `k1` is that of pincushion.
    #[test]
    fn the_lens_is_inverted() {
        for distortion in [-0.09, 0.05] {
            let errors = CameraErrors { distortion, ..CameraErrors::default() };
            let straight = Vector2::new(0.46, -0.35);
            let seen = errors.distorted(&straight).0;
            assert!((seen.norm() > straight.norm()) == (distortion > 0.0));
            assert!((errors.straight(&seen) - straight).norm() < 1e-6, "{distortion}");
        }
    }

    /// Where the camera moves, its errors show, and their standard errors include what is left.
    #[test]
    fn the_errors_of_the_camera_are_estimated() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut filter = started();
        let errors = CameraErrors { distortion: -0.08, ..CameraErrors::default() };
        for frame in 0..120 {
            let place = Vector3::new(0.05 * f64::from(frame), 0.03 * f64::from(frame), 0.0);
            filter.predict(hovering(0.065), &SENSORS);
            filter.update_attitude(&Attitude::default(), &SENSORS);
            let mut seen = sightings(&filter, place, errors, &mut rng);
            filter.update_sightings(0, [&camera(), &camera()], &mut seen, 50).unwrap();
        }
        let sigma = filter.at(CAMERA, CAMERA).sqrt();
        let error = filter.errors.distortion - errors.distortion;
        assert!(sigma < 0.5 * CAMERA_SIGMAS[0] && error.abs() < 3.0 * sigma, "{error} {sigma}");
        let before = filter.errors.distortion;
        filter.restart(50.0, &Attitude::default(), &SENSORS, 46.0, false);
        assert_eq!((filter.errors.distortion, filter.at(CAMERA, CAMERA).sqrt()), (before, sigma));
        filter.errors.distortion = f64::NAN;
        filter.restart(50.0, &Attitude::default(), &SENSORS, 46.0, true);
        assert!(filter.is_sound() && filter.at(CAMERA, CAMERA).sqrt() == CAMERA_SIGMAS[0]);
    }

    /// A climb over a slope looks like a motion across it.
    #[test]
    fn a_climb_over_a_slope_does_not_mislead() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut filter = started();
        let (slope, mut place) = (Vector2::new(0.2, -0.1), Vector3::zeros());
        for _ in 0..60 {
            place.z -= 0.05;
            filter.predict(hovering(0.065), &SENSORS);
            filter.update_attitude(&Attitude::default(), &SENSORS);
            let believed = std::mem::replace(&mut filter.slope, slope);
            let mut seen = sightings(&filter, place, CameraErrors::default(), &mut rng);
            filter.slope = believed;
            filter.update_sightings(0, [&camera(), &camera()], &mut seen, 50).unwrap();
        }
        let (moved, covariance) = filter.displacement(0).unwrap();
        for axis in 0..2 {
            let (error, sigma) = (moved[axis], covariance[(axis, axis)].sqrt());
            assert!(error.abs() < 3.0 * sigma && error.abs() < 0.1, "{error} {sigma}");
            let (error, sigma) = (filter.slope[axis] - slope[axis], filter.at(SLOPE + axis, SLOPE + axis).sqrt());
            assert!(error.abs() < 3.0 * sigma && sigma < 0.9 * SLOPE_SIGMA, "{error} {sigma}");
        }
    }

    /// Without samples of the IMU camera and ground are taken as better known, until samples come again.
    #[test]
    fn without_samples_the_camera_is_calibrated_and_the_ground_is_flat() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut filter = started();
        let place = Vector3::new(4.0, 0.0, 0.0);
        filter.predict_free(0.066);
        assert!((filter.at(CAMERA, CAMERA).sqrt() - FREE_DISTORTION_SIGMA).abs() < 1e-12);
        assert_eq!(filter.height_sigma, 50.0 * FREE_HEIGHT_SIGMA);
        let mut seen = sightings(&filter, place, CameraErrors::default(), &mut rng);
        assert!(filter.update_sightings(0, [&camera(), &camera()], &mut seen, 50).unwrap().is_applied);
        let (known, moved) = (filter.at(CAMERA, CAMERA), filter.displacement(0).unwrap().1[(0, 0)]);
        let correlation = filter.cross.iter().map(|value| value.abs()).fold(0.0, f64::max);
        filter.predict(hovering(0.005), &SENSORS);
        let withheld = CAMERA_SIGMAS[0].powi(2) - FREE_DISTORTION_SIGMA.powi(2);
        assert!((filter.at(CAMERA, CAMERA) - known - withheld).abs() < 1e-12);
        assert_eq!(filter.height_sigma, MAX_HEIGHT_SIGMA_M);
        filter.predict_free(1e-6);
        let reduced = filter.cross.iter().map(|value| value.abs()).fold(0.0, f64::max);
        assert!((reduced / correlation - FREE_HEIGHT_SIGMA / HEIGHT_SIGMA).abs() < 1e-3, "{reduced} {correlation}");
        assert!(filter.at(CAMERA, CAMERA).sqrt() < FREE_DISTORTION_SIGMA + 1e-12 && filter.is_sound());
        assert!(filter.displacement(0).unwrap().1[(0, 0)] >= moved);
    }

    /// The first sightings of a hover have independent errors, of which a sixteenth counts: the squared error is well
    /// below its covariance. Readings have their stated errors.
    #[test]
    fn the_covariance_includes_the_error() {
        let (mut sum, runs) = (0.0, 40);
        for seed in 0..runs {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut filter = started();
            let mut tilt = || SENSORS.tilt * normal(&mut rng);
            let reading = Attitude { roll: tilt(), pitch: tilt(), yaw: 0.0 };
            filter.restart(50.0, &reading, &SENSORS, 46.0, false);
            filter.clone_pose(0);
            let place = Vector3::new(0.3, -0.2, 0.1);
            for _ in 0..10 {
                filter.predict_free(0.066);
                filter.update_attitude(&reading, &SENSORS);
                let mut seen = sightings(&filter, place, CameraErrors::default(), &mut rng);
                assert!(filter.update_sightings(0, [&camera(), &camera()], &mut seen, 50).unwrap().is_applied);
            }
            let (found, covariance) = filter.displacement(0).unwrap();
            let error = (found - place).xy();
            let covariance = covariance.fixed_view::<2, 2>(0, 0).into_owned();
            sum += error.dot(&(covariance.try_inverse().unwrap() * error));
            assert!(error.norm() < 0.15, "{error}");
        }
        let nees = sum / runs as f64;
        assert!((0.01..4.0).contains(&nees), "{nees}");
    }

    /// What a helicopter cannot do in a fifteenth of a second is not accepted, and coasting widens what is.
    #[test]
    fn an_impossible_jump_is_refused_and_coasting_grows_the_covariance() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut filter = started();
        for _ in 0..15 {
            filter.predict(hovering(0.065), &SENSORS);
            let mut seen = sightings(&filter, Vector3::zeros(), CameraErrors::default(), &mut rng);
            assert!(filter.update_sightings(0, [&camera(), &camera()], &mut seen, 50).unwrap().is_applied);
        }
        let sigma = |filter: &Filter| filter.displacement(0).unwrap().1[(0, 0)].sqrt();
        let before = (filter.pose, sigma(&filter));
        let mut seen = sightings(&filter, Vector3::new(1.0, 0.0, 0.0), CameraErrors::default(), &mut rng);
        let jump = filter.update_sightings(0, [&camera(), &camera()], &mut seen, 8).unwrap();
        assert!(!jump.is_applied && filter.pose == before.0, "{jump:?}");
        filter.predict(hovering(2.0), &SENSORS);
        assert!(sigma(&filter) > 2.0 * before.1, "{} {}", sigma(&filter), before.1);
    }

    /// With considered heights, frames from one place 2 m aside never bring the error below that of the heights.
    #[test]
    fn heights_do_not_average_out() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let mut filter = started();
        let place = Vector3::new(2.0, 0.0, 0.0);
        let mut sigmas = Vec::new();
        for _ in 0..60 {
            filter.predict_free(0.066);
            filter.update_attitude(&Attitude::default(), &SENSORS);
            let mut seen = sightings(&filter, place, CameraErrors::default(), &mut rng);
            filter.update_sightings(0, [&camera(), &camera()], &mut seen, 8).unwrap();
            sigmas.push(filter.displacement(0).unwrap().1[(0, 0)].sqrt());
        }
        // 10 m in each of about 48 cells, at 2 m from 50 m.
        let of_heights = 2.0 / 50.0 * MAX_HEIGHT_SIGMA_M / 48f64.sqrt();
        assert!(sigmas[59] > 0.5 * of_heights && filter.is_sound(), "{} {of_heights}", sigmas[59]);
    }
}
