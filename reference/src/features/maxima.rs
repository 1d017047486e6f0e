//! `p` is a feature point of scale `k` where `DOG_k(p) >= T_k`, `DOG_k(p) > DOG_k(q)` for the neighbours `q` of the 7x7
//! window that come earlier in raster order, and `DOG_k(p) >= DOG_k(q)` for those that come later.
//!
//! Integer responses can be equal. With strict comparisons only, a plateau has no maximum; with none, it has several.
//! By this rule only the first of the highest samples of a window, in raster order, is a maximum. So two maxima of one
//! scale are never within 3 px of each other in both directions. A centre is eligible where `18 <= x < W - 18` and `18
//! <= y < H - 18`, whatever the scale: 16 px of the outer ring and 2 px of MaxDOG, so that no window of a feature
//! leaves the frame. All 48 neighbours are used, eligible or not. A frame under 37 px in either direction has no
//! feature point.

use std::{cmp::Ordering, ops::Range};

use crate::features::feature::Feature;
use crate::image::plane::Plane;

/// Distance from the centre of the 7x7 window to its border, in pixels.
pub(crate) const WINDOW_RADIUS: usize = 3;

/// Distance of eligible centres from the border of the frame, in pixels.
const MARGIN: usize = 18;

/// Side of a cell of the grid that spreads the strongest features over the frame, in pixels.
const CELL_SIDE: u32 = 128;

/// Smallest response that is kept, relative to the `n`-th strongest: weak maxima are repeated less often, so that an
/// empty cell does not justify them.
const MIN_RELATIVE_RESPONSE: f64 = 0.7;

/// Returns the columns (or rows) in which a centre is eligible, for a frame of `size` columns (or rows).
pub fn eligible(size: usize) -> Range<usize> {
    MARGIN..size.saturating_sub(MARGIN).max(MARGIN)
}

/// Returns `true` if `(x, y)` is a maximum of its 7x7 window.
///
/// # Panics
/// If the window leaves the frame.
pub fn is_maximum<T: Copy + PartialOrd>(dog: &Plane<T>, x: usize, y: usize) -> bool {
    let centre = dog[(x, y)];
    let columns = x - WINDOW_RADIUS..=x + WINDOW_RADIUS;
    let earlier = |q: &T| centre > *q;
    let later = |q: &T| centre >= *q;
    // The row of the centre first: it rejects most candidates.
    dog.row(y)[x - WINDOW_RADIUS..x].iter().all(earlier)
        && dog.row(y)[x + 1..=x + WINDOW_RADIUS].iter().all(later)
        && (1..=WINDOW_RADIUS).all(|dy| {
            dog.row(y - dy)[columns.clone()].iter().all(earlier) && dog.row(y + dy)[columns.clone()].iter().all(later)
        })
}

/// Finds the eligible maxima of at least `threshold`. Returns their `(x, y)` in raster order.
pub fn maxima<T: Copy + PartialOrd>(dog: &Plane<T>, threshold: T) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let columns = eligible(dog.width());
    if columns.is_empty() {
        return found;
    }
    // The nearest four neighbours first, without branches: they reject most samples.
    let mut candidates = vec![false; columns.len()];
    for y in eligible(dog.height()) {
        let (start, n) = (columns.start, columns.len());
        let part = |y: usize, x: usize| &dog.row(y)[x..x + n];
        let (centre, above, below) = (part(y, start), part(y - 1, start), part(y + 1, start));
        let (left, right) = (part(y, start - 1), part(y, start + 1));
        let candidates = &mut candidates[..n];
        for x in 0..n {
            let c = centre[x];
            candidates[x] = (c >= threshold) & (c > above[x]) & (c > left[x]) & (c >= right[x]) & (c >= below[x]);
        }
        let chosen = (start..).zip(candidates).filter(|(x, candidate)| **candidate && is_maximum(dog, *x, y));
        found.extend(chosen.map(|(x, _)| (x, y)));
    }
    found
}

/// Returns the `n`-th strongest response (1 is the strongest) among the eligible maxima of at least `floor`. As a
/// threshold it gives `n` features, more if responses tie. `None` if there are fewer maxima or `n` is 0.
pub fn nth_strongest<T: Copy + PartialOrd>(dog: &Plane<T>, floor: T, n: usize) -> Option<T> {
    let mut responses: Vec<T> = maxima(dog, floor).into_iter().map(|at| dog[at]).collect();
    if n == 0 || n > responses.len() {
        return None;
    }
    let descending = |a: &T, b: &T| b.partial_cmp(a).unwrap_or(Ordering::Equal);
    Some(*responses.select_nth_unstable_by(n - 1, descending).1)
}

/// Selects `n` features, spread over the frame by [`spread`].
pub fn strongest_per_cell(features: &[Feature], n: usize) -> Vec<Feature> {
    spread(features, n, |f| (f.x, f.y, f.response))
}

/// Selects `n` items in rounds, among those with at least 0.7 of the `n`-th strongest response: each round takes the
/// strongest remaining item of every 128x128 cell. If the last round has too many items, its strongest are taken. Ties
/// are decided by the order of the input, which the result keeps. `position` returns column, row and response of an
/// item.
pub fn spread<T: Copy>(items: &[T], n: usize, position: impl Fn(&T) -> (u32, u32, f64)) -> Vec<T> {
    if items.len() <= n {
        return items.to_vec();
    }
    if n == 0 {
        return Vec::new();
    }
    let mut ranked: Vec<Ranked> =
        items.iter().enumerate().map(|(index, item)| Ranked { response: position(item).2, index }).collect();
    let floor = MIN_RELATIVE_RESPONSE * ranked.select_nth_unstable_by(n - 1, Ranked::stronger).1.response;
    let strong = |item: &&T| position(item).2 >= floor;
    let cell = |item: &T| {
        let (x, y, _) = position(item);
        ((x / CELL_SIDE) as usize, (y / CELL_SIDE) as usize)
    };
    let columns = items.iter().map(|item| cell(item).0).max().unwrap_or(0) + 1;
    let cell = |item: &T| cell(item).1 * columns + cell(item).0;
    let cells = items.iter().map(cell).max().unwrap_or(0) + 1;

    // Items sorted by cell. The ends of the cells in `ranked` are counted first, then each cell is filled from behind.
    let mut bounds = vec![0; cells + 1];
    items.iter().filter(strong).for_each(|item| bounds[cell(item)] += 1);
    let mut end = 0;
    for bound in &mut bounds {
        end += *bound;
        *bound = end;
    }
    ranked.truncate(end);
    for (index, item) in items.iter().enumerate().filter(|(_, item)| strong(item)) {
        let bound = &mut bounds[cell(item)];
        *bound -= 1;
        ranked[*bound] = Ranked { response: position(item).2, index };
    }

    // The number of complete rounds; all rounds are complete if at most `n` items are strong enough.
    let after = |rounds: usize| bounds.windows(2).map(|b| (b[1] - b[0]).min(rounds)).sum::<usize>();
    let rounds = (1..=ranked.len()).find(|&rounds| after(rounds) > n).map_or(ranked.len(), |rounds| rounds - 1);
    let left = n - after(rounds);

    let mut kept = vec![false; items.len()];
    let mut last_round = Vec::new();
    for bounds in bounds.windows(2) {
        let mut cell = &mut ranked[bounds[0]..bounds[1]];
        if cell.len() > rounds {
            let (stronger, nth, _) = cell.select_nth_unstable_by(rounds, Ranked::stronger);
            last_round.push(*nth);
            cell = stronger;
        }
        cell.iter().for_each(|item| kept[item.index] = true);
    }
    if left < last_round.len() {
        last_round.select_nth_unstable_by(left, Ranked::stronger);
        last_round.truncate(left);
    }
    last_round.iter().for_each(|item| kept[item.index] = true);
    items.iter().zip(kept).filter_map(|(&item, kept)| kept.then_some(item)).collect()
}

/// An item of [`spread`].
#[derive(Clone, Copy)]
struct Ranked {
    response: f64,
    index: usize,
}

impl Ranked {
    /// Compares two items; the stronger one is less, of equal ones the earlier.
    fn stronger(&self, other: &Self) -> Ordering {
        other.response.total_cmp(&self.response).then(self.index.cmp(&other.index))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::features::feature::Descriptor;

    /// Finds maxima by the definition, word for word: every neighbour by its offset, `earlier` by comparing raster
    /// positions.
    fn by_definition(dog: &Plane<u8>, threshold: u8) -> Vec<(usize, usize)> {
        let (w, h) = (dog.width() as i64, dog.height() as i64);
        let mut found = Vec::new();
        for y in 0..h {
            for x in 0..w {
                if x < 18 || x >= w - 18 || y < 18 || y >= h - 18 {
                    continue;
                }
                let at = |x: i64, y: i64| dog[(x as usize, y as usize)];
                let wins = (-3..=3).all(|dy| {
                    (-3..=3).all(|dx| match (dy, dx) {
                        (0, 0) => true,
                        _ if dy * w + dx < 0 => at(x, y) > at(x + dx, y + dy),
                        _ => at(x, y) >= at(x + dx, y + dy),
                    })
                });
                if wins && at(x, y) >= threshold {
                    found.push((x as usize, y as usize));
                }
            }
        }
        found
    }

    /// Returns a random picture. A small number of grey levels makes plateaus and ties.
    fn picture() -> impl Strategy<Value = Plane<u8>> {
        (37usize..60, 37usize..60, 1u8..=255).prop_flat_map(|(w, h, top)| {
            prop::collection::vec(0..=top, w * h).prop_map(move |samples| Plane::from_vec(w, h, samples).unwrap())
        })
    }

    proptest! {
        #[test]
        fn maxima_are_those_of_the_definition(dog in picture(), threshold in 0u8..4) {
            prop_assert_eq!(maxima(&dog, threshold), by_definition(&dog, threshold));
        }

        #[test]
        fn two_maxima_never_share_a_window(dog in picture()) {
            let found = maxima(&dog, 0);
            for (i, a) in found.iter().enumerate() {
                for b in &found[..i] {
                    prop_assert!(a.0.abs_diff(b.0) > WINDOW_RADIUS || a.1.abs_diff(b.1) > WINDOW_RADIUS);
                }
            }
        }

        #[test]
        fn the_nth_strongest_response_is_the_threshold_for_n_features(dog in picture(), n in 1usize..6) {
            match nth_strongest(&dog, 1, n) {
                Some(threshold) => {
                    prop_assert!(maxima(&dog, threshold).len() >= n);
                    prop_assert!(threshold == u8::MAX || maxima(&dog, threshold + 1).len() < n);
                }
                None => prop_assert!(maxima(&dog, 1).len() < n),
            }
        }
    }

    #[test]
    fn an_isolated_plateau_is_one_maximum_its_first_sample() {
        // Up to 4 px wide every sample of the plateau sees the first one in its own window.
        for (w, h) in [(1, 1), (2, 1), (1, 2), (2, 2), (4, 4)] {
            let inside = |x: usize, y: usize| (25..25 + w).contains(&x) && (24..24 + h).contains(&y);
            let dog = Plane::from_fn(60, 60, |x, y| u16::from(inside(x, y)));
            assert_eq!(maxima(&dog, 1), [(25, 24)], "plateau of {w} x {h}");
        }
    }

    #[test]
    fn a_diagonal_plateau_that_leans_left_is_not_doubled() {
        let dog = Plane::from_fn(60, 60, |x, y| u16::from(x + y == 50 && (24..27).contains(&y)));
        assert_eq!(maxima(&dog, 1), [(26, 24)]);
    }

    #[test]
    fn a_neighbour_outside_the_eligible_part_still_counts() {
        let mut dog = Plane::filled(40, 40, 0u16);
        dog[(18, 20)] = 5;
        assert_eq!(maxima(&dog, 1), [(18, 20)]);
        dog[(17, 20)] = 5;
        assert_eq!(maxima(&dog, 1), []);
    }

    #[test]
    fn frames_under_37_px_have_no_maxima() {
        for (w, h) in [(1, 1), (1, 200), (200, 1), (36, 37), (37, 36), (36, 400), (7, 7)] {
            let dog = Plane::from_fn(w, h, |x, y| (x * 31 + y * 17) % 11);
            assert_eq!(maxima(&dog, 0), [], "{w} x {h}");
        }
        let mut dog = Plane::filled(37, 37, 0u16);
        dog[(18, 18)] = 1;
        assert_eq!(maxima(&dog, 1), [(18, 18)]);
    }

    #[test]
    fn a_constant_plane_has_no_maxima() {
        assert_eq!(maxima(&Plane::filled(50, 50, 3.5), 0.0), []);
    }

    fn feature(x: u32, y: u32, response: f64) -> Feature {
        Feature { x, y, scale: 0, bright: true, response, neighbours: [0.0; 4], descriptor: Descriptor::default() }
    }

    #[test]
    fn each_cell_gives_its_strongest_before_any_gives_its_second() {
        // Three strong ones in one cell, less strong ones in two others.
        let all = [
            feature(20, 20, 9.0),
            feature(30, 20, 8.5),
            feature(40, 20, 8.0),
            feature(130, 20, 6.4),
            feature(20, 130, 7.0),
        ];
        let kept = |n| strongest_per_cell(&all, n).iter().map(|f| f.response).collect::<Vec<_>>();
        assert_eq!(kept(0), []);
        assert_eq!(kept(2), [9.0, 7.0]);
        assert_eq!(kept(3), [9.0, 6.4, 7.0]);
        assert_eq!(kept(4), [9.0, 8.5, 6.4, 7.0]);
        assert_eq!(kept(5), [9.0, 8.5, 8.0, 6.4, 7.0]);
        assert_eq!(kept(6).len(), 5);
    }

    #[test]
    fn a_weak_one_is_left_out_however_empty_its_cell() {
        let all = [feature(20, 20, 9.0), feature(30, 20, 8.0), feature(40, 20, 7.0), feature(130, 20, 5.5)];
        let kept = |n| strongest_per_cell(&all, n).iter().map(|f| f.response).collect::<Vec<_>>();
        // 0.7 of the second strongest is 5.6, of the third 4.9.
        assert_eq!(kept(2), [9.0, 8.0]);
        assert_eq!(kept(3), [9.0, 8.0, 5.5]);
    }

    proptest! {
        #[test]
        fn spreading_takes_rounds_in_order(
            all in prop::collection::vec((0u32..200, 0u32..150, 0u8..9), 0..80), n in 0usize..90,
        ) {
            // The definition: leave out the weak, sort by round, then response, then position in the list; take the
            // first n.
            let given: Vec<Feature> = all.into_iter().map(|(x, y, r)| feature(x, y, f64::from(r))).collect();
            let mut responses: Vec<f64> = given.iter().map(|f| f.response).collect();
            responses.sort_by(|a, b| b.total_cmp(a));
            let nth = if n > 0 && given.len() > n { responses[n - 1] } else { 0.0 };
            let all: Vec<Feature> = given.iter().filter(|f| f.response >= 0.7 * nth).copied().collect();
            let beats = |a: usize, b: usize| (all[b].response, a) < (all[a].response, b);
            let cell = |i: usize| (all[i].x / 128, all[i].y / 128);
            let round = |i: usize| (0..all.len()).filter(|&j| j != i && cell(j) == cell(i) && beats(j, i)).count();
            let mut order: Vec<usize> = (0..all.len()).collect();
            order.sort_by(|&a, &b| round(a).cmp(&round(b)).then(all[b].response.total_cmp(&all[a].response)));
            order.truncate(n);
            order.sort_unstable();
            prop_assert_eq!(strongest_per_cell(&given, n), order.into_iter().map(|i| all[i]).collect::<Vec<_>>());
        }
    }

    #[test]
    fn ties_between_features_fall_to_the_first() {
        let all = [feature(20, 20, 1.0), feature(30, 20, 1.0), feature(130, 20, 1.0)];
        assert_eq!(strongest_per_cell(&all, 1), [all[0]]);
        assert_eq!(strongest_per_cell(&all, 2), [all[0], all[2]]);
    }
}
