//! The checks that a hover must pass.

use super::summary::Summary;

/// Largest rms distance from the target over flat ground, m.
pub(super) const FLAT_BOUND_M: f64 = 0.1;
/// Largest rms distance from the target over relief or buildings, m.
pub(super) const RELIEF_BOUND_M: f64 = 0.3;
/// Longest time without an estimate that passes, s.
pub const MAX_LOSS_S: f64 = 1.0;
/// Largest roll or pitch that passes, degrees.
pub const MAX_TILT_DEG: f64 = 5.0;

/// A check in words, and whether it passes.
pub(super) struct Check {
    pub(super) text: String,
    pub(super) pass: bool,
}

/// Checks a hover. `first_difference` is the first frame for which the lines of ARM binary and host differ, and
/// `last_reason` the reason of the last frame without an estimate.
pub(super) fn check(
    summary: &Summary,
    is_water: bool,
    first_difference: Option<usize>,
    last_reason: Option<&str>,
) -> Vec<Check> {
    let mut checks = Vec::new();
    let mut add = |text: String, pass: bool| checks.push(Check { text, pass });
    if let Some(frame) = first_difference {
        add(format!("frame {frame}: the ARM binary's line is not the host's; is `make arm` up to date?"), false);
    }
    if is_water {
        let found = summary.estimates;
        add(format!("{found} estimates over water, where none can be right"), found == 0);
    } else {
        let bound = summary.bound_m.unwrap_or(RELIEF_BOUND_M);
        if summary.estimates == 0 {
            add(format!("no frame has an estimate: {}", last_reason.unwrap_or_default()), false);
        }
        add(format!("{:.3} m rms from the target, at most {bound}", summary.rms_m), summary.rms_m <= bound);
        let longest = summary.longest_loss_s;
        add(format!("vision away for {longest:.1} s at the longest, at most {MAX_LOSS_S}"), longest <= MAX_LOSS_S);
    }
    let tilt = summary.tilt_max_deg;
    add(format!("roll and pitch within {tilt:.1} degrees, at most {MAX_TILT_DEG}"), tilt <= MAX_TILT_DEG);
    checks
}
