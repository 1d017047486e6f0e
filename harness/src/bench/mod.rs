//! The bench: time, clocks and tasks around a model of the engine, and the bus models that work in it.
//!
//! | module | content |
//! |---|---|
//! | [`sim`] | the scheduler, triggers, tasks, handles of signals |
//! | [`bus`] | drivers, monitors and checkers; transfers of whole arrays |
//! | [`error`], [`failure`], [`report`] | how a run ends: what both of them share |

pub mod bus;
pub mod error;
pub mod failure;
pub mod report;
pub mod sim;
