//! One smoother from `sigma` to codes, with what each step cost: the record that every export is written from.
//!
//! Two errors, never mixed: `l2`, `linf` and `sigma_eff` of a [`CoefficientSet`] are its approximation, the unquantised filter
//! against the sampled Gaussian; those of [`Quantised`] and [`Lerp`] are quantisation, codes against the unquantised filter.

use super::direct_form::IntegerDirectForm;
use super::{CoefficientError, LerpCoefficients, look_ahead_error, look_ahead_for};
use hoverlock_reference::smoothing::recursive::direct_form::Structure;
use hoverlock_reference::smoothing::recursive::{Family, Fit, Recursive};
use hoverlock_reference::smoothing::smoother::{Residuals, Response};
use serde::Serialize;

/// What is wanted of one smoother.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wish {
    /// Which approximation of the Gaussian.
    pub family: Family,
    /// How its free parameter is chosen.
    pub fit: Fit,
    /// `sigma`, pixels.
    pub sigma: f64,
    /// `F`: fraction bits of every code.
    pub frac_bits: u32,
    /// Look-ahead of the lerp form, which only the first-order filter has.
    pub look_ahead: LookAhead,
}

/// How the number of look-ahead stages is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LookAhead {
    /// So many stages.
    Stages(u32),
    /// The fewest that leave out no more than this part of the sum.
    Error(f64),
}

/// The coefficients of one smoother. The equations of `a`, `b` and `b_ahead` are those of
/// [`direct_form`](hoverlock_reference::smoothing::recursive::direct_form).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CoefficientSet {
    /// The family, as the command spells it.
    pub method: &'static str,
    /// Poles of each side.
    pub order: usize,
    /// The `sigma` asked for, pixels.
    pub sigma: f64,
    /// How the free parameter was chosen.
    pub fit: &'static str,
    /// The free parameter.
    pub parameter: Parameter,
    /// `cascade` or `parallel`.
    pub structure: &'static str,
    /// `a[1 ..= order]`: feedback, added.
    pub a: Vec<f64>,
    /// `b[0 ..]`: feed-forward.
    pub b: Vec<f64>,
    /// `b_ahead[1 ..= order]`: feed-forward of the anticausal pass in parallel.
    pub b_ahead: Vec<f64>,
    /// `sqrt(sum n^2 h)` of the unquantised filter, pixels.
    pub sigma_eff: f64,
    /// Largest deviation from the sampled Gaussian, over the Gaussian's peak.
    pub linf: f64,
    /// l2 norm of the deviation from the sampled Gaussian, over the Gaussian's.
    pub l2: f64,
    /// `sum h`.
    pub dc_gain: f64,
    /// The same in integers.
    pub quantised: Quantised,
}

/// The free parameter of a family.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// `a`, `q` or `scale`.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
}

/// The direct form in units of `2^-frac_bits`, and how far it is from the unquantised filter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quantised {
    /// `F`.
    pub frac_bits: u32,
    /// Bits of the narrowest two's complement word that holds every code of the direct form.
    pub width: u32,
    /// Codes of `a`.
    pub a: Vec<i64>,
    /// Codes of `b`.
    pub b: Vec<i64>,
    /// Codes of `b_ahead`.
    pub b_ahead: Vec<i64>,
    /// `sqrt(sum n^2 h)`, pixels.
    pub sigma_eff: f64,
    /// Largest deviation from the unquantised response, over its peak.
    pub linf: f64,
    /// l2 norm of the deviation from the unquantised response, over its own.
    pub l2: f64,
    /// Exactly 1: the integers' own quotient.
    pub dc_gain: f64,
    /// The form that is built; the first-order filter only.
    pub lerp: Option<Lerp>,
}

/// The lerp cells: the unsigned `u0.F` coefficients of the hardware.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Lerp {
    /// `round(2^F (1 - a))`.
    pub g: u32,
    /// `round(2^F / (1 + a^(2^j)))`.
    pub g_j: Vec<u32>,
    /// `m`, stages.
    pub look_ahead: u32,
    /// `a^(2^m)`: the part of the sum that the stages leave out.
    pub look_ahead_error: f64,
    /// Stages whose coefficient rounds to 1 and is held at `2^F - 1`: a shorter look-ahead is as good.
    pub saturated: Vec<u32>,
    /// Down the columns: recursion, then look-ahead.
    pub columns: Deviation,
    /// Along the rows: look-back, then look-ahead.
    pub rows: Deviation,
}

/// How far a quantised, truncated filter is from the unquantised one of infinite reach.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Deviation {
    /// `sqrt(sum n^2 h)`, pixels.
    pub sigma_eff: f64,
    /// Largest deviation, over the unquantised peak.
    pub linf: f64,
    /// l2 norm of the deviation, over the unquantised filter's.
    pub l2: f64,
    /// `sum h`.
    pub dc_gain: f64,
    /// `sum n h`, pixels: how far the picture is moved.
    pub shift: f64,
}

impl From<Residuals> for Deviation {
    fn from(r: Residuals) -> Self {
        Self { sigma_eff: r.sigma_eff, linf: r.linf, l2: r.l2, dc_gain: r.dc_gain, shift: r.shift }
    }
}

impl CoefficientSet {
    /// Designs, rounds and checks one smoother.
    ///
    /// # Errors
    /// Where the filter, the number of bits or the look-ahead is not possible, or no rounding is stable with DC gain 1.
    pub fn design(wish: &Wish) -> Result<Self, CoefficientError> {
        let filter = Recursive::design(wish.family, wish.fit, wish.sigma)?;
        let (form, approximation) = (filter.direct_form(), filter.residuals());
        let exact = Response::symmetric(&filter.impulse_response());
        let integers = IntegerDirectForm::round(&form, wish.sigma, wish.frac_bits)?;
        let quantisation = Residuals::between(&integers.real().impulse_response(), &exact);
        let (numerator, denominator) = integers.dc_gain();
        let lerp = match wish.family {
            Family::FirstOrder => Some(Lerp::design(wish, filter.parameter(), &exact)?),
            _ => None,
        };
        Ok(Self {
            method: wish.family.key(),
            order: wish.family.order(),
            sigma: wish.sigma,
            fit: wish.fit.name(),
            parameter: Parameter { name: wish.family.parameter_name(), value: filter.parameter() },
            structure: match form.structure {
                Structure::Cascade => "cascade",
                Structure::Parallel => "parallel",
            },
            a: form.a,
            b: form.b,
            b_ahead: form.b_ahead,
            sigma_eff: approximation.sigma_eff,
            linf: approximation.linf,
            l2: approximation.l2,
            dc_gain: approximation.dc_gain,
            quantised: Quantised {
                frac_bits: wish.frac_bits,
                width: integers.width(),
                sigma_eff: quantisation.sigma_eff,
                linf: quantisation.linf,
                l2: quantisation.l2,
                dc_gain: numerator as f64 / denominator as f64,
                a: integers.a,
                b: integers.b,
                b_ahead: integers.b_ahead,
                lerp,
            },
        })
    }

    /// The coefficients that a machine is loaded with, in order: the lerp cells where there are any, the direct form elsewhere.
    pub fn words(&self) -> Vec<Word> {
        let q = &self.quantised;
        let word = |name: String, code: i64, meaning: String| Word { name, code, meaning };
        if let Some(lerp) = &q.lerp {
            let stage = |(j, &code): (usize, &u32)| {
                word(format!("G_{j}"), code.into(), format!("1 / (1 + a^{}), {} ahead", 1u64 << j, 1u64 << j))
            };
            let recursion = word("G".to_owned(), lerp.g.into(), "1 - a, recursion".to_owned());
            return std::iter::once(recursion).chain(lerp.g_j.iter().enumerate().map(stage)).collect();
        }
        let list = |name: &'static str, first: usize, codes: &[i64], meaning: &'static str| -> Vec<Word> {
            codes
                .iter()
                .zip(first..)
                .map(|(&code, i)| word(format!("{name}{i}"), code, format!("{meaning} {i}")))
                .collect()
        };
        [
            list("A", 1, &q.a, "feedback, output"),
            list("B", 0, &q.b, "feed-forward, sample"),
            list("B_AHEAD", 1, &q.b_ahead, "feed-forward of the anticausal pass, sample"),
        ]
        .concat()
    }

    /// Bits of a word, and whether it has a sign.
    pub fn word_format(&self) -> (u32, bool) {
        if self.quantised.lerp.is_some() { (self.quantised.frac_bits, false) } else { (self.quantised.width, true) }
    }
}

/// One coefficient as it is loaded into a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Word {
    /// Its name within the set, in capitals.
    pub name: String,
    /// The integer, in units of `2^-F`.
    pub code: i64,
    /// What it is.
    pub meaning: String,
}

impl Lerp {
    fn design(wish: &Wish, a: f64, exact: &Response) -> Result<Self, CoefficientError> {
        let look_ahead = match wish.look_ahead {
            LookAhead::Stages(stages) => stages,
            LookAhead::Error(error) => look_ahead_for(a, error)?,
        };
        let coefficients = LerpCoefficients::of_pole(wish.sigma, a, look_ahead, wish.frac_bits)?;
        let [columns, rows] =
            coefficients.impulse_responses().map(|response| Residuals::between(&response, exact).into());
        Ok(Self {
            look_ahead,
            look_ahead_error: look_ahead_error(a, look_ahead),
            columns,
            rows,
            g: coefficients.g,
            g_j: coefficients.g_j,
            saturated: coefficients.saturated,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::bounds::Bounds;

    fn first_order(sigma: f64, look_ahead: LookAhead) -> CoefficientSet {
        let wish = Wish { family: Family::FirstOrder, fit: Fit::LeastSquares, sigma, frac_bits: 16, look_ahead };
        CoefficientSet::design(&wish).unwrap()
    }

    #[test]
    fn the_design_point_holds_its_bound() {
        for (sigma, stages) in [(2.0, 5), (3.2, 5), (5.12, 6)] {
            let set = first_order(sigma, LookAhead::Error(1e-4));
            let lerp = set.quantised.lerp.as_ref().unwrap();
            assert_eq!(lerp.look_ahead, stages);
            for way in [lerp.columns, lerp.rows] {
                let relative = (way.sigma_eff / set.sigma_eff - 1.0).abs();
                assert!(
                    relative <= Bounds::acceptance().coefficients.sigma_eff_relative,
                    "sigma {sigma}: {relative:e}"
                );
                // A chain of lerps has DC gain 1 whatever its coefficients: what is missing is rounding of f64.
                assert!((way.dc_gain - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_shorter_look_ahead_is_seen() {
        let l2 = |stages| first_order(5.12, LookAhead::Stages(stages)).quantised.lerp.unwrap().rows.l2;
        assert!(l2(5) > 10.0 * l2(6), "{} {}", l2(5), l2(6));
    }

    #[test]
    fn every_family_has_a_set() {
        for family in Family::all() {
            for &fit in family.fits() {
                let wish = Wish { family, fit, sigma: 2.0, frac_bits: 16, look_ahead: LookAhead::Error(1e-4) };
                let set = CoefficientSet::design(&wish).unwrap();
                assert_eq!((set.a.len(), set.quantised.a.len()), (set.order, set.order));
                assert_eq!(set.quantised.dc_gain, 1.0);
                assert!((set.dc_gain - 1.0).abs() < 1e-12);
                assert!(set.quantised.l2 < 0.01, "{family:?}: {}", set.quantised.l2);
                let codes = set.words().len();
                let lerp = set.quantised.lerp.as_ref().map(|lerp| 1 + lerp.g_j.len());
                assert_eq!(codes, lerp.unwrap_or(set.a.len() + set.b.len() + set.b_ahead.len()));
            }
        }
    }
}
