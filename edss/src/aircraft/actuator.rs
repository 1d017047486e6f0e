//! The servos of the blade angles: `dx/dt = (command - x) / T`, with limited rate and travel.
//!
//! The constants are assumptions typical of hydraulic servos; the source of the derivatives has none.

use nalgebra::SVector;

/// Time constant of a servo.
const TIME_CONSTANT_S: f64 = 0.04;
/// Largest rate of a blade angle, rad/s: 20 degrees/s.
const MAX_RATE: f64 = 20.0 * std::f64::consts::PI / 180.0;
/// Travel to either side of trim that the autopilot may use, rad: 4 degrees.
const MAX_TRAVEL: f64 = 4.0 * std::f64::consts::PI / 180.0;

/// The four servos: collective, longitudinal and lateral cyclic, tail rotor collective.
#[derive(Debug, Clone, PartialEq)]
pub struct Actuators {
    angles: SVector<f64, 4>,
    /// Part of the difference to the command that one step removes.
    share: f64,
    step: f64,
}

impl Actuators {
    /// Creates the servos at trim, for steps of `step` seconds.
    pub fn new(step: f64) -> Self {
        Self { angles: SVector::zeros(), share: -libm::expm1(-step / TIME_CONSTANT_S), step }
    }

    /// Returns the blade angles from trim, rad.
    pub fn angles(&self) -> SVector<f64, 4> {
        self.angles
    }

    /// Advances by one step towards the commanded angles (rad); exact for a constant command.
    pub fn advance(&mut self, command: &SVector<f64, 4>) {
        let max_change = MAX_RATE * self.step;
        self.angles = self.angles.zip_map(command, |angle, command| {
            let change = (command.clamp(-MAX_TRAVEL, MAX_TRAVEL) - angle) * self.share;
            angle + change.clamp(-max_change, max_change)
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_servo_lags_and_keeps_its_limits() {
        let mut servos = Actuators::new(0.005);
        // A small command is followed as the exponential says.
        for _ in 0..8 {
            servos.advance(&SVector::repeat(0.01));
        }
        let expected = 0.01 * (1.0 - (-1.0f64).exp());
        assert!((servos.angles()[0] - expected).abs() < 1e-12, "{}", servos.angles());
        // A large one is limited in rate, then in travel.
        let before = servos.angles()[1];
        servos.advance(&SVector::repeat(1.0));
        assert!((servos.angles()[1] - before - MAX_RATE * 0.005).abs() < 1e-12, "{}", servos.angles());
        (0..1000).for_each(|_| servos.advance(&SVector::repeat(-1.0)));
        assert!((servos.angles()[2] + MAX_TRAVEL).abs() < 1e-9, "{}", servos.angles());
    }
}
