//! Recursive approximations of the Gaussian, one file per family.
//!
//! Each family is a curve through the filters with one free parameter: the pole `a` of the first-order filters, `q` of
//! Young and van Vliet, the scale of Deriche. Three ways to choose it:
//!
//! - [`Fit::Published`]: by the formula its authors print,
//! - [`Fit::Variance`]: so that `sum n^2 h[n] = sigma^2`,
//! - [`Fit::LeastSquares`]: so that `sum (h[n] - w[n])^2` is smallest, `w` the unit-sum sampled Gaussian.
//!
//! Variance and least squares differ much if the shape is poor: an exponential of the right variance is too narrow
//! at its shoulders.

pub mod alvarez_mazorra;
pub mod border;
pub mod cascade;
pub mod deriche;
pub mod direct_form;
pub mod first_order;
pub mod parallel;
pub mod van_vliet_young_verbeek;
pub mod young_van_vliet;

use crate::smoothing::design::{DesignError, SIGMA_MAX, check_sigma};
use crate::smoothing::gaussian::SIGMA_MIN;
use crate::smoothing::separable::{Lanes, single_line};
use crate::smoothing::smoother::Residuals;
use border::Border;
use cascade::Cascade;
use direct_form::DirectForm;
use parallel::Parallel;

/// A family of filters with one free parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Family {
    /// Two-sided first order.
    FirstOrder,
    /// First order repeated.
    AlvarezMazorra {
        /// Number of passes, 1 to 4.
        passes: usize,
    },
    /// Deriche's damped waves.
    Deriche {
        /// Poles of each side, 2 to 4.
        order: usize,
    },
    /// Young and van Vliet 1995.
    YoungVanVliet,
    /// Van Vliet, Young and Verbeek 1998.
    VanVlietYoungVerbeek {
        /// Poles of each side, 3 to 5.
        order: usize,
    },
}

impl Family {
    /// Iterates over all families with all their orders.
    pub fn all() -> impl Iterator<Item = Self> {
        let repeated = (1..=alvarez_mazorra::PASSES_MAX).map(|passes| Self::AlvarezMazorra { passes });
        let deriche = (deriche::ORDERS.0..=deriche::ORDERS.1).map(|order| Self::Deriche { order });
        let (low, high) = van_vliet_young_verbeek::ORDERS;
        let vyv = (low..=high).map(|order| Self::VanVlietYoungVerbeek { order });
        std::iter::once(Self::FirstOrder).chain(repeated).chain(deriche).chain([Self::YoungVanVliet]).chain(vyv)
    }

    /// Returns the name in files and on the command line, without the order.
    pub fn key(self) -> &'static str {
        match self {
            Self::FirstOrder => "first-order",
            Self::AlvarezMazorra { .. } => "alvarez-mazorra",
            Self::Deriche { .. } => "deriche",
            Self::YoungVanVliet => "yvv95",
            Self::VanVlietYoungVerbeek { .. } => "vyv",
        }
    }

    /// Returns the name for messages and reports.
    pub fn name(self) -> String {
        match self {
            Self::FirstOrder => "the first-order filter".to_owned(),
            Self::AlvarezMazorra { passes } => format!("Alvarez-Mazorra with {passes} passes"),
            Self::Deriche { order } => format!("Deriche of order {order}"),
            Self::YoungVanVliet => "Young-van Vliet 1995".to_owned(),
            Self::VanVlietYoungVerbeek { order } => format!("van Vliet-Young-Verbeek of order {order}"),
        }
    }

    /// Returns the number of poles of each side.
    pub fn order(self) -> usize {
        match self {
            Self::FirstOrder => 1,
            Self::AlvarezMazorra { passes } => passes,
            Self::Deriche { order } | Self::VanVlietYoungVerbeek { order } => order,
            Self::YoungVanVliet => 3,
        }
    }

    /// Returns the fits of the family, the default first.
    pub fn fits(self) -> &'static [Fit] {
        match self {
            Self::FirstOrder => &[Fit::LeastSquares, Fit::Variance],
            Self::AlvarezMazorra { .. } | Self::VanVlietYoungVerbeek { .. } => &[Fit::Variance, Fit::LeastSquares],
            Self::Deriche { .. } | Self::YoungVanVliet => &[Fit::Published, Fit::Variance, Fit::LeastSquares],
        }
    }

    /// Returns the name of the free parameter.
    pub fn parameter_name(self) -> &'static str {
        match self {
            Self::FirstOrder | Self::AlvarezMazorra { .. } => "a",
            Self::Deriche { .. } => "scale",
            Self::YoungVanVliet | Self::VanVlietYoungVerbeek { .. } => "q",
        }
    }

    /// Returns the smallest and the largest `sigma`, pixels.
    pub fn sigma_range(self) -> (f64, f64) {
        match self {
            Self::YoungVanVliet => young_van_vliet::SIGMA_RANGE,
            _ => (SIGMA_MIN, SIGMA_MAX),
        }
    }

    fn check_order(self) -> Result<(), DesignError> {
        let (method, order, (min, max)) = match self {
            Self::FirstOrder | Self::YoungVanVliet => return Ok(()),
            Self::AlvarezMazorra { passes } => ("Alvarez-Mazorra", passes, (1, alvarez_mazorra::PASSES_MAX)),
            Self::Deriche { order } => ("Deriche", order, deriche::ORDERS),
            Self::VanVlietYoungVerbeek { order } => ("van Vliet-Young-Verbeek", order, van_vliet_young_verbeek::ORDERS),
        };
        if (min..=max).contains(&order) { Ok(()) } else { Err(DesignError::Order { method, order, min, max }) }
    }

    /// Returns the filter with the given free parameter.
    fn passes(self, parameter: f64) -> Passes {
        match self {
            Self::FirstOrder => Passes::Cascade(alvarez_mazorra::filter(parameter, 1)),
            Self::AlvarezMazorra { passes } => Passes::Cascade(alvarez_mazorra::filter(parameter, passes)),
            Self::Deriche { order } => Passes::Parallel(deriche::filter(order, parameter)),
            Self::YoungVanVliet => Passes::Cascade(young_van_vliet::filter(parameter)),
            Self::VanVlietYoungVerbeek { order } => Passes::Cascade(van_vliet_young_verbeek::filter(order, parameter)),
        }
    }

    /// Returns the free parameter for which the variance of the impulse response is `sigma^2`.
    fn parameter_of_variance(self, sigma: f64) -> f64 {
        match self {
            Self::FirstOrder => alvarez_mazorra::pole(sigma, 1),
            Self::AlvarezMazorra { passes } => alvarez_mazorra::pole(sigma, passes),
            _ => solve_variance(sigma, |parameter| self.passes(parameter).variance()),
        }
    }
}

/// A rule for the free parameter of a family.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Fit {
    /// The formula of the authors.
    Published,
    /// The variance of the impulse response is that of the Gaussian.
    Variance,
    /// Least squares against the unit-sum sampled Gaussian.
    LeastSquares,
}

impl Fit {
    /// Returns the name for messages and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Published => "published",
            Self::Variance => "variance",
            Self::LeastSquares => "least-squares",
        }
    }
}

/// The two passes of a filter.
#[derive(Debug, Clone, PartialEq)]
enum Passes {
    Cascade(Cascade),
    Parallel(Parallel),
}

impl Passes {
    fn variance(&self) -> f64 {
        match self {
            Self::Cascade(cascade) => cascade.variance(),
            Self::Parallel(parallel) => parallel.variance(),
        }
    }

    fn filter(&self, tile: &mut [Lanes], border: Border) {
        match self {
            Self::Cascade(cascade) => cascade.filter(tile, border),
            Self::Parallel(parallel) => parallel.filter(tile),
        }
    }

    fn impulse_response(&self) -> Vec<f64> {
        let radius = match self {
            Self::Cascade(cascade) => cascade.radius(),
            Self::Parallel(parallel) => parallel.radius(),
        };
        // Poles close together decay as n^k r^n: 2^-70 leaves room for the factor n^k.
        let reach = (-70.0 * std::f64::consts::LN_2 / radius.ln()).ceil().max(1.0) as usize;
        let mut line = vec![0.0; 2 * reach + 1];
        line[reach] = 1.0;
        single_line(&line, |tile| self.filter(tile, Border::Held)).split_off(reach)
    }
}

/// A recursive smoother with its coefficients.
#[derive(Debug, Clone, PartialEq)]
pub struct Recursive {
    family: Family,
    fit: Fit,
    sigma: f64,
    parameter: f64,
    passes: Passes,
}

impl Recursive {
    /// Finds the coefficients for `sigma` pixels.
    ///
    /// # Errors
    /// The family does not have this order or fit, or `sigma` is out of range.
    pub fn design(family: Family, fit: Fit, sigma: f64) -> Result<Self, DesignError> {
        family.check_order()?;
        if !family.fits().contains(&fit) {
            let allowed = family.fits().iter().map(|fit| fit.name()).collect::<Vec<_>>().join(" or ");
            return Err(DesignError::Fit { method: family.name(), fit: fit.name(), allowed });
        }
        check_sigma(&family.name(), sigma, family.sigma_range())?;
        let parameter = match (fit, family) {
            (Fit::Published, Family::YoungVanVliet) => young_van_vliet::published_q(sigma),
            (Fit::Published, _) => sigma,
            (Fit::Variance, _) => family.parameter_of_variance(sigma),
            (Fit::LeastSquares, Family::FirstOrder) => first_order::pole(sigma)?,
            (Fit::LeastSquares, _) => least_squares(family, sigma),
        };
        Ok(Self { family, fit, sigma, parameter, passes: family.passes(parameter) })
    }

    /// Returns the family of the filter.
    pub fn family(&self) -> Family {
        self.family
    }

    /// Returns the fit of the free parameter.
    pub fn fit(&self) -> Fit {
        self.fit
    }

    /// Returns the `sigma` of the design, pixels.
    pub fn sigma(&self) -> f64 {
        self.sigma
    }

    /// Returns the free parameter that the fit has chosen; see [`Family::parameter_name`].
    pub fn parameter(&self) -> f64 {
        self.parameter
    }

    /// Multiplies the sections out into one difference equation.
    pub fn direct_form(&self) -> DirectForm {
        match &self.passes {
            Passes::Cascade(cascade) => cascade.direct_form(),
            Passes::Parallel(parallel) => parallel.direct_form(),
        }
    }

    /// Returns the half `h[0 ..= reach]` of the impulse response; the sum beyond the reach is below `2^-53` of the
    /// whole.
    pub fn impulse_response(&self) -> Vec<f64> {
        self.passes.impulse_response()
    }

    /// Returns `H(e^{i omega})` at `omega` radians per pixel.
    pub fn frequency_response(&self, omega: f64) -> f64 {
        match &self.passes {
            Passes::Cascade(cascade) => cascade.frequency_response(omega),
            Passes::Parallel(parallel) => parallel.frequency_response(omega),
        }
    }

    /// Computes the error against the Gaussian of the same `sigma`.
    pub fn residuals(&self) -> Residuals {
        Residuals::from_gaussian(&self.impulse_response(), self.sigma)
    }

    /// Filters a tile in place.
    pub(crate) fn filter(&self, tile: &mut [Lanes], border: Border) {
        self.passes.filter(tile, border);
    }
}

/// Returns the parameter at which `variance` is `sigma^2`, by bisection to the last bit. It is between 0 and
/// `2 sigma + 1`, and the variance increases through it, for any `sigma` of at least 0.38. (Below that the arguments of
/// the poles of van Vliet, Young and Verbeek exceed a full turn.)
fn solve_variance(sigma: f64, variance: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 2.0 * sigma + 1.0);
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if variance(middle) < sigma * sigma { low = middle } else { high = middle }
    }
}

/// Returns the parameter of the smallest l2 error, by golden-section search over the `sigma` of the variance fit. The
/// search starts at 0.78 `sigma`, because at half a pixel the sampled Gaussian is narrower than its `sigma`, and ends
/// at 2 `sigma`, because the best exponential is about 1.5 times as wide.
fn least_squares(family: Family, sigma: f64) -> f64 {
    let error =
        |s: f64| Residuals::from_gaussian(&family.passes(family.parameter_of_variance(s)).impulse_response(), sigma).l2;
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let (mut low, mut high) = (0.78 * sigma, 2.0 * sigma);
    let (mut left, mut right) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut error_left, mut error_right) = (error(left), error(right));
    // A minimum is flat: below the square root of the rounding error its position is undefined.
    while high - low > 1e-8 * sigma {
        if error_left < error_right {
            (high, right, error_right) = (right, left, error_left);
            left = high - ratio * (high - low);
            error_left = error(left);
        } else {
            (low, left, error_left) = (left, right, error_right);
            right = low + ratio * (high - low);
            error_right = error(right);
        }
    }
    family.parameter_of_variance(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smoothing::smoother::Response;

    /// Iterates over every filter with each of its fits.
    fn designs() -> impl Iterator<Item = (Family, Fit)> {
        Family::all().flat_map(|family| family.fits().iter().map(move |&fit| (family, fit)))
    }

    #[test]
    fn the_variance_fit_is_exact() {
        for (family, fit) in designs().filter(|design| design.1 == Fit::Variance) {
            let (low, high) = family.sigma_range();
            for sigma in [low, 0.7, 1.0, 2.0, 5.12, 20.0, high] {
                let got = Recursive::design(family, fit, sigma).unwrap().residuals().sigma_eff;
                assert!((got / sigma - 1.0).abs() < 1e-9, "{family:?}, sigma {sigma}: {got}");
            }
        }
    }

    #[test]
    fn least_squares_is_the_best_of_the_fits() {
        for family in Family::all() {
            let (low, high) = family.sigma_range();
            for sigma in [low, 1.0, 2.0, 5.12, high.min(40.0)] {
                let l2 = |fit| Recursive::design(family, fit, sigma).unwrap().residuals().l2;
                let best = l2(Fit::LeastSquares);
                for &fit in family.fits() {
                    assert!(best <= l2(fit) * (1.0 + 1e-9), "{family:?}, sigma {sigma}, {}", fit.name());
                }
            }
        }
    }

    #[test]
    fn one_pass_is_the_first_order_filter() {
        for (fit, tolerance) in [(Fit::Variance, 0.0), (Fit::LeastSquares, 1e-7)] {
            let parameter = |family| Recursive::design(family, fit, 2.0).unwrap().parameter();
            let difference = parameter(Family::AlvarezMazorra { passes: 1 }) - parameter(Family::FirstOrder);
            assert!(difference.abs() <= tolerance, "{difference}");
        }
    }

    #[test]
    fn direct_forms_respond_as_the_sections_do() {
        for (family, fit) in designs() {
            let filter = Recursive::design(family, fit, 2.0).unwrap();
            let direct = filter.direct_form();
            assert_eq!(direct.a.len(), family.order());
            assert!(direct.is_stable(), "{family:?}");
            for i in 0..=20 {
                let omega = f64::from(i) * std::f64::consts::PI / 20.0;
                let difference = direct.frequency_response(omega) - filter.frequency_response(omega);
                assert!(difference.norm() < 1e-11, "{family:?}: {difference}");
            }
        }
    }

    #[test]
    fn direct_forms_smooth_as_the_sections_do() {
        for (family, fit) in designs() {
            let filter = Recursive::design(family, fit, 3.2).unwrap();
            let wanted = Response::symmetric(&filter.impulse_response());
            let residuals = Residuals::between(&filter.direct_form().impulse_response(), &wanted);
            assert!(residuals.linf < 1e-11, "{family:?}: {residuals:?}");
        }
    }

    #[test]
    fn direct_forms_hold_the_border_sample_as_the_sections_do() {
        // Steep at both ends, so that a wrong border shows.
        let line: Vec<f64> = (0..50).map(|n| f64::from((n * n * 37 + n * 11) % 1000 + 40 * n)).collect();
        for (family, fit) in designs() {
            let filter = Recursive::design(family, fit, 3.2).unwrap();
            let form = filter.direct_form();
            let wanted = single_line(&line, |tile| filter.filter(tile, Border::Held));
            let differences =
                form.smooth_line(&line).iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(differences < 1e-6, "{family:?}: {differences}");
            assert_eq!(form.smooth_line(&[0.1; 40]), [0.1; 40], "{family:?}");
        }
    }

    #[test]
    fn unknown_orders_and_fits_are_refused_by_name() {
        let refused = |family, fit, sigma| Recursive::design(family, fit, sigma).unwrap_err().to_string();
        let message = refused(Family::Deriche { order: 5 }, Fit::Published, 2.0);
        assert_eq!(message, "Deriche has no order 5: choose one from 2 to 4");
        assert!(refused(Family::AlvarezMazorra { passes: 0 }, Fit::Variance, 2.0).contains("no order 0"));
        assert!(refused(Family::VanVlietYoungVerbeek { order: 2 }, Fit::Variance, 2.0).contains("from 3 to 5"));
        assert!(refused(Family::FirstOrder, Fit::Published, 2.0).contains("no published fit: choose least"));
        for (family, fit) in designs() {
            for sigma in [0.0, -1.0, 0.49, 1e9, f64::NAN, f64::INFINITY] {
                let message = refused(family, fit, sigma);
                assert!(message.contains(&format!("sigma {sigma} px")) && message.contains("choose"), "{message}");
            }
        }
    }
}
