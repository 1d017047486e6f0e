//! Cubic B-spline weights on 12-bit pixels: `(B J)(x + t) = sum_k beta(k - t) J(x + k)`, `k = -1 .. 2`, `0 <= t < 1`.

use hoverlock_reference::image::plane::Plane;
use nalgebra::Vector2;

/// Phases `t` of a pixel.
pub(super) const PHASES: usize = 64;
/// Sum of the weights of a phase.
pub(super) const WEIGHT_SUM: i32 = 512;
/// Bits of a pixel that do not count.
const PIXEL_SHIFT: u32 = 4;
/// Bits of the product of two weights that are rounded off a sample.
const SAMPLE_SHIFT: u32 = 15;
/// Side of a window, px. It holds a patch that is turned by 20 degrees, or enlarged by a third, and may move.
const WINDOW_PX: usize = 40;
/// Pixels of a window from the first to the last that a sample needs.
const TAPS: usize = 3 * WINDOW_PX + 4;

/// Weights of the pixels at -1, 0, 1 and 2 for each phase, in steps of 1/512. The outer two are rounded; the inner two
/// follow from them, so that the sum is 1 and the mean exactly `t`: rounding of weights does not move a patch.
pub(super) const WEIGHTS: [[i32; 4]; PHASES] = {
    // `t^3 / 6`, with `t` in phases.
    const fn outer(phase: i32) -> i32 {
        let scale = 6 * (PHASES * PHASES * PHASES) as i32 / WEIGHT_SUM;
        (phase * phase * phase + scale / 2) / scale
    }
    let mut table = [[0; 4]; PHASES];
    let mut phase = 0;
    while phase < PHASES {
        let t = phase as i32;
        let [before, last] = [outer(PHASES as i32 - t), outer(t)];
        let after = t * (WEIGHT_SUM / PHASES as i32) + before - 2 * last;
        table[phase] = [before, WEIGHT_SUM - before - after - last, after, last];
        phase += 1;
    }
    table
};

/// Weights of the value at a whole pixel.
pub(super) const VALUE: [i32; 4] = WEIGHTS[0];
/// Weights of the derivative there, which is the central difference.
pub(super) const SLOPE: [i32; 4] = [-WEIGHT_SUM / 2, 0, WEIGHT_SUM / 2, 0];

/// The 12-bit pixels about a patch, in rows of a fixed length, which are faster to reach than those of a frame.
pub(super) struct Window {
    pixels: [i32; WINDOW_PX * WINDOW_PX],
    /// Column and row of its first pixel in the frame.
    pub(super) corner: [usize; 2],
    /// Columns and rows that are filled.
    size: [usize; 2],
}

impl Window {
    /// Copies what the samples within `extent` (px) of `centre` need, or `None` if that leaves the frame or does not
    /// fit.
    pub(super) fn about(frame: &Plane<u16>, centre: &Vector2<f64>, extent: &Vector2<f64>) -> Option<Self> {
        let (mut corner, mut size) = ([0; 2], [0; 2]);
        for (axis, side) in [frame.width(), frame.height()].into_iter().enumerate() {
            // A pixel more, as positions are rounded.
            let [first, last] = [centre[axis] - extent[axis] - 2.0, centre[axis] + extent[axis] + 4.0];
            let is_inside = first >= 0.0 && last <= side as f64;
            if !is_inside {
                return None;
            }
            corner[axis] = first as usize;
            size[axis] = last as usize - corner[axis];
            if size[axis] > WINDOW_PX {
                return None;
            }
        }
        let mut pixels = [0; WINDOW_PX * WINDOW_PX];
        for (y, to) in pixels.chunks_exact_mut(WINDOW_PX).enumerate().take(size[1]) {
            let row = &frame.row(corner[1] + y)[corner[0]..corner[0] + size[0]];
            for (to, pixel) in to.iter_mut().zip(row) {
                *to = i32::from(pixel >> PIXEL_SHIFT);
            }
        }
        Some(Self { pixels, corner, size })
    }

    /// Returns `true` if all samples within `extent` (px) of `centre` have their pixels.
    pub(super) fn contains(&self, centre: &Vector2<f64>, extent: &Vector2<f64>) -> bool {
        (0..2).all(|axis| {
            let centre = centre[axis] - self.corner[axis] as f64;
            centre - extent[axis] >= 2.0 && centre + extent[axis] + 4.0 <= self.size[axis] as f64
        })
    }

    /// Returns the sums of the pixels from -1 to 2 in the columns from -1 to 2 about the pixel (`x`, `y`) of the
    /// window, with the weights `down`.
    #[inline(always)]
    pub(super) fn columns(&self, [x, y]: [usize; 2], down: &[i32; 4]) -> [i32; 4] {
        let first = (WINDOW_PX * y + x).wrapping_sub(WINDOW_PX + 1);
        // Whoever asks has made the window large enough.
        let Some(rows) = self.pixels.get(first..).and_then(<[i32]>::first_chunk::<TAPS>) else { return [0; 4] };
        let mut sums = [0; 4];
        for (row, weight) in rows.chunks(WINDOW_PX).zip(down) {
            let Some(taps) = row.first_chunk::<4>() else { return sums };
            for (sum, tap) in sums.iter_mut().zip(taps) {
                *sum += weight * tap;
            }
        }
        sums
    }
}

/// Returns the sum of four columns with the weights `across`, in steps of 1/8: 15 bits, and a sign for a slope.
#[inline(always)]
pub(super) fn sample(columns: &[i32; 4], across: &[i32; 4]) -> i16 {
    let sum: i32 = columns.iter().zip(across).map(|(column, weight)| column * weight).sum();
    ((sum + (1 << (SAMPLE_SHIFT - 1))) >> SAMPLE_SHIFT) as i16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_have_sum_and_mean_of_their_phase() {
        for (phase, weights) in WEIGHTS.iter().enumerate() {
            let mean: i32 = weights.iter().zip([-1, 0, 1, 2]).map(|(w, k)| w * k).sum();
            assert_eq!((weights.iter().sum::<i32>(), mean * PHASES as i32), (WEIGHT_SUM, WEIGHT_SUM * phase as i32));
            assert!(weights.iter().all(|w| *w >= 0), "{weights:?}");
            let t = phase as f64 / PHASES as f64;
            let exact = [(1.0 - t).powi(3) / 6.0, (3.0 * t.powi(3) - 6.0 * t * t + 4.0) / 6.0];
            let off = exact.iter().zip(weights).map(|(e, w)| (e - f64::from(*w) / f64::from(WEIGHT_SUM)).abs());
            assert!(off.fold(0.0, f64::max) < 2.0 / f64::from(WEIGHT_SUM), "phase {phase}: {weights:?}");
        }
    }

    /// Every position that a window is made for has its own pixels.
    #[test]
    fn a_window_has_the_samples_of_the_frame() {
        let frame = Plane::from_fn(60, 50, |x, y| (16 * (60 * y + x)) as u16);
        for (centre, extent) in [((13.0, 13.0), 11.0), ((30.4, 25.7), 11.5), ((46.0, 35.9), 10.0)] {
            let centre = Vector2::new(centre.0, centre.1);
            let window = Window::about(&frame, &centre, &Vector2::repeat(extent)).expect("it is inside");
            for sign in [-1.0, 1.0] {
                let at = centre.map(|v| (v + sign * extent) as usize);
                let columns = window.columns([at.x - window.corner[0], at.y - window.corner[1]], &[0, 512, 0, 0]);
                assert_eq!(columns, [0, 1, 2, 3].map(|j| 512 * (60 * at.y + at.x + j - 1) as i32));
            }
        }
        assert!(Window::about(&frame, &Vector2::new(12.9, 25.0), &Vector2::repeat(11.0)).is_none());
        assert!(Window::about(&frame, &Vector2::new(30.0, 35.5), &Vector2::repeat(11.0)).is_none());
        assert!(Window::about(&frame, &Vector2::new(30.0, 25.0), &Vector2::repeat(18.0)).is_none());
    }
}
