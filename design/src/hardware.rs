//! Constraints of the hardware: a design that breaks one has models, but cannot be built.

use crate::{DesignPoint, Key};

/// Smallest width and height of a frame in hardware, px.
pub const MIN_SIDE: u32 = 64;

/// Largest height of a frame in hardware, px.
pub const MAX_ROWS: u32 = 2048;

/// A condition that a design must fulfil to be built.
pub(crate) struct Constraint {
    /// The key to change if the condition is broken.
    pub key: &'static str,
    holds: fn(&DesignPoint) -> bool,
    /// Requirement and its reason, as they end the message of [`Unbuildable`].
    pub reason: &'static str,
}

/// All constraints of the hardware, in the order in which they are checked.
pub(crate) static CONSTRAINTS: [Constraint; 10] = [
    Constraint {
        key: "width",
        holds: |design| (MIN_SIDE..=4096).contains(&design.width),
        reason: "the hardware takes 64 to 4096 columns",
    },
    Constraint {
        key: "height",
        holds: |design| (MIN_SIDE..=MAX_ROWS).contains(&design.height),
        reason: "the hardware takes 64 to 2048 rows",
    },
    Constraint {
        key: "state",
        holds: |design| design.state.bits() <= 18,
        reason: "the multiplier of a lerp is 18 x 18, so a state has at most 18 bits",
    },
    Constraint {
        key: "coefficient",
        holds: |design| design.coefficient.bits() <= 16,
        reason: "a field of the register bank has 16 bits, so a coefficient has at most 16",
    },
    Constraint {
        key: "look_ahead",
        holds: |design| design.look_ahead.iter().all(|m| (2..=6).contains(m)),
        reason: "a smoother has 2 to 6 stages each way, because frames may have 64 rows only",
    },
    Constraint {
        key: "look_ahead",
        holds: |design| design.look_ahead.is_sorted(),
        reason: "the pixels of a smoother are delayed to align it with the wider ones: it may not look further ahead",
    },
    Constraint {
        key: "dog_bits",
        holds: |design| (6..=15).contains(&design.dog_bits),
        reason: "a response has 6 to 15 bits, half a word of a record with its sign",
    },
    Constraint {
        key: "dog_bits",
        holds: |design| design.dog_shift() >= 0,
        reason: "the LSB of a response must not be finer than one of the state; give the state more fraction bits",
    },
    Constraint {
        key: "ring_radii",
        holds: |design| design.ring_radii.iter().all(|radius| (9..=16).contains(radius)),
        reason: "the hardware has the 15 rows of a ring from 9 to 16 px",
    },
    Constraint {
        key: "threshold_initial",
        holds: |design| design.threshold.initial <= design.max_dog(),
        reason: "the threshold must not exceed the largest response, 2^dog_bits - 1",
    },
];

/// The error that a design breaks a constraint of the hardware: its models work, but no Verilog can be emitted for it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{key} = {value} cannot be built: {reason}")]
pub struct Unbuildable {
    key: &'static str,
    value: String,
    reason: &'static str,
}

impl DesignPoint {
    /// Checks that the hardware can be built for this design.
    ///
    /// # Errors
    /// The first constraint that the design breaks.
    pub fn check_buildable(&self) -> Result<(), Unbuildable> {
        match CONSTRAINTS.iter().find(|constraint| !(constraint.holds)(self)) {
            Some(&Constraint { key, reason, .. }) => {
                let value = Key::named(key).map(|key| key.value(self).to_string()).unwrap_or_default();
                Err(Unbuildable { key, value, reason })
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::KT27;

    #[test]
    fn a_design_that_cannot_be_built_is_rejected_by_its_constraint() {
        for (change, part) in [
            ("width=63", "64 to 4096 columns"),
            ("height=2049", "64 to 2048 rows"),
            ("state=u16.3", "at most 18 bits"),
            ("coefficient=u0.17", "at most 16"),
            ("look_ahead=[5, 5, 7]", "2 to 6 stages"),
            ("look_ahead=[5, 6, 5]", "it may not look further"),
            ("dog_bits=16", "6 to 15"),
            ("state=u16.0", "finer than one of the state"),
            ("ring_radii=[8, 16]", "15 rows of a ring from 9 to 16"),
            ("threshold_initial=40000", "largest response"),
        ] {
            let error = KT27.with_override(change).unwrap().check_buildable().expect_err(change).to_string();
            assert!(error.contains(part) && error.contains(" cannot be built: "), "{error}");
            assert_eq!(error.lines().count(), 1);
        }
    }

    #[test]
    fn every_constraint_names_a_key() {
        for constraint in &CONSTRAINTS {
            assert!(Key::named(constraint.key).is_some(), "{}", constraint.key);
        }
    }
}
