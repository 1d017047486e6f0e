//! The estimate from two pictures alone: the estimator that flies, without samples of an IMU or a limit of the work.

use crate::calibration::Calibration;
use crate::line::{Estimate, Reason};
use crate::message::Telemetry;
use crate::navigator::MAX_FEATURES;
use crate::tracker::{Seen, Tracker};
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::budget::Budget;

/// Time that is assumed between the pictures, us: a reference that is found so much later is confirmed.
const BETWEEN_US: u64 = 2_000_000;

/// A picture with its readings.
#[derive(Debug, Clone, Copy)]
pub struct Picture<'a> {
    /// Readings at its exposure; their times are not used.
    pub telemetry: &'a Telemetry,
    /// Its features, of which the 1024 strongest count, as in flight.
    pub features: &'a [Feature],
    /// Its pixels.
    pub pixels: &'a Plane<u16>,
}

/// Estimates the displacement from the first picture to the second.
///
/// # Errors
/// The reason why there is no estimate.
pub fn estimate(pictures: [Picture<'_>; 2], calibration: &Calibration) -> Result<Estimate, Reason> {
    let mut tracker = Tracker::with_capacity(MAX_FEATURES);
    tracker.calibrate(calibration);
    let mut budget = Budget::UNLIMITED;
    let mut estimate = Err(Reason::Reference);
    for (number, Picture { telemetry, features, pixels }) in pictures.into_iter().enumerate() {
        let (camera, telemetry) = calibration.seen_by([pixels.width(), pixels.height()], telemetry)?;
        let telemetry = &Telemetry { time_us: BETWEEN_US * number as u64, ..telemetry };
        let features = &strongest(features);
        let seen = Seen { frame: None, telemetry, camera, features, pixels: Some(pixels) };
        if number == 0 {
            tracker.capture(&seen, &mut budget)?;
        } else {
            estimate = tracker.estimate(&seen, &mut false, &mut budget);
        }
    }
    Ok(calibration.of_sensor(estimate?))
}

/// Returns the strongest features in raster order.
fn strongest(features: &[Feature]) -> Vec<Feature> {
    let place = |feature: &Feature| (feature.y, feature.x, feature.scale);
    let mut strongest = features.to_vec();
    // Of equally strong ones the first in raster order is kept.
    strongest.sort_by(|a, b| b.response.total_cmp(&a.response).then(place(a).cmp(&place(b))));
    strongest.truncate(MAX_FEATURES);
    strongest.sort_by_key(place);
    strongest
}
