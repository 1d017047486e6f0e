//! The design that the emitter is compiled for, as constants, and what a design must keep to be built.
//!
//! The numbers come from the design file by the build script; what follows from them stands here. Leaf cells use the
//! names in their Verilog, bodies of `#[hdl_gen]` as slices and array lengths. [`crate::emission::post_pass`] puts the
//! numbers in their place ([`CONSTANTS`]), because rust-hdl prints the names.

use hoverlock_fixed_point::model::bit_true::record_words;
use hoverlock_fixed_point::model::design::{AutomaticThreshold, DesignPoint};
use hoverlock_fixed_point::model::format::Format;

include!(concat!(env!("OUT_DIR"), "/design.rs"));

/// Defines the constants and lists them with their names.
macro_rules! constants {
    ($($(#[$doc:meta])* $name:ident = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: usize = $value;)*

        /// The constants that may stand in Verilog, by name.
        pub const CONSTANTS: &[(&str, usize)] = &[
            ("SCALE_PAIRS", SCALE_PAIRS),
            ("PIXEL_BITS", PIXEL_BITS),
            ("COEFFICIENT_BITS", COEFFICIENT_BITS),
            ("DOG_BITS", DOG_BITS),
            $((stringify!($name), $name)),*
        ];
    };
}

constants! {
    /// Bits of a filter state.
    STATE_BITS = PIXEL_BITS + FRACTION_BITS;
    /// The state's highest bit.
    STATE_TOP = STATE_BITS - 1;
    /// Bits of a difference of two states with its sign.
    DIFFERENCE_BITS = STATE_BITS + 1;
    /// Bits of a coefficient times a distance.
    PRODUCT_BITS = STATE_BITS + COEFFICIENT_BITS;
    /// Bits of a response and its sign.
    SIGNED_BITS = DOG_BITS + 1;
    /// Bits of the step of a threshold.
    CHANGE_BITS = DOG_BITS - 2;
    /// Bits of a column.
    COLUMN_BITS = WIDTH.next_power_of_two().trailing_zeros() as usize;
    /// Words of a line memory.
    LINE_WORDS = 1 << COLUMN_BITS;
    /// Bits of `W`.
    WIDTH_BITS = COLUMN_BITS + 1;
    /// Largest `W`.
    MAX_WIDTH = WIDTH;
    /// Bits of a row.
    ROW_BITS = 11;
    /// Bits of `H`.
    HEIGHT_BITS = ROW_BITS + 1;
    /// Largest `H`.
    MAX_HEIGHT = 1 << ROW_BITS;
    /// Bits of a position, the row above the column.
    POSITION_BITS = ROW_BITS + COLUMN_BITS;
    /// Bits of the number of steps of [`crate::cells::sequencer::DRAIN_LINES`].
    DRAIN_BITS = COLUMN_BITS + 7;
    /// One bit less.
    DRAIN_TOP = DRAIN_BITS - 1;
    /// Bits of a beat of the video with its two flags.
    BEAT_BITS = PIXEL_BITS + 2;
    /// Coefficients of the smoothers.
    COEFFICIENTS = coefficients();
    /// Bits of a bank: the coefficients, a threshold for each scale pair, target and mode, 16 bits each.
    BANK_BITS = 16 * (COEFFICIENTS + SCALE_PAIRS + 2);
    /// Where the threshold of scale pair 0 stands in a bank.
    THRESHOLD_0_AT = 16 * COEFFICIENTS;
    /// Of scale pair 1, where there is one.
    THRESHOLD_1_AT = THRESHOLD_0_AT + 16;
    /// Of scale pair 2.
    THRESHOLD_2_AT = THRESHOLD_0_AT + 32;
    /// The target.
    TARGET_AT = THRESHOLD_0_AT + 16 * SCALE_PAIRS;
    /// The mode.
    MODE_AT = TARGET_AT + 16;
    /// Bits of the six rows above the newest one of a 7x7 window.
    WINDOW_BITS = 6 * SIGNED_BITS;
    /// Bits of the four neighbours of a centre.
    NEIGHBOURS_BITS = 4 * DOG_BITS;
    /// Bits of the 15 rows that a ring of 9 to 16 px has.
    RING_BITS = 15 * SIGNED_BITS;
    /// Bits of those of the widest ring that are not the newest.
    OLDER_BITS = 14 * SIGNED_BITS;
    /// Bits of the 32 points of a ring.
    POINTS_BITS = 32 * SIGNED_BITS;
    /// Where the hits stand in a candidate, above the position, one bit for each scale pair.
    HITS_AT = POSITION_BITS;
    /// Signs and responses of the scale pairs.
    CENTRES_AT = HITS_AT + SCALE_PAIRS;
    /// Their neighbours.
    NEIGHBOURS_AT = CENTRES_AT + SCALE_PAIRS * SIGNED_BITS;
    /// Bits of a candidate.
    CANDIDATE_BITS = NEIGHBOURS_AT + SCALE_PAIRS * NEIGHBOURS_BITS;
    /// Bits of a record.
    RECORD_BITS = 32 * record_words(SCALE_PAIRS);
}

/// A recursion and its look-ahead for each smoother.
const fn coefficients() -> usize {
    let (mut smoother, mut sum) = (0, 0);
    while smoother < LOOK_AHEAD.len() {
        sum += 1 + LOOK_AHEAD[smoother];
        smoother += 1;
    }
    sum
}

/// One DoG LSB is `2^s` state LSB.
pub const DOG_SHIFT: usize = STATE_BITS - 2 - DOG_BITS;

/// Smallest `W` and `H`.
pub const LEAST_SIDE: usize = 64;

/// Lines of the longest smoother.
pub const SMOOTHER_LINES: usize = (1 << LONGEST) - 1;

/// Steps of the longest smoother in addition to its lines.
pub const SMOOTHER_STEPS: usize = crate::smoother::steps(LONGEST as u64) as usize;

/// Look-ahead of the longest smoother.
pub const LONGEST: usize = {
    let (mut smoother, mut longest) = (0, 0);
    while smoother < LOOK_AHEAD.len() {
        if LOOK_AHEAD[smoother] > longest {
            longest = LOOK_AHEAD[smoother];
        }
        smoother += 1;
    }
    longest
};

/// The design that this was compiled for.
pub fn compiled() -> DesignPoint {
    DesignPoint {
        width: WIDTH as u32,
        height: HEIGHT as u32,
        pixel: Format::unsigned(PIXEL_BITS as i8, 0),
        state: Format::unsigned(PIXEL_BITS as i8, FRACTION_BITS as i8),
        coefficient: Format::unsigned(0, COEFFICIENT_BITS as i8),
        scale_pairs: SCALE_PAIRS as u32,
        sigmas: SIGMAS.to_vec().into(),
        look_ahead: LOOK_AHEAD.iter().map(|m| *m as u32).collect(),
        dog_bits: DOG_BITS as u32,
        ring_radii: RING_RADII.to_vec().into(),
        threshold: AutomaticThreshold { target: THRESHOLD_TARGET as u32, initial: THRESHOLD_INITIAL as u32 },
        candidate_queue: CANDIDATE_QUEUE as u32,
        record_fifo: RECORD_FIFO as u32,
    }
}

/// Why a design has a model and no hardware.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{key} = {value} cannot be built: {why}")]
pub struct Unbuildable {
    key: &'static str,
    value: String,
    why: &'static str,
}

/// Checks what the hardware cannot do.
///
/// # Errors
/// The first constraint that the design breaks.
pub fn buildable(design: &DesignPoint) -> Result<(), Unbuildable> {
    let DesignPoint { width, height, state, coefficient, look_ahead, dog_bits, ring_radii, threshold, .. } = design;
    let constraints = [
        ("width", width.to_string(), (64..=4096).contains(width), "the hardware takes 64 to 4096 columns"),
        ("height", height.to_string(), (64..=2048).contains(height), "the hardware takes 64 to 2048 rows"),
        (
            "state",
            state.to_string(),
            state.bits() <= 18,
            "the multiplier of a lerp is 18 x 18, so a state has at most 18 bits",
        ),
        (
            "coefficient",
            coefficient.to_string(),
            coefficient.bits() <= 16,
            "a field of the register bank has 16 bits, so a coefficient has at most 16",
        ),
        (
            "look_ahead",
            format!("{look_ahead:?}"),
            look_ahead.iter().all(|m| (2..=6).contains(m)),
            "a smoother has 2 to 6 stages each way, because frames may have 64 rows only",
        ),
        (
            "look_ahead",
            format!("{look_ahead:?}"),
            look_ahead.is_sorted(),
            "the pixels of a smoother are delayed to align it with the wider ones, so none may look further ahead",
        ),
        (
            "dog_bits",
            dog_bits.to_string(),
            (6..=15).contains(dog_bits),
            "a response has 6 to 15 bits, half a word of a record with its sign",
        ),
        (
            "dog_bits",
            dog_bits.to_string(),
            design.dog_shift() >= 0,
            "an LSB of the response would be finer than one of the state; give the state more fraction bits",
        ),
        (
            "ring_radii",
            format!("{ring_radii:?}"),
            ring_radii.iter().all(|radius| (9..=16).contains(radius)),
            "the hardware has the 15 rows of a ring from 9 to 16 px",
        ),
        (
            "threshold_initial",
            threshold.initial.to_string(),
            threshold.initial <= design.max_dog(),
            "it is more than the largest response, 2^dog_bits - 1",
        ),
    ];
    match constraints.into_iter().find(|(_, _, kept, _)| !kept) {
        Some((key, value, _, why)) => Err(Unbuildable { key, value, why }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_fixed_point::model::design::{KT27, SHIPPED};

    #[test]
    fn the_compiled_design_can_be_built_like_every_shipped_one() {
        assert_eq!(buildable(&compiled()), Ok(()));
        for (name, text) in SHIPPED {
            assert_eq!(buildable(&DesignPoint::from_file(text).unwrap()), Ok(()), "{name}");
        }
    }

    #[test]
    fn a_design_that_cannot_be_built_is_refused_by_its_constraint() {
        for (change, part) in [
            ("width=63", "64 to 4096 columns"),
            ("height=2049", "64 to 2048 rows"),
            ("state=u16.3", "at most 18 bits"),
            ("coefficient=u0.17", "at most 16"),
            ("look_ahead=[5, 5, 7]", "2 to 6 stages"),
            ("look_ahead=[5, 6, 5]", "none may look further"),
            ("dog_bits=16", "6 to 15"),
            ("state=u16.0", "finer than one of the state"),
            ("ring_radii=[8, 16]", "15 rows of a ring from 9 to 16"),
            ("threshold_initial=40000", "largest response"),
        ] {
            let error = buildable(&KT27.with_override(change).unwrap()).expect_err(change).to_string();
            assert!(error.contains(part) && error.contains(" cannot be built: "), "{error}");
            assert_eq!(error.lines().count(), 1);
        }
    }
}
