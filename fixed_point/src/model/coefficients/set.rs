//! The coefficients of one smoother from `sigma` to raw integers, with the error of each step.
//!
//! Two kinds of error are separate: `l2`, `linf` and `sigma_eff` of a [`CoefficientSet`] are approximation errors, the
//! unquantised filter against the sampled Gaussian. Those of [`Quantised`] and [`Lerp`] are quantisation errors, the
//! integer filter against the unquantised one.

use super::direct_form::IntegerDirectForm;
use super::{CoefficientError, LerpCoefficients, look_ahead_error, look_ahead_for};
use hoverlock_reference::smoothing::recursive::direct_form::Structure;
use hoverlock_reference::smoothing::recursive::{Family, Fit, Recursive};
use hoverlock_reference::smoothing::smoother::{Residuals, Response};
use serde::Serialize;

/// The design parameters of one smoother.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SmootherSpec {
    /// Family of the filter.
    pub family: Family,
    /// Fit of the free parameter.
    pub fit: Fit,
    /// `sigma` of the smoother, px.
    pub sigma: f64,
    /// `F`: fraction bits of the coefficients.
    pub frac_bits: u32,
    /// Look-ahead of the lerp form; ignored unless `family` is first-order.
    pub look_ahead: LookAhead,
}

/// Number of look-ahead stages, or the error it follows from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LookAhead {
    /// A number of stages.
    Stages(u32),
    /// The fewest stages that omit at most this part of the sum.
    Error(f64),
}

/// The coefficients of one smoother. The equations of `a`, `b` and `b_ahead` are those of
/// [`direct_form`](hoverlock_reference::smoothing::recursive::direct_form).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CoefficientSet {
    /// Name of the family on the command line.
    pub method: &'static str,
    /// Poles of each side.
    pub order: usize,
    /// `sigma` of the smoother, px.
    pub sigma: f64,
    /// Fit of the free parameter.
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
    /// `sqrt(sum n^2 h)` of the unquantised filter, px.
    pub sigma_eff: f64,
    /// Largest deviation from the sampled Gaussian, over the Gaussian's peak.
    pub linf: f64,
    /// l2 norm of the deviation from the sampled Gaussian, over the Gaussian's.
    pub l2: f64,
    /// DC gain, `sum h`.
    pub dc_gain: f64,
    /// The integer coefficients.
    pub quantised: Quantised,
}

/// The free parameter of a family.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// `a`, `q` or `scale`.
    pub name: &'static str,
    /// Value of the parameter.
    pub value: f64,
}

/// The direct form in units of `2^-frac_bits`, and its error against the unquantised filter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quantised {
    /// `F`: fraction bits of every coefficient.
    pub frac_bits: u32,
    /// Least number of bits for every coefficient of the direct form in two's complement.
    pub width: u32,
    /// `a[1 ..= order]`, rounded, in units of `2^-frac_bits`.
    pub a: Vec<i64>,
    /// `b[0 ..]`, rounded, in units of `2^-frac_bits`.
    pub b: Vec<i64>,
    /// `b_ahead[1 ..= order]`, rounded, in units of `2^-frac_bits`.
    pub b_ahead: Vec<i64>,
    /// `sqrt(sum n^2 h)`, px.
    pub sigma_eff: f64,
    /// Largest deviation from the unquantised response, over its peak.
    pub linf: f64,
    /// l2 norm of the deviation from the unquantised response, over its own.
    pub l2: f64,
    /// DC gain of the integer filter: exactly 1.
    pub dc_gain: f64,
    /// The lerp form of the hardware; first-order filter only.
    pub lerp: Option<Lerp>,
}

/// The lerp form: the unsigned `u0.F` coefficients of the hardware.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Lerp {
    /// `round(2^F (1 - a))`.
    pub g: u32,
    /// `round(2^F / (1 + a^(2^j)))`.
    pub g_j: Vec<u32>,
    /// `m`: number of look-ahead stages.
    pub look_ahead: u32,
    /// `a^(2^m)`: the part of the sum that the stages omit.
    pub look_ahead_error: f64,
    /// Stages whose coefficient rounds to 1 and saturates at `2^F - 1`: use a shorter look-ahead.
    pub saturated: Vec<u32>,
    /// Vertical: recursion, then column look-ahead.
    pub columns: Deviation,
    /// Horizontal: row look-back, then row look-ahead.
    pub rows: Deviation,
}

/// Error of a quantised, truncated filter against the unquantised filter of infinite length.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Deviation {
    /// `sqrt(sum n^2 h)`, px.
    pub sigma_eff: f64,
    /// Largest deviation, over the unquantised peak.
    pub linf: f64,
    /// l2 norm of the deviation, over the unquantised filter's.
    pub l2: f64,
    /// DC gain, `sum h`.
    pub dc_gain: f64,
    /// `sum n h`, px: shift of the picture.
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
    /// The filter, the number of bits or the look-ahead is out of range, or no rounding is stable with DC gain 1.
    pub fn design(spec: &SmootherSpec) -> Result<Self, CoefficientError> {
        let filter = Recursive::design(spec.family, spec.fit, spec.sigma)?;
        let (form, approximation) = (filter.direct_form(), filter.residuals());
        let exact = Response::symmetric(&filter.impulse_response());
        let integers = IntegerDirectForm::round(&form, spec.sigma, spec.frac_bits)?;
        let quantisation = Residuals::between(&integers.real().impulse_response(), &exact);
        let (numerator, denominator) = integers.dc_gain();
        let lerp = match spec.family {
            Family::FirstOrder => Some(Lerp::design(spec, filter.parameter(), &exact)?),
            _ => None,
        };
        Ok(Self {
            method: spec.family.key(),
            order: spec.family.order(),
            sigma: spec.sigma,
            fit: spec.fit.name(),
            parameter: Parameter { name: spec.family.parameter_name(), value: filter.parameter() },
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
                frac_bits: spec.frac_bits,
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

    /// Returns the coefficients as they are exported, in order: the lerp form if there is one, otherwise the direct
    /// form.
    pub fn words(&self) -> Vec<Word> {
        let q = &self.quantised;
        let word = |name: String, raw: i64, meaning: String| Word { name, raw, meaning };
        if let Some(lerp) = &q.lerp {
            let stage = |(j, &raw): (usize, &u32)| {
                word(format!("G_{j}"), raw.into(), format!("1 / (1 + a^{}), {} ahead", 1u64 << j, 1u64 << j))
            };
            let recursion = word("G".to_owned(), lerp.g.into(), "1 - a, recursion".to_owned());
            return std::iter::once(recursion).chain(lerp.g_j.iter().enumerate().map(stage)).collect();
        }
        let list = |name: &'static str, first: usize, raw: &[i64], meaning: &'static str| -> Vec<Word> {
            raw.iter().zip(first..).map(|(&raw, i)| word(format!("{name}{i}"), raw, format!("{meaning} {i}"))).collect()
        };
        [
            list("A", 1, &q.a, "feedback, output"),
            list("B", 0, &q.b, "feed-forward, sample"),
            list("B_AHEAD", 1, &q.b_ahead, "feed-forward of the anticausal pass, sample"),
        ]
        .concat()
    }

    /// Bits of an exported coefficient, and whether it is signed.
    pub fn word_format(&self) -> (u32, bool) {
        if self.quantised.lerp.is_some() { (self.quantised.frac_bits, false) } else { (self.quantised.width, true) }
    }
}

/// One coefficient as it is exported.
#[derive(Debug, Clone, PartialEq)]
pub struct Word {
    /// Name within the set, in upper case.
    pub name: String,
    /// Raw integer, in units of `2^-F`.
    pub raw: i64,
    /// Meaning, for comments.
    pub meaning: String,
}

impl Lerp {
    fn design(spec: &SmootherSpec, a: f64, exact: &Response) -> Result<Self, CoefficientError> {
        let look_ahead = match spec.look_ahead {
            LookAhead::Stages(stages) => stages,
            LookAhead::Error(error) => look_ahead_for(a, error)?,
        };
        let coefficients = LerpCoefficients::of_pole(spec.sigma, a, look_ahead, spec.frac_bits)?;
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
        let spec =
            SmootherSpec { family: Family::FirstOrder, fit: Fit::LeastSquares, sigma, frac_bits: 16, look_ahead };
        CoefficientSet::design(&spec).unwrap()
    }

    #[test]
    fn the_design_point_is_within_its_bound() {
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
                // A chain of lerps has DC gain 1 with any coefficients; the rest is f64 rounding.
                assert!((way.dc_gain - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_shorter_look_ahead_gives_a_larger_error() {
        let l2 = |stages| first_order(5.12, LookAhead::Stages(stages)).quantised.lerp.unwrap().rows.l2;
        assert!(l2(5) > 10.0 * l2(6), "{} {}", l2(5), l2(6));
    }

    #[test]
    fn every_family_gives_a_set() {
        for family in Family::all() {
            for &fit in family.fits() {
                let spec = SmootherSpec { family, fit, sigma: 2.0, frac_bits: 16, look_ahead: LookAhead::Error(1e-4) };
                let set = CoefficientSet::design(&spec).unwrap();
                assert_eq!((set.a.len(), set.quantised.a.len()), (set.order, set.order));
                assert_eq!(set.quantised.dc_gain, 1.0);
                assert!((set.dc_gain - 1.0).abs() < 1e-12);
                assert!(set.quantised.l2 < 0.01, "{family:?}: {}", set.quantised.l2);
                let count = set.words().len();
                let lerp = set.quantised.lerp.as_ref().map(|lerp| 1 + lerp.g_j.len());
                assert_eq!(count, lerp.unwrap_or(set.a.len() + set.b.len() + set.b_ahead.len()));
            }
        }
    }
}
