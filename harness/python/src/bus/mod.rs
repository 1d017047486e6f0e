//! Bus models of the engine: streams, masters and memories, and whole frames as numpy arrays.

mod common;
mod registers;
mod stream;
mod transfer;

pub use self::registers::{Access, Burst, RawChecker, RawMaster, RawMemory};
pub use self::stream::{RawListener, RawSource, Symbols};
pub use self::transfer::{Transfer, TransferOptions, Transferred};
