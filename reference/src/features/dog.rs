//! `d_k = G_{sigma1} * I - G_{sigma2} * I`, `DOG_k = |d_k|`: the difference of a narrow and a wide smoothing of one
//! frame.
//!
//! `sigma1 < sigma2` in pixels; the default is the chain 2.0 - 3.2 - 5.12, so that the two pairs `k = 0, 1` share three
//! filters. A chain of one to three pairs has one filter more than pairs. `DOG_k` is in the unit of the planes (DN of
//! the camera sample, or LSB for planes of integers); at most 0.243 of full scale with the first-order filters
//! of the default chain. The sign of `d_k` is a separate bit, which distinguishes bright from dark spots. Source: D.
//! Lowe, "Distinctive image features from scale-invariant keypoints", 2004, eq. (1).

use std::ops::Sub;

use crate::image::plane::Plane;

/// Standard deviations in pixels of the default chain: pair `k` is the difference of filters `k` and `k + 1`.
pub const SIGMAS: [f64; 3] = [2.0, 3.2, 5.12];

/// The signed difference of one scale pair, as magnitude and sign bit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dog<T> {
    /// `DOG_k = |d_k|`, never negative.
    pub magnitude: Plane<T>,
    /// The sign bit: `true` if `d_k >= 0`.
    pub positive: Plane<bool>,
}

impl<T: Copy + PartialOrd + Sub<Output = T>> Dog<T> {
    /// Computes narrow minus wide. The smaller sample is subtracted from the larger, so that unsigned samples do not
    /// wrap.
    ///
    /// # Panics
    /// The shapes differ.
    pub fn between(narrow: &Plane<T>, wide: &Plane<T>) -> Self {
        Self {
            magnitude: narrow.zip_map(wide, |&n, &w| if n >= w { n - w } else { w - n }),
            positive: narrow.zip_map(wide, |n, w| n >= w),
        }
    }
}

impl Dog<f64> {
    /// Returns the signed difference `d_k`, for heat maps and error measures.
    pub fn signed(&self) -> Plane<f64> {
        self.magnitude.zip_map(&self.positive, |&m, &positive| if positive { m } else { -m })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_counts_as_positive_and_unsigned_samples_do_not_wrap() {
        let narrow = Plane::from_vec(3, 1, vec![5u32, 7, 9]).unwrap();
        let wide = Plane::from_vec(3, 1, vec![6u32, 7, 4]).unwrap();
        let dog = Dog::between(&narrow, &wide);
        assert_eq!(dog.magnitude.as_slice(), [1, 0, 5]);
        assert_eq!(dog.positive.as_slice(), [false, true, true]);
    }

    #[test]
    fn signed_difference_is_narrow_minus_wide() {
        let narrow = Plane::from_vec(2, 1, vec![1.5, -2.0]).unwrap();
        let wide = Plane::from_vec(2, 1, vec![2.0, -4.5]).unwrap();
        assert_eq!(Dog::between(&narrow, &wide).signed().as_slice(), [-0.5, 2.5]);
    }
}
