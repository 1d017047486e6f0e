//! Rejects matches of the fixed pattern of the sensor.
//!
//! Dust and unequal pixels stay where they are while the ground moves. The estimate is rejected if half of the inliers
//! stay on their pixel and IMU and laser exclude, by four standard errors, that the picture stood still. A drift that
//! undoes the turn exactly is rejected too; of the possible drifts that is one in thousands.

use crate::motion::model::{Pair, transfer};
use crate::motion::observation::{Observation, ViewErrors};
use crate::motion::refusal::Refusal;
use nalgebra::Vector2;

/// Motion of a match below which it stays on its pixel, px.
const MAX_STILL_MOTION_PX: f64 = 0.75;

/// Standard errors beyond which IMU and laser exclude that the picture stood still.
const MOTION_SIGMAS: f64 = 4.0;

/// Rejects inlier pairs that show the pattern of the sensor.
///
/// # Errors
/// [`Refusal::SensorPattern`].
pub fn check(pairs: &[Pair], reference: &Observation, current: &Observation) -> Result<(), Refusal> {
    let is_still =
        |pair: &&Pair| (pair.current - pair.reference).norm_squared() < MAX_STILL_MOTION_PX * MAX_STILL_MOTION_PX;
    let still = pairs.iter().filter(is_still).count();
    if 2 * still < pairs.len() || !has_moved(reference, current) {
        return Ok(());
    }
    Err(Refusal::SensorPattern { still, inliers: pairs.len() })
}

/// Returns `true` if IMU and laser exclude that the picture stood still, assuming no drift.
fn has_moved(reference: &Observation, current: &Observation) -> bool {
    let both = |error: fn(&ViewErrors) -> f64| error(&reference.errors).hypot(error(&current.errors));
    let (tilt, heading, height) = (both(|e| e.tilt), both(|e| e.heading), both(|e| e.plane_height));
    let (reference, current) = (&reference.view, &current.view);
    let without_drift = current.from_ground() * reference.to_ground();
    let moved = |p: Vector2<f64>| transfer(&without_drift, p).map(|q| q - p);
    let matrix = reference.camera().matrix();
    let (centre, corner) = (Vector2::new(matrix[(0, 2)], matrix[(1, 2)]), Vector2::zeros());
    let (Some(shift), Some(turn)) = (moved(centre), moved(corner)) else { return true };
    let half = centre.norm();
    // Tilt shifts the whole picture; yaw turns it and height scales it about the centre.
    let by_tilt = MOTION_SIGMAS * tilt * current.camera().focal();
    let by_turn = MOTION_SIGMAS * half * (heading + height / current.height());
    shift.norm() > by_tilt || (turn - shift).norm() > by_turn + half * by_tilt / current.camera().focal()
}
