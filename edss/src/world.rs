//! Scene, helicopter and camera in one clock, frame by frame.

use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::orthophoto::ViewError;
use nalgebra::Vector3;

use crate::camera::{FRAME_RATE, Kt27, Motion, Optics, SIZE};
use crate::flight::{Fix, Flight, Moment, Readings, Setup};
use crate::pose::Pose;
use crate::render::{Lens, Renderer, Shot};

/// A frame, and what was so when it was exposed.
#[derive(Debug, Clone)]
pub struct Exposure {
    /// The frame.
    pub frame: Plane<u16>,
    /// What the sensors say.
    pub readings: Readings,
    /// The truth.
    pub moment: Moment,
    /// Field of view across the columns, radians.
    pub field_of_view: f64,
}

/// The world of one flight.
pub struct World {
    renderer: Renderer,
    /// The camera.
    pub camera: Kt27,
    flight: Flight,
    radiance: Plane<f32>,
    time: f64,
    /// The camera has seen something, and its exposure follows.
    awake: bool,
}

impl World {
    /// A flight over a scene, with a camera at `field_of_view` degrees.
    pub fn new(renderer: Renderer, setup: &Setup, optics: Optics, field_of_view: f64, seed: u64) -> Self {
        let camera = Kt27::new(optics, field_of_view, seed);
        let radiance = Plane::filled(SIZE.0, SIZE.1, 0.0);
        Self { renderer, camera, flight: Flight::new(setup, seed), radiance, time: 0.0, awake: false }
    }

    /// Flies on to a time, s, and takes a frame there.
    ///
    /// # Errors
    /// None within the camera's zoom.
    pub fn expose(&mut self, time: f64) -> Result<Exposure, ViewError> {
        let moment = self.advance(time);
        let renderer = &self.renderer;
        let readings = self.flight.readings(&mut |pose| range(renderer, time, pose));
        let pinhole = self.camera.pinhole()?;
        let optics = self.camera.optics();
        let Moment { camera: pose, velocity, rates, .. } = moment;
        let last = pose.moved(&velocity, &rates, optics.rolling);
        let [k1, k2] = optics.distortion;
        let shot = Shot { lens: Lens { camera: pinhole, k1, k2 }, first: pose, last, time };
        self.renderer.render(&shot, &mut self.radiance);
        if !self.awake {
            self.awake = true;
            self.camera.settle(&self.radiance);
        }
        let motion = Motion::of(&pinhole, &pose, &velocity, &rates, self.camera.exposure());
        let field_of_view = self.camera.field_of_view();
        let frame = self.camera.read_out(&mut self.radiance, &motion);
        Ok(Exposure { frame, readings, moment, field_of_view })
    }

    /// Lets time pass, and tells the autopilot what vision makes of a frame; nothing where there is no estimate.
    pub fn take(&mut self, time: f64, fix: Option<Fix>) {
        self.advance(time);
        self.flight.take(fix);
    }

    /// The place to be held is where the helicopter is now.
    pub fn engage(&mut self) {
        self.flight.engage();
    }

    fn advance(&mut self, time: f64) -> Moment {
        self.camera.advance(time - self.time);
        self.time = time;
        self.flight.advance(time)
    }
}

/// The time of a frame, s.
pub fn exposed(frame: usize) -> f64 {
    frame as f64 / FRAME_RATE
}

/// What the laser hits from a pose, along the optical axis, m.
pub fn range(renderer: &Renderer, time: f64, pose: Pose) -> Option<f64> {
    renderer.range(time, pose.position, pose.attitude.rotation() * Vector3::z())
}
