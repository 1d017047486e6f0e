//! The plots of the stability of points and descriptors under warps.

use hoverlock_design::SmootherKind;

use crate::repeatability::{Curve, Sample, Stability, Warp};

use crate::colour::Rgb;
use crate::plot::{Axis, BLUE, Chart, GREY, Mark, ORANGE, PlotError, Series};
use crate::study::Study;

fn warp_name(warp: Warp) -> (&'static str, &'static str) {
    match warp {
        Warp::Rotation => ("rotation", "degrees"),
        Warp::Scale => ("scale", "scale, current / reference"),
        Warp::Tilt => ("projective tilt", "degrees"),
    }
}

/// Plots two rows: points of the smoothers, and descriptors at the points of the first-order one.
pub(super) fn plots(study: &Study) -> Result<Vec<String>, PlotError> {
    type Line = (&'static str, Rgb, fn(&Sample) -> f64);
    let mut points: Vec<Line> = vec![
        ("ideal (Gaussian)", GREY, |sample| sample.ideal.repeatability),
        ("first order", BLUE, |sample| sample.recursive.repeatability),
    ];
    if study.design.smoother != SmootherKind::FirstOrder {
        let other = |sample: &Sample| sample.other.map_or(f64::NAN, |other| other.repeatability);
        points.push((study.design.smoother.name(), ORANGE, other));
    }
    let descriptors: [Line; 3] = [
        ("LBP", GREY, |sample| sample.recursive.lbp),
        ("MaxLBP alone", ORANGE, |sample| sample.recursive.strict),
        ("MaxLBP with signs", BLUE, |sample| sample.recursive.signs),
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
    let second = curves.iter().map(|curve| chart(curve, &descriptors, "matched correctly, %"));
    first.chain(second).collect()
}

/// Returns the largest difference in repeatability, `ideal` less `recursive`, percentage points.
pub(super) fn largest_gap(curves: &[Curve]) -> f64 {
    let gap = |a: &Stability, b: &Stability| 100.0 * (a.repeatability - b.repeatability);
    let samples = curves.iter().flat_map(|curve| &curve.samples);
    let gaps = samples.map(|sample| gap(&sample.ideal, &sample.recursive));
    gaps.fold(0.0, |most: f64, gap| if gap.abs() > most.abs() { gap } else { most })
}
