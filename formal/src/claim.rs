//! Claims: properties of Verilog modules, and the parameters of their proofs.

use std::collections::BTreeMap;

use serde::Deserialize;

/// A fault in a source file that must make the proof fail.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mutant {
    /// Name of the source file.
    pub file: String,
    /// Text to replace, which must occur exactly once in the file.
    pub from: String,
    /// Text to put in its place.
    pub to: String,
}

/// An observer that the proof adds to a module, such as a read port of a memory; the module does not depend on it.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Observe {
    /// Name of the source file.
    pub file: String,
    /// Verilog to insert before `endmodule`.
    pub text: String,
}

/// A hole of a claim: mutations that change the module and that the proof does not detect, with the reason.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hole {
    /// Number of the hole, unique in the claim.
    pub number: u32,
    /// Name of the source file.
    pub file: String,
    /// Texts of source lines: a mutation matches if the line of its cell contains one of them.
    pub lines: Vec<String>,
    /// Why the claim does not cover it, and what does.
    pub reason: String,
}

/// An assumption of a claim, and what guarantees it: assertions of other claims, a rule, or a hole of the proof.
#[derive(Debug, Clone, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Assumption {
    /// The assumption in words.
    pub text: String,
    /// Assertions that guarantee it, as `claim.label`, or `claim` for a claim about numbers.
    #[serde(default)]
    pub by: Vec<String>,
    /// Name of the rule of the composition that the integrator keeps.
    pub rule: Option<String>,
    /// Number of the hole in formal/README.md that is left.
    pub hole: Option<u32>,
}

/// The physical unit of an input, for counter-examples.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unit {
    /// Name of the unit.
    pub unit: String,
    /// Value of one LSB in this unit.
    pub lsb: f64,
}

/// Returns the number of steps in which most mutants are refuted.
fn default_fault() -> u32 {
    8
}

/// A claim: the contents of its TOML file, and the wrapper with the properties.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Name of the claim and of its files.
    #[serde(skip)]
    pub name: String,
    /// The claim in words.
    pub statement: String,
    /// Names of the Verilog files that the claim is about.
    pub sources: Vec<String>,
    /// Source of the wrapper with the properties.
    #[serde(skip)]
    pub properties: String,
    /// Name of the wrapper's module; `None` lets Yosys find the only top module.
    #[serde(skip)]
    pub top: Option<String>,
    /// `k` of the induction, or the number of steps from reset if the claim is bounded.
    pub depth: u32,
    /// Number of steps from reset within which each cover must be reached.
    pub cover: u32,
    /// Number of steps from reset in which a mutant is searched for a violation before the induction is tried.
    #[serde(default = "default_fault")]
    pub fault: u32,
    /// The claim is only proved for `depth` steps from reset, without induction.
    #[serde(default)]
    pub bounded: bool,
    /// Products are abstracted: they may have any value that the assumptions of the wrapper allow.
    #[serde(default)]
    pub cut_products: bool,
    /// Modules that are abstracted: their outputs may have any value in each step.
    #[serde(default)]
    pub cut: Vec<String>,
    /// Faults that must make the proof fail.
    #[serde(default, rename = "mutant")]
    pub mutants: Vec<Mutant>,
    /// Sources that the proof also contains without the fault, with their modules renamed to `golden_NAME`, for
    /// comparison.
    #[serde(default)]
    pub golden: Vec<String>,
    /// Observers of state that is not on a port or a wire, such as memories.
    #[serde(default)]
    pub observe: Vec<Observe>,
    /// Mutations that the proof does not detect, with reasons.
    #[serde(default, rename = "hole")]
    pub holes: Vec<Hole>,
    /// Sources whose mutations another claim answers for: file name, and name of that claim.
    #[serde(default)]
    pub elsewhere: BTreeMap<String, String>,
    /// Assumptions of the claim.
    #[serde(default)]
    pub assumed: Vec<Assumption>,
    /// Units of the inputs of the wrapper, for counter-examples.
    #[serde(default)]
    pub units: BTreeMap<String, Unit>,
}

/// The error of reading a claim.
#[derive(Debug, thiserror::Error)]
#[error("claim {name}: {reason}")]
pub struct ClaimError {
    name: String,
    reason: String,
}

impl Claim {
    /// Creates a claim from its name, its TOML file and its wrapper, whose module must be `NAME_properties`.
    ///
    /// # Errors
    /// If the settings are not valid TOML, a key is missing or unknown, or two holes have the same number.
    pub fn parse(name: &str, settings: &str, properties: &str) -> Result<Self, ClaimError> {
        let claim: Self = toml::from_str(settings).map_err(|error| ClaimError {
            name: name.into(),
            reason: error.to_string().lines().collect::<Vec<_>>().join(" "),
        })?;
        let mut numbers: Vec<u32> = claim.holes.iter().map(|hole| hole.number).collect();
        numbers.sort_unstable();
        if let Some(pair) = numbers.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(ClaimError { name: name.into(), reason: format!("two holes have number {}", pair[0]) });
        }
        let top = Some(format!("{name}_properties"));
        Ok(Self { name: name.into(), properties: properties.into(), top, ..claim })
    }
}
