//! The published description of the method, figure by figure and claim by claim, beside what today's code gives.
//!
//! | module | figures |
//! |---|---|
//! | `system` | 1 to 3, 12, 13: what is connected to what, and what flows |
//! | `terrain` | 4 and formula (1): displacement of points by relief |
//! | `filters` | 5 to 7: the first-order filter in place of the Gaussian |
//! | `descriptors` | 8 and 9: LBP and MaxLBP |
//! | `motion` | 10, 11 and 15: matching on pseudo-orthophotos, RANSAC |
//! | `scenes` | 14: pictures of the simulator |
//!
//! The pictures are those of the simulator, and everything random has a seed, so the page is the same everywhere. Only
//! instructions of the ARM, which take a cross compiler and an emulator, come from `docs/results.json`.

mod descriptors;
mod diagram;
mod filters;
mod motion;
pub mod page;
mod scenes;
mod system;
mod terrain;

use std::collections::BTreeMap;

use hoverlock_edss::render::RenderError;
use hoverlock_edss::scene::SceneError;
use hoverlock_fixed_point::model::coefficients::CoefficientError;
use hoverlock_reference::motion::orthophoto::ViewError;
use hoverlock_reference::motion::ransac::RansacError;
use hoverlock_reference::smoothing::design::DesignError;
use hoverlock_reports::coefficient_plots::FigureError;
use hoverlock_reports::plot::PlotError;
use image::ImageError;
use serde::Serialize;
use serde_json::Value;

/// The reason why a figure cannot be regenerated. Each is a defect of this program: it has no input.
#[derive(Debug, thiserror::Error)]
pub enum PaperError {
    /// A filter has no coefficients.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// The default design has no coefficients.
    #[error(transparent)]
    Coefficients(#[from] CoefficientError),
    /// A plot failed.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// The plot of a filter failed.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// A picture cannot be encoded.
    #[error("a picture cannot be encoded: {0}")]
    Image(#[from] ImageError),
    /// A scene is not valid.
    #[error("a scene is not valid: {0}")]
    Scene(#[from] SceneError),
    /// A scene cannot be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A view sees no ground.
    #[error(transparent)]
    View(#[from] ViewError),
    /// Two pictures have no motion.
    #[error("two pictures of one place have no motion: {0}")]
    Motion(#[from] RansacError),
    /// A measured number is missing.
    #[error("docs/results.json has no {0}; measure it")]
    NoResult(String),
    /// A ray of the camera meets no ground.
    #[error("a ray of the camera meets no ground")]
    NoGround,
}

/// A command that states numbers of the page.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Command {
    /// The command, to paste in the folder of the page.
    pub line: String,
    /// Members of its `--json` as JSON pointers, with their values.
    pub states: BTreeMap<&'static str, Value>,
}

/// A figure, formula or claim of the description, and what today's code gives.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Item {
    /// Its number there: `figure 4`, `formula (1)`, `claim 2`.
    pub number: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// What is stated there.
    pub stated: &'static str,
    /// What was found here, with its numbers.
    pub found: String,
    /// Whether the statement holds; `None` if it states nothing that can be false.
    pub holds: Option<bool>,
    /// The command or the document where it can be followed further; empty if there is none.
    pub evidence: &'static str,
    /// The commands that state its numbers.
    pub commands: Vec<Command>,
    /// The numbers that no command but this page states; empty if there are none.
    pub only_here: &'static str,
    /// The files that the commands read, by their names in the folder of the page.
    #[serde(skip)]
    pub inputs: Vec<(String, Vec<u8>)>,
    /// Drawings, each an SVG element.
    #[serde(skip)]
    pub drawings: Vec<String>,
}

/// Regenerates all items in the order of the description. `progress` gets the number of each step, from 0, and the
/// number of steps before it begins.
///
/// # Errors
/// See [`PaperError`].
pub fn items(progress: impl Fn(usize, usize)) -> Result<Vec<Item>, PaperError> {
    type Step = fn() -> Result<Vec<Item>, PaperError>;
    let steps: [Step; 7] = [
        || Ok(system::first()),
        terrain::items,
        filters::items,
        descriptors::items,
        motion::items,
        || Ok(system::second()),
        scenes::items,
    ];
    let mut items = Vec::new();
    for (number, step) in steps.iter().enumerate() {
        progress(number, steps.len());
        items.extend(step()?);
    }
    items.extend(motion::town()?);
    items.push(system::relief_of_the_processor()?);
    Ok(items)
}
