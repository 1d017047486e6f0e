//! `rtl`: the same bits from the emitted Verilog, and what it takes of a device.
//!
//! The simulation and the estimate are made elsewhere, with tools that may be missing. Here they are plain numbers, or the reason why there
//! are none; a level that was not run holds no bound and breaks none.

use hoverlock_fixed_point::analysis::bounds::{Check, Sense};
use serde::Serialize;

use hoverlock_fixed_point::analysis::levels::Level;

use crate::study::{self, BoundRow, LevelStudy, Study};

/// The name of its bound.
pub const MISMATCHES: &str = "RTL mismatches";

/// Something that needs a tool: made, or not, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "status", rename_all = "lowercase")]
pub enum Made<T> {
    /// It was made.
    Run {
        /// What came of it.
        result: T,
    },
    /// It was not.
    #[serde(rename = "not run")]
    NotRun {
        /// One line.
        reason: String,
    },
}

impl<T> Made<T> {
    /// Not made.
    pub fn not_run(reason: impl Into<String>) -> Self {
        Self::NotRun { reason: reason.into() }
    }

    /// What came of it.
    pub fn result(&self) -> Option<&T> {
        match self {
            Self::Run { result } => Some(result),
            Self::NotRun { .. } => None,
        }
    }
}

/// The frames of one picture through the Verilated top, one condition after the other, back to back.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Simulated {
    /// Name of the picture.
    pub picture: String,
    /// Frames.
    pub frames: u64,
    /// Pixels of all frames.
    pub pixels: u64,
    /// Clock cycles.
    pub cycles: u64,
    /// Samples of all planes compared.
    pub samples: u64,
    /// Features compared.
    pub features: u64,
    /// Features that the hardware dropped.
    pub dropped: u64,
    /// Samples and features that differ.
    pub mismatches: u64,
    /// The first of them, in words.
    pub first_mismatch: Option<String>,
    /// All that should have been compared was.
    pub complete: bool,
    /// Cycles between the starts of frames over their pixels, the worst.
    pub cycles_per_pixel: Option<f64>,
    /// Lines from a frame's first pixel to its first smoothed sample.
    pub latency_lines: Option<f64>,
    /// Lines from a feature's pixel to its record.
    pub feature_latency_lines: Option<f64>,
}

/// A device and what is used of it, each in the order ALM, M10K, DSP blocks.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DeviceShare {
    /// Name.
    pub name: String,
    /// Where its figures come from.
    pub source: String,
    /// What it has.
    pub has: [u64; 3],
    /// What may be used.
    pub limits: [u64; 3],
    /// What is used, percent.
    pub used_percent: [f64; 3],
    /// The limits are kept.
    pub fits: bool,
}

/// What the instances of one module take.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModuleShare {
    /// Name.
    pub name: String,
    /// How often it is there.
    pub instances: u64,
    /// Adaptive logic modules.
    pub alm: u64,
    /// Block memories.
    pub m10k: u64,
    /// Multipliers 18 x 18.
    pub mul18: u64,
    /// Registers.
    pub registers: u64,
    /// Levels of the longest path through its logic.
    pub logic_levels: u32,
}

/// What the hardware takes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sizing {
    /// Who says so.
    pub label: String,
    /// Adaptive logic modules.
    pub alm: u64,
    /// Block memories.
    pub m10k: u64,
    /// DSP blocks.
    pub dsp: u64,
    /// Multipliers 18 x 18.
    pub mul18: u64,
    /// Registers.
    pub registers: u64,
    /// Levels of the longest path.
    pub logic_levels: u32,
    /// The clock it is meant for, MHz.
    pub target_mhz: u32,
    /// How ALMs are derived.
    pub alm_rule: String,
    /// What a level is.
    pub levels_rule: String,
    /// What fits.
    pub fits_rule: String,
    /// The device it is for first.
    pub devices: Vec<DeviceShare>,
    /// Each module, the largest first.
    pub modules: Vec<ModuleShare>,
}

/// `rtl`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Hardware {
    /// Each picture.
    pub simulation: Made<Vec<Simulated>>,
    /// The estimate.
    pub estimate: Made<Sizing>,
}

/// All pictures together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Totals {
    /// Frames.
    pub frames: u64,
    /// Samples compared.
    pub samples: u64,
    /// Features compared.
    pub features: u64,
    /// What differs.
    pub mismatches: u64,
    /// The worst.
    pub cycles_per_pixel: Option<f64>,
    /// The worst.
    pub latency_lines: Option<f64>,
    /// The worst.
    pub feature_latency_lines: Option<f64>,
}

impl Hardware {
    /// Nobody ran anything.
    pub fn not_run(reason: &str) -> Self {
        Self { simulation: Made::not_run(reason), estimate: Made::not_run(reason) }
    }

    /// All pictures together.
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
    /// The study with its last level: 0 mismatches are allowed on each picture, and none are said of one where nothing was compared.
    #[must_use]
    pub fn with_hardware(mut self, hardware: Hardware) -> Self {
        for run in hardware.simulation.result().into_iter().flatten() {
            let measured = if run.complete || run.mismatches > 0 { run.mismatches as f64 } else { f64::NAN };
            let place = match &run.first_mismatch {
                Some(first) => first.clone(),
                None if run.complete => format!("{} samples, {} features compared", run.samples, run.features),
                None => "not everything was compared".into(),
            };
            let check = Check::new(MISMATCHES, "", Sense::AtMost, 0.0, measured, place);
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
            changes: study::changes(Level::Rtl),
            measurements: Vec::new(),
            hardware: Some(hardware),
        });
        self
    }

    /// `rtl`.
    pub fn hardware(&self) -> Option<&Hardware> {
        self.levels.iter().find_map(|level| level.hardware.as_ref())
    }
}
