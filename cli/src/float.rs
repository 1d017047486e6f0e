//! The fast float extractor over the chain of a design: its sigmas and its rings.

use anyhow::{Result, bail};
use hoverlock_design::DesignPoint;
use hoverlock_reference::features::extractor::Selection;
use hoverlock_reference::features::fast::FastExtractor;
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::image::plane::Plane;

/// The features of a frame, in raster order.
pub type FloatFeatures = Box<dyn FnMut(&Plane<u16>) -> Vec<Feature>>;

/// The extractor of a design; its number of smoothers is part of its type.
pub fn float_features(design: &DesignPoint, selection: Selection) -> Result<FloatFeatures> {
    match *design.sigmas {
        [a, b] => of_chain(design, [a, b], selection),
        [a, b, c] => of_chain(design, [a, b, c], selection),
        [a, b, c, d] => of_chain(design, [a, b, c, d], selection),
        _ => bail!("a chain of {} sigmas; the float extractor takes 2 to 4", design.sigmas.len()),
    }
}

fn of_chain<const F: usize>(design: &DesignPoint, sigmas: [f64; F], selection: Selection) -> Result<FloatFeatures> {
    let mut extractor = FastExtractor::of_chain(sigmas, selection)?.with_rings(&design.ring_radii);
    Ok(Box::new(move |frame| extractor.extract(frame)))
}
