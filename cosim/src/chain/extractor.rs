//! The source of the feature packets: floating point, integers, or the simulated hardware.

use hoverlock_arm::bus::Bus;
use hoverlock_arm::hardware::{Fpga, Size};
use hoverlock_arm::message::{Unsent, encode_frame};
use hoverlock_arm::setup::{Thresholds, set_up};
use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::model::design::camera_samples;
use hoverlock_fixed_point::model::fastest::FastestModel;
use hoverlock_fixed_point::model::record::FeatureRecord;
use hoverlock_fixed_point::model::record_limit::RecordLimit;
use hoverlock_fixed_point::model::threshold::{Maxima, ThresholdController};
use hoverlock_reference::features::extractor::Selection;
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::image::plane::Plane;
use hoverlock_registers::record::default_limit;
use hoverlock_simulation::board::{Driver, RegisterPort};
use hoverlock_simulation::{SimulationError, Simulator, Trace};

use super::{ChainError, FeatureSource, float_features};
use crate::Monitor;

/// Clock cycles from an interrupt to the CPU's first access: 20 us at 100 MHz.
const INTERRUPT_LATENCY_CYCLES: u64 = 2_000;

/// A function that returns the features of a frame that reach the thresholds, and the maxima of each scale pair.
type Features = Box<dyn FnMut(&Plane<u16>, &[u32]) -> (Vec<FeatureRecord>, Vec<Maxima>)>;

/// An extractor that makes a packet for each frame. The thresholds follow the responses of the frame before.
pub(super) enum Extractor {
    /// A model, the control of its thresholds, the largest response, and the number of frames so far.
    Model { features: Features, control: ThresholdController, max: u32, frames: u32 },
    /// The simulated hardware, which controls its thresholds itself.
    Rtl { driver: Box<Driver>, design: Box<DesignPoint> },
}

impl Extractor {
    /// Creates an extractor whose thresholds have settled on the first frame, like those of a camera that has looked at
    /// it for a while. `fpga` is the hardware that is expected.
    pub(super) fn new(
        source: FeatureSource,
        design: &DesignPoint,
        fpga: &Fpga,
        first: &Plane<u16>,
        monitor: &dyn Monitor,
    ) -> Result<Self, ChainError> {
        match source {
            FeatureSource::Float => Self::float(design, first),
            FeatureSource::Fixed => Self::fixed(design, first),
            FeatureSource::Rtl => Self::rtl(design, fpga, first, monitor),
        }
    }

    fn model(design: &DesignPoint, features: Features, thresholds: &[u32]) -> Self {
        Self::Model {
            features,
            control: ThresholdController::resumed(design, thresholds),
            max: design.max_dog(),
            frames: 0,
        }
    }

    fn float(design: &DesignPoint, first: &Plane<u16>) -> Result<Self, ChainError> {
        let selection = Selection { threshold: design.dog().lsb(), count: usize::MAX };
        let (design, mut extract) = (design.clone(), float_features(design, selection)?);
        let mut control = ThresholdController::new(&design);
        control.settle(&maxima(&records(&design, &extract(first)), design.pairs()));
        let of = design.clone();
        let features = move |frame: &Plane<u16>, thresholds: &[u32]| {
            let all = records(&of, &extract(frame));
            (above(&all, thresholds), maxima(&all, of.pairs()))
        };
        Ok(Self::model(&design, Box::new(features), control.thresholds()))
    }

    fn fixed(design: &DesignPoint, first: &Plane<u16>) -> Result<Self, ChainError> {
        let (max_width, max_height) = (design.width as usize, design.height as usize);
        let (width, height) = (first.width(), first.height());
        if width > max_width || height > max_height {
            return Err(ChainError::FrameSize { width, height, max_width, max_height });
        }
        let (of, mut model) = (design.clone(), FastestModel::new(design)?);
        let thresholds = model.settled(&camera_samples(design, first));
        let features = move |frame: &Plane<u16>, thresholds: &[u32]| {
            let found = model.features(&camera_samples(&of, frame), thresholds);
            (found, model.maxima().to_vec())
        };
        Ok(Self::model(design, Box::new(features), &thresholds))
    }

    fn rtl(design: &DesignPoint, fpga: &Fpga, first: &Plane<u16>, monitor: &dyn Monitor) -> Result<Self, ChainError> {
        let size = Size::new(fpga, first.width() as u32, first.height() as u32)?;
        let settled = FastestModel::new(design)?.settled(&camera_samples(design, first));
        let thresholds = std::array::from_fn(|k| settled.get(k).copied().unwrap_or_default());
        let step = monitor.long_step("building the Verilated model (once; later runs find it)");
        let simulator = Simulator::of_design(design, None, Trace::None)?;
        drop(step);
        let driver = Driver::start(&simulator, INTERRUPT_LATENCY_CYCLES, |port| {
            Ok::<_, ChainError>(set_up(&mut Port(port), fpga, size, Thresholds::Automatic(thresholds))?)
        })?;
        Ok(Self::Rtl { driver: Box::new(driver), design: Box::new(design.clone()) })
    }

    /// Returns the registers of the hardware as address and value; `None` without simulated hardware.
    pub(super) fn registers(&self) -> Option<&[(u32, u32)]> {
        match self {
            Self::Rtl { driver, .. } => Some(driver.registers()),
            Self::Model { .. } => None,
        }
    }

    /// Returns the number of clock cycles simulated so far; `None` without simulated hardware.
    pub(super) fn cycles(&self) -> Option<u64> {
        match self {
            Self::Rtl { driver, .. } => Some(driver.cycles()),
            Self::Model { .. } => None,
        }
    }

    /// Returns the packet of the next frame: its records, the trailer last.
    pub(super) fn packet(&mut self, frame: &Plane<u16>) -> Result<Vec<u8>, ChainError> {
        match self {
            Self::Rtl { driver, design } => {
                driver.send(&camera_samples(design, frame))?;
                Ok(driver.packet()?.ok_or(ChainError::NoPacket)?.bytes)
            }
            Self::Model { features, control, max, frames } => {
                let thresholds = control.thresholds().to_vec();
                let (found, maxima) = features(frame, &thresholds);
                control.finish_frame(&maxima);
                *frames += 1;
                let limit = default_limit(thresholds.len());
                let sent = RecordLimit::sent(limit, &thresholds, *max, frame.height(), &found);
                let unsent = Unsent { dropped: 0, withheld: (found.len() - sent.len()) as u32 };
                Ok(encode_frame(*frames - 1, &sent, 0, unsent, &thresholds))
            }
        }
    }
}

/// The registers of the simulated board as the flight program's bus.
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

/// Converts features to the records of the hardware, with responses in LSB of the DoG.
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

/// Returns the records whose response reaches the threshold of their scale.
fn above(records: &[FeatureRecord], thresholds: &[u32]) -> Vec<FeatureRecord> {
    let reaches = |record: &&FeatureRecord| u32::from(record.response) >= thresholds[usize::from(record.scale)];
    records.iter().filter(reaches).copied().collect()
}

/// Returns the maxima of each scale pair from the records of all of them.
fn maxima(records: &[FeatureRecord], pairs: usize) -> Vec<Maxima> {
    let of_pair = |k: usize| records.iter().filter(move |record| usize::from(record.scale) == k);
    (0..pairs).map(|k| Maxima::new(of_pair(k).map(|record| record.response).collect())).collect()
}
