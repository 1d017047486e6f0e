//! The plots of quantisation error against picture contrast, with the calibration that set the limits.

use hoverlock_fixed_point::analysis::bounds::{Bounds, ClassLimits};
use hoverlock_fixed_point::analysis::errors::BitKind;

use crate::plot::{Axis, BLUE, Chart, Mark, PlotError, RED, Series};
use crate::study::Study;

/// One row of `calibration.csv`: a scale of a frame.
struct Calibrated {
    /// Picture, condition and seed.
    frame: String,
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
            frame: fields.get(..3)?.join(","),
            rms: field("rms_lsb")?,
            maxlbp_flips: field("maxlbp_flips_percent")?,
            beyond_one_px: 100.0 - field("within_one_px_percent")?,
        })
    };
    lines.filter_map(row).collect()
}

/// Returns the lowest contrast of each frame and its flipped bits, which are counted over all scales.
fn calibrated_flips(rows: &[Calibrated]) -> Vec<(f64, f64)> {
    let frames = rows.chunk_by(|a, b| a.frame == b.frame);
    let lowest = |frame: &[Calibrated]| frame.iter().map(|row| row.rms).fold(f64::INFINITY, f64::min);
    frames.map(|frame| (lowest(frame), frame[0].maxlbp_flips)).collect()
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
        study
            .fit_frames()
            .flat_map(|frame| &frame.scales)
            .map(|scale| (scale.interior.reference_rms, 100.0 - scale.kept.within_one_px_percent))
            .collect(),
        steps(&bounds.class.features, columns.map(|column| 100.0 - column.within_one_px_percent)),
    );
    let flips = chart(
        "MaxLBP bits flipped, all scales",
        "%",
        0.0005,
        1.0,
        calibrated_flips(&calibrated),
        study.fit_frames().map(|frame| (frame.lowest_rms_lsb(), frame.flips.percent(BitKind::Maxlbp))).collect(),
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

    #[test]
    fn flips_of_the_calibration_are_a_point_for_each_frame_at_its_lowest_contrast() {
        let rows = calibration();
        let points = calibrated_flips(&rows);
        assert_eq!(2 * points.len(), rows.len());
        for (point, scales) in points.iter().zip(rows.chunks(2)) {
            assert_eq!(*point, (scales[0].rms.min(scales[1].rms), scales[0].maxlbp_flips));
        }
    }
}
