//! Cubic B-spline weights on raw samples: `(B J)(x + t) = sum_k beta(k - t) J(x + k)`, `k = -1 .. 2`, `0 <= t < 1`.
//!
//! This is the spline without its prefilter: it does not interpolate but smooths, by `[1 4 1] / 6` at `t = 0`. At a
//! whole pixel its derivative is the central difference. Its advantage is what it does to a phase `t`: the frequency
//! response of the weights is `sum_m sinc^4(w / 2 + pi m) exp(i (w + 2 pi m) t)`, so that low frequencies are shifted
//! by exactly `t`. The error is of the order `(w / 2 pi)^4`; bilinear weights shift by `w^2 t (1 - t) (1 - 2 t) / 6`
//! too little or too much. Unser, Aldroubi and Eden, 1993.

use crate::image::plane::Plane;
use nalgebra::Vector2;

/// Returns the weights of the samples at -1, 0, 1 and 2 for the phase `t`, `0 <= t < 1`. They sum to 1.
pub fn weights(t: f64) -> [f64; 4] {
    let (s, t2, t3) = (1.0 - t, t * t, t * t * t);
    [s * s * s / 6.0, (3.0 * t3 - 6.0 * t2 + 4.0) / 6.0, (3.0 * (t + t2 - t3) + 1.0) / 6.0, t3 / 6.0]
}

/// Returns `B J` at `q`, or `None` if one of the 16 samples is outside the frame.
pub fn sample(frame: &Plane<u16>, q: Vector2<f64>) -> Option<f64> {
    let inside = |v: f64, size: usize| v >= 1.0 && v < (size as f64) - 2.0;
    (inside(q.x, frame.width()) && inside(q.y, frame.height())).then(|| {
        let (x, y) = (q.x as usize, q.y as usize);
        let (across, down) = (weights(q.x - x as f64), weights(q.y - y as f64));
        let along_row = |row: &[u16]| across.iter().zip(row).map(|(w, &v)| w * f64::from(v)).sum::<f64>();
        down.iter().enumerate().map(|(k, w)| w * along_row(&frame.row(y + k - 1)[x - 1..x + 3])).sum()
    })
}

/// Returns `B I` and its derivatives at the whole pixel (`x`, `y`), which is not at the border of the frame.
pub fn value_and_slope(frame: &Plane<u16>, x: usize, y: usize) -> (f64, Vector2<f64>) {
    let rows = [y - 1, y, y + 1].map(|y| {
        let [l, c, r] = [x - 1, x, x + 1].map(|x| f64::from(frame.row(y)[x]));
        ((l + 4.0 * c + r) / 6.0, 0.5 * (r - l))
    });
    let [(upper, upper_slope), (middle, middle_slope), (lower, lower_slope)] = rows;
    let value = (upper + 4.0 * middle + lower) / 6.0;
    (value, Vector2::new((upper_slope + 4.0 * middle_slope + lower_slope) / 6.0, 0.5 * (lower - upper)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one_and_have_the_phase_as_their_mean() {
        for i in 0..64 {
            let t = f64::from(i) / 64.0;
            let w = weights(t);
            let mean: f64 = w.iter().zip([-1.0, 0.0, 1.0, 2.0]).map(|(w, k)| w * k).sum();
            assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-12 && (mean - t).abs() < 1e-12, "{t}: {w:?}");
            assert!(w.iter().all(|w| *w >= 0.0), "{t}: {w:?}");
        }
    }

    #[test]
    fn a_whole_pixel_has_the_value_and_slope_of_the_spline() {
        let frame = Plane::from_fn(16, 12, |x, y| ((x * 7919 + y * 104_729) % 6007) as u16);
        let q = Vector2::new(7.0, 5.0);
        let (value, slope) = value_and_slope(&frame, 7, 5);
        assert!((value - sample(&frame, q).unwrap()).abs() < 1e-9);
        let step = 1e-5;
        for (i, axis) in [Vector2::x(), Vector2::y()].into_iter().enumerate() {
            let [after, before] = [step, -step].map(|step| sample(&frame, q + axis * step).unwrap());
            assert!((slope[i] - (after - before) / (2.0 * step)).abs() < 1e-3, "{slope} {after} {before}");
        }
    }

    #[test]
    fn positions_whose_samples_leave_the_frame_have_no_value() {
        let frame = Plane::filled(8, 6, 5u16);
        for (x, y) in [(0.9, 3.0), (6.0, 3.0), (3.0, 0.9), (3.0, 4.0), (f64::NAN, 3.0), (-1e300, 3.0)] {
            assert_eq!(sample(&frame, Vector2::new(x, y)), None, "{x} {y}");
        }
        assert!((sample(&frame, Vector2::new(5.99, 3.99)).unwrap() - 5.0).abs() < 1e-12);
    }
}
