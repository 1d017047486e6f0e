//! The scenarios of the port bench. The everyday tests run them, and the mutation test runs them against every mutant.

use hoverlock_fixed_point::model::threshold::{Maxima, ThresholdController};
use hoverlock_registers::Access as FieldAccess;
use hoverlock_rtl::cells::record_fifo::RESERVED;
use hoverlock_rtl::registers::registers;
use rand::{RngExt, SeedableRng, seq::IteratorRandom};
use rand_chacha::ChaCha8Rng;

use super::*;

/// A scenario on a model of any design.
pub type Scenario = fn(&Simulator) -> Outcome;

/// All of them, the quick and telling ones first.
pub const SCENARIOS: [(&str, Scenario); 12] = [
    ("registers", register_map),
    ("status", status_and_interrupt),
    ("frames", frames_keep_their_registers),
    ("faults", faulty_frames),
    ("tags", errors_keep_to_their_trailer),
    ("sizes", refused_and_changed_sizes),
    ("gaps", gaps_of_every_kind),
    ("disabled", a_disabled_core_drains),
    ("resets", resets_at_any_moment),
    ("forgotten", a_reset_forgets_set_and_thresholds),
    ("automatic", automatic_thresholds),
    ("overflow", a_sink_that_sleeps),
];

/// 30, 22.5 and 18 DN, or the least there is.
pub fn low(design: &DesignPoint) -> Vec<u32> {
    [30.0, 22.5, 18.0][..design.pairs()].iter().map(|dn| (dn / design.dog().lsb()).max(1.0) as u32).collect()
}

/// Three frames of the smallest size, every one different.
fn small(design: &DesignPoint) -> [Frame; 3] {
    [1, 2, 3].map(|seed| Frame::new(design, ground(design, 64, 64, seed), &low(design)))
}

/// Every register: identification, values after reset, what can be written, and what must not change with it.
pub fn register_map(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let mut bench = Bench::new(simulator, 1);
    let map = registers(design).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let mut expected = [0u32; 64];
    let mut writable = [0u32; 64];
    for register in &map {
        for field in &register.fields {
            let word = register.offset as usize / 4;
            let mask = (((1u64 << field.bits) - 1) as u32) << field.low;
            expected[word] |= field.reset << field.low;
            if field.access == FieldAccess::ReadWrite {
                writable[word] |= mask;
            }
        }
    }
    expected[2] = emission(design);
    let reset = expected;
    let all = |bench: &mut Bench, expected: &[u32; 64], when: &str| -> Outcome {
        for (word, expected) in expected.iter().enumerate() {
            let actual = bench.read(4 * word as u32);
            equal("registers", &format!("address 0x{:02x} {when}", 4 * word), *expected, actual)?;
        }
        Ok(())
    };
    all(&mut bench, &expected, "after reset")?;
    for round in 0..4 {
        for (word, expected) in expected.iter_mut().enumerate() {
            let value = match round {
                0 => u32::MAX,
                1 => 0,
                _ => random.random(),
            };
            // Not the pulse that resets, and no frame is sent: enabled or not is the same.
            bench.write(4 * word as u32, value & !if word == 3 { RESET } else { 0 });
            *expected = *expected & !writable[word] | value & writable[word];
        }
        // The coefficients stand behind it and withdraw what was committed.
        expected[COMMIT as usize / 4] = 0;
        all(&mut bench, &expected, "after writes")?;
    }
    for word in [0, u32::MAX - 1, 1] {
        bench.write(COMMIT, word);
        equal("registers", "the commit", word & 1, bench.read(COMMIT))?;
    }
    expected[COMMIT as usize / 4] = 1;
    // A reset by software leaves the registers alone, one by hardware does not.
    bench.write(CONTROL, expected[3] | RESET);
    all(&mut bench, &expected, "after a software reset")?;
    bench.reset(1);
    all(&mut bench, &reset, "after a second reset")
}

fn status(bench: &mut Bench, expected: u32) -> Outcome {
    let actual = bench.read(STATUS);
    equal("status", "bits", expected, actual)
}

/// Each bit is set by its event only, stays, is cleared by a one and by nothing else; the interrupt follows.
pub fn status_and_interrupt(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let low = &low(design);
    let mut bench = Bench::new(simulator, 3);
    let [frame, other, _] = &small(design);
    status(&mut bench, 0)?;
    bench.configure(frame);
    bench.write(CONTROL, ENABLE);
    bench.send(frame.beats());
    bench.until("the frame is in", 10_000, |bench| bench.is_sent())?;
    status(&mut bench, BUSY | BEGUN)?;
    equal("registers", "frames before the first is done", 0, bench.read(FRAMES))?;
    bench.exactly(frame, 0, low, 0)?;
    bench.idle()?;
    status(&mut bench, BEGUN | FRAME)?;
    bench.has_thresholds(low)?;
    equal("registers", "frames", 1, bench.read(FRAMES))?;
    equal("registers", "features", frame.records(low).len() as u32, bench.read(FEATURES))?;
    equal("registers", "dropped", 0, bench.read(DROPPED))?;
    // The interrupt is the frame's and masked by its bit.
    let masks = [ENABLE, INTERRUPT_ERROR, INTERRUPT_FRAME, INTERRUPT_FRAME | ENABLE, AUTOMATIC, 0];
    for control in masks {
        bench.write(CONTROL, control);
        equal("interrupt", "frame", u8::from(control & INTERRUPT_FRAME != 0), u8::from(bench.interrupt()))?;
    }
    // Zeros clear nothing, ones clear their own bit.
    bench.write(STATUS, 0);
    bench.write(STATUS, !FRAME & !BEGUN);
    status(&mut bench, BEGUN | FRAME)?;
    bench.write(STATUS, BEGUN);
    status(&mut bench, FRAME)?;
    bench.write(CONTROL, INTERRUPT_FRAME);
    bench.write(STATUS, FRAME);
    status(&mut bench, 0)?;
    equal("interrupt", "after it was cleared", 0, u8::from(bench.interrupt()))?;

    // Errors of all kinds, one after the other. Each raises the error interrupt only, and each is cleared alone.
    bench.write(CONTROL, ENABLE | INTERRUPT_ERROR);
    let size = frame.pixels.as_slice().len();
    let stray = vec![(7, false, false), (7, false, true)];
    let short: Vec<Beat> = frame.beats().into_iter().take(size / 2).chain([(9, false, true)]).collect();
    let long: Vec<Beat> =
        frame.beats().into_iter().take(size - 1).chain([(1, false, false), (2, false, true)]).collect();
    let interrupted: Vec<Beat> = frame.beats().into_iter().take(200).chain(other.beats()).collect();
    for (beats, bit, frames) in [(stray, REFUSED, 0), (short, SHORT, 1), (long, LONG, 1), (interrupted, INTERRUPTED, 2)]
    {
        equal("interrupt", "before an error", 0, u8::from(bench.interrupt()))?;
        bench.send(beats);
        for _ in 0..frames {
            bench.packet()?;
        }
        bench.idle()?;
        let done = if frames > 0 { BEGUN | FRAME } else { 0 };
        status(&mut bench, bit | done)?;
        equal("interrupt", "at an error", 1, u8::from(bench.interrupt()))?;
        bench.write(CONTROL, ENABLE);
        equal("interrupt", "of an error, masked", 0, u8::from(bench.interrupt()))?;
        bench.write(CONTROL, ENABLE | INTERRUPT_ERROR);
        equal("interrupt", "of an error, unmasked", 1, u8::from(bench.interrupt()))?;
        bench.write(STATUS, bit);
        status(&mut bench, done)?;
        equal("interrupt", "of an error, cleared", 0, u8::from(bench.interrupt()))?;
        bench.write(STATUS, u32::MAX);
    }
    equal("registers", "frames after errors", 5, bench.read(FRAMES))?;

    // A white spot with coefficients near 1 exceeds the largest response.
    let spot =
        Plane::from_fn(
            64,
            64,
            |x, y| if x.abs_diff(32).pow(2) + y.abs_diff(32).pow(2) <= 16 { white(design) } else { 0 },
        );
    let mut coefficients = default_coefficients(design).unwrap();
    coefficients[..=design.look_ahead[0] as usize].fill(most(design));
    let thresholds = [10, 15, 20].map(|part| strongest(design) / part);
    let wide = Frame::with(design, spot, &thresholds[..design.pairs()], coefficients);
    assert!(wide.saturates() && !wide.records(&wide.thresholds).is_empty());
    bench.begin(&wide, wide.beats())?;
    bench.exactly(&wide, 5, &wide.thresholds, 0)?;
    bench.idle()?;
    status(&mut bench, FRAME | SATURATED)?;
    equal("interrupt", "at a saturated response", 1, u8::from(bench.interrupt()))?;
    bench.write(STATUS, SATURATED);
    status(&mut bench, FRAME)
}

/// Frames back to back, each with its own coefficients and thresholds, its own records and its own trailer.
pub fn frames_keep_their_registers(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let low = &low(design);
    let mut bench = Bench::new(simulator, 9);
    bench.write(CONTROL, ENABLE);
    let mut random = ChaCha8Rng::seed_from_u64(10);
    let frame = |seed: u64, random: &mut ChaCha8Rng| {
        // From a third to the whole: features are found with any such coefficients.
        let count = default_coefficients(design).unwrap().len();
        let coefficients = (0..count).map(|_| random.random_range(most(design) / 3..=most(design))).collect();
        let frame = Frame::with(design, ground(design, 64, 64, seed), low, coefficients);
        let features = frame.planes.features(low);
        // The response of any of its features, so that the threshold decides about others.
        let threshold = |k: usize| {
            let of_pair = features.iter().filter(|feature| usize::from(feature.scale) == k);
            of_pair.choose(random).map_or(low[k], |feature| feature.response.into())
        };
        Frame { thresholds: (0..design.pairs()).map(threshold).collect(), ..frame }
    };
    let frames: Vec<Frame> = (0..4).map(|seed| frame(seed, &mut random)).collect();
    for frame in &frames {
        bench.begin(frame, frame.beats())?;
    }
    for (number, frame) in frames.iter().enumerate() {
        bench.exactly(frame, number as u32, &frame.thresholds, 0)?;
    }
    bench.idle()
}

/// Short, long and interrupted frames at telling lengths: padded, cut, reported once, and their neighbours exact.
pub fn faulty_frames(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let low = &low(design);
    let mut bench = Bench::new(simulator, 4);
    bench.write(CONTROL, ENABLE);
    let [good, other, _] = &small(design);
    let size = good.pixels.as_slice().len();
    let mut number = 0;
    for (length, extra, ends) in
        [(1, 0, true), (size - 1, 0, true), (65, 0, false), (size - 1, 0, false), (size, 1, true), (size, 3000, true)]
    {
        let pixels = good.pixels.as_slice();
        let completed = Plane::from_fn(64, 64, |x, y| pixels[(y * 64 + x).min(length - 1)]);
        let faulty = Frame::new(design, completed, low);
        let count = length + extra;
        let beat =
            |i: usize| (pixels.get(i).copied().unwrap_or(i as u16 & white(design)), i == 0, ends && i + 1 == count);
        bench.begin(&faulty, (0..count).map(beat))?;
        bench.begin(other, other.beats())?;
        let (errors, bit) = if extra > 0 {
            (2, LONG)
        } else if ends {
            (1, SHORT)
        } else {
            (4, INTERRUPTED)
        };
        bench.exactly(&faulty, number, low, errors)?;
        bench.exactly(other, number + 1, low, 0)?;
        number += 2;
        equal("status", "after a faulty frame", bit, bench.read(STATUS) & (SHORT | LONG | INTERRUPTED | REFUSED))?;
        bench.write(STATUS, bit);
    }
    // Three faults in a row, all three in the pipeline at once: each trailer says its own.
    let cut: Vec<Beat> = good.beats().into_iter().take(4000).collect();
    let mut ended = cut.clone();
    ended[3999].2 = true;
    let padded = Plane::from_fn(64, 64, |x, y| good.pixels.as_slice()[(y * 64 + x).min(3999)]);
    let faulty = Frame::new(design, padded, low);
    bench.send(ended.iter().chain(&cut).chain(&cut).copied());
    bench.send(good.beats());
    for (errors, frame) in [(1, &faulty), (4, &faulty), (4, &faulty), (0, good)] {
        bench.exactly(frame, number, low, errors)?;
        number += 1;
    }
    Ok(())
}

/// A frame ends in any of the clocks around the trailer of the one before, and one of both has an error: each trailer
/// reports the errors of its own frame.
pub fn errors_keep_to_their_trailer(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let low = &low(design);
    let mut bench = Bench::new(simulator, 12);
    let [good, ..] = &small(design);
    let length = good.pixels.as_slice().len() - 1;
    let pixels = good.pixels.as_slice();
    let short = Frame::new(design, Plane::from_fn(64, 64, |x, y| pixels[(y * 64 + x).min(length - 1)]), low);
    let mut cut: Vec<Beat> = good.beats().into_iter().take(length).collect();
    cut[length - 1].2 = true;
    bench.write(CONTROL, ENABLE);
    bench.begin(good, good.beats())?;
    bench.until("the frame is in", 10_000, |bench| bench.is_sent())?;
    let end = bench.cycle;
    bench.until("the packet", 20_000, |bench| !bench.packets.is_empty())?;
    // From the last beat to the last record out of the FIFO, some clocks behind the trailer.
    let latency = bench.cycle - end;
    bench.exactly(good, 0, low, 0)?;
    let mut number = 1;
    let whole = (good, good.beats(), 0);
    let faulty = (&short, cut, 1);
    for early in 0..10 {
        for [first, second] in [[&faulty, &whole], [&whole, &faulty]] {
            bench.idle()?;
            bench.send(first.1.iter().copied());
            bench.send_after((latency + 2).saturating_sub(4096 + early), second.1.iter().copied());
            for (frame, _, errors) in [first, second] {
                bench.exactly(frame, number, low, *errors)?;
                number += 1;
            }
        }
    }
    Ok(())
}

/// Checks that invalid sizes are refused with a sticky bit, that the next valid frame is exact, and that sizes can grow
/// and shrink in both directions.
pub fn refused_and_changed_sizes(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let low = &low(design);
    let mut bench = Bench::new(simulator, 5);
    bench.write(CONTROL, ENABLE);
    let widest = design.width as usize;
    // A size without its highest bit is a good one.
    let too_wide = design.width.next_power_of_two() as usize;
    let shapes = [(64, 64), (65, 64), (65, 66), (64, 66), (80, 64), (64, 70), (127, 64), (64, 64), (66, 64)];
    let refused = [
        (63, 64),
        (64, 63),
        (widest + 1, 64),
        (64, 2049),
        (0, 0),
        (2047, 64),
        (64, 4095),
        (widest, 63),
        (too_wide + 64, 64),
    ];
    for (number, ((w, h), (bad_w, bad_h))) in shapes.into_iter().zip(refused).enumerate() {
        let frame = Frame::new(design, ground(design, w, h, number as u64), low);
        bench.write(SIZE, bad_h << 16 | bad_w as u32);
        bench.write(COMMIT, 1);
        bench.send([(1, true, false), (2, false, false), (3, false, true)]);
        bench.until("a refused frame is swallowed", 20_000, |bench| bench.is_sent())?;
        bench.run(4);
        let seen = bench.read(STATUS) & (REFUSED | BEGUN);
        equal("status", &format!("after a frame of {bad_w} x {bad_h}"), REFUSED, seen)?;
        bench.write(STATUS, REFUSED);
        // Two frames: one right after the change, one directly after it.
        bench.begin(&frame, frame.beats())?;
        bench.begin(&frame, frame.beats())?;
        bench.exactly(&frame, 2 * number as u32, low, 0)?;
        bench.exactly(&frame, 2 * number as u32 + 1, low, 0)?;
        equal("status", "refused without reason", 0, bench.read(STATUS) & REFUSED)?;
    }
    // The limits themselves are possible: the first line of the largest frame is taken.
    for (w, h) in [(design.width, 64), (64, 2048)] {
        bench.idle()?;
        bench.write(SIZE, h << 16 | w);
        bench.write(COMMIT, 1);
        bench.send((0..w).map(|i| (0, i == 0, false)));
        bench.run(8000);
        equal("status", &format!("after a line of {w} x {h}"), BEGUN, bench.read(STATUS) & (REFUSED | BEGUN))?;
        bench.clear(ENABLE);
        bench.forget();
        bench.write(STATUS, u32::MAX);
    }
    Ok(())
}

/// Two frames of one size with a gap, the second beginning at some step of the first one's drain.
pub fn gap(simulator: &Simulator, cycles: u64, pauses: f64, seed: u64) -> Outcome {
    let design = simulator.design();
    let low = &low(design);
    let mut bench = Bench::new(simulator, seed);
    bench.set_source_pause(pauses);
    bench.set_sink_pause(pauses);
    let [first, second, _] = &small(design);
    bench.configure(first);
    bench.write(CONTROL, ENABLE);
    bench.send(first.beats());
    bench.send_after(cycles, second.beats());
    bench.exactly(first, 0, low, 0)?;
    bench.exactly(second, 1, low, 0)?;
    bench.idle()
}

/// Frames apart by everything from nothing to longer than the drain, which is 96 lines of 64.
pub fn gaps_of_every_kind(simulator: &Simulator) -> Outcome {
    for (i, cycles) in [0, 1, 2, 63, 1000, 5100, 5371, 6143, 6144, 6145, 7000].into_iter().enumerate() {
        gap(simulator, cycles, if i % 3 == 2 { 0.2 } else { 0.0 }, i as u64)?;
    }
    Ok(())
}

/// A core that is disabled between frames drops further frames without an error and still outputs the records of the
/// last one.
pub fn a_disabled_core_drains(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let low = &low(design);
    let mut bench = Bench::new(simulator, 6);
    let [frame, other, _] = &small(design);
    bench.configure(frame);
    bench.send(frame.beats());
    bench.until("a frame is swallowed", 10_000, |bench| bench.is_sent())?;
    bench.run(4);
    status(&mut bench, 0)?;
    bench.write(CONTROL, ENABLE);
    bench.begin(frame, frame.beats())?;
    bench.write(CONTROL, 0);
    // The frame in progress ends as it should; those that follow without a gap are dropped, but must not stop the
    // drain.
    for _ in 0..3 {
        bench.send(other.beats());
    }
    bench.until("the packet of the frame before", 14_000, |bench| !bench.packets.is_empty())?;
    bench.exactly(frame, 0, low, 0)?;
    bench.until("the others are swallowed", 14_000, |bench| bench.is_sent())?;
    bench.idle()?;
    status(&mut bench, FRAME)?;
    bench.write(CONTROL, ENABLE);
    bench.begin(other, other.beats())?;
    bench.exactly(other, 1, low, 0)
}

/// Resets in the first line, in the middle, while draining, with records waiting, with registers being written.
pub fn resets_at_any_moment(simulator: &Simulator) -> Outcome {
    let moments =
        [1, 5, 40, 100, 2000, 4096, 4100, 4096 + 2600, 4096 + 3900, 4096 + 5200, 4096 + 5371, 4096 + 6140, 12_000];
    for (i, moment) in moments.into_iter().enumerate() {
        for software in [false, true] {
            reset_at(simulator, moment, software, i as u64)?;
        }
    }
    Ok(())
}

/// A reset at a moment of the second frame; then the data in flight are lost and the next frame is the first.
pub fn reset_at(simulator: &Simulator, moment: u64, software: bool, seed: u64) -> Outcome {
    let design = simulator.design();
    let low = &low(design);
    let mut bench = Bench::new(simulator, seed);
    let [before, lost, after] = &small(design);
    bench.write(CONTROL, ENABLE);
    bench.begin(before, before.beats())?;
    // Records of the first frame wait in the FIFO.
    bench.set_sink_pause(1.0);
    bench.send(lost.beats());
    bench.until("the first frame is in", 10_000, |bench| bench.pending() <= 4096)?;
    bench.run(moment);
    if software {
        // The source knows nothing of it and sends the rest of its frame, which is refused.
        bench.clear(ENABLE);
        let rest = !bench.is_sent();
        bench.set_sink_pause(0.0);
        bench.until("the rest of the frame is swallowed", 10_000, |bench| bench.is_sent())?;
        bench.run(4);
        let refused = if rest { REFUSED } else { 0 };
        equal("reset", "refused after a software reset", refused, bench.read(STATUS) & REFUSED)?;
        bench.write(STATUS, u32::MAX);
    } else {
        // A write in the very cycle of the reset is lost with everything else.
        bench.reset(1 + (seed % 3) as u32);
        bench.set_sink_pause(0.0);
        equal("reset", "status", 0, bench.read(STATUS))?;
        equal("reset", "size", design.height << 16 | design.width, bench.read(SIZE))?;
        equal("reset", "frames", 0, bench.read(FRAMES))?;
        equal("reset", "features", 0, bench.read(FEATURES))?;
        bench.write(CONTROL, ENABLE);
    }
    bench.begin(after, after.beats())?;
    bench.begin(before, before.beats())?;
    bench.exactly(after, 0, low, 0)?;
    bench.exactly(before, 1, low, 0)?;
    bench.idle()?;
    status(&mut bench, FRAME)
}

/// A hardware reset forgets the size that the last frame took: without a commit no frame begins. Any reset forgets that
/// the thresholds followed the responses: the first automatic frame takes the manual ones.
pub fn a_reset_forgets_set_and_thresholds(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let mut bench = Bench::new(simulator, 13);
    let thresholds: Vec<u32> = low(design).into_iter().map(|threshold| threshold + 9).collect();
    let frame = &Frame::new(design, ground(design, 64, 64, 1), &thresholds);
    for software in [false, true] {
        bench.write(CONTROL, ENABLE | AUTOMATIC);
        bench.begin(frame, frame.beats())?;
        bench.exactly(frame, 0, &frame.thresholds, 0)?;
        bench.begin(frame, frame.beats())?;
        bench.packet()?;
        if software {
            bench.clear(ENABLE | AUTOMATIC);
        } else {
            bench.reset(1);
            bench.write(TARGET, 600);
            bench.write(CONTROL, ENABLE);
            bench.send(frame.beats());
            bench.until("the frame is swallowed", 10_000, |bench| bench.is_sent())?;
            bench.run(4);
            equal("reset", "a frame without a set", REFUSED, bench.read(STATUS) & (REFUSED | BEGUN))?;
            bench.write(STATUS, u32::MAX);
            bench.write(CONTROL, ENABLE | AUTOMATIC);
        }
        bench.begin(frame, frame.beats())?;
        bench.exactly(frame, 0, &frame.thresholds, 0)?;
        bench.reset(1);
    }
    Ok(())
}

/// Thresholds that follow the responses: up, down, held, from the manual one, and back to it.
pub fn automatic_thresholds(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let low = &low(design);
    let mut bench = Bench::new(simulator, 7);
    let thresholds = [1, 7, 3].iter().zip(low).map(|(times, low)| times * low).collect::<Vec<u32>>();
    let frame = &Frame::new(design, ground(design, 80, 72, 9), &thresholds);
    let least = vec![1; design.pairs()];
    let most = (frame.records(&least).len() / design.pairs()) as u32;
    let mut number = 0;
    // Targets that pull both down, hold, and push up; and what the model's controller would say.
    for target in [most / 2, 0, 2000, most / 4] {
        bench.write(TARGET, target);
        bench.write(CONTROL, ENABLE);
        bench.begin(frame, frame.beats())?;
        bench.exactly(frame, number, &frame.thresholds, 0)?;
        number += 1;
        // The first automatic frame takes the manual thresholds.
        bench.write(CONTROL, ENABLE | AUTOMATIC);
        let mut control = Thresholds(design, frame.thresholds.clone(), target);
        for i in 0..8 {
            bench.begin(frame, frame.beats())?;
            if i % 3 == 2 {
                bench.idle()?;
            }
            bench.exactly(frame, number, &control.1, 0)?;
            bench.has_thresholds(&control.1)?;
            control.follow(&frame.planes.maxima());
            number += 1;
        }
    }
    Ok(())
}

/// The controller of the model from any start: the model's own begins at its design point's thresholds.
struct Thresholds<'a>(&'a DesignPoint, Vec<u32>, u32);

impl Thresholds<'_> {
    fn follow(&mut self, maxima: &[Maxima]) {
        let mut design = self.0.clone();
        design.threshold.target = self.2;
        let mut control = ThresholdController::resumed(&design, &self.1);
        control.finish_frame(maxima);
        self.1 = control.thresholds().to_vec();
    }
}

/// The sink is not ready: features are dropped and counted, trailers wait, and then the video stalls. When the sink is
/// ready again all records come out.
pub fn a_sink_that_sleeps(simulator: &Simulator) -> Outcome {
    let design = simulator.design();
    let low = &low(design);
    let mut bench = Bench::new(simulator, 8);
    bench.write(CONTROL, ENABLE | INTERRUPT_ERROR);
    bench.set_sink_pause(1.0);
    let least = vec![1; design.pairs()];
    let large = Frame::new(design, ground(design, 224, 170, 4), &least);
    let fits = design.record_fifo as usize - RESERVED;
    assert!(large.records(&least).len() > fits, "{} features fill no FIFO", large.records(&least).len());
    bench.begin(&large, large.beats())?;
    // Trailers fill the reserved entries; the 15th does not fit, so the video stalls before it.
    let [plain, ..] = &small(design);
    let frames = 20;
    bench.begin(plain, std::iter::empty::<Beat>().chain(plain.beats()))?;
    for _ in 1..frames {
        bench.send(plain.beats());
    }
    bench.run(200_000);
    if bench.is_sent() {
        return fail("feature FIFO", "the video was never stopped");
    }
    let standing = bench.pending();
    bench.run(5000);
    equal("feature FIFO", "beats accepted while there is no space for a trailer", standing, bench.pending())?;
    equal("status", "dropped", DROPS, bench.read(STATUS) & DROPS)?;
    equal("interrupt", "at drops", 1, u8::from(bench.interrupt()))?;
    bench.set_sink_pause(0.3);
    let packet = bench.packet()?;
    let dropped = packet.check(&large, 0, &least, 0)?;
    if dropped == 0 || packet.records.len() < fits {
        return fail("feature FIFO", format!("{} records written, {dropped} dropped", packet.records.len()));
    }
    let mut total = 0;
    for number in 1..=frames {
        let packet = bench.packet()?;
        total += packet.check(plain, number, low, 0)?;
    }
    if total == 0 {
        return fail("feature FIFO", "nothing dropped with a full FIFO");
    }
    bench.idle()?;
    bench.write(STATUS, u32::MAX);
    bench.begin(plain, plain.beats())?;
    bench.exactly(plain, frames + 1, low, 0)?;
    equal("status", "drops after the FIFO was emptied", 0, bench.read(STATUS) & DROPS)
}
