//! A helicopter about hover: `M dx/dt`, six degrees of freedom, linear aerodynamics, exact kinematics and gravity.
//!
//! With body axes `x` forward, `y` right, `z` down, velocity `V = (u, v, w)` and rates `w = (p, q, r)`, attitude `R`
//! (body to level frame), `R0` that of trim:
//!
//! ```text
//! dV/dt = f + R^T g - w x V,    f = -R0^T g + F (w, V - R^T wind, blades)
//! dw/dt =                           L (w, V - R^T wind, blades)
//! ```
//!
//! `F` and `L` are the published derivatives ([`lynx`]); `f` is what an accelerometer reads. A gust enters through the
//! velocity relative to the air. The moments of rotation on rotation are left out: at the 0.1 rad/s of a hover they are
//! below 0.01 rad/s^2.
//!
//! **Camera.** It is fixed to the fuselage where it looks straight down in trim, the top of its picture to the nose, at
//! the centre of gravity. Its roll, pitch and yaw are therefore zero in trim; the fuselage then has roll -3.1 and pitch
//! 3.4 degrees in the signs of flight mechanics.

pub mod actuator;
pub mod lynx;

use crate::pose::Pose;
use hoverlock_reference::motion::orthophoto::Attitude;
use lynx::Derivatives;
use nalgebra::{Matrix3, SVector, Vector3};

/// Gravity, m/s^2.
pub const GRAVITY: f64 = 9.80665;

/// Position (`X_e`, `Y_e`, `Z`), then roll, pitch, yaw of the fuselage in the signs of flight mechanics, then `p q r`,
/// then `u v w`; metres, radians, seconds.
pub type State = SVector<f64, 12>;

/// The rigid body with its aerodynamics.
#[derive(Debug, Clone, PartialEq)]
pub struct Aircraft {
    derivatives: Derivatives,
    /// Camera axes -> body axes.
    mount: Matrix3<f64>,
    /// What an accelerometer reads in trim.
    lift: Vector3<f64>,
}

/// Camera axes of a camera without tilt (right, back, down) -> forward, right, down; also level frame
/// (`X_e`, `Y_e`, `Z`) -> north, east, down, where north is against `Y_e`.
fn forward_right_down() -> Matrix3<f64> {
    Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
}

/// Body axes -> north, east, down.
fn body_to_level(roll: f64, pitch: f64, yaw: f64) -> Matrix3<f64> {
    let [(sr, cr), (sp, cp), (sy, cy)] = [roll, pitch, yaw].map(libm::sincos);
    let about_x = Matrix3::new(1.0, 0.0, 0.0, 0.0, cr, -sr, 0.0, sr, cr);
    let about_y = Matrix3::new(cp, 0.0, sp, 0.0, 1.0, 0.0, -sp, 0.0, cp);
    let about_z = Matrix3::new(cy, -sy, 0.0, sy, cy, 0.0, 0.0, 0.0, 1.0);
    about_z * about_y * about_x
}

impl Aircraft {
    /// The Lynx.
    pub fn lynx() -> Self {
        let derivatives = Derivatives::lynx();
        let [roll, pitch] = derivatives.trim;
        let mount = body_to_level(roll, pitch, 0.0).transpose() * forward_right_down();
        let lift = mount * Vector3::new(0.0, 0.0, -GRAVITY);
        Self { derivatives, mount, lift }
    }

    /// Trimmed at a height (m), heading away from `Y_e`.
    pub fn trimmed(&self, height: f64) -> State {
        let [roll, pitch] = self.derivatives.trim;
        let mut state = State::zeros();
        state[2] = -height;
        state[3] = roll;
        state[4] = pitch;
        state
    }

    /// Body axes -> world.
    fn to_world(state: &State) -> Matrix3<f64> {
        forward_right_down().transpose() * body_to_level(state[3], state[4], state[5])
    }

    /// `dw/dt` and `f` for the wind (world, m/s) and the blade angles from trim (rad).
    fn accelerations(&self, state: &State, wind: &Vector3<f64>, blades: &SVector<f64, 4>) -> SVector<f64, 6> {
        let air = Self::to_world(state).transpose() * wind;
        let mut motion: SVector<f64, 6> = state.fixed_rows::<6>(6).into();
        motion.fixed_rows_mut::<3>(3).iter_mut().zip(air.iter()).for_each(|(velocity, air)| *velocity -= air);
        let mut accelerations = self.derivatives.accelerations(&motion, blades);
        accelerations.fixed_rows_mut::<3>(3).iter_mut().zip(self.lift.iter()).for_each(|(f, lift)| *f += lift);
        accelerations
    }

    /// `dx/dt`.
    pub fn derivative(&self, state: &State, wind: &Vector3<f64>, blades: &SVector<f64, 4>) -> State {
        let to_world = Self::to_world(state);
        let accelerations = self.accelerations(state, wind, blades);
        let angular: Vector3<f64> = accelerations.fixed_rows::<3>(0).into();
        let force: Vector3<f64> = accelerations.fixed_rows::<3>(3).into();
        let rates: Vector3<f64> = state.fixed_rows::<3>(6).into();
        let velocity: Vector3<f64> = state.fixed_rows::<3>(9).into();
        let gravity = to_world.transpose() * Vector3::new(0.0, 0.0, GRAVITY);
        let linear = force + gravity - rates.cross(&velocity);
        let ((sin_roll, cos_roll), (sin_pitch, cos_pitch)) = (libm::sincos(state[3]), libm::sincos(state[4]));
        let turning = rates.y * sin_roll + rates.z * cos_roll;
        let angles = Vector3::new(
            rates.x + turning * sin_pitch / cos_pitch,
            rates.y * cos_roll - rates.z * sin_roll,
            turning / cos_pitch,
        );
        let mut derivative = State::zeros();
        for (i, part) in [to_world * velocity, angles, angular, linear].iter().enumerate() {
            derivative.fixed_rows_mut::<3>(3 * i).copy_from(part);
        }
        derivative
    }

    /// The state `step` seconds later, by the classical Runge-Kutta method of fourth order; wind and blade angles stand
    /// still meanwhile.
    pub fn advance(&self, state: &State, wind: &Vector3<f64>, blades: &SVector<f64, 4>, step: f64) -> State {
        let at = |state: &State| self.derivative(state, wind, blades);
        let a = at(state);
        let b = at(&(state + a * (step / 2.0)));
        let c = at(&(state + b * (step / 2.0)));
        let d = at(&(state + c * step));
        state + (a + (b + c) * 2.0 + d) * (step / 6.0)
    }

    /// Where the camera is and how it is turned.
    pub fn camera(&self, state: &State) -> Pose {
        let rotation = Self::to_world(state) * self.mount;
        // The inverse of `Attitude::rotation`: its bottom row is (-sin roll cos pitch, -sin pitch, cos roll cos pitch).
        let roll = libm::atan2(-rotation[(2, 0)], rotation[(2, 2)]);
        let pitch = -libm::asin(rotation[(2, 1)].clamp(-1.0, 1.0));
        let yaw = libm::atan2(-rotation[(0, 1)], rotation[(1, 1)]);
        Pose { position: state.fixed_rows::<3>(0).into(), attitude: Attitude { roll, pitch, yaw } }
    }

    /// Velocity over the ground in the world, m/s.
    pub fn velocity(&self, state: &State) -> Vector3<f64> {
        Self::to_world(state) * state.fixed_rows::<3>(9)
    }

    /// Angular velocity about the camera's axes, rad/s.
    pub fn rates(&self, state: &State) -> Vector3<f64> {
        self.mount.transpose() * state.fixed_rows::<3>(6)
    }

    /// What an accelerometer on the camera reads, m/s^2 along the camera's axes.
    pub fn specific_force(&self, state: &State, wind: &Vector3<f64>, blades: &SVector<f64, 4>) -> Vector3<f64> {
        self.mount.transpose() * self.accelerations(state, wind, blades).fixed_rows::<3>(3)
    }
}
