//! The design that the emitter is compiled for, as constants.
//!
//! The build script writes a constant for each number of the design file; this module derives the others. Leaf cells
//! use the names in their Verilog, bodies of `#[hdl_gen]` as slices and array lengths. [`crate::emission::post_pass`]
//! puts the numbers in their place ([`constant`]), because rust-hdl prints the names.

use hoverlock_design::{DesignPoint, MAX_ROWS, pipeline};
use hoverlock_registers::record::record_words;

include!(concat!(env!("OUT_DIR"), "/design.rs"));

/// Defines the constants and lists them with their names.
macro_rules! constants {
    ($($(#[$doc:meta])* $name:ident = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: usize = $value;)*

        /// The derived constants with their names.
        const DERIVED_CONSTANTS: &[(&str, usize)] = &[$((stringify!($name), $name)),*];
    };
}

constants! {
    /// Steps of a stage: border and lerp.
    CELL_STEPS = pipeline::CELL_STEPS as usize;
    /// The state's highest bit.
    STATE_TOP = STATE_BITS - 1;
    /// Bits of a difference of two states with its sign.
    DIFFERENCE_BITS = STATE_BITS + 1;
    /// Bits of the pixels of four rows.
    PIXEL_ROWS_BITS = 4 * PIXEL_BITS;
    /// Lowest bit of the second of four pixels.
    PIXEL_ROW_1_AT = PIXEL_BITS;
    /// Lowest bit of the third of four pixels.
    PIXEL_ROW_2_AT = 2 * PIXEL_BITS;
    /// Lowest bit of the fourth of four pixels.
    PIXEL_ROW_3_AT = 3 * PIXEL_BITS;
    /// Bits of a coefficient times a distance.
    PRODUCT_BITS = STATE_BITS + COEFFICIENT_BITS;
    /// Bits of a response and its sign.
    SIGNED_BITS = DOG_BITS + 1;
    /// Bits of a column number.
    COLUMN_BITS = WIDTH.next_power_of_two().trailing_zeros() as usize;
    /// Words of a line memory.
    LINE_WORDS = 1 << COLUMN_BITS;
    /// Bits of a width `W`.
    WIDTH_BITS = COLUMN_BITS + 1;
    /// Largest width `W`, px.
    MAX_WIDTH = WIDTH;
    /// Bits of a row number.
    ROW_BITS = MAX_ROWS.ilog2() as usize;
    /// Bits of a height `H`.
    HEIGHT_BITS = ROW_BITS + 1;
    /// Largest height `H`, px.
    MAX_HEIGHT = MAX_ROWS as usize;
    /// Bits of a position, the row above the column.
    POSITION_BITS = ROW_BITS + COLUMN_BITS;
    /// Bits of the number of steps of [`crate::cells::sequencer::DRAIN_LINES`].
    DRAIN_BITS = COLUMN_BITS + 7;
    /// Highest bit of the number of steps of a drain.
    DRAIN_TOP = DRAIN_BITS - 1;
    /// Bits of a beat of the video with its two flags.
    BEAT_BITS = PIXEL_BITS + 2;
    /// Number of coefficients of all smoothers.
    COEFFICIENTS = coefficients();
    /// Bits of a bank: the coefficients, a threshold for each scale pair, target, mode and record limit, 16 bits each.
    BANK_BITS = 16 * (COEFFICIENTS + SCALE_PAIRS + 3);
    /// Lowest bit of the threshold of scale pair 0 in a bank.
    THRESHOLD_0_AT = 16 * COEFFICIENTS;
    /// Lowest bit of the threshold of scale pair 1 in a bank, if the design has that pair.
    THRESHOLD_1_AT = THRESHOLD_0_AT + 16;
    /// Lowest bit of the threshold of scale pair 2 in a bank, if the design has that pair.
    THRESHOLD_2_AT = THRESHOLD_0_AT + 32;
    /// Lowest bit of the target of the automatic threshold in a bank.
    TARGET_AT = THRESHOLD_0_AT + 16 * SCALE_PAIRS;
    /// Lowest bit of the mode in a bank.
    MODE_AT = TARGET_AT + 16;
    /// Lowest bit of the record limit in a bank.
    RECORD_LIMIT_AT = MODE_AT + 16;
    /// Bits of the six rows above the newest one of a 7x7 window.
    WINDOW_BITS = 6 * SIGNED_BITS;
    /// Bits of the four neighbours of a centre.
    NEIGHBOURS_BITS = 4 * DOG_BITS;
    /// Bits of the 15 rows that a ring of 9 to 16 px has.
    RING_BITS = 15 * SIGNED_BITS;
    /// Bits of the rows of the widest ring without the newest row.
    OLDER_BITS = 14 * SIGNED_BITS;
    /// Bits of the 32 points of a ring.
    POINTS_BITS = 32 * SIGNED_BITS;
    /// Lowest bit of the hits in a candidate, above the position: one bit for each scale pair.
    HITS_AT = POSITION_BITS;
    /// Lowest bit of the signs and responses of the scale pairs in a candidate.
    CENTRES_AT = HITS_AT + SCALE_PAIRS;
    /// Lowest bit of the neighbours of the responses in a candidate.
    NEIGHBOURS_AT = CENTRES_AT + SCALE_PAIRS * SIGNED_BITS;
    /// Bits of a candidate.
    CANDIDATE_BITS = NEIGHBOURS_AT + SCALE_PAIRS * NEIGHBOURS_BITS;
    /// Bits of a record.
    RECORD_BITS = 32 * record_words(SCALE_PAIRS);
}

/// Returns the value of a constant that Verilog may name, or `None` if there is no such constant.
pub fn constant(name: &str) -> Option<usize> {
    let mut constants = KEY_CONSTANTS.iter().chain(DERIVED_CONSTANTS);
    constants.find(|(known, _)| *known == name).map(|(_, value)| *value)
}

/// Returns the number of coefficients: one for the recursion and one for each stage of the look-ahead of a smoother.
const fn coefficients() -> usize {
    let (mut smoother, mut sum) = (0, 0);
    while smoother < LOOK_AHEAD.len() {
        sum += 1 + LOOK_AHEAD[smoother];
        smoother += 1;
    }
    sum
}

/// Rows of the column stages that may lie outside the frame: three for the first two stages of each different
/// look-ahead, and one for each of the others.
pub const BANDS: usize = {
    let (mut smoother, mut bands) = (1, 3 + MAX_LOOK_AHEAD - 2);
    while smoother < LOOK_AHEAD.len() {
        if LOOK_AHEAD[smoother] != LOOK_AHEAD[smoother - 1] {
            bands += 3;
        }
        smoother += 1;
    }
    bands
};

/// One DoG LSB is `2^s` state LSB.
pub const DOG_SHIFT: usize = STATE_BITS - 2 - DOG_BITS;

/// Lines of the longest smoother.
pub const SMOOTHER_LINES: usize = pipeline::lines(MAX_LOOK_AHEAD as u64) as usize;

/// Steps of the longest smoother in addition to its lines.
pub const SMOOTHER_STEPS: usize = pipeline::smoother_steps(MAX_LOOK_AHEAD as u64) as usize;

/// Look-ahead of the longest smoother.
pub const MAX_LOOK_AHEAD: usize = {
    let (mut smoother, mut longest) = (0, 0);
    while smoother < LOOK_AHEAD.len() {
        if LOOK_AHEAD[smoother] > longest {
            longest = LOOK_AHEAD[smoother];
        }
        smoother += 1;
    }
    longest
};

/// Returns the design that the emitter was compiled for.
pub fn compiled() -> DesignPoint {
    let text = include_str!(concat!(env!("OUT_DIR"), "/design.toml"));
    DesignPoint::from_file(text).expect("the build script wrote a design file")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_compiled_design_can_be_built() {
        assert_eq!(compiled().check_buildable(), Ok(()));
    }
}
