//! Linear systems, and products of tall matrices.

use super::sightings::StateRow;
use super::{PAIR, STATES};

/// Returns a row for each state.
pub(super) fn transposed(rows: &[StateRow]) -> [[f64; PAIR]; STATES] {
    std::array::from_fn(|state| std::array::from_fn(|i| rows[i][state]))
}

/// Subtracts `product^T columns`, which is symmetric, from the covariance of the first `changed` states with the first
/// `active` ones. Four columns at a time have independent sums, which keep the pipeline of the processor filled.
pub(super) fn subtract_products(
    covariance: &mut [f64],
    product: &[StateRow],
    columns: &[StateRow],
    changed: usize,
    active: usize,
) {
    const AT_ONCE: usize = 4;
    for row in 0..changed {
        let columns_of = |(begin, end): (usize, usize)| (begin..end).step_by(AT_ONCE).map(move |first| (first, end));
        for (first, end) in [(0, row + 1), (changed, active)].into_iter().flat_map(columns_of) {
            let mut less = [-0.0; AT_ONCE];
            for (product, column) in product.iter().zip(columns) {
                let factor = product[row];
                // Beyond the last state there is nothing.
                let tail = || std::array::from_fn(|i| column.get(first + i).copied().unwrap_or_default());
                let column = column[first..].first_chunk::<AT_ONCE>().copied().unwrap_or_else(tail);
                less.iter_mut().zip(column).for_each(|(less, value)| *less += factor * value);
            }
            for (column, less) in (first..end).zip(less) {
                let value = covariance[row * STATES + column] - less;
                covariance[row * STATES + column] = value;
                covariance[column * STATES + row] = value;
            }
        }
    }
}

/// Solves `A X = B` by elimination with row pivots: `a` is `size` x `size` and is destroyed; the first `columns` of the
/// `stride` columns of `b` become `X`, both row-major. Returns `None` if `A` is singular.
pub(super) fn solve(a: &mut [f64], b: &mut [f64], size: usize, stride: usize, columns: usize) -> Option<()> {
    for i in 0..size {
        let magnitude = |row: &usize| a[row * size + i].abs();
        let pivot = (i..size).max_by(|one, other| magnitude(one).total_cmp(&magnitude(other)))?;
        if magnitude(&pivot).is_nan() || magnitude(&pivot) < 1e-12 {
            return None;
        }
        if pivot != i {
            (0..size).for_each(|j| a.swap(i * size + j, pivot * size + j));
            (0..columns).for_each(|j| b.swap(i * stride + j, pivot * stride + j));
        }
        let (upper, lower) = a.split_at_mut((i + 1) * size);
        let (b_upper, b_lower) = b.split_at_mut((i + 1) * stride);
        let (row, b_row) = (&upper[i * size..], &b_upper[i * stride..][..columns]);
        for (other, b_other) in lower.chunks_exact_mut(size).zip(b_lower.chunks_exact_mut(stride)) {
            let factor = other[i] / row[i];
            if factor != 0.0 {
                (i..size).for_each(|j| other[j] -= factor * row[j]);
                b_other.iter_mut().zip(b_row).for_each(|(value, above)| *value -= factor * above);
            }
        }
    }
    for i in (0..size).rev() {
        let (upper, lower) = b.split_at_mut((i + 1) * stride);
        let row = &mut upper[i * stride..][..columns];
        for (j, below) in (i + 1..size).zip(lower.chunks_exact(stride)) {
            let factor = a[i * size + j];
            row.iter_mut().zip(below).for_each(|(value, other)| *value -= factor * other);
        }
        row.iter_mut().for_each(|value| *value /= a[i * size + i]);
    }
    Some(())
}
