//! Frames that change abruptly, for the automatic threshold.

use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::model::design::camera_samples;
use hoverlock_reference::image::plane::Plane;
use hoverlock_simulation::{Fault, Job, Outcome};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::noise;

/// Returns how many frames have another threshold than the frame before.
pub fn thresholds_moved(outcome: &Outcome) -> usize {
    outcome.frames.windows(2).filter(|pair| pair[0].thresholds != pair[1].thresholds).count()
}

/// Frames of the smallest size back to back in automatic mode, whose contrast changes abruptly by up to the whole range
/// of the responses. Each has a target of its own; a few are manual, cut short, or reset.
pub fn abrupt_changes(design: &DesignPoint, frames: usize, seed: u64) -> Vec<Job> {
    let mut draw = ChaCha8Rng::seed_from_u64(seed);
    let mut contrast = 0;
    let job = |i: usize| {
        if draw.random_ratio(1, 2) {
            contrast = draw.random_range(0..=12);
        }
        let pixels = noise(64, 64, seed + i as u64).map(|pixel| 30_000 + (pixel >> contrast) / 2);
        let mut job = Job::of(design, camera_samples(design, &pixels), vec![1; design.pairs()]).unwrap();
        let most = if draw.random_ratio(1, 4) { 400 } else { 20 };
        job.automatic = draw.random_ratio(14, 15).then(|| draw.random_range(0..most));
        // An interrupted frame needs a next one.
        job.fault = match if i + 1 < frames { draw.random_range(0..40) } else { 3 } {
            0 => Fault::Short(draw.random_range(1..4000)),
            1 => Fault::Interrupted(draw.random_range(1..4000)),
            2 => Fault::Clear(draw.random_range(1..4000)),
            _ => Fault::None,
        };
        job
    };
    (0..frames).map(job).collect()
}

/// Frames in automatic mode with large responses and a target of their own each: the threshold is a quarter between the
/// edges of a bin that has several maxima.
pub fn targets_within_bins(design: &DesignPoint, frames: usize, seed: u64) -> Vec<Job> {
    let mut draw = ChaCha8Rng::seed_from_u64(seed);
    let job = |i: usize| {
        let (grey, contrast) = (noise(40, 30, seed + i as u64), draw.random_range(0..3));
        let square = |x: usize, y: usize| if grey.row(y / 4)[x / 4] & 0x100 != 0 { 0xffff >> contrast } else { 0 };
        let pixels = camera_samples(design, &Plane::from_fn(160, 120, square));
        let mut job = Job::of(design, pixels, vec![1; design.pairs()]).unwrap();
        job.automatic = Some(draw.random_range(5..150));
        job
    };
    (0..frames).map(job).collect()
}
