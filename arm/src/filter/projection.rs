//! The image of a keyframe's landmark in the present frame, with its derivatives.

use super::rotation::{exponential, skew};
use super::{CameraPose, ERRORS, PAIR, POSE};
use crate::calibration::Calibration;
use hoverlock_reference::motion::orthophoto::Camera;
use nalgebra::{Matrix2, Matrix2x3, Matrix3, SMatrix, SVector, Vector2, Vector3};

/// Newton's steps of the inverse of the lens: 1e-6 of the radius at a distortion of 10 %.
const LENS_STEPS: usize = 3;
/// A camera with its motion while it is read out.
#[derive(Debug, Clone, Copy)]
pub(super) struct MovingCamera {
    pub(super) pose: CameraPose,
    /// In the level frame, m/s.
    pub(super) velocity: Vector3<f64>,
    /// About the camera's axes, rad/s.
    pub(super) rates: Vector3<f64>,
}

impl MovingCamera {
    /// Returns the pose after `seconds`.
    pub(super) fn after(&self, seconds: f64) -> CameraPose {
        // To first order: a read-out turns the camera by milliradians.
        CameraPose {
            position: self.pose.position + self.velocity * seconds,
            rotation: self.pose.rotation * (Matrix3::identity() + skew(&(self.rates * seconds))),
        }
    }
}

/// Errors of the camera, as in the [module](self).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct CameraErrors {
    pub(super) distortion: f64,
    pub(super) readout_s: f64,
    pub(super) focal: f64,
    pub(super) delay_s: f64,
}

impl CameraErrors {
    /// Returns the values of a calibration, which does not know the delay.
    pub(super) fn of(calibration: &Calibration) -> Self {
        let Calibration { k1, readout_s, focal, .. } = calibration;
        Self { distortion: k1.value, readout_s: readout_s.value, focal: focal.value, delay_s: 0.0 }
    }

    /// Adds errors in the order of the states.
    pub(super) fn add(&mut self, change: &SVector<f64, ERRORS>) {
        self.distortion += change.x;
        self.readout_s += change.y;
        self.focal += change.z;
        self.delay_s += change.w;
    }

    /// Returns the time of exposure of a part of the rows, s after the time stamp.
    fn exposed_s(&self, part: f64) -> f64 {
        self.delay_s + self.readout_s * part
    }

    /// Returns the normalised coordinates at which a direction appears, and their derivative.
    pub(super) fn distorted(&self, u: &Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
        let stretch = 1.0 + self.distortion * u.norm_squared();
        (u * stretch, Matrix2::identity() * stretch + u * u.transpose() * (2.0 * self.distortion))
    }

    /// Returns the normalised coordinates of the direction that appears at `seen`.
    pub(super) fn straight(&self, seen: &Vector2<f64>) -> Vector2<f64> {
        let k = self.distortion * seen.norm_squared();
        let mut ratio = 1.0;
        for _ in 0..LENS_STEPS {
            // The bound keeps the result finite beyond the fold of a lens.
            let rate = (1.0 + 3.0 * k * ratio * ratio).max(0.1);
            ratio -= (ratio * (1.0 + k * ratio * ratio) - 1.0) / rate;
        }
        seen * ratio
    }
}

/// What the images of a keyframe's landmarks in the present frame depend on.
#[derive(Debug, Clone, Copy)]
pub(super) struct PairState {
    pub(super) then: MovingCamera,
    pub(super) now: MovingCamera,
    pub(super) errors: CameraErrors,
    pub(super) slope: Vector2<f64>,
}

impl PairState {
    /// Returns the state changed by errors in the order of [`super::pair_states`].
    pub(super) fn moved(&self, change: &[f64; PAIR]) -> Self {
        let three = |first: usize| Vector3::new(change[first], change[first + 1], change[first + 2]);
        let mut other = *self;
        for (camera, first) in [(&mut other.now, 0), (&mut other.then, POSE)] {
            camera.pose.position += three(first);
            camera.pose.rotation = exponential(&three(first + 3)) * camera.pose.rotation;
        }
        other.errors.add(&SVector::from_column_slice(&change[2 * POSE..2 * POSE + ERRORS]));
        other.slope += Vector2::new(change[PAIR - 2], change[PAIR - 1]);
        other
    }
}

/// The image of a landmark and its derivatives.
pub(super) struct Projection {
    pub(super) image: Vector2<f64>,
    /// By position and rotation of the present camera, and of the keyframe's.
    pub(super) by_pose: [Matrix2x3<f64>; 4],
    /// By the errors of the camera.
    pub(super) by_camera: SMatrix<f64, 2, ERRORS>,
    pub(super) by_slope: Matrix2<f64>,
    /// By the height of the cell.
    pub(super) by_height: Vector2<f64>,
    /// The point on the mean ground, m.
    pub(super) point: Vector3<f64>,
}

impl Projection {
    /// Returns the derivatives in the order of [`super::pair_states`].
    pub(super) fn by_pair(&self) -> SMatrix<f64, 2, PAIR> {
        let mut by = SMatrix::<f64, 2, PAIR>::zeros();
        for (part, block) in self.by_pose.iter().enumerate() {
            by.fixed_view_mut::<2, 3>(0, 3 * part).copy_from(block);
        }
        by.fixed_view_mut::<2, ERRORS>(0, 2 * POSE).copy_from(&self.by_camera);
        by.fixed_view_mut::<2, 2>(0, PAIR - 2).copy_from(&self.by_slope);
        by
    }
}

impl PairState {
    /// Projects a pixel of a keyframe into the present camera; `None` if it is not seen.
    pub(super) fn project(&self, [from, to]: [&Camera; 2], pixel: &Vector2<f64>) -> Option<Projection> {
        let Self { then, now, errors, slope } = self;
        let normal = normal(slope);
        // The first row has the delay alone.
        let part = |camera: &Camera, pixel: &Vector2<f64>| pixel.y / camera.last_pixel().y.max(1.0);
        let focals = [from, to].map(|camera| camera.focal() * (1.0 + errors.focal));
        let was_seen = (pixel - from.principal()) / focals[0];
        let u = errors.straight(&was_seen);
        let then_part = part(from, pixel);
        let read = then.after(errors.exposed_s(then_part));
        let ray = read.rotation * u.push(1.0);
        let towards = normal.dot(&ray);
        if towards < 1e-3 {
            return None;
        }
        let s = -normal.dot(&read.position) / towards;
        let point = read.position + ray * s;
        let direction = |pose: &CameraPose| {
            let q = pose.rotation.transpose() * (point - pose.position);
            (q.z >= 1e-3 * s).then_some(q)
        };
        let image = |q: &Vector3<f64>| {
            let (seen, by) = errors.distorted(&(q.xy() / q.z));
            (seen, to.principal() + seen * focals[1], by)
        };
        // The row decides on the time; that of the pose of the first one is near enough.
        let now_part = part(to, &image(&direction(&now.after(errors.exposed_s(0.0)))?).1);
        let pose = now.after(errors.exposed_s(now_part));
        let q = direction(&pose)?;
        let (is_seen, image, by_straight) = image(&q);
        let f = focals[1] / q.z;
        let by_direction = by_straight * Matrix2x3::new(f, 0.0, -f * q.x / q.z, 0.0, f, -f * q.y / q.z);
        let a = by_direction * pose.rotation.transpose();
        let along = a * (Matrix3::identity() - ray * normal.transpose() / towards);
        let by_pose = [-a, a * skew(&(point - pose.position)), along, -along * skew(&ray) * s];
        let by_reference =
            (along * read.rotation * s).fixed_view::<2, 2>(0, 0) * errors.distorted(&u).1.try_inverse()?;
        let cubic = |u: &Vector2<f64>| u * u.norm_squared();
        let turning = |camera: &MovingCamera| camera.pose.rotation * camera.rates;
        let by_now = by_pose[0] * now.velocity + by_pose[1] * turning(now);
        let by_then = by_pose[2] * then.velocity + by_pose[3] * turning(then);
        let by_camera = SMatrix::from_columns(&[
            cubic(&(q.xy() / q.z)) * focals[1] - by_reference * cubic(&u),
            by_now * now_part + by_then * then_part,
            is_seen * to.focal() - by_reference * was_seen / (1.0 + errors.focal),
            by_now + by_then,
        ]);
        let by_height = -a * ray / towards;
        let by_slope = -by_height * point.xy().transpose();
        Some(Projection { image, by_pose, by_camera, by_slope, by_height, point })
    }
}

/// Returns a normal of the ground with a slope, downwards.
pub(super) fn normal(slope: &Vector2<f64>) -> Vector3<f64> {
    Vector3::new(-slope.x, -slope.y, 1.0)
}
