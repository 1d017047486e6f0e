//! Joined samples, queues, sequencer and registers.

use hoverlock_design::KT27;
use hoverlock_fixed_point::model::record_limit::RecordLimit as Law;
use hoverlock_rtl::{
    cells::{
        csr::Csr,
        join::{Neighbours, PixelState, RingRows, SignedResponse},
        queue::{CandidateQueue, CandidateWord},
        record_fifo::RecordFifo,
        record_limit::RecordLimit,
        record_writer::RecordWriter,
        sequencer::Sequencer,
    },
    emission::emission,
    registers::registers,
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rust_hdl::prelude::*;

use super::*;

pub fn samples_side_by_side() {
    agree_now!(PixelState, PixelState::default(), "pixel_state", [x], [y]);
    agree_now!(SignedResponse, SignedResponse::default(), "signed_response", [magnitude, positive], [y]);
    agree_now!(Neighbours, Neighbours::default(), "neighbours", [left, right, upper, lower], [y]);
    agree_now!(RingRows, RingRows::default(), "ring_rows", [newest, older], [y]);
    agree_now!(
        CandidateWord,
        CandidateWord::default(),
        "candidate_word",
        [position, hit[0], hit[1], centre[0], centre[1], neighbours[0], neighbours[1]],
        [word]
    );
}

pub fn queues_and_records() {
    // Positions enter in ascending order. The ring passes all of them later, or the queue becomes full.
    let mut next = 0u64;
    agree!(
        CandidateQueue,
        CandidateQueue::default(),
        "candidate_queue",
        6000,
        [reset, advance, word, active, x, y],
        [found, dropped],
        |cell: &mut CandidateQueue, cycle, draw: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 2 || cycle == 1500;
            let pushes = cycle > 2 && draw.random_ratio(1, if cycle < 3000 { 9 } else { 2 });
            let mut word = cell.word.next;
            word.set_bits(0, Bits::<21>::from(next));
            word = word.replace_bit(21, pushes).replace_bit(22, pushes && draw.random());
            cell.word.next = word;
            let late = next.saturating_sub(if cycle < 3000 { 300 } else { 4000 });
            cell.active.next = true;
            cell.x.next = (late & 0x3ff).into();
            cell.y.next = (late >> 10).into();
            if cell.advance.next {
                next += 1;
            }
        }
    );
    agree!(
        RecordWriter,
        RecordWriter::default(),
        "record_writer",
        4000,
        [
            reset,
            advance,
            found,
            candidate,
            maxlbp[0],
            maxlbp[1],
            sign[0],
            sign[1],
            lost,
            over_limit,
            frame_end,
            errors,
            take,
            threshold[0],
            threshold[1],
            room
        ],
        [write, record, done, count, dropped, frames],
        |cell: &mut RecordWriter, cycle, draw: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 2 || draw.random_ratio(1, 1500);
            cell.found.next = draw.random_ratio(1, 5);
            cell.frame_end.next = draw.random_ratio(1, 100);
            cell.room.next = draw.random_ratio(3, 4);
        }
    );
    agree!(
        RecordFifo,
        RecordFifo::default(),
        "record_fifo",
        4000,
        [reset, write, record, ready],
        [room, stall, valid, start_of_packet],
        |cell: &mut RecordFifo, cycle, draw: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 2 || draw.random_ratio(1, 1500);
            // Fills for a while, then empties.
            let filling = cycle % 2000 < 1200;
            cell.write.next = !cell.stall.val() && draw.random_ratio(if filling { 9 } else { 1 }, 10);
            cell.ready.next = draw.random_ratio(if filling { 1 } else { 9 }, 10);
        }
    );
}

/// A frame of rows of six columns, for the cells that see only where rows end.
#[derive(Clone, Copy)]
struct Rows {
    x: u64,
    y: u64,
    height: u64,
    limit: u64,
    thresholds: [u64; 2],
}

impl Rows {
    fn drawn(draw: &mut ChaCha8Rng) -> Self {
        let height = [64, 65, 99, 100, 101, 164, 165, 300][draw.random_range(0..8)];
        let limit = [0, 1, 63, 64, 200, 1000, 0xffff][draw.random_range(0..7)];
        let thresholds = [draw.random_range(1..40), draw.random_range(1..400)];
        Self { x: 0, y: 0, height, limit, thresholds }
    }

    fn is_eligible(&self) -> bool {
        (1..4).contains(&self.x) && self.y >= 18 && self.y < self.height - 18
    }

    fn next(&mut self, draw: &mut ChaCha8Rng) {
        self.x += 1;
        if self.x == 6 {
            (self.x, self.y) = (0, self.y + 1);
        }
        if self.y == self.height {
            *self = Self::drawn(draw);
        }
    }
}

pub fn the_record_limit_is_the_law_of_the_model() {
    let nothing = || Law::new(0, &[0, 0], 0x7fff);
    let (rows, law) = (RefCell::new(None), RefCell::new(nothing()));
    // Features sent, and withheld.
    let tally = RefCell::new([0, 0]);
    // Responses of the step before.
    let before = RefCell::new([0, 0]);
    let responses = |cell: &RecordLimit| {
        let response = |k: usize| cell.hit[k].val().then(|| before.borrow()[k]);
        [response(0), response(1), None]
    };
    alike!(
        RecordLimit::default(),
        "record_limit",
        40_000,
        [reset, advance, height, y, last_column, limit, threshold[0], threshold[1], hit[0], hit[1], p[0], p[1]],
        [keep[0], keep[1], withheld],
        |cell: &mut RecordLimit, cycle, draw: &mut ChaCha8Rng| {
            let mut rows = rows.borrow_mut();
            let rows = rows.get_or_insert_with(|| Rows::drawn(draw));
            cell.reset.next = cycle < 2 || draw.random_ratio(1, 9000);
            cell.height.next = rows.height.into();
            cell.y.next = rows.y.into();
            cell.last_column.next = rows.x == 5;
            cell.limit.next = rows.limit.into();
            for k in 0..2 {
                let threshold = rows.thresholds[k];
                cell.threshold[k].next = threshold.into();
                cell.hit[k].next = rows.is_eligible() && draw.random();
                let most = (threshold << draw.random_range(0..8)).min(0x7fff);
                cell.p[k].next = draw.random_range(threshold..=most).into();
            }
            if cell.advance.next {
                rows.next(draw);
            }
        },
        |cell: &RecordLimit, _| {
            let mut law = law.borrow_mut();
            if cell.reset.val() {
                *law = nothing();
            } else if cell.advance.val() {
                let y = cell.y.val().to_u32();
                let band_rows = (cell.height.val().to_u32() - 36).div_ceil(64);
                if cell.last_column.val() && y == 17 {
                    let thresholds = cell.threshold.each_ref().map(|threshold| threshold.val().to_u32());
                    *law = Law::new(cell.limit.val().to_u32(), &thresholds, 0x7fff);
                } else {
                    let hits = responses(cell);
                    let [all, sent] = [hits.map(|hit| hit.is_some()), law.pixel(hits)]
                        .map(|flags| flags.into_iter().filter(|flag| *flag).count() as u64);
                    assert_eq!(cell.withheld.val().to_u64(), all - sent);
                    let mut tally = tally.borrow_mut();
                    *tally = [tally[0] + sent, tally[1] + all - sent];
                    if cell.last_column.val() && y >= 18 && (y - 17).is_multiple_of(band_rows) {
                        law.finish_band();
                    }
                }
                *before.borrow_mut() = cell.p.each_ref().map(|p| p.val().to_u32());
            }
            let keep = law.clone().pixel(responses(cell));
            assert_eq!(cell.keep.each_ref().map(|keep| keep.val()), [keep[0], keep[1]]);
        }
    );
    assert!(!is_driven("record_limit") || tally.borrow().iter().all(|count| *count > 1000), "{tally:?}");
}

pub fn sequencer_under_any_stream() {
    agree!(
        Sequencer,
        Sequencer::default(),
        "sequencer",
        60_000,
        [
            reset,
            enable,
            new_width,
            new_height,
            committed,
            stall,
            valid,
            data,
            start_of_packet,
            end_of_packet,
            frame_done
        ],
        [ready, width, height, capture, advance, busy, errors, frame_errors],
        |cell: &mut Sequencer, cycle, draw: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 2 || draw.random_ratio(1, 30_000);
            cell.enable.next = cycle % 9000 > 200;
            let size = cycle as u64 / 25_000;
            cell.new_width.next = if cycle % 9000 > 8000 { 63u64 } else { 64 + size }.into();
            cell.new_height.next = 64u64.into();
            cell.committed.next = draw.random_ratio(1, 3);
            cell.stall.next = draw.random_ratio(1, 20);
            cell.valid.next = draw.random_ratio(19, 20);
            cell.start_of_packet.next =
                draw.random_ratio(1, if cycle % 12_000 < 9000 { 6000 } else { 300 }) || cycle % 3000 == 250;
            cell.end_of_packet.next = draw.random_ratio(1, 7000);
            cell.frame_done.next = draw.random_ratio(1, 5000);
        }
    );
}

pub fn registers_read_back_and_clear() {
    agree!(
        Csr,
        Csr::new(emitted_map()),
        "csr",
        8000,
        [
            reset,
            address,
            read,
            write,
            writedata,
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
        [readdata, irq, clear, enable, width, height, bank, committed],
        |cell: &mut Csr, cycle, draw: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 2 || draw.random_ratio(1, 2000);
            // Control, status and the counts of the last frame as often as all others together.
            let often = [3, 4, 10, 11, 12][draw.random_range(0..5)];
            cell.address.next = if draw.random() { often } else { draw.random_range(0..40u64) }.into();
            cell.read.next = cycle == 2 || draw.random();
            // Events of the pipeline must not count while it is reset.
            cell.done.next = draw.random_ratio(1, 20) || (cell.clear.val() && draw.random());
            cell.errors.next = if draw.random_ratio(1, 10) { draw.random_range(0..16u64) } else { 0 }.into();
            cell.saturated.next = draw.random_ratio(1, 50);
        }
    );
}

/// The map with the hash that the emitted Verilog shows.
fn emitted_map() -> Vec<hoverlock_registers::Register> {
    let hash = emission().unwrap();
    let mut map = registers(&KT27).unwrap();
    map.iter_mut().filter(|register| register.name == "emission").for_each(|register| register.fields[0].reset = hash);
    map
}
