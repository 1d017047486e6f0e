//! Borders of the frame, coefficients and positions.

use hoverlock_rtl::cells::{
    bank::Bank,
    border::{CoefficientRegister, ColumnBorder, RepeatedRows, RowLookAheadBorder, RowLookBackBorder},
    decision::Eligible,
    delay::Cursor,
    threshold::Threshold,
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rust_hdl::prelude::*;

use super::*;

pub fn borders_and_positions() {
    agree!(
        ColumnBorder,
        ColumnBorder::default(),
        "column_border",
        500,
        [advance, x, neighbour, border, outside],
        [p, q],
        |_: &mut ColumnBorder, _, _: &mut ChaCha8Rng| {}
    );
    alike!(
        RepeatedRows::default(),
        "repeated_rows",
        500,
        [advance, rows[0], rows[1], rows[2], rows[3], held, outside],
        [y],
        |_: &mut RepeatedRows, _, _: &mut ChaCha8Rng| {},
        |cell: &RepeatedRows, _| {
            if cell.advance.val() {
                let outside = |i: usize| i > 0 && cell.outside.val().get_bit(i - 1);
                let row = |i: usize| if outside(i) { cell.held.val() } else { cell.rows[i].val() };
                let expected: u64 = (0..4).map(|i| row(i).to_u64() << (16 * i)).sum();
                assert_eq!(cell.y.val().to_u64(), expected);
            }
        }
    );
    for (module, numbers) in family("row_look_back_border") {
        agree!(
            RowLookBackBorder,
            RowLookBackBorder::new(numbers[1] as u64),
            &module,
            1500,
            [reset, advance, first, x, delayed],
            [p, q],
            |cell: &mut RowLookBackBorder, cycle, draw: &mut ChaCha8Rng| {
                resets!(cell, cycle, draw);
                cell.first.next = draw.random_ratio(1, 40);
            }
        );
    }
    for (module, numbers) in family("row_look_ahead_border") {
        agree!(
            RowLookAheadBorder,
            RowLookAheadBorder::new(numbers[1] as u64),
            &module,
            1500,
            [reset, advance, last, x, delayed],
            [p, q],
            |cell: &mut RowLookAheadBorder, cycle, draw: &mut ChaCha8Rng| {
                resets!(cell, cycle, draw);
                cell.last.next = draw.random_ratio(1, 40);
            }
        );
    }
    agree!(
        CoefficientRegister,
        CoefficientRegister::default(),
        "coefficient_register",
        300,
        [advance, load, d],
        [g],
        |_: &mut CoefficientRegister, _, _: &mut ChaCha8Rng| {}
    );
    agree!(Bank, Bank::default(), "bank", 100, [load, d], [q], |_: &mut Bank, _, _: &mut ChaCha8Rng| {});
    agree!(
        Cursor,
        Cursor::default(),
        "cursor",
        9000,
        [reset, advance, width, height, start],
        [active, x, y, first_column, last_column, first_row, last_row],
        |cell: &mut Cursor, cycle, draw: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 2 || draw.random_ratio(1, 3000);
            cell.width.next = 64u64.into();
            cell.height.next = 64u64.into();
            cell.start.next = cycle == 5 || draw.random_ratio(1, 3000);
        }
    );
    agree!(
        Eligible,
        Eligible::default(),
        "eligible",
        3000,
        [advance, width, height, active, x, y],
        [eligible, position],
        |cell: &mut Eligible, _, draw: &mut ChaCha8Rng| {
            cell.width.next = draw.random_range(64..=1024u64).into();
            cell.height.next = draw.random_range(64..=2048u64).into();
            cell.active.next = true;
            if draw.random() {
                cell.x.next = (cell.width.next.to_u64() - draw.random_range(16..21)).into();
                cell.y.next = draw.random_range(16..21u64).into();
            }
        }
    );
    agree!(
        Threshold,
        Threshold::default(),
        "threshold",
        20_000,
        [reset, advance, enters, start, maximum, hit, centre, follow, manual, target],
        [threshold, count],
        |cell: &mut Threshold, cycle, draw: &mut ChaCha8Rng| {
            // The bins are cleared by a first sum; from a second one on it is that of the bins.
            let clears = cycle < 202;
            cell.reset.next = cycle < 2 || (!clears && draw.random_ratio(1, 4000));
            cell.advance.next = clears || draw.random_ratio(9, 10);
            cell.enters.next = cycle == 2 || cycle == 102 || (!clears && draw.random_ratio(1, 150));
            cell.start.next = !clears && draw.random_ratio(1, 60);
            cell.maximum.next = !clears && !cell.maximum.val() && draw.random();
            cell.hit.next = cell.maximum.next && draw.random();
            cell.follow.next = draw.random_ratio(9, 10);
            cell.target.next = draw.random_range(0..60u64).into();
            let bits = draw.random_range(3..=15);
            cell.centre.next = draw.random_range(1..1u64 << bits).into();
            if draw.random() {
                cell.manual.next = draw.random_range(0..4u64).into();
            }
        }
    );
}
