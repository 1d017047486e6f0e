//! Results of the level `rtl`: simulation of the emitted Verilog against `bit_true`, and its resource estimate.
//!
//! Another crate runs the simulation and the estimate, with tools that may be missing. This module has their results,
//! or the reason why there are none. No bound is checked for a simulation that was not run.

use hoverlock_fixed_point::analysis::bounds::{Check, Sense};
use hoverlock_fixed_point::analysis::levels::Level;
use serde::Serialize;

use crate::study::{self, BoundRow, LevelStudy, Study};

/// Name of the bound on the simulation.
pub const MISMATCHES: &str = "RTL mismatches";

/// The result of a step that needs an external tool, or the reason why the step was not run.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "status", rename_all = "lowercase")]
pub enum StepResult<T> {
    /// The step was run.
    Run {
        /// The result of the step.
        result: T,
    },
    /// The step was not run.
    #[serde(rename = "not run")]
    NotRun {
        /// The reason, one line.
        reason: String,
    },
}

impl<T> StepResult<T> {
    /// Returns a step that was not run.
    pub fn not_run(reason: impl Into<String>) -> Self {
        Self::NotRun { reason: reason.into() }
    }

    /// Returns the result; `None` if the step was not run.
    pub fn result(&self) -> Option<&T> {
        match self {
            Self::Run { result } => Some(result),
            Self::NotRun { .. } => None,
        }
    }
}

/// The simulation of one picture: one frame for each condition, back to back.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Simulated {
    /// File name of the picture.
    pub picture: String,
    /// Number of frames simulated.
    pub frames: u64,
    /// Pixels of all frames.
    pub pixels: u64,
    /// Number of clock cycles simulated.
    pub cycles: u64,
    /// Samples compared, all planes.
    pub samples: u64,
    /// Number of features compared.
    pub features: u64,
    /// Features dropped by the output FIFO.
    pub dropped: u64,
    /// Samples and features that differ from `bit_true`.
    pub mismatches: u64,
    /// Description of the first mismatch.
    pub first_mismatch: Option<String>,
    /// Every expected sample and feature was compared.
    pub complete: bool,
    /// Clock cycles from one start of frame to the next, per pixel; the largest.
    pub cycles_per_pixel: Option<f64>,
    /// Latency from the first pixel of a frame to its first smoothed sample, lines.
    pub latency_lines: Option<f64>,
    /// Latency from the pixel of a feature to its record, lines.
    pub feature_latency_lines: Option<f64>,
}

/// Utilisation of one device. Arrays are in the order ALM, M10K, DSP blocks.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DeviceUtilisation {
    /// Name of the device.
    pub name: String,
    /// Source of the device data.
    pub source: String,
    /// Resources of the device.
    pub has: [u64; 3],
    /// Limits on the use.
    pub limits: [u64; 3],
    /// Use, percent of the device.
    pub used_percent: [f64; 3],
    /// The design is within the limits.
    pub fits: bool,
}

/// Resources of all instances of one module.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModuleResources {
    /// Name of the module.
    pub name: String,
    /// Number of instances.
    pub instances: u64,
    /// Number of adaptive logic modules of all instances.
    pub alm: u64,
    /// Number of M10K block memories of all instances.
    pub m10k: u64,
    /// Number of 18 x 18 multipliers of all instances.
    pub mul18: u64,
    /// Number of registers of all instances.
    pub registers: u64,
    /// Logic levels of its longest path.
    pub logic_levels: u32,
}

/// The resource estimate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ResourceEstimate {
    /// Name of the estimating tool.
    pub label: String,
    /// Adaptive logic modules.
    pub alm: u64,
    /// M10K block memories.
    pub m10k: u64,
    /// Number of DSP blocks.
    pub dsp: u64,
    /// Multipliers 18 x 18.
    pub mul18: u64,
    /// Number of registers.
    pub registers: u64,
    /// Logic levels of the longest path.
    pub logic_levels: u32,
    /// Target clock frequency, MHz.
    pub target_mhz: u32,
    /// How ALMs are counted, one sentence.
    pub alm_rule: String,
    /// How logic levels are counted, one sentence.
    pub levels_rule: String,
    /// The rule of the limits, one sentence.
    pub fits_rule: String,
    /// Devices, the target device first.
    pub devices: Vec<DeviceUtilisation>,
    /// Modules, largest first.
    pub modules: Vec<ModuleResources>,
}

/// The results of the level `rtl`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Hardware {
    /// Simulation of each picture.
    pub simulation: StepResult<Vec<Simulated>>,
    /// The resource estimate.
    pub estimate: StepResult<ResourceEstimate>,
}

/// Totals over all pictures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Totals {
    /// Number of frames simulated.
    pub frames: u64,
    /// Number of samples compared.
    pub samples: u64,
    /// Number of features compared.
    pub features: u64,
    /// Number of mismatches.
    pub mismatches: u64,
    /// Clock cycles per pixel, the largest.
    pub cycles_per_pixel: Option<f64>,
    /// Latency to the smoothed sample, lines, the largest.
    pub latency_lines: Option<f64>,
    /// Latency to the feature record, lines, the largest.
    pub feature_latency_lines: Option<f64>,
}

impl Hardware {
    /// Returns results of which neither simulation nor estimate was run.
    pub fn not_run(reason: &str) -> Self {
        Self { simulation: StepResult::not_run(reason), estimate: StepResult::not_run(reason) }
    }

    /// Returns the totals over all pictures; `None` if the simulation was not run.
    pub fn totals(&self) -> Option<Totals> {
        let runs = self.simulation.result()?;
        let sum = |of: fn(&Simulated) -> u64| runs.iter().map(of).sum();
        let worst = |of: fn(&Simulated) -> Option<f64>| runs.iter().filter_map(of).reduce(f64::max);
        Some(Totals {
            frames: sum(|run| run.frames),
            samples: sum(|run| run.samples),
            features: sum(|run| run.features),
            mismatches: sum(|run| run.mismatches),
            cycles_per_pixel: worst(|run| run.cycles_per_pixel),
            latency_lines: worst(|run| run.latency_lines),
            feature_latency_lines: worst(|run| run.feature_latency_lines),
        })
    }
}

impl Study {
    /// Adds the level `rtl`. The bound is 0 mismatches for each picture; a comparison that is not complete fails.
    #[must_use]
    pub fn with_hardware(mut self, hardware: Hardware) -> Self {
        for run in hardware.simulation.result().into_iter().flatten() {
            let measured = if run.complete || run.mismatches > 0 { run.mismatches as f64 } else { f64::NAN };
            let location = match &run.first_mismatch {
                Some(first) => first.clone(),
                None if run.complete => format!("{} samples, {} features compared", run.samples, run.features),
                None => "comparison not complete".into(),
            };
            let check = Check::new(MISMATCHES, "", Sense::AtMost, 0.0, measured, location);
            self.pass &= check.pass;
            self.bounds.push(BoundRow {
                margin: check.limit - check.measured,
                check,
                picture: Some(run.picture.clone()),
                condition: None,
            });
        }
        self.levels.retain(|level| level.name != Level::Rtl);
        self.levels.push(LevelStudy {
            name: Level::Rtl,
            changes: study::changes(Level::Rtl, &self.design),
            measurements: Vec::new(),
            hardware: Some(hardware),
        });
        self
    }

    /// Returns the results of the level `rtl`.
    pub fn hardware(&self) -> Option<&Hardware> {
        self.levels.iter().find_map(|level| level.hardware.as_ref())
    }
}
