//! Stability of feature points and descriptors under a known warp `H` of a real picture:
//!
//! ```text
//! repeatability = |R| / N,    R = one-to-one pairs (p, q), same scale and polarity, |H p - q| <= 1.5 px
//! correct       = |M and R| / |R|,    M = mutual best matches of the descriptors among the same N points
//! ```
//!
//! REF is the middle of the picture, CUR the same picture resampled (bicubic) through `H`, which does not move the
//! middle of the frame. A point counts if it is eligible in one frame and its mapped position is eligible in the other,
//! so that both frames show the same ground. Each frame and each smoother gives its `N_k` strongest points per scale.
//! The numbers are equal because more points repeat more often by chance. Positions have subpixel resolution
//! (parabola).
//!
//! The sampled Gaussian (`ideal`) is compared with the two-sided first-order recursion (`recursive`), whose features
//! are claimed to be "almost identically stable". At the points of each, three descriptors are compared: LBP on
//! intensities, MaxLBP without sign bits (strict) and MaxLBP with sign bits. Measured over 16 pictures: within 5
//! degrees of rotation the recursion repeats at most 2.6 percentage points less, and under changes of scale as many
//! points or more. At large rotations it repeats less (87 % against 96 % at 20 degrees), because the contour lines of a
//! product of two exponentials are diamonds, those of a product of two Gaussians circles.
//!
//! Source of the measure: K. Mikolajczyk et al., "A comparison of affine region
//! detectors", 2005, section 4.1, with positions in pixels instead of overlapping regions: all features of a scale pair
//! have one size here.

pub mod lbp;

use std::ops::Range;

use nalgebra::{Matrix3, Vector2};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use hoverlock_reference::features::dog::SIGMAS;
use hoverlock_reference::features::extractor::{features, layers_between};
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::features::maxima::eligible;
use hoverlock_reference::features::maxlbp::Ring;
use hoverlock_reference::image::bicubic::bicubic;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::matching::Matching;
use hoverlock_reference::motion::model::transfer;
use hoverlock_reference::smoothing::design::DesignError;
use hoverlock_reference::smoothing::recursive::border::Border;
use hoverlock_reference::smoothing::smoother::Smoother;

/// Largest distance of a repeated point from its warped position, px.
const MAX_REPEATED_DISTANCE_PX: f64 = 1.5;

/// Largest number of points of each scale pair.
const MAX_POINTS_PER_SCALE: usize = 300;

/// Horizontal field of view for the tilts, degrees: the wide end of the zoom of the camera.
const FIELD_OF_VIEW_DEG: f64 = 50.0;

/// A family of warps about the middle of the frame, with one parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Warp {
    /// About the optical axis, degrees, from the `x` axis towards the `y` axis.
    Rotation,
    /// Size of the ground in CUR over that in REF.
    Scale,
    /// The ground turned about the horizontal through the middle of the frame, degrees: a projective warp.
    Tilt,
}

impl Warp {
    /// All families, in the order of the report.
    pub const ALL: [Self; 3] = [Self::Rotation, Self::Scale, Self::Tilt];

    /// Returns the parameters at which the family is measured.
    pub fn values(self) -> &'static [f64] {
        match self {
            Self::Rotation => &[0.0, 1.0, 2.0, 3.5, 5.0, 7.5, 10.0, 15.0, 20.0],
            Self::Scale => &[0.8, 0.85, 0.9, 0.95, 1.0, 1.05, 1.1, 1.18, 1.25],
            Self::Tilt => &[0.0, 2.5, 5.0, 7.5, 10.0, 15.0, 20.0],
        }
    }

    /// Returns the homography from REF pixel to CUR pixel, for frames of `width` x `height`.
    pub fn homography(self, value: f64, width: usize, height: usize) -> Matrix3<f64> {
        let middle = Vector2::new(width as f64 - 1.0, height as f64 - 1.0) / 2.0;
        let (sin, cos) = value.to_radians().sin_cos();
        let about_middle = match self {
            Self::Rotation => Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0),
            Self::Scale => Matrix3::new(value, 0.0, 0.0, 0.0, value, 0.0, 0.0, 0.0, 1.0),
            // Ground (X, Y, 0) turned about X, seen from distance 1 with focal length f:
            // x' = f X / (1 + Y sin), y' = f Y cos / (1 + Y sin), where REF has x = f X, y = f Y.
            Self::Tilt => {
                let focal = width as f64 / 2.0 / (FIELD_OF_VIEW_DEG / 2.0).to_radians().tan();
                Matrix3::new(1.0, 0.0, 0.0, 0.0, cos, 0.0, 0.0, sin / focal, 1.0)
            }
        };
        Matrix3::new_translation(&middle) * about_middle * Matrix3::new_translation(&-middle)
    }
}

/// The stability of points and descriptors over one family of warps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Family of the warps.
    pub warp: Warp,
    /// Measurements in the order of the parameter, without warps that have no points to compare.
    pub samples: Vec<Sample>,
}

/// The measurement at one parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// The parameter: degrees, or the ratio of sizes.
    pub value: f64,
    /// `N`: points compared, the same for both smoothers and both frames.
    pub points: usize,
    /// Stability with the sampled Gaussian, `ideal`.
    pub ideal: Stability,
    /// Stability with the two-sided first-order recursion, `recursive`.
    pub recursive: Stability,
    /// Stability with the smoother of the design, if it is another one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other: Option<Stability>,
}

/// The fractions of repeated points and of correct matches, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Stability {
    /// Fraction of the points of REF that are repeated in CUR.
    pub repeatability: f64,
    /// Fraction of those that LBP on intensities matches correctly.
    pub lbp: f64,
    /// Fraction of those that MaxLBP without sign bits matches correctly.
    pub strict: f64,
    /// Fraction of those that MaxLBP with sign bits matches correctly.
    pub signs: f64,
}

/// A function that designs a smoother of `sigma` px.
pub type SmootherOf<'a> = &'a dyn Fn(f64) -> Result<Smoother, DesignError>;

/// Measures one picture and returns one curve per family of warps. The frame is the middle of the picture, at most
/// `frame` columns and rows; outside the picture CUR repeats the border sample, and points there are not compared.
/// `other` is measured beside the Gaussian and the first-order recursion.
///
/// # Errors
/// A smoother cannot be designed, which is a defect of this program.
pub fn curves(
    picture: &Plane<u16>,
    frame: (usize, usize),
    other: Option<SmootherOf<'_>>,
) -> Result<Vec<Curve>, DesignError> {
    let mut smoothers = vec![Bank::of(Smoother::gaussian)?, Bank::of(Smoother::first_order)?];
    smoothers.extend(other.map(Bank::of).transpose()?);
    let view = View::of(picture, frame);
    let reference = view.seen_through(&Matrix3::identity());
    let points = |frame: &Plane<u16>| -> Vec<Vec<Point>> { smoothers.iter().map(|bank| bank.points(frame)).collect() };
    let in_reference = points(&reference);
    let sample = |warp: Warp, value: f64| {
        let homography = warp.homography(value, view.width, view.height);
        // One value of each curve is no warp at all.
        let in_current = if homography == Matrix3::identity() {
            in_reference.clone()
        } else {
            points(&view.seen_through(&homography))
        };
        let (points, stability) = compare(&in_reference, &in_current, &homography, &reference)?;
        let &[ideal, recursive, ref others @ ..] = &stability[..] else { return None };
        Some(Sample { value, points, ideal, recursive, other: others.first().copied() })
    };
    Ok(Warp::ALL
        .into_iter()
        .map(|warp| {
            let samples: Vec<_> = warp.values().par_iter().map(|&value| sample(warp, value)).collect();
            Curve { warp, samples: samples.into_iter().flatten().collect() }
        })
        .collect())
}

/// The three smoothers of one kind.
struct Bank([Smoother; SIGMAS.len()]);

/// A feature with its MaxLBP and LBP descriptors.
#[derive(Debug, Clone, Copy)]
struct Point {
    feature: Feature,
    lbp: Feature,
    position: Vector2<f64>,
}

impl Bank {
    fn of(design: impl Fn(f64) -> Result<Smoother, DesignError>) -> Result<Self, DesignError> {
        let [narrow, middle, wide] = SIGMAS.map(design);
        Ok(Self([narrow?, middle?, wide?]))
    }

    /// Extracts all features of at least one LSB of the fixed-point DoG, 0.5 DN.
    fn points(&self, frame: &Plane<u16>) -> Vec<Point> {
        let plane = frame.map(|&dn| f64::from(dn));
        let smoothed = self.0.each_ref().map(|smoother| smoother.smooth(&plane, Border::Held));
        let layers = layers_between(&smoothed, &Ring::defaults());
        let point = |feature: Feature| {
            let descriptor = lbp::descriptor(frame, feature.x as usize, feature.y as usize);
            let (x, y) = feature.subpixel();
            Point { feature, lbp: Feature { descriptor, ..feature }, position: Vector2::new(x, y) }
        };
        features(&layers, &[0.5; 2], 1.0).into_iter().map(point).collect()
    }
}

/// The frame in the middle of a picture.
struct View<'a> {
    picture: &'a Plane<u16>,
    width: usize,
    height: usize,
    offset: Vector2<f64>,
}

impl<'a> View<'a> {
    fn of(picture: &'a Plane<u16>, frame: (usize, usize)) -> Self {
        let (x, y, width, height) = hoverlock_pictures::centred_crop((picture.width(), picture.height()), frame);
        let offset = Vector2::new(x as f64, y as f64);
        Self { picture, width, height, offset }
    }

    /// Renders the frame whose pixel `H p` shows the ground of the unwarped pixel `p`.
    fn seen_through(&self, homography: &Matrix3<f64>) -> Plane<u16> {
        // The warps here are far from singular.
        let back = homography.try_inverse().unwrap_or_else(Matrix3::identity);
        Plane::from_fn(self.width, self.height, |x, y| {
            let position = transfer(&back, Vector2::new(x as f64, y as f64)).unwrap_or_default() + self.offset;
            bicubic(self.picture, position.x, position.y)
        })
    }
}

/// Returns `N` and the stability of each smoother, or `None` if one of them has no point of either scale.
fn compare(
    reference: &[Vec<Point>],
    current: &[Vec<Point>],
    homography: &Matrix3<f64>,
    frame: &Plane<u16>,
) -> Option<(usize, Vec<Stability>)> {
    let back = homography.try_inverse()?;
    let area = [eligible(frame.width()), eligible(frame.height())];
    let common = |points: &[Point], to_other: &Matrix3<f64>| -> [Vec<Point>; 2] {
        [0, 1].map(|scale| {
            let mut points: Vec<Point> = points
                .iter()
                .filter(|p| {
                    p.feature.scale == scale && transfer(to_other, p.position).is_some_and(|q| is_within(q, &area))
                })
                .copied()
                .collect();
            // A stable sort: of equal responses the earlier in raster order comes first.
            points.sort_by(|a, b| b.feature.response.total_cmp(&a.feature.response));
            points
        })
    };
    let pairs = reference.iter().zip(current);
    let mut sides: Vec<_> = pairs.map(|(from, to)| [common(from, homography), common(to, &back)]).collect();
    let numbers = [0, 1].map(|scale| {
        let available = sides.iter().flatten().map(|side| side[scale].len()).min().unwrap_or(0);
        available.min(MAX_POINTS_PER_SCALE)
    });
    let points = numbers.iter().sum();
    if points == 0 {
        return None;
    }
    for side in sides.iter_mut().flatten() {
        side.iter_mut().zip(numbers).for_each(|(of_scale, n)| of_scale.truncate(n));
    }
    let stability = |[from, to]: &[[Vec<Point>; 2]; 2]| stability(&from.concat(), &to.concat(), homography);
    Some((points, sides.iter().map(stability).collect()))
}

fn is_within(position: Vector2<f64>, [columns, rows]: &[Range<usize>; 2]) -> bool {
    let within = |v: f64, range: &Range<usize>| v >= range.start as f64 && v < range.end as f64;
    within(position.x, columns) && within(position.y, rows)
}

/// Computes repeatability and correct matches of two lists of equal length.
fn stability(reference: &[Point], current: &[Point], homography: &Matrix3<f64>) -> Stability {
    let repeated = repeated(reference, current, homography);
    let correct = |strict: bool, described: fn(&Point) -> Feature| {
        let of = |points: &[Point]| points.iter().map(described).collect::<Vec<_>>();
        let matches = Matching { strict, ..Matching::default() }.matches(&of(reference), &of(current));
        let right = matches.iter().filter(|m| repeated.binary_search(&(m.reference, m.current)).is_ok()).count();
        right as f64 / repeated.len().max(1) as f64
    };
    Stability {
        repeatability: repeated.len() as f64 / reference.len() as f64,
        lbp: correct(true, |p| p.lbp),
        strict: correct(true, |p| p.feature),
        signs: correct(false, |p| p.feature),
    }
}

/// Returns the pairs `R`, sorted by index. They are chosen nearest first, and no point is in two pairs.
fn repeated(reference: &[Point], current: &[Point], homography: &Matrix3<f64>) -> Vec<(usize, usize)> {
    let mut near = Vec::new();
    for (i, p) in reference.iter().enumerate() {
        let Some(expected) = transfer(homography, p.position) else { continue };
        for (j, q) in current.iter().enumerate() {
            let distance = (q.position - expected).norm();
            let is_similar = p.feature.scale == q.feature.scale && p.feature.bright == q.feature.bright;
            if is_similar && distance <= MAX_REPEATED_DISTANCE_PX {
                near.push((distance, i, j));
            }
        }
    }
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let (mut taken_i, mut taken_j) = (vec![false; reference.len()], vec![false; current.len()]);
    let mut pairs: Vec<(usize, usize)> = near
        .into_iter()
        .filter_map(|(_, i, j)| {
            let free = !taken_i[i] && !taken_j[j];
            if free {
                (taken_i[i], taken_j[j]) = (true, true);
            }
            free.then_some((i, j))
        })
        .collect();
    pairs.sort_unstable();
    pairs
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::io::Write as _;

    use super::*;
    use hoverlock_pictures::{Picture, data_dir};

    /// Returns random values on a grid of 7 px with bicubic interpolation: detail of about the size of the features.
    fn texture(width: usize, height: usize) -> Plane<u16> {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let grid = Plane::from_fn(width / 7 + 2, height / 7 + 2, |_, _| random.random_range(10_000..50_000u16));
        Plane::from_fn(width, height, |x, y| bicubic(&grid, x as f64 / 7.0, y as f64 / 7.0))
    }

    fn at(h: &Matrix3<f64>, x: f64, y: f64) -> (f64, f64) {
        let p = transfer(h, Vector2::new(x, y)).unwrap();
        (p.x, p.y)
    }

    #[test]
    fn warps_keep_the_middle_and_map_known_points() {
        let close = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).abs() < 1e-9 && (a.1 - b.1).abs() < 1e-9;
        for warp in Warp::ALL {
            for &value in warp.values() {
                let h = warp.homography(value, 101, 81);
                assert!(close(at(&h, 50.0, 40.0), (50.0, 40.0)), "{warp:?} {value}");
            }
        }
        assert!(close(at(&Warp::Rotation.homography(90.0, 101, 81), 60.0, 40.0), (50.0, 50.0)));
        assert!(close(at(&Warp::Scale.homography(2.0, 101, 81), 60.0, 35.0), (70.0, 30.0)));
        // f = 50.5 / tan 25 degrees = 108.297; 10 px below the middle Y = 0.092339, tilted by 30 degrees:
        // y' = f Y cos 30 / (1 + Y sin 30) = 8.660254 / 1.0461693 = 8.278062, and x' = 10 / 1.0461693 = 9.558682.
        let (x, y) = at(&Warp::Tilt.homography(30.0, 101, 81), 60.0, 50.0);
        assert!((x - 59.558682).abs() < 1e-5 && (y - 48.278062).abs() < 1e-5, "{x} {y}");
    }

    #[test]
    fn without_a_warp_all_points_repeat_and_a_wrong_warp_repeats_none() {
        let picture = texture(220, 200);
        let bank = || Bank::of(Smoother::first_order).unwrap().points(&picture);
        let points = || [bank(), bank()];
        let (n, found) = compare(&points(), &points(), &Matrix3::identity(), &picture).unwrap();
        assert!(n >= 100, "{n} points");
        assert_eq!(found[0], Stability { repeatability: 1.0, lbp: 1.0, strict: 1.0, signs: 1.0 });
        // By chance 7 px^2 of 220 x 200 hold one of n points.
        let wrong = Matrix3::new_translation(&Vector2::new(13.0, -9.0));
        let (_, found) = compare(&points(), &points(), &wrong, &picture).unwrap();
        assert!(found[0].repeatability < 0.2, "{found:?}");
    }

    #[test]
    fn a_shift_by_whole_pixels_repeats_all_points_of_the_interior() {
        let picture = texture(300, 260);
        let [from, to] = [(10, 20), (27, 8)].map(|(x, y)| picture.crop(x, y, 220, 200).unwrap());
        let bank = Bank::of(Smoother::gaussian).unwrap();
        let points = |frame: &Plane<u16>| [bank.points(frame), bank.points(frame)];
        // A ground point at (x, y) of the first crop is at (x - 17, y + 12) of the second.
        let shift = Matrix3::new_translation(&Vector2::new(-17.0, 12.0));
        let (n, found) = compare(&points(&from), &points(&to), &shift, &from).unwrap();
        let found = found[0];
        // 18 px from the border the widest Gaussian still sees it at 3.5 sigma: a point or two may differ.
        assert!(n >= 80 && found.repeatability >= 0.95 && found.signs >= 0.95, "{n} {found:?}");
    }

    #[test]
    fn a_pair_is_of_one_scale_and_polarity_and_no_point_is_in_two() {
        let feature = Bank::of(Smoother::first_order).unwrap().points(&texture(100, 100))[0];
        let put = |x: f64, scale: u8, bright: bool| Point {
            feature: Feature { scale, bright, ..feature.feature },
            position: Vector2::new(x, 50.0),
            ..feature
        };
        let from = [put(20.0, 0, true), put(21.0, 0, true), put(40.0, 1, true), put(60.0, 0, true), put(80.0, 0, true)];
        let to = [put(20.9, 0, true), put(40.0, 0, true), put(60.0, 0, false), put(81.6, 0, true), put(82.0, 0, true)];
        assert_eq!(repeated(&from, &to, &Matrix3::identity()), [(1, 0)]);
    }

    #[test]
    #[ignore = "25 warps of real pictures, about 4 s each"]
    fn the_recursion_is_almost_as_stable_as_the_gaussian_within_the_envelope() {
        let Some(folder) = data_dir() else {
            writeln!(
                std::io::stderr(),
                "SKIPPED: the_recursion_is_almost_as_stable_as_the_gaussian_within_the_envelope: \
                 set HOVERLOCK_DATA to the picture folder"
            )
            .expect("stderr is open");
            return;
        };
        for name in ["farmstead", "pasture_low_texture", "urban_intersection_a"] {
            let picture = Picture::open(folder.join("textures").join(name).with_extension("png")).unwrap();
            for curve in curves(&picture.luma, (1024, 768), None).unwrap() {
                // Roll, pitch and yaw of 5 degrees, 5 m of altitude in 100 m.
                let within = |value: f64| match curve.warp {
                    Warp::Rotation | Warp::Tilt => value <= 5.0,
                    Warp::Scale => (0.95..=1.05).contains(&value),
                };
                for sample in curve.samples.iter().filter(|sample| within(sample.value)) {
                    let (ideal, recursive) = (sample.ideal, sample.recursive);
                    let lost = ideal.repeatability - recursive.repeatability;
                    eprintln!("{name} {:?} {}: {ideal:.3?} {recursive:.3?}", curve.warp, sample.value);
                    assert_eq!(sample.points, 2 * MAX_POINTS_PER_SCALE);
                    // Measured over 16 pictures, on average: 0.92 and more, and at most 0.026 behind the Gaussian.
                    assert!(lost <= 0.05 && recursive.repeatability >= 0.85, "{name} {:?} {sample:?}", curve.warp);
                    assert!(recursive.signs >= recursive.strict && recursive.strict >= recursive.lbp, "{sample:?}");
                    assert!(recursive.signs >= 0.9, "{name} {:?} {sample:?}", curve.warp);
                }
            }
        }
    }

    #[test]
    fn frames_without_points_give_no_samples() {
        for picture in [Plane::filled(90, 80, 5u16), Plane::filled(1, 1, 0)] {
            assert!(curves(&picture, (1024, 768), None).unwrap().iter().all(|curve| curve.samples.is_empty()));
        }
    }
}
