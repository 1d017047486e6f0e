//! Hamming distances of one descriptor to sixteen others at once.

use crate::motion::matching::candidate::{BYTES, Candidate, Words};
use crate::motion::matching::{BLOCK_WORK, WIDE_BLOCK_WORK};

/// Candidates in a block: the bytes of a NEON or SSE register.
pub(super) const BLOCK: usize = 16;

/// The descriptors of sixteen candidates, with byte `k` of all candidates side by side.
///
/// The Hamming distances of sixteen pairs are then sixteen times exclusive or, bit count of each byte, and sum of
/// bytes; the largest distance, 192, fits a byte. Compilers vectorise this for x86-64. For NEON they sum along the
/// wrong axis: about 1000 instructions a block, where [`neon`] has about 100 (by the assembly of both).
pub(super) struct Block {
    bytes: [[u8; BLOCK]; BYTES],
    /// Bytes of the third scale pair; `None` if all are 0.
    third: Option<Box<[[u8; BLOCK]; BYTES / 2]>>,
    /// Largest Hamming distance that is of interest to each candidate.
    pub(super) limits: [u8; BLOCK],
    /// Bit mask of the lanes that have a candidate.
    lanes: u16,
}

impl Block {
    /// Interleaves the descriptors of at most sixteen candidates.
    pub(super) fn of(candidates: &[Candidate]) -> Self {
        let lanes = (((1u32 << candidates.len()) - 1) & 0xffff) as u16;
        let mut block = Self { bytes: [[0; BLOCK]; BYTES], third: None, limits: [u8::MAX; BLOCK], lanes };
        for (lane, candidate) in candidates.iter().enumerate() {
            let Words { bytes, third } = candidate.words;
            (0..BYTES).for_each(|k| block.bytes[k][lane] = bytes[k]);
            if third != [0; BYTES / 2] {
                let lanes = block.third.get_or_insert_default();
                (0..BYTES / 2).for_each(|k| lanes[k][lane] = third[k]);
            }
        }
        block
    }

    /// Returns the work units of [`Block::closer`].
    pub(super) fn work(&self, words: &Words) -> usize {
        if self.is_wide(words) { WIDE_BLOCK_WORK } else { BLOCK_WORK }
    }

    /// Returns `true` if the third scale pair must be compared.
    fn is_wide(&self, words: &Words) -> bool {
        self.third.is_some() || words.third != [0; BYTES / 2]
    }

    /// Computes all Hamming distances. Returns a bit mask of the lanes whose distance is at most `limit` or at most the
    /// limit of the candidate, and the distances.
    #[inline(always)]
    pub(super) fn closer(&self, words: &Words, limit: u8) -> (u16, [u8; BLOCK]) {
        if self.is_wide(words) {
            let (closer, hamming) = self.three_pairs(words, limit);
            return (closer & self.lanes, hamming);
        }
        #[cfg(all(target_arch = "arm", target_feature = "neon"))]
        let (closer, hamming) = neon::closer(&self.bytes, &self.limits, &words.bytes, limit);
        #[cfg(not(all(target_arch = "arm", target_feature = "neon")))]
        let (closer, hamming) = self.two_pairs(words, limit);
        (closer & self.lanes, hamming)
    }

    /// Compares all three scale pairs.
    fn three_pairs(&self, words: &Words, limit: u8) -> (u16, [u8; BLOCK]) {
        const NONE: &[[u8; BLOCK]; BYTES / 2] = &[[0; BLOCK]; BYTES / 2];
        let mut hamming = [0u8; BLOCK];
        add_distances(&mut hamming, &self.bytes, &words.bytes);
        add_distances(&mut hamming, self.third.as_deref().unwrap_or(NONE), &words.third);
        self.near(hamming, limit)
    }

    /// Compares two scale pairs, in portable code.
    #[cfg_attr(all(target_arch = "arm", target_feature = "neon"), expect(dead_code, reason = "for other processors"))]
    fn two_pairs(&self, words: &Words, limit: u8) -> (u16, [u8; BLOCK]) {
        let mut hamming = [0u8; BLOCK];
        add_distances(&mut hamming, &self.bytes, &words.bytes);
        self.near(hamming, limit)
    }

    /// Compares the distances with both limits.
    #[inline(always)]
    fn near(&self, hamming: [u8; BLOCK], limit: u8) -> (u16, [u8; BLOCK]) {
        let mut small = [0u8; BLOCK];
        for ((small, hamming), other) in small.iter_mut().zip(&hamming).zip(&self.limits) {
            *small = u8::from(*hamming <= limit) | u8::from(hamming <= other);
        }
        // Gathering the bits is skipped for most blocks, which have none.
        if small == [0; BLOCK] {
            return (0, hamming);
        }
        (small.iter().enumerate().fold(0, |bits, (lane, small)| bits | u16::from(*small) << lane), hamming)
    }
}

/// Adds the bit distance of each lane to each byte.
#[inline(always)]
fn add_distances<const N: usize>(hamming: &mut [u8; BLOCK], lanes: &[[u8; BLOCK]; N], bytes: &[u8; N]) {
    for (lanes, byte) in lanes.iter().zip(bytes) {
        for (sum, lane) in hamming.iter_mut().zip(lanes) {
            *sum += (lane ^ byte).count_ones() as u8;
        }
    }
}

/// The inner loop in NEON instructions.
#[cfg(all(target_arch = "arm", target_feature = "neon"))]
mod neon {
    use super::{BLOCK, BYTES};
    use std::arch::asm;

    /// Adds the distances in one byte of the descriptors.
    macro_rules! byte {
        () => {
            "vld1.8 {{d18[], d19[]}}, [{bytes}]!
            vld1.8 {{d20, d21}}, [{lanes}]!
            veor q9, q9, q10
            vcnt.8 q9, q9
            vadd.i8 q8, q8, q9
            "
        };
    }

    // Repeated by hand: the compiler does not know the length of `.rept` when it places constants.
    macro_rules! four_bytes {
        () => {
            concat!(byte!(), byte!(), byte!(), byte!())
        };
    }

    /// Computes what the portable code does: for every byte of a descriptor `vld1` of that byte into all lanes, `vld1`
    /// of the bytes of sixteen candidates, `veor`, `vcnt`, `vadd`; then the comparisons, and a bit for each lane.
    #[inline(always)]
    pub fn closer(
        lanes: &[[u8; BLOCK]; BYTES],
        limits: &[u8; BLOCK],
        bytes: &[u8; BYTES],
        limit: u8,
    ) -> (u16, [u8; BLOCK]) {
        const WEIGHTS: [u8; BLOCK] = [1, 2, 4, 8, 16, 32, 64, 128, 1, 2, 4, 8, 16, 32, 64, 128];
        let mut hamming = [0u8; BLOCK];
        let mut closer: u32;
        // SAFETY: reads `lanes`, `limits`, `bytes` and the weights, writes `hamming`, each over its whole length and
        // not beyond; `vld1.8` and `vst1.8` need no alignment. All registers that change are named, the stack is not
        // used.
        unsafe {
            asm!(
                "vmov.i8 q8, #0",
                four_bytes!(),
                four_bytes!(),
                four_bytes!(),
                four_bytes!(),
                "vdup.8 q9, {closer}",
                "vld1.8 {{d20, d21}}, [{limits}]",
                "vld1.8 {{d22, d23}}, [{weights}]",
                "vmax.u8 q9, q9, q10",
                "vcge.u8 q9, q9, q8",
                "vand q9, q9, q11",
                "vpadd.i8 d18, d18, d19",
                "vpadd.i8 d18, d18, d18",
                "vpadd.i8 d18, d18, d18",
                "vmov.u16 {closer}, d18[0]",
                "vst1.8 {{d16, d17}}, [{hamming}]",
                bytes = inout(reg) bytes.as_ptr() => _,
                lanes = inout(reg) lanes.as_ptr() => _,
                limits = in(reg) limits.as_ptr(),
                weights = in(reg) WEIGHTS.as_ptr(),
                hamming = in(reg) hamming.as_mut_ptr(),
                closer = inout(reg) u32::from(limit) => closer,
                out("q8") _,
                out("q9") _,
                out("q10") _,
                out("q11") _,
                options(nostack, preserves_flags),
            );
        }
        (closer as u16, hamming)
    }
}
