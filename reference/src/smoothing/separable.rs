//! `y = rows(columns(x))`: a one-dimensional filter along the columns of a plane, then along its rows.
//!
//! Columns come first, as in the hardware. `LANES` neighbouring lines are filtered side by side: a tile holds sample
//! `n` of all of them next to each other, so that `LANES` independent recursions hide the latency of each other, and
//! memory is accessed along rows also when the filter runs down the columns. Lanes do not mix: the result does not
//! depend on their number.

use crate::image::plane::Plane;
use rayon::prelude::*;

/// Lines filtered side by side: two cache lines of `f64`.
pub const LANES: usize = 16;

/// Sample `n` of `LANES` neighbouring lines.
pub type Lanes = [f64; LANES];

/// Filters the columns, then the rows of `plane`. `filter` works on a tile in place, one `Lanes` per sample of the
/// line.
pub fn columns_then_rows(plane: &Plane<f64>, filter: impl Fn(&mut [Lanes]) + Sync) -> Plane<f64> {
    let (width, height) = (plane.width(), plane.height());
    let tiles: Vec<Vec<Lanes>> = (0..width.div_ceil(LANES))
        .into_par_iter()
        .map(|t| {
            let x = t * LANES;
            let used = LANES.min(width - x);
            let mut tile = vec![[0.0; LANES]; height];
            for (lanes, row) in tile.iter_mut().zip(plane.rows()) {
                lanes[..used].copy_from_slice(&row[x..x + used]);
            }
            filter(&mut tile);
            tile
        })
        .collect();
    let mut out = Plane::filled(width, height, 0.0);
    out.as_mut_slice().par_chunks_mut(LANES * width).enumerate().for_each_init(
        || vec![[0.0; LANES]; width],
        |lines, (group, rows)| {
            let used = rows.len() / width;
            for (columns, tile) in lines.chunks_mut(LANES).zip(&tiles) {
                for (r, lanes) in tile[group * LANES..group * LANES + used].iter().enumerate() {
                    for (line, &sample) in columns.iter_mut().zip(lanes) {
                        line[r] = sample;
                    }
                }
            }
            filter(lines);
            for (r, row) in rows.chunks_exact_mut(width).enumerate() {
                for (sample, line) in row.iter_mut().zip(lines.iter()) {
                    *sample = line[r];
                }
            }
        },
    );
    out
}

/// Filters a single line with the same kind of filter.
pub fn single_line(line: &[f64], filter: impl Fn(&mut [Lanes])) -> Vec<f64> {
    let mut tile: Vec<Lanes> = line.iter().map(|&sample| [sample; LANES]).collect();
    filter(&mut tile);
    tile.iter().map(|lanes| lanes[0]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Computes `y[n] = x[n] + 2 x[n - 1]`, which is not symmetric, so that a wrong direction shows.
    fn doubled_neighbour(tile: &mut [Lanes]) {
        for n in (1..tile.len()).rev() {
            let before = tile[n - 1];
            for (sample, before) in tile[n].iter_mut().zip(before) {
                *sample += 2.0 * before;
            }
        }
    }

    #[test]
    fn columns_and_rows_of_any_size_are_filtered_in_place() {
        for (width, height) in [(1, 1), (1, 40), (40, 1), (16, 16), (17, 33), (15, 31)] {
            let sample = |x: usize, y: usize| (x * x + 7 * y) as f64;
            let column = |x: usize, y: usize| sample(x, y) + if y > 0 { 2.0 * sample(x, y - 1) } else { 0.0 };
            let want =
                Plane::from_fn(width, height, |x, y| column(x, y) + if x > 0 { 2.0 * column(x - 1, y) } else { 0.0 });
            let got = columns_then_rows(&Plane::from_fn(width, height, sample), doubled_neighbour);
            assert_eq!(got, want, "{width} x {height}");
        }
    }
}
