//! `MaxDOG_k(q) = max DOG_k` over the `(2D + 1)^2` window around `q`, `D = 2`; bit `i` of `MaxLBP_k(p)` is
//! `DOG_k(p) >= MaxDOG_k(p + o_i)` for `i = 0 .. 31`.
//!
//! The ring is `o_i = (round(R cos(2 pi i / 32)), round(R sin(2 pi i / 32)))`, `x` to the right, `y` down, half away
//! from zero, `R` = 12 px for `k = 0` and 16 px for the others by default and at most 16 px, so that the same centres
//! are eligible whatever the radii and the number of pairs. At a maximum nine of ten of these bits are 1, so that
//! MaxLBP words alone are not distinctive. Therefore a second word per scale has as bit `i` the sign of the DoG at `p +
//! o_i`, 1 if `d_k >= 0`: 128 bits for two pairs. A descriptor always has all scales at the pixel of the feature. The
//! strict distance ignores the sign words; the descriptor always has them. MaxLBP is the LBP of T. Ojala et al., 2002,
//! eq. (4), with the intensity replaced by the response and the neighbour by the maximum around it.

use crate::features::dog::Dog;
use crate::features::feature::{Descriptor, MAX_PAIRS, RING_POINTS};
use crate::image::plane::Plane;

/// `D`: MaxDOG is the maximum of `(2D + 1)^2` samples.
pub const MAX_RADIUS: usize = 2;

/// Default radius of the ring of each scale pair, px.
pub const RING_RADII: [u32; MAX_PAIRS] = [12, 16, 16];

/// Largest radius of a ring, px.
pub const MAX_RING_RADIUS: u32 = 16;

/// The ring points `o_i` as `(dx, dy)`, px.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ring(pub [(i32, i32); RING_POINTS]);

impl Ring {
    /// Returns the ring of a radius, px.
    pub fn of_radius(radius: u32) -> Self {
        Self(std::array::from_fn(|i| {
            let angle = 2.0 * std::f64::consts::PI * i as f64 / RING_POINTS as f64;
            let part = |part: f64| (f64::from(radius) * part).round();
            // `f64::round` rounds half away from zero.
            (part(angle.cos()) as i32, part(angle.sin()) as i32)
        }))
    }

    /// Returns the default ring of each scale pair.
    pub fn defaults() -> [Self; MAX_PAIRS] {
        RING_RADII.map(Self::of_radius)
    }
}

/// The planes from which the descriptors of one scale pair are computed. `T` is a float of levels `ideal` to
/// `quantised` or an integer of the bit-true model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layer<T> {
    /// `DOG_k` and the sign bit of every sample.
    pub dog: Dog<T>,
    /// `MaxDOG_k` of every sample.
    pub max_dog: Plane<T>,
    /// Ring on which both are sampled.
    pub ring: Ring,
}

impl<T: Copy + PartialOrd> Layer<T> {
    /// Computes MaxDOG and combines it with the DoG and a ring.
    pub fn new(dog: Dog<T>, ring: Ring) -> Self {
        let max_dog = max_dog(&dog.magnitude);
        Self { dog, max_dog, ring }
    }
}

/// Computes `MaxDOG` of every sample. At the border the maximum is over the part of the window within the frame, which
/// is the same as repeating the border sample.
pub fn max_dog<T: Copy + PartialOrd>(dog: &Plane<T>) -> Plane<T> {
    const WINDOW: usize = 2 * MAX_RADIUS + 1;
    let (w, h) = (dog.width(), dog.height());
    // Maxima along the row of the last five rows: row `y` is at index `y % 5`.
    let mut along_rows: [Vec<T>; WINDOW] = std::array::from_fn(|_| dog.row(0).to_vec());
    let mut out = dog.clone();
    for y in 0..h + MAX_RADIUS {
        if y < h {
            max_along_row(dog.row(y), &mut along_rows[y % WINDOW]);
        }
        if y >= MAX_RADIUS {
            // Rows outside the frame are replaced by the centre row, which does not change the maximum.
            let centre = y - MAX_RADIUS;
            let rows: [&[T]; WINDOW] = std::array::from_fn(|i| {
                let q = centre + i;
                let inside = q >= MAX_RADIUS && q - MAX_RADIUS < h;
                &along_rows[if inside { q - MAX_RADIUS } else { centre } % WINDOW][..w]
            });
            let out = &mut out.row_mut(centre)[..w];
            for x in 0..w {
                out[x] = rows[1..].iter().fold(rows[0][x], |m, row| larger(m, row[x]));
            }
        }
    }
    out
}

fn larger<T: PartialOrd>(a: T, b: T) -> T {
    if b > a { b } else { a }
}

/// Writes `out[x] = max source[x - 2 ..= x + 2]`, restricted to the row.
fn max_along_row<T: Copy + PartialOrd>(source: &[T], out: &mut [T]) {
    out.copy_from_slice(source);
    for dx in 1..=MAX_RADIUS.min(source.len() - 1) {
        out.iter_mut().zip(&source[dx..]).for_each(|(m, &s)| *m = larger(*m, s));
        out[dx..].iter_mut().zip(source).for_each(|(m, &s)| *m = larger(*m, s));
    }
}

/// Computes the descriptor at a pixel, from all scale pairs.
///
/// # Panics
/// If a ring point is outside the frame (the pixel is not an eligible centre), or with more than [`MAX_PAIRS`] layers.
pub fn descriptor<T: Copy + PartialOrd>(layers: &[Layer<T>], x: usize, y: usize) -> Descriptor {
    let mut descriptor = Descriptor::default();
    for (k, layer) in layers.iter().enumerate() {
        let centre = layer.dog.magnitude[(x, y)];
        for (i, &(dx, dy)) in layer.ring.0.iter().enumerate() {
            let at = (x.wrapping_add_signed(dx as isize), y.wrapping_add_signed(dy as isize));
            descriptor.maxlbp[k] |= u32::from(centre >= layer.max_dog[at]) << i;
            descriptor.sign[k] |= u32::from(layer.dog.positive[at]) << i;
        }
    }
    descriptor
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn ring_is_the_table_of_the_design() {
        let [inner, outer, _] = Ring::defaults().map(|ring| ring.0);
        // 16 cos and 16 sin of 0, 11.25, 22.5, 33.75, 45 degrees: 16/0, 15.69/3.12, 14.78/6.12, 13.30/8.89,
        // 11.31/11.31.
        assert_eq!(outer[..5], [(16, 0), (16, 3), (15, 6), (13, 9), (11, 11)]);
        // 12/0, 11.77/2.34, 11.09/4.59, 9.98/6.67, 8.49/8.49.
        assert_eq!(inner[..5], [(12, 0), (12, 2), (11, 5), (10, 7), (8, 8)]);
        for points in [outer, inner] {
            for i in 0..RING_POINTS {
                let (x, y) = points[i];
                assert_eq!(points[(i + 8) % 32], (-y, x), "a quarter turn to the right, y down, of point {i}");
            }
        }
    }

    fn by_definition(dog: &Plane<u8>, x: i64, y: i64) -> u8 {
        let inside = |x: i64, y: i64| x >= 0 && y >= 0 && x < dog.width() as i64 && y < dog.height() as i64;
        let window = (-2..=2).flat_map(|dy| (-2..=2).map(move |dx| (x + dx, y + dy)));
        window.filter(|&(x, y)| inside(x, y)).map(|(x, y)| dog[(x as usize, y as usize)]).max().unwrap()
    }

    fn plane(w: usize, h: usize) -> impl Strategy<Value = Plane<u8>> {
        prop::collection::vec(any::<u8>(), w * h).prop_map(move |s| Plane::from_vec(w, h, s).unwrap())
    }

    proptest! {
        #[test]
        fn max_dog_is_that_of_the_definition(dog in (1usize..12, 1usize..12).prop_flat_map(|(w, h)| plane(w, h))) {
            let expected = Plane::from_fn(dog.width(), dog.height(), |x, y| by_definition(&dog, x as i64, y as i64));
            prop_assert_eq!(max_dog(&dog), expected);
        }

        #[test]
        fn bits_are_those_of_the_definition(
            narrow in plane(40, 39), middle in plane(40, 39), wide in plane(40, 39), radius in 4..=MAX_RING_RADIUS,
        ) {
            let layers = [Dog::between(&narrow, &middle), Dog::between(&middle, &wide), Dog::between(&narrow, &wide)]
                .map(|dog| Layer::new(dog, Ring::of_radius(radius)));
            for (x, y) in [(18, 18), (21, 20), (20, 19)] {
                let found = descriptor(&layers, x, y);
                for (k, Layer { dog, .. }) in layers.iter().enumerate() {
                    for i in 0..32 {
                        let (sin, cos) = (f64::from(i) * 11.25).to_radians().sin_cos();
                        let [dx, dy] = [cos, sin].map(|part| (f64::from(radius) * part).round() as i64);
                        let (px, py) = (x as i64 + dx, y as i64 + dy);
                        let expected = dog.magnitude[(x, y)] >= by_definition(&dog.magnitude, px, py);
                        prop_assert_eq!(found.maxlbp[k] >> i & 1 == 1, expected);
                        prop_assert_eq!(found.sign[k] >> i & 1 == 1, dog.positive[(px as usize, py as usize)]);
                    }
                }
            }
        }
    }

    #[test]
    fn equal_responses_set_the_bit() {
        let flat = Plane::filled(37, 37, 4u16);
        let ring = Ring::of_radius(16);
        let layer = || Layer::new(Dog { magnitude: flat.clone(), positive: Plane::filled(37, 37, false) }, ring);
        let found = descriptor(&[layer(), layer()], 18, 18);
        assert_eq!(found, Descriptor::of_two([u32::MAX; 2], [0; 2]));
    }
}
