//! Extractor, flight program and simulated helicopter together.
//!
//! - [`cosim()`] passes a folder of frames through extractor and flight program.
//! - [`hover()`] closes the loop: the estimate steers a simulated helicopter in wind.
//! - [`upsets`] measures what an upset in the hardware costs in centimetres.
//! - [`Campaign`] flies many hovers on this machine or on a cluster, and [`fly_point`] one of them.
//!
//! Each takes a settings struct and returns an outcome struct, which serialises to the JSON object of the command of
//! the same name and renders its page. Nothing is printed and no file is written but the table of a campaign. The
//! caller follows and stops a run through a [`Monitor`]; `&()` ignores the progress.
//!
//! ```no_run
//! use hoverlock_cosim::{CosimSettings, HoverSettings, cosim, hover};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let settings = HoverSettings { scene: "town".into(), seconds: 5.0, ..HoverSettings::default() };
//! let outcome = hover(&settings, &())?;
//! println!("{:.3} m rms from the target", outcome.summary.rms_m);
//! std::fs::write("hover.csv", outcome.table()?)?;
//! std::fs::write("index.html", outcome.page("my program")?)?;
//!
//! let outcome = cosim(&CosimSettings::new("flight/"), &())?;
//! println!("{}", serde_json::to_string_pretty(&outcome)?);
//! # Ok(())
//! # }
//! ```

pub mod campaign;
pub mod chain;
pub mod hover;
mod monitor;
mod pages;
mod replay;
pub mod sequence;
pub mod toml_file;
pub mod upsets;

pub use campaign::{Campaign, CampaignOutcome, CampaignSettings, FlownPoint, Point, fly_point};
pub use chain::{FeatureSource, FlightProgram};
pub use hover::{HoverOutcome, HoverSettings, hover};
pub use monitor::{BoxError, FrameProgress, Monitor};
pub use pages::estimates::Estimate;
pub use replay::{Accuracy, CosimError, CosimFrame, CosimOutcome, CosimSettings, FloatReference, Position, cosim};
