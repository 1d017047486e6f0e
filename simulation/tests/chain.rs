//! The whole chain, `bit_true` against `rtl`: sizes, pauses, frames back to back, new coefficients, faults, drops.

mod port_bench;

use std::sync::LazyLock;

use hoverlock_design::KT27;
use hoverlock_reference::image::plane::Plane;
use hoverlock_simulation::{Fault, Job, Outcome, Simulator, Streams, run};
use port_bench::abrupt::{abrupt_changes, targets_within_bins, thresholds_moved};
use port_bench::{lattice, noise};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

static SIMULATOR: LazyLock<Simulator> = LazyLock::new(|| Simulator::new().expect("Verilator builds the top"));

fn jobs(sizes: &[(usize, usize)]) -> Vec<Job> {
    let frame = |(i, &(w, h)): (usize, &(usize, usize))| Job::new(noise(w, h, i as u64), [60, 45]).unwrap();
    sizes.iter().enumerate().map(frame).collect()
}

fn exact(jobs: &[Job], streams: Streams) -> Outcome {
    let outcome = run(&SIMULATOR, jobs, streams).unwrap();
    assert!(outcome.pass(), "{outcome:#?}");
    outcome
}

#[test]
fn three_frames_back_to_back_take_one_cycle_a_pixel() {
    let outcome = exact(&jobs(&[(80, 72); 4]), Streams::default());
    assert_eq!(outcome.cycles_per_pixel, Some(1.0), "{outcome:#?}");
    // Nothing but the beginning and the end of frames in the status.
    assert_eq!(outcome.status & 0x7fff_ffff, 1 << 7 | 1);
}

#[test]
fn pauses_on_both_sides_change_nothing() {
    for seed in 1..=5 {
        exact(
            &jobs(&[(64, 64), (64, 64), (64, 64)]),
            Streams { source_pause: 0.4, sink_pause: 0.4, seed, ..Default::default() },
        );
    }
}

#[test]
fn odd_sizes_and_changes_of_size() {
    exact(&jobs(&[(64, 65), (65, 64), (127, 67), (66, 66), (65, 64)]), Streams::default());
    exact(&jobs(&[(127, 65), (64, 64)]), Streams { source_pause: 0.1, ..Default::default() });
}

#[test]
fn coefficients_travel_with_their_frame() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut jobs = jobs(&[(64, 64); 5]);
    for job in &mut jobs[1..] {
        job.coefficients.iter_mut().for_each(|raw| *raw = random.random_range(0..=0xffff));
        job.thresholds = vec![random.random_range(1..200), random.random_range(1..200)];
    }
    exact(&jobs, Streams::default());
}

#[test]
fn extremes_of_pixels_and_coefficients() {
    let mut jobs = jobs(&[(70, 64); 4]);
    jobs[0].pixels = Plane::from_fn(70, 64, |x, y| if (x / 9 + y / 7) % 2 == 0 { 0 } else { 0xffff });
    jobs[1].coefficients.iter_mut().for_each(|raw| *raw = 0xffff);
    jobs[2].coefficients.iter_mut().for_each(|raw| *raw = 0);
    jobs[3].pixels = Plane::filled(70, 64, 0xffff);
    exact(&jobs, Streams::default());
}

#[test]
fn ties_and_thresholds_that_are_met_exactly() {
    // A few grey levels make responses of a few LSB: plateaus, equal neighbours on all sides, responses equal to the
    // threshold.
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut jobs = jobs(&[(90, 80); 4]);
    for (job, thresholds) in jobs.iter_mut().zip([[1, 1], [4, 3], [5, 3], [6, 4]]) {
        job.pixels = Plane::from_fn(90, 80, |_, _| 30_000 + random.random_range(0..60u16));
        job.thresholds = thresholds.into();
    }
    let outcome = exact(&jobs, Streams::default());
    assert!(outcome.features > 40, "{outcome:#?}");
}

#[test]
fn thresholds_follow_abrupt_changes_of_the_smallest_frames() {
    let outcome = exact(&abrupt_changes(&KT27, 150, 1), Streams::default());
    assert!(thresholds_moved(&outcome) > 60, "{outcome:#?}");
    exact(&abrupt_changes(&KT27, 60, 2), Streams { source_pause: 0.3, sink_pause: 0.3, ..Streams::default() });
    exact(&targets_within_bins(&KT27, 12, 3), Streams::default());
}

#[test]
fn automatic_thresholds_follow_the_responses_of_the_frame_before() {
    let mut jobs = jobs(&[(96, 80); 9]);
    // A dull frame between rich ones, a new target, and manual thresholds between two automatic spells.
    jobs[2].pixels = noise(96, 80, 2).map(|pixel| 30_000 + pixel / 64);
    for (i, target) in [(0, 20), (1, 20), (2, 20), (3, 20), (4, 400), (5, 12), (7, 12), (8, 12)] {
        jobs[i].automatic = Some(target);
    }
    let outcome = exact(&jobs, Streams { source_pause: 0.05, ..Streams::default() });
    let thresholds: Vec<_> = outcome.frames.iter().map(|frame| frame.thresholds.clone()).collect();
    let moved = thresholds.windows(2).filter(|pair| pair[0] != pair[1]).count();
    assert!(moved >= 6, "{thresholds:?}");
    for manual in [0, 6, 7] {
        assert_eq!(thresholds[manual], [60, 45], "{thresholds:?}");
    }
}

#[test]
fn a_reset_in_mid_frame_leaves_nothing_behind() {
    let mut jobs = jobs(&[(64, 64); 8]);
    jobs[1].fault = Fault::Reset(2500);
    jobs[4].fault = Fault::Clear(3000);
    jobs[5].fault = Fault::Clear(100);
    jobs.iter_mut().for_each(|job| job.automatic = Some(40));
    let outcome = exact(&jobs, Streams::default());
    // After a reset the first frame has the manual thresholds, however many the frame before had.
    for i in [2, 6] {
        assert_eq!(outcome.frames[i].thresholds, [60, 45]);
        assert!(outcome.frames[i].features > 0);
    }
}

#[test]
fn faults_are_reported_and_the_next_frame_is_exact() {
    let mut jobs = jobs(&[(64, 64); 8]);
    jobs[1].fault = Fault::Short(1000);
    jobs[2].fault = Fault::Interrupted(2000);
    jobs[4].fault = Fault::Long(500);
    jobs[5].fault = Fault::Short(1);
    jobs[6].fault = Fault::Interrupted(4095);
    let outcome = exact(&jobs, Streams::default());
    // Begun, done, short, long, interrupted.
    assert_eq!(outcome.status & 0x7fff_ffff, 1 << 7 | 0b1111, "{outcome:#?}");
}

#[test]
fn a_sink_that_is_not_ready_costs_features_but_no_pixels_and_each_is_counted() {
    let mut jobs = jobs(&[(192, 128); 3]);
    jobs.iter_mut().for_each(|job| job.thresholds = vec![1, 1]);
    let outcome = exact(&jobs, Streams { sink_opens: 60_000, ..Default::default() });
    assert!(outcome.dropped > 0, "{outcome:#?}");
    assert_eq!(outcome.status >> 5 & 1, 1);
    assert_eq!(outcome.features + outcome.dropped, outcome.model_features);
    // No pixel waits for the sink.
    assert_eq!(outcome.frames[2].began - outcome.frames[1].began, 192 * 128);
}

#[test]
fn candidates_beyond_the_queue_are_counted() {
    // 15 lines of 1024 pixels hold about 900 such maxima, 512 can wait for their rings.
    let mut jobs = jobs(&[(1024, 64); 2]);
    jobs[0] = Job::new(lattice(1024, 64), [1, 1]).unwrap();
    jobs[0].record_limit = 0xffff;
    let outcome = exact(&jobs, Streams::default());
    assert!(outcome.frames[0].dropped > 100 && outcome.frames[1].dropped == 0, "{outcome:#?}");
}

/// Three different frames of a size back to back, each with its own coefficients and thresholds, with pauses on both
/// sides.
fn size(width: usize, height: usize) -> Outcome {
    let seed = (width << 12 | height) as u64;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut jobs = jobs(&[(width, height); 3]);
    for (i, job) in jobs.iter_mut().enumerate() {
        job.pixels = noise(width, height, seed + i as u64);
        if i > 0 {
            job.coefficients.iter_mut().for_each(|raw| *raw = random.random_range(10_000..=0xffff));
            job.thresholds = vec![random.random_range(40..200), random.random_range(40..200)];
        }
    }
    let pause = random.random_range(0.05..0.3);
    exact(&jobs, Streams { source_pause: pause, sink_pause: pause, seed, ..Default::default() })
}

#[test]
fn sizes_at_the_edges_of_counters_and_memories() {
    for (width, height) in
        [(64, 65), (65, 64), (127, 65), (1000, 64), (1023, 64), (1024, 65), (64, 767), (65, 768), (64, 2048)]
    {
        size(width, height);
    }
}

#[test]
#[ignore = "long: every width with every height, 26 million pixels"]
fn all_named_sizes() {
    for width in [64, 65, 127, 1023, 1024] {
        for height in [64, 65, 767, 768, 2048] {
            let outcome = size(width, height);
            eprintln!("{width} x {height}: {} features, {:.0} cycles/s", outcome.features, outcome.cycles_per_second);
        }
    }
}
