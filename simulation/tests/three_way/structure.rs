//! The checks of what is built of cells: stages, the three smoothers, a scale pair, the core between its streams.
//!
//! rust-hdl's simulator takes 0.05 ms (a scale pair) to 1 ms (the core) a cycle for these, so frames are as small as
//! they may be.

use std::cell::Cell;

use hoverlock_design::{KT27, pipeline::CELL_STEPS};
use hoverlock_fixed_point::model::bit_true::BitTrue;
use hoverlock_fixed_point::model::lerp::lerp;
use hoverlock_reference::features::maxlbp::{Layer as Responses, Ring};
use hoverlock_reference::image::plane::Plane;
use hoverlock_registers::record::FLAG_TRAILER;
use hoverlock_rtl::{
    core::Core,
    extractor::{scale_pair::ScalePair, smoothers::Smoothers},
    registers::default_coefficients,
    smoother::stages::{ColumnLookAhead, RowLookAhead, RowLookBack},
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rust_hdl::prelude::*;

use super::{Check, Word, bench_port, instance, is_driven, random};

/// Modules that are driven here and not in the checks of the leaves.
pub const MODULES: [&str; 6] =
    ["column_look_ahead", "row_look_back(2)", "row_look_ahead(2)", "smoothers", "scale_pair", "hoverlock_core"];

/// Steps from the sample of a stage to its result, which is seen after the edge.
const LATE: usize = CELL_STEPS as usize - 1;

/// All checks of what is built of cells.
pub const CHECKS: [Check; 5] = [
    ("row_stages", row_stages),
    ("column_look_ahead", column_look_ahead),
    ("smoothers", smoothers),
    ("scale_pair", scale_pair),
    ("core", core),
];

/// Rows of 41 samples through a row look-back and a row look-ahead stage, against the definition.
pub fn row_stages() {
    const REACH: usize = 2;
    const WIDTH: usize = 41;
    let g = 47_101u64;
    // Samples of all rows in the order they came.
    let (mut sent, mut given): (Vec<u32>, Vec<u32>) = (Vec::new(), Vec::new());
    alike!(
        RowLookBack::new(1),
        "row_look_back(2)",
        3000,
        [reset, advance, x, first, load, g],
        [y, first_out, load_out],
        |cell: &mut RowLookBack, cycle, _: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 2;
            cell.advance.next &= cycle >= 2;
            cell.g.next = g.into();
            cell.load.next = sent.is_empty();
            cell.first.next = sent.len().is_multiple_of(WIDTH);
            if cell.advance.next {
                sent.push(cell.x.next.to_u32());
            }
        },
        |cell: &RowLookBack, _| {
            if cell.advance.val() {
                given.push(cell.y.val().to_u32());
            }
        }
    );
    // The coefficient is taken with the first sample.
    for n in 0..given.len().saturating_sub(LATE) {
        let (row, c) = (n / WIDTH * WIDTH, n % WIDTH);
        assert_eq!(given[n + LATE], lerp(sent[row + c.saturating_sub(REACH)], sent[n], g as u32, 16), "sample {n}");
    }
    let (mut sent, mut given): (Vec<u32>, Vec<u32>) = (Vec::new(), Vec::new());
    alike!(
        RowLookAhead::new(1),
        "row_look_ahead(2)",
        3000,
        [reset, advance, x, last, load, g],
        [y, last_out, loads],
        |cell: &mut RowLookAhead, cycle, _: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 2;
            cell.advance.next &= cycle >= 2;
            cell.g.next = g.into();
            cell.load.next = sent.is_empty();
            cell.last.next = sent.len() % WIDTH == WIDTH - 1;
            if cell.advance.next {
                sent.push(cell.x.next.to_u32());
            }
        },
        |cell: &RowLookAhead, _| {
            if cell.advance.val() {
                given.push(cell.y.val().to_u32());
            }
        }
    );
    // The coefficient follows its marker; the first row is before it.
    for n in WIDTH..given.len().saturating_sub(LATE + REACH) {
        let (row, c) = (n / WIDTH * WIDTH, n % WIDTH);
        let expected = lerp(sent[row + (c + REACH).min(WIDTH - 1)], sent[n], g as u32, 16);
        assert_eq!(given[n + LATE + REACH], expected, "sample {n}");
    }
}

/// A column stage with rows that are outside now and then.
pub fn column_look_ahead() {
    let g = 42_386u64;
    let (mut sent, mut given): (Vec<(u32, u32)>, Vec<u32>) = (Vec::new(), Vec::new());
    alike!(
        ColumnLookAhead::default(),
        "column_look_ahead",
        1000,
        [advance, x, delayed, held, outside, load, g],
        [y],
        |cell: &mut ColumnLookAhead, cycle, _: &mut ChaCha8Rng| {
            cell.advance.next &= cycle >= 2;
            cell.g.next = g.into();
            // The marker comes with the first operands, a step after their samples.
            cell.load.next = sent.len() == 1;
            if cell.advance.next {
                let p = if cell.outside.next { &cell.held } else { &cell.x };
                sent.push((p.next.to_u32(), cell.delayed.next.to_u32()));
            }
        },
        |cell: &ColumnLookAhead, _| {
            if cell.advance.val() {
                given.push(cell.y.val().to_u32());
            }
        }
    );
    for n in 0..given.len().saturating_sub(LATE) {
        let (p, q) = sent[n];
        assert_eq!(given[n + LATE], lerp(p, q, g as u32, 16), "step {n}");
    }
}

fn noise(width: usize, height: usize, seed: u64) -> Plane<u16> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    Plane::from_fn(width, height, |x, y| ((x * 311 + y * 173) % 30_000) as u16 + random.random_range(0..30_000u16))
}

fn bank(thresholds: [u64; 2]) -> Bits<384> {
    let mut bank = Bits::<384>::default();
    for (i, raw) in default_coefficients(&KT27).unwrap().into_iter().enumerate() {
        bank.set_bits(16 * i, Bits::<16>::from(u64::from(raw)));
    }
    bank.set_bits(304, Bits::<16>::from(thresholds[0]));
    bank.set_bits(320, Bits::<16>::from(thresholds[1]));
    bank.set_bits(368, Bits::<16>::from(2046u64));
    bank
}

/// A frame of the smallest size through all three smoothers at once.
pub fn smoothers() {
    let pixels = noise(64, 64, 5);
    let (mut step, mut seen) = (0usize, None::<usize>);
    let planes = BitTrue::new(&KT27).unwrap().planes(&pixels);
    let mut compared = 0;
    alike!(
        Smoothers::default(),
        "smoothers",
        4096 + 65 * 64 + 200,
        [reset, advance, width, height, start, pixel, frame_bank],
        [window_bank, address, write_address, registered_write_address, narrow, middle, wide, start_out],
        |cell: &mut Smoothers, cycle, draw: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 8;
            cell.advance.next = cycle >= 8 && draw.random_ratio(39, 40);
            cell.width.next = 64u64.into();
            cell.height.next = 64u64.into();
            cell.frame_bank.next = bank([60, 45]);
            // The marker is one step before the first sample.
            cell.start.next = step == 0;
            let at = step.wrapping_sub(1).min(4095);
            cell.pixel.next = u64::from(pixels.as_slice()[at]).into();
            step += usize::from(cell.advance.next);
        },
        |cell: &Smoothers, _| {
            if !cell.advance.val() {
                return;
            }
            if let Some(at) = seen.filter(|at| *at < 4096) {
                let got = [&cell.narrow, &cell.middle, &cell.wide].map(|signal| signal.val().to_u32());
                let want = [0, 1, 2].map(|i: usize| planes.smoothed[i].as_slice()[at]);
                assert_eq!(got, want, "sample {at}");
                compared += 1;
            }
            seen = if cell.start_out.val() { Some(0) } else { seen.map(|at| at + 1) };
        }
    );
    assert!(!is_driven("smoothers") || compared > 3900, "only {compared} samples came out");
}

/// A scale pair with states that come close and far, against MaxDOG and the response of the model.
pub fn scale_pair() {
    const HEIGHT: usize = 24;
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let narrow = Plane::from_fn(64, HEIGHT, |_, _| random.random_range(0..0x4_0000u32));
    let wide = narrow.map(|state| match random.random_range(0..3) {
        0 => random.random_range(0..0x4_0000u32),
        1 => state.saturating_add_signed(random.random_range(-9..=9)).min(0x3_ffff),
        _ => *state,
    });
    let (dog, _) = BitTrue::new(&KT27).unwrap().dog(&BitTrue::signed_dog(&narrow, &wide));
    let responses = Responses::new(dog, Ring::of_radius(16));
    let word = |magnitude: &Plane<u16>, at: (usize, usize)| {
        u64::from(magnitude[at] | u16::from(responses.dog.positive[at]) << 15)
    };
    let steps = Cell::new(0usize);
    alike!(
        ScalePair::default(),
        "scale_pair",
        64 * HEIGHT + 60,
        [reset, advance, address, registered_write_address, narrow, wide],
        [response, saturated, strict, loose, p, centre, neighbours, ring],
        |cell: &mut ScalePair, cycle, draw: &mut ChaCha8Rng| {
            let step = steps.get();
            cell.reset.next = cycle < 2;
            cell.advance.next = cycle >= 2 && draw.random_ratio(39, 40);
            cell.address.next = (step as u64 % 64).into();
            cell.registered_write_address.next = ((step as u64 + 62) % 64).into();
            let at = step.min(64 * HEIGHT - 1);
            cell.narrow.next = u64::from(narrow.as_slice()[at]).into();
            cell.wide.next = u64::from(wide.as_slice()[at]).into();
            steps.set(step + usize::from(cell.advance.next));
        },
        |cell: &ScalePair, _| {
            let step = steps.get();
            if !cell.advance.val() {
                return;
            }
            // `step` samples are in: the response is two steps late, the ring two lines, two columns and eight steps.
            if let Some(at) = step.checked_sub(2).filter(|at| *at < 64 * HEIGHT) {
                assert_eq!(cell.response.val().to_u64(), word(&responses.dog.magnitude, (at % 64, at / 64)));
            }
            let (x, y) = ((step + 64 * HEIGHT - 8 - 2 - 2 * 64) % 64, step.saturating_sub(8 + 2 + 2 * 64) / 64);
            if step > 4 * 64 && (2..62).contains(&x) && (2..HEIGHT - 2).contains(&y) {
                assert_eq!(cell.ring.val().to_u64(), word(&responses.max_dog, (x, y)), "ring at {x}, {y}");
            }
        }
    );
}

/// A frame of the smallest size through the core, from beats to records.
pub fn core() {
    let pixels = noise(64, 64, 7);
    let planes = BitTrue::new(&KT27).unwrap().planes(&pixels);
    let expected: Vec<_> = planes.features(&[60, 45]).iter().map(|feature| feature.pack()).collect();
    let (mut sent, mut records) = (0usize, Vec::new());
    let mut valid = false;
    alike!(
        Core::default(),
        "hoverlock_core",
        4096 + 6300 + 600,
        [
            reset,
            enable,
            new_width,
            new_height,
            bank,
            committed,
            video_valid,
            video_data,
            video_startofpacket,
            video_endofpacket,
            feature_ready
        ],
        [
            video_ready,
            feature_valid,
            feature_startofpacket,
            busy,
            errors,
            begun,
            done,
            count,
            dropped,
            frames,
            saturated,
            threshold[0],
            threshold[1]
        ],
        |cell: &mut Core, cycle, draw: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 8;
            cell.enable.next = true;
            cell.new_width.next = 64u64.into();
            cell.new_height.next = 64u64.into();
            cell.bank.next = bank([60, 45]);
            cell.committed.next = true;
            cell.feature_ready.next = draw.random_ratio(3, 4);
            valid = cycle > 10 && sent < 4096 && (valid || draw.random_ratio(39, 40));
            cell.video_valid.next = valid;
            if valid {
                cell.video_data.next = u64::from(pixels.as_slice()[sent]).into();
                cell.video_startofpacket.next = sent == 0;
                cell.video_endofpacket.next = sent == 4095;
                // Ready is a register: it holds at the edge that follows.
                if cell.video_ready.val() {
                    sent += 1;
                    valid = false;
                }
            }
            if cell.feature_valid.val() && cell.feature_ready.next {
                records.push(Word::words(cell.feature_data.val()));
            }
        },
        |_: &Core, _| ()
    );
    if is_driven("hoverlock_core") {
        let trailer = records.pop().expect("a trailer");
        assert_eq!(trailer[1] >> 16, u32::from(FLAG_TRAILER));
        assert_eq!(trailer[2] as usize, expected.len());
        assert_eq!(records, expected.iter().map(|record| record[..8].to_vec()).collect::<Vec<_>>());
    }
}
