//! Van Vliet, Young and Verbeek 1998, "Recursive Gaussian derivative filters", ICPR, orders 3 to 5:
//!
//! ```text
//! H+(z) = prod_i (1 - 1/d_i) / (1 - z^-1 / d_i),    d_i(q) = d_i^(1/q),    sigma^2 = sum_i 2 d_i(q) / (d_i(q) - 1)^2
//! ```
//!
//! `d_i` are the inverse poles of the filter that is closest to the Gaussian of `sigma` 2 in the l2 norm (their table
//! 1); `q` is 1 there, and is solved for any other `sigma` so that the variance is exact.

use super::cascade::{Cascade, Section};
use nalgebra::Complex;

/// Lowest and highest order.
pub const ORDERS: (usize, usize) = (3, 5);

const THIRD: &[(f64, f64)] = &[(1.41650, 1.00829), (1.86543, 0.0)];
const FOURTH: &[(f64, f64)] = &[(1.13228, 1.28114), (1.78534, 0.46763)];
const FIFTH: &[(f64, f64)] = &[(0.86430, 1.45389), (1.61433, 0.83134), (1.87504, 0.0)];

/// Returns the filter of `order` 3 to 5 with the given `q`.
pub(crate) fn filter(order: usize, q: f64) -> Cascade {
    let inverse_poles = match order {
        3 => THIRD,
        4 => FOURTH,
        _ => FIFTH,
    };
    let section = |&(re, im): &(f64, f64)| {
        let pole = Complex::new(re, im).powf(-1.0 / q);
        if im == 0.0 { Section::real(pole.re) } else { Section::pair(pole) }
    };
    Cascade::new(inverse_poles.iter().map(section).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smoothing::recursive::{Family, Fit, Recursive};

    #[test]
    fn the_table_is_for_sigma_two() {
        for order in ORDERS.0..=ORDERS.1 {
            // Five printed decimals of the poles leave an error of a few 1e-5 in sigma.
            let sigma = filter(order, 1.0).variance().sqrt();
            assert!((sigma - 2.0).abs() < 5e-5, "order {order}: {sigma}");
        }
    }

    #[test]
    fn each_order_is_closer_to_the_gaussian() {
        for sigma in [1.0, 2.0, 5.12, 20.0] {
            let l2 = |order| {
                let family = Family::VanVlietYoungVerbeek { order };
                Recursive::design(family, Fit::Variance, sigma).unwrap().residuals().l2
            };
            assert!(l2(4) < l2(3) && l2(5) < l2(4), "sigma {sigma}: {} {} {}", l2(3), l2(4), l2(5));
        }
    }
}
