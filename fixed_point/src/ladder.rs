//! The ladder: how a float becomes a wire, one cause of error a rung.
//!
//! | rung | name | what changes |
//! |---|---|---|
//! | 0 | ideal | the sampled Gaussian, f64 |
//! | 1 | recursive | the two-sided first-order recursion, f64, whole frame, the border sample held |
//! | 2 | streaming | look-ahead both ways and look-back along rows reach `2^m - 1` samples only, f64 |
//! | 3 | coefficients | rung 2 with the coefficients rounded |
//! | 4 | fixed | rung 3 in integers: the bit-true model |
//!
//! All planes are in codes of the camera word, `0 ..= 65535`, whatever the rung; those of rung 4 are exact, for its words are
//! whole multiples of a power of two. *Approximation* is a rung against rung 0, *quantisation* against rung 2.

use rayon::prelude::*;

use hoverlock_reference::dog::Dog;
use hoverlock_reference::extractor;
use hoverlock_reference::feature::Feature;
use hoverlock_reference::maxlbp::{Layer, max_dog};
use hoverlock_reference::plane::Plane;
use hoverlock_reference::recursive::border::Border;
use hoverlock_reference::recursive::first_order;
use hoverlock_reference::smoother::Smoother;

use crate::bit_true::{BitTrue, Planes};
use crate::coefficients::CoefficientError;
use crate::design::{DesignPoint, SCALES, SMOOTHERS};
use crate::stages::{self, Cells, Stage};
use crate::worst_case;

/// One rung.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rung {
    /// 0: the sampled Gaussian.
    Ideal,
    /// 1: the two-sided recursion.
    Recursive,
    /// 2: finite reach, as it streams.
    Streaming,
    /// 3: rounded coefficients.
    Coefficients,
    /// 4: integers.
    Fixed,
}

impl Rung {
    /// From the ideal down to the wire.
    pub const ALL: [Rung; 5] = [Rung::Ideal, Rung::Recursive, Rung::Streaming, Rung::Coefficients, Rung::Fixed];

    /// `0 ..= 4`.
    pub fn number(self) -> usize {
        self as usize
    }

    /// One word, as in the table.
    pub fn name(self) -> &'static str {
        ["ideal", "recursive", "streaming", "coefficients", "fixed"][self.number()]
    }
}

/// All planes of one rung, in codes of the camera word.
#[derive(Debug, Clone, PartialEq)]
pub struct RungPlanes {
    /// `G_0 .. G_2`.
    pub smoothed: [Plane<f64>; SMOOTHERS],
    /// `d_k = G_k - G_{k+1}`; in rung 4 before it is rounded to an LSB of the DoG.
    pub signed_dog: [Plane<f64>; SCALES],
    /// `DOG_k`.
    pub dog: [Plane<f64>; SCALES],
    /// `MaxDOG_k`.
    pub max_dog: [Plane<f64>; SCALES],
}

impl RungPlanes {
    /// Everything that follows from the smoothed planes of rungs 0 to 3.
    pub fn of(smoothed: [Plane<f64>; SMOOTHERS]) -> Self {
        let signed_dog = [0, 1].map(|k| smoothed[k].zip_map(&smoothed[k + 1], |narrow, wide| narrow - wide));
        let dog = [0, 1].map(|k: usize| signed_dog[k].map(|d: &f64| d.abs()));
        let max_dog = [0, 1].map(|k: usize| max_dog(&dog[k]));
        Self { smoothed, signed_dog, dog, max_dog }
    }
}

/// What one smoother makes of a frame, in codes of the camera word.
#[derive(Debug, Clone, PartialEq)]
pub struct Smoothed {
    /// After the vertical pass: recursion and look-ahead down the columns.
    pub columns: Plane<f64>,
    /// After the horizontal pass too.
    pub rows: Plane<f64>,
}

/// The rungs of one design point.
#[derive(Debug, Clone)]
pub struct Ladder {
    design: DesignPoint,
    ideal: [Smoother; SMOOTHERS],
    recursive: [Smoother; SMOOTHERS],
    streaming: [Cells<f64>; SMOOTHERS],
    coefficients: [Cells<f64>; SMOOTHERS],
    fixed: BitTrue,
}

impl Ladder {
    /// Designs all rungs.
    ///
    /// # Errors
    /// Where a filter of one of the sigmas, or its rounding to the coefficient format, does not exist.
    pub fn new(design: &DesignPoint) -> Result<Self, CoefficientError> {
        let fixed = BitTrue::new(design)?;
        let [narrow, middle, wide] = design.sigmas;
        let streaming = |smoother: usize| {
            first_order::pole(design.sigmas[smoother]).map(|a| Cells::of_pole(a, design.look_ahead[smoother]))
        };
        Ok(Self {
            design: design.clone(),
            ideal: [Smoother::gaussian(narrow)?, Smoother::gaussian(middle)?, Smoother::gaussian(wide)?],
            recursive: [Smoother::first_order(narrow)?, Smoother::first_order(middle)?, Smoother::first_order(wide)?],
            streaming: [streaming(0)?, streaming(1)?, streaming(2)?],
            coefficients: fixed.cells().each_ref().map(|cells| cells.values(design.coefficient)),
            fixed,
        })
    }

    /// The design point.
    pub fn design(&self) -> &DesignPoint {
        &self.design
    }

    /// Rung 4 in its own integers.
    pub fn bit_true(&self) -> &BitTrue {
        &self.fixed
    }

    /// Coefficients of rung 2 (unrounded) or rungs 3 and 4 (rounded), as numbers.
    pub fn cells(&self, rung: Rung) -> Option<&[Cells<f64>; SMOOTHERS]> {
        match rung {
            Rung::Ideal | Rung::Recursive => None,
            Rung::Streaming => Some(&self.streaming),
            Rung::Coefficients | Rung::Fixed => Some(&self.coefficients),
        }
    }

    /// Smooths by one of the three smoothers of rung 2, 3 or 4 and shows every stage's output, in order, to `each`.
    ///
    /// # Panics
    /// For rungs 0 and 1, which have no stages.
    pub fn stages(
        &self,
        rung: Rung,
        smoother: usize,
        pixels: &Plane<u16>,
        mut each: impl FnMut(Stage, &Plane<f64>),
    ) -> Plane<f64> {
        let float = |cells: &Cells<f64>, each: &mut dyn FnMut(Stage, &Plane<f64>)| {
            stages::smooth(&codes(pixels), cells, |p, q, c| p + c * (q - p), each)
        };
        match rung {
            Rung::Ideal | Rung::Recursive => panic!("rung {} has no stages", rung.number()),
            Rung::Streaming => float(&self.streaming[smoother], &mut each),
            Rung::Coefficients => float(&self.coefficients[smoother], &mut each),
            Rung::Fixed => {
                let lsb = self.design.state.lsb();
                let state = self.fixed.state(pixels);
                let show = |stage, plane: &Plane<u32>| each(stage, &plane.map(|code| f64::from(*code) * lsb));
                self.fixed.smooth(smoother, &state, show).map(|code| f64::from(*code) * lsb)
            }
        }
    }

    /// What one smoother of a rung makes of a frame, after its vertical and after its horizontal pass.
    pub fn smoothed(&self, rung: Rung, smoother: usize, pixels: &Plane<u16>) -> Smoothed {
        let whole = |filter: &Smoother| {
            let frame = codes(pixels);
            // The vertical pass alone is both passes over columns that stand alone.
            Smoothed { columns: columns_only(filter, &frame), rows: filter.smooth(&frame, Border::Held) }
        };
        match rung {
            Rung::Ideal => whole(&self.ideal[smoother]),
            Rung::Recursive => whole(&self.recursive[smoother]),
            Rung::Streaming | Rung::Coefficients | Rung::Fixed => {
                let last = Stage::LookDown(self.design.look_ahead[smoother] - 1);
                let mut columns = None;
                let rows = self.stages(rung, smoother, pixels, |stage, plane| {
                    if stage == last {
                        columns = Some(plane.clone());
                    }
                });
                Smoothed { columns: columns.expect("the look-ahead is at least 1"), rows }
            }
        }
    }

    /// All planes of a rung.
    pub fn planes(&self, rung: Rung, pixels: &Plane<u16>) -> RungPlanes {
        if rung == Rung::Fixed {
            return self.in_codes(&self.fixed(pixels));
        }
        let smooth = |smoother: usize| match rung {
            Rung::Ideal => self.ideal[smoother].smooth(&codes(pixels), Border::Held),
            Rung::Recursive => self.recursive[smoother].smooth(&codes(pixels), Border::Held),
            _ => self.stages(rung, smoother, pixels, |_, _| ()),
        };
        RungPlanes::of(per_smoother(smooth))
    }

    /// All planes of rung 4 in its own integers, the three smoothers side by side.
    pub fn fixed(&self, pixels: &Plane<u16>) -> Planes {
        let state = self.fixed.state(pixels);
        self.fixed.planes_of(per_smoother(|smoother| self.fixed.smooth(smoother, &state, |_, _| ())))
    }

    /// Integer planes of this design point in codes of the camera word.
    pub fn in_codes(&self, planes: &Planes) -> RungPlanes {
        let (state, dog) = (self.design.state.lsb(), self.design.dog().lsb());
        RungPlanes {
            smoothed: planes.smoothed.each_ref().map(|plane| plane.map(|code| f64::from(*code) * state)),
            signed_dog: planes.signed_dog.each_ref().map(|plane| plane.map(|code| f64::from(*code) * state)),
            dog: planes.layers.each_ref().map(|layer| layer.dog.magnitude.map(|code| f64::from(*code) * dog)),
            max_dog: planes.layers.each_ref().map(|layer| layer.max_dog.map(|code| f64::from(*code) * dog)),
        }
    }

    /// Most a smoother of this rung can differ from the rung above, codes; `range` is the largest pixel less the smallest.
    /// Nothing for rung 0, which has none above. For rung 1 it holds where no border is in sight.
    pub fn worst_case(&self, rung: Rung, smoother: usize, range: f64) -> Option<f64> {
        let (streaming, rounded) = (&self.streaming[smoother], &self.coefficients[smoother]);
        let response = |filters: &[Smoother; SMOOTHERS]| filters[smoother].impulse_response();
        match rung {
            Rung::Ideal => None,
            Rung::Recursive => {
                Some(worst_case::response_difference(&response(&self.recursive), &response(&self.ideal)) * range)
            }
            Rung::Streaming => Some(worst_case::reach(streaming) * range),
            Rung::Coefficients => Some(worst_case::coefficient(streaming, rounded) * range),
            Rung::Fixed => Some(worst_case::rounding(rounded) * self.design.state.lsb()),
        }
    }

    /// Most `d_k` of this rung can differ from the rung above, codes, as [`Ladder::worst_case`] for its two smoothers; `DOG_k` and
    /// `MaxDOG_k` of rung 4 differ by half an LSB of the DoG more, as long as they do not saturate.
    pub fn worst_dog(&self, rung: Rung, k: usize, range: f64) -> Option<f64> {
        Some(self.worst_case(rung, k, range)? + self.worst_case(rung, k + 1, range)?)
    }

    /// All features of a rung in raster order, scale 0 before scale 1 at one pixel; thresholds in codes of the camera word.
    pub fn features(&self, planes: &RungPlanes, thresholds: [f64; SCALES]) -> Vec<Feature> {
        let layer = |k: usize| Layer {
            dog: Dog { magnitude: planes.dog[k].clone(), positive: planes.signed_dog[k].map(|d| *d >= 0.0) },
            max_dog: planes.max_dog[k].clone(),
        };
        extractor::features(&[layer(0), layer(1)], thresholds, 1.0)
    }
}

fn codes(pixels: &Plane<u16>) -> Plane<f64> {
    pixels.map(|pixel| f64::from(*pixel))
}

fn per_smoother<T: Send>(make: impl Fn(usize) -> T + Send + Sync) -> [T; SMOOTHERS] {
    let made: Vec<T> = (0..SMOOTHERS).into_par_iter().map(make).collect();
    made.try_into().ok().expect("one per smoother")
}

/// The vertical pass of a smoother: every column as a picture one pixel wide, whose rows have nothing to smooth.
fn columns_only(filter: &Smoother, frame: &Plane<f64>) -> Plane<f64> {
    let columns: Vec<Vec<f64>> = (0..frame.width())
        .into_par_iter()
        .map(|x| {
            let column: Vec<f64> = frame.rows().map(|row| row[x]).collect();
            filter.smooth_line(&column, Border::Held)
        })
        .collect();
    Plane::from_fn(frame.width(), frame.height(), |x, y| columns[x][y])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::KT27;
    use crate::format::Format;
    use crate::pictures::{Content, Picture, pictures};
    use hoverlock_reference::maxlbp::descriptor;
    use proptest::prelude::*;

    /// Design points of a sweep: other sigmas, reach and word lengths.
    fn designs() -> impl Strategy<Value = DesignPoint> {
        let sigma = 0.8..3.0f64;
        let fraction = |design: i8, low: i8, high: i8| prop_oneof![1 => Just(design), 2 => low..=high];
        let free = (
            (sigma, 1.2..2.5f64, 1.2..2.5f64),
            prop::array::uniform3(1..=7u32),
            (fraction(2, 0, 8), fraction(16, 8, 20), fraction(15, 9, 16)),
        )
            .prop_map(|((sigma, first, second), look_ahead, (state, coefficient, dog))| DesignPoint {
                sigmas: [sigma, sigma * first, sigma * first * second],
                look_ahead,
                state: Format::unsigned(16, state),
                coefficient: Format::unsigned(0, coefficient),
                dog_bits: dog as u32,
                ..KT27
            });
        prop_oneof![1 => Just(KT27), 3 => free]
    }

    /// Largest difference of two planes.
    fn distance(a: &Plane<f64>, b: &Plane<f64>) -> f64 {
        a.as_slice().iter().zip(b.as_slice()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    fn range(pixels: &Plane<u16>) -> f64 {
        let samples = pixels.as_slice().iter();
        samples.clone().max().map_or(0.0, |max| f64::from(*max)) - samples.min().map_or(0.0, |min| f64::from(*min))
    }

    /// Some 60 cells of f64 arithmetic on values up to 2^16, each off by 2^-53 of them: 5e-10 codes, with room.
    const FLOAT: f64 = 1e-8;

    fn layers(planes: &RungPlanes) -> [Layer<f64>; 2] {
        [0, 1].map(|k: usize| Layer {
            dog: Dog { magnitude: planes.dog[k].clone(), positive: planes.signed_dog[k].map(|d| *d >= 0.0) },
            max_dog: planes.max_dog[k].clone(),
        })
    }

    #[test]
    fn rungs_are_named_and_numbered_from_the_top() {
        let names = Rung::ALL.map(|rung| (rung.number(), rung.name()));
        assert_eq!(names, [(0, "ideal"), (1, "recursive"), (2, "streaming"), (3, "coefficients"), (4, "fixed")]);
    }

    #[test]
    fn frames_from_one_pixel_upward_have_all_planes() {
        let ladder = Ladder::new(&KT27).unwrap();
        for (width, height) in [(1, 1), (1, 50), (50, 1), (2, 3), (37, 37)] {
            let picture = Picture { width, height, seed: 5, content: Content::Noise { low: 0, high: 65535 } }.draw();
            for rung in Rung::ALL {
                let planes = ladder.planes(rung, &picture);
                let shapes = planes.smoothed.iter().chain(&planes.signed_dog).chain(&planes.dog).chain(&planes.max_dog);
                assert!(shapes.clone().all(|plane| (plane.width(), plane.height()) == (width, height)));
                let thresholds = [1.0; 2];
                assert!(width == 37 || ladder.features(&planes, thresholds).is_empty());
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]

        #[test]
        fn each_rung_stays_within_its_worst_case_of_the_one_above(design in designs(), picture in pictures(90)) {
            let pixels = picture.draw();
            let (width, height) = (pixels.width(), pixels.height());
            let ladder = Ladder::new(&design).unwrap();
            let range = range(&pixels);
            let rungs = Rung::ALL.map(|rung| ladder.planes(rung, &pixels));
            for rung in &Rung::ALL[1..] {
                let (above, below) = (&rungs[rung.number() - 1], &rungs[rung.number()]);
                for smoother in 0..SMOOTHERS {
                    let bound = ladder.worst_case(*rung, smoother, range).unwrap() + FLOAT;
                    let (above, below) = (&above.smoothed[smoother], &below.smoothed[smoother]);
                    if *rung == Rung::Recursive {
                        // Each pass holds its own border sample: a^(H - y) + a^(W - x) of the weight is another's.
                        let a = first_order::pole(design.sigmas[smoother]).unwrap();
                        for y in 0..height {
                            for x in 0..width {
                                let border = a.powi((height - y) as i32) + a.powi((width - x) as i32);
                                let error = (below[(x, y)] - above[(x, y)]).abs();
                                prop_assert!(error <= bound + border * range, "{error} at ({x}, {y}), {bound} + {border}");
                            }
                        }
                    } else {
                        let error = distance(above, below);
                        prop_assert!(error <= bound, "{rung:?} smoother {smoother}: {error} codes, bound {bound}");
                    }
                }
                if *rung != Rung::Recursive {
                    for k in 0..SCALES {
                        let bound = ladder.worst_dog(*rung, k, range).unwrap() + FLOAT;
                        let error = distance(&above.signed_dog[k], &below.signed_dog[k]);
                        prop_assert!(error <= bound, "{rung:?} d_{k}: {error} codes, bound {bound}");
                    }
                }
            }
        }

        #[test]
        fn bits_flip_only_where_the_margin_is_below_the_bound(
            design in designs(), mut picture in pictures(60), larger in 37..60usize,
        ) {
            (picture.width, picture.height) = (picture.width.max(larger), picture.height.max(37));
            let pixels = picture.draw();
            let ladder = Ladder::new(&design).unwrap();
            let (above, below) = (ladder.planes(Rung::Coefficients, &pixels), ladder.planes(Rung::Fixed, &pixels));
            let (half, most) = (design.dog().lsb() / 2.0, design.dog().value(i64::from(design.max_dog())));
            let bounds = [0, 1].map(|k| ladder.worst_dog(Rung::Fixed, k, 0.0).unwrap() + FLOAT);
            for (k, bound) in bounds.iter().enumerate() {
                let clipped = above.dog[k].map(|dog| dog.min(most));
                prop_assert!(distance(&clipped, &below.dog[k]) <= bound + half);
                prop_assert!(distance(&max_dog(&clipped), &below.max_dog[k]) <= bound + half);
            }
            let (float, fixed) = (layers(&above), layers(&below));
            let rings = hoverlock_reference::maxlbp::rings();
            for y in hoverlock_reference::maxima::eligible(pixels.height()) {
                for x in hoverlock_reference::maxima::eligible(pixels.width()) {
                    let (a, b) = (descriptor(&float, x, y), descriptor(&fixed, x, y));
                    for k in 0..SCALES {
                        let (maxlbp, sign) = (a.maxlbp[k] ^ b.maxlbp[k], a.sign[k] ^ b.sign[k]);
                        for (i, (dx, dy)) in rings[k].iter().enumerate() {
                            let at = (x.wrapping_add_signed(*dx as isize), y.wrapping_add_signed(*dy as isize));
                            // Both sides of the comparison may be off, by the DoG's error and its rounding; a flip where
                            // one of them saturates is the range's fault, not the rounding's.
                            let saturated = above.dog[k][(x, y)].max(above.max_dog[k][at]) >= most;
                            let margin = (above.dog[k][(x, y)] - above.max_dog[k][at]).abs();
                            prop_assert!(maxlbp >> i & 1 == 0 || saturated || margin <= 2.0 * (bounds[k] + half), "{margin}");
                            let margin = above.signed_dog[k][at].abs();
                            prop_assert!(sign >> i & 1 == 0 || margin <= bounds[k], "{margin}");
                        }
                    }
                }
            }
        }

        #[test]
        fn constants_pass_every_rung_unchanged(
            design in designs(), width in 1..80usize, height in 1..80usize, value: u16,
        ) {
            let pixels = Plane::filled(width, height, value);
            let ladder = Ladder::new(&design).unwrap();
            for rung in Rung::ALL {
                let planes = ladder.planes(rung, &pixels);
                for smoothed in &planes.smoothed {
                    prop_assert!(smoothed.as_slice().iter().all(|sample| *sample == f64::from(value)), "{rung:?}");
                }
                prop_assert!(planes.dog.iter().all(|dog| dog.as_slice().iter().all(|sample| *sample == 0.0)));
                prop_assert!(ladder.features(&planes, [design.dog().lsb(); 2]).is_empty());
            }
        }

        #[test]
        fn fixed_features_are_those_of_its_planes_in_codes(picture in pictures(90), threshold in 1u32..3000) {
            let ladder = Ladder::new(&KT27).unwrap();
            let planes = ladder.fixed(&picture.draw());
            let records: Vec<Feature> = planes.features([threshold; 2]).iter().map(Feature::from).collect();
            prop_assert_eq!(records, ladder.features(&ladder.in_codes(&planes), [f64::from(threshold) / 2.0; 2]));
        }

        #[test]
        fn stages_end_in_the_planes(design in designs(), picture in pictures(60)) {
            let pixels = picture.draw();
            let ladder = Ladder::new(&design).unwrap();
            for rung in Rung::ALL {
                let planes = ladder.planes(rung, &pixels);
                for smoother in 0..SMOOTHERS {
                    let passes = ladder.smoothed(rung, smoother, &pixels);
                    prop_assert_eq!(&passes.rows, &planes.smoothed[smoother]);
                    // Columns alone: a picture whose rows are constant is smoothed by the vertical pass only.
                    let column = Plane::from_fn(1, pixels.height(), |_, y| pixels[(0, y)]);
                    let alone = ladder.smoothed(rung, smoother, &column);
                    let first = Plane::from_fn(1, pixels.height(), |_, y| passes.columns[(0, y)]);
                    prop_assert_eq!(&alone.rows, &first);
                }
            }
        }
    }
}
