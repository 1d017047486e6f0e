//! Figures 5 to 7: the first-order recursive filter in place of the Gaussian.

use hoverlock_design::KT27;
use hoverlock_fixed_point::analysis::levels::{Level, Levels};
use hoverlock_reference::features::dog::SIGMAS;
use hoverlock_reference::features::extractor::extract;
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::features::maxima::strongest_per_cell;
use hoverlock_reference::features::maxlbp::Ring;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::smoothing::design::DesignError;
use hoverlock_reference::smoothing::recursive::border::Border;
use hoverlock_reference::smoothing::recursive::{Family, Fit, Recursive};
use hoverlock_reference::smoothing::smoother::Smoother;
use hoverlock_reports::coefficient_plots::figures;

use crate::motion::{Pairing, SELECTION, views_of};
use crate::scenes::files;
use crate::{Item, PaperError};

/// Share of the correct matches by the Gaussian that the first-order filter must reach to be "enough".
const ENOUGH: f64 = 0.9;

/// Extracts the strongest features in f64 with first-order filters.
fn by_first_order(frame: &Plane<u16>, smoothers: &[Smoother]) -> Vec<Feature> {
    let smooth = |plane: &Plane<f64>, sigma: f64| {
        let own = smoothers.iter().find(|smoother| smoother.sigma() == sigma);
        own.map_or_else(|| plane.clone(), |smoother| smoother.smooth(plane, Border::Held))
    };
    extract(frame, &SIGMAS, &Ring::defaults(), smooth, &SELECTION)
}

/// Extracts the strongest features of the level `ideal`: with true Gaussians.
fn by_gaussian(frame: &Plane<u16>, levels: &Levels) -> Vec<Feature> {
    let planes = levels.planes(Level::Ideal, frame);
    let thresholds = vec![SELECTION.threshold; levels.design().pairs()];
    strongest_per_cell(&levels.features(&planes, &thresholds), SELECTION.count)
}

/// Returns the share of `of` that has a feature of `among` of the same scale within a pixel.
fn share(of: &[Feature], among: &[Feature]) -> f64 {
    let near = |a: &Feature, b: &Feature| a.scale == b.scale && a.x.abs_diff(b.x) <= 1 && a.y.abs_diff(b.y) <= 1;
    of.iter().filter(|a| among.iter().any(|b| near(a, b))).count() as f64 / of.len().max(1) as f64
}

/// Figures 5, 6 and 7.
pub fn items() -> Result<Vec<Item>, PaperError> {
    let design = |sigma: f64| Recursive::design(Family::FirstOrder, Fit::LeastSquares, sigma);
    let recursive = SIGMAS.iter().map(|&sigma| design(sigma)).collect::<Result<Vec<_>, DesignError>>()?;
    let drawn = figures(&recursive)?;
    let plots = |names: &[&str]| {
        let own = drawn.iter().filter(|figure| names.contains(&figure.name.as_str()));
        own.map(|figure| figure.chart.svg()).collect::<Result<Vec<_>, _>>()
    };
    let residuals: Vec<String> = SIGMAS
        .iter()
        .map(|&sigma| {
            let smoother = Smoother::first_order(sigma)?;
            let (own, best) = (smoother.impulse_response(), Smoother::gaussian(sigma)?.impulse_response());
            let worst = own.iter().zip(&best).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            Ok(format!("{:.0} % at sigma {sigma} px", 100.0 * worst / best[0]))
        })
        .collect::<Result<_, DesignError>>()?;

    let first_order = SIGMAS.map(Smoother::first_order).into_iter().collect::<Result<Vec<_>, DesignError>>()?;
    let levels = Levels::new(&KT27)?;
    let views = views_of("field")?;
    let by_gaussian = [0, 1].map(|i: usize| by_gaussian(&views[i].frame, &levels));
    let by_first_order = [0, 1].map(|i: usize| by_first_order(&views[i].frame, &first_order));
    let [ideal, own] = [&by_gaussian, &by_first_order].map(|sets| Pairing::of(&views, sets, false));
    let part = own.correct as f64 / ideal.correct as f64;
    Ok(vec![
        Item {
            number: "figure 5",
            title: "Impulse response of the DoG in one dimension",
            stated: "The difference of two recursive filters has the form of a difference of Gaussians.",
            found: "Both scale pairs of the default chain, beside the DoG of true Gaussians of the same sigmas.".into(),
            holds: None,
            evidence: "hoverlock coeffs --sigma 2 3.2 5.12",
            drawings: plots(&["dog0_impulse", "dog1_impulse"])?,
            ..Item::default()
        },
        Item {
            number: "figure 6",
            title: "First-order filter against the Gaussian",
            stated: "H(z) = A^2 / ((b0 - b1 z)(b0 - b1 z^-1)) approximates the Gaussian.",
            found: format!(
                "Largest difference of the impulse responses, of the Gaussian's peak: {}. An exponential is not a \
                 Gaussian; what \
                 that costs is figure 7.",
                residuals.join(", ")
            ),
            holds: None,
            evidence: "hoverlock coeffs --sigma 2 3.2 5.12",
            drawings: plots(&["smoother0_impulse", "smoother2_impulse"])?,
            ..Item::default()
        },
        Item {
            number: "figure 7",
            title: "First-order filter directly for detection",
            stated: "The first-order filter is enough to find the features.",
            found: format!(
                "Correct matches between two views of the field: {} with first-order filters, {} with Gaussians, so \
                 {:.0} %; \"enough\" is taken as {:.0} %. The search of hoverlock match is repeated near the motion \
                 that it finds; then {} and {} matches agree. The features are not the same ones: {:.0} % of those by \
                 Gaussians are within a pixel of one by first-order filters.",
                own.correct,
                ideal.correct,
                100.0 * part,
                100.0 * ENOUGH,
                own.agree,
                ideal.agree,
                100.0 * share(&by_gaussian[0], &by_first_order[0])
            ),
            holds: Some(part >= ENOUGH),
            commands: vec![
                own.command("hoverlock match field_1.png field_2.png --level recursive".into()),
                ideal.command("hoverlock match field_1.png field_2.png --level ideal".into()),
            ],
            only_here: "the numbers of correct matches, which take the true motion, and the shares",
            inputs: files("field", &views)?,
            ..Item::default()
        },
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_feature_a_pixel_away_is_shared() {
        let at = |x: u32, scale: u8| Feature { x, scale, ..crate::motion::tests::feature() };
        assert_eq!(share(&[at(10, 0), at(20, 0)], &[at(11, 0), at(22, 0)]), 0.5);
        assert_eq!(share(&[at(10, 0)], &[at(10, 1)]), 0.0);
    }
}
