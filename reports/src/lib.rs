//! The quantisation report: measurements, HTML page, JSON and JUnit files; and the plots, drawings and page style that
//! other reports share.
//!
//! The HTML page is one file without network access: pictures are `data:` URLs, plots are inline SVG.

pub mod baseline;
pub mod canvas;
pub mod check_outcome;
pub mod coefficient_plots;
pub mod colour;
pub mod embed;
pub mod figures;
pub mod hardware;
pub mod journal;
pub mod output;
pub mod overlay;
pub mod page;
pub mod plot;
pub mod provenance;
pub mod ranges;
pub mod repeatability;
pub mod smoothers;
pub mod study;
pub mod sweep;
