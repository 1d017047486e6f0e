//! Resources of a design point: `M10K = sum over memories ceil(width / w(words))`,
//! `lerps = sum over smoothers (2 + 3 m)`: the recursion, `3 m` stages, and the first stage at a second row.
//!
//! This memory model equals the Yosys estimate of the shipped designs. Emission and synthesis of a design take minutes,
//! so a search among designs and a report use the model. A memory of `1024` words is
//! `ceil(width / 10)` blocks, of `512` words `ceil(width / 20)`; [`blocks`] has the rule. A memory of up to 32 words is
//! in logic (MLAB), unless it fills a twentieth of a block; then Yosys uses a block. One lerp is one multiplier,
//! `|q - p|` times a coefficient, unsigned: 9x9 where both have at most 9 bits, three of which share a DSP block and
//! count as two; 18x18 where both have at most 18 bits, two of which share a block; else 27x27, which takes a block and
//! counts as two (tried in Yosys: 9 by 9; 19 and 20 by 16; 18 by 28, which takes two of 18x18).
//!
//! The model is in this crate because it depends on the word lengths only, and the report must not depend on the RTL
//! crate. A test of the synthesis crate compares it with Yosys, memory by memory.

use serde::Serialize;

use hoverlock_design::{DesignPoint, Protection};
use hoverlock_reference::features::maxlbp::MAX_RING_RADIUS;
use hoverlock_registers::record::record_words;

/// Memories of equal depth and width.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Memory {
    /// Depth of each memory, words.
    pub words: u64,
    /// Width of a word, bits.
    pub width: u64,
    /// Number of these memories.
    pub count: u64,
    /// Purpose, in words for the report.
    pub purpose: &'static str,
}

/// The resources of a design point that depend on its word lengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Resources {
    /// Block memories of 10 Kbit.
    pub m10k: u64,
    /// Adaptive logic modules, about: see [`alm`].
    pub alm: u64,
    /// Multipliers in units of 18 x 18; one of 27 x 27 counts as two, three of 9 x 9 count as two.
    pub mul18: u64,
    /// DSP blocks, each with three 9 x 9 multipliers, two 18 x 18 or one 27 x 27.
    pub dsp: u64,
}

/// Depth and width of the configurations of an M10K block, without `256 x 40`, which Yosys does not know: Quartus may
/// take fewer blocks for memories of up to 256 words.
const FORMS: [(u64, u64); 5] = [(512, 20), (1024, 10), (2048, 5), (4096, 2), (8192, 1)];

/// Bits of an M10K block.
const BLOCK_BITS: u64 = 10_240;

/// Largest depth of a memory in logic, words.
pub const MLAB_WORDS: u64 = 32;

/// Longest delay of one memory in logic, steps: its words and an output register.
const LONGEST_DELAY: u64 = MLAB_WORDS + 1;

/// Bits of a row: the hardware takes 2048.
const ROW_BITS: u64 = 11;

/// Returns the number of M10K blocks of a simple dual-port memory: `ceil(words / 2^a) ceil(width / w)` of the form
/// `2^a x w` whose bits are used best, and of forms that are equal the widest. That is the choice of Yosys, tried for
/// widths of 1 to 44 bits and 350.
pub fn blocks(words: u64, width: u64) -> u64 {
    let count = |(deep, wide): (u64, u64)| words.div_ceil(deep) * width.div_ceil(wide);
    // Used bits are the same for all forms, so the best use is the smallest number of bits.
    FORMS.into_iter().min_by_key(|&(deep, wide)| count((deep, wide)) * deep * wide).map_or(0, count)
}

/// Returns the memories of a design that use M10K blocks.
pub fn memories(design: &DesignPoint) -> Vec<Memory> {
    let line = u64::from(design.width).next_power_of_two();
    // A protected memory has a bit more for each sample, candidate and record. Delays are not protected.
    let parity = u64::from(design.protection != Protection::Off);
    let (pixel, state) = (u64::from(design.pixel.bits()), u64::from(design.state.bits()));
    let magnitude = u64::from(design.dog_bits);
    // Each response has a sign bit.
    let response = magnitude + 1;
    let (pairs, smoothers) = (design.scale_pairs.into(), design.smoothers() as u64);
    let longest = design.look_ahead.iter().copied().max().unwrap_or(0);
    let shortest = design.look_ahead.iter().copied().min().unwrap_or(0);
    let mut found = Vec::new();
    let mut add = |purpose, count: u64, words: u64, width: u64| {
        found.push(Memory { words, width, count, purpose });
    };
    // The two longest column stages of a smoother see rows of pixels, which all smoothers share. The others keep rows
    // of states. All are one word.
    let rows = (1u64 << longest) - (1 << shortest.saturating_sub(2));
    let states: u64 = design.look_ahead.iter().map(|m| (1 << m.saturating_sub(2)) - 1).sum();
    add("column look-ahead", 1, line, rows * (pixel + parity) + states * (state + parity));
    add("state of the recursions", smoothers, line, state + parity);
    add("held last row", 1, line, pixel + parity);
    for j in 0..longest {
        let stages = design.look_ahead.iter().filter(|m| **m > j).count() as u64;
        add("row look-back and look-ahead", 2 * stages, (1 << j) - 1, state);
    }
    for (smoother, m) in design.look_ahead.iter().enumerate().filter(|(_, m)| **m < longest) {
        // Smoothers of one look-ahead share their rows of pixels.
        if !design.look_ahead[..smoother].contains(m) {
            add("rows of a shorter smoother", 1, u64::from(4 * (longest - m)) - 1, 4 * pixel);
        }
        let steps = u64::from(8 * (longest - m)) + (1 << longest) - (1 << m);
        let cells = steps.div_ceil(LONGEST_DELAY);
        for cell in 0..cells {
            add("output of a shorter smoother", 1, (steps + cells - 1 - cell) / cells - 1, state);
        }
    }
    add("7x7 windows", pairs, line, 6 * (response + parity));
    for radius in design.ring_radii.iter().copied() {
        // From the last row of the widest ring to the first of this one.
        add("rings", 1, line, u64::from(MAX_RING_RADIUS + radius) * (response + parity));
    }
    // Position, and of each scale pair a hit, the response with its sign, and four neighbours.
    let position = ROW_BITS + u64::from(line.trailing_zeros());
    add("candidates", 1, design.candidate_queue.into(), position + pairs * (1 + response + 4 * magnitude) + parity);
    let record = 32 * record_words(design.pairs()) as u64;
    add("records", 1, design.record_fifo.into(), record + parity);
    found.retain(|memory| memory.words > MLAB_WORDS || 20 * memory.words * memory.width >= BLOCK_BITS);
    found.retain(|memory| memory.width > 0);
    found
}

/// Estimates the adaptive logic modules of a design: `L (2.73 s + c/4 + 68.1) + k (74 N + 577)` for `L` lerps, `k`
/// scale pairs and words of `s` (state), `c` (coefficient) and `N` bits (DoG).
///
/// A line through the Yosys estimates of the shipped designs, which it meets within 2 %: a lerp with its coefficient
/// and borders, and what there is for each scale pair. It orders designs of equal memory; a number to rely on is that
/// of `hoverlock rtl estimate`.
pub fn alm(design: &DesignPoint) -> u64 {
    let bits = |word: u32| f64::from(word);
    let lerps: f64 = design.look_ahead.iter().map(|m| 2.0 + 3.0 * bits(*m)).sum();
    let lerp = 2.73 * bits(design.state.bits()) + bits(design.coefficient.bits()) / 4.0 + 68.1;
    (lerps * lerp + bits(design.scale_pairs) * (74.0 * bits(design.dog_bits) + 577.0)).round() as u64
}

/// Estimates block memories, ALMs, multipliers and DSP blocks of a design from its word lengths, without Yosys.
pub fn resources(design: &DesignPoint) -> Resources {
    let lerps: u64 = design.look_ahead.iter().map(|m| 2 + 3 * u64::from(*m)).sum();
    let m10k = memories(design).iter().map(|memory| memory.count * blocks(memory.words, memory.width)).sum();
    let (state, coefficient) = (design.state.bits(), design.coefficient.bits());
    // Sixths of a DSP block.
    let each = match (state, coefficient) {
        (..=9, ..=9) => 2,
        (..=18, ..=18) => 3,
        // One of 27x27, or two of 18x18 side by side.
        (..=18, _) | (..=27, ..=27) => 6,
        (..=27, _) => 9,
        _ => 12,
    };
    Resources { m10k, alm: alm(design), mul18: (each * lerps).div_ceil(3), dsp: (each * lerps).div_ceil(6) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_design::KT27;

    #[test]
    fn block_memories_have_five_forms() {
        for (words, width, count) in [
            (1024, 576, 58),
            (1024, 18, 2),
            (512, 256, 13),
            (512, 175, 9),
            (256, 256, 13),
            (2048, 10, 2),
            (9000, 3, 6),
            // Read from netlists of Yosys 0.23: 2048 x 5 where it leaves nothing unused, else 4096 x 2.
            (4096, 10, 4),
            (4096, 11, 6),
            (4096, 18, 9),
            (4096, 36, 18),
            (4096, 350, 140),
            (8192, 5, 4),
            (8192, 18, 18),
        ] {
            assert_eq!(blocks(words, width), count, "{words} x {width}");
        }
    }

    #[test]
    fn memories_of_every_number_of_scale_pairs_are_those_that_yosys_counts() {
        for (name, counted) in [("kt27", 291), ("small", 118), ("three_scales", 337)] {
            assert_eq!(resources(&DesignPoint::shipped(name).unwrap()).m10k, counted, "{name}");
        }
    }

    #[test]
    fn alms_are_about_those_that_yosys_counts() {
        for (name, counted) in [("kt27", 9984.0), ("hd1080", 8583.0), ("small", 6463.0), ("three_scales", 13204.0)] {
            let alm = alm(&DesignPoint::shipped(name).unwrap()) as f64;
            assert!((alm / counted - 1.0).abs() < 0.02, "{name}: {alm}");
        }
    }

    #[test]
    fn resources_follow_the_word_lengths() {
        let of = |change: &str| resources(&KT27.with_override(change).unwrap());
        let chosen = of("dog_bits=15");
        // 2 + 3 m cells a smoother, m = 5, 5, 6: 17 + 17 + 20.
        assert_eq!((chosen.mul18, chosen.dsp), (54, 27));
        // Coefficients lie in no memory, and up to 18 bits fit the multiplier.
        let memory = |of: Resources| (of.m10k, of.mul18, of.dsp);
        assert_eq!([of("coefficient=u0.8"), of("coefficient=u0.18")].map(memory), [memory(chosen); 2]);
        // Of 9 by 9 bits three share a block, and of 9 by 10 two.
        let narrow = |coefficient: &str| {
            let of = resources(&KT27.with_overrides(["pixel=u8.0", "state=u8.1", coefficient]).unwrap());
            (of.mul18, of.dsp)
        };
        assert_eq!([narrow("coefficient=u0.9"), narrow("coefficient=u0.10")], [(36, 18), (54, 27)]);
        // A state of 19 bits takes a whole block each.
        assert_eq!((of("state=u16.3").mul18, of("state=u16.3").dsp), (108, 54));
        // 56 rows of pixels and 7 + 7 + 15 rows of states are one word: 896 bits, and 464 at 16 bits of state,
        // 522 at 18.
        // Recursions take two blocks each, whatever the state; two delays of 31 words are in logic.
        assert_eq!(chosen.m10k - of("state=u16.0").m10k, 142 - 136 + 2);
        // Windows, rings and candidates follow the DoG.
        let rings = |response: u64| blocks(1024, 28 * response) + blocks(1024, 32 * response);
        let windows = |response: u64| 2 * blocks(1024, 6 * response);
        let queue = |magnitude: u64| blocks(512, 25 + 10 * magnitude);
        let dogs = |magnitude: u64| rings(magnitude + 1) + windows(magnitude + 1) + queue(magnitude);
        assert_eq!(chosen.m10k - of("dog_bits=12").m10k, dogs(15) - dogs(12));
    }
}
