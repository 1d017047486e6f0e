//! Shrinks a random flight that fails to the fewest ingredients that still fail.

use super::{FlownFlight, RandomFlight, fly_random};
use crate::campaign::CampaignError;
use crate::chain::FeatureSource;
use crate::monitor::Monitor;

/// Smallest availability of a flight that does not fail.
pub const MIN_AVAILABILITY: f64 = 0.97;
/// Time after the first misleading frame that a shrunk flight keeps, s.
const KEPT_S: f64 = 0.5;

/// A flight that was shrunk.
#[derive(Debug, Clone)]
pub struct Shrunk {
    /// The flight with the fewest ingredients.
    pub flight: RandomFlight,
    /// Its result.
    pub flown: FlownFlight,
    /// Number of flights that were flown.
    pub attempts: usize,
}

/// Returns `true` if a flight fails in the way of another: by a misleading frame, or else by its availability.
fn fails_like(flown: &FlownFlight, first: &FlownFlight) -> bool {
    if first.misleading > 0 {
        flown.misleading > 0
    } else {
        // A flight without a view of the ground has nothing to answer.
        flown.availability().is_some_and(|availability| availability < MIN_AVAILABILITY)
    }
}

/// Removes ingredients, the last ones first, as long as the flight fails in the same way; a flight with a misleading
/// frame ends soon after it. `progress` receives each attempt and whether it fails.
///
/// # Errors
/// The flight does not fail, or an attempt cannot be flown.
pub fn shrink(
    flight: &RandomFlight,
    features: FeatureSource,
    monitor: &dyn Monitor,
    progress: &mut dyn FnMut(&RandomFlight, bool),
) -> Result<Shrunk, CampaignError> {
    let first = fly_random(flight, features, monitor)?;
    if !fails_like(&first, &first) {
        return Err(CampaignError::NoFailure { seed: flight.seed, number: flight.number });
    }
    let mut shrunk = Shrunk { flight: flight.clone(), flown: first.clone(), attempts: 1 };
    loop {
        let ingredients = shrunk.flight.ingredients.len();
        let kept = |flown: &FlownFlight| flown.misleading_at_s.map_or(flight.seconds, |at| (at + KEPT_S).ceil());
        for index in (0..ingredients).rev() {
            let mut fewer = shrunk.flight.without(index);
            fewer.seconds = kept(&shrunk.flown).clamp(1.0, flight.seconds);
            let flown = fly_random(&fewer, features, monitor)?;
            shrunk.attempts += 1;
            let fails = fails_like(&flown, &first);
            progress(&fewer, fails);
            if fails {
                (shrunk.flight, shrunk.flown) = (fewer, flown);
            }
        }
        if shrunk.flight.ingredients.len() == ingredients {
            return Ok(shrunk);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::random::flown::tests::flown;

    #[test]
    fn a_flight_fails_by_frames_that_show_the_ground() {
        let rarely = flown(1, 0);
        let water = FlownFlight { in_view: 0, answered: 0, ..flown(1, 0) };
        assert!(fails_like(&rarely, &rarely) && !fails_like(&water, &water) && !fails_like(&water, &rarely));
    }
}
