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
//! | 21 | delay `D` of the exposure of the first row after the time stamp, by the clock of the IMU, s | difference |
//! | 22..24 | slope of the mean ground along both axes of the level frame, `z = slope . (x, y)` | difference |
//! | 24 + 6 k | position and rotation of the camera in keyframe `k` | as above |
//!
//! ```text
//! dp/dt = v,    dv/dt = R (f - b_a) + g,    dR/dt = R [w - b_g]
//! ```
//!
//! **Errors of the camera.** A direction with normalised coordinates `u` is seen at `c + f (1 + e) u (1 + k1 |u|^2)`.
//! Row `y` of `n` is exposed `D + T y / (n - 1)` after the time stamp, at the pose that velocity and angular velocity
//! predict. Two frames from one pose have the same errors, so only motion makes the errors observable. A millisecond of
//! `D` is a third of a pixel in the narrow view of a helicopter that turns by 3 degrees a second.
//!
//! **Heights are considered, not estimated** (Schmidt 1966): each cell of a grid on the ground, an eighth of the
//! picture wide, has a height with the standard deviation `min(10 m, 0.2 h)` that no measurement reduces. The filter
//! keeps its correlation with the state, so that the same unknown height does not average out over frames. In
//! `y = (pose, keyframe pose, errors of the camera, heights of the cells in view)` all sightings of a frame have an
//! information matrix `L` and vector `n`, and
//!
//! ```text
//! M = P_xy (I + L P_yy)^-1,    dx = M n,    P_xx -= M L P_yx,    P_xh -= M L P_yh,    P_hh unchanged
//! ```
//!
//! **The slope is corrected in part** (partial update, Brink 2017). Errors of the pixels persist over frames, so that
//! what does not move seems better known with every frame. With the part `k_s` that a state keeps, `k` of the slope, 1
//! of a height, and 0 of all others,
//!
//! ```text
//! dx_s (1 - k_s),    P_st = k_s k_t P_st before + (1 - k_s k_t) P_st after
//! ```
//!
//! **Patches alone.** Without samples of the IMU, and with a calibrated camera, a frame is fitted to patches that were
//! refined on the frames, a few hundredths of a pixel each. Such a fit has no memory: keyframe, ground and camera err
//! alike in all frames, so only the present pose is corrected, and all of the information counts. The ground is even at
//! first. If fewer than four in ten patches agree, their residuals decide how rough it is: half of the variance of the
//! relief is common to a cell, half is a landmark's own ([`hoverlock_reference::motion::relief`]).
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
//! | module | its one job |
//! |---|---|
//! | `grid` | the cells of the ground |
//! | `inconsistency` | by how much innovations and residuals contradict the covariance |
//! | `information` | the sum of the information of sightings |
//! | `linear` | linear systems, and products of tall matrices |
//! | `prediction` | where landmarks are expected in the present frame |
//! | `projection` | the image of a landmark in the present frame, with its derivatives |
//! | `readings` | the updates by attitude and laser |
//! | `rotation` | small rotations as vectors |
//! | `sightings` | the update by sightings of landmarks |
//! | `sparse` | products with a transition, most of whose elements are 0 |
//! | `step` | samples of the IMU with their intervals |
//!
//! Nothing here allocates after [`Filter::new`].

mod grid;
mod inconsistency;
mod information;
mod linear;
mod prediction;
mod projection;
mod readings;
mod rotation;
mod sightings;
mod sparse;
mod step;

use crate::calibration::Calibration;
use grid::{CELLS, Grid};
use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reference::motion::orthophoto::Attitude;
use hoverlock_reference::motion::relief::ReliefSums;
pub use inconsistency::Inconsistency;
use nalgebra::{Matrix3, SMatrix, SVector, Vector2, Vector3};
pub use prediction::Prediction;
use projection::{CameraErrors, MovingCamera, PairState};
use rotation::{exponential, orthonormal, skew};
use sightings::Scratch;
pub use sightings::{INFORMATION_SHARE, Sighting};
use sparse::{SparseRows, transposed};
pub use step::Step;

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
/// Errors of the camera.
const ERRORS: usize = 4;
/// Errors of the camera, and the slope of the ground.
const COMMON: usize = ERRORS + 2;

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
/// The same of even ground, which patches alone are fitted to first.
const EVEN_HEIGHT_SIGMA: f64 = 0.001;
/// Standard deviation of the slope of the mean ground: a row of houses along one side of a picture from 20 m is one.
const SLOPE_SIGMA: f64 = 0.15;
/// Part of its error that the slope keeps in an update by sightings.
const KEPT_SLOPE: f64 = 0.87;
/// Standard error of the height over the mean ground from one laser reading, as a part of that of a cell.
const GROUND_SIGMA: f64 = 0.3;

/// White noise of the gyroscopes, rad/sqrt(s): a tactical-grade IMU in vibration. An assumption.
const GYRO_NOISE: f64 = 2e-4;
/// White noise of the accelerometers, m/s/sqrt(s). An assumption.
const FORCE_NOISE: f64 = 1e-2;
/// Random walk of the bias of a gyroscope, rad/s/sqrt(s). A step of the bias is seen in the motion of the picture.
const GYRO_BIAS_WALK: f64 = 3e-5;
/// Random walk of the bias of an accelerometer, m/s^2/sqrt(s).
const FORCE_BIAS_WALK: f64 = 1e-3;
/// Normalised innovation squared (NIS) above which samples of the IMU contradict pictures. With a 16th of the
/// information its expectation is 6/16; the mean over a second was at most 0.5 in flights without a fault.
const CONSISTENT_NIS: f64 = 0.6;
/// NIS above which errors grow: that of most flights is below. Up to [`CONSISTENT_NIS`] their variance grows with its
/// cube, as a bias of the IMU that has stepped is learnt in part; beyond it in proportion.
const USUAL_NIS: f64 = 0.3;
/// NIS of the motion of the picture above which biases walk faster. What is wrong with a perspective does not raise it;
/// decision 070 has the errors with other limits.
const CONSISTENT_MOTION_NIS: f64 = 0.3;
/// Largest factor of the variance with which biases walk.
const MAX_WALK_FACTOR: f64 = 9e4;
/// Time constant of the wander of the attitude reading, s.
const WANDER_TIME_S: f64 = 10.0;
/// Share of the variance of an attitude reading that is white.
const WHITE_ATTITUDE_SHARE: f64 = 0.25;
/// Age of an attitude reading, s. Its error in a turn is treated as noise.
const ATTITUDE_AGE_S: f64 = 0.01;
/// Standard error of the delay of the exposure at the start, s: the middle of a long exposure, or a time stamp that is
/// late by a few milliseconds.
const DELAY_SIGMA_S: f64 = 0.005;
/// Largest standard deviation of the distortion without samples of the IMU. A distortion `k1` moves pairs like a tilt
/// of `3 k1 d / h`, and without the IMU only a calibration says which of them it is.
const FREE_DISTORTION_SIGMA: f64 = 0.01;
/// Longest read-out time with which patches alone are fitted, s.
const MAX_FREE_READOUT_S: f64 = 0.001;
/// States with their standard deviations without samples of the IMU. The ground is level then: a slope looks like tilt.
const FREE_SIGMAS: [(usize, f64); 3] = [(CAMERA, FREE_DISTORTION_SIGMA), (SLOPE, 0.0), (SLOPE + 1, 0.0)];
/// Standard error of the velocity at the start, m/s.
const VELOCITY_SIGMA: f64 = 1.0;
/// Without samples of the IMU: velocity that the camera may have, m/s.
const FREE_VELOCITY: f64 = 30.0;
/// Without samples of the IMU: angular velocity that the camera may have, rad/s.
const FREE_RATE: f64 = 0.3;

/// Work units of a prediction, and of the updates by attitude and laser, without cells.
pub const PREDICTION_WORK: usize = 30_000;
/// Work units of a cell in them.
pub const CELL_PREDICTION_WORK: usize = 300;

type Vehicle = SMatrix<f64, VEHICLE, VEHICLE>;
/// The same, row by row.
type Rows = [[f64; VEHICLE]; VEHICLE];

/// Position and rotation of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPose {
    /// In the level frame, m.
    pub position: Vector3<f64>,
    /// Camera to level frame.
    pub rotation: Matrix3<f64>,
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
    calibration: Calibration,
    /// Rotation from the camera to the inertial sensor; `None` if they are aligned.
    boresight: Option<Matrix3<f64>>,
    /// The last prediction had a sample of the IMU.
    has_rates: bool,
    /// The keyframe of the last frame if there were no samples of the IMU before it: the next one has its rates.
    without_rates: Option<usize>,
    /// Row-major, symmetric.
    covariance: Vec<f64>,
    /// Correlation of states and heights, `STATES` rows.
    cross: Vec<f64>,
    grid: Grid,
    /// Standard deviation of the height of a cell, m.
    height_sigma: f64,
    /// The last fit was one to patches alone, without samples of the IMU.
    by_patches: bool,
    /// It took the ground as rough.
    is_rough: bool,
    /// What the residuals of the last linearisation say of the relief.
    relief: ReliefSums,
    /// Mean chi squared of the patches over its expectation, at least 1.
    excess: f64,
    /// The same where nothing is known of the relief, m.
    max_height_sigma: f64,
    /// Variances that are left out without samples of the IMU, in the order of [`FREE_SIGMAS`].
    withheld: [f64; FREE_SIGMAS.len()],
    /// Angular velocity of the last step, rad/s.
    rates: Vector3<f64>,
    /// The last prediction had no samples of the IMU.
    is_free: bool,
    /// Running NIS of the sightings, and its largest value, which decays.
    nis: [f64; 2],
    /// Running NIS of the motion of the picture.
    motion_nis: f64,
    /// Running mean square of what residuals of a block of the picture have in common, px^2.
    common: f64,
    scratch: Scratch,
}

impl Filter {
    /// Allocates a filter. Its state is that of the next [`Filter::restart`].
    pub fn new() -> Self {
        let mut filter = Self {
            pose: CameraPose { position: Vector3::zeros(), rotation: Matrix3::identity() },
            velocity: Vector3::zeros(),
            gyro_bias: Vector3::zeros(),
            force_bias: Vector3::zeros(),
            wander: Vector3::zeros(),
            keyframes: [None; MAX_KEYFRAMES],
            has_rates: false,
            without_rates: None,
            calibration: Calibration::default(),
            boresight: None,
            errors: CameraErrors::default(),
            slope: Vector2::zeros(),
            covariance: vec![0.0; STATES * STATES],
            cross: vec![0.0; STATES * CELLS],
            grid: Grid::new(),
            height_sigma: MAX_HEIGHT_SIGMA_M,
            by_patches: false,
            is_rough: false,
            relief: ReliefSums::default(),
            excess: 1.0,
            max_height_sigma: MAX_HEIGHT_SIGMA_M,
            withheld: [0.0; FREE_SIGMAS.len()],
            rates: Vector3::zeros(),
            is_free: true,
            nis: [0.0; 2],
            motion_nis: 0.0,
            common: 0.0,
            scratch: Scratch::new(),
        };
        filter.calibrate(&Calibration::default());
        filter
    }

    /// Gives the errors of the camera the values and standard errors of a calibration. Biases have its values from the
    /// next [`Filter::restart`] on.
    pub fn calibrate(&mut self, calibration: &Calibration) {
        (self.calibration, self.boresight) = (*calibration, calibration.boresight());
        self.errors = CameraErrors::of(calibration);
        self.withheld = [0.0; FREE_SIGMAS.len()];
        let Calibration { k1, readout_s, focal, .. } = calibration;
        for (state, sigma) in (CAMERA..SLOPE).zip([k1.sigma, readout_s.sigma, focal.sigma, DELAY_SIGMA_S]) {
            (0..STATES).for_each(|i| self.covariance[state * STATES + i] = 0.0);
            (0..STATES).for_each(|i| self.covariance[i * STATES + state] = 0.0);
            self.cross[state * CELLS..(state + 1) * CELLS].fill(0.0);
            self.covariance[state * (STATES + 1)] = sigma * sigma;
        }
    }

    /// Makes the present place the origin, `height` m over the ground, without keyframes. `width_m` is the ground that
    /// the picture spans. With `keep`, velocity, attitude and biases stay; otherwise the attitude is the reading.
    /// The errors of the camera stay in either case. Nothing stays of a state that is not sound.
    pub fn restart(&mut self, height: f64, attitude: &Attitude, sensors: &SensorErrors, width_m: f64, keep: bool) {
        let is_sound = self.is_sound();
        self.keyframes = [None; MAX_KEYFRAMES];
        self.restart_grid(width_m);
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
        let [(gyro_bias, gyro_sigma), (force_bias, force_sigma)] = self.calibration.biases();
        (self.gyro_bias, self.force_bias, self.wander) = (gyro_bias, force_bias, Vector3::zeros());
        if !is_sound {
            let calibration = self.calibration;
            self.calibrate(&calibration);
        }
        let of_camera = SMatrix::<f64, ERRORS, ERRORS>::from_fn(|row, column| self.at(CAMERA + row, CAMERA + column));
        self.covariance.fill(0.0);
        let mut set = |row: usize, column: usize, value: f64| self.covariance[row * STATES + column] = value;
        set(2, 2, ground * ground);
        for (axis, reading) in attitude_errors(sensors).into_iter().enumerate() {
            let variance = reading * reading;
            set(VELOCITY + axis, VELOCITY + axis, VELOCITY_SIGMA * VELOCITY_SIGMA);
            set(ROTATION + axis, ROTATION + axis, variance * (1.0 + WHITE_ATTITUDE_SHARE));
            set(GYRO_BIAS + axis, GYRO_BIAS + axis, gyro_sigma * gyro_sigma);
            set(FORCE_BIAS + axis, FORCE_BIAS + axis, force_sigma * force_sigma);
            // The rotation is the reading, so its error is the opposite of the wander.
            set(WANDER + axis, WANDER + axis, variance);
            set(ROTATION + axis, WANDER + axis, -variance);
            set(WANDER + axis, ROTATION + axis, -variance);
        }
        for error in 0..ERRORS {
            (0..ERRORS).for_each(|other| set(CAMERA + error, CAMERA + other, of_camera[(error, other)]));
        }
        (SLOPE..CORE).for_each(|i| set(i, i, SLOPE_SIGMA * SLOPE_SIGMA));
    }

    fn at(&self, row: usize, column: usize) -> f64 {
        self.covariance[row * STATES + column]
    }

    /// Predicts over samples of the IMU.
    pub fn predict(&mut self, steps: impl Iterator<Item = Step>, sensors: &SensorErrors) {
        let mut transition: Rows = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
        let (mut noise, mut slope_noise) = ([[0.0; VEHICLE]; VEHICLE], 0.0);
        self.set_free(false);
        let walk = self.walk_factor();
        self.has_rates = false;
        for step in steps {
            let step = self.boresight.map_or(step, |boresight| step.turned(&boresight));
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
            let f = SparseRows::of(&f);
            transition = f.times(&transition);
            noise = transposed(&f.times(&transposed(&f.times(&noise))));
            for (axis, reading) in attitude_errors(sensors).into_iter().enumerate() {
                noise[VELOCITY + axis][VELOCITY + axis] += FORCE_NOISE * FORCE_NOISE * h;
                noise[ROTATION + axis][ROTATION + axis] += GYRO_NOISE * GYRO_NOISE * h;
                noise[GYRO_BIAS + axis][GYRO_BIAS + axis] += GYRO_BIAS_WALK * GYRO_BIAS_WALK * h * walk;
                noise[FORCE_BIAS + axis][FORCE_BIAS + axis] += FORCE_BIAS_WALK * FORCE_BIAS_WALK * h * walk;
                noise[WANDER + axis][WANDER + axis] += reading * reading * (1.0 - decay * decay);
            }
            // Other ground has another slope.
            slope_noise += self.velocity.xy().norm() * h / self.grid.width_m();
            self.pose.position += self.velocity * h + acceleration * (h * h / 2.0);
            self.velocity += acceleration * h;
            self.pose.rotation *= exponential(&(rates * h));
            self.wander *= decay;
            (self.rates, self.has_rates) = (rates, true);
        }
        self.pose.rotation = orthonormal(&self.pose.rotation);
        let matrix = |rows: &Rows| Vehicle::from_fn(|row, column| rows[row][column]);
        self.propagate(&matrix(&transition), &matrix(&noise));
        let variance = SLOPE_SIGMA * SLOPE_SIGMA;
        for i in SLOPE..CORE {
            let walked = self.at(i, i) + variance * slope_noise;
            self.covariance[i * (STATES + 1)] = self.at(i, i).max(walked.min(variance));
        }
    }

    /// Returns the factor of the variance with which biases walk: a bias that steps makes innovations persist.
    fn walk_factor(&self) -> f64 {
        let ratio = (self.motion_nis / CONSISTENT_MOTION_NIS).max(1.0);
        let square = ratio * ratio;
        (square * square * square).min(MAX_WALK_FACTOR)
    }

    /// Returns the factors of standard errors that innovations and residuals demand.
    pub fn inconsistency(&self) -> Inconsistency {
        let common = (self.common / sightings::COMMON_PX2).max(1.0);
        let usual = (self.nis[1].min(CONSISTENT_NIS) / USUAL_NIS).max(1.0).powi(3);
        Inconsistency::new(usual * (self.nis[1] / CONSISTENT_NIS).max(1.0) * self.excess, common)
    }

    /// Returns `true` if the camera is known as well as a fit to patches alone needs: without samples of the IMU
    /// nothing says what a read-out over time does to a picture.
    pub fn is_calibrated(&self) -> bool {
        let Calibration { k1, readout_s, .. } = &self.calibration;
        k1.sigma <= FREE_DISTORTION_SIGMA && readout_s.value + readout_s.sigma <= MAX_FREE_READOUT_S
    }

    /// Returns `true` if the last fit was one to patches alone.
    pub fn is_by_patches(&self) -> bool {
        self.by_patches
    }

    /// Returns `true` if the last prediction had no samples of the IMU.
    pub fn is_free(&self) -> bool {
        self.is_free
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

    /// Adds errors to all states.
    fn correct(&mut self, by: &[f64; STATES]) {
        let three = |first: usize| Vector3::new(by[first], by[first + 1], by[first + 2]);
        self.pose.position += three(POSITION);
        self.velocity += three(VELOCITY);
        self.pose.rotation = exponential(&three(ROTATION)) * self.pose.rotation;
        self.gyro_bias += three(GYRO_BIAS);
        self.force_bias += three(FORCE_BIAS);
        self.wander += three(WANDER);
        self.errors.add(&SVector::from_column_slice(&by[CAMERA..SLOPE]));
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
        let CameraErrors { distortion, readout_s, focal, delay_s } = &self.errors;
        let vehicle = self.pose.position.iter().chain(&self.velocity).chain(&self.pose.rotation);
        let finite =
            vehicle.chain([distortion, readout_s, focal, delay_s]).chain(&self.slope).all(|value| value.is_finite());
        finite && (0..CORE).all(|i| self.at(i, i) > -1e-9)
    }

    /// Returns the pose of the camera at the exposure of the first row.
    pub fn exposed(&self) -> CameraPose {
        self.present().after(self.errors.delay_s)
    }

    /// Returns the pose of a keyframe at its exposure.
    pub fn keyframe(&self, k: usize) -> Option<CameraPose> {
        self.keyframes[k].map(|camera| camera.after(self.errors.delay_s))
    }

    /// Returns displacement (m) from a keyframe and its covariance.
    pub fn displacement(&self, k: usize) -> Option<(Vector3<f64>, Matrix3<f64>)> {
        let first = CORE + POSE * k;
        let covariance = Matrix3::from_fn(|i, j| {
            self.at(i, j) - self.at(i, first + j) - self.at(first + i, j) + self.at(first + i, first + j)
        });
        self.keyframe(k).map(|pose| (self.exposed().position - pose.position, covariance))
    }

    /// Returns the velocity (m/s) and its covariance (m^2/s^2).
    pub fn velocity(&self) -> (Vector3<f64>, Matrix3<f64>) {
        (self.velocity, Matrix3::from_fn(|i, j| self.at(VELOCITY + i, VELOCITY + j)))
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

    /// Shares a variance of the relief (m^2), within its limits, between cells and landmarks.
    fn set_relief(&mut self, variance: f64) {
        let limit = |part: f64| (part / HEIGHT_SIGMA * self.max_height_sigma).powi(2);
        let half = variance.clamp(limit(EVEN_HEIGHT_SIGMA), limit(FREE_HEIGHT_SIGMA)) / 2.0;
        self.set_height_sigma(half.sqrt());
    }

    /// Returns the variance of the height of a landmark over that of its cell, m^2: that of the cell in a fit to
    /// patches alone, and 0 in others.
    fn roughness(&self) -> f64 {
        if self.by_patches { self.height_variance() } else { 0.0 }
    }

    fn height_variance(&self) -> f64 {
        self.height_sigma * self.height_sigma
    }

    /// Makes the cells those of a picture that spans `width_m` of the ground if they are too large or too small for it.
    pub fn fit_grid(&mut self, width_m: f64) {
        if self.grid.is_unfit(width_m) {
            self.restart_grid(width_m);
        }
    }

    /// Makes the cells those of a picture that spans `width_m` of the ground. Nothing is known of their heights.
    fn restart_grid(&mut self, width_m: f64) {
        self.grid.restart(width_m);
        self.cross.fill(0.0);
    }

    /// Returns the place of the cell of a point, without the correlation of the cell that had it before.
    fn cell(&mut self, point: &Vector3<f64>) -> usize {
        let (cell, is_left) = self.grid.enter(point);
        if is_left {
            (0..STATES).for_each(|state| self.cross[state * CELLS + cell] = 0.0);
        }
        cell
    }

    /// Returns the work units of a prediction without its steps, and of the updates by attitude and laser.
    pub fn prediction_work(&self) -> usize {
        PREDICTION_WORK + CELL_PREDICTION_WORK * self.grid.correlated()
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

    /// Returns the number of states up to the last keyframe; the others have no covariance.
    fn active(&self) -> usize {
        CORE + POSE * self.keyframes.iter().rposition(Option::is_some).map_or(0, |last| last + 1)
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

#[cfg(test)]
mod tests;
