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
        let smoothed = per_smoother(smooth);
        let signed_dog = [0, 1].map(|k| smoothed[k].zip_map(&smoothed[k + 1], |narrow, wide| narrow - wide));
        let dog = [0, 1].map(|k: usize| signed_dog[k].map(|d: &f64| d.abs()));
        let max_dog = [0, 1].map(|k: usize| max_dog(&dog[k]));
        RungPlanes { smoothed, signed_dog, dog, max_dog }
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
