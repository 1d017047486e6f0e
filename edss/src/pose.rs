//! Where a camera is and how it is turned: a point `p` of the world is seen in the direction `R^T (p - position)`.

use hoverlock_reference::motion::orthophoto::Attitude;
use nalgebra::{Vector2, Vector3};

/// Position and attitude of the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// `X_e`, `Y_e` and `Z` (down) over the mean ground, m.
    pub position: Vector3<f64>,
    /// Roll, pitch and yaw.
    pub attitude: Attitude,
}

impl Pose {
    /// Height over the mean ground, m.
    pub fn height(&self) -> f64 {
        -self.position.z
    }

    /// The point on the mean ground below it, m.
    pub fn ground(&self) -> Vector2<f64> {
        self.position.xy()
    }

    /// The pose the part `t` of the way to `end`; angles are interpolated one by one, which is exact to second order
    /// in what they change by.
    pub fn towards(&self, end: &Self, t: f64) -> Self {
        let mix = |from: f64, to: f64| from + t * (to - from);
        let (a, b) = (self.attitude, end.attitude);
        let attitude = Attitude { roll: mix(a.roll, b.roll), pitch: mix(a.pitch, b.pitch), yaw: mix(a.yaw, b.yaw) };
        Self { position: self.position.lerp(&end.position, t), attitude }
    }
}
