//! What was measured with what: enough to have every number again.

use hoverlock_fixed_point::bounds::{Bounds, Seeds};
use hoverlock_fixed_point::ladder::Ladder;
use serde::Serialize;
use sha2::{Digest, Sha256};

/// Where the numbers come from. There is no date in it: the same inputs give the same bytes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Provenance {
    /// `git describe` of the sources when they were built.
    pub commit: &'static str,
    /// The command as typed.
    pub command: String,
    /// The design point, every key written out.
    pub configuration: String,
    /// SHA-256 of that text.
    pub configuration_sha256: String,
    /// The coefficients of rung 4, one smoother a line: `g`, then `g_j`.
    pub coefficients: String,
    /// SHA-256 of that text.
    pub coefficients_sha256: String,
    /// SHA-256 of the bounds file's content.
    pub bounds_sha256: String,
    /// Seeds of degradations and motions.
    pub seeds: Seeds,
}

impl Provenance {
    /// Of a ladder and the command that asked for it.
    pub fn of(ladder: &Ladder, command: &str) -> Self {
        let bounds = Bounds::acceptance();
        let configuration = ladder.design().to_toml();
        let design = ladder.design();
        let line = |(smoother, sigma): (usize, &f64)| {
            let cells = &ladder.bit_true().cells()[smoother];
            let reach: Vec<String> = cells.reach.iter().map(u32::to_string).collect();
            format!("sigma {sigma}: {}; {}\n", cells.g, reach.join(" "))
        };
        let coefficients: String = design.sigmas.iter().enumerate().map(line).collect();
        Self {
            commit: env!("HOVERLOCK_COMMIT"),
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

fn sha256(text: &str) -> String {
    Sha256::digest(text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
}
