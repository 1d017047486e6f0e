//! Rare cases of the control logic, from the ports only: each is met on purpose, because random frames seldom meet it.
//! The numbers are those of the default design but for [`OF_ANY_DESIGN`].

#![allow(dead_code, reason = "each test binary uses its part")]

use std::sync::LazyLock;

use hoverlock_design::{DesignPoint, KT27};
use hoverlock_fixed_point::model::threshold::{ThresholdController, count_per_scale};
use hoverlock_reference::image::plane::Plane;
use hoverlock_rtl::registers::default_coefficients;
use hoverlock_simulation::Simulator;

use crate::port_bench::{
    AUTOMATIC, Access, BEGUN, BUSY, Beat, Bench, COEFFICIENTS_OFFSET, COMMIT, CONTROL, DROPPED, DROPS, ENABLE, FRAME,
    FRAMES, Frame, INTERRUPT_ERROR, INTERRUPTED, LONG, Outcome, REFUSED, SATURATED, SHORT, SIZE, STATUS, TARGET,
    THRESHOLD_NOW, equal, fail, ground, lattice, noise, scenarios::Scenario, strongest,
};

/// All of them, by the name that a fault is to be found by.
pub const CORNERS: [(&str, Scenario); 14] = [
    ("narrower", a_narrower_frame_behind_a_gap),
    ("skid", packets_that_wait_in_the_skid_buffer),
    ("strays", beats_outside_a_frame),
    ("commit", a_set_is_taken_whole_at_any_cycle),
    ("standing start", a_start_that_stands_keeps_its_set),
    ("banks", every_frame_its_own_mode_and_target),
    ("met target", a_target_that_is_met_changes_nothing),
    ("many features", a_count_beyond_4096),
    ("threshold limits", thresholds_stop_at_their_limits),
    ("one drop", one_dropped_feature),
    ("stop", the_video_stops_behind_thirteen_trailers),
    ("coarse", a_coarse_response_alone_is_cut),
    ("cleared", an_event_in_the_cycle_of_its_clearing),
    ("latency", cycles_from_port_to_port),
];

const THRESHOLDS: [u32; 2] = [60, 45];

static SMALL: LazyLock<[Frame; 2]> =
    LazyLock::new(|| [1, 2].map(|seed| Frame::new(&KT27, noise(64, 64, seed), THRESHOLDS)));

/// A frame of the smallest size that is one pixel again and again.
static GREY: LazyLock<Frame> = LazyLock::new(|| Frame::new(&KT27, Plane::filled(64, 64, 777), THRESHOLDS));

/// Those that any design of two scale pairs is put through.
pub const OF_ANY_DESIGN: [&str; 1] = ["met target"];

/// An enabled core.
fn enabled(simulator: &Simulator, seed: u64) -> Bench {
    let mut bench = Bench::new(simulator, seed);
    bench.write(CONTROL, ENABLE);
    bench
}

fn flags(bench: &mut Bench, when: &str, expected: u32) -> Outcome {
    let actual = bench.read(STATUS) & !BUSY;
    equal("status", when, expected, actual)
}

/// Two wide frames with a gap, so that the second begins at some address of the line memories, and then a narrow one.
fn a_narrower_frame_behind_a_gap(simulator: &Simulator) -> Outcome {
    let wide = Frame::new(&KT27, noise(305, 64, 40), THRESHOLDS);
    let narrow = Frame::new(&KT27, noise(69, 64, 41), THRESHOLDS);
    for gap in [0, 68, 69, 150, 304, 305, 374] {
        let mut bench = enabled(simulator, 42);
        bench.configure(&wide);
        bench.send(wide.beats());
        bench.send_after(gap, wide.beats());
        bench.exactly(&wide, 0, THRESHOLDS, 0)?;
        bench.write(STATUS, BEGUN);
        bench.begin(&narrow, narrow.beats())?;
        bench.exactly(&wide, 1, THRESHOLDS, 0)?;
        bench.exactly(&narrow, 2, THRESHOLDS, 0)?;
    }
    Ok(())
}

/// Packets of one and two beats behind a change of size: start and end of packet wait in the second beat of the skid
/// buffer.
fn packets_that_wait_in_the_skid_buffer(simulator: &Simulator) -> Outcome {
    let [good, _] = &*SMALL;
    for (beats, seed) in [(1, 1), (2, 2), (3, 3)] {
        let mut bench = enabled(simulator, seed);
        // The pipeline is full of a frame of another size, so what follows has to wait.
        let before = Frame::new(&KT27, noise(65, 64, 8), THRESHOLDS);
        bench.begin(&before, before.beats())?;
        bench.until("the frame before is in", 10_000, |bench| bench.is_sent())?;
        bench.configure(good);
        let short = (0..beats).map(|i| (777, i == 0, i + 1 == beats));
        bench.send(short.chain(good.beats()));
        bench.exactly(&before, 0, THRESHOLDS, 0)?;
        bench.exactly(&GREY, 1, THRESHOLDS, 1)?;
        bench.exactly(good, 2, THRESHOLDS, 0)?;
        bench.idle()?;
        flags(&mut bench, "after a packet in the skid buffer", FRAME | BEGUN | SHORT)?;
    }
    Ok(())
}

/// Beats without a start: not reported while disabled, reported once a packet while enabled, also behind a frame that
/// was too long.
fn beats_outside_a_frame(simulator: &Simulator) -> Outcome {
    let mut bench = Bench::new(simulator, 4);
    let [good, other] = &*SMALL;
    let stray: [Beat; 3] = [(1, false, false), (2, false, false), (3, false, true)];
    let swallow = |bench: &mut Bench, beats: &[Beat], when: &str, expected: u32| -> Outcome {
        bench.send(beats.iter().copied());
        bench.until("the beats are swallowed", 10_000, |bench| bench.is_sent())?;
        bench.run(6);
        flags(bench, when, expected)?;
        bench.write(STATUS, u32::MAX);
        Ok(())
    };
    swallow(&mut bench, &stray, "after stray beats while disabled", 0)?;
    // Enabled in the middle of a packet that began while disabled: it is not reported, what comes behind its end is.
    swallow(&mut bench, &stray[..2], "after more of them", 0)?;
    bench.write(CONTROL, ENABLE);
    swallow(&mut bench, &stray, "at the end of a packet that began while disabled", 0)?;
    swallow(&mut bench, &stray, "after a stray packet", REFUSED)?;
    swallow(&mut bench, &stray[..2], "at the first of another", REFUSED)?;
    swallow(&mut bench, &stray, "at the rest of it", 0)?;
    let mut long = good.beats();
    long[4095].2 = false;
    bench.begin(good, long.into_iter().chain([(5, false, false), (6, false, true)]))?;
    bench.exactly(good, 0, THRESHOLDS, 2)?;
    bench.idle()?;
    flags(&mut bench, "after a frame too long", FRAME | LONG)?;
    bench.write(STATUS, u32::MAX);
    swallow(&mut bench, &stray, "after a stray packet behind a long frame", REFUSED)?;
    bench.begin(other, other.beats())?;
    bench.exactly(other, 1, THRESHOLDS, 0)
}

/// Two sets that differ in size and all else: one is committed, or withdrawn, at any cycle around a frame's start, and
/// the frame takes one of them whole.
fn a_set_is_taken_whole_at_any_cycle(simulator: &Simulator) -> Outcome {
    let codes = |by: u32| default_coefficients(&KT27).unwrap().into_iter().map(|code| code - by).collect::<Vec<u32>>();
    let first = Frame::with(&KT27, noise(64, 64, 5), [50, 40], codes(1000));
    // The same beats under the new size and under the old one: a frame of 66 x 66, or one of 64 x 64 that is too long.
    let pixels = noise(66, 66, 6);
    let new = Frame::with(&KT27, pixels.clone(), [70, 30], codes(3000));
    let old = Frame::with(
        &KT27,
        Plane::from_fn(64, 64, |x, y| pixels.as_slice()[y * 64 + x]),
        first.thresholds,
        first.coefficients.clone(),
    );
    let (mut taken, mut kept) = (0, 0);
    // Committed: the write comes `after` cycles after the first beat is offered. Withdrawn: the same with a write to a
    // coefficient.
    for withdraws in [false, true] {
        for after in -3i64..10 {
            let mut bench = enabled(simulator, 20 + after.unsigned_abs());
            bench.begin(&first, first.beats())?;
            bench.exactly(&first, 0, first.thresholds, 0)?;
            bench.idle()?;
            bench.write(STATUS, u32::MAX);
            bench.configure(&new);
            let last = if withdraws {
                Access::Write(COEFFICIENTS_OFFSET + 72, 1)
            } else {
                // What `configure` committed is withdrawn, and the set is whole again.
                bench.write(TARGET, 7);
                Access::Write(COMMIT, 1)
            };
            // The first beat is offered in the second cycle after it was queued.
            if after < -1 {
                bench.cycle(Some(last));
                bench.run(after.unsigned_abs() - 2);
                bench.send(new.beats());
            } else {
                bench.send(new.beats());
                bench.run((after + 1) as u64);
                bench.cycle(Some(last));
            }
            let packet = bench.packet()?;
            let is_new = packet.check(&new, 1, new.thresholds, 0);
            let is_old = packet.check(&old, 1, old.thresholds, 2);
            let when = if withdraws { "withdrawn" } else { "committed" };
            match (is_new, is_old) {
                (Ok(0), _) => taken += 1,
                (_, Ok(0)) => kept += 1,
                (Err(failure), _) => {
                    return fail("registers", format!("{when} {after} cycles after: {}", failure.what));
                }
                _ => return fail("registers", "dropped features"),
            }
            // Before the start it counts, and well after it not.
            let sees = packet.trailer[4] == new.thresholds[1] << 16 | new.thresholds[0];
            if !(0..=7).contains(&after) && sees != ((after < 0) != withdraws) {
                return fail(
                    "registers",
                    format!("{when} {after} cycles after the start, the frame takes the wrong set"),
                );
            }
            bench.idle()?;
            // A commit that came too late waits for the next frame.
            let pending = u32::from(!sees && !withdraws);
            equal("registers", "commit", pending, bench.read(COMMIT))?;
        }
    }
    if taken < 6 || kept < 6 {
        return fail("registers", format!("{taken} frames with the new set, {kept} with the old one"));
    }
    // Not committed since reset: there is no set, so the frame is refused; and a mode that changes withdraws a commit
    // as well.
    let mut bench = Bench::new(simulator, 3);
    equal("registers", "commit after reset", 1, bench.read(COMMIT))?;
    bench.write(CONTROL, ENABLE | AUTOMATIC);
    equal("registers", "commit after the mode changed", 0, bench.read(COMMIT))?;
    bench.write(COMMIT, 1);
    bench.write(CONTROL, ENABLE | AUTOMATIC | INTERRUPT_ERROR);
    equal("registers", "commit after the interrupt changed", 1, bench.read(COMMIT))?;
    bench.write(SIZE, 64 << 16 | 64);
    equal("registers", "commit after a write", 0, bench.read(COMMIT))?;
    bench.send([(1, true, false), (2, false, false), (3, false, true)]);
    bench.run(10);
    flags(&mut bench, "after a frame without a set", REFUSED)
}

/// The first beat of a frame, and then no other for long: the registers are written and committed in between, for the
/// next frame.
fn a_start_that_stands_keeps_its_set(simulator: &Simulator) -> Outcome {
    let codes = |by: u32| default_coefficients(&KT27).unwrap().into_iter().map(|code| code - by).collect();
    let first = Frame::with(&KT27, noise(64, 64, 7), [50, 40], codes(500));
    let second = Frame::with(&KT27, noise(64, 64, 8), [90, 80], codes(2500));
    let mut bench = enabled(simulator, 6);
    // A frame before, so that the pipeline neither is empty nor rests.
    let [before, _] = &*SMALL;
    bench.begin(before, before.beats())?;
    let mut beats = first.beats();
    let rest = beats.split_off(1);
    bench.begin(&first, beats)?;
    bench.configure(&second);
    bench.run(50);
    bench.send(rest);
    bench.exactly(before, 0, THRESHOLDS, 0)?;
    bench.exactly(&first, 1, first.thresholds, 0)?;
    bench.send(second.beats());
    bench.exactly(&second, 2, second.thresholds, 0)?;
    bench.idle()
}

/// The thresholds that the model's controller makes of a frame's.
fn followed(design: &DesignPoint, thresholds: [u32; 2], target: u32, counts: [u32; 3]) -> [u32; 2] {
    let mut design = design.clone();
    design.threshold.target = target;
    let mut control = ThresholdController::resumed(&design, &thresholds);
    control.finish_frame(&counts);
    control.thresholds().try_into().expect("two scale pairs")
}

/// Frames of the smallest size back to back, so that the next set is there while this frame is still in the columns:
/// mode, target and manual thresholds change with each.
fn every_frame_its_own_mode_and_target(simulator: &Simulator) -> Outcome {
    let mut bench = enabled(simulator, 9);
    let steps = [(false, 0), (true, 0), (true, 2000), (false, 2000), (true, 0), (true, 0), (true, 2000), (false, 0)];
    let mut last: Option<([u32; 2], [u32; 3], bool)> = None;
    let mut expected = Vec::new();
    for (i, (automatic, target)) in steps.into_iter().enumerate() {
        let manual = [40 + 10 * i as u32, 90 - 10 * i as u32];
        let frame = Frame::new(&KT27, noise(64, 64, 30 + i as u64), manual);
        let thresholds = match last {
            Some((thresholds, counts, true)) if automatic => followed(&KT27, thresholds, target, counts),
            _ => manual,
        };
        bench.write(TARGET, target);
        bench.write(CONTROL, ENABLE | if automatic { AUTOMATIC } else { 0 });
        bench.begin(&frame, frame.beats())?;
        last = Some((thresholds, count_per_scale(&frame.planes.features(&thresholds)), automatic));
        expected.push((frame, thresholds));
    }
    for (number, (frame, thresholds)) in expected.iter().enumerate() {
        bench.exactly(frame, number as u32, *thresholds, 0)?;
    }
    bench.idle()
}

/// Two frames, the second with thresholds that follow: what they become. The sink is open, but records may be dropped.
fn follows(bench: &mut Bench, frame: &Frame, number: &mut u32, target: u32) -> Outcome<[u32; 2]> {
    bench.write(TARGET, target);
    bench.write(CONTROL, ENABLE);
    bench.begin(frame, frame.beats())?;
    bench.packet()?.check(frame, *number, frame.thresholds, 0)?;
    bench.write(CONTROL, ENABLE | AUTOMATIC);
    // The first automatic frame takes the manual thresholds, the second follows it.
    bench.begin(frame, frame.beats())?;
    bench.begin(frame, frame.beats())?;
    bench.packet()?.check(frame, *number + 1, frame.thresholds, 0)?;
    let packet = bench.packet()?;
    let now = [packet.trailer[4] & strongest(&bench.design), packet.trailer[4] >> 16];
    let expected =
        followed(&bench.design, frame.thresholds, target, count_per_scale(&frame.planes.features(&frame.thresholds)));
    for k in 0..2 {
        equal("threshold", &format!("scale pair {k}, target {target}"), expected[k], now[k])?;
    }
    packet.check(frame, *number + 2, now, 0)?;
    *number += 3;
    Ok(now)
}

/// A count of exactly three or five quarters of the target changes nothing, and a target one further away does.
fn a_target_that_is_met_changes_nothing(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let mut bench = enabled(simulator, 10);
    let mut number = 0;
    let pixels = ground(design, 128, 96, 9);
    let planes = Frame::new(design, pixels.clone(), [1, 1]);
    for (quarters, k) in [(3, 0), (3, 1), (5, 0), (5, 1)] {
        // A threshold that as many features reach as can be such a part of a target.
        let found = (1..6000).find_map(|threshold| {
            let count = count_per_scale(&planes.planes.features(&[threshold; 2]))[k];
            (count > 0 && (4 * count).is_multiple_of(quarters)).then_some((threshold, 4 * count / quarters))
        });
        let Some((threshold, target)) = found else { return fail("bench", "no threshold has such a count") };
        let frame = Frame::new(design, pixels.clone(), [threshold; 2]);
        let now = follows(&mut bench, &frame, &mut number, target)?;
        equal("threshold", &format!("met with {quarters} quarters, scale pair {k}"), threshold, now[k])?;
        let beyond = if quarters == 3 { target + 1 } else { target - 1 };
        let now = follows(&mut bench, &frame, &mut number, beyond)?;
        if now[k] == threshold {
            return fail("threshold", format!("stays at {threshold} beyond {quarters} quarters, scale pair {k}"));
        }
    }
    Ok(())
}

/// More than 4096 features of one scale pair: the threshold rises, as it must not if the count stopped at 1023 or lost
/// its carry.
fn a_count_beyond_4096(simulator: &Simulator) -> Outcome {
    let mut bench = enabled(simulator, 11);
    let frame = Frame::new(&KT27, lattice(300, 300), [9, 9]);
    let many = count_per_scale(&frame.planes.features(&[9, 9]))[0];
    if !(4097..4500).contains(&many) {
        return fail("bench", format!("{many} features"));
    }
    let now = follows(&mut bench, &frame, &mut 0, 2000)?;
    equal("threshold", "after more than 4096 features", 11, now[0])
}

/// Thresholds neither pass the largest code nor fall below 1.
fn thresholds_stop_at_their_limits(simulator: &Simulator) -> Outcome {
    let mut bench = enabled(simulator, 12);
    let mut number = 0;
    // White spots, and coefficients that leave the spots in one plane and nothing in the other: responses at the
    // largest code.
    let spot = |x: usize, y: usize| if x.abs_diff(32).pow(2) + y.abs_diff(32).pow(2) <= 16 { 0xffff } else { 0 };
    let mut coefficients = default_coefficients(&KT27).unwrap();
    coefficients[..6].fill(0xffff);
    for (thresholds, target) in
        [([0x7fff, 1], 0), ([0x71c6, 2], 0), ([0x71c7, 3], 0), ([0x71c8, 8], 0), ([0x7000, 9], 0)]
    {
        let frame = Frame::with(&KT27, Plane::from_fn(64, 64, spot), thresholds, coefficients.clone());
        if count_per_scale(&frame.planes.features(&thresholds))[0] == 0 {
            return fail("bench", "no response at the largest code");
        }
        follows(&mut bench, &frame, &mut number, target)?;
    }
    for (thresholds, target) in [([1, 1], 2000), ([2, 3], 2000), ([8, 7], 2000), ([9, 10], 2000), ([15, 16], 2000)] {
        let frame = Frame::new(&KT27, noise(64, 64, 12), thresholds);
        follows(&mut bench, &frame, &mut number, target)?;
    }
    Ok(())
}

/// Features that wait for a sink which takes nothing: as many as the FIFO gives room, with those at its output.
const WAITING: usize = 498;

/// A frame with `wanted` features, the thresholds searched for it.
fn with_features(wanted: usize) -> Outcome<Frame> {
    (4..12)
        .find_map(|seed| thresholds_for(wanted, Frame::new(&KT27, noise(224, 170, seed), [1, 1])))
        .map_or_else(|| fail("bench", format!("no thresholds give {wanted} features")), Ok)
}

/// The frame with thresholds that leave it `wanted` features.
fn thresholds_for(wanted: usize, all: Frame) -> Option<Frame> {
    let features = all.planes.features(&[1, 1]);
    let reach = |scale: u8, threshold: u32| {
        let of_scale = features.iter().filter(|feature| u32::from(feature.scale) == u32::from(scale));
        of_scale.filter(|feature| u32::from(feature.response) >= threshold).count()
    };
    let coarse: Vec<usize> = (0..3000).map(|threshold| reach(1, threshold)).collect();
    for fine in 1..3000 {
        let Some(rest) = wanted.checked_sub(reach(0, fine)) else { continue };
        let Some(coarse) = coarse.iter().skip(1).position(|count| *count == rest) else { continue };
        let thresholds = [fine, coarse as u32 + 1];
        // `room` is a clock or two behind the last record: the last two stand far enough apart for it.
        let last = all.planes.features(&thresholds).split_off(wanted - 2);
        if last[0].y != last[1].y || last[0].x.abs_diff(last[1].x) > 8 {
            return Some(Frame { thresholds, ..all });
        }
    }
    None
}

/// A closed sink and one feature more than there is room for: one dropped feature is counted and reported.
fn one_dropped_feature(simulator: &Simulator) -> Outcome {
    for extra in [0, 1] {
        let mut bench = enabled(simulator, 13);
        bench.write(CONTROL, ENABLE | INTERRUPT_ERROR);
        bench.set_sink_pause(1.0);
        let frame = with_features(WAITING + extra)?;
        bench.begin(&frame, frame.beats())?;
        bench.idle()?;
        let dropped = extra as u32;
        equal("registers", "dropped", dropped, bench.read(DROPPED))?;
        let bit = if dropped > 0 { DROPS } else { 0 };
        flags(&mut bench, &format!("after {dropped} dropped"), FRAME | bit)?;
        equal("interrupt", "at a drop", dropped, u32::from(bench.interrupt()))?;
        bench.set_sink_pause(0.0);
        let packet = bench.packet()?;
        equal("record", "dropped", dropped, packet.check(&frame, 0, frame.thresholds, 0)?)?;
    }
    Ok(())
}

/// Behind a closed sink features fill their part of the FIFO and trailers the rest, down to the last three places; then
/// the video stops.
fn the_video_stops_behind_thirteen_trailers(simulator: &Simulator) -> Outcome {
    let mut bench = enabled(simulator, 14);
    bench.set_sink_pause(1.0);
    let frame = with_features(WAITING)?;
    bench.begin(&frame, frame.beats())?;
    let empty = Frame::new(&KT27, Plane::filled(64, 64, 9), THRESHOLDS);
    bench.idle()?;
    bench.configure(&empty);
    (0..16).for_each(|_| bench.send(empty.beats()));
    bench.run(120_000);
    equal("feature FIFO", "frames done before the video stops", 13, bench.read(FRAMES))?;
    if bench.is_sent() {
        return fail("feature FIFO", "the video was never stopped");
    }
    bench.set_sink_pause(0.0);
    bench.exactly(&frame, 0, frame.thresholds, 0)?;
    for number in 1..=16 {
        bench.exactly(&empty, number, THRESHOLDS, 0)?;
    }
    bench.idle()
}

/// Narrow and middle smoother alike: no fine response at all, and a coarse one that reaches further than its code.
fn spotted(radius: usize) -> Frame {
    let spot =
        |x: usize, y: usize| if x.abs_diff(32).pow(2) + y.abs_diff(32).pow(2) <= radius.pow(2) { 0xffff } else { 0 };
    let mut coefficients = default_coefficients(&KT27).unwrap();
    coefficients[..12].fill(0xffff);
    Frame::with(&KT27, Plane::from_fn(64, 64, spot), [3000, 2000], coefficients)
}

/// A response cut in the coarse scale pair alone is reported as well.
fn a_coarse_response_alone_is_cut(simulator: &Simulator) -> Outcome {
    let mut bench = enabled(simulator, 15);
    let frame = spotted(3);
    if frame.planes.saturated[0] != 0 || frame.planes.saturated[1] == 0 {
        return fail("bench", format!("{:?} responses are cut", frame.planes.saturated));
    }
    bench.begin(&frame, frame.beats())?;
    bench.exactly(&frame, 0, frame.thresholds, 0)?;
    bench.idle()?;
    flags(&mut bench, "after a coarse response was cut", FRAME | SATURATED)
}

/// A status bit that is cleared in the very cycle of its event stays; a cycle later it goes.
fn an_event_in_the_cycle_of_its_clearing(simulator: &Simulator) -> Outcome {
    let [good, other] = &*SMALL;
    let size = good.pixels.as_slice().len();
    let once = spotted(0);
    if once.planes.saturated != [0, 1] {
        return fail("bench", format!("{:?} responses are cut", once.planes.saturated));
    }
    let dropping = with_features(WAITING + 1)?;
    let good_beats = good.beats();
    let cases: [(u32, &str, &Frame, Vec<Beat>, bool); 8] = [
        (BEGUN, "begun", good, good_beats.clone(), false),
        (FRAME, "frame", good, good_beats.clone(), false),
        (SHORT, "short_frame", good, vec![(1, true, false), (2, false, true)], false),
        (
            LONG,
            "long_frame",
            good,
            good_beats.iter().copied().take(size - 1).chain([(1, false, false)]).collect(),
            false,
        ),
        (INTERRUPTED, "interrupted", good, good_beats.iter().copied().take(9).chain(other.beats()).collect(), false),
        (REFUSED, "refused", good, vec![(1, false, true)], false),
        (DROPS, "dropped", &dropping, dropping.beats(), true),
        (SATURATED, "saturated", &once, once.beats(), false),
    ];
    for (bit, name, frame, beats, closed) in cases {
        let play = |clear: Option<u64>| -> (Bench, Option<u64>) {
            let mut bench = enabled(simulator, 16);
            bench.configure(frame);
            bench.set_sink_pause(if closed { 1.0 } else { 0.0 });
            bench.send(beats.iter().copied());
            let end = bench.cycle + 120_000;
            let mut seen = None;
            while bench.cycle < end && seen.is_none() {
                let now = bench.cycle;
                if clear == Some(now) {
                    bench.write(STATUS, bit);
                } else if clear.is_some_and(|clear| now < clear) {
                    bench.cycle(None);
                } else {
                    // Read as early as it can be: what is read was there before this cycle's edge.
                    seen = (bench.read(STATUS) & bit != 0).then_some(now);
                    if clear.is_some() {
                        return (bench, seen);
                    }
                }
            }
            (bench, seen)
        };
        // Set with the edge that ends the cycle before.
        let (_, seen) = play(None);
        let Some(seen) = seen else { return fail("status", format!("`{name}` is never set")) };
        for (clear, stays) in [(seen - 2, false), (seen - 1, true), (seen, false)] {
            let (mut bench, there) = play(Some(clear));
            // Cleared before the event, it comes a cycle later.
            let there = there.is_some() || (clear == seen - 2 && bench.read(STATUS) & bit != 0);
            let expected = stays || clear == seen - 2;
            equal(
                "status",
                &format!("`{name}` cleared {} cycles after its event", clear as i64 - seen as i64 + 1),
                u8::from(expected),
                u8::from(there),
            )?;
        }
    }
    Ok(())
}

/// Exact numbers of cycles, without a pause: from a frame's last beat to its trailer, and from the start of a frame of
/// a new size to its third beat.
fn cycles_from_port_to_port(simulator: &Simulator) -> Outcome {
    for (w, h) in [(64, 64), (65, 64), (100, 70), (333, 65)] {
        let mut bench = enabled(simulator, 17);
        let frame = Frame::new(&KT27, noise(w, h, 17), THRESHOLDS);
        bench.configure(&frame);
        bench.run(4);
        bench.send(frame.beats());
        let begin = first_offer(&bench);
        // The size is taken over, and three cycles later the frame begins: the third beat finds room a cycle after
        // that.
        let rest = w * h - 3;
        bench.until("the third beat", 100, |bench| bench.pending() == rest)?;
        equal("sequencer", "cycles to the third beat of a new size", TO_THE_THIRD, bench.cycle - begin)?;
        bench.until("the last beat", 100_000, |bench| bench.is_sent())?;
        let last = bench.cycle;
        bench.until("the trailer", 100_000, |bench| !bench.packets.is_empty())?;
        equal(
            "trailer",
            &format!("cycles behind the last of {w} x {h} pixels"),
            81 * w as u64 + TO_THE_TRAILER,
            bench.cycle - last,
        )?;
        bench.exactly(&frame, 0, THRESHOLDS, 0)?;
        // As exact after a frame of the same size: nothing has to settle.
        bench.idle()?;
        bench.send(frame.beats());
        let begin = first_offer(&bench);
        bench.until("all beats", 100_000, |bench| bench.is_sent())?;
        equal("sequencer", "cycles of a frame", (w * h) as u64, bench.cycle - begin)?;
        bench.exactly(&frame, 1, THRESHOLDS, 0)?;
        let now = THRESHOLDS[1] << 16 | THRESHOLDS[0];
        equal("registers", "thresholds in use", now, bench.read(THRESHOLD_NOW))?;
    }
    Ok(())
}

/// The cycle in which the first of the beats that were queued last is offered: the source looks at its queue at the
/// next edge.
fn first_offer(bench: &Bench) -> u64 {
    bench.cycle + 1
}

/// Cycles from the first offer of a frame of a new size to its third beat, the pipeline empty.
const TO_THE_THIRD: u64 = 7;

/// Cycles from a frame's last beat to its trailer, behind 81 lines.
const TO_THE_TRAILER: u64 = 171;
