//! Statistics of the designs of a campaign.

use serde::Serialize;

use super::FlownPoint;

/// A design over all its points.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DesignStatistics {
    /// Name, file or changes of the design.
    pub name: String,
    /// Number of points.
    pub points: usize,
    /// Number of points that pass.
    pub passed: usize,
    /// Rms distance from the target over all points, m.
    pub rms_m: f64,
    /// Largest rms distance of a point, m.
    pub worst_m: f64,
    /// Rms of estimate less truth over all points, m; `None` without an estimate.
    pub error_rms_m: Option<f64>,
    /// Number of frames without an estimate.
    pub lost: usize,
    /// M10K blocks, by the memory model.
    pub m10k: u64,
    /// Multipliers 18 x 18, by the memory model.
    pub mul18: u64,
    /// The design is on the Pareto front of error and memory.
    pub pareto: bool,
}

impl DesignStatistics {
    fn new(name: &str, points: &[FlownPoint]) -> Self {
        let own: Vec<&FlownPoint> = points.iter().filter(|point| point.design == name).collect();
        let rms = |values: Vec<f64>| {
            (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
        };
        let errors: Vec<f64> = own.iter().filter_map(|point| point.error_rms_m).collect();
        Self {
            name: name.to_owned(),
            points: own.len(),
            passed: own.iter().filter(|point| point.pass).count(),
            rms_m: rms(own.iter().map(|point| point.rms_m).collect()),
            worst_m: own.iter().map(|point| point.rms_m).fold(0.0, f64::max),
            error_rms_m: (!errors.is_empty()).then(|| rms(errors)),
            lost: own.iter().map(|point| point.lost).sum(),
            m10k: own.first().map_or(0, |point| point.m10k),
            mul18: own.first().map_or(0, |point| point.mul18),
            pareto: false,
        }
    }

    /// Returns the error that is compared with memory. A design without an estimate is the worst.
    fn error(&self) -> f64 {
        self.error_rms_m.unwrap_or(f64::INFINITY)
    }
}

/// Returns the statistics of each design, in the order in which the designs first occur.
pub(super) fn by_design(points: &[FlownPoint]) -> Vec<DesignStatistics> {
    let mut names: Vec<&str> = Vec::new();
    for point in points {
        if !names.contains(&point.design.as_str()) {
            names.push(&point.design);
        }
    }
    let mut designs: Vec<_> = names.into_iter().map(|name| DesignStatistics::new(name, points)).collect();
    let costs: Vec<_> = designs.iter().map(|design| (design.m10k, design.error())).collect();
    for (design, &(m10k, error)) in designs.iter_mut().zip(&costs) {
        let dominates = |&(other_m10k, other_error): &(u64, f64)| {
            (other_m10k <= m10k && other_error < error) || (other_m10k < m10k && other_error <= error)
        };
        design.pareto = !costs.iter().any(dominates);
    }
    designs
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::campaign::CampaignOutcome;
    use crate::chain::FeatureSource;
    use crate::hover::CameraView;

    /// Returns a point with an error of `error` metres.
    pub(crate) fn flown(design: &str, seed: u64, m10k: u64, error: f64, pass: bool) -> FlownPoint {
        FlownPoint {
            scene: "field".into(),
            height_m: 50.0,
            view: CameraView::Wide,
            gusts_m_s: 3.0,
            seconds: 10.0,
            features: FeatureSource::Fixed,
            design: design.into(),
            inputs: "0123abcd".into(),
            seed,
            commit: "0123456789ab".into(),
            m10k,
            mul18: 51,
            rms_m: 2.0 * error,
            max_m: 3.0 * error,
            imu_only_rms_m: 2.0,
            error_rms_m: Some(error),
            frames: 151,
            lost: 0,
            pass,
            reason: if pass { String::new() } else { "too far <away>".into() },
        }
    }

    #[test]
    fn the_front_has_the_designs_that_no_other_dominates() {
        let points = [
            flown("kt27", 1, 437, 0.02, true),
            flown("dog_bits=10", 1, 420, 0.05, true),
            flown("state=u16.4", 1, 460, 0.03, true),
            flown("state=u16.1", 1, 425, 0.02, false),
        ];
        let pareto: Vec<bool> = by_design(&points).iter().map(|design| design.pareto).collect();
        assert_eq!(pareto, [false, true, false, true]);
    }

    #[test]
    fn statistics_cover_all_points_of_a_design_and_the_page_shows_them() {
        let points = [flown("kt27", 1, 437, 0.03, true), flown("kt27", 2, 437, 0.04, false)];
        let designs = by_design(&points);
        let [design] = &designs[..] else { panic!() };
        assert_eq!((design.points, design.passed, design.worst_m), (2, 1, 0.08));
        assert!((design.error_rms_m.unwrap() - (0.00125f64).sqrt()).abs() < 1e-12);
        let outcome = CampaignOutcome::new(vec!["kt27".into()], points.into());
        let page = outcome.page("hoverlock sweep").unwrap();
        assert!(page.contains("too far &lt;away&gt;") && page.contains("1 of 2"));
        assert!(page.contains("<dt>flown by</dt><dd><code>0123456789ab</code></dd>"), "{page}");
        assert_eq!(outcome.of_other_commits(), 2);
    }
}
