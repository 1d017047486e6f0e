//! A camera over textured ground, `pixel = K R^T (point - position)`, and its IMU and laser readings.
//!
//! The world has `X`, `Y` horizontal and `Z` down, metres. The ground is `height - relief(X, Y)` below the camera. The
//! ray of a pixel is intersected with it by fixed-point iteration, which converges if slope times the tangent of the
//! viewing angle is below 1. A pixel is the mean of 2 x 2 rays, each a cubic interpolation (Keys, 1981) of a texture
//! that is mirrored at its borders.

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
/// Distance of a hill from the next hollow over `pi`, m.
const RELIEF_SCALE_M: f64 = 15.0;

/// The relief of the ground, `amplitude sin(X / 15 m + a) sin(Y / 15 m + b)`.
#[derive(Debug, Clone, Copy)]
pub struct Relief {
    /// Height of the hills and depth of the hollows, m.
    pub amplitude: f64,
    /// Phases `a` and `b`, radians.
    pub phase: Vector2<f64>,
}

impl Relief {
    /// Returns the height of the ground at `p`, m.
    fn height(&self, p: Vector2<f64>) -> f64 {
        let angle = p / RELIEF_SCALE_M + self.phase;
        self.amplitude * angle.x.sin() * angle.y.sin()
    }
}

/// The true pose of a camera.
#[derive(Debug, Clone, Copy)]
pub struct CameraPose {
    /// Pinhole camera.
    pub camera: Camera,
    /// Roll, pitch and yaw.
    pub attitude: Attitude,
    /// Horizontal position, m.
    pub position: Vector2<f64>,
    /// Height over the mean ground, m.
    pub height: f64,
}

impl CameraPose {
    /// Returns the ground point that a pixel shows, m.
    pub fn ground(&self, relief: &Relief, pixel: Vector2<f64>) -> Vector2<f64> {
        self.ray_caster().ground(relief, pixel)
    }

    /// Returns the pixel that shows a point of the ground.
    pub fn pixel(&self, relief: &Relief, point: Vector2<f64>) -> Vector2<f64> {
        let below = (point - self.position).push(self.height - relief.height(point));
        let image = self.camera.matrix() * (self.attitude.rotation().transpose() * below);
        image.xy() / image.z
    }

    /// Prepares the rays of all pixels.
    fn ray_caster(&self) -> RayCaster {
        RayCaster {
            rays: self.attitude.rotation() * self.camera.inverse(),
            position: self.position,
            height: self.height,
        }
    }

    /// Simulates the sensor readings, with noise of their standard errors times `scale`.
    pub fn readings(&self, relief: &Relief, sensors: &SensorErrors, scale: f64, rng: &mut ChaCha8Rng) -> View {
        let centre = Vector2::new(WIDTH as f64 - 1.0, HEIGHT as f64 - 1.0) / 2.0;
        let hit = self.ground(relief, centre);
        let range = (hit - self.position).push(self.height - relief.height(hit)).norm();
        let mut error = |sigma: f64| scale * sigma * normal(rng);
        let attitude = Attitude {
            roll: self.attitude.roll + error(sensors.tilt),
            pitch: self.attitude.pitch + error(sensors.tilt),
            yaw: self.attitude.yaw + error(sensors.heading),
        };
        View::new(self.camera, attitude, range + error(sensors.range)).expect("a hovering camera sees the ground")
    }
}

/// The rays of a camera pose, with the rotation applied once.
struct RayCaster {
    rays: Matrix3<f64>,
    position: Vector2<f64>,
    height: f64,
}

impl RayCaster {
    fn ground(&self, relief: &Relief, pixel: Vector2<f64>) -> Vector2<f64> {
        let ray = self.rays * pixel.push(1.0);
        let slope = ray.xy() / ray.z;
        let mut point = self.position + slope * self.height;
        if relief.amplitude > 0.0 {
            for _ in 0..12 {
                point = self.position + slope * (self.height - relief.height(point));
            }
        }
        point
    }
}

/// Returns a deviate of variance 1, the sum of twelve uniform numbers minus 6.
pub fn normal(rng: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
}

/// The ranges from which a flight between two frames is drawn.
#[derive(Debug, Clone, Copy)]
pub struct FlightRanges {
    /// Angle over the columns, degrees.
    pub field_of_view: f64,
    /// Largest roll and pitch, degrees.
    pub tilt: f64,
    /// Largest change of roll and pitch between the frames, degrees.
    pub tilt_between: f64,
    /// Largest change of yaw between the frames, degrees.
    pub yaw: f64,
    /// Largest displacement per axis, m.
    pub drift: f64,
    /// Largest change of altitude, m.
    pub climb: f64,
    /// Height of hills, m.
    pub relief: f64,
}

/// The truth of two frames of a flight, and the sensor readings.
#[derive(Debug, Clone, Copy)]
pub struct Flight {
    /// True poses of REF and CUR.
    pub poses: [CameraPose; 2],
    /// Relief of the ground.
    pub relief: Relief,
    /// IMU and laser readings of REF and CUR.
    pub views: [View; 2],
}

impl Flight {
    /// Draws a flight at a height of 100 m.
    pub fn draw(ranges: &FlightRanges, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut within = |limit: f64| limit * (2.0 * rng.random::<f64>() - 1.0);
        let camera = Camera::with_field_of_view(WIDTH, HEIGHT, ranges.field_of_view * DEGREE).expect("a camera");
        let tilt = ranges.tilt * DEGREE;
        let first = Attitude { roll: within(tilt), pitch: within(tilt), yaw: within(180.0 * DEGREE) };
        let mut near = |angle: f64| (angle + within(ranges.tilt_between * DEGREE)).clamp(-tilt, tilt);
        let (roll, pitch) = (near(first.roll), near(first.pitch));
        let second = Attitude { roll, pitch, yaw: first.yaw + within(ranges.yaw * DEGREE) };
        let displacement = Vector2::new(within(ranges.drift), within(ranges.drift));
        let climb = within(ranges.climb);
        let relief = Relief { amplitude: ranges.relief, phase: Vector2::new(within(3.0), within(3.0)) };
        let poses = [(first, Vector2::zeros(), 100.0), (second, displacement, 100.0 + climb)]
            .map(|(attitude, position, height)| CameraPose { camera, attitude, position, height });
        let views = poses.map(|pose| pose.readings(&relief, &SENSORS, 1.0, &mut rng));
        Self { poses, relief, views }
    }

    /// Returns the CUR pixel that shows the ground of a REF pixel.
    pub fn transfer(&self, pixel: Vector2<f64>) -> Vector2<f64> {
        self.poses[1].pixel(&self.relief, self.poses[0].ground(&self.relief, pixel))
    }

    /// Returns the displacement from REF to CUR, m.
    pub fn displacement(&self) -> Vector2<f64> {
        self.poses[1].position - self.poses[0].position
    }
}

/// Renders the frame of a camera over `texture`, whose texels are `texel` m wide and whose centre is the origin.
pub fn render(pose: &CameraPose, relief: &Relief, texture: &Plane<u16>, texel: f64) -> Plane<u16> {
    let middle = Vector2::new(texture.width() as f64, texture.height() as f64) / 2.0;
    render_with(pose, relief, |p| cubic(texture, p / texel + middle))
}

/// Renders the frame of a camera over a ground whose radiance is a function of the position, m.
pub fn render_with(pose: &CameraPose, relief: &Relief, ground: impl Fn(Vector2<f64>) -> f64 + Sync) -> Plane<u16> {
    let ray_caster = pose.ray_caster();
    let mut frame = Plane::filled(WIDTH, HEIGHT, 0u16);
    frame.as_mut_slice().par_chunks_exact_mut(WIDTH).enumerate().for_each(|(y, row)| {
        for (x, sample) in row.iter_mut().enumerate() {
            let mut sum = 0.0;
            for (dx, dy) in [(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)] {
                sum += ground(ray_caster.ground(relief, Vector2::new(x as f64 + dx, y as f64 + dy)));
            }
            // `as` clips the overshoot of the interpolation.
            *sample = (0.25 * sum).round() as u16;
        }
    });
    frame
}

/// Interpolates the texture at `p` (texels), mirrored at its borders.
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

/// Reflects an index at both ends of `0 .. size`.
fn mirrored(index: i64, size: usize) -> usize {
    let turn = index.rem_euclid(2 * size as i64) as usize;
    turn.min(2 * size - 1 - turn)
}
