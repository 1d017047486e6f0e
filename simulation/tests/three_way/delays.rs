//! Cells that wait: registers, memories, markers, lines.

use hoverlock_rtl::cells::{
    address::AddressCounter,
    delay::{Delay, FlagDelay, FrameDelay, PulseDelay},
    line_delay::{ColumnMemory, LineDelay},
    ring::{RingTaps, rows},
    tail::{HeldRow, TailCounter},
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rust_hdl::prelude::*;

use super::*;

/// All delays of this width.
macro_rules! delay {
    ($bits:literal) => {
        for (module, numbers) in family("delay").into_iter().filter(|(_, numbers)| numbers[0] == $bits) {
            let steps = numbers[1];
            let mut past = Vec::new();
            alike!(
                Delay::<$bits>::new(steps),
                &module,
                400,
                [reset, advance, x],
                [y],
                |cell: &mut Delay<$bits>, cycle, _: &mut ChaCha8Rng| cell.reset.next = cycle < 2,
                |cell: &Delay<$bits>, _| {
                    if cell.advance.val() {
                        past.push(cell.x.val());
                        if past.len() >= steps {
                            assert_eq!(cell.y.val(), past[past.len() - steps]);
                        }
                    }
                }
            );
        }
    };
}

pub fn delays() {
    delay!(15);
    delay!(16);
    delay!(18);
    delay!(64);
    let all = family("delay").into_iter().map(|(_, numbers)| numbers[0]);
    assert!(all.into_iter().all(|bits| [15, 16, 18, 64].contains(&bits)), "a delay of another width");
    for (module, numbers) in family("flag_delay") {
        let steps = numbers[0];
        agree!(
            FlagDelay,
            FlagDelay::new(steps),
            &module,
            1000,
            [reset, advance, x],
            [y],
            |cell: &mut FlagDelay, cycle, draw: &mut ChaCha8Rng| {
                resets!(cell, cycle, draw);
            }
        );
    }
    for (module, numbers) in family("pulse_delay") {
        let steps = numbers[0];
        let mut last = None;
        let mut step = 0;
        alike!(
            PulseDelay::new(steps as u64),
            &module,
            2000,
            [reset, advance, x],
            [y],
            |cell: &mut PulseDelay, cycle, draw: &mut ChaCha8Rng| {
                resets!(cell, cycle, draw);
                cell.x.next = draw.random_ratio(1, 15);
            },
            |cell: &PulseDelay, _| {
                if cell.reset.val() {
                    last = None;
                } else if cell.advance.val() {
                    step += 1;
                    // The pulse is seen with the step before the one it belongs to.
                    assert_eq!(cell.y.val(), last.is_some_and(|last| step + 1 == last + steps), "{module}");
                    if cell.x.val() {
                        last = Some(step);
                    }
                }
            }
        );
    }
    for (module, numbers) in family("frame_delay") {
        let (lines, steps) = (numbers[0] as u64, numbers[1] as u64);
        // The count has bits that only wide frames use.
        for width in [66 + lines, 700, 1024] {
            let (mut step, mut last) = (0u64, None);
            // Cycles in which the marker leaves, and some more: a tenth of them has no step.
            let cycles = 5 * (lines * width + steps) / 4 + 100;
            let again = 5 + cycles as usize;
            let cleared = again + cycles as usize;
            alike!(
                FrameDelay::new(lines, steps),
                &module,
                cleared + cycles as usize,
                [reset, advance, width, x],
                [y],
                |cell: &mut FrameDelay, cycle, draw: &mut ChaCha8Rng| {
                    cell.reset.next = cycle < 2 || cycle == cleared + 50;
                    cell.advance.next = draw.random_ratio(9, 10);
                    cell.width.next = width.into();
                    cell.x.next = [5, again, cleared].contains(&cycle);
                },
                |cell: &FrameDelay, _| {
                    if cell.reset.val() {
                        last = None;
                    } else if cell.advance.val() {
                        step += 1;
                        assert_eq!(
                            cell.y.val(),
                            last.is_some_and(|last| step + 1 == last + lines * width + steps),
                            "{module}, {width} columns"
                        );
                        if cell.x.val() {
                            last = Some(step);
                        }
                    }
                }
            );
        }
    }
}

pub fn lines_of_every_depth() {
    /// A line memory of this width with these taps, whose reads take this number of steps.
    macro_rules! lines {
        ($bits:literal, $out:literal, $module:expr, $taps:expr, $read:expr) => {{
            let (mut count, mut past) = (0u64, Vec::new());
            let (taps, read): (&[usize], u64) = ($taps, $read);
            let cell = if read == 2 { LineDelay::<$bits, $out>::registered } else { LineDelay::<$bits, $out>::new };
            // As many steps as the oldest tap needs, and a hundred more.
            let cycles = 64 * taps[taps.len() - 1] + 200;
            alike!(
                cell(taps),
                $module,
                cycles,
                [advance, address, write_address, x],
                [y],
                |cell: &mut LineDelay<$bits, $out>, cycle, draw: &mut ChaCha8Rng| {
                    cell.advance.next = cycle < 100 || draw.random_ratio(19, 20);
                    cell.address.next = (count % 60).into();
                    cell.write_address.next = ((count + 60 - read) % 60).into();
                    count += u64::from(cell.advance.next);
                },
                |cell: &LineDelay<$bits, $out>, _| {
                    if cell.advance.val() {
                        past.push(cell.x.val());
                        for (i, tap) in taps.iter().enumerate().filter(|(_, tap)| past.len() > 60 * **tap) {
                            assert_eq!(cell.y.val().get_bits::<$bits>($bits * i), past[past.len() - 60 * tap]);
                        }
                    }
                }
            );
        }};
    }
    for (module, numbers) in family("line_delay") {
        // Bits, rows, taps, outputs; bit `k - 1` of the taps is row `k`.
        let taps: Vec<usize> = (1..=numbers[1]).filter(|row| numbers[2] >> (row - 1) & 1 != 0).collect();
        assert_eq!(taps.len(), numbers[3]);
        let read = numbers[5] as u64;
        match (numbers[0], numbers[3]) {
            (18, 1) => lines!(18, 18, &module, &taps, read),
            (16, 6) => lines!(16, 96, &module, &taps, read),
            (16, 15) => lines!(16, 240, &module, &taps, read),
            (16, 14) => lines!(16, 224, &module, &taps, read),
            other => panic!("a line memory of another form: {other:?}"),
        }
    }
    let of_ring = |scale: usize| rows(scale).into_iter().map(|(line, _)| line).filter(|line| *line > 0).collect();
    let rings: Vec<Vec<usize>> = vec![of_ring(0), of_ring(1)];
    for ring in rings {
        let taps = ring.iter().fold(0, |taps, line| taps | 1 << (line - 1));
        assert!(family("line_delay").iter().any(|(_, numbers)| numbers[2] == taps), "no line memory of {ring:?}");
    }
}

/// The rows of all column stages of the default design in one memory, against their delays.
pub fn column_rows() {
    const LINES: [usize; 10] = [1, 2, 4, 1, 2, 4, 1, 2, 4, 8];
    const TAPS: [usize; 5] = [16, 32, 40, 48, 56];
    let (mut count, mut pixels) = (0u64, Vec::new());
    let mut states: [Vec<Bits<18>>; 10] = Default::default();
    alike!(
        ColumnMemory::new(&TAPS, &LINES),
        "column_memory",
        64 * 56 + 400,
        [advance, address, write_address, pixel, x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8], x[9]],
        [taps[0], taps[1], taps[2], taps[3], taps[4], y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], y[8], y[9]],
        |cell: &mut ColumnMemory<5, 10>, cycle, draw: &mut ChaCha8Rng| {
            cell.advance.next = cycle < 100 || draw.random_ratio(19, 20);
            cell.address.next = (count % 60).into();
            cell.write_address.next = ((count + 59) % 60).into();
            count += u64::from(cell.advance.next);
        },
        |cell: &ColumnMemory<5, 10>, _| {
            if cell.advance.val() {
                pixels.push(cell.pixel.val());
                for (y, tap) in cell.taps.iter().zip(TAPS).filter(|(_, tap)| pixels.len() > 60 * tap) {
                    assert_eq!(y.val(), pixels[pixels.len() - 60 * tap], "{tap} lines");
                }
                for (i, lines) in LINES.into_iter().enumerate() {
                    states[i].push(cell.x[i].val());
                    if states[i].len() > 60 * lines {
                        assert_eq!(cell.y[i].val(), states[i][states[i].len() - 60 * lines], "stage {i}");
                    }
                }
            }
        }
    );
    assert!(!is_driven("column_memory") || pixels.len() > 60 * 56 + 100);
}

pub fn lines_and_addresses() {
    agree!(
        AddressCounter,
        AddressCounter::default(),
        "address_counter",
        1500,
        [reset, advance, width],
        [address, write_address, registered_write_address, recursion_write_address],
        |cell: &mut AddressCounter, cycle, draw: &mut ChaCha8Rng| {
            resets!(cell, cycle, draw);
            cell.width.next = if cycle < 700 { 100u64 } else { 64 }.into();
        }
    );
    agree!(
        HeldRow,
        HeldRow::default(),
        "held_row",
        2000,
        [advance, write, address, write_address, x],
        [y],
        |cell: &mut HeldRow, _, draw: &mut ChaCha8Rng| {
            cell.address.next = draw.random_range(0..16u64).into();
            cell.write_address.next = draw.random_range(0..16u64).into();
        }
    );
    agree!(
        TailCounter,
        TailCounter::default(),
        "tail_counter",
        9000,
        [reset, advance, width, start],
        [outside],
        |cell: &mut TailCounter, cycle, draw: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 2 || draw.random_ratio(1, 5000);
            cell.width.next = 64u64.into();
            cell.start.next = cycle == 10 || draw.random_ratio(1, 5000);
        }
    );
    let lines: Vec<usize> = rows(1).into_iter().map(|(line, _)| line).collect();
    assert_eq!((lines[0], lines[14], lines.len()), (0, 32, 15));
    agree!(
        RingTaps<240>,
        RingTaps::<240>::new(0),
        "ring_taps_0",
        200,
        [reset, advance, rows],
        [points],
        |cell: &mut RingTaps<240>, cycle, _: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 1;
            cell.advance.next = cycle > 0;
        }
    );
    agree!(
        RingTaps<240>,
        RingTaps::<240>::new(1),
        "ring_taps_1",
        200,
        [reset, advance, rows],
        [points],
        |cell: &mut RingTaps<240>, cycle, _: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 1;
            cell.advance.next = cycle > 0;
        }
    );
}
