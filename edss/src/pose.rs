//! Position and attitude of a camera: a point `p` of the world appears in the direction `R^T (p - position)`.

use hoverlock_reference::motion::orthophoto::Attitude;
use nalgebra::{Matrix3, Vector2, Vector3};

/// The position and attitude of the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// `X_e`, `Y_e` and `Z` (down) over the mean ground, m.
    pub position: Vector3<f64>,
    /// Roll, pitch and yaw, rad.
    pub attitude: Attitude,
}

impl Pose {
    /// Returns the height over the mean ground, m.
    pub fn height(&self) -> f64 {
        -self.position.z
    }

    /// Returns the point on the mean ground below the camera, m.
    pub fn ground(&self) -> Vector2<f64> {
        self.position.xy()
    }

    /// Interpolates between this pose (`t = 0`) and `end` (`t = 1`). Angles are interpolated one by one, which is exact
    /// to second order in their change.
    pub fn interpolate(&self, end: &Self, t: f64) -> Self {
        let mix = |from: f64, to: f64| from + t * (to - from);
        let (a, b) = (self.attitude, end.attitude);
        let attitude = Attitude { roll: mix(a.roll, b.roll), pitch: mix(a.pitch, b.pitch), yaw: mix(a.yaw, b.yaw) };
        Self { position: self.position.lerp(&end.position, t), attitude }
    }

    /// Returns the pose of a camera that is turned by `boresight` relative to this one.
    pub fn turned(&self, boresight: &Attitude) -> Self {
        // The way through a rotation matrix would round.
        if *boresight == Attitude::default() {
            return *self;
        }
        let rotation = self.attitude.rotation() * boresight.rotation();
        Self { position: self.position, attitude: Attitude::of_rotation(&rotation) }
    }

    /// Returns the pose after a short time, with `velocity` over the ground (m/s) and `rates` about the camera's axes
    /// (rad/s). Exact to second order in the angle of rotation.
    pub fn moved(&self, velocity: &Vector3<f64>, rates: &Vector3<f64>, seconds: f64) -> Self {
        let turn = self.attitude.rotation() * (Matrix3::identity() + rates.cross_matrix() * seconds);
        Self { position: self.position + velocity * seconds, attitude: Attitude::of_rotation(&turn) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Extracting the angles inverts the rotation; a rotation about an axis of the camera leaves that axis in
        /// place.
        #[test]
        fn a_pose_moves_as_its_rates_say(
            roll in -0.5..0.5f64, pitch in -0.5..0.5f64, yaw in -3.0..3.0f64, axis in 0..3usize, rate in -1.0..1.0f64,
        ) {
            let pose = Pose { position: Vector3::new(1.0, 2.0, -50.0), attitude: Attitude { roll, pitch, yaw } };
            let still = pose.moved(&Vector3::new(0.0, 0.0, 2.0), &Vector3::zeros(), 0.5);
            prop_assert!((still.attitude.rotation() - pose.attitude.rotation()).norm() < 1e-12);
            prop_assert_eq!(still.position.z, -49.0);
            let mut rates = Vector3::zeros();
            rates[axis] = rate;
            let (seconds, kept) = (1e-3, Vector3::ith(axis, 1.0));
            let turned = pose.moved(&Vector3::zeros(), &rates, seconds).attitude.rotation();
            let before = pose.attitude.rotation();
            prop_assert!((turned * kept - before * kept).norm() < 1e-6);
            // The next axis goes towards the one after it.
            let (next, after) = (Vector3::ith((axis + 1) % 3, 1.0), Vector3::ith((axis + 2) % 3, 1.0));
            let expected = before * (next + after * rate * seconds);
            prop_assert!((turned * next - expected).norm() < 2e-6);
        }
    }
}
