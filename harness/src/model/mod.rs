//! One instance of a model: its ports and public signals by name, `eval`, and what the Verilog said.
//!
//! A [`Model`] may be sent to another thread but not shared between threads; each has a Verilator context of its own,
//! so any number of instances of any number of models live side by side.
//!
//! Values are unsigned words of at most 64 bits; wider signals are little-endian lists of 32-bit words. Verilator has
//! two states: there is no X and no Z. What is not reset starts as zero, or random with
//! [`Initial::Random`](crate::build::Initial::Random).

mod files;
mod instance;
mod library;
mod message;
mod raw;
mod signal;
mod storage;

pub use self::instance::{InstanceOptions, Model};
pub use self::library::Library;
pub use self::message::Message;
pub use self::raw::{RawSignal, Word};
pub use self::signal::{Direction, SignalId, SignalInfo};
pub use self::storage::Storage;
pub(crate) use self::storage::{has_words, load, load_words, store, store_words};
