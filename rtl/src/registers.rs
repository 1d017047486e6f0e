//! The register map of a design, with the coefficients of its smoothers as reset values.

use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::model::coefficients::{CoefficientError, LerpCoefficients};
use hoverlock_fixed_point::model::stages::StageCoefficients;
use hoverlock_registers::Register;

/// Returns the coefficients of a design, in the order of [`crate::cells::bank`].
///
/// # Errors
/// If a smoother of the design does not exist.
pub fn default_coefficients(design: &DesignPoint) -> Result<Vec<u32>, CoefficientError> {
    let mut coefficients = Vec::new();
    for (&sigma, &look_ahead) in design.sigmas.iter().zip(&*design.look_ahead) {
        let bits = design.coefficient.bits();
        let designed = StageCoefficients::from(LerpCoefficients::design(sigma, look_ahead, bits)?);
        coefficients.push(designed.g);
        coefficients.extend(designed.g_j);
    }
    Ok(coefficients)
}

/// Returns all registers of a design in the order of their offsets.
///
/// # Errors
/// As [`default_coefficients`].
pub fn registers(design: &DesignPoint) -> Result<Vec<Register>, CoefficientError> {
    Ok(hoverlock_registers::registers(design, &default_coefficients(design)?))
}
