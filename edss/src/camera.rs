//! The camera KT-27: converts radiance on the sensor into a frame of 16-bit samples.
//!
//! ```text
//! dust         v <- t v inside a speck                             after the motion, as it sits on the sensor
//! vignetting   v <- v cos^4(angle off the axis), softened          natural fall-off of a lens
//! motion       v <- mean of v along the motion during the exposure
//! electrons    e = v t s                                           t exposure, s electrons a second at radiance 1
//! noise        e <- e + N(0, e + r^2)                              shot noise (Poisson), read noise r
//! sample       round(e g), clipped to 0 ..= 65535                  g so that the full well is full scale at gain 1
//! ```
//!
//! Shot and read noise are one draw, a sum of four uniform numbers: variance exact, excess kurtosis -0.3, range +-3.46.
//! The zoom moves at a limited rate. Exposure and gain follow the mean of the last frame. The maker publishes only a
//! few figures (1024 x 768, 16 bit, 5.4 to 50 degrees, 15 frames a second); the others are assumptions, collected in
//! [`Optics`].

use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::orthophoto::{Attitude, Camera, ViewError};
use nalgebra::{Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;
use rayon::prelude::*;

use crate::obstruction::mean;
use crate::pose::Pose;
use crate::random::{Purpose, stream};

/// Columns and rows of a frame, pixels.
pub const FRAME_SIZE: (usize, usize) = (1024, 768);
/// Frame rate, 1/s.
pub const FRAME_RATE: f64 = 15.0;
/// Smallest and largest field of view across the columns.
pub const FIELD_OF_VIEW_RANGE_DEG: [f64; 2] = [5.4, 50.0];
/// Largest value of a sample, DN.
const FULL_SCALE: f64 = 65535.0;

/// The assumed properties of lens, sensor and exposure control.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Optics {
    /// Largest zoom rate, degrees/s. At 15 frames a second, 6 degrees/s change a view of 20 degrees by 2 % a frame.
    pub zoom_rate: f64,
    /// Part of the natural fall-off of light towards the edges that the lens does not correct, 0 to 1.
    pub vignetting: f64,
    /// Residual radial distortion `k1` and `k2` after calibration, of normalised coordinates (Brown 1966).
    pub distortion: [f64; 2],
    /// Time from the read-out of the first row to that of the last, s; 0 for a global shutter.
    pub readout_time: f64,
    /// Rotation of the camera relative to the inertial sensor that nobody knows of.
    pub boresight: Attitude,
    /// Number of specks of dust on the sensor.
    pub specks: u32,
    /// Capacity of a pixel, electrons.
    pub full_well: f64,
    /// Read noise, electrons rms.
    pub read_noise: f64,
    /// Exposure at which radiance 1 fills the well, s.
    pub fill_time: f64,
    /// Longest automatic exposure, s: longer ones blur.
    pub max_exposure: f64,
    /// Mean of a frame at which the exposure control aims, as a fraction of full scale.
    pub target_mean: f64,
    /// Largest automatic gain.
    pub max_gain: f64,
}

impl Default for Optics {
    fn default() -> Self {
        Self {
            zoom_rate: 6.0,
            vignetting: 0.5,
            distortion: [0.0; 2],
            readout_time: 0.0,
            boresight: Attitude::default(),
            specks: 0,
            full_well: 20_000.0,
            read_noise: 12.0,
            fill_time: 2e-3,
            max_exposure: 4e-3,
            target_mean: 0.45,
            max_gain: 4.0,
        }
    }
}

/// The motion of the picture during an exposure, px: `v(p) = centre + linear (p - c)`, `c` the middle of the frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// Motion in the middle of the frame, px.
    pub centre: Vector2<f64>,
    /// Change of the motion per pixel along `x` and along `y`, px/px.
    pub linear: [Vector2<f64>; 2],
}

impl Motion {
    /// Computes the motion for a camera over level ground during `seconds`: the ground of each pixel is projected from
    /// the later pose.
    pub fn over_ground(
        pinhole: &Camera,
        pose: &Pose,
        velocity: &Vector3<f64>,
        rates: &Vector3<f64>,
        seconds: f64,
    ) -> Self {
        let later = pose.moved(velocity, rates, seconds);
        let rays = pose.attitude.rotation() * pinhole.inverse();
        let back = pinhole.matrix() * later.attitude.rotation().transpose();
        let moved = |p: Vector2<f64>| {
            let ray = rays * p.push(1.0);
            let point = pose.position + ray * (pose.height() / ray.z);
            let image = back * (point - later.position);
            image.xy() / image.z - p
        };
        let middle = Vector2::new(FRAME_SIZE.0 as f64 - 1.0, FRAME_SIZE.1 as f64 - 1.0) / 2.0;
        let centre = moved(middle);
        let step = 200.0;
        let slope = |axis: Vector2<f64>| (moved(middle + step * axis) - centre) / step;
        Self { centre, linear: [slope(Vector2::x()), slope(Vector2::y())] }
    }
}

/// Motion at the corners, px, below which no blur is drawn: its standard deviation would be 0.06 px.
const MIN_BLUR_PX: f64 = 0.2;

/// A speck of dust on the sensor.
#[derive(Debug, Clone, Copy)]
struct Speck {
    /// Middle, px.
    at: [f64; 2],
    /// Radius, px.
    radius: f64,
    /// Part of the light that passes.
    transmission: f32,
}

impl Speck {
    fn draw(random: &mut ChaCha8Rng) -> Self {
        let mut uniform = |min: f64, max: f64| min + (max - min) * random.random::<f64>();
        let at = [uniform(0.0, FRAME_SIZE.0 as f64), uniform(0.0, FRAME_SIZE.1 as f64)];
        Self { at, radius: uniform(1.0, 5.0), transmission: uniform(0.2, 0.9) as f32 }
    }

    /// Darkens the pixels inside.
    fn darken(&self, radiance: &mut Plane<f32>) {
        let [x, y] = self.at;
        let span = |middle: f64, end: usize| {
            let first = (middle - self.radius).ceil().max(0.0) as usize;
            first..((middle + self.radius).floor() as usize + 1).min(end)
        };
        let (columns, rows) = (span(x, radiance.width()), span(y, radiance.height()));
        for row in rows {
            for column in columns.clone() {
                if (column as f64 - x).hypot(row as f64 - y) <= self.radius {
                    radiance[(column, row)] *= self.transmission;
                }
            }
        }
    }
}

/// The camera with its zoom and exposure control.
#[derive(Debug, Clone)]
pub struct Kt27 {
    optics: Optics,
    seed: u64,
    frames: u64,
    field_of_view: f64,
    wanted: f64,
    exposure: f64,
    gain: f64,
    dust: Vec<Speck>,
}

impl Kt27 {
    /// Creates a camera with a field of view in degrees, before its first frame.
    pub fn new(optics: Optics, field_of_view: f64, seed: u64) -> Self {
        let field_of_view = field_of_view.clamp(FIELD_OF_VIEW_RANGE_DEG[0], FIELD_OF_VIEW_RANGE_DEG[1]);
        let exposure = (optics.target_mean * optics.fill_time).min(optics.max_exposure);
        let mut random = stream(seed, Purpose::Dust);
        let dust = (0..optics.specks).map(|_| Speck::draw(&mut random)).collect();
        Self { optics, seed, frames: 0, field_of_view, wanted: field_of_view, exposure, gain: 1.0, dust }
    }

    /// Returns the assumed properties.
    pub fn optics(&self) -> &Optics {
        &self.optics
    }

    /// Returns the field of view across the columns, radians.
    pub fn field_of_view(&self) -> f64 {
        self.field_of_view.to_radians()
    }

    /// Returns the pinhole camera at the present zoom.
    ///
    /// # Errors
    /// If the field of view is not valid, which [`FIELD_OF_VIEW_RANGE_DEG`] excludes.
    pub fn pinhole(&self) -> Result<Camera, ViewError> {
        Camera::with_field_of_view(FRAME_SIZE.0, FRAME_SIZE.1, self.field_of_view())
    }

    /// Returns the exposure of the next frame, s.
    pub fn exposure(&self) -> f64 {
        self.exposure
    }

    /// Sets the field of view to move to, degrees, clamped to [`FIELD_OF_VIEW_RANGE_DEG`].
    pub fn zoom(&mut self, degrees: f64) {
        self.wanted = degrees.clamp(FIELD_OF_VIEW_RANGE_DEG[0], FIELD_OF_VIEW_RANGE_DEG[1]);
    }

    /// Advances the zoom by `seconds`.
    pub fn advance(&mut self, seconds: f64) {
        let most = self.optics.zoom_rate * seconds;
        self.field_of_view += (self.wanted - self.field_of_view).clamp(-most, most);
    }

    /// Sets exposure and gain to the values at which the control settles for this radiance.
    pub fn settle_exposure(&mut self, radiance: &Plane<f32>) {
        let light = self.optics.target_mean * self.optics.fill_time / mean(radiance.as_slice()).max(0.01);
        self.exposure = light.min(self.optics.max_exposure);
        self.gain = (light / self.exposure).clamp(1.0, self.optics.max_gain);
    }

    /// Converts radiance into a frame and updates exposure and gain for the next. Overwrites `radiance` by its blurred
    /// version.
    pub fn read_out(&mut self, radiance: &mut Plane<f32>, motion: &Motion) -> Plane<u16> {
        let (width, height) = (radiance.width(), radiance.height());
        if let Some(blurred) = motion_blurred(radiance, motion) {
            *radiance = blurred;
        }
        self.dust.iter().for_each(|speck| speck.darken(radiance));
        let optics = self.optics;
        let electrons = (optics.full_well * self.exposure / optics.fill_time) as f32;
        let per_electron = (FULL_SCALE / optics.full_well * self.gain) as f32;
        let read = (optics.read_noise * optics.read_noise) as f32;
        let focal = (width as f64 / 2.0 / libm::tan(self.field_of_view() / 2.0)) as f32;
        let loss = optics.vignetting as f32;
        let middle = ((width as f32 - 1.0) / 2.0, (height as f32 - 1.0) / 2.0);
        let seed = self.seed;
        let first = self.frames * height as u64;
        let mut frame = Plane::filled(width, height, 0u16);
        let rows = frame.as_mut_slice().par_chunks_exact_mut(width);
        let sum: u64 = rows
            .zip(radiance.as_slice().par_chunks_exact(width))
            .enumerate()
            .map(|(y, (to, from))| {
                let mut random = row_stream(seed, first + y as u64);
                let mut bytes = vec![0u8; 8 * width];
                random.fill_bytes(&mut bytes);
                let dy = (y as f32 - middle.1) / focal;
                let mut sum = 0u64;
                for (x, (to, &value)) in to.iter_mut().zip(from).enumerate() {
                    let dx = (x as f32 - middle.0) / focal;
                    let cos2 = 1.0 / (1.0 + dx * dx + dy * dy);
                    let light = value * (1.0 - loss * (1.0 - cos2 * cos2));
                    let mean = (light * electrons).max(0.0);
                    let draw = deviate(&bytes[8 * x..8 * x + 8]);
                    let noisy = mean + (mean + read).sqrt() * draw;
                    // `as` clips to 0 ..= 65535.
                    *to = (noisy * per_electron + 0.5) as u16;
                    sum += u64::from(*to);
                }
                sum
            })
            .sum();
        self.frames += 1;
        self.update_exposure(sum as f64 / (width * height) as f64 / FULL_SCALE);
        frame
    }

    /// Moves exposure and gain a fifth of the way towards the target mean.
    fn update_exposure(&mut self, mean: f64) {
        let wanted = self.exposure * self.gain * (self.optics.target_mean / mean.max(0.01)).clamp(0.5, 2.0);
        let light = self.exposure * self.gain + 0.2 * (wanted - self.exposure * self.gain);
        self.exposure = light.min(self.optics.max_exposure);
        self.gain = (light / self.exposure).clamp(1.0, self.optics.max_gain);
    }
}

/// Returns the random stream of a row, counted over all frames, so that rows can be drawn in any order.
fn row_stream(seed: u64, row: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream((Purpose::Camera as u64) << 56 | row);
    random
}

/// Converts eight random bytes into a deviate of mean 0 and variance 1: a normalised sum of four uniform numbers.
fn deviate(bytes: &[u8]) -> f32 {
    let sum: u32 = bytes.chunks_exact(2).map(|pair| u32::from(u16::from_le_bytes([pair[0], pair[1]]))).sum();
    // 2 x 65535, and sqrt(4 (65536^2 - 1) / 12).
    (sum as f32 - 131_070.0) * (1.0 / 37_837.227)
}

/// Averages the picture along the motion; returns `None` if the motion is negligible.
fn motion_blurred(radiance: &Plane<f32>, motion: &Motion) -> Option<Plane<f32>> {
    let (width, height) = (radiance.width(), radiance.height());
    let middle = Vector2::new(width as f64 - 1.0, height as f64 - 1.0) / 2.0;
    let at =
        |p: Vector2<f64>| motion.centre + motion.linear[0] * (p.x - middle.x) + motion.linear[1] * (p.y - middle.y);
    let corners = [(0.0, 0.0), (2.0, 0.0), (0.0, 2.0), (2.0, 2.0)];
    let longest = corners.iter().map(|(x, y)| at(Vector2::new(x * middle.x, y * middle.y)).norm()).fold(0.0, f64::max);
    if longest < MIN_BLUR_PX {
        return None;
    }
    // A point every half pixel or closer; the mid-points of equal parts have the mean and, nearly, the variance.
    let taps = ((2.0 * longest).ceil() as usize).clamp(2, 64);
    let mut blurred = Plane::filled(width, height, 0f32);
    blurred.as_mut_slice().par_chunks_exact_mut(width).enumerate().for_each(|(y, row)| {
        let first = at(Vector2::new(0.0, y as f64));
        for (x, to) in row.iter_mut().enumerate() {
            let v = first + motion.linear[0] * x as f64;
            let mut sum = 0.0;
            for tap in 0..taps {
                let part = ((tap as f64 + 0.5) / taps as f64) - 0.5;
                sum += bilinear(radiance, x as f32 + (part * v.x) as f32, y as f32 + (part * v.y) as f32);
            }
            *to = sum / taps as f32;
        }
    });
    Some(blurred)
}

fn bilinear(plane: &Plane<f32>, x: f32, y: f32) -> f32 {
    let (right, bottom) = (plane.width() - 1, plane.height() - 1);
    let (x, y) = (x.clamp(0.0, right as f32), y.clamp(0.0, bottom as f32));
    let (left, top) = ((x as usize).min(right.saturating_sub(1)), (y as usize).min(bottom.saturating_sub(1)));
    let (s, t) = (x - left as f32, y - top as f32);
    let (upper, lower) = (plane.row(top), plane.row((top + 1).min(bottom)));
    let beside = (left + 1).min(right);
    let above = upper[left] + s * (upper[beside] - upper[left]);
    let below = lower[left] + s * (lower[beside] - lower[left]);
    above + t * (below - above)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_reference::motion::orthophoto::Attitude;

    fn quiet() -> Optics {
        Optics { vignetting: 0.0, ..Optics::default() }
    }

    fn statistics(samples: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
        let n = samples.clone().count() as f64;
        let mean = samples.clone().sum::<f64>() / n;
        (mean, samples.map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0))
    }

    /// A grey wall: the variance of a sample is that of its electrons and of the read-out. With 786 432 samples the
    /// standard error of the variance is 0.16 %.
    #[test]
    fn the_noise_is_that_of_electrons_and_read_out() {
        for grey in [0.02f32, 0.3, 0.8] {
            let mut camera = Kt27::new(quiet(), 50.0, 5);
            let exposure = camera.exposure();
            let frame = camera.read_out(&mut Plane::filled(FRAME_SIZE.0, FRAME_SIZE.1, grey), &Motion::default());
            let (mean, variance) = statistics(frame.as_slice().iter().map(|&dn| f64::from(dn)));
            let electrons = 20_000.0 * exposure / 2e-3 * f64::from(grey);
            let dn = 65535.0 / 20_000.0;
            assert!((mean / (electrons * dn) - 1.0).abs() < 1e-3, "{grey}: {mean}");
            // Rounding adds a twelfth.
            let expected = (electrons + 144.0) * dn * dn + 1.0 / 12.0;
            assert!((variance / expected - 1.0).abs() < 0.01, "{grey}: {variance} {expected}");
        }
    }

    #[test]
    fn frames_differ_and_seeds_repeat() {
        let frames = |seed| {
            let mut camera = Kt27::new(quiet(), 50.0, seed);
            [0, 1].map(|_| camera.read_out(&mut Plane::filled(64, 48, 0.5), &Motion::default()))
        };
        assert_eq!(frames(1), frames(1));
        assert_ne!(frames(1)[0], frames(1)[1]);
        assert_ne!(frames(1)[0], frames(2)[0]);
    }

    #[test]
    fn the_light_falls_off_with_the_fourth_power_of_the_cosine() {
        let silent = Optics { full_well: 1e9, read_noise: 0.0, vignetting: 1.0, ..Optics::default() };
        let mut camera = Kt27::new(silent, 50.0, 0);
        let frame = camera.read_out(&mut Plane::filled(FRAME_SIZE.0, FRAME_SIZE.1, 0.9), &Motion::default());
        let focal = 512.0 / 25f64.to_radians().tan();
        let angle = (512.0f64.hypot(384.0) / focal).atan();
        let measured = f64::from(frame[(0, 0)]) / f64::from(frame[(512, 384)]);
        assert!((measured - angle.cos().powi(4)).abs() < 2e-3, "{measured}");
    }

    /// A step moved by 6 px during the exposure becomes a ramp of 6 px about its middle.
    #[test]
    fn motion_blurs_along_its_direction() {
        let silent = Optics { full_well: 1e9, read_noise: 0.0, ..quiet() };
        let mut camera = Kt27::new(silent, 50.0, 0);
        let mut step = Plane::from_fn(64, 48, |x, _| if x < 32 { 0.0f32 } else { 0.8 });
        let motion = Motion { centre: Vector2::new(6.0, 0.0), ..Motion::default() };
        let frame = camera.read_out(&mut step, &motion);
        let full = f64::from(frame[(60, 20)]);
        // The step lies between columns 31 and 32.
        for x in 26..38usize {
            let ramp = ((x as f64 - 31.5) / 6.0 + 0.5).clamp(0.0, 1.0);
            let measured = f64::from(frame[(x, 20)]) / full;
            assert!((measured - ramp).abs() < 0.06, "{x}: {measured} {ramp}");
        }
        let along = Motion { centre: Vector2::new(0.0, 6.0), ..Motion::default() };
        let mut step = Plane::from_fn(64, 48, |x, _| if x < 32 { 0.0f32 } else { 0.8 });
        assert_eq!(camera.read_out(&mut step, &along)[(31, 20)], 0, "a step along the motion stays");
    }

    /// Level, 50 m up: 1 m/s to the right moves the ground to the left by f / 50 px a second; a yaw turns the picture
    /// the other way; a descent opens it.
    #[test]
    fn the_picture_moves_against_the_camera() {
        let pinhole = Camera::with_field_of_view(FRAME_SIZE.0, FRAME_SIZE.1, 50f64.to_radians()).unwrap();
        let position = Vector3::new(0.0, 0.0, -50.0);
        let pose = Pose { position, attitude: Attitude::default() };
        let of = |velocity, rates| Motion::over_ground(&pinhole, &pose, &velocity, &rates, 1e-3);
        let right = of(Vector3::x(), Vector3::zeros());
        assert!((right.centre - Vector2::new(-pinhole.focal() / 50.0 * 1e-3, 0.0)).norm() < 1e-6);
        assert!(right.linear[0].norm() < 1e-9 && right.linear[1].norm() < 1e-9);
        let yaw = of(Vector3::zeros(), Vector3::z());
        assert!((yaw.linear[0] - Vector2::new(0.0, -1e-3)).norm() < 1e-5, "{yaw:?}");
        assert!((yaw.linear[1] - Vector2::new(1e-3, 0.0)).norm() < 1e-5);
        let down = of(Vector3::z(), Vector3::zeros());
        assert!((down.linear[0] - Vector2::new(1e-3 / 50.0, 0.0)).norm() < 1e-7, "{down:?}");
    }

    #[test]
    fn zoom_is_limited_in_range_and_rate() {
        let mut camera = Kt27::new(quiet(), 50.0, 0);
        camera.zoom(1.0);
        camera.advance(1.0);
        assert!((camera.field_of_view().to_degrees() - 44.0).abs() < 1e-9);
        camera.advance(100.0);
        assert!((camera.field_of_view().to_degrees() - FIELD_OF_VIEW_RANGE_DEG[0]).abs() < 1e-9);
    }

    #[test]
    fn exposure_control_reaches_the_target_mean() {
        let mut camera = Kt27::new(quiet(), 50.0, 0);
        let mut mean = 0.0;
        for _ in 0..60 {
            let frame = camera.read_out(&mut Plane::filled(256, 192, 0.15), &Motion::default());
            mean = statistics(frame.as_slice().iter().map(|&dn| f64::from(dn))).0 / 65535.0;
        }
        assert!((mean - 0.45).abs() < 0.01, "{mean}");
        assert!(camera.exposure() <= 4e-3);
    }
}
