//! The updates by readings of the sensors.

use super::grid::CELLS;
use super::projection::normal;
use super::rotation::logarithm;
use super::{ATTITUDE_AGE_S, Filter, POSITION, ROTATION, SLOPE, STATES, WANDER, WHITE_ATTITUDE_SHARE, attitude_errors};
use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reference::motion::orthophoto::Attitude;
use nalgebra::Vector3;

/// Standard error of a laser reading as a measurement of the ground, as a part of the same. Neighbouring readings hit
/// the same hill, so it is larger than the roughness.
const LASER_SIGMA: f64 = 0.4;

impl Filter {
    /// Updates by an attitude reading. Returns what of it contradicts the state and is ignored, rad about each axis.
    pub fn update_attitude(&mut self, attitude: &Attitude, sensors: &SensorErrors) -> Vector3<f64> {
        let turned = logarithm(&(attitude.rotation() * self.pose.rotation.transpose()));
        let innovation = turned - self.wander;
        let age = ATTITUDE_AGE_S * self.rates.norm();
        let mut contradiction = Vector3::zeros();
        for (axis, reading) in attitude_errors(sensors).into_iter().enumerate() {
            let noise = WHITE_ATTITUDE_SHARE * reading * reading + age * age;
            let by_states = [(ROTATION + axis, 1.0), (WANDER + axis, 1.0)];
            if !self.update_scalar(&by_states, None, innovation[axis], noise) {
                contradiction[axis] = innovation[axis];
            }
        }
        contradiction
    }

    /// Updates by the range (m) of the laser along the optical axis and its standard error. If it contradicts the
    /// state, it is ignored, and its difference from the range that the state expects is returned, as a part of the
    /// latter; otherwise 0.
    pub fn update_range(&mut self, range: f64, error: f64) -> f64 {
        let axis = self.pose.rotation.column(2).into_owned();
        let normal = normal(&self.slope);
        let towards = normal.dot(&axis);
        if towards < 0.5 {
            return 0.0;
        }
        let expected = -normal.dot(&self.pose.position) / towards;
        let hit = self.pose.position + axis * expected;
        let cell = self.cell(&hit);
        let noise = (LASER_SIGMA * self.max_height_sigma).powi(2) + error * error;
        // Higher ground and a lower camera have a shorter range.
        let by = -1.0 / towards;
        let by_states = [(POSITION + 2, by), (SLOPE, -by * hit.x), (SLOPE + 1, -by * hit.y)];
        if self.update_scalar(&by_states, Some((cell, by)), range - expected, noise) {
            0.0
        } else {
            range / expected - 1.0
        }
    }

    /// Schmidt's update by one scalar with derivatives by some states and the height of a cell. Returns `false` if the
    /// innovation is not one by chance; then nothing changes.
    fn update_scalar(
        &mut self,
        by: &[(usize, f64)],
        height: Option<(usize, f64)>,
        innovation: f64,
        noise: f64,
    ) -> bool {
        let height_variance = self.height_variance();
        let mut column = [0.0; STATES];
        for (row, value) in column.iter_mut().enumerate() {
            *value = by.iter().map(|(state, factor)| factor * self.at(row, *state)).sum::<f64>()
                + height.map_or(0.0, |(cell, factor)| factor * self.cross[row * CELLS + cell]);
        }
        let own: f64 = by.iter().map(|(state, factor)| factor * column[*state]).sum();
        let of_height = height.map_or(0.0, |(cell, factor)| {
            let cross: f64 = by.iter().map(|(state, k)| k * self.cross[state * CELLS + cell]).sum();
            factor * (cross + factor * height_variance)
        });
        let variance = own + of_height + noise;
        // Five standard deviations: not by chance.
        if innovation * innovation > 25.0 * variance {
            return false;
        }
        if let Some((cell, _)) = height {
            self.grid.set_correlated(cell);
        }
        let gain = column.map(|value| value / variance);
        for cell in 0..CELLS {
            let mut along: f64 = by.iter().map(|(state, factor)| factor * self.cross[state * CELLS + cell]).sum();
            if let Some((_, factor)) = height.filter(|(touched, _)| *touched == cell) {
                along += factor * height_variance;
            }
            if along != 0.0 {
                (0..STATES).for_each(|row| self.cross[row * CELLS + cell] -= gain[row] * along);
            }
        }
        for (row, gain) in self.covariance.chunks_exact_mut(STATES).zip(&gain) {
            row.iter_mut().zip(&column).for_each(|(value, other)| *value -= gain * other);
        }
        self.correct(&gain.map(|value| value * innovation));
        true
    }
}
