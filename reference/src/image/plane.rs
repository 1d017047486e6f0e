//! `I(x, y)`: a two-dimensional array of samples, row-major, `x` the column, `y` the row, `(0, 0)` the top left.

use std::ops::{Index, IndexMut};

/// An error of making a plane from samples, or of cropping one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PlaneError {
    /// The number of samples is not `width * height`.
    #[error("a plane of {width} x {height} holds {} samples, not {samples}", width * height)]
    Shape {
        /// Requested number of columns.
        width: usize,
        /// Requested number of rows.
        height: usize,
        /// Number of samples given.
        samples: usize,
    },
    /// The width or the height is 0.
    #[error("a plane needs at least one row and one column, not {width} x {height}")]
    Empty {
        /// Requested number of columns.
        width: usize,
        /// Requested number of rows.
        height: usize,
    },
    /// A crop extends outside the plane.
    #[error("the crop {width} x {height} at ({x}, {y}) leaves the plane")]
    Crop {
        /// Leftmost column of the crop.
        x: usize,
        /// Topmost row of the crop.
        y: usize,
        /// Requested number of columns.
        width: usize,
        /// Requested number of rows.
        height: usize,
    },
}

/// A `width` x `height` array of samples, never empty, without padding between rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plane<T> {
    width: usize,
    height: usize,
    samples: Vec<T>,
}

impl<T> Plane<T> {
    /// Makes a plane from samples in raster order.
    ///
    /// # Errors
    /// The plane would be empty, or the number of samples is not `width * height`.
    pub fn from_vec(width: usize, height: usize, samples: Vec<T>) -> Result<Self, PlaneError> {
        if width == 0 || height == 0 {
            return Err(PlaneError::Empty { width, height });
        }
        if width.checked_mul(height) != Some(samples.len()) {
            return Err(PlaneError::Shape { width, height, samples: samples.len() });
        }
        Ok(Self { width, height, samples })
    }

    /// Returns the plane whose sample at `(x, y)` is `f(x, y)`.
    ///
    /// # Panics
    /// If `width` or `height` is 0.
    pub fn from_fn(width: usize, height: usize, mut f: impl FnMut(usize, usize) -> T) -> Self {
        assert!(width > 0 && height > 0, "a plane needs at least one row and one column");
        let mut samples = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                samples.push(f(x, y));
            }
        }
        Self { width, height, samples }
    }

    /// Returns the number of columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Returns the number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Returns all samples in raster order.
    pub fn as_slice(&self) -> &[T] {
        &self.samples
    }

    /// Returns all samples in raster order, writable.
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        &mut self.samples
    }

    /// Converts the plane into its samples in raster order.
    pub fn into_vec(self) -> Vec<T> {
        self.samples
    }

    /// Returns row `y`.
    pub fn row(&self, y: usize) -> &[T] {
        &self.samples[y * self.width..(y + 1) * self.width]
    }

    /// Returns row `y`, writable.
    pub fn row_mut(&mut self, y: usize) -> &mut [T] {
        &mut self.samples[y * self.width..(y + 1) * self.width]
    }

    /// Iterates over the rows from top to bottom.
    pub fn rows(&self) -> std::slice::ChunksExact<'_, T> {
        self.samples.chunks_exact(self.width)
    }

    /// Applies `f` to every sample.
    pub fn map<U>(&self, f: impl FnMut(&T) -> U) -> Plane<U> {
        Plane { width: self.width, height: self.height, samples: self.samples.iter().map(f).collect() }
    }

    /// Applies `f` to every pair of samples of two planes of the same shape.
    ///
    /// # Panics
    /// If the shapes differ.
    pub fn zip_map<U, V>(&self, other: &Plane<U>, mut f: impl FnMut(&T, &U) -> V) -> Plane<V> {
        assert_eq!((self.width, self.height), (other.width, other.height), "planes of different shape");
        let samples = self.samples.iter().zip(&other.samples).map(|(a, b)| f(a, b)).collect();
        Plane { width: self.width, height: self.height, samples }
    }
}

impl<T: Clone> Plane<T> {
    /// Returns a plane of one value.
    ///
    /// # Panics
    /// If `width` or `height` is 0.
    pub fn filled(width: usize, height: usize, value: T) -> Self {
        assert!(width > 0 && height > 0, "a plane needs at least one row and one column");
        Self { width, height, samples: vec![value; width * height] }
    }

    /// Copies the part of `width` x `height` samples whose top left sample is at `(x, y)`.
    ///
    /// # Errors
    /// The part is empty or extends outside the plane.
    pub fn crop(&self, x: usize, y: usize, width: usize, height: usize) -> Result<Self, PlaneError> {
        if width == 0 || height == 0 {
            return Err(PlaneError::Empty { width, height });
        }
        let fits = |start: usize, len: usize, whole: usize| start.checked_add(len).is_some_and(|end| end <= whole);
        if !fits(x, width, self.width) || !fits(y, height, self.height) {
            return Err(PlaneError::Crop { x, y, width, height });
        }
        let samples = (y..y + height).flat_map(|r| self.row(r)[x..x + width].iter().cloned()).collect();
        Ok(Self { width, height, samples })
    }

    /// Exchanges rows and columns.
    pub fn transposed(&self) -> Self {
        Self::from_fn(self.height, self.width, |x, y| self[(y, x)].clone())
    }
}

impl<T> Index<(usize, usize)> for Plane<T> {
    type Output = T;

    /// Returns the sample in column `x` and row `y`.
    fn index(&self, (x, y): (usize, usize)) -> &T {
        assert!(x < self.width, "column {x} of {}", self.width);
        &self.samples[y * self.width + x]
    }
}

impl<T> IndexMut<(usize, usize)> for Plane<T> {
    fn index_mut(&mut self, (x, y): (usize, usize)) -> &mut T {
        assert!(x < self.width, "column {x} of {}", self.width);
        &mut self.samples[y * self.width + x]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shape_is_checked() {
        assert_eq!(Plane::from_vec(2, 2, vec![1, 2, 3]), Err(PlaneError::Shape { width: 2, height: 2, samples: 3 }));
        assert_eq!(Plane::<u8>::from_vec(0, 2, vec![]), Err(PlaneError::Empty { width: 0, height: 2 }));
        assert!(Plane::<u8>::from_vec(usize::MAX, 2, vec![]).is_err());
    }

    #[test]
    fn crop_takes_the_named_part() {
        let plane = Plane::from_fn(4, 3, |x, y| 10 * y + x);
        assert_eq!(plane.crop(1, 1, 2, 2).unwrap().into_vec(), [11, 12, 21, 22]);
        assert!(plane.crop(3, 0, 2, 1).is_err());
        assert!(plane.crop(usize::MAX, 0, 2, 1).is_err());
    }

    #[test]
    fn transposition_exchanges_columns_and_rows() {
        let plane = Plane::from_fn(3, 2, |x, y| 10 * y + x);
        assert_eq!(plane.transposed().into_vec(), [0, 10, 1, 11, 2, 12]);
    }
}
