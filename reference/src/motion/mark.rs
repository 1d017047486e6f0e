//! Marks between the parts of a frame's work. An emulator counts the instructions between them.
//!
//! On the ARM a mark is one instruction without effect, `and rN, rN, rN`, that no compiler emits; elsewhere it compiles
//! to nothing.

/// A part of the work that begins at a mark. Its number is the number of the register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Part {
    /// All work that is in no other part: records, gate, output.
    Frame = 1,
    /// Comparison of descriptors.
    Matching = 2,
    /// Search of the motion by RANSAC.
    Search = 3,
    /// The pose fit.
    Pose = 4,
    /// Pixels to feature records, if software does that.
    Extraction = 5,
    /// Templates: cut from a keyframe, and refined on the present frame.
    Refinement = 6,
    /// Bytes of the stream to messages and pixels, which lie in memory on a board.
    Transfer = 7,
    /// The end of a frame.
    End = 8,
}

/// Marks the beginning of a part.
#[inline(always)]
pub fn mark(part: Part) {
    #[cfg(target_arch = "arm")]
    {
        use std::arch::asm;
        // SAFETY: a register is combined with itself and keeps its value, flags are not changed. Without `nomem` no
        // access to memory moves over the mark.
        unsafe {
            match part {
                Part::Frame => asm!("and r1, r1, r1", options(nostack, preserves_flags)),
                Part::Matching => asm!("and r2, r2, r2", options(nostack, preserves_flags)),
                Part::Search => asm!("and r3, r3, r3", options(nostack, preserves_flags)),
                Part::Pose => asm!("and r4, r4, r4", options(nostack, preserves_flags)),
                Part::Extraction => asm!("and r5, r5, r5", options(nostack, preserves_flags)),
                Part::Refinement => asm!("and r6, r6, r6", options(nostack, preserves_flags)),
                Part::Transfer => asm!("and r7, r7, r7", options(nostack, preserves_flags)),
                Part::End => asm!("and r8, r8, r8", options(nostack, preserves_flags)),
            }
        }
    }
    #[cfg(not(target_arch = "arm"))]
    let _ = part;
}
