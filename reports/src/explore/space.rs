//! The designs that a search may choose from: the words of a base design, changed.
//!
//! Frame, pixel and sigmas belong to the camera and the application; they stay. State, coefficients and DoG take every
//! length that can be built. The look-ahead takes the shortest combinations that pass the check of `sigma_eff`: a
//! longer one costs memory, and no check sees what it brings.

use hoverlock_fixed_point::analysis::acceptance::check_coefficients;
use hoverlock_fixed_point::analysis::bounds::Bounds;
use hoverlock_fixed_point::analysis::levels::Levels;
use hoverlock_fixed_point::analysis::resources::{Resources, resources};
use hoverlock_fixed_point::model::design::{AutomaticThreshold, DesignPoint};
use hoverlock_fixed_point::model::format::Format;
use rayon::prelude::*;

use super::measure::Checked;

/// Says why a design cannot be built; `None` for one that can.
pub type Unbuildable<'a> = &'a (dyn Fn(&DesignPoint) -> Option<String> + Sync);

/// Look-ahead of a smoother, stages.
const LOOK_AHEAD: std::ops::RangeInclusive<u32> = 1..=7;
/// Fraction bits of the state.
const STATE: std::ops::RangeInclusive<i8> = 0..=12;
/// Fraction bits of the coefficients.
const COEFFICIENT: std::ops::RangeInclusive<i8> = 6..=18;
/// Bits of the DoG.
const DOG: std::ops::RangeInclusive<u32> = 4..=16;

/// A design of the space.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The design.
    pub design: DesignPoint,
    /// What differs from the base design, as `KEY=VALUE`; `base` for the base itself.
    pub name: String,
    /// What it takes of the device.
    pub resources: Resources,
    /// The check of the coefficients that it fails, which needs no picture.
    pub failure: Option<Checked>,
    /// The check of the coefficients that is closest to its limit.
    pub closest: Option<Checked>,
}

impl Candidate {
    /// A design beside its base.
    pub fn new(design: DesignPoint, base: &DesignPoint) -> Self {
        let checks: Vec<Checked> = match Levels::new(&design) {
            Err(error) => vec![Checked::impossible("coefficients", error.to_string())],
            Ok(levels) => {
                check_coefficients(&levels, Bounds::acceptance()).iter().map(|check| Checked::of(check, None)).collect()
            }
        };
        let failure = checks.iter().find(|check| !check.pass).cloned();
        let closest = checks.into_iter().max_by(|a, b| a.used.total_cmp(&b.used));
        Self { name: changes(&design, base), resources: resources(&design), design, failure, closest }
    }

    /// No word is longer than that of `other`, and the look-ahead is the same: the rounding is nowhere finer.
    pub fn is_coarser(&self, other: &Self) -> bool {
        let (a, b) = (&self.design, &other.design);
        a.look_ahead == b.look_ahead
            && a.state.bits() <= b.state.bits()
            && a.coefficient.bits() <= b.coefficient.bits()
            && a.dog_bits <= b.dog_bits
    }
}

/// The keys of `design` that differ from those of `base`, as `--config` takes them.
pub fn changes(design: &DesignPoint, base: &DesignPoint) -> String {
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
    if changed.is_empty() { "base".into() } else { changed.join(" ") }
}

/// `base` with a DoG of other bits. The initial threshold stays the same in DN.
pub fn with_dog_bits(base: &DesignPoint, bits: u32) -> DesignPoint {
    let scaled = f64::from(base.threshold.initial) * 2f64.powi(bits as i32 - base.dog_bits as i32);
    let most = f64::from((1u32 << bits) - 1);
    let initial = scaled.round().clamp(1.0, most) as u32;
    DesignPoint { dog_bits: bits, threshold: AutomaticThreshold { initial, ..base.threshold }, ..base.clone() }
}

/// All designs that can be built, the base first.
pub fn candidates(base: &DesignPoint, unbuildable: Unbuildable) -> Vec<Candidate> {
    let mut designs = vec![base.clone()];
    for look_ahead in look_aheads(base, unbuildable) {
        for fraction in STATE {
            for coefficient in COEFFICIENT {
                for bits in DOG {
                    let design = DesignPoint {
                        look_ahead: look_ahead.clone().into(),
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

/// The base's look-ahead, and the shortest that pass the checks of the coefficients at the base's coefficient format.
fn look_aheads(base: &DesignPoint, unbuildable: Unbuildable) -> Vec<Vec<u32>> {
    // All lists of a look-ahead for each smoother, the widest smoother's changing first.
    let mut all: Vec<Vec<u32>> = vec![Vec::new()];
    for _ in 0..base.smoothers() {
        all = all.iter().flat_map(|before| LOOK_AHEAD.map(|m| [&before[..], &[m]].concat())).collect();
    }
    all.retain(|look_ahead| {
        let design = DesignPoint { look_ahead: look_ahead.clone().into(), ..base.clone() };
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
    use hoverlock_fixed_point::model::design::KT27;

    #[test]
    fn a_name_says_what_differs_and_makes_the_design_again() {
        let mut design = KT27;
        for change in ["state=u16.1", "coefficient=u0.14", "look_ahead=[5,5,5]"] {
            design = design.with_override(change).unwrap();
        }
        let name = changes(&design, &KT27);
        assert_eq!(name, "state=u16.1 coefficient=u0.14 look_ahead=[5,5,5]");
        let again = name.split(' ').fold(KT27, |design, change| design.with_override(change).unwrap());
        assert_eq!(again, design);
        assert_eq!(changes(&KT27, &KT27), "base");
    }

    #[test]
    fn the_initial_threshold_stays_the_same_in_dn() {
        for bits in [6, 12, 15] {
            let design = with_dog_bits(&KT27, bits);
            assert_eq!(f64::from(design.threshold.initial) * design.dog().lsb(), 1024.0, "{bits}");
        }
    }

    #[test]
    fn every_candidate_can_be_built_and_stands_there_once() {
        let odd = |design: &DesignPoint| (design.state.bits() > 18 || design.dog_shift() < 0).then(String::new);
        let all = candidates(&KT27, &odd);
        assert_eq!(all[0].design, KT27);
        assert_eq!(all[0].failure, None);
        for (i, candidate) in all.iter().enumerate() {
            assert!(odd(&candidate.design).is_none());
            assert!(!all[..i].iter().any(|other| other.design == candidate.design), "{}", candidate.name);
        }
        // Less look-ahead than the base's fails the check of sigma_eff somewhere, so no other is in the space.
        assert!(all.iter().all(|candidate| candidate.design.look_ahead == KT27.look_ahead));
    }
}
