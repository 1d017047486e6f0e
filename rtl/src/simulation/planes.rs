//! The sample comparisons: every smoothed sample, DoG and MaxDOG of a frame against `bit_true`, in the step where it is
//! visible.
//!
//! One step after `start_out` the smoothers show sample `(0, 0)`, and one more with every step; the response follows
//! [`RESPONSE_STEPS`] later, MaxDOG two lines and some steps after that. MaxDOG is compared where its window lies in
//! the frame: other values are never used.

use std::sync::Arc;

use hoverlock_fixed_point::model::bit_true::Planes;
use hoverlock_reference::features::maxlbp::Layer;

use super::outcome::{Outcome, Position};

/// Steps from the smoothed sample to its response.
const RESPONSE_STEPS: usize = 2;
/// Steps from the response to the ring sample of the same line.
const RING_STEPS: usize = 6;
/// Half a window of MaxDOG.
const RADIUS: usize = 2;

/// The smoothers by name.
const SMOOTHERS: [&str; 3] = ["narrow", "middle", "wide"];

/// The values of the hardware in a step.
pub(super) struct Shown {
    pub smoothed: [u32; 3],
    pub response: [u16; 2],
    pub ring: [u16; 2],
}

/// A frame whose samples are in the pipeline.
pub(super) struct Passing {
    pub frame: usize,
    planes: Arc<Planes>,
    /// Steps since its first smoothed sample.
    step: usize,
    /// Position of the next MaxDOG value.
    ring: (usize, usize),
    size: (usize, usize),
}

impl Passing {
    pub fn new(frame: usize, planes: Arc<Planes>) -> Self {
        let size = (planes.smoothed[0].width(), planes.smoothed[0].height());
        Self { frame, planes, step: 0, ring: (0, 0), size }
    }

    fn ring_delay(&self) -> usize {
        RESPONSE_STEPS + RING_STEPS + RADIUS * self.size.0 + RADIUS
    }

    /// All samples were compared.
    pub fn is_through(&self) -> bool {
        self.ring.1 == self.size.1
    }

    /// Compares the values of a step.
    #[inline]
    pub fn compare(&mut self, shown: &Shown, cycle: u64, outcome: &mut Outcome) {
        let (w, h) = self.size;
        let planes = &*self.planes;
        let samples = w * h;
        let position = |index: usize| Position { frame: self.frame, x: index % w, y: index / w };
        if self.step < samples {
            for (i, got) in shown.smoothed.into_iter().enumerate() {
                let want = planes.smoothed[i].as_slice()[self.step];
                if want != got {
                    let units = |state: u32| format!("0x{state:05x}, {} DN", f64::from(state) / 4.0);
                    outcome.differ(&format!("smoother {}", SMOOTHERS[i]), position(self.step), cycle, || {
                        ["sample".into(), units(want), units(got)]
                    });
                }
            }
            outcome.samples += 3;
        }
        let units = |sample: u16| {
            let sign = if sample >> 15 == 1 { '+' } else { '-' };
            format!("0x{sample:04x}, {sign}{} DN", f64::from(sample & 0x7fff) / 2.0)
        };
        if let Some(index) = self.step.checked_sub(RESPONSE_STEPS).filter(|index| *index < samples) {
            for (k, got) in shown.response.into_iter().enumerate() {
                let Layer { dog, .. } = &planes.layers[k];
                let want = dog.magnitude.as_slice()[index] | u16::from(dog.positive.as_slice()[index]) << 15;
                if want != got {
                    outcome.differ(&format!("DoG {k}"), position(index), cycle, || {
                        ["sign and response".into(), units(want), units(got)]
                    });
                }
            }
            outcome.samples += 2;
        }
        if self.step >= self.ring_delay() && !self.is_through() {
            let (x, y) = self.ring;
            if (RADIUS..w - RADIUS).contains(&x) && (RADIUS..h - RADIUS).contains(&y) {
                let index = y * w + x;
                for (k, got) in shown.ring.into_iter().enumerate() {
                    let Layer { dog, max_dog } = &planes.layers[k];
                    let want = max_dog.as_slice()[index] | u16::from(dog.positive.as_slice()[index]) << 15;
                    if want != got {
                        outcome.differ(&format!("MaxDOG {k}"), position(index), cycle, || {
                            ["sign and maximum".into(), units(want), units(got)]
                        });
                    }
                }
                outcome.samples += 2;
            }
            self.ring = if x + 1 == w { (0, y + 1) } else { (x + 1, y) };
        }
        self.step += 1;
    }
}
