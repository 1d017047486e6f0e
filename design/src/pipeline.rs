//! The pipeline of the hardware: the steps of each cell, and the delays and latencies that follow from them.
//!
//! A step is a clock edge at which the datapath advances, a line is `W` steps. Everything that waits for a sample, the
//! headers of the Verilog and the comparison of the simulation take their numbers from here, so a register more in a
//! cell is a change of the cell and of its number.
//!
//! | part | lines | steps |
//! |---|---|---|
//! | a pixel to its smoothed sample | [`lines`] | [`smoothed_at`] |
//! | its response | 0 | [`DIFFERENCE_STEPS`] |
//! | MaxDOG at the centre of its window | [`MAX_DOG_RADIUS`] | [`MAX_DOG_STEPS`] |
//! | the decision at the centre of its window | [`WINDOW_RADIUS`] | [`WINDOW_STEPS`] |
//! | the ring of the centre | [`RING_LINES`] | [`RING_STEPS`] |
//! | its record | 0 | [`RECORD_STEPS`] |

use crate::point::MAX_RING_RADIUS;

/// Steps from the samples at a border to the operands of a lerp.
pub const BORDER_STEPS: u64 = 1;

/// Steps from the operands `p`, `q` of a lerp to its `y`. Its coefficient is taken one step after them.
pub const LERP_STEPS: u64 = 3;

/// Steps of a stage: border and lerp.
pub const CELL_STEPS: u64 = BORDER_STEPS + LERP_STEPS;

/// Steps of the first two column stages: the border of their rows and two lerps.
pub const TREE_STEPS: u64 = BORDER_STEPS + 2 * LERP_STEPS;

/// Steps from the marker of a frame to its first position at a cursor.
pub const CURSOR_STEPS: u64 = 1;

/// Steps from an address of a line memory to the sample: it is written back at an address that is older by so much.
pub const READ_STEPS: u64 = 1;

/// Steps from the address to the sample where a register is behind the line memory.
pub const REGISTERED_READ_STEPS: u64 = READ_STEPS + 1;

/// Steps of the recursion from an address to the state that is written back.
pub const RECURSION_STEPS: u64 = READ_STEPS + CELL_STEPS;

/// Steps from the smoothed samples to the response.
pub const DIFFERENCE_STEPS: u64 = 2;

/// Steps from the samples of a column to its maxima.
pub const COLUMN_MAXIMUM_STEPS: u64 = 3;

/// Steps of a maximum of two values.
pub const MAXIMUM_STEPS: u64 = 1;

/// Rows and columns from the centre of the window of a maximum to its border.
pub const WINDOW_RADIUS: u64 = 3;

/// Rows and columns from the centre of the window of MaxDOG to its border.
pub const MAX_DOG_RADIUS: u64 = 2;

/// Lines from a response at the centre of the widest ring, through MaxDOG, to the complete ring.
pub const RING_LINES: u64 = MAX_DOG_RADIUS + MAX_RING_RADIUS as u64;

/// Steps from a response to the decision at the centre of its window, in addition to the lines of the radius.
pub const WINDOW_STEPS: u64 =
    COLUMN_MAXIMUM_STEPS + window_maximum_steps(2 * WINDOW_RADIUS + 1) + MAXIMUM_STEPS + WINDOW_RADIUS;

/// Steps from a response to MaxDOG at the centre of its window, in addition to the lines of the radius.
pub const MAX_DOG_STEPS: u64 = COLUMN_MAXIMUM_STEPS + window_maximum_steps(2 * MAX_DOG_RADIUS + 1) + MAX_DOG_RADIUS;

/// Steps from the position of a ring's centre to its candidate.
pub const QUEUE_STEPS: u64 = 1;

/// Steps from a response to the position of the complete ring at the queue of candidates, in addition to
/// [`RING_LINES`]: the 32 points are there together with the candidate.
pub const RING_STEPS: u64 = MAX_DOG_STEPS + MAX_RING_RADIUS as u64 - QUEUE_STEPS;

/// Steps from a candidate to its first record.
pub const WRITER_STEPS: u64 = 3;

/// Steps from the position of the complete ring to the record.
pub const RECORD_STEPS: u64 = QUEUE_STEPS + WRITER_STEPS;

/// Steps from the position of a frame's last ring to its trailer, if no record is in the way.
pub const TRAILER_STEPS: u64 = 2;

/// Clocks from a beat of the video to its step.
pub const SEQUENCER_CLOCKS: u64 = 2;

/// Clocks from a record to its beat, if the FIFO is empty.
pub const FIFO_CLOCKS: u64 = 3;

/// Returns the steps of a running maximum of `samples` by doubling: the logarithm to base 2, rounded up.
pub const fn window_maximum_steps(samples: u64) -> u64 {
    samples.next_power_of_two().trailing_zeros() as u64
}

/// Returns the lines of the column stages of a smoother of look-ahead `m`.
pub const fn lines(look_ahead: u64) -> u64 {
    (1 << look_ahead) - 1
}

/// Returns the steps of the row stages of a smoother of look-ahead `m`.
pub const fn row_steps(look_ahead: u64) -> u64 {
    2 * CELL_STEPS * look_ahead + (1 << look_ahead) - 1
}

/// Returns the steps of a smoother of look-ahead `m` in addition to its lines.
pub const fn smoother_steps(look_ahead: u64) -> u64 {
    TREE_STEPS + CELL_STEPS * (look_ahead - 1) + row_steps(look_ahead)
}

/// Returns the steps from a pixel at the input of the extractor to its smoothed sample, in addition to [`lines`], the
/// longest look-ahead `m` given. The input is registered.
pub const fn smoothed_at(look_ahead: u64) -> u64 {
    1 + smoother_steps(look_ahead)
}

/// Returns the steps from a pixel to the position of its complete ring, in addition to [`lines`] and [`RING_LINES`],
/// the longest look-ahead `m` given. Its record is [`RECORD_STEPS`] later, after the last pixel of a frame the trailer
/// [`TRAILER_STEPS`] later.
pub const fn ring_at(look_ahead: u64) -> u64 {
    smoothed_at(look_ahead) + DIFFERENCE_STEPS + RING_STEPS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_running_maximum_doubles_its_window() {
        assert_eq!([1, 2, 3, 4, 5, 7, 8, 9].map(window_maximum_steps), [0, 1, 2, 2, 3, 3, 3, 4]);
    }
}
