//! Motion of the picture: `p' = H p` in homogeneous coordinates, `p` a pixel of REF, `p'` the same ground in CUR.
//!
//! | model | `H` | parameters | minimal pairs |
//! |---|---|---|---|
//! | shift | `[1 0 tx; 0 1 ty; 0 0 1]` | 2 | 1 |
//! | similarity | `[a -b tx; b a ty; 0 0 1]` | 4 | 2 |
//! | affine | `[a b tx; c d ty; 0 0 1]` | 6 | 3 |
//! | homography | `[a b tx; c d ty; g h 1]` | 8 | 4 |
//!
//! Coordinates are pixels, `(0, 0)` the centre of the top-left pixel, `x` right, `y` down. Every fit minimises the
//! weighted transfer error `sum w |p' - H p|^2` (px^2), in coordinates moved to the weighted centroid and scaled to a
//! mean square distance of 2 (Hartley, 1997, "In defense of the eight-point algorithm"), so that the normal equations
//! are well conditioned. The homography's error is not linear in its parameters; its equations, multiplied by the
//! denominator, are, and weights of one over the last denominator squared bring pixels back. The model is exact at the
//! minimal number of pairs.
//!
//! A camera above the ground never sees it mirrored or from behind. A fit with a negative determinant, or with a
//! denominator that changes its sign between the pairs, is therefore refused like a degenerate sample.

use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector2, Vector3};

/// Motion model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Model {
    /// Two parameters: a translation.
    Shift,
    /// Four: translation, rotation, scale.
    Similarity,
    /// Six: a linear map and a translation.
    Affine,
    /// Eight: the motion of a plane between two views.
    Homography,
}

/// Positions of the same ground point in two pictures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Position in REF, px.
    pub reference: Vector2<f64>,
    /// Position in CUR, px.
    pub current: Vector2<f64>,
}

/// Why there is no fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum MotionError {
    /// Fewer pairs with a positive weight than the model has freedoms.
    #[error("the model needs {needed} pairs, not {given}")]
    TooFew {
        /// Pairs the model takes.
        needed: usize,
        /// Pairs with a positive weight.
        given: usize,
    },
    /// The pairs are degenerate (one position or one line), or the map mirrors the picture.
    #[error("the pairs do not determine the model")]
    Degenerate,
    /// As many weights as pairs are needed, all finite and none negative; coordinates are finite.
    #[error("weights and coordinates must be finite, weights not negative and as many as pairs")]
    NotFinite,
}

impl Model {
    /// Pairs that determine the model.
    pub fn minimal_pairs(self) -> usize {
        match self {
            Self::Shift => 1,
            Self::Similarity => 2,
            Self::Affine => 3,
            Self::Homography => 4,
        }
    }

    /// Free parameters, two a pair.
    pub fn parameters(self) -> usize {
        2 * self.minimal_pairs()
    }

    /// Least squares over all pairs, each counted once; exact for the minimal number.
    ///
    /// # Errors
    /// Where there are too few pairs or they do not determine the model.
    pub fn fit(self, pairs: &[Pair]) -> Result<Matrix3<f64>, MotionError> {
        self.fit_by(pairs, |_| 1.0, HOMOGRAPHY_ROUNDS)
    }

    /// Least squares with a weight for each pair; weight 0 leaves a pair out.
    ///
    /// # Errors
    /// As [`Model::fit`], and where weights are negative, not finite or not as many as pairs.
    pub fn fit_weighted(self, pairs: &[Pair], weights: &[f64]) -> Result<Matrix3<f64>, MotionError> {
        if weights.len() != pairs.len() || weights.iter().any(|w| !w.is_finite() || *w < 0.0) {
            return Err(MotionError::NotFinite);
        }
        self.fit_by(pairs, |i| weights[i], HOMOGRAPHY_ROUNDS)
    }

    /// A single round of the fit, for a caller that iterates: `weights` already contain one over the square of each
    /// pair's denominator under the motion before.
    ///
    /// # Errors
    /// As [`Model::fit_weighted`].
    pub fn fit_round(self, pairs: &[Pair], weights: &[f64]) -> Result<Matrix3<f64>, MotionError> {
        if weights.len() != pairs.len() || weights.iter().any(|w| !w.is_finite() || *w < 0.0) {
            return Err(MotionError::NotFinite);
        }
        self.fit_by(pairs, |i| weights[i], 1)
    }

    fn fit_by(self, pairs: &[Pair], weight: impl Fn(usize) -> f64, rounds: usize) -> Result<Matrix3<f64>, MotionError> {
        let given = (0..pairs.len()).filter(|&i| weight(i) > 0.0).count();
        if given < self.minimal_pairs() {
            return Err(MotionError::TooFew { needed: self.minimal_pairs(), given });
        }
        let from = Frame::of(pairs, &weight, |pair| pair.reference)?;
        let to = Frame::of(pairs, &weight, |pair| pair.current)?;
        if self == Self::Shift {
            let t = to.centroid - from.centroid;
            return Ok(Matrix3::new(1.0, 0.0, t.x, 0.0, 1.0, t.y, 0.0, 0.0, 1.0));
        }
        if from.scale == 0.0 || to.scale == 0.0 {
            return Err(MotionError::Degenerate);
        }
        let normal = |pair: &Pair| (from.enter(pair.reference), to.enter(pair.current));
        let h = match self {
            Self::Shift | Self::Similarity => similarity(pairs, &weight, normal),
            Self::Affine => affine(pairs, &weight, normal)?,
            Self::Homography => homography(pairs, &weight, normal, given, rounds)?,
        };
        let h = to.leave() * h * from.matrix();
        let h = h / h[(2, 2)];
        let sound = h.iter().all(|v| v.is_finite()) && h.determinant() > 0.0;
        if sound { Ok(h) } else { Err(MotionError::Degenerate) }
    }
}

/// The position mapped by `H`; `None` where it is at infinity or behind the camera.
pub fn transfer(h: &Matrix3<f64>, p: Vector2<f64>) -> Option<Vector2<f64>> {
    let q = h * Vector3::new(p.x, p.y, 1.0);
    (q.z > 0.0).then(|| Vector2::new(q.x / q.z, q.y / q.z))
}

/// Squared transfer error of a pair, px^2; infinite where the position is not seen.
pub fn squared_error(h: &Matrix3<f64>, pair: &Pair) -> f64 {
    transfer(h, pair.reference).map_or(f64::INFINITY, |q| (pair.current - q).norm_squared())
}

/// Coordinates about the centroid with a mean square distance of 2.
struct Frame {
    centroid: Vector2<f64>,
    /// 0 where all positions coincide.
    scale: f64,
}

/// Positions closer together than this (px rms) count as one. It is far below the accuracy of a feature position.
const ONE_PLACE: f64 = 1e-6;

impl Frame {
    fn of(
        pairs: &[Pair],
        weight: impl Fn(usize) -> f64,
        position: impl Fn(&Pair) -> Vector2<f64>,
    ) -> Result<Self, MotionError> {
        let mut total = 0.0;
        let mut sum = Vector2::zeros();
        for (i, pair) in pairs.iter().enumerate() {
            total += weight(i);
            sum += weight(i) * position(pair);
        }
        let centroid = sum / total;
        let spread: f64 =
            pairs.iter().enumerate().map(|(i, pair)| weight(i) * (position(pair) - centroid).norm_squared()).sum();
        let rms = (spread / total).sqrt();
        if !rms.is_finite() {
            return Err(MotionError::NotFinite);
        }
        let scale = if rms > ONE_PLACE { std::f64::consts::SQRT_2 / rms } else { 0.0 };
        Ok(Self { centroid, scale })
    }

    fn enter(&self, p: Vector2<f64>) -> Vector2<f64> {
        self.scale * (p - self.centroid)
    }

    fn matrix(&self) -> Matrix3<f64> {
        let (s, c) = (self.scale, self.centroid);
        Matrix3::new(s, 0.0, -s * c.x, 0.0, s, -s * c.y, 0.0, 0.0, 1.0)
    }

    fn leave(&self) -> Matrix3<f64> {
        let (s, c) = (self.scale, self.centroid);
        Matrix3::new(1.0 / s, 0.0, c.x, 0.0, 1.0 / s, c.y, 0.0, 0.0, 1.0)
    }
}

/// The part of the scatter across a line of pairs, relative to the part along it, below which they count as one line:
/// 1e-10 is a millimetre of a pixel on a picture's diagonal.
const ON_A_LINE: f64 = 1e-10;

/// About the centroid the translation drops out and, with positions as complex numbers, `a + ib = sum(conj(p) p') / sum
/// |p|^2`.
fn similarity(
    pairs: &[Pair],
    weight: impl Fn(usize) -> f64,
    normal: impl Fn(&Pair) -> (Vector2<f64>, Vector2<f64>),
) -> Matrix3<f64> {
    let (mut a, mut b, mut scatter) = (0.0, 0.0, 0.0);
    for (i, pair) in pairs.iter().enumerate() {
        let (w, (p, q)) = (weight(i), normal(pair));
        a += w * p.dot(&q);
        b += w * p.perp(&q);
        scatter += w * p.norm_squared();
    }
    let (a, b) = (a / scatter, b / scatter);
    Matrix3::new(a, -b, 0.0, b, a, 0.0, 0.0, 0.0, 1.0)
}

/// `L = (sum p' p^T) (sum p p^T)^-1` about the centroid.
fn affine(
    pairs: &[Pair],
    weight: impl Fn(usize) -> f64,
    normal: impl Fn(&Pair) -> (Vector2<f64>, Vector2<f64>),
) -> Result<Matrix3<f64>, MotionError> {
    let (mut cross, mut scatter) = (Matrix2::zeros(), Matrix2::zeros());
    for (i, pair) in pairs.iter().enumerate() {
        let (w, (p, q)) = (weight(i), normal(pair));
        cross += w * q * p.transpose();
        scatter += w * p * p.transpose();
    }
    if scatter.determinant() <= ON_A_LINE * scatter.trace().powi(2) {
        return Err(MotionError::Degenerate);
    }
    let linear = cross * scatter.try_inverse().ok_or(MotionError::Degenerate)?;
    Ok(linear.to_homogeneous())
}

/// Rounds of the reweighted homography fit; the denominator is 1 within some per cent, so each gains two digits.
const HOMOGRAPHY_ROUNDS: usize = 3;

/// `(a x + b y + tx) - x' (g x + h y) = x'` and the same for `y'`: linear in the eight parameters.
fn homography(
    pairs: &[Pair],
    weight: impl Fn(usize) -> f64,
    normal: impl Fn(&Pair) -> (Vector2<f64>, Vector2<f64>),
    given: usize,
    rounds: usize,
) -> Result<Matrix3<f64>, MotionError> {
    let exact = given == Model::Homography.minimal_pairs();
    if exact && has_three_on_a_line(pairs, &weight, &normal) {
        return Err(MotionError::Degenerate);
    }
    let mut bottom = (0.0, 0.0);
    let mut h = Matrix3::identity();
    for _ in 0..if exact { 1 } else { rounds } {
        let mut moments = Moments::default();
        for (i, pair) in pairs.iter().enumerate() {
            let (p, q) = normal(pair);
            let denominator = bottom.0 * p.x + bottom.1 * p.y + 1.0;
            moments.add(weight(i) / (denominator * denominator), p, q);
        }
        let (normal_matrix, right) = moments.normal_equations();
        let scale = normal_matrix.trace();
        let factor = normal_matrix.cholesky().ok_or(MotionError::Degenerate)?;
        // The squared pivots are what each parameter has left when the others are taken out of it.
        if factor.l_dirty().diagonal().iter().any(|pivot| pivot * pivot <= ON_A_LINE * scale) {
            return Err(MotionError::Degenerate);
        }
        let [a, b, tx, c, d, ty, g, k] = factor.solve(&right).into();
        h = Matrix3::new(a, b, tx, c, d, ty, g, k, 1.0);
        bottom = (g, k);
        let behind = |(i, pair): (usize, &Pair)| {
            let p = normal(pair).0;
            weight(i) > 0.0 && g * p.x + k * p.y + 1.0 <= 0.0
        };
        if pairs.iter().enumerate().any(behind) {
            return Err(MotionError::Degenerate);
        }
    }
    Ok(h)
}

/// Sums over the pairs of `w`, `w qx`, `w qy`, `w |q|^2` (rows) times `1, x, y, x^2, x y, y^2` (columns), `(x, y)` the
/// position `p` in REF.
///
/// Each pair gives two equations, `[P 0 -qx (x, y)]` and `[0 P -qy (x, y)]` with `P = (x, y, 1)`. Their normal matrix
/// has no other sums than these 24, where its outer products would be 128 products a pair.
#[derive(Default)]
struct Moments([[f64; 6]; 4]);

impl Moments {
    fn add(&mut self, w: f64, p: Vector2<f64>, q: Vector2<f64>) {
        let monomials = [1.0, p.x, p.y, p.x * p.x, p.x * p.y, p.y * p.y];
        let factors = [w, w * q.x, w * q.y, w * (q.x * q.x + q.y * q.y)];
        for (sums, factor) in self.0.iter_mut().zip(factors) {
            for (sum, monomial) in sums.iter_mut().zip(monomials) {
                *sum += factor * monomial;
            }
        }
    }

    fn normal_equations(&self) -> (SMatrix<f64, 8, 8>, SVector<f64, 8>) {
        // Sums of P P^T; the first two columns are those of P (x, y)^T.
        let [ground, qx, qy, q2] = self.0.map(|[one, x, y, xx, xy, yy]| Matrix3::new(xx, xy, x, xy, yy, y, x, y, one));
        let mut matrix = SMatrix::<f64, 8, 8>::zeros();
        matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&ground);
        matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&ground);
        for (row, sums) in [(0, &qx), (3, &qy)] {
            let beside = -sums.fixed_columns::<2>(0);
            matrix.fixed_view_mut::<3, 2>(row, 6).copy_from(&beside);
            matrix.fixed_view_mut::<2, 3>(6, row).copy_from(&beside.transpose());
        }
        matrix.fixed_view_mut::<2, 2>(6, 6).copy_from(&q2.fixed_view::<2, 2>(0, 0));
        let right = [qx[(0, 2)], qx[(1, 2)], qx[(2, 2)], qy[(0, 2)], qy[(1, 2)], qy[(2, 2)], -q2[(0, 2)], -q2[(1, 2)]];
        (matrix, SVector::from(right))
    }
}

/// Of four positions three on one line leave the homography open, in either picture.
fn has_three_on_a_line(
    pairs: &[Pair],
    weight: impl Fn(usize) -> f64,
    normal: impl Fn(&Pair) -> (Vector2<f64>, Vector2<f64>),
) -> bool {
    let mut positions = [(Vector2::zeros(), Vector2::zeros()); 4];
    let counted = (0..pairs.len()).filter(|&i| weight(i) > 0.0).map(|i| normal(&pairs[i]));
    positions.iter_mut().zip(counted).for_each(|(position, pair)| *position = pair);
    let flat = |a: Vector2<f64>, b: Vector2<f64>, c: Vector2<f64>| (b - a).perp(&(c - a)).powi(2) <= ON_A_LINE;
    (0..positions.len()).any(|left_out| {
        let mut three = positions.iter().enumerate().filter(|(i, _)| *i != left_out).map(|(_, position)| position);
        match (three.next(), three.next(), three.next()) {
            (Some(a), Some(b), Some(c)) => flat(a.0, b.0, c.0) || flat(a.1, b.1, c.1),
            _ => true,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MODELS: [Model; 4] = [Model::Shift, Model::Similarity, Model::Affine, Model::Homography];

    /// A random motion of the model: up to 15 degrees, 20 % of scale, 300 px, 5 % of shear, and a
    /// perspective that changes the scale by up to 5 % over 1000 px.
    fn motion(model: Model) -> impl Strategy<Value = Matrix3<f64>> {
        let shear = if model >= Model::Affine { 0.05 } else { 0.0 };
        let bottom = if model == Model::Homography { 5e-5 } else { 0.0 };
        let turn = if model == Model::Shift { 0.0 } else { 1.0 };
        let unit = || -1.0..1.0f64;
        (unit(), unit(), (unit(), unit()), (unit(), unit()), (unit(), unit())).prop_map(
            move |(angle, scale, (tx, ty), (s0, s1), (g, h))| {
                let (sin, cos) = (turn * 0.26 * angle).sin_cos();
                let k = 1.0 + turn * 0.2 * scale;
                let (s0, s1) = (shear * s0, shear * s1);
                Matrix3::new(
                    k * cos + s0,
                    -k * sin + s1,
                    300.0 * tx,
                    k * sin + s1,
                    k * cos - s0,
                    300.0 * ty,
                    bottom * g,
                    bottom * h,
                    1.0,
                )
            },
        )
    }

    fn positions(count: impl Into<prop::collection::SizeRange>) -> impl Strategy<Value = Vec<Vector2<f64>>> {
        prop::collection::vec((0.0..1024.0f64, 0.0..768.0f64).prop_map(|(x, y)| Vector2::new(x, y)), count)
    }

    fn pairs_under(h: &Matrix3<f64>, positions: &[Vector2<f64>]) -> Vec<Pair> {
        positions.iter().map(|&p| Pair { reference: p, current: transfer(h, p).unwrap() }).collect()
    }

    /// A triangle over the picture whose smallest height is at least 20 px, so that rounding is not magnified beyond
    /// the tolerance below.
    fn well_spread(positions: &[Vector2<f64>]) -> bool {
        let n = positions.len();
        let far = (0..n).all(|i| (0..i).all(|j| (positions[i] - positions[j]).norm() > 20.0));
        let wide = |i: usize, j: usize, k: usize| {
            let longest = (positions[i] - positions[j]).norm().max((positions[j] - positions[k]).norm());
            (positions[j] - positions[i]).perp(&(positions[k] - positions[i])).abs() > 20.0 * longest
        };
        far && (0..n).all(|i| (0..i).all(|j| (0..j).all(|k| wide(i, j, k))))
    }

    fn any_model_with_motion() -> impl Strategy<Value = (Model, Matrix3<f64>)> {
        prop::sample::select(MODELS.to_vec()).prop_flat_map(|model| motion(model).prop_map(move |h| (model, h)))
    }

    proptest! {
        #[test]
        fn minimal_pairs_are_met_exactly((model, h) in any_model_with_motion(), four in positions(4)) {
            let positions = &four[..model.minimal_pairs()];
            prop_assume!(well_spread(positions));
            let pairs = pairs_under(&h, positions);
            let found = model.fit(&pairs).unwrap();
            for pair in &pairs {
                prop_assert!(squared_error(&found, pair) < 1e-12, "{model:?} {found} {h}");
            }
        }

        #[test]
        fn many_exact_pairs_give_the_motion_back(
            (model, h) in any_model_with_motion(), positions in positions(12..40),
        ) {
            let pairs = pairs_under(&h, &positions);
            let found = model.fit(&pairs).unwrap();
            for corner in [(0.0, 0.0), (1023.0, 0.0), (0.0, 767.0), (1023.0, 767.0)] {
                let corner = Vector2::new(corner.0, corner.1);
                let miss = (transfer(&found, corner).unwrap() - transfer(&h, corner).unwrap()).norm();
                prop_assert!(miss < 1e-6, "{model:?} misses a corner by {miss}");
            }
        }

        /// No small change of a parameter lowers the weighted sum: the fit is the minimum, weights included.
        #[test]
        fn least_squares_is_a_minimum(
            (model, h) in any_model_with_motion(),
            positions in positions(12..30),
            noise in prop::collection::vec((-1.0..1.0f64, -1.0..1.0f64, 0.1..2.0f64), 30),
        ) {
            let mut pairs = pairs_under(&h, &positions);
            for (pair, n) in pairs.iter_mut().zip(&noise) {
                pair.current += Vector2::new(n.0, n.1);
            }
            let weights: Vec<f64> = noise.iter().take(pairs.len()).map(|n| n.2).collect();
            let cost = |h: &Matrix3<f64>| -> f64 {
                pairs.iter().zip(&weights).map(|(pair, w)| w * squared_error(h, pair)).sum()
            };
            let found = model.fit_weighted(&pairs, &weights).unwrap();
            let least = cost(&found);
            let mut steps = vec![(0, 2, 0.1), (1, 2, 0.1)];
            if model >= Model::Affine {
                steps.extend([(0, 0, 1e-3), (0, 1, 1e-3), (1, 0, 1e-3), (1, 1, 1e-3)]);
            }
            for (row, column, step) in steps {
                for step in [step, -step] {
                    let mut near = found;
                    near[(row, column)] += step;
                    let near = cost(&near);
                    prop_assert!(near > least, "{model:?}: {near} at ({row}, {column}) {step} under {least}");
                }
            }
            if model == Model::Similarity {
                for turn in [Matrix3::new(1.001, 0.0, 0.0, 0.0, 1.001, 0.0, 0.0, 0.0, 1.0),
                             Matrix3::new(1.0, -1e-3, 0.0, 1e-3, 1.0, 0.0, 0.0, 0.0, 1.0)] {
                    prop_assert!(cost(&(turn * found)) > least);
                    prop_assert!(cost(&(turn.try_inverse().unwrap() * found)) > least);
                }
            }
        }

        #[test]
        fn weight_zero_leaves_out(h in motion(Model::Affine), positions in positions(12..20), wild in positions(3)) {
            let mut pairs = pairs_under(&h, &positions);
            let mut weights = vec![1.0; pairs.len()];
            pairs.extend(wild.iter().map(|&p| Pair { reference: p, current: Vector2::new(p.y, -p.x) }));
            weights.resize(pairs.len(), 0.0);
            for model in MODELS {
                let left_out = model.fit_weighted(&pairs, &weights).unwrap();
                let absent = model.fit(&pairs[..positions.len()]).unwrap();
                prop_assert!((left_out - absent).norm() < 1e-9, "{model:?} {left_out} {absent}");
            }
        }
    }

    /// A strong perspective, in a square of side 2 with noise of 0.01: denominators from 0.4 to 1.6, so that the
    /// equations as they are would weigh some pairs 16 times as much as others. The minimum is found here by
    /// Gauss-Newton on all eight parameters.
    #[test]
    fn the_homography_minimises_the_transfer_error() {
        let truth = Matrix3::new(1.1, 0.1, 0.2, -0.1, 0.9, -0.1, 0.35, -0.25, 1.0);
        let spread = |i: u32, step: f64| 2.0 * (f64::from(i) * step).fract() - 1.0;
        let pairs: Vec<Pair> = (0..60)
            .map(|i| {
                let reference = Vector2::new(spread(i, 0.618_034), spread(i, 0.414_214));
                let noise = 0.01 * Vector2::new(spread(i, 0.732_051), spread(i, 0.236_068));
                Pair { reference, current: transfer(&truth, reference).unwrap() + noise }
            })
            .collect();
        let cost = |h: &Matrix3<f64>| pairs.iter().map(|pair| squared_error(h, pair)).sum::<f64>();
        let found = Model::Homography.fit(&pairs).unwrap();
        let mut least = found;
        for _ in 0..10 {
            let (mut normal, mut gradient) = (SMatrix::<f64, 8, 8>::zeros(), SVector::<f64, 8>::zeros());
            for pair in &pairs {
                let position = |h: &Matrix3<f64>| transfer(h, pair.reference).unwrap();
                let slope = SMatrix::<f64, 2, 8>::from_fn(|axis, k| {
                    let mut near = least;
                    near[(k / 3, k % 3)] += 1e-6;
                    (position(&near)[axis] - position(&least)[axis]) / 1e-6
                });
                normal += slope.transpose() * slope;
                gradient += slope.transpose() * (pair.current - position(&least));
            }
            let step = normal.cholesky().unwrap().solve(&gradient);
            for k in 0..8 {
                least[(k / 3, k % 3)] += step[k];
            }
        }
        let (found, least) = (cost(&found), cost(&least));
        assert!(least < 0.01 && found <= 1.001 * least, "{found} over {least}");
    }

    fn pair(reference: (f64, f64), current: (f64, f64)) -> Pair {
        Pair { reference: Vector2::new(reference.0, reference.1), current: Vector2::new(current.0, current.1) }
    }

    #[test]
    fn degenerate_samples_are_refused() {
        let still = |x: f64, y: f64| pair((x, y), (x, y));
        let one_place = [still(5.0, 5.0); 4];
        let line: Vec<Pair> = (0..6).map(|i| still(10.0 * f64::from(i), 20.0 * f64::from(i))).collect();
        let three_on_a_line = [still(0.0, 0.0), still(100.0, 0.0), still(200.0, 0.0), still(50.0, 90.0)];
        for model in [Model::Similarity, Model::Affine, Model::Homography] {
            assert_eq!(model.fit(&one_place), Err(MotionError::Degenerate), "{model:?}");
        }
        for model in [Model::Affine, Model::Homography] {
            assert_eq!(model.fit(&line), Err(MotionError::Degenerate), "{model:?}");
        }
        assert_eq!(Model::Homography.fit(&three_on_a_line), Err(MotionError::Degenerate));
        for turn in 0..50 {
            // On a line in CUR only, at any angle: rounding alone decides the sign of the determinant.
            let (s, c) = (0.1 * f64::from(turn)).sin_cos();
            let on_line = |t: f64| (100.0 + c * t, 50.0 + s * t);
            let fold = [
                pair((0.0, 0.0), on_line(0.0)),
                pair((100.0, 3.0), on_line(70.0)),
                pair((180.0, 90.0), on_line(130.0)),
                pair((30.0, 90.0), (100.0 - 60.0 * s, 50.0 + 60.0 * c)),
            ];
            assert_eq!(Model::Homography.fit(&fold), Err(MotionError::Degenerate), "{turn}");
        }
        assert_eq!(
            Model::Affine.fit(&line[..2]),
            Err(MotionError::TooFew { needed: 3, given: 2 }),
            "two pairs cannot make an affine map"
        );
    }

    #[test]
    fn a_mirroring_map_is_refused() {
        let mirrored = [
            pair((0.0, 0.0), (0.0, 0.0)),
            pair((100.0, 0.0), (-100.0, 0.0)),
            pair((0.0, 100.0), (0.0, 100.0)),
            pair((90.0, 80.0), (-90.0, 80.0)),
        ];
        assert_eq!(Model::Affine.fit(&mirrored), Err(MotionError::Degenerate));
        assert_eq!(Model::Homography.fit(&mirrored), Err(MotionError::Degenerate));
    }

    #[test]
    fn invalid_weights_and_coordinates_are_refused() {
        let pairs = [pair((0.0, f64::NAN), (1.0, 1.0)), pair((9.0, 1.0), (8.0, 1.0))];
        assert_eq!(Model::Similarity.fit(&pairs), Err(MotionError::NotFinite));
        let pairs = [pair((0.0, 0.0), (1.0, 1.0)), pair((9.0, 1.0), (8.0, 1.0))];
        assert_eq!(Model::Shift.fit_weighted(&pairs, &[1.0]), Err(MotionError::NotFinite));
        assert_eq!(Model::Shift.fit_weighted(&pairs, &[1.0, -1.0]), Err(MotionError::NotFinite));
    }
}
