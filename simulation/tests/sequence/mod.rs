//! Random sequences of frames through the top, from its ports only, compared with `bit_true`.
//!
//! Every frame has its own size, content, registers, gap and pauses; some are cut short, too long or interrupted;
//! resets, stray beats, a disabled core, impossible sizes, closed sinks and register writes at any moment come between.
//! A sequence is a JSON text, so it can be played again, and [`shrunk`] makes the one that fails shorter.
//!
//! What is compared: every record and trailer, the status bits, the counts in the registers. Where registers are
//! committed in the very cycles in which a frame begins, either set may be the frame's, but one of them whole.

#![allow(dead_code, reason = "each test binary uses its part")]

mod play;
pub mod shrink;

use hoverlock_design::{DesignPoint, MAX_ROWS};
use hoverlock_fixed_point::model::design::camera_samples;
use hoverlock_reference::image::plane::Plane;
use hoverlock_simulation::Simulator;
use rand::{RngExt, SeedableRng, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::port_bench::{Beat, Outcome, latency, lattice, noise, white};
pub use play::Tally;

/// Frames one after the other, from a hardware reset.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sequence {
    /// Decides the pauses, the cycles of register accesses, and what registers and memories hold at first.
    pub seed: u64,
    pub frames: Vec<Step>,
}

/// One frame, and what happens around it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Step {
    pub width: usize,
    pub height: usize,
    pub content: Content,
    pub pixels: u64,
    pub fault: Fault,
    pub before: Before,
    /// Cycles without a beat before the first one; 0 sends it right behind the last beat of the frame before.
    pub gap: u64,
    /// Cycles in a hundred in which the source offers nothing, and in which the sink takes nothing.
    pub pauses: [u32; 2],
    /// Cycles from the frame's first beat on in which the sink takes nothing at all.
    pub closed: u64,
    /// Seed of random coefficients; without it, those of the design point.
    pub coefficients: Option<u64>,
    pub thresholds: Vec<u32>,
    pub target: u32,
    pub automatic: bool,
    /// Most features that the frame sends.
    pub record_limit: u32,
    /// The registers are written while the frame begins, with this number of beats of the frame before still to come;
    /// otherwise ahead of it. Only behind a frame of the same size.
    pub racing: Option<usize>,
    /// Once the frame has begun, registers are written that nobody commits.
    pub scribbles: bool,
    pub reset: Option<Reset>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Content {
    /// Grey noise over a slope.
    Noise,
    /// Few grey levels: ties, and responses equal to the threshold.
    Faint,
    /// White and black blocks: large responses, some of them cut with coefficients far from those of the design point.
    Blocks,
    /// As many maxima as there can be.
    Lattice,
    /// One grey.
    Flat,
}

/// How the frame's packet differs from a whole one, in beats.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Fault {
    None,
    /// End of packet at this beat.
    Short(usize),
    /// So many beats too many, with an end of packet or without one.
    Long(usize, bool),
    /// The next frame starts after this beat.
    Interrupted(usize),
}

/// What comes before the frame's registers are written.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Before {
    Nothing,
    /// Beats without a start, the last with an end.
    Stray(usize),
    /// A packet while the core is disabled, with a start of packet or without one.
    Disabled(usize, bool),
    /// A packet of an impossible size.
    Refused(u32, u32),
}

/// A reset, `cycles` cycles after the top has taken `beats` beats of the frame: by the port `reset` if `hard`,
/// otherwise by the clear bit of the register `control`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Reset {
    pub hard: bool,
    pub beats: usize,
    pub cycles: u64,
}

impl Sequence {
    /// A sequence of some frames for a design, all of it decided by the seed.
    pub fn random(design: &DesignPoint, seed: u64, frames: usize) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut sequence = Self { seed, frames: Vec::new() };
        // Numbers of their own, so that the other sequences stay what they are.
        let mut crowding = ChaCha8Rng::seed_from_u64(!seed);
        let crowd = (seed.is_multiple_of(4)).then(|| Crowd::random(design, &mut crowding));
        let mut heights = ChaCha8Rng::seed_from_u64(seed ^ 0x7a11);
        for _ in 0..frames {
            let before = sequence.frames.last().map(|step: &Step| (step.width, step.height));
            let step = Step::random(design, &mut random, before);
            sequence.frames.push(match &crowd {
                Some(crowd) => crowd.join(step, &mut crowding),
                // One in thirty is higher than those that come often, up to the highest.
                None if heights.random_ratio(1, 30) => Step {
                    width: heights.random_range(64..=80),
                    height: heights.random_range(257..=MAX_ROWS as usize),
                    ..step
                },
                None => step,
            });
        }
        sequence.agreed()
    }

    /// The same with nothing in it that contradicts itself, so that frames can be left out at will.
    pub fn agreed(mut self) -> Self {
        let mut before: Option<Step> = None;
        let last = self.frames.len().saturating_sub(1);
        for (i, step) in self.frames.iter_mut().enumerate() {
            let size = step.width * step.height;
            match &mut step.fault {
                Fault::Short(beats) | Fault::Interrupted(beats) => *beats = (*beats).clamp(1, size - 1),
                Fault::Long(0, ends) => *ends = false,
                _ => {}
            }
            if let (Fault::Interrupted(_), true) = (step.fault, i == last) {
                step.fault = Fault::None;
            }
            // What has no end, or waits for a start, has the next frame's start to end it.
            let open = before.as_ref().is_some_and(|before| {
                before.reset.is_none() && matches!(before.fault, Fault::Interrupted(_) | Fault::Long(_, false))
            });
            if open {
                step.before = Before::Nothing;
            }
            let same = before.as_ref().is_some_and(|before| {
                before.reset.is_none() && (before.width, before.height) == (step.width, step.height)
            });
            if !same || step.before != Before::Nothing {
                step.racing = None;
            }
            before = Some(step.clone());
        }
        self
    }

    pub fn play(&self, simulator: &Simulator) -> Outcome<Tally> {
        play::play(self, simulator)
    }

    /// The text that plays it again.
    pub fn text(&self) -> String {
        serde_json::to_string(self).unwrap()
    }
}

/// Small frames of one size, more than half of them with a fault, so close that each ends in some clock around the
/// trailer of the one before: several error tags are on their way, and come and go at once.
struct Crowd {
    width: usize,
    height: usize,
    /// Cycles between two frames that let the second end with the trailer of the first, about.
    gap: usize,
}

impl Crowd {
    fn random(design: &DesignPoint, random: &mut ChaCha8Rng) -> Self {
        let (lines, cycles) = latency(design);
        // From a frame's last pixel to the trailer in the pipeline: the FIFO and its output come behind.
        let (lines, steps) = (lines as usize, cycles as usize - 7);
        // As high as the pipeline, or one row more and so wide that the steps of the latency are that row.
        let (width, height) = match random.random_bool(0.5) {
            true => (random.random_range(64..=96), random.random_range(64..=lines.max(64))),
            false => (steps + random.random_range(2..9), lines.max(63) + 1),
        };
        Self { width, height, gap: (lines * width + steps).saturating_sub(width * height) }
    }

    fn join(&self, step: Step, random: &mut ChaCha8Rng) -> Step {
        let size = self.width * self.height;
        let fault = match random.random_range(0..8) {
            0..3 => Fault::Short(size - random.random_range(1..4)),
            3 => Fault::Interrupted(size - random.random_range(1..4)),
            4 => Fault::Long(random.random_range(0..4), random.random()),
            _ => Fault::None,
        };
        let gap = match self.gap {
            0 => 0,
            gap => (gap + random.random_range(0..8)) as u64,
        };
        let (width, height) = (self.width, self.height);
        let (pauses, closed, before, reset) = ([0, 0], 0, Before::Nothing, None);
        Step { width, height, fault, gap, pauses, closed, before, reset, ..step }
    }
}

impl Step {
    fn random(design: &DesignPoint, random: &mut ChaCha8Rng, before: Option<(usize, usize)>) -> Self {
        // Most frames are small, so that there are many; every width and height comes.
        let width = match random.random_range(0..10) {
            0..5 => random.random_range(64..=128),
            5..9 => random.random_range(64..=320),
            _ => random.random_range(64..=design.width as usize),
        };
        // At 64 lines the next frame begins while this one is still in the columns.
        let height = match random.random_range(0..8) {
            0 | 1 => random.random_range(64..=66),
            2..6 => random.random_range(64..=96),
            _ => random.random_range(64..=256),
        };
        let (width, height) = before.filter(|_| random.random_ratio(1, 4)).unwrap_or((width, height));
        let size = width * height;
        let content =
            *[Content::Noise, Content::Noise, Content::Faint, Content::Blocks, Content::Lattice, Content::Flat]
                .choose(random)
                .unwrap();
        let fault = match random.random_range(0..20) {
            0 => Fault::Short(random.random_range(1..size)),
            1 => Fault::Long(random.random_range(0..200), random.random()),
            2 => Fault::Interrupted(random.random_range(1..size)),
            3 => Fault::Short(size - 1),
            // So short that all of it waits in the skid buffer.
            4 => Fault::Short(random.random_range(1..4)),
            _ => Fault::None,
        };
        let before = match random.random_range(0..24) {
            0 => Before::Stray(random.random_range(1..40)),
            1 => Before::Disabled(random.random_range(5..40), random.random()),
            2 => *[
                Before::Refused(63, 64),
                Before::Refused(design.width + 1, 64),
                Before::Refused(64, 63),
                Before::Refused(64, 2049),
            ]
            .choose(random)
            .unwrap(),
            _ => Before::Nothing,
        };
        let gap = match random.random_range(0..4) {
            0 | 1 => 0,
            2 => random.random_range(1..=2 * width as u64),
            _ => random.random_range(1..=100 * width as u64),
        };
        let pause = |random: &mut ChaCha8Rng| match random.random_range(0..3) {
            0 | 1 => 0,
            _ => random.random_range(1..60),
        };
        let most_dn = match content {
            Content::Faint => 6.0,
            Content::Blocks => 1500.0,
            _ => 60.0,
        };
        let most = (most_dn / design.dog().lsb()).max(3.0) as u32;
        Self {
            width,
            height,
            content,
            pixels: random.random(),
            fault,
            before,
            gap,
            pauses: [pause(random), pause(random)],
            closed: if random.random_ratio(1, 10) { random.random_range(1000..60_000) } else { 0 },
            coefficients: random.random_ratio(1, 3).then(|| random.random()),
            thresholds: (0..design.pairs()).map(|_| random.random_range(0..most)).collect(),
            target: random.random_range(0..600),
            automatic: random.random_ratio(1, 3),
            record_limit: if random.random_ratio(1, 3) { random.random_range(0..300) } else { 2046 },
            racing: random.random_ratio(1, 2).then(|| random.random_range(0..60)),
            scribbles: random.random_ratio(1, 4),
            reset: random.random_ratio(1, 20).then(|| Reset {
                hard: random.random(),
                beats: random.random_range(1..=size),
                cycles: random.random_range(0..300),
            }),
        }
    }

    /// What the camera sees, 16 bits a sample.
    fn scene(&self) -> Plane<u16> {
        let (w, h) = (self.width, self.height);
        let mut random = ChaCha8Rng::seed_from_u64(self.pixels);
        match self.content {
            Content::Noise => noise(w, h, self.pixels),
            Content::Faint => Plane::from_fn(w, h, |_, _| 30_000 + random.random_range(0..60u16)),
            Content::Blocks => {
                let (a, b) = (random.random_range(4..12), random.random_range(4..12));
                Plane::from_fn(w, h, |x, y| if (x / a + y / b).is_multiple_of(2) { 0 } else { 0xffff })
            }
            Content::Lattice => lattice(w, h),
            Content::Flat => Plane::filled(w, h, random.random()),
        }
    }

    /// The frame as it is to enter the pipeline: cut short, it ends with its last pixel again and again.
    pub fn entered(&self, design: &DesignPoint) -> Plane<u16> {
        let picture = camera_samples(design, &self.scene());
        match self.fault {
            Fault::Short(beats) | Fault::Interrupted(beats) => {
                let pixels = picture.as_slice();
                Plane::from_fn(self.width, self.height, |x, y| pixels[(y * self.width + x).min(beats - 1)])
            }
            Fault::None | Fault::Long(..) => picture,
        }
    }

    /// The packet as the source sends it.
    pub fn beats(&self, design: &DesignPoint) -> Vec<Beat> {
        let picture = camera_samples(design, &self.scene());
        let pixels = picture.as_slice();
        let (count, ends) = match self.fault {
            Fault::None => (pixels.len(), true),
            Fault::Short(beats) => (beats, true),
            Fault::Long(extra, ends) => (pixels.len() + extra, ends),
            Fault::Interrupted(beats) => (beats, false),
        };
        let extra = |i: usize| i as u16 & white(design);
        (0..count)
            .map(|i| (pixels.get(i).copied().unwrap_or_else(|| extra(i)), i == 0, ends && i + 1 == count))
            .collect()
    }

    /// The error bits of its trailer.
    pub fn errors(&self) -> u32 {
        match self.fault {
            Fault::None => 0,
            Fault::Short(_) => 1,
            Fault::Long(..) => 2,
            Fault::Interrupted(_) => 4,
        }
    }
}

/// Frames in a sequence: enough for sizes to follow each other, few enough to find the cause in.
pub const LENGTH: usize = 10;

/// As many frames as asked for, in sequences of [`LENGTH`], two at a time. Gives what was run, or the first sequence
/// that fails.
pub fn campaign(simulator: &Simulator, seed: u64, frames: usize) -> Result<Tally, Box<Failed>> {
    use std::sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    };
    let count = frames.div_ceil(LENGTH);
    let next = AtomicUsize::new(0);
    let total = Mutex::new((Tally::default(), None::<(usize, Failed)>));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    if at >= count {
                        break;
                    }
                    let sequence =
                        Sequence::random(simulator.design(), seed + at as u64, LENGTH.min(frames - at * LENGTH));
                    let outcome = sequence.play(simulator);
                    let mut total = total.lock().unwrap();
                    match outcome {
                        Ok(tally) => total.0.add(&tally),
                        Err(what) => {
                            // One that began before this one may fail too, and is the first then.
                            if total.1.as_ref().is_none_or(|(first, _)| at < *first) {
                                total.1 = Some((at, Failed { sequence, what }));
                            }
                            next.store(count, Ordering::Relaxed);
                        }
                    }
                }
            });
        }
    });
    let (tally, failed) = total.into_inner().unwrap();
    failed.map_or(Ok(tally), |(_, failed)| Err(Box::new(failed)))
}

/// A sequence that fails, and how.
#[derive(Debug)]
pub struct Failed {
    pub sequence: Sequence,
    pub what: crate::port_bench::Failure,
}
