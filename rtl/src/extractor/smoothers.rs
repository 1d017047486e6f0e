//! The smoothers, aligned, with one line memory for the column look-ahead of all.
//!
//! The column stages of all smoothers end in the same step. A smoother of less look-ahead than the longest begins with
//! older rows of the shared memory, and its output is delayed by the row stages that it does not have.
//!
//! The build script writes this module, because the look-ahead decides which rows and delays there are.

use hoverlock_design::pipeline::{CELL_STEPS, LERP_STEPS};
use rust_hdl::prelude::*;

use crate::{
    cells::{
        Address, Coefficient, Fields, Height, Pixel, PixelRows, STATE_BITS, State, Width,
        address::AddressCounter,
        bank::Bank,
        border::{CoefficientRegister, ColumnBorder, RepeatedRows},
        delay::{Cursor, Delay, FlagDelay, FrameDelay, PulseDelay},
        flag::Flag,
        join::PixelState,
        lerp::Lerp,
        line_delay::{ColumnMemory, LineDelay},
        tail::{HeldRow, TailCounter},
    },
    design::{PARITY, PIXEL_BITS, PIXEL_ROW_1_AT, PIXEL_ROW_2_AT, PIXEL_ROW_3_AT},
    smoother::{
        smoother,
        stages::{ColumnLookAhead, RowLookAhead, RowLookBack},
    },
};

include!(concat!(env!("OUT_DIR"), "/smoothers.rs"));
