//! Samples of a picture between its pixels.

use super::plane::Plane;

/// Interpolates a picture at column `x` and row `y`, px from the middle of the first pixel, by the cubic of R. Keys,
/// 1981 (`a = -1/2`), which is exact at pixels and on parabolas. The border sample is repeated.
pub fn bicubic(picture: &Plane<u16>, x: f64, y: f64) -> u16 {
    let weights = |t: f64| {
        [
            0.5 * t * (-1.0 + t * (2.0 - t)),
            1.0 + 0.5 * t * t * (-5.0 + 3.0 * t),
            0.5 * t * (1.0 + t * (4.0 - 3.0 * t)),
            0.5 * t * t * (t - 1.0),
        ]
    };
    let (left, top) = (x.floor(), y.floor());
    let (across, down) = (weights(x - left), weights(y - top));
    let index = |start: f64, i: usize, size: usize| (start + i as f64 - 1.0).clamp(0.0, size as f64 - 1.0) as usize;
    let columns: [usize; 4] = std::array::from_fn(|i| index(left, i, picture.width()));
    let value: f64 = (0..4)
        .map(|j| {
            let row = picture.row(index(top, j, picture.height()));
            down[j] * (0..4).map(|i| across[i] * f64::from(row[columns[i]])).sum::<f64>()
        })
        .sum();
    value.round().clamp(0.0, f64::from(u16::MAX)) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bicubic_is_exact_at_pixels_and_on_parabolas() {
        let picture = Plane::from_fn(20, 20, |x, y| (100 * x * x + 40 * x * y + 3000) as u16);
        for (x, y) in [(5.0, 7.0), (5.5, 7.0), (6.1, 9.9), (3.25, 12.75)] {
            let expected = (100.0 * x * x + 40.0 * x * y + 3000.0_f64).round();
            assert_eq!(f64::from(bicubic(&picture, x, y)), expected, "({x}, {y})");
        }
        assert_eq!(bicubic(&picture, -50.0, 300.0), picture[(0, 19)]);
        assert_eq!(bicubic(&Plane::filled(1, 1, 9), 0.3, -0.4), 9);
    }
}
