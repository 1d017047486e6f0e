//! A claim: properties over Verilog modules, and how they are proved.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::ring;

/// A fault that must make the proof fail.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mutant {
    /// The source file.
    pub file: String,
    /// Text that stands in it exactly once.
    pub from: String,
    /// What it becomes.
    pub to: String,
}

/// A read port for the proof, which nothing of the module depends on.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Observe {
    /// The source file.
    pub file: String,
    /// Text put before its `endmodule`.
    pub text: String,
}

/// What the raw integer of an input stands for.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unit {
    /// Its unit.
    pub unit: String,
    /// One LSB in this unit.
    pub lsb: f64,
}

/// Steps in which most faults show.
fn fault() -> u32 {
    8
}

/// A claim; what its TOML file says, and what follows from its name.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Its name, that of its files.
    #[serde(skip)]
    pub name: String,
    /// What is claimed, in words.
    pub statement: String,
    /// The Verilog files it is about.
    pub sources: Vec<String>,
    /// The wrapper with the properties; its top is `NAME_properties`, or the only top there is.
    #[serde(skip)]
    pub properties: String,
    /// The wrapper's module; `None` lets Yosys find it.
    #[serde(skip)]
    pub top: Option<String>,
    /// `k` of the induction, or how many steps from reset where the claim is bounded.
    pub depth: u32,
    /// Steps within which each cover must be reached.
    pub cover: u32,
    /// Steps from reset in which a mutant is looked for before the induction is asked.
    #[serde(default = "fault")]
    pub fault: u32,
    /// Proved for `depth` steps from reset only.
    #[serde(default)]
    pub bounded: bool,
    /// Products are replaced by any value that the wrapper's assumptions allow.
    #[serde(default)]
    pub cut_products: bool,
    /// Modules left out: their outputs may be anything at each step.
    #[serde(default)]
    pub cut: Vec<String>,
    /// Faults that must make the proof fail.
    #[serde(default, rename = "mutant")]
    pub mutants: Vec<Mutant>,
    /// Sources that the proof also has as they are without a fault, their modules named `golden_NAME`: what a module is
    /// compared with.
    #[serde(default)]
    pub golden: Vec<String>,
    /// What the proof reads of the modules beside their ports and wires, as memories.
    #[serde(default)]
    pub observe: Vec<Observe>,
    /// What the claim takes for granted, in words.
    #[serde(default)]
    pub assumed: Vec<String>,
    /// Units of the wrapper's inputs, in which a violation is told.
    #[serde(default)]
    pub units: BTreeMap<String, Unit>,
}

/// Why a claim cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("claim {name}: {reason}")]
pub struct ClaimError {
    name: String,
    reason: String,
}

impl Claim {
    /// A claim from its two files.
    ///
    /// # Errors
    /// The settings are not TOML, or lack something.
    pub fn parse(name: &str, settings: &str, properties: &str) -> Result<Self, ClaimError> {
        let claim: Self = toml::from_str(settings).map_err(|error| ClaimError {
            name: name.into(),
            reason: error.to_string().lines().collect::<Vec<_>>().join(" "),
        })?;
        let top = Some(format!("{name}_properties"));
        Ok(Self { name: name.into(), properties: properties.into(), top, ..claim })
    }
}

macro_rules! shipped {
    ($($name:literal),* $(,)?) => {
        /// Name, settings and properties of the claims about the emitted Verilog.
        const SHIPPED: &[(&str, &str, &str)] = &[$((
            $name,
            include_str!(concat!("../claims/", $name, ".toml")),
            include_str!(concat!("../claims/", $name, ".sv")),
        )),*];
    };
}

shipped![
    "lerp",
    "difference",
    "row_look_back",
    "row_look_ahead",
    "row_look_ahead_border",
    "frame_delay",
    "markers",
    "address_counter",
    "delay",
    "line_delay_18x32",
    "window_maximum_5",
    "window_maximum_7",
    "column_maximum",
    "decision",
    "cursor",
    "threshold",
    "candidate_queue",
    "record_fifo",
    "sequencer",
    "unset_registers",
    "csr",
    "ring_comparator",
    "record_writer",
    "top",
];

/// The claims about the emitted Verilog.
///
/// # Errors
/// One of them is not as it should be.
pub fn shipped() -> Result<Vec<Claim>, ClaimError> {
    let written = SHIPPED.iter().map(|(name, settings, properties)| Claim::parse(name, settings, properties));
    written.chain(ring::claims().into_iter().map(Ok)).collect()
}
