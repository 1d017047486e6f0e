//! The readable extractor in f64, for any smoother: `I -> {G_sigma * I} -> {DOG_k, MaxDOG_k} -> features`.
//!
//! [`fast`](crate::features::fast) computes the same features in f32. Features are in
//! raster order, the lower `k` first at one pixel. The steps are separate functions, so that every model level,
//! integers included, uses the same search and the same descriptors.

use std::ops::Sub;

use crate::features::dog::Dog;
use crate::features::feature::Feature;
use crate::features::maxima::{maxima, spread};
use crate::features::maxlbp::{Layer, Ring, descriptor};
use crate::image::plane::Plane;

/// The choice of the maxima that become features.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Selection {
    /// `T` of every scale pair in DN of the camera sample: a feature has `DOG_k >= T`.
    pub threshold: f64,
    /// Largest number of features, spread over the frame by [`spread`].
    pub count: usize,
}

impl Default for Selection {
    /// Returns a threshold of one LSB of the fixed-point DoG (0.5 DN), the lowest of the hardware, and 1000 features.
    fn default() -> Self {
        Self { threshold: 0.5, count: 1000 }
    }
}

/// Extracts the features of a frame with a chain of sigmas (px) and the ring of each scale pair. `smooth(plane, sigma)`
/// smooths by a Gaussian of `sigma` px or by an approximation of it. Features are in raster order.
pub fn extract(
    frame: &Plane<u16>,
    sigmas: &[f64],
    rings: &[Ring],
    smooth: impl Fn(&Plane<f64>, f64) -> Plane<f64>,
    selection: &Selection,
) -> Vec<Feature> {
    let layers = layers(frame, sigmas, rings, smooth);
    let found = points(&layers, &vec![selection.threshold; layers.len()]);
    let position = |p: &Point| (p.x as u32, p.y as u32, layers[p.scale].dog.magnitude[(p.x, p.y)]);
    let kept = spread(&found, selection.count, position);
    kept.into_iter().map(|point| feature(&layers, point, 1.0)).collect()
}

/// Computes `DOG_k`, sign and `MaxDOG_k` of each scale pair of a chain of sigmas (px); there is one pair less than
/// there are sigmas.
pub fn layers(
    frame: &Plane<u16>,
    sigmas: &[f64],
    rings: &[Ring],
    smooth: impl Fn(&Plane<f64>, f64) -> Plane<f64>,
) -> Vec<Layer<f64>> {
    let frame = frame.map(|&dn| f64::from(dn));
    let smoothed: Vec<_> = sigmas.iter().map(|sigma| smooth(&frame, *sigma)).collect();
    layers_between(&smoothed, rings)
}

/// Computes the layers from smoothed planes, the narrowest first.
///
/// # Panics
/// If the planes differ in shape.
pub fn layers_between<T: Copy + PartialOrd + Sub<Output = T>>(smoothed: &[Plane<T>], rings: &[Ring]) -> Vec<Layer<T>> {
    let pairs = smoothed.windows(2).zip(rings);
    pairs.map(|(pair, ring)| Layer::new(Dog::between(&pair[0], &pair[1]), *ring)).collect()
}

/// Returns the features of all maxima of at least the threshold of their scale, in raster order. `dn_per_unit` converts
/// a response to DN: 1 for float planes, 1/2 for the fixed-point DoG.
///
/// # Panics
/// If the layers differ in shape.
pub fn features<T: Copy + PartialOrd + Into<f64>>(
    layers: &[Layer<T>],
    thresholds: &[T],
    dn_per_unit: f64,
) -> Vec<Feature> {
    points(layers, thresholds).into_iter().map(|point| feature(layers, point, dn_per_unit)).collect()
}

/// The position of a feature; the order of the fields is the order of features.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Point {
    y: usize,
    x: usize,
    scale: usize,
}

fn points<T: Copy + PartialOrd>(layers: &[Layer<T>], thresholds: &[T]) -> Vec<Point> {
    let shape = |layer: &Layer<T>| (layer.dog.magnitude.width(), layer.dog.magnitude.height());
    assert!(layers.windows(2).all(|pair| shape(&pair[0]) == shape(&pair[1])), "layers of different shape");
    let mut found = Vec::new();
    for (scale, (layer, threshold)) in layers.iter().zip(thresholds).enumerate() {
        let maxima = maxima(&layer.dog.magnitude, *threshold);
        found.extend(maxima.into_iter().map(|(x, y)| Point { y, x, scale }));
    }
    found.sort_unstable();
    found
}

fn feature<T: Copy + PartialOrd + Into<f64>>(layers: &[Layer<T>], at: Point, dn_per_unit: f64) -> Feature {
    let Point { x, y, scale } = at;
    let dog = &layers[scale].dog;
    let dn = |x: usize, y: usize| dog.magnitude[(x, y)].into() * dn_per_unit;
    Feature {
        x: x as u32,
        y: y as u32,
        scale: scale as u8,
        bright: dog.positive[(x, y)],
        response: dn(x, y),
        neighbours: [dn(x - 1, y), dn(x + 1, y), dn(x, y - 1), dn(x, y + 1)],
        descriptor: descriptor(layers, x, y),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::features::dog::SIGMAS;

    /// Smooths with a known result: the mean over a square of about `sigma` px to each side, cut at the border.
    fn box_mean(plane: &Plane<f64>, sigma: f64) -> Plane<f64> {
        let reach = sigma.round() as usize;
        Plane::from_fn(plane.width(), plane.height(), |x, y| {
            let columns = x.saturating_sub(reach)..(x + reach + 1).min(plane.width());
            let rows = y.saturating_sub(reach)..(y + reach + 1).min(plane.height());
            let area = (columns.len() * rows.len()) as f64;
            rows.map(|r| plane.row(r)[columns.clone()].iter().sum::<f64>()).sum::<f64>() / area
        })
    }

    fn picture() -> impl Strategy<Value = Plane<u16>> {
        (1usize..90, 1usize..70).prop_flat_map(|(w, h)| {
            prop::collection::vec(any::<u16>(), w * h).prop_map(move |s| Plane::from_vec(w, h, s).unwrap())
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn features_are_ordered_eligible_and_agree_with_the_layers(frame in picture(), pairs in 1usize..=3) {
            let sigmas = [2.0, 3.2, 5.12, 8.2];
            let layers = layers(&frame, &sigmas[..=pairs], &Ring::defaults(), box_mean);
            let thresholds = [30.0, 20.0, 15.0];
            let all = features(&layers, &thresholds, 1.0);
            let expected: usize = (0..pairs).map(|k| maxima(&layers[k].dog.magnitude, thresholds[k]).len()).sum();
            prop_assert_eq!(all.len(), expected);
            prop_assert!(all.windows(2).all(|w| (w[0].y, w[0].x, w[0].scale) < (w[1].y, w[1].x, w[1].scale)));
            for f in &all {
                let (x, y, k) = (f.x as usize, f.y as usize, usize::from(f.scale));
                let d = layers[k].dog.signed();
                prop_assert!(f.response >= thresholds[k]);
                prop_assert_eq!(if f.bright { f.response } else { -f.response }, d[(x, y)]);
                prop_assert_eq!(f.neighbours[1], d[(x + 1, y)].abs());
                prop_assert_eq!(f.neighbours[2], d[(x, y - 1)].abs());
                let (sx, sy) = f.subpixel();
                prop_assert!((sx - x as f64).abs() <= 0.5 && (sy - y as f64).abs() <= 0.5);
            }
        }

        #[test]
        fn integer_and_float_layers_give_the_same_features(frame in picture()) {
            // Whole numbers in either type: every comparison has the same outcome, so every feature is the same.
            let frames = [3.0, 5.0, 9.0].map(|reach| box_mean(&frame.map(|&c| f64::from(c)), reach).map(|v| v.round()));
            let float = layers_between(&frames, &Ring::defaults());
            let whole = layers_between(&frames.map(|f| f.map(|&v| v as u32)), &Ring::defaults());
            prop_assert_eq!(features(&float, &[40.0; 2], 0.5), features(&whole, &[40; 2], 0.5));
        }
    }

    #[test]
    fn a_bright_spot_is_one_bright_feature() {
        // One pixel of 60000 on black: the box means are 60000 / 49 on 7x7 px and 60000 / 121 on 11x11 px around it, so
        // d_1 is 728 on the 7x7 px, which start at (28, 27), and -496 on the rest of the 11x11.
        let mut frame = Plane::filled(64, 64, 0u16);
        frame[(31, 30)] = 60000;
        let mut found = features(&layers(&frame, &SIGMAS, &Ring::defaults(), box_mean), &[100.0; 2], 1.0);
        found.retain(|f| f.bright && f.scale == 1);
        assert_eq!(found.len(), 1, "the flat top of the box mean counts once");
        assert_eq!((found[0].x, found[0].y), (28, 27), "at its first pixel");
        assert!((found[0].response - (60000.0 / 49.0 - 60000.0 / 121.0)).abs() < 1e-9);
    }

    #[test]
    fn pictures_without_texture_or_too_small_have_no_features() {
        for frame in [Plane::filled(60, 60, 777u16), Plane::filled(60, 60, u16::MAX), Plane::filled(1, 500, 3)] {
            assert_eq!(extract(&frame, &SIGMAS, &Ring::defaults(), box_mean, &Selection::default()), []);
        }
        let busy = Plane::from_fn(36, 90, |x, y| ((x * 7919 + y * 104_729) % 65_536) as u16);
        assert_eq!(extract(&busy, &SIGMAS, &Ring::defaults(), box_mean, &Selection::default()), []);
    }

    #[test]
    fn count_limits_the_features() {
        let frame = Plane::from_fn(120, 120, |x, y| ((x * x * 7919 + y * y * 31_337 + x * y * 911) % 65_536) as u16);
        let all = features(&layers(&frame, &SIGMAS, &Ring::defaults(), box_mean), &[0.5; 2], 1.0);
        assert!(all.len() > 20, "{}", all.len());
        assert_eq!(
            extract(&frame, &SIGMAS, &Ring::defaults(), box_mean, &Selection { count: 20, ..Selection::default() })
                .len(),
            20
        );
    }
}
