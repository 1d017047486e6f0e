//! One instance of a model: ports and public signals by name, evaluation, messages of the Verilog.
//!
//! A [`Model`] may move to another thread but not be shared between threads. Each has a Verilator context of its own,
//! so any number of instances of any number of models can exist at the same time.
//!
//! Values are unsigned integers of at most 64 bits; those of wider signals are lists of 32-bit words, lowest first.
//! Verilator has two states: there is no X and no Z. Registers without a reset start at 0, or at random with
//! [`Initial::Random`](crate::engine::build::Initial::Random).

mod files;
mod instance;
mod library;
mod message;
mod raw;
mod signal;
mod storage;
mod values;

pub use self::instance::{InstanceOptions, Model};
pub use self::library::Library;
pub use self::message::Message;
pub use self::raw::{RawSignal, Word};
pub use self::signal::{Direction, SignalId, SignalInfo};
pub use self::storage::Storage;
pub(crate) use self::storage::{has_words, load, load_array, load_words, store, store_words};
