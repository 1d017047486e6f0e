//! Reasons to reject matches that agree with each other and are wrong.
//!
//! RANSAC rejects agreement that chance explains. Two kinds of agreement are neither chance nor the motion of the
//! ground: ground that repeats (module `repeating_ground`) and the fixed pattern of the sensor (module
//! `sensor_pattern`).

/// A reason to reject an estimate.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// A second motion explains the matches as well.
    #[error("no estimate: the ground repeats, {second} of {inliers} matches fit as well ({x:+.0}, {y:+.0}) px away")]
    RepeatingGround {
        /// Inliers that have a similar feature at the second motion.
        second: usize,
        /// Inliers that were checked.
        inliers: usize,
        /// Offset of the second motion from the first along `x`, px.
        x: f64,
        /// Offset of the second motion from the first along `y`, px.
        y: f64,
    },
    /// The matched features stay on their pixels although the camera has moved.
    #[error(
        "no estimate: {still} of {inliers} matches stay on their pixel, and IMU and laser say that the picture moved"
    )]
    SensorPattern {
        /// Inliers that stay on their pixel.
        still: usize,
        /// All inliers.
        inliers: usize,
    },
}
