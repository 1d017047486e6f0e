//! The errors and limits that all smoother designs share.

/// Largest `sigma` of any smoother, pixels: a quarter of the 1024 columns of the default design.
pub const SIGMA_MAX: f64 = 256.0;

/// An error of the design of a smoother.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DesignError {
    /// `sigma` is not a number or outside the range of the method.
    #[error("sigma {sigma} px is not possible for {method}: choose one from {min} to {max} px")]
    Sigma {
        /// Name of the method.
        method: String,
        /// The given `sigma`, pixels.
        sigma: f64,
        /// Smallest `sigma` of this method, pixels.
        min: f64,
        /// Largest `sigma` of this method, pixels.
        max: f64,
    },
    /// The method does not have this order.
    #[error("{method} has no order {order}: choose one from {min} to {max}")]
    Order {
        /// Name of the method.
        method: &'static str,
        /// The given order.
        order: usize,
        /// Lowest order of the method.
        min: usize,
        /// Highest order of the method.
        max: usize,
    },
    /// The method does not have this fit.
    #[error("{method} has no {fit} fit: choose {allowed}")]
    Fit {
        /// Name of the method.
        method: String,
        /// Name of the given fit.
        fit: &'static str,
        /// Names of the fits of the method.
        allowed: String,
    },
}

/// Checks that `sigma` is a number within the range of the method.
///
/// # Errors
/// `sigma` is NaN or outside the range.
pub(crate) fn check_sigma(method: &str, sigma: f64, (min, max): (f64, f64)) -> Result<(), DesignError> {
    // No range contains NaN.
    if (min..=max).contains(&sigma) {
        Ok(())
    } else {
        Err(DesignError::Sigma { method: method.to_owned(), sigma, min, max })
    }
}
