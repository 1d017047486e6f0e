//! A flight: helicopter, wind, sensors and autopilot in one clock; vision comes in from outside.
//!
//! Time runs in steps of [`STEP`] on a fixed grid. At each point of the grid sensors read, the autopilot decides, and
//! wind and blade angles are set for the step that follows. [`Flight::advance`] may stop anywhere between; what is
//! asked between does not change what follows. A flight begins settled: for [`SETTLING`] seconds before time 0 a pilot
//! who knows the place holds it.

pub use crate::autopilot::{Fix, Hold};

use crate::aircraft::actuator::Actuators;
use crate::aircraft::lynx::Derivatives;
use crate::aircraft::{Aircraft, State};
use crate::autopilot::Autopilot;
use crate::pose::Pose;
use crate::random::{Purpose, stream};
use crate::sensors::{Barometer, Imu, Inertial, Laser};
use crate::wind::{Climate, Wind};
use hoverlock_reference::motion::orthophoto::Attitude;
use nalgebra::{Matrix2, Vector2, Vector3, Vector4};
use rand::RngExt;
use serde::Serialize;

/// Step of the integration, s.
pub const STEP: f64 = 0.005;
/// How long the helicopter hovers before time 0, s.
pub const SETTLING: f64 = 20.0;
/// Steps from one reading of the barometer to the next: 20 a second.
const BAROMETER: i64 = 10;
/// By how much the height changes, m.
const CHANGE: f64 = 5.0;
/// Period of the smooth change, s.
const SMOOTH: f64 = 20.0;
/// From one abrupt change to the next, s.
const ABRUPT: f64 = 10.0;

/// The true range along the optical axis from a pose, m; none where the axis meets nothing.
pub type Range<'a> = dyn FnMut(Pose) -> Option<f64> + 'a;

/// What the height does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Altitude {
    /// It is held.
    #[default]
    Hold,
    /// A sine of 5 m and 20 s.
    Smooth,
    /// 5 m up, back, 5 m down, back, or first down: at once, every 10 s.
    Abrupt,
}

/// What a flight is to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup {
    /// Height over the mean ground, m.
    pub height: f64,
    /// Root mean square of each horizontal component of the gusts, m/s.
    pub gust_rms: f64,
    /// Mean wind towards `X_e` and `Y_e`, m/s.
    pub mean_wind: Vector2<f64>,
    /// Root mean square of the sensor's error of roll and of pitch, rad.
    pub tilt_noise: f64,
    /// Root mean square of its error of yaw, rad.
    pub heading_noise: f64,
    /// Root mean square of the laser's noise, m.
    pub laser_noise: f64,
    /// What the height does.
    pub altitude: Altitude,
    /// From what the place is held.
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

/// Why there is no such flight.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{name} must lie between {least} and {most} {unit}, not {value}")]
pub struct SetupError {
    /// What is out of its range.
    pub name: &'static str,
    /// Its least value.
    pub least: f64,
    /// Its largest value.
    pub most: f64,
    /// Of both.
    pub unit: &'static str,
    /// As given.
    pub value: f64,
}

impl Setup {
    /// Whether a flight can be had: the gusts' formulas are those of low altitude, up to 1000 feet; the helicopter is
    /// one about hover, and a side wind of 10 m/s takes 2.2 of the 3.5 degrees that the place loop may tilt it.
    ///
    /// # Errors
    /// A value is out of its range, or no number.
    pub fn check(&self) -> Result<(), SetupError> {
        let bounds = [
            ("height", self.height, 10.0, 300.0, "m"),
            ("rms of gusts", self.gust_rms, 0.0, 5.0, "m/s"),
            ("mean wind", self.mean_wind.norm(), 0.0, 10.0, "m/s"),
            ("tilt noise", self.tilt_noise, 0.0, 0.02, "rad"),
            ("heading noise", self.heading_noise, 0.0, 0.05, "rad"),
            ("laser noise", self.laser_noise, 0.0, 1.0, "m"),
        ];
        let wrong = bounds.into_iter().find(|(_, value, least, most, _)| !(least..=most).contains(&value));
        wrong.map_or(Ok(()), |(name, value, least, most, unit)| Err(SetupError { name, least, most, unit, value }))
    }
}

/// The truth of a moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Since the start, s.
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
    /// The height that is asked for, m.
    pub height: f64,
    /// Where the autopilot believes to be, from the place it holds, m.
    pub believed: Vector2<f64>,
    /// How much of the tilt is the place loop's: 1 while it holds the place, 0 in attitude hold.
    pub hold: f64,
}

/// A [`Moment`] as a row of a table.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Row {
    /// Since the start, s.
    pub time: f64,
    /// `X_e`, m.
    pub x: f64,
    /// `Y_e`, m.
    pub y: f64,
    /// Down from the mean ground, m.
    pub z: f64,
    /// Of the camera, rad.
    pub roll: f64,
    /// Of the camera, rad.
    pub pitch: f64,
    /// Of the camera, rad.
    pub yaw: f64,
    /// Along `X_e`, m/s.
    pub vx: f64,
    /// Along `Y_e`, m/s.
    pub vy: f64,
    /// Down, m/s.
    pub vz: f64,
    /// About the camera's axis along columns, rad/s.
    pub rate_x: f64,
    /// About its axis along rows, rad/s.
    pub rate_y: f64,
    /// About its optical axis, rad/s.
    pub rate_z: f64,
    /// Towards `X_e`, m/s.
    pub wind_x: f64,
    /// Towards `Y_e`, m/s.
    pub wind_y: f64,
    /// Down, m/s.
    pub wind_z: f64,
    /// From trim, rad.
    pub collective: f64,
    /// From trim, rad.
    pub longitudinal: f64,
    /// From trim, rad.
    pub lateral: f64,
    /// From trim, rad.
    pub tail: f64,
    /// Over the mean ground, m.
    pub height_wanted: f64,
    /// From the place that is held, along `X_e`, m.
    pub believed_x: f64,
    /// Along `Y_e`, m.
    pub believed_y: f64,
    /// 1 where the place is held, 0 in attitude hold.
    pub hold: f64,
}

impl Moment {
    /// The row.
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

/// What the sensors say at a moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Readings {
    /// Attitude of the camera.
    pub attitude: Attitude,
    /// Range along the optical axis, m; none where the laser met nothing.
    pub range: Option<f64>,
    /// The moment, s.
    pub time: f64,
}

/// A flight.
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
    /// Number of the point of the grid that the state is at; 0 at time 0.
    point: i64,
    /// The moment last asked for, s.
    now: f64,
    upwards: f64,
}

impl Flight {
    /// The flight of a seed, for a setup that passes [`Setup::check`].
    ///
    /// # Panics
    /// Never: the blade angles of the published derivatives command all four accelerations, which a test shows.
    pub fn new(setup: &Setup, seed: u64) -> Self {
        let aircraft = Aircraft::lynx();
        let actuators = Actuators::new(STEP);
        let state = aircraft.trimmed(setup.height);
        let climate = Climate { gust_rms: setup.gust_rms, mean: setup.mean_wind, height: setup.height };
        let wind = Wind::new(&climate, seed, STEP);
        let truth = inertial(&aircraft, &state, &wind, &actuators);
        let point = -(SETTLING / STEP).round() as i64;
        let start = point as f64 * STEP;
        let pilot = Autopilot::new(&Derivatives::lynx(), setup.tilt_noise, setup.height, start, STEP);
        let mut flight = Self {
            setup: *setup,
            actuators,
            imu: Imu::new(setup.tilt_noise, setup.heading_noise, &truth, seed, STEP),
            laser: Laser::new(setup.laser_noise, seed),
            barometer: Barometer::new(seed, BAROMETER as f64 * STEP),
            autopilot: pilot.expect("the blade angles command the four accelerations"),
            wind,
            state,
            point,
            now: 0.0,
            upwards: if stream(seed, Purpose::Flight).random::<bool>() { 1.0 } else { -1.0 },
            aircraft,
        };
        flight.settle();
        flight
    }

    /// The pilot's hover, until time 0.
    fn settle(&mut self) {
        while self.point < 0 {
            let displacement = self.aircraft.camera(&self.state).ground();
            let covariance = Matrix2::identity() * 1e-4;
            let exposed = self.point as f64 * STEP;
            self.autopilot.take(&Fix { displacement, covariance, height: None, yaw: None, exposed });
            self.step();
        }
        self.state[0] = 0.0;
        self.state[1] = 0.0;
        self.autopilot.set_hold(self.setup.mode);
        self.autopilot.engage(0.0);
    }

    /// The height that is asked for at a time, m, and its rate, m/s.
    fn height(&self, time: f64) -> [f64; 2] {
        let change = CHANGE * self.upwards;
        let [above, climb] = match self.setup.altitude {
            _ if time < 0.0 => [0.0, 0.0],
            Altitude::Hold => [0.0, 0.0],
            Altitude::Smooth => {
                let turns = std::f64::consts::TAU / SMOOTH;
                let (sin, cos) = libm::sincos(turns * time);
                [change * sin, change * turns * cos]
            }
            Altitude::Abrupt => [[0.0, change, 0.0, -change][(time / ABRUPT) as usize % 4], 0.0],
        };
        [self.setup.height + above, climb]
    }

    /// From one point of the grid to the next.
    fn step(&mut self) {
        self.state = self.aircraft.advance(&self.state, &self.wind.velocity(), &self.actuators.angles(), STEP);
        self.point += 1;
        let time = self.point as f64 * STEP;
        self.wind.advance();
        self.imu.advance(&inertial(&self.aircraft, &self.state, &self.wind, &self.actuators));
        let reading = self.imu.reading();
        if self.point % BAROMETER == 0 {
            self.autopilot.height(time, self.barometer.read(self.aircraft.camera(&self.state).height()));
        }
        let height = self.height(time);
        let command = self.autopilot.advance(time, reading, height);
        self.actuators.advance(&command);
    }

    /// The truth at a time, s, which must not lie before the one last asked for.
    pub fn advance(&mut self, to: f64) -> Moment {
        while (self.point + 1) as f64 * STEP <= to {
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
            height: self.height(to)[0],
            believed: self.autopilot.position(),
            hold: self.autopilot.weight(),
        }
    }

    /// The state at the moment last asked for.
    fn present(&self) -> State {
        let rest = self.now - self.point as f64 * STEP;
        self.aircraft.advance(&self.state, &self.wind.velocity(), &self.actuators.angles(), rest)
    }

    /// What the sensors say of a frame at the moment last asked for.
    pub fn readings(&mut self, laser: &mut Range) -> Readings {
        let range = laser(self.aircraft.camera(&self.present())).map(|range| self.laser.read(range));
        Readings { attitude: self.imu.reading().attitude, range, time: self.now }
    }

    /// Vision's result of a frame, at the moment last asked for; none where there is no estimate.
    pub fn take(&mut self, fix: Option<Fix>) {
        if let Some(fix) = fix {
            self.autopilot.take(&fix);
        }
    }

    /// Start of hold: the place to be held is where the helicopter is at the moment last asked for, which is to be the
    /// one when vision's reference is exposed.
    pub fn engage(&mut self) {
        self.autopilot.engage(self.point as f64 * STEP);
    }
}

/// What an inertial sensor without errors reads.
fn inertial(aircraft: &Aircraft, state: &State, wind: &Wind, actuators: &Actuators) -> Inertial {
    Inertial {
        attitude: aircraft.camera(state).attitude,
        rates: aircraft.rates(state),
        force: aircraft.specific_force(state, &wind.velocity(), &Vector4::from(actuators.angles())),
    }
}
