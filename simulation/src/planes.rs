//! The sample comparisons: every smoothed sample, DoG and MaxDOG of a frame against `bit_true`, in the step in which it
//! is visible.
//!
//! One step after `start_out` the smoothers show sample `(0, 0)`, and one more with every step; the response follows
//! [`RESPONSE_STEPS`] later, MaxDOG two lines and some steps after that. MaxDOG is compared where its window lies in
//! the frame: other values are never used.

use std::sync::Arc;

use hoverlock_design::pipeline::{DIFFERENCE_STEPS, MAX_DOG_RADIUS, MAX_DOG_STEPS};
use hoverlock_design::{DesignPoint, smoother_names};
use hoverlock_fixed_point::model::bit_true::Planes;
use hoverlock_reference::features::{feature::MAX_PAIRS, maxlbp::Layer};

use crate::outcome::{Outcome, Position};

/// Steps from the smoothed sample to its response.
const RESPONSE_STEPS: usize = DIFFERENCE_STEPS as usize;
/// Half a window of MaxDOG.
const RADIUS: usize = MAX_DOG_RADIUS as usize;

/// The values of the hardware in a step. Those of smoothers and scale pairs that the design does not have are 0 and not
/// compared.
pub(super) struct Shown {
    pub smoothed: [u32; MAX_PAIRS + 1],
    pub response: [u32; MAX_PAIRS],
    pub ring: [u32; MAX_PAIRS],
}

/// The units of the samples of a design.
#[derive(Debug, Clone, Copy)]
pub(super) struct Units {
    /// LSB of a state, DN.
    state: f64,
    /// LSB of a response, DN.
    dog: f64,
    /// Bit of the sign of a response.
    sign: u32,
}

impl Units {
    pub fn of(design: &DesignPoint) -> Self {
        Self { state: design.state_dn().lsb(), dog: design.dog().lsb(), sign: design.dog_bits }
    }

    /// Returns a response with its sign.
    fn signed(self, magnitude: u16, positive: bool) -> u32 {
        u32::from(magnitude) | u32::from(positive) << self.sign
    }
}

/// A frame whose samples are in the pipeline.
pub(super) struct Passing {
    pub frame: usize,
    planes: Arc<Planes>,
    units: Units,
    /// Steps since its first smoothed sample.
    step: usize,
    /// Position of the next MaxDOG value.
    ring: (usize, usize),
    size: (usize, usize),
}

impl Passing {
    pub fn new(frame: usize, planes: Arc<Planes>, units: Units) -> Self {
        let size = (planes.smoothed[0].width(), planes.smoothed[0].height());
        Self { frame, planes, units, step: 0, ring: (0, 0), size }
    }

    fn ring_delay(&self) -> usize {
        RESPONSE_STEPS + RADIUS * self.size.0 + MAX_DOG_STEPS as usize
    }

    /// Returns `true` if all samples were compared.
    pub fn is_through(&self) -> bool {
        self.ring.1 == self.size.1
    }

    /// Compares the values of a step.
    #[inline]
    pub fn compare(&mut self, shown: &Shown, cycle: u64, outcome: &mut Outcome) {
        let (w, h) = self.size;
        let (planes, units) = (&*self.planes, self.units);
        let samples = w * h;
        let position = |index: usize| Position { frame: self.frame, x: index % w, y: index / w };
        if self.step < samples {
            for (i, (plane, got)) in planes.smoothed.iter().zip(shown.smoothed).enumerate() {
                let want = plane.as_slice()[self.step];
                if want != got {
                    let text = |state: u32| format!("0x{state:05x}, {} DN", f64::from(state) * units.state);
                    let name = smoother_names(planes.smoothed.len())[i];
                    outcome.differ(&format!("smoother {name}"), position(self.step), cycle, || {
                        ["sample".into(), text(want), text(got)]
                    });
                }
            }
            outcome.samples += planes.smoothed.len() as u64;
        }
        let text = |sample: u32| {
            let sign = if sample >> units.sign == 1 { '+' } else { '-' };
            format!("0x{sample:04x}, {sign}{} DN", f64::from(sample & ((1 << units.sign) - 1)) * units.dog)
        };
        if let Some(index) = self.step.checked_sub(RESPONSE_STEPS).filter(|index| *index < samples) {
            for (k, (layer, got)) in planes.layers.iter().zip(shown.response).enumerate() {
                let Layer { dog, .. } = layer;
                let want = units.signed(dog.magnitude.as_slice()[index], dog.positive.as_slice()[index]);
                if want != got {
                    outcome.differ(&format!("DoG {k}"), position(index), cycle, || {
                        ["sign and response".into(), text(want), text(got)]
                    });
                }
            }
            outcome.samples += planes.layers.len() as u64;
        }
        if self.step >= self.ring_delay() && !self.is_through() {
            let (x, y) = self.ring;
            if (RADIUS..w - RADIUS).contains(&x) && (RADIUS..h - RADIUS).contains(&y) {
                let index = y * w + x;
                for (k, (layer, got)) in planes.layers.iter().zip(shown.ring).enumerate() {
                    let Layer { dog, max_dog, .. } = layer;
                    let want = units.signed(max_dog.as_slice()[index], dog.positive.as_slice()[index]);
                    if want != got {
                        outcome.differ(&format!("MaxDOG {k}"), position(index), cycle, || {
                            ["sign and maximum".into(), text(want), text(got)]
                        });
                    }
                }
                outcome.samples += planes.layers.len() as u64;
            }
            self.ring = if x + 1 == w { (0, y + 1) } else { (x + 1, y) };
        }
        self.step += 1;
    }
}
