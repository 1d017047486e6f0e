//! The outcome of a check in a form that JSON can hold.

use hoverlock_fixed_point::analysis::bounds::Check;
use serde::{Deserialize, Serialize};

/// A check and its outcome. Numbers that are not finite are `None`, because JSON cannot represent them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CheckOutcome {
    /// Name of the bound.
    pub check: String,
    /// Unit of `measured` and `limit`.
    pub unit: String,
    /// The measured value.
    pub measured: Option<f64>,
    /// The limit of the bound.
    pub limit: Option<f64>,
    /// Picture, condition, scale or smoother that was checked.
    pub place: String,
    /// Fraction of the allowance that is used, at most [`CheckOutcome::MAX_USED`]. The check fails above 1.
    pub used: f64,
    /// The check passes.
    pub pass: bool,
}

impl CheckOutcome {
    /// Stands for an infinite `used`.
    pub const MAX_USED: f64 = 1e6;

    /// Converts a check. `place` names the picture and condition; `None` for a check that needs no picture.
    pub fn new(check: &Check, place: Option<&str>) -> Self {
        let finite = |value: f64| value.is_finite().then_some(value);
        // NaN means that nothing was measured, which is the worst failure.
        let used = if check.used.is_nan() { Self::MAX_USED } else { check.used.min(Self::MAX_USED) };
        Self {
            check: check.name.into(),
            unit: check.unit.into(),
            measured: finite(check.measured),
            limit: finite(check.limit),
            place: place.map_or_else(|| check.location.clone(), |place| format!("{place}, {}", check.location)),
            used,
            pass: check.pass,
        }
    }

    /// Returns a failure without numbers, for a design that cannot be measured. `reason` takes the place of `place`.
    pub fn unmeasurable(check: &str, reason: String) -> Self {
        Self {
            check: check.into(),
            unit: String::new(),
            measured: None,
            limit: None,
            place: reason,
            used: Self::MAX_USED,
            pass: false,
        }
    }
}
