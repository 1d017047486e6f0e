//! The simulated world: steps scene, flight and camera together, frame by frame.

use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::orthophoto::ViewError;
use nalgebra::Vector3;

use crate::camera::{FRAME_RATE, FRAME_SIZE, Kt27, Motion, Optics};
use crate::flight::{Fix, Flight, InertialSample, Moment, Readings, Setup};
use crate::obstruction::Obstruction;
use crate::pose::Pose;
use crate::render::{Lens, Renderer, Shot};

/// A frame with the sensor readings and the truth at its exposure.
#[derive(Debug, Clone)]
pub struct Exposure {
    /// Samples of the frame.
    pub frame: Plane<u16>,
    /// Sensor readings.
    pub readings: Readings,
    /// Samples of the inertial sensor since the frame before, the oldest first.
    pub inertial: Vec<InertialSample>,
    /// True state.
    pub moment: Moment,
    /// Field of view across the columns, radians.
    pub field_of_view: f64,
}

/// A flight over a scene, with a camera.
pub struct World {
    renderer: Renderer,
    /// Camera with its zoom and exposure control.
    pub camera: Kt27,
    /// What is between scene and camera.
    pub obstruction: Obstruction,
    flight: Flight,
    radiance: Plane<f32>,
    time: f64,
    /// The exposure has been set to the scene by a first frame.
    exposure_settled: bool,
}

impl World {
    /// Creates a flight over a scene, with a field of view in degrees.
    pub fn new(renderer: Renderer, setup: &Setup, optics: Optics, field_of_view: f64, seed: u64) -> Self {
        let camera = Kt27::new(optics, field_of_view, seed);
        let radiance = Plane::filled(FRAME_SIZE.0, FRAME_SIZE.1, 0.0);
        let obstruction = Obstruction::default();
        let flight = Flight::new(setup, seed);
        Self { renderer, camera, obstruction, flight, radiance, time: 0.0, exposure_settled: false }
    }

    /// Advances to a time (s) and exposes a frame there.
    ///
    /// # Errors
    /// If the field of view is not valid, which the zoom range of the camera excludes.
    pub fn expose(&mut self, time: f64) -> Result<Exposure, ViewError> {
        let moment = self.advance(time);
        let renderer = &self.renderer;
        let optics = *self.camera.optics();
        let readings = self.flight.readings(&mut |pose| true_range(renderer, time, pose.turned(&optics.boresight)));
        let pinhole = self.camera.pinhole()?;
        let pose = moment.camera.turned(&optics.boresight);
        let (velocity, rates) = (moment.velocity, optics.boresight.rotation().transpose() * moment.rates);
        let last = pose.moved(&velocity, &rates, optics.readout_time);
        let [k1, k2] = optics.distortion;
        let shot = Shot { lens: Lens { camera: pinhole, k1, k2 }, first: pose, last, time };
        self.renderer.render(&shot, &mut self.radiance);
        self.obstruction.apply(&mut self.radiance);
        if !self.exposure_settled {
            self.exposure_settled = true;
            self.camera.settle_exposure(&self.radiance);
        }
        let motion = Motion::over_ground(&pinhole, &pose, &velocity, &rates, self.camera.exposure());
        let field_of_view = self.camera.field_of_view();
        let frame = self.camera.read_out(&mut self.radiance, &motion);
        Ok(Exposure { frame, readings, inertial: self.flight.take_inertial(), moment, field_of_view })
    }

    /// Advances to a time (s) and passes the vision fix of a frame to the autopilot; `None` if there is no estimate.
    pub fn apply_fix(&mut self, time: f64, fix: Option<Fix>) {
        self.advance(time);
        self.flight.apply_fix(fix);
    }

    /// Makes the present position the one to hold.
    pub fn engage(&mut self) {
        self.flight.engage();
    }

    /// Sets the velocity of a gust that comes on top of the wind, m/s.
    pub fn set_gust(&mut self, velocity: Vector3<f64>) {
        self.flight.set_gust(velocity);
    }

    /// Adds to the constant errors of the inertial sensor: angular rates (rad/s) and specific force (m/s^2).
    pub fn add_inertial_bias(&mut self, rates: &Vector3<f64>, force: &Vector3<f64>) {
        self.flight.add_inertial_bias(rates, force);
    }

    fn advance(&mut self, time: f64) -> Moment {
        self.camera.advance(time - self.time);
        self.time = time;
        self.flight.advance(time)
    }
}

/// Takes a single frame of a scene at rest, with settled exposure. `field_of_view` is in degrees, `seed` that of the
/// noise of the sensor.
///
/// # Errors
/// If the field of view is not valid, which the zoom range of the camera excludes.
pub fn still(renderer: &Renderer, pose: &Pose, field_of_view: f64, seed: u64) -> Result<Plane<u16>, ViewError> {
    let mut camera = Kt27::new(Optics::default(), field_of_view, seed);
    let lens = Lens { camera: camera.pinhole()?, k1: 0.0, k2: 0.0 };
    let mut radiance = Plane::filled(FRAME_SIZE.0, FRAME_SIZE.1, 0.0);
    renderer.render(&Shot { lens, first: *pose, last: *pose, time: 0.0 }, &mut radiance);
    camera.settle_exposure(&radiance);
    Ok(camera.read_out(&mut radiance, &Motion::default()))
}

/// Returns the time at which a frame is exposed, s.
pub fn frame_time(frame: usize) -> f64 {
    frame as f64 / FRAME_RATE
}

/// Returns the distance from a pose along the optical axis to the scene, m; `None` if there is no hit.
fn true_range(renderer: &Renderer, time: f64, pose: Pose) -> Option<f64> {
    renderer.range(time, pose.position, pose.attitude.rotation() * Vector3::z())
}
