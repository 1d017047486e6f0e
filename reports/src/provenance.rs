//! Provenance of a report: everything needed to reproduce its numbers.

use hoverlock_fixed_point::analysis::bounds::{Bounds, Seeds};
use hoverlock_fixed_point::analysis::levels::Levels;
use serde::Serialize;
use sha2::{Digest, Sha256};

/// `git describe` of the sources when they were built.
pub const COMMIT: &str = env!("HOVERLOCK_COMMIT");

/// Sources, inputs and settings of a report. It has no date, so that the same inputs give the same bytes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Provenance {
    /// `git describe` of the sources at build time.
    pub commit: &'static str,
    /// The command as typed.
    pub command: String,
    /// The design point as TOML, with every key.
    pub configuration: String,
    /// SHA-256 of that text.
    pub configuration_sha256: String,
    /// Raw coefficients of `bit_true`, one smoother per line: `g`, then `g_j`.
    pub coefficients: String,
    /// SHA-256 of that text.
    pub coefficients_sha256: String,
    /// SHA-256 of `bounds.toml`.
    pub bounds_sha256: String,
    /// Seeds of degradations and motions.
    pub seeds: Seeds,
}

impl Provenance {
    /// Returns the provenance of a study of these levels by this command.
    pub fn of(levels: &Levels, command: &str) -> Self {
        let bounds = Bounds::acceptance();
        let configuration = levels.design().to_toml();
        let design = levels.design();
        let line = |(smoother, sigma): (usize, &f64)| {
            let coefficients = &levels.bit_true().coefficients()[smoother];
            let g_j: Vec<String> = coefficients.g_j.iter().map(u32::to_string).collect();
            format!("sigma {sigma}: {}; {}\n", coefficients.g, g_j.join(" "))
        };
        let coefficients: String = design.sigmas.iter().enumerate().map(line).collect();
        Self {
            commit: COMMIT,
            command: command.to_owned(),
            configuration_sha256: sha256(&configuration),
            configuration,
            coefficients_sha256: sha256(&coefficients),
            coefficients,
            bounds_sha256: sha256(Bounds::FILE),
            seeds: bounds.seeds,
        }
    }
}

/// Returns the SHA-256 of some bytes, in hexadecimal.
pub fn sha256(bytes: impl AsRef<[u8]>) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
