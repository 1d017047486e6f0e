//! Features of two pictures become the motion between them: search wide with few freedoms, then refine near with all of them.
//!
//! 1. Match without a gate (or within that of a prediction) and search a similarity, or a shift where no more is wanted: a sample of
//!    two is often free of outliers where one of four is not. This alone decides whether there is an estimate, and its quality.
//! 2. Match again within [`GATES`] of where the motion so far takes each feature, which recovers matches whose best was
//!    elsewhere, and search the wanted model; three times, each gate narrower. A round that finds no consensus
//!    of its own leaves the motion as it is.
//!
//! Real neighbours of a flight (turned up to 7 degrees, scale to 1.13, 300 px apart): a similarity alone misses the
//! centre of the picture by up to 4 px where the ground is seen obliquely, the refined homography by at most 1 px.

use crate::features::feature::Feature;
use crate::motion::matching::{Gate, Match, Matching};
use crate::motion::model::{Model, Pair};
use crate::motion::ransac::{Consensus, Ransac, RansacError};
use nalgebra::{Matrix3, Vector2};

/// Radii of the gates of refinement, px. The first holds what a similarity leaves of an oblique view: a scale that changes by 10 %
/// over 1000 px, at 500 px from the centre. The second holds relief; the third keeps what is as near as a vote, and nothing that a
/// better descriptor further off can take.
pub const GATES: [f64; 3] = [48.0, 16.0, 3.0];

/// A match has at most this part of the distance of the second best: few right matches are lost by it, and every other wrong one.
pub const DISTINCT: f64 = 0.9;

/// How the motion is estimated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimator {
    /// How features are matched, with the gate of a prediction if there is one.
    pub matching: Matching,
    /// How the motion is searched; its model is the one wanted.
    pub ransac: Ransac,
}

impl Default for Estimator {
    /// A homography in the end.
    fn default() -> Self {
        let matching = Matching { ratio: Some(DISTINCT), ..Matching::default() };
        Self { matching, ransac: Ransac { model: Model::Homography, ..Ransac::default() } }
    }
}

/// The motion between two pictures and what it rests on.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// REF pixel -> CUR pixel.
    pub homography: Matrix3<f64>,
    /// Kind of motion that was reached: the wanted one, or that of the search where refinement found none.
    pub model: Model,
    /// The matches of the last round.
    pub matches: Vec<Match>,
    /// Their places, in the same order.
    pub pairs: Vec<Pair>,
    /// Those that agree with the motion, ascending.
    pub inliers: Vec<usize>,
    /// Root mean square error of the inliers, px.
    pub rms: f64,
    /// Quality of the search, 0 ..= 255.
    pub quality: u8,
}

impl Estimator {
    /// The motion that takes the features of REF to those of CUR.
    ///
    /// # Errors
    /// Where a setting makes no sense, and where there is no estimate.
    pub fn estimate(&self, reference: &[Feature], current: &[Feature]) -> Result<Estimate, RansacError> {
        let search = Ransac { model: self.ransac.model.min(Model::Similarity), ..self.ransac };
        let mut best = round(&self.matching, &search, reference, current)?;
        for radius in GATES {
            let matching = Matching { gate: Some(Gate { prediction: best.homography, radius }), ..self.matching };
            if let Ok(refined) = round(&matching, &self.ransac, reference, current) {
                best = Estimate { quality: best.quality, ..refined };
            }
        }
        Ok(best)
    }
}

/// One matching and one search.
fn round(
    matching: &Matching,
    ransac: &Ransac,
    reference: &[Feature],
    current: &[Feature],
) -> Result<Estimate, RansacError> {
    let matches = matching.matches(reference, current);
    let pairs = pairs(&matches, reference, current);
    let Consensus { homography, inliers, rms, quality, .. } =
        ransac.run(&pairs, matching.gate.map(|gate| gate.radius))?;
    Ok(Estimate { homography, model: ransac.model, matches, pairs, inliers, rms, quality })
}

/// The places of matched features, to a fraction of a pixel.
pub fn pairs(matches: &[Match], reference: &[Feature], current: &[Feature]) -> Vec<Pair> {
    let place = |feature: &Feature| {
        let (x, y) = feature.subpixel();
        Vector2::new(x, y)
    };
    matches
        .iter()
        .map(|m| Pair { reference: place(&reference[m.reference]), current: place(&current[m.current]) })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::feature::Descriptor;
    use crate::motion::model::transfer;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn feature(rng: &mut ChaCha8Rng, place: Vector2<f64>, words: [u32; 4], group: (u8, bool)) -> Option<Feature> {
        let (x, y) = (place.x.round(), place.y.round());
        // A parabola with its vertex at the place: f(t) = 100 - 8 (t - offset)^2, and its neighbours at -1 and 1.
        let f = |offset: f64| [100.0 - 8.0 * (1.0 + offset).powi(2), 100.0 - 8.0 * (1.0 - offset).powi(2)];
        let (dx, dy) = (place.x - x, place.y - y);
        let lift = |v: f64, offset: f64| v + 8.0 * offset * offset;
        let ([l, r], [u, d]) = (f(dx), f(dy));
        // Every bit flips with probability 1/16.
        let mut flips = || rng.random::<u32>() & rng.random::<u32>() & rng.random::<u32>() & rng.random::<u32>();
        let noisy = words.map(|word| word ^ flips());
        (x >= 0.0 && y >= 0.0).then(|| Feature {
            x: x as u32,
            y: y as u32,
            scale: group.0,
            bright: group.1,
            response: 100.0,
            neighbours: [lift(l, dx), lift(r, dx), lift(u, dy), lift(d, dy)],
            descriptor: Descriptor { maxlbp: [noisy[0], noisy[1]], sign: [noisy[2], noisy[3]] },
        })
    }

    /// `common` features seen in both pictures, as many again in each alone.
    fn pictures(h: &Matrix3<f64>, common: usize, seed: u64) -> (Vec<Feature>, Vec<Feature>) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (mut reference, mut current) = (Vec::new(), Vec::new());
        for i in 0..3 * common {
            let place = Vector2::new(1024.0 * rng.random::<f64>(), 768.0 * rng.random::<f64>());
            let words = [rng.random(), rng.random(), rng.random(), rng.random()];
            let group = (u8::from(rng.random::<bool>()), rng.random());
            if i < 2 * common {
                reference.extend(feature(&mut rng, place, words, group));
            }
            if i < common || i >= 2 * common {
                current.extend(feature(&mut rng, transfer(h, place).unwrap(), words, group));
            }
        }
        (reference, current)
    }

    /// 5 degrees, 5 % larger, 200 px, and oblique: the scale changes by 5 % over the picture, so a similarity that fits the centre
    /// is off by more than dist at the border.
    fn oblique() -> Matrix3<f64> {
        let (s, c) = (5f64.to_radians().sin(), 5f64.to_radians().cos());
        Matrix3::new(1.05 * c, -1.05 * s, 200.0, 1.05 * s, 1.05 * c, -90.0, 3e-5, -4e-5, 1.0)
    }

    #[test]
    fn an_oblique_motion_is_found_to_a_fraction_of_a_pixel() {
        for seed in 0..5 {
            let (reference, current) = pictures(&oblique(), 200, seed);
            let found = Estimator::default().estimate(&reference, &current).unwrap();
            let centre = Vector2::new(511.5, 383.5);
            let miss = (transfer(&found.homography, centre).unwrap() - transfer(&oblique(), centre).unwrap()).norm();
            // The places are exact; a wrong match within 3 px among 150 moves the least squares by some hundredths.
            assert!(miss < 0.05, "{miss}");
            assert_eq!(found.model, Model::Homography);
            assert!(found.inliers.len() > 150, "{}", found.inliers.len());
        }
    }

    #[test]
    fn unrelated_pictures_give_no_estimate() {
        for seed in 0..20 {
            let reference = pictures(&oblique(), 250, 2 * seed).0;
            let current = pictures(&oblique(), 250, 2 * seed + 1).1;
            let outcome = Estimator::default().estimate(&reference, &current);
            assert!(outcome.as_ref().is_err_and(RansacError::is_no_estimate), "{outcome:?}");
        }
        assert!(Estimator::default().estimate(&[], &[]).is_err_and(|error| error.is_no_estimate()));
    }

    #[test]
    fn the_wanted_model_is_the_one_that_comes() {
        let shift = Matrix3::new(1.0, 0.0, 40.0, 0.0, 1.0, 25.0, 0.0, 0.0, 1.0);
        let (reference, current) = pictures(&shift, 100, 3);
        for model in [Model::Shift, Model::Similarity, Model::Affine, Model::Homography] {
            let estimator = Estimator { ransac: Ransac { model, ..Ransac::default() }, ..Estimator::default() };
            let found = estimator.estimate(&reference, &current).unwrap();
            assert_eq!(found.model, model);
            assert!((found.homography - shift).abs().max() < 1e-3, "{model:?} {}", found.homography);
        }
    }
}
