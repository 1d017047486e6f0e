//! The search for the cheapest design that passes every check of the quantisation report.
//!
//! Each of three words can be short on its own while all three together fail, and a shorter word can pass where a
//! longer one fails, because it can be close to the exact value by chance. So the search covers all combinations of
//! words and concludes nothing about one design from another. A design is measured until its first check fails. The
//! parts of the measurement at which the base design is closest to a limit come first, and the cheapest designs. The
//! best design is always measured in full.
//!
//! [`mission`] is the search by another bound: the centimetres that a simulated helicopter keeps to its target.
//!
//! Resources are those of the memory model ([`hoverlock_fixed_point::analysis::resources`]), which needs no synthesis.

mod measure;
pub mod mission;
pub mod output;
mod page;
pub mod results;
mod search;
mod space;

use std::time::Instant;

use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::analysis::resources::Resources;
use hoverlock_reports::check_outcome::CheckOutcome;
use hoverlock_reports::study::{Subject, Unfit};
use serde::Serialize;

pub use measure::PartOutcome;
pub use results::KnownResults;
pub use search::run;
pub use space::Unbuildable;

/// The quantity that the best design has least of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Objective {
    /// Block memories of 10 kbit.
    M10k,
    /// Adaptive logic modules.
    Alm,
    /// DSP blocks with multipliers.
    Dsp,
    /// The DoG error, among the designs that fit the device.
    Error,
}

/// The inputs of a search.
pub struct Task<'a> {
    /// The design whose words are changed.
    pub base: &'a DesignPoint,
    /// The pictures to measure on.
    pub subjects: &'a [Subject],
    /// The quantity to minimise.
    pub objective: Objective,
    /// Time at which the search stops.
    pub deadline: Instant,
    /// Name of the device, and the ALM, M10K and DSP blocks that a design may use.
    pub device: (&'a str, [u64; 3]),
    /// Returns the reason why a design cannot be built.
    pub unbuildable: Unbuildable<'a>,
    /// Version of the program. Results of another version are not reused.
    pub build: &'a str,
}

/// The state of knowledge about a design.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// The design passes every check.
    Passes,
    /// The design fails a check.
    Fails,
    /// The search stopped before the design was measured in full.
    Open,
}

/// A design after the search.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Point {
    /// Differences from the base design in the syntax of `--config`; `base` for the base.
    pub name: String,
    /// The design itself: the base or a variant of it.
    pub design: DesignPoint,
    /// Resources by the memory model.
    #[serde(flatten)]
    pub resources: Resources,
    /// The design fits the device.
    pub fits: bool,
    /// Result of the checks.
    pub status: Status,
    /// The design passes every check.
    pub pass: bool,
    /// Percentage of the allowance that the closest check leaves, negative if it fails. `None` if nothing was measured.
    pub margin: Option<f64>,
    /// The check that is closest to its limit, or furthest beyond it.
    pub worst: Option<CheckOutcome>,
    /// The first check that fails.
    pub failure: Option<CheckOutcome>,
    /// Rms of the DoG error on the worst frame measured, LSB of the design point `kt27`.
    pub dog_rms_lsb: Option<f64>,
    /// Number of frames measured, over all pictures and conditions.
    pub frames: usize,
    /// The design is on the Pareto front of memory and error.
    pub front: bool,
}

/// The result of a search.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Exploration {
    /// A design passes every check.
    pub pass: bool,
    /// Every design that could be better than the best has been measured.
    pub decided: bool,
    /// Every design has been measured.
    pub complete: bool,
    /// The quantity that was minimised.
    pub objective: Objective,
    /// Name of the device.
    pub device: String,
    /// Number of frames, over all pictures and conditions.
    pub frames: usize,
    /// Number of parts measured by this search.
    pub measured: usize,
    /// Number of parts whose results an earlier search had.
    pub restored: usize,
    /// Index of the best design in `points`; `None` if no design passes. The JSON file has the design itself under this
    /// name.
    #[serde(skip)]
    pub best: Option<usize>,
    /// Pictures, conditions and motions by which the base cannot be judged. Part of no verdict.
    pub unfit: Vec<Unfit>,
    /// Name of each picture, and SHA-256 of the part that was measured.
    pub pictures: Vec<(String, String)>,
    /// Names of the pictures that judge: by one of their parts the base can be judged.
    pub judges: Vec<String>,
    /// All designs, the base first.
    pub points: Vec<Point>,
}

impl Exploration {
    /// Returns the best design; `None` if no design passes.
    pub fn best(&self) -> Option<&Point> {
        self.points.get(self.best?)
    }

    /// Returns the design whose words were changed.
    pub fn base(&self) -> Option<&Point> {
        self.points.first()
    }
}

/// The progress of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Progress {
    /// Number of designs whose status is known.
    pub settled: usize,
    /// Number of designs of the search.
    pub designs: usize,
    /// The measurement that begins.
    pub step: String,
    /// Name and M10K of the cheapest design that has passed so far.
    pub best: Option<(String, u64)>,
}
