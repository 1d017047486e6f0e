// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

#ifndef HOVERLOCK_REGISTERS_H
#define HOVERLOCK_REGISTERS_H

#define HOVERLOCK_IDENTIFICATION 0x00u
#define HOVERLOCK_IDENTIFICATION_LETTERS_SHIFT 0
#define HOVERLOCK_IDENTIFICATION_LETTERS_MASK 0xffffffffu // `HLCK`
#define HOVERLOCK_VERSION 0x04u
#define HOVERLOCK_VERSION_NUMBER_SHIFT 0
#define HOVERLOCK_VERSION_NUMBER_MASK 0xffffffffu // major above minor, 16 bits each
#define HOVERLOCK_EMISSION 0x08u
#define HOVERLOCK_EMISSION_HASH_SHIFT 0
#define HOVERLOCK_EMISSION_HASH_MASK 0xffffffffu // first 32 bits of the SHA-256 of the emitted Verilog
#define HOVERLOCK_CONTROL 0x0cu
#define HOVERLOCK_CONTROL_ENABLE_SHIFT 0
#define HOVERLOCK_CONTROL_ENABLE_MASK 0x00000001u // frames are taken; otherwise they are dropped whole
#define HOVERLOCK_CONTROL_AUTOMATIC_SHIFT 1
#define HOVERLOCK_CONTROL_AUTOMATIC_MASK 0x00000002u // thresholds follow the count of the frame before; part of the set
#define HOVERLOCK_CONTROL_INTERRUPT_FRAME_SHIFT 2
#define HOVERLOCK_CONTROL_INTERRUPT_FRAME_MASK 0x00000004u // interrupt at the end of a frame
#define HOVERLOCK_CONTROL_INTERRUPT_ERROR_SHIFT 3
#define HOVERLOCK_CONTROL_INTERRUPT_ERROR_MASK 0x00000008u // interrupt at an error
#define HOVERLOCK_CONTROL_RESET_SHIFT 31
#define HOVERLOCK_CONTROL_RESET_MASK 0x80000000u // clears the pipeline and the FIFO, not the registers
#define HOVERLOCK_STATUS 0x10u
#define HOVERLOCK_STATUS_FRAME_SHIFT 0
#define HOVERLOCK_STATUS_FRAME_MASK 0x00000001u // a frame was finished
#define HOVERLOCK_STATUS_SHORT_FRAME_SHIFT 1
#define HOVERLOCK_STATUS_SHORT_FRAME_MASK 0x00000002u // end of packet before the last pixel; the frame was padded
#define HOVERLOCK_STATUS_LONG_FRAME_SHIFT 2
#define HOVERLOCK_STATUS_LONG_FRAME_MASK 0x00000004u // no end of packet at the last pixel; what followed was dropped
#define HOVERLOCK_STATUS_INTERRUPTED_SHIFT 3
#define HOVERLOCK_STATUS_INTERRUPTED_MASK 0x00000008u // start of packet before the last pixel; the frame was padded
#define HOVERLOCK_STATUS_REFUSED_SHIFT 4
#define HOVERLOCK_STATUS_REFUSED_MASK 0x00000010u // a beat outside a frame, or a frame of an impossible size
#define HOVERLOCK_STATUS_DROPPED_SHIFT 5
#define HOVERLOCK_STATUS_DROPPED_MASK 0x00000020u // features were dropped
#define HOVERLOCK_STATUS_SATURATED_SHIFT 6
#define HOVERLOCK_STATUS_SATURATED_MASK 0x00000040u // a response was cut to the largest code
#define HOVERLOCK_STATUS_BEGUN_SHIFT 7
#define HOVERLOCK_STATUS_BEGUN_MASK 0x00000080u // a frame has begun, with the set if one was committed: the registers are free for the next
#define HOVERLOCK_STATUS_BUSY_SHIFT 31
#define HOVERLOCK_STATUS_BUSY_MASK 0x80000000u // frames are in the pipeline
#define HOVERLOCK_SIZE 0x14u
#define HOVERLOCK_SIZE_WIDTH_SHIFT 0
#define HOVERLOCK_SIZE_WIDTH_MASK 0x000007ffu // columns, 64 to 1024
#define HOVERLOCK_SIZE_HEIGHT_SHIFT 16
#define HOVERLOCK_SIZE_HEIGHT_MASK 0x0fff0000u // rows, 64 to 2048
#define HOVERLOCK_THRESHOLD 0x18u
#define HOVERLOCK_THRESHOLD_FINE_SHIFT 0
#define HOVERLOCK_THRESHOLD_FINE_MASK 0x00007fffu // least response of scale pair 0, half DN
#define HOVERLOCK_THRESHOLD_COARSE_SHIFT 16
#define HOVERLOCK_THRESHOLD_COARSE_MASK 0x7fff0000u // least response of scale pair 1
#define HOVERLOCK_TARGET 0x1cu
#define HOVERLOCK_TARGET_COUNT_SHIFT 0
#define HOVERLOCK_TARGET_COUNT_MASK 0x0000ffffu // features per scale pair
#define HOVERLOCK_THRESHOLD_NOW 0x20u
#define HOVERLOCK_THRESHOLD_NOW_FINE_SHIFT 0
#define HOVERLOCK_THRESHOLD_NOW_FINE_MASK 0x00007fffu // threshold in use, scale pair 0
#define HOVERLOCK_THRESHOLD_NOW_COARSE_SHIFT 16
#define HOVERLOCK_THRESHOLD_NOW_COARSE_MASK 0x7fff0000u // threshold in use, scale pair 1
#define HOVERLOCK_FRAMES 0x24u
#define HOVERLOCK_FRAMES_COUNT_SHIFT 0
#define HOVERLOCK_FRAMES_COUNT_MASK 0xffffffffu // frames finished since reset
#define HOVERLOCK_FEATURES 0x28u
#define HOVERLOCK_FEATURES_COUNT_SHIFT 0
#define HOVERLOCK_FEATURES_COUNT_MASK 0x000fffffu // features of the last finished frame
#define HOVERLOCK_DROPPED 0x2cu
#define HOVERLOCK_DROPPED_COUNT_SHIFT 0
#define HOVERLOCK_DROPPED_COUNT_MASK 0x000fffffu // features of the last finished frame that were dropped
#define HOVERLOCK_COMMIT 0x30u
#define HOVERLOCK_COMMIT_PENDING_SHIFT 0
#define HOVERLOCK_COMMIT_PENDING_MASK 0x00000001u // write 1: the registers are a whole set for the next frame that begins; 1 until it has begun, or until one of them is written
#define HOVERLOCK_NARROW_G 0x40u
#define HOVERLOCK_NARROW_G_CODE_SHIFT 0
#define HOVERLOCK_NARROW_G_CODE_MASK 0x0000ffffu // `g` of the recursion, u0.16
#define HOVERLOCK_NARROW_G0 0x44u
#define HOVERLOCK_NARROW_G0_CODE_SHIFT 0
#define HOVERLOCK_NARROW_G0_CODE_MASK 0x0000ffffu // `g_0` of the look-ahead, u0.16
#define HOVERLOCK_NARROW_G1 0x48u
#define HOVERLOCK_NARROW_G1_CODE_SHIFT 0
#define HOVERLOCK_NARROW_G1_CODE_MASK 0x0000ffffu // `g_1` of the look-ahead, u0.16
#define HOVERLOCK_NARROW_G2 0x4cu
#define HOVERLOCK_NARROW_G2_CODE_SHIFT 0
#define HOVERLOCK_NARROW_G2_CODE_MASK 0x0000ffffu // `g_2` of the look-ahead, u0.16
#define HOVERLOCK_NARROW_G3 0x50u
#define HOVERLOCK_NARROW_G3_CODE_SHIFT 0
#define HOVERLOCK_NARROW_G3_CODE_MASK 0x0000ffffu // `g_3` of the look-ahead, u0.16
#define HOVERLOCK_NARROW_G4 0x54u
#define HOVERLOCK_NARROW_G4_CODE_SHIFT 0
#define HOVERLOCK_NARROW_G4_CODE_MASK 0x0000ffffu // `g_4` of the look-ahead, u0.16
#define HOVERLOCK_MIDDLE_G 0x58u
#define HOVERLOCK_MIDDLE_G_CODE_SHIFT 0
#define HOVERLOCK_MIDDLE_G_CODE_MASK 0x0000ffffu // `g` of the recursion, u0.16
#define HOVERLOCK_MIDDLE_G0 0x5cu
#define HOVERLOCK_MIDDLE_G0_CODE_SHIFT 0
#define HOVERLOCK_MIDDLE_G0_CODE_MASK 0x0000ffffu // `g_0` of the look-ahead, u0.16
#define HOVERLOCK_MIDDLE_G1 0x60u
#define HOVERLOCK_MIDDLE_G1_CODE_SHIFT 0
#define HOVERLOCK_MIDDLE_G1_CODE_MASK 0x0000ffffu // `g_1` of the look-ahead, u0.16
#define HOVERLOCK_MIDDLE_G2 0x64u
#define HOVERLOCK_MIDDLE_G2_CODE_SHIFT 0
#define HOVERLOCK_MIDDLE_G2_CODE_MASK 0x0000ffffu // `g_2` of the look-ahead, u0.16
#define HOVERLOCK_MIDDLE_G3 0x68u
#define HOVERLOCK_MIDDLE_G3_CODE_SHIFT 0
#define HOVERLOCK_MIDDLE_G3_CODE_MASK 0x0000ffffu // `g_3` of the look-ahead, u0.16
#define HOVERLOCK_MIDDLE_G4 0x6cu
#define HOVERLOCK_MIDDLE_G4_CODE_SHIFT 0
#define HOVERLOCK_MIDDLE_G4_CODE_MASK 0x0000ffffu // `g_4` of the look-ahead, u0.16
#define HOVERLOCK_WIDE_G 0x70u
#define HOVERLOCK_WIDE_G_CODE_SHIFT 0
#define HOVERLOCK_WIDE_G_CODE_MASK 0x0000ffffu // `g` of the recursion, u0.16
#define HOVERLOCK_WIDE_G0 0x74u
#define HOVERLOCK_WIDE_G0_CODE_SHIFT 0
#define HOVERLOCK_WIDE_G0_CODE_MASK 0x0000ffffu // `g_0` of the look-ahead, u0.16
#define HOVERLOCK_WIDE_G1 0x78u
#define HOVERLOCK_WIDE_G1_CODE_SHIFT 0
#define HOVERLOCK_WIDE_G1_CODE_MASK 0x0000ffffu // `g_1` of the look-ahead, u0.16
#define HOVERLOCK_WIDE_G2 0x7cu
#define HOVERLOCK_WIDE_G2_CODE_SHIFT 0
#define HOVERLOCK_WIDE_G2_CODE_MASK 0x0000ffffu // `g_2` of the look-ahead, u0.16
#define HOVERLOCK_WIDE_G3 0x80u
#define HOVERLOCK_WIDE_G3_CODE_SHIFT 0
#define HOVERLOCK_WIDE_G3_CODE_MASK 0x0000ffffu // `g_3` of the look-ahead, u0.16
#define HOVERLOCK_WIDE_G4 0x84u
#define HOVERLOCK_WIDE_G4_CODE_SHIFT 0
#define HOVERLOCK_WIDE_G4_CODE_MASK 0x0000ffffu // `g_4` of the look-ahead, u0.16
#define HOVERLOCK_WIDE_G5 0x88u
#define HOVERLOCK_WIDE_G5_CODE_SHIFT 0
#define HOVERLOCK_WIDE_G5_CODE_MASK 0x0000ffffu // `g_5` of the look-ahead, u0.16

#endif
