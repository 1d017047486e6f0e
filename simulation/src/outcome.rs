//! The result of a run: counts, rates, and the first difference as text.

use hoverlock_fixed_point::model::record::FeatureRecord;

/// A difference between hardware and model, as text.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Mismatch {
    /// Stage: `smoother narrow` and the other smoothers, `DoG 0`, `MaxDOG 0` and the other scale pairs,
    /// `decision`, `record`, `descriptor`, `trailer`, `feature FIFO`, `feature stream`, `registers`, `end of frame`.
    pub stage: String,
    /// Frame, from 0.
    pub frame: usize,
    /// Column, pixels.
    pub x: usize,
    /// Row, pixels.
    pub y: usize,
    /// Clock cycle since reset.
    pub cycle: u64,
    /// The field that differs.
    pub field: String,
    /// Value of `bit_true`, in hex and in DN.
    pub expected: String,
    /// Value of the hardware.
    pub actual: String,
}

/// Frame and pixel of a comparison.
#[derive(Debug, Clone, Copy)]
pub(super) struct Position {
    pub frame: usize,
    pub x: usize,
    pub y: usize,
}

/// The result of a frame.
#[derive(Debug, Clone, Default, serde::Serialize)]
pub struct FrameOutcome {
    /// The cycle in which its first pixel was taken.
    pub began: u64,
    /// Its thresholds, as `bit_true` has them.
    pub thresholds: Vec<u32>,
    /// Features `bit_true` finds in it; of a frame that a reset cut off, those that came out before.
    pub model_features: u64,
    /// Records that came out.
    pub features: u64,
    /// Features its trailer says were dropped.
    pub dropped: u64,
    /// Samples and records that differ.
    pub mismatches: u64,
    /// The records themselves, in the order in which they came out.
    #[serde(skip)]
    pub records: Vec<FeatureRecord>,
}

/// The result of a run.
#[derive(Debug, Clone, Default, serde::Serialize)]
pub struct Outcome {
    /// Number of pixels sent.
    pub pixels: u64,
    /// Clock cycles from the first after the reset.
    pub cycles: u64,
    /// Cycles between the starts of consecutive frames of one size, over their pixels, the worst; `None` for fewer
    /// than three, or if source or sink pause.
    pub cycles_per_pixel: Option<f64>,
    /// The sum over the frames; `features + dropped` if nothing differs.
    pub model_features: u64,
    /// Records compared.
    pub features: u64,
    /// Features the hardware says it dropped.
    pub dropped: u64,
    /// Samples of all planes compared.
    pub samples: u64,
    /// Samples and records that differ.
    pub mismatches: u64,
    /// The first of them.
    pub first_mismatch: Option<Mismatch>,
    /// Simulated clock cycles a second, everything compared.
    pub cycles_per_second: f64,
    /// The status register at the end, see `registers/REGISTERS.md`.
    pub status: u32,
    /// The register `emission` at the end: the hash of the Verilog that ran.
    pub emission: u32,
    /// Lines from a frame's first pixel to its first smoothed sample, with the rest in pixels as a fraction; `None`
    /// if source or sink pause.
    pub latency_lines: Option<f64>,
    /// Lines from a feature's own pixel at the input to its record at the FIFO, the least of all: a second scale pair
    /// at the same pixel comes later, and so do frames that wait for their size. `None` if source or sink pause.
    pub feature_latency_lines: Option<f64>,
    /// The result of each frame.
    pub frames: Vec<FrameOutcome>,
    /// The cycle in which the first record was taken.
    #[serde(skip)]
    pub first_feature: Option<u64>,
}

impl Outcome {
    /// Returns `true` if features and planes were compared, nothing differs, and every feature either came out or was
    /// counted as dropped.
    pub fn pass(&self) -> bool {
        self.mismatches == 0
            && self.features > 0
            && self.samples > 0
            && self.features + self.dropped == self.model_features
    }

    /// Counts a difference; `texts` gives field, expected and actual of the first.
    #[cold]
    pub(super) fn differ(&mut self, stage: &str, at: Position, cycle: u64, texts: impl FnOnce() -> [String; 3]) {
        self.mismatches += 1;
        if let Some(frame) = self.frames.get_mut(at.frame) {
            frame.mismatches += 1;
        }
        if self.first_mismatch.is_none() {
            let [field, expected, actual] = texts();
            let Position { frame, x, y } = at;
            self.first_mismatch = Some(Mismatch { stage: stage.into(), frame, x, y, cycle, field, expected, actual });
        }
    }
}
