//! Designs other than the default: emitted, and simulated against the model of the same design.
//!
//! The emitter is compiled for each design, so the first run takes a minute; later ones find what it emitted, and the
//! built model, in the cache.

mod port_bench;

use hoverlock_design::{AutomaticThreshold, DesignPoint, Format, KT27, Protection, SmootherKind, pipeline};
use hoverlock_fixed_point::model::bit_true::BitTrue;
use hoverlock_fixed_point::model::design::camera_samples;
use hoverlock_pictures::{Picture, data_dir};
use hoverlock_reference::image::plane::Plane;
use hoverlock_simulation::{Fault, Job, Outcome, Simulator, Streams, Trace, run};
use port_bench::abrupt::{abrupt_changes, targets_within_bins, thresholds_moved};
use port_bench::noise;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// How many designs are drawn, and the seed of the first.
const DESIGNS: (u64, u64) = (20, 1);

/// A frame with the thresholds that the design has pairs for.
fn frame(design: &DesignPoint, picture: &Plane<u16>, thresholds: [u32; 3]) -> Job {
    Job::of(design, camera_samples(design, picture), &thresholds[..design.pairs()]).unwrap()
}

#[track_caller]
fn exact(simulator: &Simulator, jobs: &[Job], streams: Streams) -> Outcome {
    let outcome = run(simulator, jobs, streams).unwrap();
    assert!(outcome.pass(), "{}{outcome:#?}", simulator.design().to_toml());
    outcome
}

fn paused(seed: u64) -> Streams {
    Streams { source_pause: 0.3, sink_pause: 0.3, seed, ..Streams::default() }
}

/// The frame of a real picture, or noise where there is none.
fn ground(design: &DesignPoint) -> Plane<u16> {
    let (width, height) = (design.width as usize, design.height as usize);
    match data_dir() {
        Some(folder) => Picture::open(folder.join("textures/farmstead.png")).unwrap().crop(width, height).luma,
        None => {
            eprintln!("skipped: the real picture, noise takes its place; set HOVERLOCK_DATA");
            noise(width, height, 1)
        }
    }
}

/// The latencies of a frame without pauses are those of [`pipeline`], to the clock.
#[track_caller]
fn takes_its_time(design: &DesignPoint, width: usize, outcome: &Outcome) {
    let longest = u64::from(design.look_ahead.iter().copied().max().unwrap());
    let lines = |lines: u64, steps: u64| {
        Some((lines * width as u64 + pipeline::SEQUENCER_CLOCKS + steps) as f64 / width as f64)
    };
    assert_eq!(
        (outcome.cycles_per_pixel, outcome.latency_lines, outcome.feature_latency_lines),
        (
            Some(1.0),
            lines(pipeline::lines(longest), pipeline::smoothed_at(longest)),
            lines(pipeline::lines(longest) + pipeline::RING_LINES, pipeline::ring_at(longest) + pipeline::RECORD_STEPS),
        ),
        "cycles a pixel, lines to the first smoothed sample, lines to a record, of\n{}",
        design.to_toml()
    );
}

#[test]
fn the_latency_of_the_default_design_is_that_of_the_pipeline() {
    let frame = frame(&KT27, &noise(200, 64, 1), [2, 2, 2]);
    let outcome = exact(&Simulator::new().unwrap(), &vec![frame; 3], Streams::default());
    takes_its_time(&KT27, 200, &outcome);
}

#[test]
fn the_hd1080_design_is_exact() {
    shipped_is_exact("hd1080");
}

#[test]
fn the_small_design_is_exact() {
    shipped_is_exact("small");
}

/// Noise with low thresholds: two pairs find one pixel and the third the next one, so that a candidate is held.
#[test]
fn the_design_of_three_scale_pairs_is_exact() {
    shipped_is_exact("three_scales");
}

/// Parity in the memories changes no record, and no trailer while no bit flips.
#[test]
fn the_small_design_with_parity_is_exact() {
    is_exact(&DesignPoint::shipped("small").unwrap().with_override("protection=parity").unwrap());
}

fn shipped_is_exact(name: &str) {
    is_exact(&DesignPoint::shipped(name).unwrap());
}

fn is_exact(design: &DesignPoint) {
    let simulator = Simulator::of_design(design, None, Trace::None).unwrap();
    let whole = frame(design, &ground(design), [2, 2, 2]);
    let outcome = exact(&simulator, &vec![whole.clone(); 3], Streams::default());
    takes_its_time(design, whole.pixels.width(), &outcome);
    // Sizes at the limits of the design, changes of size, coefficients of its bits, faults, and pauses on both sides.
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let widest = design.width as usize;
    let sizes = [(64, 64), (widest, 65), (widest - 1, 64), (65, 66), (65, 66), (128, 64), (128, 64)];
    let mut jobs: Vec<Job> =
        (0..).zip(sizes).map(|(seed, (w, h))| frame(design, &noise(w, h, seed), [3, 2, 2])).collect();
    for job in &mut jobs[1..] {
        job.coefficients.iter_mut().for_each(|raw| *raw = random.random_range(0..=design.coefficient.max_raw() as u32));
    }
    jobs[3].automatic = Some(40);
    jobs[4].automatic = Some(40);
    jobs[5].fault = Fault::Short(1000);
    exact(&simulator, &jobs, Streams::default());
    for seed in 1..=3 {
        exact(&simulator, &jobs, paused(seed));
    }
    let outcome = exact(&simulator, &abrupt_changes(design, 60, 26), Streams::default());
    assert!(thresholds_moved(&outcome) > 20, "{outcome:#?}");
    exact(&simulator, &abrupt_changes(design, 40, 27), paused(4));
    exact(&simulator, &targets_within_bins(design, 12, 28), paused(5));
}

/// A design that has a model and hardware, with everything drawn.
fn drawn(random: &mut ChaCha8Rng) -> DesignPoint {
    loop {
        let pixel = random.random_range(8..=16);
        let pairs = random.random_range(1..=3);
        let mut look_ahead: Vec<u32> = (0..=pairs).map(|_| random.random_range(2..=6)).collect();
        look_ahead.sort_unstable();
        let narrow = random.random_range(0.8..2.5);
        let design = DesignPoint {
            width: random.random_range(64..=1400),
            height: random.random_range(64..=1100),
            pixel: Format::unsigned(pixel, 0),
            state: Format::unsigned(pixel, random.random_range(0..=(18 - pixel).min(8))),
            coefficient: Format::unsigned(0, random.random_range(7..=16)),
            scale_pairs: pairs as u32,
            sigmas: [1.0, 1.6, 2.4, 3.5][..=pairs].iter().map(|ratio| narrow * ratio).collect(),
            smoother: SmootherKind::FirstOrder,
            look_ahead,
            dog_bits: random.random_range(6..=15),
            threshold: AutomaticThreshold {
                target: random.random_range(1..=1000),
                initial: random.random_range(1..=60),
            },
            ring_radii: (0..pairs).map(|_| random.random_range(9..=16)).collect(),
            candidate_queue: 64 << random.random_range(0..=4),
            record_fifo: 64 << random.random_range(0..=4),
            protection: Protection::ALL[random.random_range(0..Protection::ALL.len())],
        };
        if design.check_buildable().is_ok() && BitTrue::new(&design).is_ok() {
            return design;
        }
    }
}

/// `HOVERLOCK_DESIGNS=N` draws N, `HOVERLOCK_SEED=S` others.
#[test]
#[ignore = "long: a minute for each design, 20 designs"]
fn designs_drawn_at_random_are_exact() {
    let number = |name: &str, default: u64| match std::env::var(name) {
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("{name}={text} is not a number")),
        Err(_) => default,
    };
    let (count, first) = (number("HOVERLOCK_DESIGNS", DESIGNS.0), number("HOVERLOCK_SEED", DESIGNS.1));
    for seed in first..first + count {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let design = drawn(&mut random);
        eprintln!("seed {seed}: {}", design.to_toml().replace('\n', ", "));
        let simulator = Simulator::of_design(&design, None, Trace::None).unwrap();
        let widest = design.width as usize;
        let sizes = [(widest, 64), (64, 70), (64, 70), (64, 70), (64.max(widest - 1), 65)];
        let jobs: Vec<Job> =
            (0..).zip(sizes).map(|(seed, (w, h))| frame(&design, &noise(w, h, seed), [2, 1, 1])).collect();
        let outcome = exact(&simulator, &jobs, Streams::default());
        assert_eq!(outcome.cycles_per_pixel, Some(1.0), "{outcome:#?}");
        let paused = exact(&simulator, &jobs, paused(seed));
        eprintln!("seed {seed}: {} samples, {} features, 0 mismatches", paused.samples, paused.features);
    }
}
