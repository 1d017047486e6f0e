// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

//! Byte addresses and masks of the registers.

/// Byte address of `identification`.
pub const IDENTIFICATION: u32 = 0x00;
/// `HLCK` (read).
pub const IDENTIFICATION_LETTERS: u32 = 0xffffffff;
/// Byte address of `version`.
pub const VERSION: u32 = 0x04;
/// major above minor, 16 bits each (read).
pub const VERSION_NUMBER: u32 = 0xffffffff;
/// Byte address of `emission`.
pub const EMISSION: u32 = 0x08;
/// first 32 bits of the SHA-256 of the emitted Verilog (read).
pub const EMISSION_HASH: u32 = 0xffffffff;
/// Byte address of `control`.
pub const CONTROL: u32 = 0x0c;
/// frames are taken; otherwise they are dropped whole (read, write).
pub const CONTROL_ENABLE: u32 = 0x00000001;
/// thresholds follow the count of the frame before; part of the set (read, write).
pub const CONTROL_AUTOMATIC: u32 = 0x00000002;
/// interrupt at the end of a frame (read, write).
pub const CONTROL_INTERRUPT_FRAME: u32 = 0x00000004;
/// interrupt at an error (read, write).
pub const CONTROL_INTERRUPT_ERROR: u32 = 0x00000008;
/// clears the pipeline and the FIFO, not the registers (write 1).
pub const CONTROL_RESET: u32 = 0x80000000;
/// Byte address of `status`.
pub const STATUS: u32 = 0x10;
/// a frame was finished (write 1 to clear).
pub const STATUS_FRAME: u32 = 0x00000001;
/// end of packet before the last pixel; the frame was padded (write 1 to clear).
pub const STATUS_SHORT_FRAME: u32 = 0x00000002;
/// no end of packet at the last pixel; what followed was dropped (write 1 to clear).
pub const STATUS_LONG_FRAME: u32 = 0x00000004;
/// start of packet before the last pixel; the frame was padded (write 1 to clear).
pub const STATUS_INTERRUPTED: u32 = 0x00000008;
/// a beat outside a frame, or a frame of an impossible size (write 1 to clear).
pub const STATUS_REFUSED: u32 = 0x00000010;
/// features were dropped (write 1 to clear).
pub const STATUS_DROPPED: u32 = 0x00000020;
/// a response was cut to the largest code (write 1 to clear).
pub const STATUS_SATURATED: u32 = 0x00000040;
/// a frame has begun, with the set if one was committed: the registers are free for the next (write 1 to clear).
pub const STATUS_BEGUN: u32 = 0x00000080;
/// frames are in the pipeline (read).
pub const STATUS_BUSY: u32 = 0x80000000;
/// Byte address of `size`.
pub const SIZE: u32 = 0x14;
/// columns, 64 to 1024 (read, write).
pub const SIZE_WIDTH: u32 = 0x000007ff;
/// rows, 64 to 2048 (read, write).
pub const SIZE_HEIGHT: u32 = 0x0fff0000;
/// Byte address of `threshold`.
pub const THRESHOLD: u32 = 0x18;
/// least response of scale pair 0, half DN (read, write).
pub const THRESHOLD_FINE: u32 = 0x00007fff;
/// least response of scale pair 1 (read, write).
pub const THRESHOLD_COARSE: u32 = 0x7fff0000;
/// Byte address of `target`.
pub const TARGET: u32 = 0x1c;
/// features per scale pair (read, write).
pub const TARGET_COUNT: u32 = 0x0000ffff;
/// Byte address of `threshold_now`.
pub const THRESHOLD_NOW: u32 = 0x20;
/// threshold in use, scale pair 0 (read).
pub const THRESHOLD_NOW_FINE: u32 = 0x00007fff;
/// threshold in use, scale pair 1 (read).
pub const THRESHOLD_NOW_COARSE: u32 = 0x7fff0000;
/// Byte address of `frames`.
pub const FRAMES: u32 = 0x24;
/// frames finished since reset (read).
pub const FRAMES_COUNT: u32 = 0xffffffff;
/// Byte address of `features`.
pub const FEATURES: u32 = 0x28;
/// features of the last finished frame (read).
pub const FEATURES_COUNT: u32 = 0x000fffff;
/// Byte address of `dropped`.
pub const DROPPED: u32 = 0x2c;
/// features of the last finished frame that were dropped (read).
pub const DROPPED_COUNT: u32 = 0x000fffff;
/// Byte address of `commit`.
pub const COMMIT: u32 = 0x30;
/// write 1: the registers are a whole set for the next frame that begins; 1 until it has begun, or until one of them is written (write 1 to set).
pub const COMMIT_PENDING: u32 = 0x00000001;
/// Byte address of `narrow_g`.
pub const NARROW_G: u32 = 0x40;
/// `g` of the recursion, u0.16 (read, write).
pub const NARROW_G_CODE: u32 = 0x0000ffff;
/// Byte address of `narrow_g0`.
pub const NARROW_G0: u32 = 0x44;
/// `g_0` of the look-ahead, u0.16 (read, write).
pub const NARROW_G0_CODE: u32 = 0x0000ffff;
/// Byte address of `narrow_g1`.
pub const NARROW_G1: u32 = 0x48;
/// `g_1` of the look-ahead, u0.16 (read, write).
pub const NARROW_G1_CODE: u32 = 0x0000ffff;
/// Byte address of `narrow_g2`.
pub const NARROW_G2: u32 = 0x4c;
/// `g_2` of the look-ahead, u0.16 (read, write).
pub const NARROW_G2_CODE: u32 = 0x0000ffff;
/// Byte address of `narrow_g3`.
pub const NARROW_G3: u32 = 0x50;
/// `g_3` of the look-ahead, u0.16 (read, write).
pub const NARROW_G3_CODE: u32 = 0x0000ffff;
/// Byte address of `narrow_g4`.
pub const NARROW_G4: u32 = 0x54;
/// `g_4` of the look-ahead, u0.16 (read, write).
pub const NARROW_G4_CODE: u32 = 0x0000ffff;
/// Byte address of `middle_g`.
pub const MIDDLE_G: u32 = 0x58;
/// `g` of the recursion, u0.16 (read, write).
pub const MIDDLE_G_CODE: u32 = 0x0000ffff;
/// Byte address of `middle_g0`.
pub const MIDDLE_G0: u32 = 0x5c;
/// `g_0` of the look-ahead, u0.16 (read, write).
pub const MIDDLE_G0_CODE: u32 = 0x0000ffff;
/// Byte address of `middle_g1`.
pub const MIDDLE_G1: u32 = 0x60;
/// `g_1` of the look-ahead, u0.16 (read, write).
pub const MIDDLE_G1_CODE: u32 = 0x0000ffff;
/// Byte address of `middle_g2`.
pub const MIDDLE_G2: u32 = 0x64;
/// `g_2` of the look-ahead, u0.16 (read, write).
pub const MIDDLE_G2_CODE: u32 = 0x0000ffff;
/// Byte address of `middle_g3`.
pub const MIDDLE_G3: u32 = 0x68;
/// `g_3` of the look-ahead, u0.16 (read, write).
pub const MIDDLE_G3_CODE: u32 = 0x0000ffff;
/// Byte address of `middle_g4`.
pub const MIDDLE_G4: u32 = 0x6c;
/// `g_4` of the look-ahead, u0.16 (read, write).
pub const MIDDLE_G4_CODE: u32 = 0x0000ffff;
/// Byte address of `wide_g`.
pub const WIDE_G: u32 = 0x70;
/// `g` of the recursion, u0.16 (read, write).
pub const WIDE_G_CODE: u32 = 0x0000ffff;
/// Byte address of `wide_g0`.
pub const WIDE_G0: u32 = 0x74;
/// `g_0` of the look-ahead, u0.16 (read, write).
pub const WIDE_G0_CODE: u32 = 0x0000ffff;
/// Byte address of `wide_g1`.
pub const WIDE_G1: u32 = 0x78;
/// `g_1` of the look-ahead, u0.16 (read, write).
pub const WIDE_G1_CODE: u32 = 0x0000ffff;
/// Byte address of `wide_g2`.
pub const WIDE_G2: u32 = 0x7c;
/// `g_2` of the look-ahead, u0.16 (read, write).
pub const WIDE_G2_CODE: u32 = 0x0000ffff;
/// Byte address of `wide_g3`.
pub const WIDE_G3: u32 = 0x80;
/// `g_3` of the look-ahead, u0.16 (read, write).
pub const WIDE_G3_CODE: u32 = 0x0000ffff;
/// Byte address of `wide_g4`.
pub const WIDE_G4: u32 = 0x84;
/// `g_4` of the look-ahead, u0.16 (read, write).
pub const WIDE_G4_CODE: u32 = 0x0000ffff;
/// Byte address of `wide_g5`.
pub const WIDE_G5: u32 = 0x88;
/// `g_5` of the look-ahead, u0.16 (read, write).
pub const WIDE_G5_CODE: u32 = 0x0000ffff;
