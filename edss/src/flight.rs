//! A flight: steps helicopter, wind, sensors and autopilot together; vision fixes come from outside.
//!
//! Time advances in steps of `STEP_S` on a fixed grid. At each grid point the sensors are read, the autopilot
//! computes its command, and wind and blade angles are set for the next step. [`Flight::advance`] may stop anywhere
//! between grid points without changing the flight. A flight begins settled: for `SETTLING_S` seconds before time 0
//! the true position is used as the fix.

pub use crate::autopilot::{Fix, Hold};

use crate::aircraft::actuator::Actuators;
use crate::aircraft::lynx::Derivatives;
use crate::aircraft::{Aircraft, State};
use crate::autopilot::Autopilot;
use crate::pose::Pose;
use crate::random::{Purpose, stream};
use crate::sensors::{Barometer, Imu, Inertial, LATENCY_S, Laser};
use crate::wind::{Climate, Wind};
use hoverlock_reference::motion::orthophoto::Attitude;
use nalgebra::{Matrix2, Vector2, Vector3, Vector4};
use rand::RngExt;
use serde::{Deserialize, Serialize};

/// Time step of the integration.
const STEP_S: f64 = 0.005;
/// Duration of the hover before time 0.
const SETTLING_S: f64 = 20.0;
/// Steps from one reading of the barometer to the next: 20 readings a second.
const BAROMETER_STEPS: i64 = 10;
/// Amplitude of the height profiles.
const ALTITUDE_CHANGE_M: f64 = 5.0;
/// Period of [`Altitude::Smooth`].
const SMOOTH_PERIOD_S: f64 = 20.0;
/// Time between the steps of [`Altitude::Abrupt`].
const ABRUPT_INTERVAL_S: f64 = 10.0;

/// A function that returns the true distance from a pose along the optical axis, m; `None` if there is no hit.
pub type TrueRange<'a> = dyn FnMut(Pose) -> Option<f64> + 'a;

/// The height profile of a flight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Altitude {
    /// Constant height.
    #[default]
    Hold,
    /// A sine with an amplitude of 5 m and a period of 20 s.
    Smooth,
    /// A step every 10 s: 5 m up, back, 5 m down, back; or down first.
    Abrupt,
}

/// The parameters of a flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup {
    /// Height over the mean ground, m.
    pub height: f64,
    /// Rms of each horizontal component of the gusts, m/s.
    pub gust_rms: f64,
    /// Mean wind towards `X_e` and `Y_e`, m/s.
    pub mean_wind: Vector2<f64>,
    /// Rms error of the sensor's roll and pitch, rad.
    pub tilt_noise: f64,
    /// Rms error of the sensor's yaw, rad.
    pub heading_noise: f64,
    /// Rms noise of the laser, m.
    pub laser_noise: f64,
    /// Height profile.
    pub altitude: Altitude,
    /// Source of the position that the autopilot holds.
    pub mode: Hold,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            height: 50.0,
            gust_rms: 3.0,
            mean_wind: Vector2::zeros(),
            tilt_noise: 0.2f64.to_radians(),
            heading_noise: 0.5f64.to_radians(),
            laser_noise: 0.1,
            altitude: Altitude::Hold,
            mode: Hold::Vision,
        }
    }
}

/// The error of a flight parameter that is out of range.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{name} must be between {min} and {max} {unit}, not {value}")]
pub struct SetupError {
    /// Name of the parameter.
    pub name: &'static str,
    /// Smallest valid value.
    pub min: f64,
    /// Largest valid value.
    pub max: f64,
    /// Unit of the values.
    pub unit: &'static str,
    /// Value that was given.
    pub value: f64,
}

impl Setup {
    /// Checks that the models are valid for the parameters. The formulas of the gusts are those of low altitude, up to
    /// 1000 feet. The helicopter model is one about hover: a side wind of 10 m/s takes 2.2 of the 3.5 degrees of tilt
    /// that the position loop may command.
    ///
    /// # Errors
    /// If a value is out of range or not a number.
    pub fn check(&self) -> Result<(), SetupError> {
        let bounds = [
            ("height", self.height, 10.0, 300.0, "m"),
            ("rms of gusts", self.gust_rms, 0.0, 5.0, "m/s"),
            ("mean wind", self.mean_wind.norm(), 0.0, 10.0, "m/s"),
            ("tilt noise", self.tilt_noise, 0.0, 0.02, "rad"),
            ("heading noise", self.heading_noise, 0.0, 0.05, "rad"),
            ("laser noise", self.laser_noise, 0.0, 1.0, "m"),
        ];
        let wrong = bounds.into_iter().find(|(_, value, min, max, _)| !(min..=max).contains(&value));
        wrong.map_or(Ok(()), |(name, value, min, max, unit)| Err(SetupError { name, min, max, unit, value }))
    }
}

/// The true state of the flight at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Time since the start, s.
    pub time: f64,
    /// Pose of the camera.
    pub camera: Pose,
    /// Velocity over the ground, m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity about the camera's axes, rad/s.
    pub rates: Vector3<f64>,
    /// Velocity of the air, m/s.
    pub wind: Vector3<f64>,
    /// Blade angles from trim, rad: collective, longitudinal and lateral cyclic, tail rotor collective.
    pub controls: [f64; 4],
    /// Commanded height over the mean ground, m.
    pub height: f64,
    /// The autopilot's estimate of the displacement from the held position, m.
    pub believed: Vector2<f64>,
    /// Weight of the position loop's tilt: 1 while it holds the position, 0 in attitude hold.
    pub hold: f64,
}

/// A [`Moment`] as a row of a CSV file, whose columns are named as the fields.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Row {
    /// Time since the start, s.
    pub time: f64,
    /// Position along `X_e`, m.
    pub x: f64,
    /// Position along `Y_e`, m.
    pub y: f64,
    /// Position downwards from the mean ground, m.
    pub z: f64,
    /// Roll of the camera, rad.
    pub roll: f64,
    /// Pitch of the camera, rad.
    pub pitch: f64,
    /// Yaw of the camera, rad.
    pub yaw: f64,
    /// Velocity along `X_e`, m/s.
    pub vx: f64,
    /// Velocity along `Y_e`, m/s.
    pub vy: f64,
    /// Velocity downwards, m/s.
    pub vz: f64,
    /// Angular rate about the camera's `x` axis, rad/s.
    pub rate_x: f64,
    /// Angular rate about the camera's `y` axis, rad/s.
    pub rate_y: f64,
    /// Angular rate about the optical axis, rad/s.
    pub rate_z: f64,
    /// Wind towards `X_e`, m/s.
    pub wind_x: f64,
    /// Wind towards `Y_e`, m/s.
    pub wind_y: f64,
    /// Wind downwards, m/s.
    pub wind_z: f64,
    /// Collective from trim, rad.
    pub collective: f64,
    /// Longitudinal cyclic from trim, rad.
    pub longitudinal: f64,
    /// Lateral cyclic from trim, rad.
    pub lateral: f64,
    /// Tail rotor collective from trim, rad.
    pub tail: f64,
    /// Commanded height over the mean ground, m.
    pub height_wanted: f64,
    /// Estimated displacement from the held position along `X_e`, m.
    pub believed_x: f64,
    /// Estimated displacement from the held position along `Y_e`, m.
    pub believed_y: f64,
    /// Weight of the position loop: 1 while it holds the position, 0 in attitude hold.
    pub hold: f64,
}

impl Moment {
    /// Returns the state as a row.
    pub fn row(&self) -> Row {
        let Pose { position, attitude } = self.camera;
        let [collective, longitudinal, lateral, tail] = self.controls;
        Row {
            time: self.time,
            x: position.x,
            y: position.y,
            z: position.z,
            roll: attitude.roll,
            pitch: attitude.pitch,
            yaw: attitude.yaw,
            vx: self.velocity.x,
            vy: self.velocity.y,
            vz: self.velocity.z,
            rate_x: self.rates.x,
            rate_y: self.rates.y,
            rate_z: self.rates.z,
            wind_x: self.wind.x,
            wind_y: self.wind.y,
            wind_z: self.wind.z,
            collective,
            longitudinal,
            lateral,
            tail,
            height_wanted: self.height,
            believed_x: self.believed.x,
            believed_y: self.believed.y,
            hold: self.hold,
        }
    }
}

/// The sensor readings at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Readings {
    /// Measured attitude of the camera, rad.
    pub attitude: Attitude,
    /// Measured range along the optical axis, m; `None` if the laser hit nothing.
    pub range: Option<f64>,
    /// Time of the readings, s.
    pub time: f64,
}

/// Rates and specific force of the inertial sensor at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InertialSample {
    /// Time at which they were measured, s; a sample is available later by the latency of the sensor.
    pub time: f64,
    /// Angular velocity about the camera's axes, rad/s.
    pub rates: Vector3<f64>,
    /// Specific force along the camera's axes, m/s^2.
    pub force: Vector3<f64>,
}

/// A simulated flight under autopilot: helicopter, wind and sensors. The caller passes in the vision fixes.
#[derive(Debug, Clone)]
pub struct Flight {
    setup: Setup,
    aircraft: Aircraft,
    actuators: Actuators,
    wind: Wind,
    imu: Imu,
    laser: Laser,
    barometer: Barometer,
    autopilot: Autopilot,
    state: State,
    /// Index of the grid point of `state`; 0 at time 0.
    point: i64,
    /// Time of the last call to [`Flight::advance`], s.
    now: f64,
    /// Sign of the first change of height.
    upwards: f64,
    /// Samples since the last call to [`Flight::take_inertial`].
    inertial: Vec<InertialSample>,
}

impl Flight {
    /// Creates a flight at time 0, with random errors and gusts from `seed`. The setup must pass [`Setup::check`].
    ///
    /// # Panics
    /// Never: the published derivatives let the blade angles command all four accelerations, which a test shows.
    pub fn new(setup: &Setup, seed: u64) -> Self {
        let aircraft = Aircraft::lynx();
        let actuators = Actuators::new(STEP_S);
        let state = aircraft.trimmed(setup.height);
        let climate = Climate { gust_rms: setup.gust_rms, mean: setup.mean_wind, height: setup.height };
        let wind = Wind::new(&climate, seed, STEP_S);
        let truth = inertial(&aircraft, &state, &wind, &actuators);
        let point = -(SETTLING_S / STEP_S).round() as i64;
        let start = point as f64 * STEP_S;
        let pilot = Autopilot::new(&Derivatives::lynx(), setup.tilt_noise, setup.height, start, STEP_S);
        let mut flight = Self {
            setup: *setup,
            actuators,
            imu: Imu::new(setup.tilt_noise, setup.heading_noise, &truth, seed, STEP_S),
            laser: Laser::new(setup.laser_noise, seed),
            barometer: Barometer::new(seed, BAROMETER_STEPS as f64 * STEP_S),
            autopilot: pilot.expect("the blade angles command the four accelerations"),
            wind,
            state,
            point,
            now: 0.0,
            upwards: if stream(seed, Purpose::Flight).random::<bool>() { 1.0 } else { -1.0 },
            inertial: Vec::new(),
            aircraft,
        };
        flight.settle();
        flight.inertial.clear();
        flight
    }

    /// Hovers with true positions as fixes until time 0.
    fn settle(&mut self) {
        while self.point < 0 {
            let displacement = self.aircraft.camera(&self.state).ground();
            let covariance = Matrix2::identity() * 1e-4;
            let exposed = self.point as f64 * STEP_S;
            self.autopilot.apply_fix(&Fix {
                displacement,
                covariance,
                velocity: None,
                height: None,
                yaw: None,
                exposed,
            });
            self.step();
        }
        self.state[0] = 0.0;
        self.state[1] = 0.0;
        self.autopilot.set_hold(self.setup.mode);
        self.autopilot.engage(0.0);
    }

    /// Returns the commanded height (m) and its rate (m/s) at a time.
    fn commanded_height(&self, time: f64) -> [f64; 2] {
        let change = ALTITUDE_CHANGE_M * self.upwards;
        let [above, climb] = match self.setup.altitude {
            _ if time < 0.0 => [0.0, 0.0],
            Altitude::Hold => [0.0, 0.0],
            Altitude::Smooth => {
                let turns = std::f64::consts::TAU / SMOOTH_PERIOD_S;
                let (sin, cos) = libm::sincos(turns * time);
                [change * sin, change * turns * cos]
            }
            Altitude::Abrupt => [[0.0, change, 0.0, -change][(time / ABRUPT_INTERVAL_S) as usize % 4], 0.0],
        };
        [self.setup.height + above, climb]
    }

    /// Advances from one grid point to the next.
    fn step(&mut self) {
        self.state = self.aircraft.advance(&self.state, &self.wind.velocity(), &self.actuators.angles(), STEP_S);
        self.point += 1;
        let time = self.point as f64 * STEP_S;
        self.wind.advance();
        self.imu.advance(&inertial(&self.aircraft, &self.state, &self.wind, &self.actuators));
        let reading = self.imu.reading();
        self.inertial.push(InertialSample { time: time - LATENCY_S, rates: reading.rates, force: reading.force });
        if self.point % BAROMETER_STEPS == 0 {
            self.autopilot.apply_height(time, self.barometer.read(self.aircraft.camera(&self.state).height()));
        }
        let height = self.commanded_height(time);
        let command = self.autopilot.advance(time, reading, height);
        self.actuators.advance(&command);
    }

    /// Advances to a time (s) and returns the true state there. Times must not decrease from call to call.
    pub fn advance(&mut self, to: f64) -> Moment {
        while (self.point + 1) as f64 * STEP_S <= to {
            self.step();
        }
        self.now = to;
        let state = self.present();
        Moment {
            time: to,
            camera: self.aircraft.camera(&state),
            velocity: self.aircraft.velocity(&state),
            rates: self.aircraft.rates(&state),
            wind: self.wind.velocity(),
            controls: self.actuators.angles().into(),
            height: self.commanded_height(to)[0],
            believed: self.autopilot.position(),
            hold: self.autopilot.weight(),
        }
    }

    /// Returns the state at `now`.
    fn present(&self) -> State {
        let rest = self.now - self.point as f64 * STEP_S;
        self.aircraft.advance(&self.state, &self.wind.velocity(), &self.actuators.angles(), rest)
    }

    /// Reads the sensors at the time of the last call to [`Flight::advance`]; `laser` returns the true range.
    pub fn readings(&mut self, laser: &mut TrueRange) -> Readings {
        let range = laser(self.aircraft.camera(&self.present())).map(|range| self.laser.read(range));
        Readings { attitude: self.imu.reading().attitude, range, time: self.now }
    }

    /// Returns the samples of the inertial sensor since the last call, 200 a second, the oldest first.
    pub fn take_inertial(&mut self) -> Vec<InertialSample> {
        std::mem::take(&mut self.inertial)
    }

    /// Passes the vision fix of a frame to the autopilot, at the time of the last call to [`Flight::advance`]. `None`
    /// has no effect.
    pub fn apply_fix(&mut self, fix: Option<Fix>) {
        if let Some(fix) = fix {
            self.autopilot.apply_fix(&fix);
        }
    }

    /// Sets the velocity of a gust that comes on top of the wind, m/s.
    pub fn set_gust(&mut self, velocity: Vector3<f64>) {
        self.wind.set_gust(velocity);
    }

    /// Adds to the constant errors of the inertial sensor: angular rates (rad/s) and specific force (m/s^2).
    pub fn add_inertial_bias(&mut self, rates: &Vector3<f64>, force: &Vector3<f64>) {
        self.imu.add_bias(rates, force);
    }

    /// Makes the present position the one to hold. Call it when the reference of the vision system is exposed.
    pub fn engage(&mut self) {
        self.autopilot.engage(self.point as f64 * STEP_S);
    }
}

/// Returns the reading of an inertial sensor without errors.
fn inertial(aircraft: &Aircraft, state: &State, wind: &Wind, actuators: &Actuators) -> Inertial {
    Inertial {
        attitude: aircraft.camera(state).attitude,
        rates: aircraft.rates(state),
        force: aircraft.specific_force(state, &wind.velocity(), &Vector4::from(actuators.angles())),
    }
}
