//! The stimulus: a frame, its register values, its fault, and the pauses of the streams.

use hoverlock_design::{DesignPoint, KT27};
use hoverlock_fixed_point::model::coefficients::CoefficientError;
use hoverlock_harness::bus::stream::Frame;
use hoverlock_reference::image::plane::Plane;

use crate::SimulationError;
use hoverlock_registers::record::default_limit;
use hoverlock_registers::{COEFFICIENTS_OFFSET, Register};
use hoverlock_rtl::registers::{default_coefficients, registers};

/// A frame with the register values that it captures.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    /// The pixels, in steps of the camera.
    pub pixels: Plane<u16>,
    /// The coefficients, in the order of the registers.
    pub coefficients: Vec<u32>,
    /// `T_k`, one for each scale pair of the design; in automatic mode those of the first such frame.
    pub thresholds: Vec<u32>,
    /// Automatic mode with this target: the thresholds follow the responses of the previous frame.
    pub automatic: Option<u32>,
    /// Most features that the frame sends, 0 to 65535.
    pub record_limit: u32,
    /// Fault of the frame at the input.
    pub fault: Fault,
}

/// A fault of a frame at the input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Fault {
    /// The frame is whole.
    #[default]
    None,
    /// Only this number of pixels, the last with end of packet.
    Short(usize),
    /// This number of pixels too many, the last of them with end of packet.
    Long(usize),
    /// Only this number of pixels and no end of packet: the next frame begins.
    Interrupted(usize),
    /// The reset input after this number of pixels: it clears registers, pipeline and FIFO. Records still inside are
    /// lost.
    Reset(usize),
    /// The same by the control register, which leaves the registers alone.
    Clear(usize),
}

impl Job {
    /// Creates a frame with the coefficients and the record limit of a design and manual thresholds.
    ///
    /// # Errors
    /// If the design has no coefficients.
    pub fn of(
        design: &DesignPoint,
        pixels: Plane<u16>,
        thresholds: impl Into<Vec<u32>>,
    ) -> Result<Self, CoefficientError> {
        let coefficients = default_coefficients(design)?;
        let (thresholds, record_limit) = (thresholds.into(), default_limit(design.pairs()));
        Ok(Self { pixels, coefficients, thresholds, automatic: None, record_limit, fault: Fault::None })
    }

    /// Creates a frame of the default design.
    ///
    /// # Errors
    /// As [`Job::of`].
    pub fn new(pixels: Plane<u16>, thresholds: impl Into<Vec<u32>>) -> Result<Self, CoefficientError> {
        Self::of(&KT27, pixels, thresholds)
    }

    /// Returns width and height, pixels.
    pub(super) fn size(&self) -> (usize, usize) {
        (self.pixels.width(), self.pixels.height())
    }

    /// Returns the number of beats that the source sends.
    pub(super) fn beats(&self) -> usize {
        match self.fault {
            Fault::None => self.pixels.as_slice().len(),
            Fault::Long(more) => self.pixels.as_slice().len() + more,
            Fault::Short(count) | Fault::Interrupted(count) | Fault::Reset(count) | Fault::Clear(count) => count.max(1),
        }
    }

    /// Returns the frame as the source sends it; `largest` is the largest pixel. Beats beyond its end are arbitrary.
    pub(super) fn frame(&self, largest: u64) -> Frame {
        let pixels = self.pixels.as_slice();
        let last = pixels.last().copied().unwrap_or_default();
        let symbol = |i: usize| u64::from(pixels.get(i).copied().unwrap_or(last ^ i as u16)) & largest;
        let frame = Frame::new(&(0..self.beats()).map(symbol).collect::<Vec<_>>());
        match self.fault {
            Fault::None | Fault::Short(_) | Fault::Long(_) => frame,
            Fault::Interrupted(_) | Fault::Reset(_) | Fault::Clear(_) => frame.without_end(),
        }
    }

    /// Returns the frame as the hardware completes it: a short one with its last pixel.
    pub(super) fn completed(&self) -> Plane<u16> {
        let (w, h) = self.size();
        let pixels = self.pixels.as_slice();
        let sent = self.beats().min(pixels.len());
        Plane::from_fn(w, h, |x, y| pixels[(y * w + x).min(sent - 1)])
    }

    /// Returns `true` if a reset clears the pipeline during the frame.
    pub(super) fn is_lost(&self) -> bool {
        matches!(self.fault, Fault::Reset(_) | Fault::Clear(_))
    }

    /// Returns the error bits of its trailer.
    pub(super) fn errors(&self) -> u32 {
        match self.fault {
            Fault::None | Fault::Reset(_) | Fault::Clear(_) => 0,
            Fault::Short(_) => 1,
            Fault::Long(_) => 2,
            Fault::Interrupted(_) => 4,
        }
    }
}

/// The pauses of both streams.
#[derive(Debug, Clone, Copy)]
pub struct Streams {
    /// Chance that no pixel is offered in a cycle.
    pub source_pause: f64,
    /// Chance that no record is taken in a cycle.
    pub sink_pause: f64,
    /// No record is taken before this cycle.
    pub sink_opens: u64,
    /// Seed of the pauses and of the initial register contents.
    pub seed: u64,
}

impl Default for Streams {
    fn default() -> Self {
        Self { source_pause: 0.0, sink_pause: 0.0, sink_opens: 0, seed: 1 }
    }
}

impl Streams {
    /// Returns `true` if the source always offers and the sink always takes: the condition of cycles per pixel.
    pub(super) fn flow(&self) -> bool {
        self.source_pause == 0.0 && self.sink_flows()
    }

    /// Returns `true` if the sink always takes: the FIFO always has room.
    pub(super) fn sink_flows(&self) -> bool {
        self.sink_pause == 0.0 && self.sink_opens == 0
    }
}

/// The register map of the bench: addresses and register values by name.
#[derive(Debug)]
pub(super) struct Map(Vec<Register>);

impl Map {
    pub fn new(design: &DesignPoint) -> Result<Self, CoefficientError> {
        Ok(Self(registers(design)?))
    }

    fn register(&self, name: &'static str) -> Result<&Register, SimulationError> {
        self.0.iter().find(|register| register.name == name).ok_or(SimulationError::Register(name))
    }

    /// Returns the byte address of a register.
    pub fn address(&self, name: &'static str) -> Result<u32, SimulationError> {
        Ok(self.register(name)?.offset)
    }

    /// Returns the mask of these fields of a register.
    pub fn mask(&self, name: &'static str, fields: &[&str]) -> Result<u32, SimulationError> {
        let of = self.register(name)?.fields.iter().filter(|field| fields.contains(&field.name.as_str()));
        Ok(of.fold(0, |mask, field| mask | (u32::MAX >> (32 - field.bits)) << field.low))
    }

    /// Returns the address of a register and its value with these field values, in their order.
    fn word(&self, name: &'static str, values: &[u32]) -> Result<(u32, u32), SimulationError> {
        let register = self.register(name)?;
        let fields = register.fields.iter().zip(values);
        Ok((register.offset, fields.fold(0, |word, (field, value)| word | value << field.low)))
    }

    /// Returns the register writes before a frame; the last one commits the set.
    pub fn writes(&self, job: &Job) -> Result<Vec<(u32, u32)>, SimulationError> {
        let (w, h) = job.size();
        let coefficients = job.coefficients.iter().enumerate();
        let mut writes: Vec<_> = coefficients.map(|(i, raw)| (COEFFICIENTS_OFFSET + 4 * i as u32, *raw)).collect();
        writes.push(self.word("size", &[w as u32, h as u32])?);
        for (name, thresholds) in ["threshold", "threshold_2"].into_iter().zip(job.thresholds.chunks(2)) {
            writes.push(self.word(name, thresholds)?);
        }
        if let Some(target) = job.automatic {
            writes.push(self.word("target", &[target])?);
        }
        writes.push(self.word("record_limit", &[job.record_limit])?);
        writes.push(self.word("control", &[1, u32::from(job.automatic.is_some())])?);
        writes.push(self.word("commit", &[1])?);
        Ok(writes)
    }

    /// Returns the write that clears the pipeline.
    pub fn clear(&self) -> Result<(u32, u32), SimulationError> {
        self.word("control", &[1, 0, 0, 0, 1])
    }
}
