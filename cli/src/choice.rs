//! Choices of the command line that are converted to types of the libraries.

use clap::ValueEnum;
use hoverlock_cosim::hover::CameraView;
use hoverlock_cosim::{FeatureSource, FlightProgram};
use hoverlock_edss::flight::Altitude;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Features {
    /// The reference in f32, its responses rounded to the LSB of the records
    Float,
    /// The bit-true integer model
    Fixed,
    /// The emitted Verilog under Verilator, its records through a DMA and a ring of buffers
    Rtl,
}

impl From<Features> for FeatureSource {
    fn from(choice: Features) -> Self {
        match choice {
            Features::Float => Self::Float,
            Features::Fixed => Self::Fixed,
            Features::Rtl => Self::Rtl,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Estimator {
    /// In this process
    Host,
    /// The ARM binary under qemu-arm, a Cortex-A9; its lines are compared with the host's
    Arm,
}

impl From<Estimator> for FlightProgram {
    fn from(choice: Estimator) -> Self {
        match choice {
            Estimator::Host => Self::Host,
            Estimator::Arm => Self::Arm,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum View {
    /// 50 degrees
    Wide,
    /// 50 degrees to acquire the reference, and 10 degrees after 2 s
    Narrow,
}

impl From<View> for CameraView {
    fn from(choice: View) -> Self {
        match choice {
            View::Wide => Self::Wide,
            View::Narrow => Self::Narrow,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Climb {
    /// The height is held
    Hold,
    /// A sine of 5 m in 20 s
    Smooth,
    /// Steps of 5 m every 10 s
    Abrupt,
}

impl From<Climb> for Altitude {
    fn from(choice: Climb) -> Self {
        match choice {
            Climb::Hold => Self::Hold,
            Climb::Smooth => Self::Smooth,
            Climb::Abrupt => Self::Abrupt,
        }
    }
}

/// Returns a parser of numbers within limits.
pub fn between(min: f64, max: f64) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| match text.parse::<f64>() {
        Ok(value) if (min..=max).contains(&value) => Ok(value),
        Ok(_) => Err(format!("must be {min} to {max}")),
        Err(_) => Err(format!("is no number; it must be {min} to {max}")),
    }
}
