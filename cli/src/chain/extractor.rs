//! Where the feature packets of the frames come from: floating point, integers, or the hardware.

use anyhow::{Result, bail};
use clap::ValueEnum;
use hoverlock_arm::bus::Bus;
use hoverlock_arm::hardware::{Fpga, Size};
use hoverlock_arm::message::encode_frame;
use hoverlock_arm::setup::{Thresholds, set_up};
use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::model::bit_true::{FeatureRecord, ThresholdController, counts};
use hoverlock_fixed_point::model::design::camera_samples;
use hoverlock_fixed_point::model::quickest::Quickest;
use hoverlock_reference::features::extractor::Selection;
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::image::plane::Plane;
use hoverlock_simulation::board::{Driver, RegisterPort};
use hoverlock_simulation::{SimulationError, Simulator, Trace};

use crate::float::float_features;
use crate::output::spinning;

/// Clock cycles from an interrupt to the CPU's first access: 20 us at 100 MHz.
const LATENCY: u64 = 2_000;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Source {
    /// The reference in f32, its responses rounded to the LSB of the records
    Float,
    /// The bit-true integer model
    Fixed,
    /// The emitted Verilog under Verilator, its records through a DMA and a ring of buffers
    Rtl,
}

/// The features of a frame at its thresholds.
pub type Features = Box<dyn FnMut(&Plane<u16>, &[u32]) -> Vec<FeatureRecord>>;

/// A packet for each frame, with the thresholds that follow the count of the frame before.
pub enum Extractor {
    /// A model, the control of its thresholds, and how many frames it has had.
    Model { features: Features, control: ThresholdController, frames: u32 },
    /// The hardware, which has its own control.
    Rtl { driver: Box<Driver>, design: Box<DesignPoint> },
}

impl Extractor {
    /// An extractor whose thresholds have settled on the first frame, as of a camera that has looked at it for a while.
    /// `fpga` is what the hardware is expected to be.
    pub fn new(source: Source, design: &DesignPoint, fpga: &Fpga, first: &Plane<u16>) -> Result<Self> {
        let model = |features, thresholds: &[u32]| {
            let control = ThresholdController::resumed(design, thresholds);
            Self::Model { features, control, frames: 0 }
        };
        Ok(match source {
            Source::Float => {
                let selection = Selection { threshold: design.dog().lsb(), count: usize::MAX };
                let (design, mut extract) = (design.clone(), float_features(design, selection)?);
                let all = records(&design, &extract(first));
                let mut control = ThresholdController::new(&design);
                control.settle(|thresholds| counts(&above(&all, thresholds)));
                let features =
                    move |frame: &Plane<u16>, thresholds: &[u32]| above(&records(&design, &extract(frame)), thresholds);
                model(Box::new(features), control.thresholds())
            }
            Source::Fixed => {
                let (width, height) = (design.width as usize, design.height as usize);
                if first.width() > width || first.height() > height {
                    bail!(
                        "frames of {} x {} px: the design takes {width} x {height} at most; change it with --config \
                         width={} --config height={}",
                        first.width(),
                        first.height(),
                        first.width(),
                        first.height()
                    );
                }
                let (design, mut quickest) = (design.clone(), Quickest::new(design)?);
                let thresholds = quickest.settled(&camera_samples(&design, first));
                let features = move |frame: &Plane<u16>, thresholds: &[u32]| {
                    quickest.features(&camera_samples(&design, frame), thresholds)
                };
                model(Box::new(features), &thresholds)
            }
            Source::Rtl => {
                let size = Size::new(fpga, first.width() as u32, first.height() as u32)?;
                let settled = Quickest::new(design)?.settled(&camera_samples(design, first));
                let thresholds = std::array::from_fn(|k| settled.get(k).copied().unwrap_or_default());
                let build = || Simulator::of_design(design, None, Trace::None);
                let simulator = spinning("building the Verilated model (once; later runs find it)", build)?;
                let driver = Driver::start(&simulator, LATENCY, |port| {
                    Ok::<_, anyhow::Error>(set_up(&mut Port(port), fpga, size, Thresholds::Automatic(thresholds))?)
                });
                Self::Rtl { driver: Box::new(driver?), design: Box::new(design.clone()) }
            }
        })
    }

    /// The registers that were read: those of the hardware where there is one.
    pub fn registers(&self) -> Option<&[(u32, u32)]> {
        match self {
            Self::Rtl { driver, .. } => Some(driver.registers()),
            Self::Model { .. } => None,
        }
    }

    /// Clock cycles simulated so far, where hardware is.
    pub fn cycles(&self) -> Option<u64> {
        match self {
            Self::Rtl { driver, .. } => Some(driver.cycles()),
            Self::Model { .. } => None,
        }
    }

    /// The packet of the next frame: its records, the trailer last.
    pub fn packet(&mut self, frame: &Plane<u16>) -> Result<Vec<u8>> {
        match self {
            Self::Rtl { driver, design } => {
                driver.send(camera_samples(design, frame));
                match driver.packet()? {
                    Some(packet) => Ok(packet.bytes),
                    None => bail!("the hardware gives no packet for a frame"),
                }
            }
            Self::Model { features, control, frames } => {
                let thresholds = control.thresholds().to_vec();
                let found = features(frame, control.thresholds());
                control.finish_frame(&counts(&found));
                *frames += 1;
                Ok(encode_frame(*frames - 1, &found, 0, 0, &thresholds))
            }
        }
    }
}

/// The registers of the simulated board, for the flight program.
struct Port<'p, 'f>(&'p mut RegisterPort<'f>);

impl Bus for Port<'_, '_> {
    type Error = SimulationError;

    fn read(&mut self, address: u32) -> Result<u32, SimulationError> {
        self.0.read(address)
    }

    fn write(&mut self, address: u32, value: u32) -> Result<(), SimulationError> {
        self.0.write(address, value)
    }
}

/// Features as the hardware would send them: responses in LSB of the DoG.
fn records(design: &DesignPoint, features: &[Feature]) -> Vec<FeatureRecord> {
    let lsb = |dn: f64| (dn / design.dog().lsb()).round().clamp(0.0, f64::from(design.max_dog())) as u16;
    let record = |feature: &Feature| FeatureRecord {
        x: feature.x as u16,
        y: feature.y as u16,
        response: lsb(feature.response),
        scale: feature.scale,
        bright: feature.bright,
        neighbours: feature.neighbours.map(lsb),
        descriptor: feature.descriptor,
    };
    features.iter().map(record).collect()
}

/// Those whose response reaches the threshold of their scale.
fn above(records: &[FeatureRecord], thresholds: &[u32]) -> Vec<FeatureRecord> {
    let reaches = |record: &&FeatureRecord| u32::from(record.response) >= thresholds[usize::from(record.scale)];
    records.iter().filter(reaches).copied().collect()
}
