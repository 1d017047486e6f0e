//! Renders a [`Study`] as one HTML page.
//!
//! The template `templates/report.html` holds the text and its order. Each module here makes the tables or plots of one
//! part of the page. Summary tables show the worst value over all pictures and conditions, and where it was found.

mod bounds;
mod chains;
mod contrast;
mod descriptor_bits;
mod device;
mod displacement;
mod histograms;
mod levels;
mod maps;
mod numbers;
mod ranges;
mod stability;
mod tiles;
mod word_lengths;

use hoverlock_fixed_point::analysis::bounds::Bounds;
use hoverlock_pictures::conditions::CONDITIONS;
use minijinja::value::{Serde, Value};
use minijinja::{Environment, context};
use serde::Serialize;

use crate::colour::Rgb;
use crate::figures;
use crate::hardware::Hardware;
use crate::plot::{BLUE, ORANGE, PlotError, VIOLET};
use crate::study::{Kind, Study};
use crate::sweep;
use numbers::{grouped, significant, typeset};

const TEMPLATE: &str = include_str!("../../templates/report.html");
/// The style sheet of all pages.
pub const STYLE: &str = include_str!("../../templates/style.css");
/// The script of all pages: sorts tables, shows values of plots, and enlarges maps.
pub const SCRIPT: &str = include_str!("../../templates/script.js");

/// Why the page could not be rendered.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// A plot failed.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// The template failed.
    #[error("the page cannot be rendered: {0}")]
    Template(#[from] minijinja::Error),
}

/// The colours of the conditions nominal, combined and fog.
const CONDITION_COLOURS: [Rgb; 3] = [BLUE, VIOLET, ORANGE];

/// Renders the whole page as HTML, with style, plots and pictures inside it.
///
/// # Errors
/// A plot or the template fails. Either is a defect of this program, not of the input.
pub fn html(study: &Study) -> Result<String, PageError> {
    let mut environment = environment();
    environment.add_template("report.html", TEMPLATE)?;
    let groups = bounds::groups(&study.bounds);
    let closest = groups.iter().max_by(|a, b| a.worst.check.used.total_cmp(&b.worst.check.used));
    let page = environment.get_template("report.html")?.render(context! {
        style => STYLE,
        script => SCRIPT,
        unchecked => study.unchecked(),
        judges => study.judges().len(),
        beyond_bound => study.beyond_bound(),
        conditions => value(CONDITIONS),
        interior => value(Bounds::acceptance().interior),
        study => value(study),
        closest => value(closest),
        failed => value(study.failures()),
        cheapest => sweep::cheapest(&study.alternatives).map(value),
        groups => value(&groups),
        matrix => value(bounds::matrix(study, &groups)),
        classes => value(Bounds::acceptance().class),
        tiles => value(tiles::tiles(study)),
        contrast => contrast::plots(study)?,
        approximation => value(levels::error_rows(study, Kind::Approximation)),
        quantisation => value(levels::error_rows(study, Kind::Quantisation)),
        histograms => histograms::plots(study)?,
        chains => chains::plot(&study.chains)?,
        formats => value(&study.format_groups),
        ranges => ranges::plot(study)?,
        colour_bar => figures::colour_bar()?,
        figures => value(maps::views(study)),
        flips => descriptor_bits::plots(study)?,
        displacement => displacement::plot(study)?,
        levels => value(levels::rows(study)),
        hardware => study.hardware().map(value),
        totals => study.hardware().and_then(Hardware::totals).map(value),
        device => study.hardware().and_then(|hardware| hardware.estimate.result()).map(device::plot).transpose()?,
        sweeps => word_lengths::sweep_plots(study)?,
        costs => word_lengths::cost_plots(study)?,
        repeatability => stability::plots(study)?,
        gap => stability::largest_gap(&study.repeatability),
    })?;
    Ok(page)
}

/// Creates an environment with the filters of the templates: `num` prints a number with fixed decimals, `sig` with
/// significant digits, `plain` with all digits, and `count` groups the digits of an integer.
pub fn environment() -> Environment<'static> {
    let mut environment = Environment::new();
    environment.add_filter("num", |value: f64, decimals: usize| typeset(format!("{value:.decimals$}")));
    environment.add_filter("sig", |value: f64, digits: usize| significant(value, digits));
    environment.add_filter("plain", |value: f64| typeset(value.to_string()));
    environment.add_filter("count", |value: u64| grouped(value));
    environment
}

/// Converts anything serialisable for a template.
pub fn value(view: impl Serialize) -> Value {
    Value::from(Serde(view))
}
