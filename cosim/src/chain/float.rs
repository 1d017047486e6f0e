//! The fast float extractor with the sigmas and rings of a design.

use hoverlock_design::DesignPoint;
use hoverlock_reference::features::extractor::Selection;
use hoverlock_reference::features::fast::FastExtractor;
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::image::plane::Plane;

use super::ChainError;

/// A function that returns the features of a frame in raster order.
pub type FloatFeatures = Box<dyn FnMut(&Plane<u16>) -> Vec<Feature>>;

/// Creates the extractor of a design. It exists for chains of 2 to 4 smoothers.
///
/// # Errors
/// The chain is shorter or longer, or a sigma is out of range.
pub fn float_features(design: &DesignPoint, selection: Selection) -> Result<FloatFeatures, ChainError> {
    match *design.sigmas {
        [a, b] => with_sigmas(design, [a, b], selection),
        [a, b, c] => with_sigmas(design, [a, b, c], selection),
        [a, b, c, d] => with_sigmas(design, [a, b, c, d], selection),
        _ => Err(ChainError::ChainLength(design.sigmas.len())),
    }
}

fn with_sigmas<const F: usize>(
    design: &DesignPoint,
    sigmas: [f64; F],
    selection: Selection,
) -> Result<FloatFeatures, ChainError> {
    let mut extractor = FastExtractor::of_chain(sigmas, selection)?.with_rings(&design.ring_radii);
    Ok(Box::new(move |frame| extractor.extract(frame)))
}
