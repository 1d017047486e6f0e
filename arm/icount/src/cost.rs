//! Cycles of an instruction on the Cortex-A9 by a table, for A32 code: cycles for which it occupies its pipeline, and
//! cycles until its result can be used.
//!
//! The numbers are those of ARM's description of this pipeline in GCC, `gcc/config/arm/cortex-a9.md`; for the square
//! root, which it does not have, those of a division and a quarter more. Advanced SIMD on four words is taken as two
//! cycles. Dual issue, and mispredicted branches, are not modelled.

/// Cycles of an instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cost {
    /// Until the next instruction of its pipeline can begin.
    pub issue: u64,
    /// Until its result can be used, at least `issue`.
    pub latency: u64,
}

const fn cost(issue: u64, latency: u64) -> Cost {
    Cost { issue, latency }
}

/// Returns the cost of an instruction.
pub fn of(code: u32) -> Cost {
    let bits = |from: u32, count: u32| code >> from & ((1 << count) - 1);
    let is_load = bits(20, 1) == 1;
    let memory = |issue: u64| cost(issue, if is_load { issue + 3 } else { issue });
    if bits(28, 4) == 15 {
        return match bits(24, 4) {
            // Advanced SIMD: arithmetic, and loads and stores of structures.
            2 | 3 => {
                if bits(6, 1) == 1 {
                    cost(2, 4)
                } else {
                    cost(1, 3)
                }
            }
            4 => {
                if bits(21, 1) == 1 {
                    cost(2, 4)
                } else {
                    cost(2, 2)
                }
            }
            _ => cost(1, 1),
        };
    }
    let is_floating = matches!(bits(8, 4), 10 | 11);
    let is_double = bits(8, 4) == 11;
    match bits(25, 3) {
        6 if is_floating && bits(24, 1) == 1 && bits(21, 1) == 0 => memory(1),
        6 if is_floating => memory(u64::from(bits(0, 8)).div_ceil(2).max(1)),
        7 if is_floating && bits(24, 1) == 0 && bits(4, 1) == 0 => arithmetic(code, is_double),
        7 => cost(1, 2),
        5 => cost(1, 1),
        4 => memory(u64::from(bits(0, 16).count_ones()).div_ceil(2).max(1)),
        2 => memory(1),
        3 if bits(4, 1) == 0 => memory(1),
        3 => cost(1, 2),
        0 if bits(4, 4) == 9 && bits(24, 1) == 0 => {
            if bits(23, 1) == 0 {
                cost(2, 4)
            } else {
                cost(3, 5)
            }
        }
        0 if bits(7, 1) == 1 && bits(4, 1) == 1 => memory(1),
        0 if bits(4, 8) != 0 => cost(1, 2),
        _ => cost(1, 1),
    }
}

/// Returns the cost of a floating-point operation.
fn arithmetic(code: u32, is_double: bool) -> Cost {
    let extension = code >> 16 & 15;
    match (code >> 23 & 1, code >> 20 & 3) {
        (0, 0 | 1) | (1, 1 | 2) => {
            if is_double {
                cost(2, 9)
            } else {
                cost(1, 8)
            }
        }
        (0, 2) => {
            if is_double {
                cost(2, 5)
            } else {
                cost(1, 4)
            }
        }
        (0, _) => cost(1, 4),
        (1, 0) => {
            if is_double {
                cost(25, 25)
            } else {
                cost(15, 15)
            }
        }
        // Square root, comparison, conversion, and moves.
        _ if extension == 1 && code >> 6 & 3 == 3 => {
            if is_double {
                cost(32, 32)
            } else {
                cost(19, 19)
            }
        }
        _ if matches!(extension, 4 | 5) => cost(1, 1),
        _ if extension >= 7 => cost(1, 4),
        _ => cost(1, 2),
    }
}
