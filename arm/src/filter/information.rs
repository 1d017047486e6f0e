//! The sum of the information of sightings, `A += J^T W J`, four at a time: an element of `A` is loaded and stored once
//! for four of them. Each element still has its terms in their order, so that the bits are those of one at a time.

use super::PAIR;
use nalgebra::SMatrix;

/// Sightings that are added together.
const AT_ONCE: usize = 4;

/// For each state of a pair, the columns of the sightings side by side.
type Columns = [[[f64; 2]; AT_ONCE]; PAIR];

/// Sightings that are not yet added.
pub(super) struct InformationBatch {
    /// `J`.
    by: Columns,
    /// `W J`.
    weighted: Columns,
    count: usize,
}

impl InformationBatch {
    pub(super) fn new() -> Self {
        Self { by: [[[0.0; 2]; AT_ONCE]; PAIR], weighted: [[[0.0; 2]; AT_ONCE]; PAIR], count: 0 }
    }

    /// Takes a sighting, and adds four to the upper triangle of `information` once they are complete.
    pub(super) fn push(
        &mut self,
        by: &SMatrix<f64, 2, PAIR>,
        weighted: &SMatrix<f64, 2, PAIR>,
        information: &mut [[f64; PAIR]; PAIR],
    ) {
        for (columns, one) in [(&mut self.by, by), (&mut self.weighted, weighted)] {
            columns.iter_mut().zip(&one.data.0).for_each(|(columns, column)| columns[self.count] = *column);
        }
        self.count += 1;
        if self.count == AT_ONCE {
            for (i, row) in information.iter_mut().enumerate() {
                let by = &self.by[i];
                for (value, weighted) in row[i..].iter_mut().zip(&self.weighted[i..]) {
                    for k in 0..AT_ONCE {
                        *value += by[k][0] * weighted[k][0] + by[k][1] * weighted[k][1];
                    }
                }
            }
            self.count = 0;
        }
    }

    /// Adds the sightings that remain.
    pub(super) fn finish(self, information: &mut [[f64; PAIR]; PAIR]) {
        for (i, row) in information.iter_mut().enumerate() {
            for (value, weighted) in row[i..].iter_mut().zip(&self.weighted[i..]) {
                for (by, weighted) in self.by[i].iter().zip(weighted).take(self.count) {
                    *value += by[0] * weighted[0] + by[1] * weighted[1];
                }
            }
        }
    }
}
