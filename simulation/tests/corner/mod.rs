//! Rare cases of the control logic, from the ports only: each is met on purpose, because random frames seldom meet it.

#![allow(dead_code, reason = "each test binary uses its part")]

use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::model::design::camera_samples;
use hoverlock_fixed_point::model::record::FeatureRecord;
use hoverlock_fixed_point::model::threshold::{Maxima, ThresholdController, count_per_scale, floor};
use hoverlock_reference::image::plane::Plane;
use hoverlock_registers::{Access as FieldAccess, Register};
use hoverlock_rtl::cells::record_fifo::RESERVED;
use hoverlock_rtl::registers::{default_coefficients, registers};
use hoverlock_simulation::Simulator;

use crate::port_bench::{
    AUTOMATIC, Access, BEGUN, BUSY, Beat, Bench, COEFFICIENTS_OFFSET, COMMIT, CONTROL, DROPPED, DROPS, ENABLE, FRAME,
    FRAMES, Frame, INTERRUPT_ERROR, INTERRUPTED, LONG, Outcome, REFUSED, SATURATED, SHORT, STATUS, TARGET, equal, fail,
    ground, latency, lattice, most, noise,
    scenarios::{Scenario, low},
    strongest, white,
};

/// All of them, by the name that a fault is to be found by.
pub const CORNERS: [(&str, Scenario); 16] = [
    ("narrower", a_narrower_frame_behind_a_gap),
    ("skid", packets_that_wait_in_the_skid_buffer),
    ("strays", beats_outside_a_frame),
    ("commit", a_set_is_taken_whole_at_any_cycle),
    ("standing start", a_start_that_stands_keeps_its_set),
    ("banks", every_frame_its_own_mode_and_target),
    ("met target", a_target_that_is_met_changes_nothing),
    ("many features", a_count_beyond_4096),
    ("threshold limits", thresholds_stop_at_their_limits),
    ("ceiling", more_features_than_the_record_limit),
    ("one drop", one_dropped_feature),
    ("full queue", every_pair_drops_at_a_full_queue),
    ("stop", the_video_stops_behind_thirteen_trailers),
    ("cut", a_response_of_one_scale_pair_is_cut),
    ("cleared", an_event_in_the_cycle_of_its_clearing),
    ("latency", cycles_from_port_to_port),
];

/// Two frames of the smallest size.
fn small(design: &DesignPoint) -> [Frame; 2] {
    [1, 2].map(|seed| Frame::new(design, ground(design, 64, 64, seed), &low(design)))
}

/// The low thresholds of a design, every second one of them one higher, from the scale pair `first` on.
fn uneven(design: &DesignPoint, first: usize) -> Vec<u32> {
    low(design).into_iter().enumerate().map(|(k, threshold)| threshold + ((k + first) % 2) as u32).collect()
}

/// The coefficients of a design, each smaller by a fraction of the largest there is.
fn smaller_by(design: &DesignPoint, fraction: u32) -> Vec<u32> {
    let by = most(design) / fraction;
    default_coefficients(design).unwrap().into_iter().map(|code| code - by).collect()
}

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
    let design = simulator.design();
    let low = &low(design);
    let wide = Frame::new(design, ground(design, 305, 64, 40), low);
    let narrow = Frame::new(design, ground(design, 69, 64, 41), low);
    for gap in [0, 68, 69, 150, 304, 305, 374] {
        let mut bench = enabled(simulator, 42);
        bench.configure(&wide);
        bench.send(wide.beats());
        bench.send_after(gap, wide.beats());
        bench.exactly(&wide, 0, low, 0)?;
        bench.write(STATUS, BEGUN);
        bench.begin(&narrow, narrow.beats())?;
        bench.exactly(&wide, 1, low, 0)?;
        bench.exactly(&narrow, 2, low, 0)?;
    }
    Ok(())
}

/// Packets of one and two beats behind a change of size: start and end of packet wait in the second beat of the skid
/// buffer.
fn packets_that_wait_in_the_skid_buffer(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let low = &low(design);
    let [good, _] = &small(design);
    // One pixel again and again.
    let pixel = white(design) / 84;
    let grey = Frame::new(design, Plane::filled(64, 64, pixel), low);
    for (beats, seed) in [(1, 1), (2, 2), (3, 3)] {
        let mut bench = enabled(simulator, seed);
        // The pipeline is full of a frame of another size, so what follows has to wait.
        let before = Frame::new(design, ground(design, 65, 64, 8), low);
        bench.begin(&before, before.beats())?;
        bench.until("the frame before is in", 10_000, |bench| bench.is_sent())?;
        bench.configure(good);
        let short = (0..beats).map(|i| (pixel, i == 0, i + 1 == beats));
        bench.send(short.chain(good.beats()));
        bench.exactly(&before, 0, low, 0)?;
        bench.exactly(&grey, 1, low, 1)?;
        bench.exactly(good, 2, low, 0)?;
        bench.idle()?;
        flags(&mut bench, "after a packet in the skid buffer", FRAME | BEGUN | SHORT)?;
    }
    Ok(())
}

/// Beats without a start: not reported while disabled, reported once a packet while enabled, also behind a frame that
/// was too long.
fn beats_outside_a_frame(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let mut bench = Bench::new(simulator, 4);
    let low = &low(design);
    let [good, other] = &small(design);
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
    swallow(&mut bench, &stray[..2], "at the first of a third", REFUSED)?;
    bench.clear(ENABLE);
    swallow(&mut bench, &stray, "at the rest of it behind a reset", REFUSED)?;
    let mut long = good.beats();
    long[4095].2 = false;
    bench.begin(good, long.into_iter().chain([(5, false, false), (6, false, true)]))?;
    bench.exactly(good, 0, low, 2)?;
    bench.idle()?;
    flags(&mut bench, "after a frame too long", FRAME | LONG)?;
    bench.write(STATUS, u32::MAX);
    swallow(&mut bench, &stray, "after a stray packet behind a long frame", REFUSED)?;
    bench.begin(other, other.beats())?;
    bench.exactly(other, 1, low, 0)
}

/// Two sets that differ in size and all else: one is committed, or withdrawn, at any cycle around a frame's start, and
/// the frame takes one of them whole.
fn a_set_is_taken_whole_at_any_cycle(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let first = Frame::with(design, ground(design, 64, 64, 5), &uneven(design, 1), smaller_by(design, 65));
    // The same beats under the new size and under the old one: a frame of 66 x 66, or one of 64 x 64 that is too long.
    let pixels = ground(design, 66, 66, 6);
    let new = Frame::with(design, pixels.clone(), &uneven(design, 0), smaller_by(design, 21));
    let old = Frame::with(
        design,
        Plane::from_fn(64, 64, |x, y| pixels.as_slice()[y * 64 + x]),
        &first.thresholds,
        first.coefficients.clone(),
    );
    let last_coefficient = COEFFICIENTS_OFFSET + 4 * (first.coefficients.len() as u32 - 1);
    let (mut taken, mut kept) = (0, 0);
    // Committed: the write comes `after` cycles after the first beat is offered. Withdrawn: the same with a write to a
    // coefficient.
    for withdraws in [false, true] {
        for after in -3i64..10 {
            let mut bench = enabled(simulator, 20 + after.unsigned_abs());
            bench.begin(&first, first.beats())?;
            bench.exactly(&first, 0, &first.thresholds, 0)?;
            bench.idle()?;
            bench.write(STATUS, u32::MAX);
            bench.configure(&new);
            let last = if withdraws {
                Access::Write(last_coefficient, 1)
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
            let is_new = packet.check(&new, 1, &new.thresholds, 0);
            let is_old = packet.check(&old, 1, &old.thresholds, 2);
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
            let sees = packet.thresholds(design.pairs()) == new.thresholds;
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
    let can_be_written = |register: &&Register| {
        register.offset != CONTROL && register.fields.iter().any(|field| field.access == FieldAccess::ReadWrite)
    };
    for register in registers(design).unwrap().iter().filter(can_be_written) {
        bench.write(COMMIT, 1);
        bench.write(register.offset, 64 << 16 | 64);
        equal("registers", &format!("commit after a write to {}", register.name), 0, bench.read(COMMIT))?;
    }
    bench.send([(1, true, false), (2, false, false), (3, false, true)]);
    bench.run(10);
    flags(&mut bench, "after a frame without a set", REFUSED)
}

/// The first beat of a frame, and then no other for long: the registers are written and committed in between, for the
/// next frame.
fn a_start_that_stands_keeps_its_set(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let low = &low(design);
    let first = Frame::with(design, ground(design, 64, 64, 7), &uneven(design, 0), smaller_by(design, 130));
    let second = Frame::with(design, ground(design, 64, 64, 8), &uneven(design, 1), smaller_by(design, 26));
    let mut bench = enabled(simulator, 6);
    // A frame before, so that the pipeline neither is empty nor rests.
    let [before, _] = &small(design);
    bench.begin(before, before.beats())?;
    let mut beats = first.beats();
    let rest = beats.split_off(1);
    bench.begin(&first, beats)?;
    bench.configure(&second);
    bench.run(50);
    bench.send(rest);
    bench.exactly(before, 0, low, 0)?;
    bench.exactly(&first, 1, &first.thresholds, 0)?;
    bench.send(second.beats());
    bench.exactly(&second, 2, &second.thresholds, 0)?;
    bench.idle()
}

/// The thresholds that the model's controller makes of a frame's.
fn followed(design: &DesignPoint, thresholds: &[u32], target: u32, maxima: &[Maxima]) -> Vec<u32> {
    let mut design = design.clone();
    design.threshold.target = target;
    let mut control = ThresholdController::resumed(&design, thresholds);
    control.finish_frame(maxima);
    control.thresholds().to_vec()
}

/// Frames of the smallest size back to back, so that the next set is there while this frame is still in the columns:
/// mode, target and manual thresholds change with each.
fn every_frame_its_own_mode_and_target(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let mut bench = enabled(simulator, 9);
    let steps = [(false, 0), (true, 0), (true, 2000), (false, 2000), (true, 0), (true, 0), (true, 2000), (false, 0)];
    let mut last: Option<(Vec<u32>, Vec<Maxima>, bool)> = None;
    let mut expected = Vec::new();
    for (i, (automatic, target)) in steps.into_iter().enumerate() {
        let manual = [i as u32, 8 - i as u32, i as u32];
        let manual: Vec<u32> = low(design).into_iter().zip(manual).map(|(low, more)| low + more).collect();
        let frame = Frame::new(design, ground(design, 64, 64, 30 + i as u64), &manual);
        let thresholds = match last {
            Some((thresholds, maxima, true)) if automatic => followed(design, &thresholds, target, &maxima),
            _ => manual,
        };
        bench.write(TARGET, target);
        bench.write(CONTROL, ENABLE | if automatic { AUTOMATIC } else { 0 });
        bench.begin(&frame, frame.beats())?;
        last = Some((thresholds.clone(), frame.planes.maxima(), automatic));
        expected.push((frame, thresholds));
    }
    for (number, (frame, thresholds)) in expected.iter().enumerate() {
        bench.exactly(frame, number as u32, thresholds, 0)?;
    }
    bench.idle()
}

/// Two frames, the second with thresholds that follow: what they become. The sink is open, but records may be dropped.
fn follows(bench: &mut Bench, frame: &Frame, number: &mut u32, target: u32) -> Outcome<Vec<u32>> {
    bench.write(TARGET, target);
    bench.write(CONTROL, ENABLE);
    bench.begin(frame, frame.beats())?;
    bench.packet()?.check(frame, *number, &frame.thresholds, 0)?;
    bench.write(CONTROL, ENABLE | AUTOMATIC);
    // The first automatic frame takes the manual thresholds, the second follows it.
    bench.begin(frame, frame.beats())?;
    bench.begin(frame, frame.beats())?;
    bench.packet()?.check(frame, *number + 1, &frame.thresholds, 0)?;
    let packet = bench.packet()?;
    let now = packet.thresholds(frame.thresholds.len());
    let expected = followed(&bench.design, &frame.thresholds, target, &frame.planes.maxima());
    for k in 0..now.len() {
        equal("threshold", &format!("scale pair {k}, target {target}"), expected[k], now[k])?;
    }
    packet.check(frame, *number + 2, &now, 0)?;
    *number += 3;
    Ok(now)
}

/// A count of exactly seven or nine eighths of the target changes nothing, and a target one further away does.
fn a_target_that_is_met_changes_nothing(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let mut bench = enabled(simulator, 10);
    let mut number = 0;
    let pixels = ground(design, 128, 96, 9);
    let of_all = |threshold: u32| vec![threshold; design.pairs()];
    let maxima = Frame::new(design, pixels.clone(), &of_all(1)).planes.maxima();
    for (eighths, k) in (0..design.pairs()).flat_map(|k| [(7, k), (9, k)]) {
        // A threshold that as many features reach as can be such a part of a target, and that moves beyond it.
        let found = (2..6000).find_map(|threshold| {
            let count = maxima[k].count(threshold);
            let target = 8 * count / eighths;
            let beyond = if eighths == 7 { target + 1 } else { target.checked_sub(1)? };
            let moves = followed(design, &of_all(threshold), beyond, &maxima)[k] != threshold;
            (count > 0 && (8 * count).is_multiple_of(eighths) && moves).then_some((threshold, target, beyond))
        });
        let Some((threshold, target, beyond)) = found else { return fail("bench", "no threshold has such a count") };
        let frame = Frame::new(design, pixels.clone(), &of_all(threshold));
        let now = follows(&mut bench, &frame, &mut number, target)?;
        equal("threshold", &format!("met with {eighths} eighths, scale pair {k}"), threshold, now[k])?;
        let now = follows(&mut bench, &frame, &mut number, beyond)?;
        if now[k] == threshold {
            return fail("threshold", format!("stays at {threshold} beyond {eighths} eighths, scale pair {k}"));
        }
    }
    Ok(())
}

/// More than 4096 features of one scale pair: they meet a target that is as large, which they do not if the count
/// stops at 1023 or loses its carry, and against a smaller one the threshold rises.
fn a_count_beyond_4096(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let mut bench = enabled(simulator, 11);
    let thresholds = vec![(4.5 / design.dog().lsb()).max(1.0) as u32; design.pairs()];
    let frame = Frame::new(design, camera_samples(design, &lattice(300, 300)), &thresholds);
    let many = count_per_scale(&frame.planes.features(&thresholds))[0];
    if !(4097..4500).contains(&many) {
        return fail("bench", format!("{many} features"));
    }
    let now = follows(&mut bench, &frame, &mut 0, many)?;
    equal("threshold", "after as many features as the target", thresholds[0], now[0])?;
    let now = follows(&mut bench, &frame, &mut 3, 2000)?;
    if now[0] <= thresholds[0] {
        return fail("threshold", format!("{} after more than 4096 features", now[0]));
    }
    Ok(())
}

/// Thresholds neither pass the highest bin nor fall below the floor, from whatever threshold they start.
fn thresholds_stop_at_their_limits(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let mut bench = enabled(simulator, 12);
    let mut number = 0;
    // White spots, and coefficients that leave the spots in one plane and nothing in the other: responses at the
    // largest code.
    let spot = |x: usize, y: usize| if x.abs_diff(32).pow(2) + y.abs_diff(32).pow(2) <= 16 { white(design) } else { 0 };
    let mut coefficients = default_coefficients(design).unwrap();
    coefficients[..=design.look_ahead[0] as usize].fill(most(design));
    let all = |first: u32, others: u32| -> Vec<u32> {
        (0..design.pairs()).map(|k| if k == 0 { first } else { others }).collect()
    };
    let largest = strongest(design);
    for (first, others) in [(largest, 1), (1, 2), (largest / 2, largest), (largest - largest / 8, 9)] {
        let thresholds = all(first, others);
        let frame = Frame::with(design, Plane::from_fn(64, 64, spot), &thresholds, coefficients.clone());
        if frame.planes.maxima()[0].count(largest) == 0 {
            return fail("bench", "no response at the largest code");
        }
        follows(&mut bench, &frame, &mut number, 0)?;
    }
    // Far more is wanted than there is, with enough for a step down and with one too little. Ground so dull that there
    // are maxima in the lowest bin and below it, which short responses may not have.
    let (ground, floor) = (ground(design, 128, 96, 12), floor(design));
    let reaching = |pixels: &Plane<u16>, threshold: u32| {
        Frame::new(design, pixels.clone(), &all(1, 1)).planes.maxima()[0].count(threshold)
    };
    let is_dull = |pixels: &Plane<u16>| {
        let [any, reach, above] = [1, floor, floor + (floor >> 3).max(1)].map(|threshold| reaching(pixels, threshold));
        reach > above && (floor == 1 || any > reach)
    };
    let pixels = (0..16).map(|shift| ground.map(|sample| sample >> shift)).find(is_dull).unwrap_or(ground);
    let reach = reaching(&pixels, floor);
    for (first, others) in [(1, 1), (2, largest), (floor, floor + 1), (8 * floor + 7, 8 * floor + 8), (largest, 64)] {
        for target in [8 * reach, 8 * reach + 1] {
            follows(&mut bench, &Frame::new(design, pixels.clone(), &all(first, others)), &mut number, target)?;
        }
    }
    Ok(())
}

/// The record limit withholds features of each scale pair, at limits from none to more than the frame has.
fn more_features_than_the_record_limit(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let mut bench = enabled(simulator, 18);
    // In the second picture a feature that raises the gates is followed at once by one that reaches the lower gate
    // alone.
    let pictures = [18, 27].map(|seed| ground(design, 128, 170, seed));
    let frames = [(0, 0), (0, 63), (0, 300), (1, 70), (0, 1000), (0, 0x8000)];
    for (number, (picture, limit)) in frames.into_iter().enumerate() {
        let mut frame = Frame::new(design, pictures[picture].clone(), &low(design));
        frame.record_limit = limit;
        let [found, sent] = [frame.planes.features(&frame.thresholds), frame.sent(&frame.thresholds).0];
        let [found, sent] = [count_per_scale(&found), count_per_scale(&sent)];
        if limit < 1000 && (0..design.pairs()).any(|k| found[k] == sent[k]) {
            return fail("bench", format!("the limit of {limit} withholds {sent:?} of {found:?}"));
        }
        bench.begin(&frame, frame.beats())?;
        bench.exactly(&frame, number as u32, &frame.thresholds, 0)?;
    }
    bench.idle()
}

/// More candidates wait for their rings than the queue holds: features of each scale pair are dropped and counted.
fn every_pair_drops_at_a_full_queue(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let mut bench = enabled(simulator, 19);
    // Noise for the coarse scale pairs, points four apart for the finest.
    let (w, h) = (design.width as usize, 80);
    let points = lattice(w, h);
    let noise = noise(w, h, 19);
    let pixels = Plane::from_fn(w, h, |x, y| noise[(x, y)] / 2 + points[(x, y)] / 2);
    let mut frame = Frame::new(design, camera_samples(design, &pixels), &vec![1; design.pairs()]);
    frame.record_limit = 0xffff;
    bench.begin(&frame, frame.beats())?;
    let packet = bench.packet()?;
    packet.check(&frame, 0, &frame.thresholds, 0)?;
    let mut taken = [0; 3];
    for record in packet.records.iter().filter_map(|record| FeatureRecord::unpack(record)) {
        taken[usize::from(record.scale)] += 1;
    }
    let found = count_per_scale(&frame.planes.features(&frame.thresholds));
    if (0..design.pairs()).any(|k| taken[k] == found[k]) {
        return fail("bench", format!("{taken:?} of {found:?} features are not dropped"));
    }
    bench.idle()?;
    flags(&mut bench, "after drops at the queue", FRAME | DROPS)
}

/// Features that wait for a sink which takes nothing: as many as the FIFO gives room, with those at its output.
fn waiting(design: &DesignPoint) -> usize {
    design.record_fifo as usize - RESERVED + 2
}

/// A frame with `wanted` features, the thresholds searched for it.
fn with_features(design: &DesignPoint, wanted: usize) -> Outcome<Frame> {
    let of_all = vec![1; design.pairs()];
    (4..12)
        .find_map(|seed| thresholds_for(design, wanted, Frame::new(design, ground(design, 224, 170, seed), &of_all)))
        .map_or_else(|| fail("bench", format!("no thresholds give {wanted} features")), Ok)
}

/// The frame with thresholds that leave it `wanted` features, of the first two scale pairs.
fn thresholds_for(design: &DesignPoint, wanted: usize, all: Frame) -> Option<Frame> {
    let largest = strongest(design);
    let features = all.planes.features(&all.thresholds);
    // Entry `t`: the features of a scale pair that reach the threshold `t`.
    let reach = |scale: u8| -> Vec<usize> {
        let mut count = vec![0; largest as usize + 2];
        let of_scale = features.iter().filter(|feature| feature.scale == scale);
        of_scale.for_each(|feature| count[usize::from(feature.response)] += 1);
        (0..=largest as usize).rev().for_each(|threshold| count[threshold] += count[threshold + 1]);
        count
    };
    let (fine, coarse) = (reach(0), reach(1));
    for first in 1..=largest {
        let Some(rest) = wanted.checked_sub(fine[first as usize]) else { continue };
        // The counts fall with the threshold.
        let second = coarse.partition_point(|count| *count > rest).max(1) as u32;
        if second > largest || coarse[second as usize] != rest {
            continue;
        }
        let thresholds = [first, second, largest][..design.pairs()].to_vec();
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
    let design = simulator.design();
    for extra in [0, 1] {
        let mut bench = enabled(simulator, 13);
        bench.write(CONTROL, ENABLE | INTERRUPT_ERROR);
        bench.set_sink_pause(1.0);
        let frame = with_features(design, waiting(design) + extra)?;
        bench.begin(&frame, frame.beats())?;
        bench.idle()?;
        let dropped = extra as u32;
        equal("registers", "dropped", dropped, bench.read(DROPPED))?;
        let bit = if dropped > 0 { DROPS } else { 0 };
        flags(&mut bench, &format!("after {dropped} dropped"), FRAME | bit)?;
        equal("interrupt", "at a drop", dropped, u32::from(bench.interrupt()))?;
        bench.set_sink_pause(0.0);
        let packet = bench.packet()?;
        equal("record", "dropped", dropped, packet.check(&frame, 0, &frame.thresholds, 0)?)?;
    }
    Ok(())
}

/// Behind a closed sink features fill their part of the FIFO and trailers the rest, down to the last three places; then
/// the video stops.
fn the_video_stops_behind_thirteen_trailers(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let mut bench = enabled(simulator, 14);
    bench.set_sink_pause(1.0);
    let low = &low(design);
    let frame = with_features(design, waiting(design))?;
    bench.begin(&frame, frame.beats())?;
    let empty = Frame::new(design, Plane::filled(64, 64, 9), low);
    bench.idle()?;
    bench.configure(&empty);
    (0..16).for_each(|_| bench.send(empty.beats()));
    bench.run(120_000);
    equal("feature FIFO", "frames done before the video stops", 13, bench.read(FRAMES))?;
    if bench.is_sent() {
        return fail("feature FIFO", "the video was never stopped");
    }
    bench.set_sink_pause(0.0);
    bench.exactly(&frame, 0, &frame.thresholds, 0)?;
    for number in 1..=16 {
        bench.exactly(&empty, number, low, 0)?;
    }
    bench.idle()
}

/// A white spot, and the smoothers up to the narrow one of scale pair `k` that leave it as it is: no response in the
/// finer pairs, and one in `k` that reaches further than its code.
fn spotted(design: &DesignPoint, k: usize, radius: usize) -> Frame {
    let inside = |x: usize, y: usize| x.abs_diff(32).pow(2) + y.abs_diff(32).pow(2) <= radius.pow(2);
    let mut coefficients = default_coefficients(design).unwrap();
    let alike: u32 = design.look_ahead[..=k].iter().map(|stages| stages + 1).sum();
    coefficients[..alike as usize].fill(most(design));
    let thresholds: Vec<u32> =
        [1500.0, 1000.0, 1000.0][..design.pairs()].iter().map(|dn| (dn / design.dog().lsb()) as u32).collect();
    let pixels = Plane::from_fn(64, 64, |x, y| if inside(x, y) { white(design) } else { 0 });
    Frame::with(design, pixels, &thresholds, coefficients)
}

/// A response cut in any single scale pair is reported.
fn a_response_of_one_scale_pair_is_cut(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    for k in 0..design.pairs() {
        let mut bench = enabled(simulator, 15);
        let frame = (0..6)
            .map(|radius| spotted(design, k, radius))
            .find(|frame| (0..design.pairs()).all(|pair| (frame.planes.saturated[pair] > 0) == (pair == k)));
        let Some(frame) = frame else { return fail("bench", format!("no spot is cut in scale pair {k} alone")) };
        bench.begin(&frame, frame.beats())?;
        bench.exactly(&frame, 0, &frame.thresholds, 0)?;
        bench.idle()?;
        flags(&mut bench, &format!("after a response of scale pair {k} was cut"), FRAME | SATURATED)?;
    }
    Ok(())
}

/// A status bit that is cleared in the very cycle of its event stays; a cycle later it goes.
fn an_event_in_the_cycle_of_its_clearing(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let [good, other] = &small(design);
    let size = good.pixels.as_slice().len();
    let once = spotted(design, design.pairs() - 1, 0);
    if once.planes.saturated.iter().sum::<u64>() != 1 {
        return fail("bench", format!("{:?} responses are cut", once.planes.saturated));
    }
    let dropping = with_features(design, waiting(design) + 1)?;
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
    let design = simulator.design();
    let low = &low(design);
    let (lines, cycles) = latency(design);
    for (w, h) in [(64, 64), (65, 64), (100, 70), (333, 65)] {
        let mut bench = enabled(simulator, 17);
        let frame = Frame::new(design, ground(design, w, h, 17), low);
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
            lines * w as u64 + cycles,
            bench.cycle - last,
        )?;
        bench.exactly(&frame, 0, low, 0)?;
        // As exact after a frame of the same size: nothing has to settle.
        bench.idle()?;
        bench.send(frame.beats());
        let begin = first_offer(&bench);
        bench.until("all beats", 100_000, |bench| bench.is_sent())?;
        equal("sequencer", "cycles of a frame", (w * h) as u64, bench.cycle - begin)?;
        bench.exactly(&frame, 1, low, 0)?;
        bench.has_thresholds(low)?;
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
