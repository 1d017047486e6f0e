//! What people look at: the quantisation report, its plots and pictures.
//!
//! Every page is one file that needs no network: pictures travel as `data:` addresses, plots as inline SVG.

pub mod coefficient_plots;
pub mod colour;
pub mod embed;
pub mod figures;
pub mod hardware;
pub mod output;
pub mod overlay;
pub mod page;
pub mod plot;
pub mod provenance;
pub mod ranges;
pub mod study;
pub mod sweep;
