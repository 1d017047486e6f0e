//! The plots of quantisation error against picture contrast, with the calibration that set the limits.

use hoverlock_fixed_point::analysis::bounds::{Bounds, ClassLimits};
use hoverlock_fixed_point::analysis::errors::BitKind;

use crate::plot::{Axis, BLUE, Chart, Mark, PlotError, RED, Series};
use crate::study::{ConditionStudy, Study};

/// One row of `calibration.csv`.
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

/// Plots features moved and bits flipped against the rms of the `streaming` DoG. Calibration in grey, this report in
/// blue, the limits in red.
pub(super) fn plots(study: &Study) -> Result<Vec<String>, PlotError> {
    let bounds = Bounds::acceptance();
    let calibrated = calibration();
    // A share of 0 is drawn on the axis.
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
    let of_report = |measure: &dyn Fn(&ConditionStudy, usize) -> f64| {
        let studies = study.pictures.iter().flat_map(|picture| &picture.conditions);
        let each = studies.flat_map(|of| (0..of.comparison.scales.len()).map(move |k| (of, k)));
        each.map(|(of, k)| (of.comparison.scales[k].interior.reference_rms, measure(of, k))).collect::<Vec<_>>()
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
        of_report(&|of, k| 100.0 - of.comparison.scales[k].kept.within_one_px_percent),
        steps(&bounds.class.features, columns.map(|column| 100.0 - column.within_one_px_percent)),
    );
    let flips = chart(
        "MaxLBP bits flipped, all scales",
        "%",
        0.0005,
        1.0,
        calibrated.iter().map(|row| (row.rms, row.maxlbp_flips)).collect(),
        of_report(&|of, _| of.comparison.flips.percent(BitKind::Maxlbp)),
        steps(&bounds.class.signal, columns.map(|column| column.maxlbp_flips_percent)),
    );
    Ok(vec![features.svg()?, flips.svg()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_calibration_row_breaks_the_limit_of_its_column() {
        // The limits were set from this table.
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
