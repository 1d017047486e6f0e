//! The design space: all designs that differ from a base design in their words.
//!
//! Frame size, pixel and sigmas are fixed by the camera and the application, so they keep their values. State,
//! coefficients and DoG take every length that can be built. The look-ahead takes the shortest combinations that pass
//! the check of `sigma_eff`; a longer one costs memory, and no check measures its benefit.

use hoverlock_design::{DesignPoint, Format};
use hoverlock_fixed_point::analysis::acceptance::check_coefficients;
use hoverlock_fixed_point::analysis::bounds::Bounds;
use hoverlock_fixed_point::analysis::levels::Levels;
use hoverlock_fixed_point::analysis::resources::{Resources, resources};
use hoverlock_reports::check_outcome::CheckOutcome;
use hoverlock_reports::sweep::with_dog_bits;
use rayon::prelude::*;

/// A function that returns the reason why a design cannot be built; `None` if it can.
pub type Unbuildable<'a> = &'a (dyn Fn(&DesignPoint) -> Option<String> + Sync);

/// Look-ahead of a smoother, stages.
const LOOK_AHEAD_STAGES: std::ops::RangeInclusive<u32> = 1..=7;
/// Fraction bits of the state.
const STATE_FRACTION_BITS: std::ops::RangeInclusive<i8> = 0..=12;
/// Fraction bits of the coefficients.
const COEFFICIENT_FRACTION_BITS: std::ops::RangeInclusive<i8> = 6..=18;
/// Bits of the DoG magnitude.
const DOG_BITS: std::ops::RangeInclusive<u32> = 4..=16;

/// A design of the space.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Candidate {
    /// All words of the design.
    pub design: DesignPoint,
    /// Differences from the base design as `KEY=VALUE`; `base` for the base itself.
    pub name: String,
    /// Resources by the memory model.
    pub resources: Resources,
    /// The first check of the coefficients that fails. These checks need no picture.
    pub failure: Option<CheckOutcome>,
    /// The check of the coefficients that is closest to its limit.
    pub closest: Option<CheckOutcome>,
}

impl Candidate {
    /// Creates a candidate and checks its coefficients.
    pub(crate) fn new(design: DesignPoint, base: &DesignPoint) -> Self {
        let checks: Vec<CheckOutcome> = match Levels::new(&design) {
            Err(error) => vec![CheckOutcome::unmeasurable("coefficients", error.to_string())],
            Ok(levels) => check_coefficients(&levels, Bounds::acceptance())
                .iter()
                .map(|check| CheckOutcome::new(check, None))
                .collect(),
        };
        let failure = checks.iter().find(|check| !check.pass).cloned();
        let closest = checks.into_iter().max_by(|a, b| a.used.total_cmp(&b.used));
        Self { name: changes(&design, base), resources: resources(&design), design, failure, closest }
    }
}

/// Returns the keys of `design` that differ from those of `base`, in the syntax of `--config`.
pub(crate) fn changes(design: &DesignPoint, base: &DesignPoint) -> String {
    let mut changed = Vec::new();
    let mut add = |differs: bool, text: String| {
        if differs {
            changed.push(text);
        }
    };
    add(design.pixel != base.pixel, format!("pixel={}", design.pixel));
    add(design.state != base.state, format!("state={}", design.state));
    add(design.coefficient != base.coefficient, format!("coefficient={}", design.coefficient));
    add(design.look_ahead != base.look_ahead, format!("look_ahead={:?}", design.look_ahead).replace(' ', ""));
    add(design.dog_bits != base.dog_bits, format!("dog_bits={}", design.dog_bits));
    // It keeps its value in DN, so its number of LSB follows the DoG.
    let initial = design.threshold.initial;
    add(initial != base.threshold.initial, format!("threshold_initial={initial}"));
    if changed.is_empty() { "base".into() } else { changed.join(" ") }
}

/// Returns all designs that can be built, the base first.
pub(crate) fn candidates(base: &DesignPoint, unbuildable: Unbuildable) -> Vec<Candidate> {
    let mut designs = vec![base.clone()];
    for look_ahead in look_aheads(base, unbuildable) {
        for fraction in STATE_FRACTION_BITS {
            for coefficient in COEFFICIENT_FRACTION_BITS {
                for bits in DOG_BITS {
                    let design = DesignPoint {
                        look_ahead: look_ahead.clone(),
                        state: Format::unsigned(base.pixel.integer_bits(), fraction),
                        coefficient: Format::unsigned(0, coefficient),
                        ..with_dog_bits(base, bits)
                    };
                    if design != *base && unbuildable(&design).is_none() {
                        designs.push(design);
                    }
                }
            }
        }
    }
    designs.into_par_iter().map(|design| Candidate::new(design, base)).collect()
}

/// Returns the look-ahead of the base, and the shortest ones that pass the checks of the coefficients at the base's
/// coefficient format.
fn look_aheads(base: &DesignPoint, unbuildable: Unbuildable) -> Vec<Vec<u32>> {
    // All combinations of one look-ahead for each smoother; that of the widest smoother varies fastest.
    let mut all: Vec<Vec<u32>> = vec![Vec::new()];
    for _ in 0..base.smoothers() {
        all = all.iter().flat_map(|before| LOOK_AHEAD_STAGES.map(|m| [&before[..], &[m]].concat())).collect();
    }
    all.retain(|look_ahead| {
        let design = DesignPoint { look_ahead: look_ahead.clone(), ..base.clone() };
        unbuildable(&design).is_none() && Candidate::new(design, base).failure.is_none()
    });
    let longer = |a: &[u32], b: &[u32]| a != b && a.iter().zip(b).all(|(a, b)| a >= b);
    let mut shortest: Vec<_> = all.iter().filter(|a| !all.iter().any(|b| longer(a, b))).cloned().collect();
    if !shortest.iter().any(|known| **known == *base.look_ahead) {
        shortest.insert(0, base.look_ahead.to_vec());
    }
    shortest
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_design::KT27;

    #[test]
    fn a_name_lists_the_differences_and_reproduces_the_design() {
        let mut design = KT27.clone();
        for change in ["state=u16.1", "coefficient=u0.14", "look_ahead=[5,5,5]"] {
            design = design.with_override(change).unwrap();
        }
        let design = with_dog_bits(&design, 14);
        let name = changes(&design, &KT27);
        assert_eq!(name, "state=u16.1 coefficient=u0.14 look_ahead=[5,5,5] dog_bits=14 threshold_initial=1024");
        let again = name.split(' ').fold(KT27.clone(), |design, change| design.with_override(change).unwrap());
        assert_eq!(again, design);
        assert_eq!(changes(&KT27, &KT27), "base");
    }

    #[test]
    fn every_candidate_can_be_built_and_is_listed_once() {
        let odd = |design: &DesignPoint| (design.state.bits() > 18 || design.dog_shift() < 0).then(String::new);
        let all = candidates(&KT27, &odd);
        assert_eq!(all[0].design, *KT27);
        assert_eq!(all[0].failure, None);
        for (i, candidate) in all.iter().enumerate() {
            assert!(odd(&candidate.design).is_none());
            assert!(!all[..i].iter().any(|other| other.design == candidate.design), "{}", candidate.name);
        }
        // Every shorter look-ahead fails the check of sigma_eff, so only the base's is in the space.
        assert!(all.iter().all(|candidate| candidate.design.look_ahead == KT27.look_ahead));
    }
}
