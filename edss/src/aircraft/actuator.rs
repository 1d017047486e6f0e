//! A blade angle's servo: `dx/dt = (command - x) / T`, its rate and its travel limited.
//!
//! The figures are ours, of the order of hydraulic servos; the source of the derivatives gives none.

use nalgebra::SVector;

/// Time constant, s.
const LAG: f64 = 0.04;
/// Largest rate, rad/s: 20 degrees a second.
const RATE: f64 = 20.0 * std::f64::consts::PI / 180.0;
/// Travel to either side of trim, rad, which the autopilot may use: 4 degrees.
const TRAVEL: f64 = 4.0 * std::f64::consts::PI / 180.0;

/// The four servos: collective, longitudinal and lateral cyclic, tail rotor collective.
#[derive(Debug, Clone, PartialEq)]
pub struct Actuators {
    angles: SVector<f64, 4>,
    share: f64,
    step: f64,
}

impl Actuators {
    /// At trim, for steps of so many seconds.
    pub fn new(step: f64) -> Self {
        Self { angles: SVector::zeros(), share: -libm::expm1(-step / LAG), step }
    }

    /// Blade angles from trim, rad.
    pub fn angles(&self) -> SVector<f64, 4> {
        self.angles
    }

    /// A step towards the commanded angles, exact for a command that stands still.
    pub fn advance(&mut self, command: &SVector<f64, 4>) {
        let most = RATE * self.step;
        self.angles = self.angles.zip_map(command, |angle, command| {
            let change = (command.clamp(-TRAVEL, TRAVEL) - angle) * self.share;
            angle + change.clamp(-most, most)
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
        assert!((servos.angles()[1] - before - RATE * 0.005).abs() < 1e-12, "{}", servos.angles());
        (0..1000).for_each(|_| servos.advance(&SVector::repeat(-1.0)));
        assert!((servos.angles()[2] + TRAVEL).abs() < 1e-9, "{}", servos.angles());
    }
}
