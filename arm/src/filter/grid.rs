//! The grid of the ground: the cells whose heights are considered.
//!
//! A cell is a square of the level frame, an eighth of the picture wide. Memory holds [`GRID_SIDE`] of them along each
//! axis, three pictures: cell `(i, j)` has the place `(i, j) mod GRID_SIDE`, and takes it from the one before.

use nalgebra::Vector3;

/// Places of cells along each axis.
const GRID_SIDE: usize = 24;
/// Places of cells.
pub(super) const CELLS: usize = GRID_SIDE * GRID_SIDE;
/// Cells across the picture: 6 m each from 50 m with the wide view.
const CELLS_ACROSS: f64 = 8.0;
/// Change of the ground that the picture spans from which on cells have another size. In larger ones a roof shares its
/// height with the street, and of smaller ones a picture has more than an update may touch.
const MAX_CHANGE: f64 = 1.25;

/// The cells, and which of their heights may have a correlation with the state.
pub(super) struct Grid {
    side_m: f64,
    /// The cell of each place.
    names: Vec<[i32; 2]>,
    is_correlated: Vec<bool>,
    correlated: usize,
}

impl Grid {
    /// Allocates the memory.
    pub(super) fn new() -> Self {
        Self { side_m: 1.0, names: vec![[0; 2]; CELLS], is_correlated: vec![false; CELLS], correlated: 0 }
    }

    /// Begins with cells of a picture that spans `width_m` of the ground, and without correlations.
    pub(super) fn restart(&mut self, width_m: f64) {
        self.side_m = (width_m / CELLS_ACROSS).max(1e-3);
        self.is_correlated.fill(false);
        self.correlated = 0;
    }

    /// Returns `true` if the cells are too large or too small for a picture that spans `width_m` of the ground.
    pub(super) fn is_unfit(&self, width_m: f64) -> bool {
        !(1.0 / MAX_CHANGE..=MAX_CHANGE).contains(&(width_m / self.width_m()))
    }

    /// Returns the ground that the picture spans, m.
    pub(super) fn width_m(&self) -> f64 {
        CELLS_ACROSS * self.side_m
    }

    /// Returns the place of the cell of a point, and whether a correlation that another cell had is left there.
    pub(super) fn enter(&mut self, point: &Vector3<f64>) -> (usize, bool) {
        let name = [point.x, point.y].map(|value| (value / self.side_m).floor() as i32);
        let [column, row] = name.map(|index| index.rem_euclid(GRID_SIDE as i32) as usize);
        let place = row * GRID_SIDE + column;
        let is_other = std::mem::replace(&mut self.names[place], name) != name;
        let is_left = is_other && std::mem::replace(&mut self.is_correlated[place], false);
        self.correlated -= usize::from(is_left);
        (place, is_left)
    }

    /// Notes that the height of a cell has a correlation with the state.
    pub(super) fn set_correlated(&mut self, place: usize) {
        self.correlated += usize::from(!self.is_correlated[place]);
        self.is_correlated[place] = true;
    }

    /// Returns the number of cells whose heights may have a correlation with the state.
    pub(super) fn correlated(&self) -> usize {
        self.correlated
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_has_one_cell_and_counts_once() {
        let mut grid = Grid::new();
        grid.restart(48.0);
        let at = |x: f64, y: f64| Vector3::new(x, y, 0.0);
        assert!(
            (grid.width_m() - 48.0).abs() < 1e-12 && !grid.is_unfit(40.0) && grid.is_unfit(38.0) && grid.is_unfit(61.0)
        );
        let (place, is_left) = grid.enter(&at(-0.1, 5.9));
        assert!(!is_left && place == 23);
        grid.set_correlated(place);
        grid.set_correlated(place);
        assert_eq!((grid.enter(&at(-5.9, 0.1)), grid.correlated()), ((place, false), 1));
        // Three pictures further.
        assert_eq!((grid.enter(&at(-0.1 + 144.0, 5.9)), grid.correlated()), ((place, true), 0));
        assert_eq!(grid.enter(&at(-0.1 + 144.0, 5.9)), (place, false));
        for lost in [f64::NAN, f64::INFINITY, -1e300] {
            assert!(grid.enter(&at(lost, lost)).0 < CELLS);
        }
    }
}
