//! Where features come from and where the flight program runs.

use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Serialize};

use super::ChainError;
use super::flight_program::arm_binary;

/// The source of the features.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FeatureSource {
    /// The reference in f32, with responses rounded to the LSB of the records.
    Float,
    /// The bit-true integer model.
    #[default]
    Fixed,
    /// The emitted Verilog under Verilator, with its records through a DMA and a ring of buffers.
    Rtl,
}

impl Display for FeatureSource {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Float => "float",
            Self::Fixed => "fixed",
            Self::Rtl => "rtl",
        })
    }
}

impl FeatureSource {
    /// Returns the name and a description for a page.
    pub fn description(self) -> String {
        let text = match self {
            Self::Float => "the reference in f32",
            Self::Fixed => "the bit-true model",
            Self::Rtl => "the emitted Verilog under Verilator, records through a DMA and a ring of buffers",
        };
        format!("{self}, {text}")
    }
}

/// The place where the flight program runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FlightProgram {
    /// In this process.
    #[default]
    Host,
    /// As the ARM binary under qemu-arm, fed through a pipe; its lines are compared with those of the host.
    Arm,
}

impl Display for FlightProgram {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Host => "host",
            Self::Arm => "arm",
        })
    }
}

impl FlightProgram {
    /// Checks that the program is installed.
    ///
    /// # Errors
    /// The ARM binary does not exist.
    pub fn check_installed(self) -> Result<(), ChainError> {
        (self == Self::Arm).then(arm_binary).transpose().map(|_| ())
    }

    /// Returns the name and a description for a page.
    pub fn description(self) -> String {
        let text = match self {
            Self::Host => "in the process of the command",
            Self::Arm => "the ARM binary under qemu; its lines are the host's, compared byte for byte",
        };
        format!("{self}, {text}")
    }
}
