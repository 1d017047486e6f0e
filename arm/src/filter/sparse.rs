//! Products with a transition of the vehicle's state over one sample of the IMU, of whose 324 elements about 60 are not
//! 0. The sums have the order of a dense product, so that the bits are the same.

use super::{Rows, VEHICLE, Vehicle};

/// The elements of a transition that are not 0: row, column and value, row by row.
pub(super) struct SparseRows {
    elements: [(usize, usize, f64); VEHICLE * VEHICLE],
    count: usize,
}

impl SparseRows {
    /// Finds the elements that are not 0.
    pub(super) fn of(matrix: &Vehicle) -> Self {
        let mut sparse = Self { elements: [(0, 0, 0.0); VEHICLE * VEHICLE], count: 0 };
        for row in 0..VEHICLE {
            for column in 0..VEHICLE {
                let value = matrix[(row, column)];
                if value != 0.0 {
                    sparse.elements[sparse.count] = (row, column, value);
                    sparse.count += 1;
                }
            }
        }
        sparse
    }

    /// Returns the product with a dense matrix on the right.
    pub(super) fn times(&self, right: &Rows) -> Rows {
        let mut product = [[0.0; VEHICLE]; VEHICLE];
        for (row, column, value) in &self.elements[..self.count] {
            product[*row].iter_mut().zip(&right[*column]).for_each(|(sum, factor)| *sum += value * factor);
        }
        product
    }
}

/// Returns the transpose of a matrix.
pub(super) fn transposed(rows: &Rows) -> Rows {
    std::array::from_fn(|row| std::array::from_fn(|column| rows[column][row]))
}
