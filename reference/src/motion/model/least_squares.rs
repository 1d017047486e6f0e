//! Least-squares fits of the models in normalised coordinates.

use crate::motion::model::{Model, MotionError, Pair};
use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector2};

/// The coordinates about the centroid with a mean square distance of 2.
pub(super) struct NormalisedFrame {
    pub(super) centroid: Vector2<f64>,
    /// Factor from px; 0 if all positions coincide.
    pub(super) scale: f64,
}

/// Spread of positions, px rms, up to which they coincide; far below the accuracy of a feature position.
const MAX_COINCIDENT_RMS_PX: f64 = 1e-6;

impl NormalisedFrame {
    /// Computes centroid and scale of the weighted positions.
    ///
    /// # Errors
    /// A coordinate is not finite.
    pub(super) fn of(
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
        let scale = if rms > MAX_COINCIDENT_RMS_PX { std::f64::consts::SQRT_2 / rms } else { 0.0 };
        Ok(Self { centroid, scale })
    }

    /// Converts a position from pixels.
    pub(super) fn normalise(&self, p: Vector2<f64>) -> Vector2<f64> {
        self.scale * (p - self.centroid)
    }

    /// Returns the matrix from pixels to normalised coordinates.
    pub(super) fn normalisation(&self) -> Matrix3<f64> {
        let (s, c) = (self.scale, self.centroid);
        Matrix3::new(s, 0.0, -s * c.x, 0.0, s, -s * c.y, 0.0, 0.0, 1.0)
    }

    /// Returns the matrix from normalised coordinates to pixels.
    pub(super) fn denormalisation(&self) -> Matrix3<f64> {
        let (s, c) = (self.scale, self.centroid);
        Matrix3::new(1.0 / s, 0.0, c.x, 0.0, 1.0 / s, c.y, 0.0, 0.0, 1.0)
    }
}

/// Scatter of the pairs across a line, relative to the scatter along it, up to which they are collinear: the square of
/// 1e-5, which is 0.01 px over the diagonal of a picture.
const MAX_COLLINEAR_SCATTER: f64 = 1e-10;

/// Fits a similarity. About the centroid the translation vanishes and, with positions as complex numbers, `a + ib =
/// sum(conj(p) p') / sum |p|^2`.
pub(super) fn similarity(
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

/// Fits an affine map, `L = (sum p' p^T) (sum p p^T)^-1` about the centroid.
pub(super) fn affine(
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
    if scatter.determinant() <= MAX_COLLINEAR_SCATTER * scatter.trace().powi(2) {
        return Err(MotionError::Degenerate);
    }
    let linear = cross * scatter.try_inverse().ok_or(MotionError::Degenerate)?;
    Ok(linear.to_homogeneous())
}

/// Rounds of the reweighted homography fit; the denominator is 1 within a few per cent, so each gains two digits.
pub(super) const HOMOGRAPHY_ROUNDS: usize = 3;

/// Fits a homography: `(a x + b y + tx) - x' (g x + h y) = x'` and the same for `y'` are linear in the eight
/// parameters. `given` is the number of pairs with a positive weight.
pub(super) fn homography(
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
        // A squared pivot is the part of a parameter that is independent of the ones before it.
        if factor.l_dirty().diagonal().iter().any(|pivot| pivot * pivot <= MAX_COLLINEAR_SCATTER * scale) {
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
/// consists of these 24 sums; as a sum of outer products it would cost 128 products a pair.
#[derive(Default)]
struct Moments([[f64; 6]; 4]);

impl Moments {
    /// Adds a pair with the weight `w`.
    fn add(&mut self, w: f64, p: Vector2<f64>, q: Vector2<f64>) {
        let monomials = [1.0, p.x, p.y, p.x * p.x, p.x * p.y, p.y * p.y];
        let factors = [w, w * q.x, w * q.y, w * (q.x * q.x + q.y * q.y)];
        for (sums, factor) in self.0.iter_mut().zip(factors) {
            for (sum, monomial) in sums.iter_mut().zip(monomials) {
                *sum += factor * monomial;
            }
        }
    }

    /// Returns the normal matrix and the right-hand side.
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

/// Returns `true` if three of four positions are collinear in either picture: they do not determine a homography.
fn has_three_on_a_line(
    pairs: &[Pair],
    weight: impl Fn(usize) -> f64,
    normal: impl Fn(&Pair) -> (Vector2<f64>, Vector2<f64>),
) -> bool {
    let mut positions = [(Vector2::zeros(), Vector2::zeros()); 4];
    let counted = (0..pairs.len()).filter(|&i| weight(i) > 0.0).map(|i| normal(&pairs[i]));
    positions.iter_mut().zip(counted).for_each(|(position, pair)| *position = pair);
    let flat =
        |a: Vector2<f64>, b: Vector2<f64>, c: Vector2<f64>| (b - a).perp(&(c - a)).powi(2) <= MAX_COLLINEAR_SCATTER;
    (0..positions.len()).any(|left_out| {
        let mut three = positions.iter().enumerate().filter(|(i, _)| *i != left_out).map(|(_, position)| position);
        match (three.next(), three.next(), three.next()) {
            (Some(a), Some(b), Some(c)) => flat(a.0, b.0, c.0) || flat(a.1, b.1, c.1),
            _ => true,
        }
    })
}
