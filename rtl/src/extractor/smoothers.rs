//! The three smoothers, aligned: a smoother of less look-ahead than the longest gets its pixels later.
//!
//! The build script writes this module, because the look-ahead decides which delays there are.

use rust_hdl::prelude::*;

use crate::{
    cells::{
        Address, Coefficient, Fields, Height, Pixel, STATE_BITS, State, Width,
        address::AddressCounter,
        bank::Bank,
        border::{CoefficientRegister, ColumnBorder},
        delay::{Cursor, Delay, FlagDelay, FrameDelay, PulseDelay},
        join::PixelState,
        lerp::Lerp,
        line_delay::LineDelay,
        tail::{HeldRow, TailCounter},
    },
    smoother::{
        CELL_STEPS, smoother,
        stages::{ColumnLookAhead, RowLookAhead, RowLookBack},
    },
};

include!(concat!(env!("OUT_DIR"), "/smoothers.rs"));
