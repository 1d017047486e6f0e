//! Joined samples, queues, sequencer and registers.

use hoverlock_design::KT27;
use hoverlock_rtl::{
    cells::{
        csr::Csr,
        join::{Neighbours, PixelState, RingRows, SignedResponse},
        queue::{CandidateQueue, CandidateWord},
        record_fifo::RecordFifo,
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
