//! The float extractor with the sigmas, the rings and the smoother of a design: the fast one if it is first-order.

use hoverlock_design::{DesignPoint, SmootherKind};
use hoverlock_fixed_point::model::design::{recursive, rings};
use hoverlock_reference::features::extractor::{Selection, extract};
use hoverlock_reference::features::fast::FastExtractor;
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::smoothing::recursive::border::Border;
use hoverlock_reference::smoothing::smoother::Smoother;

use super::ChainError;

/// A function that returns the features of a frame in raster order.
pub type FloatFeatures = Box<dyn FnMut(&Plane<u16>) -> Vec<Feature>>;

/// Creates the extractor of a design. It exists for chains of 2 to 4 smoothers.
///
/// # Errors
/// The chain is shorter or longer, or a sigma is out of range.
pub fn float_features(design: &DesignPoint, selection: Selection) -> Result<FloatFeatures, ChainError> {
    if design.smoother != SmootherKind::FirstOrder {
        return clear_float_features(design, selection);
    }
    match *design.sigmas {
        [a, b] => with_sigmas(design, [a, b], selection),
        [a, b, c] => with_sigmas(design, [a, b, c], selection),
        [a, b, c, d] => with_sigmas(design, [a, b, c, d], selection),
        _ => Err(ChainError::ChainLength(design.sigmas.len())),
    }
}

/// Creates the clear extractor of the level `recursive`, for any smoother.
///
/// # Errors
/// A sigma is out of range.
pub fn clear_float_features(design: &DesignPoint, selection: Selection) -> Result<FloatFeatures, ChainError> {
    let filters = design.sigmas.iter().map(|sigma| Ok(Smoother::Recursive(recursive(design, *sigma)?)));
    let filters = filters.collect::<Result<Vec<_>, ChainError>>()?;
    let (sigmas, rings) = (design.sigmas.clone(), rings(design));
    Ok(Box::new(move |frame| {
        let smooth = |plane: &Plane<f64>, sigma: f64| -> Plane<f64> {
            let filter = filters.iter().find(|filter| filter.sigma() == sigma).expect("a sigma of the design");
            filter.smooth(plane, Border::Held)
        };
        extract(frame, &sigmas, &rings, smooth, &selection)
    }))
}

fn with_sigmas<const F: usize>(
    design: &DesignPoint,
    sigmas: [f64; F],
    selection: Selection,
) -> Result<FloatFeatures, ChainError> {
    let mut extractor = FastExtractor::of_chain(sigmas, selection)?.with_rings(&design.ring_radii);
    Ok(Box::new(move |frame| extractor.extract(frame)))
}
