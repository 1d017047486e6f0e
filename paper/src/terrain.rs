//! Figure 4 and formula (1): the displacement of a point by relief, against the simulator.
//!
//! A point that lies `dh` below the plane through the laser's point is displaced by `dh tan(tilt + phi)` along each
//! axis ([`height_error`], formula (1)); the published bound is 1 m at a mean relief of 10 m within 5 degrees of roll
//! and pitch. Here a camera with random tilt looks at random places of simulated hills, and each pixel of a grid is
//! rectified with the laser's range and true attitude. What is left is the terrain's error alone: the distance from the
//! rectified position to where the pixel's ray meets the hills.

use std::path::Path;

use hoverlock_edss::pose::Pose;
use hoverlock_edss::render::{Lens, Renderer};
use hoverlock_edss::scene::Scene;
use hoverlock_reference::motion::model::transfer;
use hoverlock_reference::motion::orthophoto::{Attitude, Camera, View, height_error};
use hoverlock_reports::colour::Rgb;
use hoverlock_reports::plot::{Axis, BLUE, Chart, GREEN, GREY, Mark, ORANGE, Rule, Series};
use nalgebra::{Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{Item, PaperError};

/// Frame, px.
const SIZE: [usize; 2] = [1024, 768];
/// Roll and pitch at most, radians.
const TILT: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// Poses, and pixels of each along columns and rows.
const POSES: usize = 400;
const GRID: [usize; 2] = [16, 12];
/// End of the plot, m.
const FARTHEST: f64 = 6.0;
/// The published bound, m.
const PUBLISHED: f64 = 1.0;

/// Hills under a camera.
struct Case {
    name: &'static str,
    colour: Rgb,
    height: f64,
    field_of_view_deg: f64,
    rms: f64,
    wavelength: f64,
    /// Mean of `|dh|` that the hills are scaled to; as they are where absent.
    mean: Option<f64>,
}

/// The errors of a case.
struct Measured {
    /// Mean of `|dh|`, m.
    relief: f64,
    /// Distance of each point from where it is, m, ascending.
    distances: Vec<f64>,
    /// The same by formula (1), ascending.
    by_formula: Vec<f64>,
}

/// Hills and views: ten metres of mean relief need a frame that spans hills, so 2 km of height for the narrow view of
/// the formula.
const CASES: [Case; 3] = [
    Case {
        name: "10 m, narrow",
        colour: BLUE,
        height: 2000.0,
        field_of_view_deg: 10.0,
        rms: 8.0,
        wavelength: 340.0,
        mean: Some(10.0),
    },
    Case {
        name: "10 m, wide",
        colour: ORANGE,
        height: 300.0,
        field_of_view_deg: 50.0,
        rms: 8.0,
        wavelength: 240.0,
        mean: Some(10.0),
    },
    Case {
        name: "field, 100 m, wide",
        colour: GREEN,
        height: 100.0,
        field_of_view_deg: 50.0,
        rms: 3.0,
        wavelength: 120.0,
        mean: None,
    },
];

/// Largest difference of the means by formula and by geometry for which the formula holds.
const FORMULA_TOLERANCE: f64 = 0.05;

/// Figure 4, formula (1), and the claim "at most 1 m".
pub fn items() -> Result<Vec<Item>, PaperError> {
    let measured = CASES.iter().map(measure).collect::<Result<Vec<_>, _>>()?;
    let rows: Vec<String> = CASES
        .iter()
        .zip(&measured)
        .map(|(case, errors)| {
            format!(
                "{}: mean relief {:.1} m, displaced by {:.2} m on average ({:.2} m by the formula), median {:.2} m, \
                 95th percentile {:.2} m, {:.0} % within 1 m",
                case.name,
                errors.relief,
                mean(&errors.distances),
                mean(&errors.by_formula),
                quantile(&errors.distances, 0.5),
                quantile(&errors.distances, 0.95),
                100.0 * within(&errors.distances)
            )
        })
        .collect();
    let narrow = &measured[0];
    let (geometry, formula) = (mean(&narrow.distances), mean(&narrow.by_formula));
    let within = within(&narrow.distances);
    Ok(vec![
        Item {
            number: "figure 4, formula (1)",
            title: "Displacement of a point by relief",
            stated: "de_x = dh tan(roll + phi), de_y = dh tan(pitch + phi).",
            found: format!("{}.", rows.join("; ")),
            holds: Some((formula / geometry - 1.0).abs() <= FORMULA_TOLERANCE),
            evidence: "edss/README.md",
            drawings: vec![chart(&measured).svg()?],
            ..Item::default()
        },
        Item {
            number: "claim 1",
            title: "\u{201c}At most 1 m\u{201d}",
            stated: "With 10 m of mean relief and roll and pitch within 5 degrees the error is at most 1 m.",
            found: format!(
                "The mean is {geometry:.2} m, but {:.0} % of the points are displaced by more than 1 m: a mean, not a \
                 bound. The distribution is the line \u{201c}10 m, narrow\u{201d} of figure 4.",
                100.0 * (1.0 - within)
            ),
            holds: Some(within == 1.0),
            evidence: "edss/README.md",
            drawings: Vec::new(),
            ..Item::default()
        },
    ])
}

/// Draws the share of the points that are displaced by less.
fn chart(measured: &[Measured]) -> Chart {
    let mut series = Vec::new();
    for (case, errors) in CASES.iter().zip(measured) {
        series.push(curve(case.name, case.colour, Mark::Line, &errors.distances, 1));
        let formula = if series.len() == 1 { "formula (1)" } else { "" };
        series.push(curve(formula, GREY, Mark::Ring(4), &errors.by_formula, 10));
    }
    Chart {
        title: "Points displaced by less, %".into(),
        size: (760, 360),
        x: Axis::linear("displacement of a rectified point by relief, m", 0.0, FARTHEST),
        y: Axis::linear("", 0.0, 100.0),
        series,
        rules: vec![Rule::Choice(PUBLISHED, "published: at most 1 m".into())],
    }
}

/// Measures points of random poses over the hills of a case. If the case has a `mean`, the hills are scaled until the
/// mean of `|dh|` is `mean`, m.
fn measure(case: &Case) -> Result<Measured, PaperError> {
    let first = errors(case, case.rms)?;
    match case.mean {
        // `dh` is proportional to the hills' height but for where the rays meet them, so twice is enough.
        Some(mean) => {
            let rms = case.rms * mean / first.relief;
            let second = errors(case, rms)?;
            errors(case, rms * mean / second.relief)
        }
        None => Ok(first),
    }
}

fn errors(case: &Case, rms: f64) -> Result<Measured, PaperError> {
    let text =
        format!("[ground.grass]\n[relief.hills]\nrms_m = {rms}\nwavelength_m = {}\noctaves = 2\n", case.wavelength);
    let renderer = Renderer::new(&Scene::parse(&text, Path::new(""))?, 1)?;
    let camera = Camera::with_field_of_view(SIZE[0], SIZE[1], case.field_of_view_deg.to_radians())?;
    let lens = Lens { camera, k1: 0.0, k2: 0.0 };
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let (mut relief, mut distances, mut by_formula) = (0.0, Vec::new(), Vec::new());
    for _ in 0..POSES {
        let mut within = |limit: f64| random.random_range(-limit..limit);
        let (x, y) = (within(2000.0), within(2000.0));
        let attitude = Attitude { roll: within(TILT), pitch: within(TILT), yaw: 0.0 };
        let pose = Pose { position: Vector3::new(x, y, -case.height), attitude };
        let middle = Vector2::new(SIZE[0] as f64 - 1.0, SIZE[1] as f64 - 1.0) / 2.0;
        let laser = renderer.ground(&lens, &pose, middle, 0.0).ok_or(PaperError::NoGround)?;
        let view = View::new(camera, attitude, (laser - pose.position).norm())?;
        let rectify = view.to_ground();
        for i in 0..GRID[0] {
            for j in 0..GRID[1] {
                let part = |k: usize, of: usize| (k as f64 + 0.5) / of as f64;
                let pixel = Vector2::new(SIZE[0] as f64 * part(i, GRID[0]), SIZE[1] as f64 * part(j, GRID[1]));
                let truth = renderer.ground(&lens, &pose, pixel, 0.0).ok_or(PaperError::NoGround)?;
                let seen = transfer(&rectify, pixel).ok_or(PaperError::NoGround)? + pose.position.xy();
                let dh = truth.z - laser.z;
                let phi = lens.direction(pixel);
                let formula = Vector2::new(
                    height_error(dh, attitude.roll, phi.x.atan()),
                    height_error(dh, attitude.pitch, phi.y.atan()),
                );
                relief += dh.abs();
                distances.push((seen - truth.xy()).norm());
                by_formula.push(formula.norm());
            }
        }
    }
    let relief = relief / distances.len() as f64;
    for values in [&mut distances, &mut by_formula] {
        values.sort_by(f64::total_cmp);
    }
    Ok(Measured { relief, distances, by_formula })
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Returns the share of ascending errors within the published bound.
fn within(errors: &[f64]) -> f64 {
    errors.partition_point(|&error| error <= PUBLISHED) as f64 / errors.len() as f64
}

/// Of sorted values.
fn quantile(values: &[f64], part: f64) -> f64 {
    values[((values.len() - 1) as f64 * part).round() as usize]
}

/// Per cent of the points at most so far, one in `step`.
fn curve(name: &str, colour: Rgb, mark: Mark, values: &[f64], step: usize) -> Series {
    let points = (0..=100u32).step_by(step).map(|p| (quantile(values, f64::from(p) / 100.0), f64::from(p)));
    Series { name: name.into(), colour, mark, points: points.filter(|point| point.0 <= FARTHEST).collect() }
}
