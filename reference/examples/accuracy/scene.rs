//! A camera over textured ground: `pixel = K R^T (point - place)`, and what IMU and laser say of it.
//!
//! The world has `X`, `Y` horizontal and `Z` down, metres. The ground lies `height - relief(X, Y)` below the camera. A
//! pixel's ray is intersected with it by fixed-point iteration, which contracts as long as slope times the tangent of
//! the viewing angle is below 1. A pixel is the mean of 2 x 2 rays, each a cubic interpolation (Keys, 1981) of a
//! texture that is mirrored at its borders.

use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reference::motion::orthophoto::{Attitude, Camera, View};
use nalgebra::{Matrix3, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Columns of a frame.
pub const WIDTH: usize = 1024;
/// Rows of a frame.
pub const HEIGHT: usize = 768;
/// One degree, radians.
pub const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// Standard errors of the simulated readings.
pub const SENSORS: SensorErrors = SensorErrors { tilt: 0.2 * DEGREE, heading: 0.5 * DEGREE, range: 0.1 };
/// Hills and hollows are `pi` times this apart, m.
const RELIEF_SCALE: f64 = 15.0;

/// Hills `amplitude sin(X / 15 m + a) sin(Y / 15 m + b)` high.
#[derive(Debug, Clone, Copy)]
pub struct Relief {
    /// Height of the hills and depth of the hollows, m.
    pub amplitude: f64,
    /// `a`, `b`, radians.
    pub phase: Vector2<f64>,
}

impl Relief {
    fn height(&self, p: Vector2<f64>) -> f64 {
        let angle = p / RELIEF_SCALE + self.phase;
        self.amplitude * angle.x.sin() * angle.y.sin()
    }
}

/// Where a camera truly is.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// The camera.
    pub camera: Camera,
    /// Its attitude.
    pub attitude: Attitude,
    /// Over the ground, m.
    pub place: Vector2<f64>,
    /// Over the mean ground, m.
    pub height: f64,
}

impl Place {
    /// The ground that a pixel sees, m, and its distance along the ray's `z`.
    pub fn ground(&self, relief: &Relief, pixel: Vector2<f64>) -> Vector2<f64> {
        self.looker().ground(relief, pixel)
    }

    /// The pixel that sees a point of the ground.
    pub fn pixel(&self, relief: &Relief, point: Vector2<f64>) -> Vector2<f64> {
        let below = (point - self.place).push(self.height - relief.height(point));
        let image = self.camera.matrix() * (self.attitude.rotation().transpose() * below);
        image.xy() / image.z
    }

    fn looker(&self) -> Looker {
        Looker { rays: self.attitude.rotation() * self.camera.inverse(), place: self.place, height: self.height }
    }

    /// What the sensors tell, with noise of their standard errors times `scale`.
    pub fn told(&self, relief: &Relief, sensors: &SensorErrors, scale: f64, rng: &mut ChaCha8Rng) -> View {
        let centre = Vector2::new(WIDTH as f64 - 1.0, HEIGHT as f64 - 1.0) / 2.0;
        let hit = self.ground(relief, centre);
        let range = (hit - self.place).push(self.height - relief.height(hit)).norm();
        let mut error = |sigma: f64| scale * sigma * normal(rng);
        let attitude = Attitude {
            roll: self.attitude.roll + error(sensors.tilt),
            pitch: self.attitude.pitch + error(sensors.tilt),
            yaw: self.attitude.yaw + error(sensors.heading),
        };
        View::new(self.camera, attitude, range + error(sensors.range)).expect("a hovering camera sees the ground")
    }
}

struct Looker {
    rays: Matrix3<f64>,
    place: Vector2<f64>,
    height: f64,
}

impl Looker {
    fn ground(&self, relief: &Relief, pixel: Vector2<f64>) -> Vector2<f64> {
        let ray = self.rays * pixel.push(1.0);
        let slope = ray.xy() / ray.z;
        let mut point = self.place + slope * self.height;
        if relief.amplitude > 0.0 {
            for _ in 0..12 {
                point = self.place + slope * (self.height - relief.height(point));
            }
        }
        point
    }
}

/// The sum of twelve uniform numbers less 6: variance 1.
pub fn normal(rng: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
}

/// What a flight between two frames is drawn from.
#[derive(Debug, Clone, Copy)]
pub struct Course {
    /// Angle over the columns, degrees.
    pub field_of_view: f64,
    /// Roll and pitch of REF lie within this, degrees.
    pub tilt: f64,
    /// Roll and pitch of CUR differ from them by at most this, and are within `tilt`, degrees.
    pub tilt_between: f64,
    /// Yaw between the frames, degrees, at most.
    pub yaw: f64,
    /// Displacement an axis, m, at most.
    pub drift: f64,
    /// Change of altitude, m, at most.
    pub climb: f64,
    /// Height of hills, m.
    pub relief: f64,
}

/// Two frames of a flight, as they truly were.
#[derive(Debug, Clone, Copy)]
pub struct Flight {
    /// REF and CUR.
    pub places: [Place; 2],
    /// The ground between.
    pub relief: Relief,
    /// What IMU and laser say.
    pub views: [View; 2],
}

impl Flight {
    /// A flight 100 m up.
    pub fn draw(course: &Course, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut within = |most: f64| most * (2.0 * rng.random::<f64>() - 1.0);
        let camera = Camera::with_field_of_view(WIDTH, HEIGHT, course.field_of_view * DEGREE).expect("a camera");
        let tilt = course.tilt * DEGREE;
        let first = Attitude { roll: within(tilt), pitch: within(tilt), yaw: within(180.0 * DEGREE) };
        let mut near = |angle: f64| (angle + within(course.tilt_between * DEGREE)).clamp(-tilt, tilt);
        let (roll, pitch) = (near(first.roll), near(first.pitch));
        let second = Attitude { roll, pitch, yaw: first.yaw + within(course.yaw * DEGREE) };
        let displacement = Vector2::new(within(course.drift), within(course.drift));
        let climb = within(course.climb);
        let relief = Relief { amplitude: course.relief, phase: Vector2::new(within(3.0), within(3.0)) };
        let places = [(first, Vector2::zeros(), 100.0), (second, displacement, 100.0 + climb)]
            .map(|(attitude, place, height)| Place { camera, attitude, place, height });
        let views = places.map(|place| place.told(&relief, &SENSORS, 1.0, &mut rng));
        Self { places, relief, views }
    }

    /// Where the ground of a REF pixel is in CUR.
    pub fn transfer(&self, pixel: Vector2<f64>) -> Vector2<f64> {
        self.places[1].pixel(&self.relief, self.places[0].ground(&self.relief, pixel))
    }

    /// From REF to CUR, m.
    pub fn displacement(&self) -> Vector2<f64> {
        self.places[1].place - self.places[0].place
    }
}

/// The frame that a camera at `place` takes of `texture`, one texel of which is `texel` m, its middle at the origin.
pub fn render(place: &Place, relief: &Relief, texture: &Plane<u16>, texel: f64) -> Plane<u16> {
    let middle = Vector2::new(texture.width() as f64, texture.height() as f64) / 2.0;
    render_with(place, relief, |p| cubic(texture, p / texel + middle))
}

/// The frame of a ground whose radiance is a function of the place.
pub fn render_with(place: &Place, relief: &Relief, ground: impl Fn(Vector2<f64>) -> f64 + Sync) -> Plane<u16> {
    let looker = place.looker();
    let mut frame = Plane::filled(WIDTH, HEIGHT, 0u16);
    frame.as_mut_slice().par_chunks_exact_mut(WIDTH).enumerate().for_each(|(y, row)| {
        for (x, sample) in row.iter_mut().enumerate() {
            let mut sum = 0.0;
            for (dx, dy) in [(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)] {
                sum += ground(looker.ground(relief, Vector2::new(x as f64 + dx, y as f64 + dy)));
            }
            // `as` clips the overshoot of the interpolation.
            *sample = (0.25 * sum).round() as u16;
        }
    });
    frame
}

fn cubic(texture: &Plane<u16>, p: Vector2<f64>) -> f64 {
    let (left, top) = (p.x.floor(), p.y.floor());
    let weights = |t: f64| {
        let (t2, t3) = (t * t, t * t * t);
        [-0.5 * t3 + t2 - 0.5 * t, 1.5 * t3 - 2.5 * t2 + 1.0, -1.5 * t3 + 2.0 * t2 + 0.5 * t, 0.5 * t3 - 0.5 * t2]
    };
    let (wx, wy) = (weights(p.x - left), weights(p.y - top));
    let columns: [usize; 4] = std::array::from_fn(|i| mirrored(left as i64 - 1 + i as i64, texture.width()));
    (0..4)
        .map(|j| {
            let row = texture.row(mirrored(top as i64 - 1 + j as i64, texture.height()));
            wy[j] * (0..4).map(|i| wx[i] * f64::from(row[columns[i]])).sum::<f64>()
        })
        .sum()
}

fn mirrored(index: i64, size: usize) -> usize {
    let turn = index.rem_euclid(2 * size as i64) as usize;
    turn.min(2 * size - 1 - turn)
}
