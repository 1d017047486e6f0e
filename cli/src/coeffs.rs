//! `hoverlock coeffs`: coefficients for a sigma, and their errors.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::model::coefficients::export;
use hoverlock_fixed_point::model::coefficients::set::{CoefficientSet, LookAhead, SmootherSpec};
use hoverlock_reference::smoothing::recursive::{Family, Fit, Recursive};
use hoverlock_reports::coefficient_plots::figures;
use serde::Serialize;

use crate::Verdict;
use crate::output::{Batch, Folder, lossy_list, print, print_json, quoted, say, shown};

/// Regenerate filter coefficients
///
/// Designs recursive smoothers that approximate a Gaussian, rounds them to integers, and reports
/// the error of either step.
///
/// a[i] is feedback and is added, b[i] is feed-forward. A cascade, all but Deriche, is
///   u[n] = b[0] x[n] + sum a[i] u[n-i]     then  y[n] = b[0] u[n] + sum a[i] y[n+i]
/// and Deriche's two sides, in parallel, are
///   u[n] = sum b[i] x[n-i] + sum a[i] u[n-i]
///   v[n] = sum b_ahead[i] x[n+i] + sum a[i] v[n+i]     y[n] = u[n] + v[n]
/// So a[1] of first-order is its pole b1/b0; a[1] to a[3] of yvv95 are b1/b0, b2/b0 and b3/b0
/// in its authors' letters. g and g_j are the unsigned coefficients of the lerp cells
/// y = p + c (q - p) that the first-order filter is built from.
///
/// Example: hoverlock coeffs --sigma 2 3.2 5.12 --out out/coefficients
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// Sigma of each smoother, pixels
    #[arg(
        long,
        required_unless_present = "design",
        num_args = 1..,
        value_name = "S",
        allow_negative_numbers = true,
        value_parser = sigma
    )]
    sigma: Vec<f64>,
    /// The smoothers of a design, with its coefficient bits and look-ahead: kt27, hd1080, small, three_scales, or a
    /// design file
    #[arg(
        long,
        value_name = "NAME|FILE",
        conflicts_with_all = ["sigma", "frac_bits", "look_ahead", "look_ahead_error"]
    )]
    design: Option<OsString>,
    /// Approximation of the Gaussian
    #[arg(long, value_enum, default_value = "first-order")]
    method: Method,
    /// Poles of each side: alvarez-mazorra 1-4 (passes), deriche 2-4, vyv 3-5 [default: 1, 4 and 3]
    #[arg(long, value_name = "N")]
    order: Option<usize>,
    /// Choice of the free parameter [default: least-squares for first-order, published for deriche and yvv95, else
    /// variance]
    #[arg(long, value_enum)]
    fit: Option<FitChoice>,
    /// Fraction bits of the integer coefficients, 1 to 31
    #[arg(long, default_value_t = 16, value_name = "F", allow_negative_numbers = true)]
    frac_bits: u32,
    /// Look-ahead stages of the lerp form; m stages reach 2^m - 1 samples [default: as many as --look-ahead-error asks
    /// for]
    #[arg(long, value_name = "M", conflicts_with = "look_ahead_error")]
    look_ahead: Option<u32>,
    /// Part of the filter's sum that the look-ahead may leave out
    #[arg(long, default_value_t = 1e-4, value_name = "E")]
    look_ahead_error: f64,
    /// Write coefficients.json, .vh, .mif, .h, .rs, .md and the plots into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// One JSON object on stdout: sets[] of method order sigma a[] b[] sigma_eff linf l2 dc_gain (against the sampled
    /// Gaussian, relative) and quantised (against the unquantised filter, with lerp g and g_j); files[]
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Method {
    /// Two-sided first order: what the hardware is built from
    FirstOrder,
    /// First order repeated
    AlvarezMazorra,
    /// Deriche 1993
    Deriche,
    /// Young and van Vliet 1995
    Yvv95,
    /// Van Vliet, Young and Verbeek 1998
    Vyv,
}

#[derive(Clone, Copy, ValueEnum)]
enum FitChoice {
    /// The formula its authors print
    Published,
    /// The variance of the impulse response is sigma squared
    Variance,
    /// Least squares against the unit-sum sampled Gaussian
    LeastSquares,
}

impl FitChoice {
    fn fit(self) -> Fit {
        match self {
            Self::Published => Fit::Published,
            Self::Variance => Fit::Variance,
            Self::LeastSquares => Fit::LeastSquares,
        }
    }
}

impl Method {
    fn family(self, order: Option<usize>) -> Result<Family> {
        let fixed = |family: Family| match order {
            Some(order) if order != family.order() => {
                bail!("{} has no order {order}: it is always {}", family.name(), family.order())
            }
            _ => Ok(family),
        };
        match self {
            Self::FirstOrder => fixed(Family::FirstOrder),
            Self::Yvv95 => fixed(Family::YoungVanVliet),
            Self::AlvarezMazorra => Ok(Family::AlvarezMazorra { passes: order.unwrap_or(1) }),
            Self::Deriche => Ok(Family::Deriche { order: order.unwrap_or(4) }),
            Self::Vyv => Ok(Family::VanVlietYoungVerbeek { order: order.unwrap_or(3) }),
        }
    }
}

#[derive(Serialize)]
struct Report {
    sets: Vec<CoefficientSet>,
    /// The files that were written.
    #[serde(serialize_with = "lossy_list")]
    files: Vec<PathBuf>,
}

/// Parses a number of pixels. The message about an impossible one quotes it as typed, because 1e308 has 309 digits.
fn sigma(text: &str) -> Result<f64, String> {
    let sigma: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if sigma.abs() > 1e9 && sigma.is_finite() {
        return Err(format!("sigma {text} px is outside 0.5 to 256 px"));
    }
    Ok(sigma)
}

pub fn run(args: &Args) -> Result<Verdict> {
    let family = args.method.family(args.order)?;
    let fit = args.fit.map_or(family.fits()[0], FitChoice::fit);
    if args.look_ahead.is_some() && args.method != Method::FirstOrder {
        bail!("--look-ahead is about the lerp form, which only --method first-order has; leave it out");
    }
    let look_ahead = args.look_ahead.map_or(LookAhead::Error(args.look_ahead_error), LookAhead::Stages);
    let spec =
        |sigma: f64, frac_bits: u32, look_ahead: LookAhead| SmootherSpec { family, fit, sigma, frac_bits, look_ahead };
    let specs: Vec<SmootherSpec> =
        match args.design.as_deref().map(DesignPoint::load).transpose().context("--design")? {
            None => args.sigma.iter().map(|sigma| spec(*sigma, args.frac_bits, look_ahead)).collect(),
            Some(design) => {
                let smoothers = design.sigmas.iter().zip(&*design.look_ahead);
                smoothers.map(|(sigma, m)| spec(*sigma, design.coefficient.bits(), LookAhead::Stages(*m))).collect()
            }
        };
    let sets = specs.iter().map(CoefficientSet::design).collect::<Result<Vec<_>, _>>()?;
    let mut report = Report { sets, files: Vec::new() };
    if let Some(folder) = &args.out {
        let command = command(&report.sets, args.design.as_deref(), look_ahead);
        report.files = write(folder, &report.sets, family, fit, &command)?;
    }
    if args.json {
        print_json(&report)?;
    } else {
        print(&table(&report))?;
    }
    Ok(Verdict::Pass)
}

/// Writes every form of the sets. All texts are made before the first file is written.
fn write(folder: &Path, sets: &[CoefficientSet], family: Family, fit: Fit, command: &str) -> Result<Vec<PathBuf>> {
    let mut json = serde_json::to_string_pretty(&serde_json::json!({ "command": command, "sets": sets }))
        .context("the coefficients cannot be written as JSON")?;
    json.push('\n');
    let mut texts = vec![("coefficients.json".to_owned(), json)];
    texts.extend(export::all(sets, command).into_iter().map(|file| (file.name.to_owned(), file.text)));
    let filters = sets.iter().map(|set| Recursive::design(family, fit, set.sigma)).collect::<Result<Vec<_>, _>>()?;
    for figure in figures(&filters)? {
        texts.push((format!("{}.svg", figure.name), figure.file()?));
    }
    let names: Vec<&str> = texts.iter().map(|(name, _)| name.as_str()).collect();
    let made = Folder::of(folder, "coeffs", &names)?;
    let mut batch = Batch::default();
    let mut paths = Vec::new();
    for (name, text) in &texts {
        let path = folder.join(name);
        batch.add(&path, text.as_bytes())?;
        paths.push(path);
    }
    batch.keep()?;
    drop(made);
    let earlier = earlier(folder, &texts)?;
    if let Some(first) = earlier.first() {
        say(&format!(
            "{}: {} files belong to an earlier, larger set, the first is {first}; remove them",
            folder.display(),
            earlier.len()
        ));
    }
    Ok(paths)
}

/// Returns plots of smoothers that an earlier run had and this one has not.
fn earlier(folder: &Path, texts: &[(String, String)]) -> Result<Vec<String>> {
    let unreadable = || format!("{}: cannot be read", folder.display());
    let ours = |name: &str| name.ends_with(".svg") && (name.starts_with("smoother") || name.starts_with("dog"));
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(unreadable)? {
        let name = entry.with_context(unreadable)?.file_name().to_string_lossy().into_owned();
        if ours(&name) && texts.iter().all(|(written, _)| *written != name) {
            names.push(name);
        }
    }
    names.sort();
    Ok(names)
}

/// Returns a command that reproduces these sets even if defaults change. A design has a look-ahead for each smoother.
fn command(sets: &[CoefficientSet], design: Option<&OsStr>, look_ahead: LookAhead) -> String {
    let Some(set) = sets.first() else { return String::new() };
    let of_filter = format!("--method {} --order {} --fit {}", set.method, set.order, set.fit);
    if let Some(design) = design {
        return format!("hoverlock coeffs --design {} {of_filter}", quoted(Path::new(design)));
    }
    let sigmas: String = sets.iter().map(|set| format!(" {}", set.sigma)).collect();
    let choice = match (&set.quantised.lerp, look_ahead) {
        (None, _) => String::new(),
        (Some(_), LookAhead::Stages(stages)) => format!(" --look-ahead {stages}"),
        (Some(_), LookAhead::Error(error)) => format!(" --look-ahead-error {error}"),
    };
    format!("hoverlock coeffs --sigma{sigmas} {of_filter} --frac-bits {}{choice}", set.quantised.frac_bits)
}

fn table(report: &Report) -> String {
    let mut text = String::new();
    for set in &report.sets {
        let list = |values: &[f64]| values.iter().map(|v| format!("{v:.8}")).collect::<Vec<_>>().join("  ");
        let integers = |values: &[i64]| values.iter().map(i64::to_string).collect::<Vec<_>>().join("  ");
        let q = &set.quantised;
        text += &format!(
            "sigma {} px: {}, order {}, {}, {} fit, {} = {:.6}\n",
            set.sigma, set.method, set.order, set.structure, set.fit, set.parameter.name, set.parameter.value
        );
        text += &format!("  a                 {}\n  b                 {}\n", list(&set.a), list(&set.b));
        if !set.b_ahead.is_empty() {
            text += &format!("  b_ahead           {}\n", list(&set.b_ahead));
        }
        text += &format!(
            "  against Gaussian  sigma_eff {:.4} px, l2 {:.3} %, linf {:.3} % of the peak, DC gain {:.12}\n",
            set.sigma_eff,
            100.0 * set.l2,
            100.0 * set.linf,
            set.dc_gain
        );
        text += &format!("  integers / 2^{:<4} a: {}   b: {}", q.frac_bits, integers(&q.a), integers(&q.b));
        if !q.b_ahead.is_empty() {
            text += &format!("   b_ahead: {}", integers(&q.b_ahead));
        }
        text += &format!(
            "\n    quantisation    sigma_eff {:.5} px, l2 {:.5} %, linf {:.5} %, DC gain exactly {}\n",
            q.sigma_eff,
            100.0 * q.l2,
            100.0 * q.linf,
            q.dc_gain
        );
        if let Some(lerp) = &q.lerp {
            let stages = lerp.g_j.iter().map(u32::to_string).collect::<Vec<_>>().join("  ");
            text += &format!("  lerp u0.{:<9} g {}   g_j {stages}\n", q.frac_bits, lerp.g);
            text += &format!(
                "    look-ahead      {} stages leave out {:.1e} of the sum\n",
                lerp.look_ahead, lerp.look_ahead_error
            );
            for (name, way) in [("columns", lerp.columns), ("rows", lerp.rows)] {
                text += &format!(
                    "    {name:<15} sigma_eff {:.5} px, l2 {:.5} %, linf {:.5} %, shift {:+.5} px, DC gain exactly 1\n",
                    way.sigma_eff,
                    100.0 * way.l2,
                    100.0 * way.linf,
                    // A symmetric filter is shifted by rounding of f64 only; this avoids a minus sign before the zero.
                    if way.shift.abs() < 1e-9 { 0.0 } else { way.shift }
                );
            }
            if let Some(first) = lerp.saturated.first() {
                text += &format!(
                    "    note            g_j rounds to 1 from stage {first} on: look-ahead {first} is as good\n"
                );
            }
        }
    }
    for path in &report.files {
        text += &format!("wrote {}\n", shown(path));
    }
    text
}
