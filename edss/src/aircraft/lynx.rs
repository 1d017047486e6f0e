//! Stability and control derivatives of the Westland Lynx about hover.
//!
//! **Source.** S. Skogestad and I. Postlethwaite, *Multivariable Feedback Control: Analysis and Design*, Wiley, 1st
//! edition 1996, section 12.2, 2nd edition 2005, section 13.2, "Helicopter control": matrices `A` and `B` of the eight
//! rigid-body states of the Lynx in hover, as printed in the book's file `Sec13_2.m`. They are those of benchmark HE4
//! of COMPleib (F. Leibfritz, 2003) and of `WestlandLynx` in GNU Octave's control package. [`PUBLISHED`] keeps the
//! units of the source: radians, feet per second, and degrees for blade angles.

use nalgebra::{SMatrix, SVector};

/// Rows of roll, pitch and yaw acceleration (rad/s^2), then of forward, lateral and downward acceleration (ft/s^2).
/// Columns: `p q r` (rad/s), `u v w` (ft/s), then collective, longitudinal cyclic, lateral cyclic and tail rotor
/// collective (degrees). Gravity is not included.
pub const PUBLISHED: [[f64; 10]; 6] = [
    [
        -11.5704956054688,
        -2.54463768005371,
        -0.06360262632370,
        0.10678052902222,
        -0.09491866827011,
        0.00710757449269,
        0.12433505058289,
        0.08278584480286,
        -2.75247764587402,
        -0.01788876950741,
    ],
    [
        0.43935656547546,
        -1.99818229675293,
        0.0,
        0.01665188372135,
        0.01846204698086,
        -0.00118747074157,
        -0.03635892271996,
        0.47509527206421,
        0.01429074257612,
        0.0,
    ],
    [
        -2.04089546203613,
        -0.45899915695190,
        -0.73502779006958,
        0.01925575733185,
        -0.00459562242031,
        0.00212036073208,
        0.30449151992798,
        0.01495801657438,
        -0.49651837348938,
        -0.20674192905426,
    ],
    [
        -0.50335502624512,
        2.29785919189453,
        0.0,
        -0.02121581137180,
        -0.02116791903973,
        0.01581159234047,
        0.28773546218872,
        -0.54450607299805,
        -0.01637935638428,
        0.0,
    ],
    [
        -2.34721755981445,
        -0.50361156463623,
        0.83494758605957,
        0.02122657001019,
        -0.03787973523140,
        0.00035400385968,
        -0.01907348632812,
        0.01636743545532,
        -0.54453611373901,
        0.23484230041504,
    ],
    [
        -0.00400543212891,
        -0.05741119384766,
        0.0,
        0.01398963481188,
        -0.00090675335377,
        -0.29051351547241,
        -4.82063293457031,
        -0.00038146972656,
        0.0,
        0.0,
    ],
];

/// Sine of the roll angle in trim: minus the published derivative of the pitch angle by `r`.
const SINE_OF_TRIM_ROLL: f64 = -0.05338427424431;
/// Cosine of trim roll times tangent of trim pitch: the published derivative of the roll angle by `r`.
const COSINE_TANGENT_OF_TRIM: f64 = 0.05952465534210;

/// Length of a foot, m.
const FOOT: f64 = 0.3048;

/// The stability and control derivatives in metres, radians and seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Derivatives {
    /// Derivatives of angular, then linear acceleration by `p q r u v w`.
    pub stability: SMatrix<f64, 6, 6>,
    /// Derivatives of the same by the four blade angles.
    pub control: SMatrix<f64, 6, 4>,
    /// Roll and pitch angle in trim, rad, in aerospace signs.
    pub trim: [f64; 2],
}

impl Derivatives {
    /// Converts the published derivatives of the Lynx.
    pub fn lynx() -> Self {
        let of_row = |row: usize| if row < 3 { 1.0 } else { FOOT };
        let of_column = |column: usize| if column < 3 { 1.0 } else { FOOT };
        let stability = SMatrix::from_fn(|row, column| PUBLISHED[row][column] * of_row(row) / of_column(column));
        let control = SMatrix::from_fn(|row, column| (PUBLISHED[row][6 + column] * of_row(row)).to_degrees());
        let roll = libm::asin(SINE_OF_TRIM_ROLL);
        let pitch = libm::atan(COSINE_TANGENT_OF_TRIM / libm::cos(roll));
        Self { stability, control, trim: [roll, pitch] }
    }

    /// Returns the accelerations, angular ones first, for `p q r u v w` and the blade angles.
    pub fn accelerations(&self, motion: &SVector<f64, 6>, blades: &SVector<f64, 4>) -> SVector<f64, 6> {
        self.stability * motion + self.control * blades
    }
}
