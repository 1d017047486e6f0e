//! A study becomes one HTML page.
//!
//! The template in `templates/report.html` holds all words and their order; here are only the tables and plots that it asks for.
//! Tables show of every measure the worst of all pictures and conditions, and where it was found.

use std::collections::BTreeMap;

use hoverlock_fixed_point::analysis::bounds::{Bounds, Class, ClassLimits, Sense};
use hoverlock_fixed_point::analysis::errors::{BitKind, Flips};
use hoverlock_fixed_point::analysis::levels::Level;
use hoverlock_reference::features::repeatability::{Curve, Stability, Warp};
use hoverlock_reference::image::conditions::CONDITIONS;
use minijinja::value::{Serde, Value};
use minijinja::{Environment, context};
use serde::Serialize;

use crate::colour::Rgb;
use crate::figures;
use crate::hardware::{DeviceShare, Hardware, Made, Sizing};
use crate::plot::{Axis, BLUE, Chart, GREEN, GREY, Mark, ORANGE, PlotError, RED, Rule, Series, VIOLET};
use crate::study::{BoundRow, ConditionStudy, Kind, Measurement, PictureStudy, Stage, Study};
use crate::sweep::{Cost, SweepPoint};

const TEMPLATE: &str = include_str!("../templates/report.html");
const STYLE: &str = include_str!("../templates/style.css");

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// A plot.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// The template.
    #[error("the page cannot be made: {0}")]
    Template(#[from] minijinja::Error),
}

/// The colours of the three conditions.
const CONDITION_COLOURS: [Rgb; 3] = [BLUE, VIOLET, ORANGE];

/// One bound over all pictures and conditions.
#[derive(Debug, Serialize)]
struct BoundGroup<'a> {
    name: &'static str,
    unit: &'static str,
    sign: &'static str,
    /// The limits, one where it is the same for all.
    limits: Vec<f64>,
    checked: usize,
    passed: usize,
    worst: &'a BoundRow,
}

/// Pictures and conditions down, bounds across.
#[derive(Debug, Serialize)]
struct MatrixRow<'a> {
    picture: &'a str,
    condition: &'a str,
    /// Dog rms of both scales, LSB.
    rms: [f64; 2],
    cells: Vec<Option<&'a BoundRow>>,
}

/// One stage of one level, worst of all.
#[derive(Debug, Serialize)]
struct ErrorRow<'a> {
    level: Level,
    first_of_level: bool,
    stage: String,
    lsb_dn: f64,
    max: &'a Measurement,
    bias: f64,
    rms: f64,
    sqnr_db: f64,
}

/// The page.
///
/// # Errors
/// Where a plot or the template fails, which would be a fault of this program.
pub fn html(study: &Study) -> Result<String, PageError> {
    let mut environment = Environment::new();
    environment.add_filter("num", |value: f64, decimals: usize| typeset(format!("{value:.decimals$}")));
    environment.add_filter("sig", |value: f64, digits: usize| significant(value, digits));
    environment.add_filter("plain", |value: f64| typeset(value.to_string()));
    environment.add_filter("count", |value: u64| grouped(value));
    environment.add_template("report.html", TEMPLATE)?;
    let groups = bound_groups(&study.bounds);
    let closest = groups.iter().max_by(|a, b| a.worst.check.used.total_cmp(&b.worst.check.used));
    let page = environment.get_template("report.html")?.render(context! {
        style => STYLE,
        study => value(study),
        closest => value(closest),
        failed => value(study.bounds.iter().filter(|row| !row.check.pass).collect::<Vec<_>>()),
        groups => value(&groups),
        matrix => value(matrix(study, &groups)),
        classes => value(Bounds::acceptance().class),
        tiles => value(tiles(study)),
        scatter => scatter(study)?,
        approximation => value(error_rows(study, Kind::Approximation)),
        quantisation => value(error_rows(study, Kind::Quantisation)),
        histograms => ulp_histograms(study)?,
        chains => chains(study)?,
        formats => value(&study.format_groups),
        ranges => ranges(study)?,
        colour_bar => figures::colour_bar()?,
        figures => value(figure_views(study)),
        flips => flip_plots(study)?,
        displacement => displacement_plot(study)?,
        levels => value(levels(study)),
        hardware => study.hardware().map(value),
        totals => study.hardware().and_then(Hardware::totals).map(value),
        taken => study.hardware().and_then(|hardware| hardware.estimate.result()).map(taken).transpose()?,
        sweeps => sweep_plots(study)?,
        costs => cost_plots(study)?,
        repeatability => repeatability_plots(study)?,
        gap => repeatability_gap(&study.repeatability),
    })?;
    Ok(page)
}

fn value(view: impl Serialize) -> Value {
    Value::from(Serde(view))
}

/// Minus signs and infinities as print has them.
fn typeset(text: String) -> String {
    match text.as_str() {
        "inf" => "∞".into(),
        "-inf" => "−∞".into(),
        "NaN" => "—".into(),
        _ => {
            let zero = text.starts_with('-') && !text.contains(|c: char| ('1'..='9').contains(&c));
            if zero { text.replace('-', "") } else { text.replace('-', "−") }
        }
    }
}

/// So many significant digits, without an exponent.
fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return typeset(format!("{value}"));
    }
    let lead = value.abs().log10().floor() as i32;
    let decimals = (digits as i32 - 1 - lead).max(0) as usize;
    typeset(format!("{value:.decimals$}"))
}

/// Thousands apart.
fn grouped(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

fn bound_groups(rows: &[BoundRow]) -> Vec<BoundGroup<'_>> {
    let mut groups: Vec<BoundGroup<'_>> = Vec::new();
    for row in rows {
        let check = &row.check;
        match groups.iter_mut().find(|group| group.name == check.name) {
            Some(group) => {
                group.checked += 1;
                group.passed += usize::from(check.pass);
                let rank = |row: &BoundRow| (!row.check.pass, row.check.used);
                if rank(row) > rank(group.worst) {
                    group.worst = row;
                }
            }
            None => groups.push(BoundGroup {
                name: check.name,
                unit: check.unit,
                sign: if check.sense == Sense::AtMost { "≤" } else { "≥" },
                limits: limits(check.name).unwrap_or_else(|| vec![check.limit]),
                checked: 1,
                passed: usize::from(check.pass),
                worst: row,
            }),
        }
    }
    groups
}

/// The limits of the three columns, for a bound that has them.
fn limits(name: &str) -> Option<Vec<f64>> {
    let bounds = Bounds::acceptance();
    let columns = [Class::Nominal, Class::Combined, Class::Fog].map(|class| bounds.column(class));
    let of = |limit: fn(&hoverlock_fixed_point::analysis::bounds::Column) -> f64| Some(columns.map(limit).to_vec());
    match name {
        "DoG SQNR" => of(|column| column.sqnr_db),
        "MaxLBP bits flipped" => of(|column| column.maxlbp_flips_percent),
        "sign bits flipped" => of(|column| column.sign_flips_percent),
        "features at the same pixel" => of(|column| column.same_pixel_percent),
        "features within 1 px" => of(|column| column.within_one_px_percent),
        _ => None,
    }
}

fn matrix<'a>(study: &'a Study, groups: &[BoundGroup<'_>]) -> Vec<MatrixRow<'a>> {
    let rows = study.pictures.iter().flat_map(|picture| picture.conditions.iter().map(move |of| (picture, of)));
    rows.map(|(picture, of)| {
        let mine = |row: &&BoundRow| {
            row.picture.as_deref() == Some(picture.name.as_str()) && row.condition == Some(of.condition.name)
        };
        let cell = |group: &BoundGroup<'_>| study.bounds.iter().filter(mine).find(|row| row.check.name == group.name);
        MatrixRow {
            picture: &picture.name,
            condition: of.condition.name,
            rms: of.comparison.scales.each_ref().map(|scale| scale.interior.reference_rms),
            cells: groups.iter().filter(|group| group.worst.condition.is_some()).map(cell).collect(),
        }
    })
    .collect()
}

/// The numbers at the top.
#[derive(Debug, Serialize)]
struct Tile {
    value: String,
    unit: &'static str,
    what: &'static str,
}

fn tiles(study: &Study) -> Vec<Tile> {
    let rms = |level: Level| {
        let of_level = study.levels.iter().filter(|study| study.name == level).flat_map(|study| &study.measurements);
        let dog = of_level.filter(|m| matches!(m.stage, Stage::Dog(_)));
        dog.map(|m| m.error.rms).fold(f64::NAN, f64::max)
    };
    let worst = |name: &str| {
        let rows = study.bounds.iter().filter(|row| row.check.name == name);
        rows.map(|row| row.check.measured).fold(f64::NAN, f64::max)
    };
    let flips = CONDITIONS.map(|c| study.flips_percent(c.name, BitKind::Maxlbp)).into_iter().fold(f64::NAN, f64::max);
    let hardware = match study.hardware().and_then(Hardware::totals) {
        Some(totals) => Tile {
            value: grouped(totals.mismatches),
            unit: "mismatches",
            what: "between the simulated hardware, rtl, and bit_true",
        },
        None => Tile {
            value: "not run".into(),
            unit: "",
            what: "the level rtl was not simulated; section 9 gives the reason",
        },
    };
    vec![
        Tile {
            value: significant(rms(Level::BitTrue), 2),
            unit: "LSB rms",
            what: "quantisation of the DoG, bit_true against streaming",
        },
        Tile {
            value: significant(rms(Level::Streaming), 2),
            unit: "LSB rms",
            what: "approximation of the DoG, streaming against the true Gaussian",
        },
        Tile { value: significant(flips, 2), unit: "%", what: "MaxLBP bits flipped in the worst condition" },
        Tile {
            value: significant(worst("displacement, largest difference"), 2),
            unit: "px",
            what: "largest change of a displacement by quantisation",
        },
        hardware,
    ]
}

/// One level in one line.
#[derive(Debug, Serialize)]
struct LevelRow {
    name: Level,
    changes: &'static str,
    against: &'static str,
    cost: String,
}

/// Every level, what differs in it and what that costs.
fn levels(study: &Study) -> Vec<LevelRow> {
    let mut rows = Vec::new();
    for level in &study.levels {
        let dogs = || level.measurements.iter().filter(|m| matches!(m.stage, Stage::Dog(_)));
        let rms = dogs().map(|m| m.error.rms).fold(0.0, f64::max);
        let kind = dogs().next().map(|m| m.kind);
        let cost = match &level.hardware {
            None if kind.is_none() => String::new(),
            None => format!("DoG {} LSB rms", significant(rms, 3)),
            Some(hardware) => match (&hardware.simulation, hardware.totals()) {
                (Made::Run { .. }, Some(totals)) => format!(
                    "{} mismatches in {} samples and {} features",
                    grouped(totals.mismatches),
                    grouped(totals.samples),
                    grouped(totals.features)
                ),
                (Made::NotRun { reason }, _) => format!("not run: {reason}"),
                _ => String::new(),
            },
        };
        let against = match (level.name, kind) {
            (Level::Rtl, _) => "bit_true",
            (_, Some(Kind::Approximation)) => "ideal",
            (_, Some(Kind::Quantisation)) => "streaming",
            (_, None) => "",
        };
        rows.push(LevelRow { name: level.name, changes: level.changes, against, cost });
    }
    rows
}

/// Bars of what is used of the first device, in front of what may be used and of what it has.
fn taken(sizing: &Sizing) -> Result<String, PlotError> {
    let Some(DeviceShare { name, has, limits, used_percent, .. }) = sizing.devices.first() else {
        return Ok(String::new());
    };
    let used = [sizing.alm, sizing.m10k, sizing.dsp];
    let names = ["ALM", "M10K blocks", "DSP blocks"];
    let ticks = (0..3).map(|i| {
        (i as f64, format!("{}: {} of {}, limit {}", names[i], grouped(used[i]), grouped(has[i]), grouped(limits[i])))
    });
    let bars = |name: &str, colour: Rgb, width: f64, height: &dyn Fn(usize) -> f64| Series {
        name: name.into(),
        colour,
        mark: Mark::Bars(width),
        points: (0..3).map(|i| (i as f64, height(i))).collect(),
    };
    Chart {
        title: format!("{name}, Yosys estimate"),
        size: (1040, 280),
        x: Axis::ticked("", -0.5, 2.5, ticks.collect()),
        y: Axis::linear("% of the device", 0.0, 100.0),
        series: vec![
            bars("device", [228, 232, 236], 0.5, &|_| 100.0),
            bars("limit", [176, 190, 204], 0.5, &|i| 100.0 * limits[i] as f64 / has[i] as f64),
            bars("used", BLUE, 0.3, &|i| used_percent[i]),
        ],
        rules: Vec::new(),
    }
    .svg()
}

fn error_rows(study: &Study, kind: Kind) -> Vec<ErrorRow<'_>> {
    let mut rows = Vec::new();
    for level in &study.levels {
        let mut first_of_level = true;
        for stage in Stage::ALL {
            let of_stage: Vec<&Measurement> =
                level.measurements.iter().filter(|m| m.stage == stage && m.kind == kind).collect();
            let worst =
                |size: fn(&Measurement) -> f64| of_stage.iter().copied().max_by(|a, b| size(a).total_cmp(&size(b)));
            let (Some(max), Some(bias), Some(rms), Some(noisy)) = (
                worst(|m| m.error.max.abs()),
                worst(|m| m.error.bias.abs()),
                worst(|m| m.error.rms),
                worst(|m| -m.error.sqnr_db),
            ) else {
                continue;
            };
            rows.push(ErrorRow {
                level: level.name,
                first_of_level,
                stage: stage.name(&study.design),
                lsb_dn: stage.lsb(),
                max,
                bias: bias.error.bias,
                rms: rms.error.rms,
                sqnr_db: noisy.error.sqnr_db,
            });
            first_of_level = false;
        }
    }
    rows
}

/// Errors of both DoG of each level, all pictures and conditions together, as shares of the samples.
fn ulp_histograms(study: &Study) -> Result<Vec<String>, PlotError> {
    let mut plots = Vec::new();
    for level in &study.levels {
        let dogs: Vec<&Measurement> = level.measurements.iter().filter(|m| matches!(m.stage, Stage::Dog(_))).collect();
        let Some(width) = dogs.iter().map(|m| m.error.histogram.bin_lsb).reduce(f64::max) else { continue };
        let mut bins: BTreeMap<i64, u64> = BTreeMap::new();
        for m in &dogs {
            for (centre, count) in m.error.histogram.centres().zip(&m.error.histogram.counts) {
                *bins.entry((centre / width).round() as i64).or_default() += count;
            }
        }
        let total: u64 = bins.values().sum();
        let share = |count: u64| 100.0 * count as f64 / total.max(1) as f64;
        let reach = bins.iter().filter(|(_, count)| **count > 0).map(|(bin, _)| bin.abs()).max().unwrap_or(1).max(3);
        let points = bins.iter().filter(|(_, count)| **count > 0);
        let points = points.map(|(bin, count)| (*bin as f64 * width, share(*count))).collect();
        let kind = dogs.first().map(|m| m.kind);
        let (against, colour) = match kind {
            Some(Kind::Approximation) => ("ideal", ORANGE),
            _ => ("streaming", BLUE),
        };
        let edge = (reach as f64 + 0.6) * width;
        let chart = Chart {
            title: format!("{} against {against}: one bar = {} LSB", level.name, grouped(width as u64)),
            size: (460, 250),
            x: Axis::linear("DoG error, LSB", -edge, edge),
            y: Axis::log("samples, %", 1e-6, 100.0),
            series: vec![Series { name: String::new(), colour, mark: Mark::Bars(0.86 * width), points }],
            rules: Vec::new(),
        };
        plots.push(chart.svg()?);
    }
    Ok(plots)
}

fn chains(study: &Study) -> Result<String, PlotError> {
    let colours = [BLUE, VIOLET, ORANGE];
    let longest = study.chains.iter().max_by_key(|chain| chain.cells.len());
    let cells = longest.map_or(1, |chain| chain.cells.len());
    let short = |name: &str| {
        name.replace("columns, ", "c ")
            .replace("rows, ", "r ")
            .replace("recursion", "rec")
            .replace("ahead ", "+")
            .replace("back ", "−")
    };
    let ticks = longest.map_or(Vec::new(), |chain| {
        let names = chain.cells.iter().enumerate();
        names.map(|(place, (name, _))| (place as f64 + 1.0, short(name))).collect()
    });
    let top = study.chains.iter().flat_map(|chain| chain.cells.iter().map(|cell| cell.1)).fold(0.5, f64::max);
    let series = study.chains.iter().zip(colours).map(|(chain, colour)| Series {
        name: format!("σ {}", chain.sigma),
        colour,
        mark: Mark::LineDots,
        points: chain.cells.iter().enumerate().map(|(place, cell)| (place as f64 + 1.0, cell.1)).collect(),
    });
    Chart {
        title: String::new(),
        size: (1040, 270),
        x: Axis::ticked(
            "cell, in the order of the data: down the columns (c), then along the rows (r); ±n: reach in samples",
            0.5,
            cells as f64 + 0.5,
            ticks,
        ),
        y: Axis::linear("rms error, state LSB", 0.0, 1.1 * top),
        series: series.collect(),
        rules: Vec::new(),
    }
    .svg()
}

/// One band a word: the share of its samples in each power of two, by height, in the colour of how they fit.
fn ranges(study: &Study) -> Result<String, PlotError> {
    let rows = &study.format_groups;
    let exponents = || rows.iter().flat_map(|row| row.histogram.iter().map(|bin| bin.0));
    let (least, most) = (exponents().min().unwrap_or(-2).max(-12), exponents().max().unwrap_or(16));
    let fits = [("in range", BLUE), ("overflow", RED), ("underflow", ORANGE)];
    let band = |place: usize| (rows.len() - 1 - place) as f64;
    let series = fits.map(|(name, colour)| {
        let points = rows.iter().enumerate().flat_map(|(place, row)| {
            let top = row.histogram.iter().map(|bin| bin.1).max().unwrap_or(1) as f64;
            let bins = row.histogram.iter().filter(move |bin| bin.2 == name);
            // The root keeps small shares visible.
            bins.map(move |bin| (f64::from(bin.0.max(least)), band(place), 0.82 * (bin.1 as f64 / top).sqrt()))
        });
        (Series { name: name.into(), colour, mark: Mark::Dots(0), points: Vec::new() }, points.collect::<Vec<_>>())
    });
    let y_ticks =
        rows.iter().enumerate().map(|(place, row)| (band(place) + 0.3, format!("{}  {}", row.node, row.format)));
    let x_ticks = (least..=most).filter(|e| e % 2 == 0).map(|e| (f64::from(e), superscript(e))).collect();
    let mut bars: Vec<Series> = Vec::new();
    for (named, points) in series {
        bars.push(named.clone());
        let columns = points.into_iter().map(|(x, from, height)| Series {
            name: String::new(),
            colour: named.colour,
            mark: Mark::Columns { from, width: 0.9 },
            points: vec![(x + 0.5, from + height)],
        });
        bars.extend(columns);
    }
    Chart {
        title: String::new(),
        size: (1040, 70 + 34 * rows.len() as u32),
        x: Axis::ticked("magnitude, DN of the camera sample", f64::from(least), f64::from(most) + 1.0, x_ticks),
        y: Axis::ticked("", -0.1, rows.len() as f64, y_ticks.collect()),
        series: bars,
        rules: Vec::new(),
    }
    .svg()
}

/// 2 to that power.
fn superscript(exponent: i32) -> String {
    let text = exponent.to_string();
    let digits = text.chars().map(|c| match c {
        '-' => '⁻',
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        _ => '⁹',
    });
    std::iter::once('2').chain(digits).collect()
}

/// What the page shows of one picture.
#[derive(Debug, Serialize)]
struct FigureView<'a> {
    name: &'a str,
    maps: Vec<(usize, bool, &'a str)>,
    condition: &'static str,
    features: &'a str,
    counts: [[usize; 4]; 2],
}

fn figure_views(study: &Study) -> Vec<FigureView<'_>> {
    study.pictures.iter().map(FigureView::of).collect()
}

impl<'a> FigureView<'a> {
    fn of(picture: &'a PictureStudy) -> Self {
        let figures = &picture.figures;
        Self {
            name: &picture.name,
            maps: figures.maps.iter().map(|map| (map.scale, map.approximation, map.address.as_str())).collect(),
            condition: figures.features.condition,
            features: &figures.features.svg,
            counts: figures.features.counts,
        }
    }
}

fn flip_plots(study: &Study) -> Result<Vec<String>, PlotError> {
    let mut all = Flips::default();
    study.flips.iter().for_each(|(_, flips)| all.add(flips));
    let percent = |flipped: u64, of: u64| 100.0 * flipped as f64 / of.max(1) as f64;
    let words = [("MaxLBP k0", BLUE), ("MaxLBP k1", VIOLET), ("sign k0", ORANGE), ("sign k1", GREEN)];
    let series = words.iter().enumerate().map(|(word, (name, colour))| Series {
        name: (*name).into(),
        colour: *colour,
        mark: Mark::Bars(0.8),
        points: (32 * word..32 * (word + 1)).map(|bit| (bit as f64, percent(all.per_bit[bit], all.features))).collect(),
    });
    let top = all.per_bit.iter().map(|&flipped| percent(flipped, all.features)).fold(0.01, f64::max);
    let ticks = (0..=128).step_by(16).map(|bit| (f64::from(bit) - 0.5, bit.to_string())).collect();
    let per_bit = Chart {
        title: String::new(),
        size: (1040, 250),
        x: Axis::ticked("descriptor bit", -1.0, 128.0, ticks),
        y: Axis::linear("flipped, %", 0.0, 1.25 * top),
        series: series.collect(),
        rules: Vec::new(),
    };
    let edges: Vec<(f64, String)> = (0..Flips::MARGIN_BINS)
        .map(|bin| (bin as f64, if bin == 0 { "<½".into() } else { format_octave(bin) }))
        .collect();
    let kinds = [("MaxLBP", BLUE, &all.maxlbp_margin), ("sign", ORANGE, &all.sign_margin)];
    let rate = kinds.map(|(name, colour, bins)| Series {
        name: name.into(),
        colour,
        mark: Mark::LineDots,
        points: bins
            .iter()
            .enumerate()
            .filter(|(_, bin)| bin.flipped > 0)
            .map(|(place, bin)| (place as f64, percent(bin.flipped, bin.bits)))
            .collect(),
    });
    let x = || Axis::ticked("margin at streaming, LSB", -0.5, Flips::MARGIN_BINS as f64 - 0.5, edges.clone());
    let against_margin = Chart {
        title: "chance to flip, by margin".into(),
        size: (520, 280),
        x: x(),
        y: Axis::log("flipped, %", 1e-3, 100.0),
        series: rate.into(),
        rules: Vec::new(),
    };
    let total =
        |bins: &[hoverlock_fixed_point::analysis::errors::MarginBin]| bins.iter().map(|bin| bin.bits).sum::<u64>();
    let share = kinds.map(|(name, colour, bins)| Series {
        name: name.into(),
        colour,
        mark: Mark::LineDots,
        points: bins.iter().enumerate().map(|(place, bin)| (place as f64, percent(bin.bits, total(bins)))).collect(),
    });
    let population = Chart {
        title: "how many bits have that margin".into(),
        size: (520, 280),
        x: x(),
        y: Axis::log("bits, %", 1e-3, 100.0),
        series: share.into(),
        rules: Vec::new(),
    };
    [per_bit, against_margin, population].iter().map(Chart::svg).collect()
}

/// The lower edge of a bin of margins.
fn format_octave(bin: usize) -> String {
    match bin {
        1 => "½".into(),
        _ => {
            let edge = 1u64 << (bin - 2);
            if edge >= 1024 { format!("{}k", edge / 1024) } else { edge.to_string() }
        }
    }
}

fn displacement_plot(study: &Study) -> Result<String, PlotError> {
    let limits = Bounds::acceptance().displacement;
    let mut series = [("streaming and bit_true apart", BLUE), ("error, streaming", GREY), ("error, bit_true", ORANGE)]
        .map(|(name, colour)| Series { name: name.into(), colour, mark: Mark::Dots(4), points: Vec::new() });
    let mut ticks = Vec::new();
    for (place, picture) in study.pictures.iter().enumerate() {
        ticks.push((place as f64, clipped(&picture.name, 26)));
        for (motion, displacement) in picture.displacements.iter().enumerate() {
            let x = place as f64 + (motion as f64 - 2.0) * 0.09;
            series[0].points.push((x, displacement.difference_px));
            series[1].points.extend(displacement.reference.iter().map(|found| (x - 0.02, found.error_px)));
            series[2].points.extend(displacement.test.iter().map(|found| (x + 0.02, found.error_px)));
        }
    }
    Chart {
        title: String::new(),
        size: (1040, 270),
        x: Axis::ticked("", -0.5, study.pictures.len() as f64 - 0.5, ticks),
        y: Axis::log("px", 1e-4, 1.0),
        series: series.into(),
        rules: vec![
            Rule::Limit(limits.max_px, format!("largest ≤ {} px", limits.max_px)),
            Rule::Limit(limits.median_px, format!("median ≤ {} px", limits.median_px)),
        ],
    }
    .svg()
}

fn clipped(text: &str, length: usize) -> String {
    if text.chars().count() <= length { text.into() } else { text.chars().take(length - 1).chain(['…']).collect() }
}

/// Rows: the parameter; columns: DoG error, bit flips, features moved.
fn sweep_plots(study: &Study) -> Result<Vec<String>, PlotError> {
    type Measure = (&'static str, fn(&SweepPoint) -> f64, f64, f64);
    let measures: [Measure; 3] = [
        ("DoG error, LSB rms", |point| point.dog_rms_lsb, 0.1, 100.0),
        ("MaxLBP bits flipped, %", |point| point.maxlbp_flips_percent, 1e-3, 10.0),
        ("features not at the same pixel, %", |point| point.moved_percent, 0.1, 100.0),
    ];
    let mut plots = Vec::new();
    for sweep in &study.sweeps {
        let (least, most) = (
            sweep.points.iter().map(|point| point.bits).fold(f64::INFINITY, f64::min),
            sweep.points.iter().map(|point| point.bits).fold(0.0, f64::max),
        );
        let mut ticks: Vec<(f64, String)> =
            sweep.points.iter().map(|point| (point.bits, point.bits.to_string())).collect();
        ticks.dedup();
        for (row, (label, measure, low, high)) in measures.iter().enumerate() {
            let series = CONDITIONS.iter().zip(CONDITION_COLOURS).map(|(condition, colour)| Series {
                name: condition.name.into(),
                colour,
                mark: Mark::LineDots,
                points: sweep
                    .points
                    .iter()
                    .filter(|point| point.condition == condition.name)
                    .map(|point| (point.bits, measure(point)))
                    .collect(),
            });
            let mut rules = vec![Rule::Choice(sweep.chosen, format!("chosen: {}", sweep.chosen))];
            if row == 0 {
                let limit = Bounds::acceptance().dog.rms_lsb;
                rules.push(Rule::Limit(limit, format!("≤ {limit}")));
            }
            let chart = Chart {
                title: format!("{}: {label}", sweep.parameter),
                size: (380, 260),
                x: Axis::ticked("bits", least - 0.4, most + 0.4, ticks.clone()),
                y: Axis::log("", *low, *high),
                series: series.collect(),
                rules,
            };
            plots.push(chart.svg()?);
        }
    }
    Ok(plots)
}

/// Error and bit flips against memory, error against multipliers: one dot a word length, the front as a line, the design point ringed.
fn cost_plots(study: &Study) -> Result<Vec<String>, PlotError> {
    type Measure = fn(&Cost) -> f64;
    let charts: [(&str, &str, Measure, f64, f64, Measure); 3] = [
        ("DoG error, LSB rms", "M10K blocks", |cost| cost.dog_rms_lsb, 0.1, 100.0, |cost| cost.resources.m10k as f64),
        (
            "MaxLBP bits flipped, %",
            "M10K blocks",
            |cost| cost.maxlbp_flips_percent,
            1e-3,
            10.0,
            |cost| cost.resources.m10k as f64,
        ),
        (
            "DoG error, LSB rms",
            "multipliers 18x18",
            |cost| cost.dog_rms_lsb,
            0.1,
            100.0,
            |cost| cost.resources.mul18 as f64,
        ),
    ];
    let mut plots = Vec::new();
    for (title, label, error, low, high, price) in charts {
        let points = |keep: &dyn Fn(&Cost) -> bool| {
            let kept = study.costs.iter().filter(|cost| keep(cost));
            let mut points: Vec<(f64, f64)> = kept.map(|cost| (price(cost), error(cost))).collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
            points
        };
        // What no other point beats in this plot alone.
        let mut front: Vec<(f64, f64)> = Vec::new();
        for (x, y) in points(&|_| true) {
            if front.last().is_none_or(|last| y < last.1) {
                front.retain(|last| last.0 < x);
                front.push((x, y));
            }
        }
        let parameters = [("state", BLUE), ("coefficients", VIOLET), ("DoG", ORANGE)];
        let mut series = vec![Series { name: "front".into(), colour: GREEN, mark: Mark::Line, points: front }];
        series.extend(parameters.map(|(name, colour)| Series {
            name: name.into(),
            colour,
            mark: Mark::Dots(4),
            points: points(&|cost| cost.parameter == name && !cost.chosen),
        }));
        let chosen = points(&|cost| cost.chosen);
        series.push(Series { name: "chosen".into(), colour: RED, mark: Mark::Ring(6), points: chosen });
        let prices = || study.costs.iter().map(price);
        let (least, most) = (prices().fold(f64::INFINITY, f64::min), prices().fold(0.0, f64::max));
        let room = 0.06 * (most - least).max(1.0);
        let mut kinds: Vec<f64> = prices().collect();
        kinds.sort_by(f64::total_cmp);
        kinds.dedup();
        let x = if kinds.len() > 4 {
            Axis::linear(label, least - room, most + room)
        } else {
            let ticks = kinds.iter().map(|kind| (*kind, kind.to_string())).collect();
            Axis::ticked(label, least - room, most + room, ticks)
        };
        let chart =
            Chart { title: title.into(), size: (380, 280), x, y: Axis::log("", low, high), series, rules: Vec::new() };
        plots.push(chart.svg()?);
    }
    Ok(plots)
}

fn warp_name(warp: Warp) -> (&'static str, &'static str) {
    match warp {
        Warp::Rotation => ("rotation", "degrees"),
        Warp::Scale => ("scale", "size of the ground, CUR / REF"),
        Warp::Tilt => ("projective tilt", "degrees"),
    }
}

/// First row: points of both smoothers; second row: descriptors on the points of `recursive`.
fn repeatability_plots(study: &Study) -> Result<Vec<String>, PlotError> {
    type Line = (&'static str, Rgb, fn(&hoverlock_reference::features::repeatability::Sample) -> f64);
    let points: [Line; 2] = [
        ("ideal, Gaussian", GREY, |sample| sample.ideal.repeatability),
        ("recursive, recursive", BLUE, |sample| sample.recursive.repeatability),
    ];
    let descriptors: [Line; 3] = [
        ("LBP", GREY, |sample| sample.recursive.lbp),
        ("strict MaxLBP", ORANGE, |sample| sample.recursive.strict),
        ("with signs", BLUE, |sample| sample.recursive.signs),
    ];
    let chart = |curve: &Curve, lines: &[Line], label: &str| {
        let (name, unit) = warp_name(curve.warp);
        let values = || curve.samples.iter().map(|sample| sample.value);
        let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        let series = lines.iter().map(|(name, colour, share)| Series {
            name: (*name).into(),
            colour: *colour,
            mark: Mark::LineDots,
            points: curve.samples.iter().map(|sample| (sample.value, 100.0 * share(sample))).collect(),
        });
        Chart {
            title: name.into(),
            size: (380, 270),
            x: Axis::linear(unit, least, most),
            y: Axis::linear(label, 0.0, 100.0),
            series: series.collect(),
            rules: Vec::new(),
        }
        .svg()
    };
    let curves = &study.repeatability;
    let first = curves.iter().map(|curve| chart(curve, &points, "points repeated, %"));
    let second = curves.iter().map(|curve| chart(curve, &descriptors, "matched rightly, %"));
    first.chain(second).collect()
}

/// The largest gap between the two smoothers, in points of a hundred.
fn repeatability_gap(curves: &[Curve]) -> f64 {
    let gap = |a: &Stability, b: &Stability| 100.0 * (a.repeatability - b.repeatability);
    let samples = curves.iter().flat_map(|curve| &curve.samples);
    let gaps = samples.map(|sample| gap(&sample.ideal, &sample.recursive));
    gaps.fold(0.0, |most: f64, gap| if gap.abs() > most.abs() { gap } else { most })
}

/// One row of the calibration.
struct Calibrated {
    rms: f64,
    maxlbp_flips: f64,
    beyond_one_px: f64,
}

fn calibration() -> Vec<Calibrated> {
    let mut lines = Bounds::CALIBRATION.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let field =
            |name: &str| -> Option<f64> { fields.get(header.iter().position(|column| *column == name)?)?.parse().ok() };
        Some(Calibrated {
            rms: field("rms_lsb")?,
            maxlbp_flips: field("maxlbp_flips_percent")?,
            beyond_one_px: 100.0 - field("within_one_px_percent")?,
        })
    };
    lines.filter_map(row).collect()
}

/// Where the columns come from: contrast against what it costs, calibration in grey, the pictures of this report on top.
fn scatter(study: &Study) -> Result<Vec<String>, PlotError> {
    let bounds = Bounds::acceptance();
    let calibrated = calibration();
    // Shares of 0 are drawn on the axis.
    let (low, high) = (40.0, 5000.0);
    let steps = |limits: &ClassLimits, allowed: [f64; 3]| {
        let edges = [
            (limits.fog, limits.combined, allowed[2]),
            (limits.combined, limits.nominal, allowed[1]),
            (limits.nominal, high, allowed[0]),
        ];
        edges.into_iter().flat_map(|(from, to, y)| [(from, y), (to, y)]).collect::<Vec<_>>()
    };
    let columns = [&bounds.nominal, &bounds.combined, &bounds.fog];
    let here = |measure: &dyn Fn(&ConditionStudy, usize) -> f64| {
        let studies = study.pictures.iter().flat_map(|picture| &picture.conditions);
        let both = studies.flat_map(|of| [(of, 0), (of, 1)]);
        both.map(|(of, k)| (of.comparison.scales[k].interior.reference_rms, measure(of, k))).collect::<Vec<_>>()
    };
    let chart =
        |title: &str, label: &str, floor: f64, top: f64, all: Vec<(f64, f64)>, mine: Vec<(f64, f64)>, limit| Chart {
            title: title.into(),
            size: (520, 300),
            x: Axis::log("rms of the streaming DoG, LSB", low, high),
            y: Axis::log(label, floor, top),
            series: vec![
                Series { name: "calibration".into(), colour: [196, 203, 210], mark: Mark::Dots(2), points: all },
                Series { name: "this report".into(), colour: BLUE, mark: Mark::Dots(3), points: mine },
                Series { name: "limit".into(), colour: RED, mark: Mark::Line, points: limit },
            ],
            rules: Vec::new(),
        };
    let features = chart(
        "features not within 1 px, per scale",
        "%",
        0.05,
        10.0,
        calibrated.iter().map(|row| (row.rms, row.beyond_one_px)).collect(),
        here(&|of, k| 100.0 - of.comparison.scales[k].kept.within_one_px_percent),
        steps(&bounds.class.features, columns.map(|column| 100.0 - column.within_one_px_percent)),
    );
    let flips = chart(
        "MaxLBP bits flipped, both scales",
        "%",
        0.0005,
        1.0,
        calibrated.iter().map(|row| (row.rms, row.maxlbp_flips)).collect(),
        here(&|of, _| of.comparison.flips.percent(BitKind::Maxlbp)),
        steps(&bounds.class.signal, columns.map(|column| column.maxlbp_flips_percent)),
    );
    Ok(vec![features.svg()?, flips.svg()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_set_as_in_print() {
        assert_eq!(significant(0.012345, 2), "0.012");
        assert_eq!(significant(-1234.5, 2), "−1234");
        assert_eq!(significant(f64::INFINITY, 2), "∞");
        assert_eq!(typeset("-0.00".into()), "0.00");
        assert_eq!(typeset(format!("{:.1}", f64::NAN)), "—");
        assert_eq!(grouped(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(grouped(999), "999");
    }

    #[test]
    fn the_calibration_keeps_the_columns_it_gave() {
        // The limits were read off this table: within its column, no row breaks its limit.
        let bounds = Bounds::acceptance();
        let rows = calibration();
        assert!(rows.len() > 900, "{}", rows.len());
        for row in rows {
            if let Some(class) = bounds.class.features.class(row.rms) {
                let limit = 100.0 - bounds.column(class).within_one_px_percent;
                assert!(row.beyond_one_px <= limit, "{} LSB: {} > {limit}", row.rms, row.beyond_one_px);
            }
        }
    }
}
