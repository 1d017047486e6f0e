//! Flight dynamics of a helicopter about hover: six degrees of freedom, linear aerodynamics, exact kinematics and
//! gravity.
//!
//! With body axes `x` forward, `y` right, `z` down, velocity `V = (u, v, w)` and rates `w = (p, q, r)`, attitude `R`
//! (body to level frame), `R0` that of trim:
//!
//! ```text
//! dV/dt = f + R^T g - w x V,    f = -R0^T g + F (w, V - R^T wind, blades)
//! dw/dt =                           L (w, V - R^T wind, blades)
//! ```
//!
//! `F` and `L` are the published derivatives ([`lynx`]); `f` is the specific force, as an accelerometer measures it. A
//! gust acts through the velocity relative to the air. Gyroscopic coupling of the rates is neglected: at the 0.1 rad/s
//! of a hover it is below 0.01 rad/s^2.
//!
//! **Camera.** It is mounted at the centre of gravity so that it looks straight down in trim, with the top of its
//! picture towards the nose. Its roll, pitch and yaw are therefore zero in trim; the fuselage then has a roll of -3.1
//! and a pitch of 3.4 degrees in aerospace signs.

pub mod actuator;
pub mod lynx;

use crate::pose::Pose;
use hoverlock_reference::motion::orthophoto::Attitude;
use lynx::Derivatives;
use nalgebra::{Matrix3, SVector, Vector3};

/// Standard gravity, m/s^2.
pub const GRAVITY: f64 = 9.80665;

/// The state vector: position (`X_e`, `Y_e`, `Z`); roll, pitch, yaw of the fuselage in aerospace signs; rates `p q r`;
/// velocity `u v w`. Units are metres, radians and seconds.
pub type State = SVector<f64, 12>;

/// A rigid-body helicopter with its aerodynamics.
#[derive(Debug, Clone, PartialEq)]
pub struct Aircraft {
    derivatives: Derivatives,
    /// Rotation from camera to body axes.
    mount: Matrix3<f64>,
    /// Specific force in trim, m/s^2.
    lift: Vector3<f64>,
}

/// Returns the rotation from the axes of a level camera (right, back, down) to forward, right, down. It is also the
/// rotation from the world frame (`X_e`, `Y_e`, `Z`) to north, east, down, with north opposite to `Y_e`.
fn forward_right_down() -> Matrix3<f64> {
    Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
}

/// Returns the rotation from body axes to north, east, down.
fn body_to_level(roll: f64, pitch: f64, yaw: f64) -> Matrix3<f64> {
    let [(sr, cr), (sp, cp), (sy, cy)] = [roll, pitch, yaw].map(libm::sincos);
    let about_x = Matrix3::new(1.0, 0.0, 0.0, 0.0, cr, -sr, 0.0, sr, cr);
    let about_y = Matrix3::new(cp, 0.0, sp, 0.0, 1.0, 0.0, -sp, 0.0, cp);
    let about_z = Matrix3::new(cy, -sy, 0.0, sy, cy, 0.0, 0.0, 0.0, 1.0);
    about_z * about_y * about_x
}

impl Aircraft {
    /// Creates the Westland Lynx.
    pub fn lynx() -> Self {
        let derivatives = Derivatives::lynx();
        let [roll, pitch] = derivatives.trim;
        let mount = body_to_level(roll, pitch, 0.0).transpose() * forward_right_down();
        let lift = mount * Vector3::new(0.0, 0.0, -GRAVITY);
        Self { derivatives, mount, lift }
    }

    /// Returns the trimmed state at a height (m), heading opposite to `Y_e`.
    pub fn trimmed(&self, height: f64) -> State {
        let [roll, pitch] = self.derivatives.trim;
        let mut state = State::zeros();
        state[2] = -height;
        state[3] = roll;
        state[4] = pitch;
        state
    }

    /// Returns the rotation from body axes to the world.
    fn to_world(state: &State) -> Matrix3<f64> {
        forward_right_down().transpose() * body_to_level(state[3], state[4], state[5])
    }

    /// Computes `dw/dt` (rad/s^2) and `f` (m/s^2) for the wind in the world (m/s) and the blade angles from trim (rad).
    fn accelerations(&self, state: &State, wind: &Vector3<f64>, blades: &SVector<f64, 4>) -> SVector<f64, 6> {
        let air = Self::to_world(state).transpose() * wind;
        let mut motion: SVector<f64, 6> = state.fixed_rows::<6>(6).into();
        motion.fixed_rows_mut::<3>(3).iter_mut().zip(air.iter()).for_each(|(velocity, air)| *velocity -= air);
        let mut accelerations = self.derivatives.accelerations(&motion, blades);
        accelerations.fixed_rows_mut::<3>(3).iter_mut().zip(self.lift.iter()).for_each(|(f, lift)| *f += lift);
        accelerations
    }

    /// Computes the time derivative of the state for the wind in the world (m/s) and the blade angles from trim (rad).
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

    /// Integrates the state over `step` seconds by the classical Runge-Kutta method of fourth order, with constant wind
    /// and blade angles.
    pub fn advance(&self, state: &State, wind: &Vector3<f64>, blades: &SVector<f64, 4>, step: f64) -> State {
        let at = |state: &State| self.derivative(state, wind, blades);
        let a = at(state);
        let b = at(&(state + a * (step / 2.0)));
        let c = at(&(state + b * (step / 2.0)));
        let d = at(&(state + c * step));
        state + (a + (b + c) * 2.0 + d) * (step / 6.0)
    }

    /// Returns position and attitude of the camera.
    pub fn camera(&self, state: &State) -> Pose {
        let rotation = Self::to_world(state) * self.mount;
        Pose { position: state.fixed_rows::<3>(0).into(), attitude: Attitude::of_rotation(&rotation) }
    }

    /// Returns the velocity over the ground in the world, m/s.
    pub fn velocity(&self, state: &State) -> Vector3<f64> {
        Self::to_world(state) * state.fixed_rows::<3>(9)
    }

    /// Returns the angular velocity about the camera's axes, rad/s.
    pub fn rates(&self, state: &State) -> Vector3<f64> {
        self.mount.transpose() * state.fixed_rows::<3>(6)
    }

    /// Returns the specific force along the camera's axes, m/s^2.
    pub fn specific_force(&self, state: &State, wind: &Vector3<f64>, blades: &SVector<f64, 4>) -> Vector3<f64> {
        self.mount.transpose() * self.accelerations(state, wind, blades).fixed_rows::<3>(3)
    }
}

#[cfg(test)]
mod tests {
    use super::lynx::PUBLISHED;
    use super::*;
    use nalgebra::{Complex, SMatrix};
    use proptest::prelude::*;

    /// The source's gravity, read from its derivatives of forward acceleration by pitch angle: 32.1036 ft/s^2 over the
    /// cosine of trim pitch. [`GRAVITY`] is 0.04 % more.
    const PUBLISHED_BY_PITCH: f64 = -32.1036071777344;

    /// `A` of the eight published states theta, phi, p, q, r, u, v, w (m, rad) by central differences of the nonlinear
    /// equations about trim.
    fn linearised() -> SMatrix<f64, 8, 8> {
        let aircraft = Aircraft::lynx();
        let trim = aircraft.trimmed(50.0);
        let rate = |state: &State| aircraft.derivative(state, &Vector3::zeros(), &SVector::zeros());
        let states = [4, 3, 6, 7, 8, 9, 10, 11];
        let h = 1e-4;
        SMatrix::from_fn(|row, column| {
            let step = State::from_fn(|i, _| if i == states[column] { h } else { 0.0 });
            (rate(&(trim + step))[states[row]] - rate(&(trim - step))[states[row]]) / (2.0 * h)
        })
    }

    #[test]
    fn trim_is_an_equilibrium() {
        let aircraft = Aircraft::lynx();
        let trim = aircraft.trimmed(50.0);
        assert!(aircraft.derivative(&trim, &Vector3::zeros(), &SVector::zeros()).norm() < 1e-12);
        let camera = aircraft.camera(&trim);
        let Attitude { roll, pitch, yaw } = camera.attitude;
        assert!(roll.abs() + pitch.abs() + yaw.abs() < 1e-12 && (camera.height() - 50.0).abs() < 1e-12, "{camera:?}");
    }

    /// The kinematics and gravity computed here must agree with the rows and columns of theta and phi that the source
    /// prints (rad, ft).
    #[test]
    fn the_nonlinear_equations_have_the_published_derivatives() {
        let computed = linearised();
        let foot = 0.3048;
        let of = |row: usize| if row < 5 { 1.0 } else { foot };
        let mut published = SMatrix::<f64, 8, 8>::zeros();
        for row in 0..6 {
            for column in 0..6 {
                published[(row + 2, column + 2)] = PUBLISHED[row][column] * of(row + 2) / of(column + 2);
            }
        }
        let printed = [
            (0, 3, 0.99857378005981),
            (0, 4, 0.05338427424431),
            (1, 2, 1.0),
            (1, 3, -0.00318221934140),
            (1, 4, 0.05952465534210),
            (5, 0, PUBLISHED_BY_PITCH * foot),
            (6, 0, 0.10216116905212 * foot),
            (6, 1, 32.0578308105469 * foot),
            (7, 0, -1.91097259521484 * foot),
            (7, 1, 1.71382904052734 * foot),
        ];
        for (row, column, value) in printed {
            published[(row, column)] = value;
        }
        for row in 0..8 {
            for column in 0..8 {
                let (a, b) = (computed[(row, column)], published[(row, column)]);
                // 5e-4 of it is gravity's difference; 1e-5 that of roundings in the source.
                assert!((a - b).abs() <= 5e-4 * b.abs() + 1e-5, "row {row}, column {column}: {a}, published {b}");
            }
        }
    }

    /// Eigenvalues of the published matrix, by LAPACK's `dgeev` in its own units (1/s): roll and pitch subsidence, the
    /// unstable oscillation of hover, a damped one, heave and yaw subsidence.
    #[test]
    fn the_modes_are_those_of_the_published_matrix() {
        let published = [
            Complex::new(-11.49675461, 0.0),
            Complex::new(-2.30361846, 0.0),
            Complex::new(0.23419806, 0.55126184),
            Complex::new(0.23419806, -0.55126184),
            Complex::new(-0.15932311, 0.59897794),
            Complex::new(-0.15932311, -0.59897794),
            Complex::new(-0.29233356, 0.0),
            Complex::new(-0.71035803, 0.0),
        ];
        let computed = linearised().complex_eigenvalues();
        for expected in published {
            let nearest = computed.iter().map(|mode| (mode - expected).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 5e-4 * expected.norm().max(1.0), "{expected}: {nearest} off, {computed}");
        }
    }

    /// A gust has the effect of flying in the opposite direction through still air.
    #[test]
    fn wind_acts_through_the_velocity_relative_to_the_air() {
        let aircraft = Aircraft::lynx();
        let wind = Vector3::new(1.0, 2.0, -0.5);
        let at_rest = aircraft.trimmed(50.0);
        let mut moving = at_rest;
        let against = Aircraft::to_world(&at_rest).transpose() * -wind;
        moving.fixed_rows_mut::<3>(9).copy_from(&against);
        let blades = SVector::zeros();
        let blown = aircraft.derivative(&at_rest, &wind, &blades);
        let flown = aircraft.derivative(&moving, &Vector3::zeros(), &blades);
        assert!((blown.fixed_rows::<6>(6) - flown.fixed_rows::<6>(6)).norm() < 1e-12);
        // Wind from the nose pushes back, wind from the left to the right: the drag of a hovering helicopter.
        let back = aircraft.derivative(&at_rest, &Vector3::new(0.0, 3.0, 0.0), &blades);
        let right = aircraft.derivative(&at_rest, &Vector3::new(3.0, 0.0, 0.0), &blades);
        assert!(back[9] < -0.05 && right[10] > 0.1, "{back} {right}");
    }

    /// Fourth order: half the step, a sixteenth of the error.
    #[test]
    fn the_integration_is_of_fourth_order() {
        let aircraft = Aircraft::lynx();
        let wind = Vector3::new(1.0, -2.0, 0.5);
        let blades = SVector::from([0.01, -0.02, 0.01, 0.02]);
        let fly = |steps: usize| {
            let start = aircraft.trimmed(50.0);
            (0..steps).fold(start, |state, _| aircraft.advance(&state, &wind, &blades, 1.0 / steps as f64))
        };
        let exact = fly(800);
        let ratio = (fly(25) - exact).norm() / (fly(50) - exact).norm();
        assert!((14.0..20.0).contains(&ratio), "{ratio}");
        // At the step of a flight the error of a second is far below what a sensor sees.
        assert!((fly(200) - exact).norm() < 1e-6, "{}", (fly(200) - exact).norm());
    }

    proptest! {
        /// The camera's attitude is the one whose rotation is the fuselage's and the mount's.
        #[test]
        fn the_cameras_attitude_is_its_rotation(
            roll in -0.3..0.3f64, pitch in -0.3..0.3f64, yaw in -3.0..3.0f64,
        ) {
            let aircraft = Aircraft::lynx();
            let mut state = aircraft.trimmed(50.0);
            state[3] += roll;
            state[4] += pitch;
            state[5] = yaw;
            let rotation = Aircraft::to_world(&state) * aircraft.mount;
            let camera = aircraft.camera(&state).attitude;
            prop_assert!((camera.rotation() - rotation).abs().max() < 1e-12);
            // Rates about the camera's axes turn the camera: over a short time the rotation changes by their skew.
            state[6] = 0.2;
            state[7] = -0.1;
            state[8] = 0.3;
            let h = 1e-6;
            let angles = aircraft.derivative(&state, &Vector3::zeros(), &SVector::zeros());
            let later = Aircraft::to_world(&(state + angles * h)) * aircraft.mount;
            let turned = rotation * (Matrix3::identity() + aircraft.rates(&state).cross_matrix() * h);
            prop_assert!((later - turned).abs().max() < 1e-10);
        }

        /// Newton's law in the world: the velocity changes by specific force and gravity.
        #[test]
        fn the_velocity_changes_by_force_and_gravity(
            roll in -0.3..0.3f64, pitch in -0.3..0.3f64, yaw in -3.0..3.0f64,
            motion in prop::array::uniform6(-2.0..2.0f64), blades in prop::array::uniform4(-0.05..0.05f64),
            wind in prop::array::uniform3(-5.0..5.0f64),
        ) {
            let aircraft = Aircraft::lynx();
            let mut state = aircraft.trimmed(50.0);
            state[3] = roll;
            state[4] = pitch;
            state[5] = yaw;
            state.fixed_rows_mut::<6>(6).copy_from_slice(&motion);
            let (wind, blades, h) = (Vector3::from(wind), SVector::from(blades), 1e-6);
            let rate = aircraft.derivative(&state, &wind, &blades);
            let change = (aircraft.velocity(&(state + rate * h)) - aircraft.velocity(&(state - rate * h))) / (2.0 * h);
            let force = aircraft.camera(&state).attitude.rotation() * aircraft.specific_force(&state, &wind, &blades);
            prop_assert!((change - force - Vector3::new(0.0, 0.0, GRAVITY)).norm() < 1e-6);
            let moved = rate.fixed_rows::<3>(0) - aircraft.velocity(&state);
            prop_assert!(moved.norm() < 1e-12);
        }
    }

    /// Right side down is negative roll of the camera, nose up is negative pitch.
    #[test]
    fn signs_are_those_of_the_camera() {
        let aircraft = Aircraft::lynx();
        let mut state = aircraft.trimmed(50.0);
        state[3] += 0.02;
        assert!(aircraft.camera(&state).attitude.roll < -0.019);
        state[4] += 0.03;
        assert!(aircraft.camera(&state).attitude.pitch < -0.029);
        state[5] += 0.04;
        assert!(aircraft.camera(&state).attitude.yaw > 0.035);
        // Forward is against Y_e.
        state[9] = 1.0;
        assert!(aircraft.velocity(&state).y < -0.9);
    }
}
