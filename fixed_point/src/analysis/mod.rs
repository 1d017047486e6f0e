//! Analysis of the model: model levels, errors between levels, ranges, bounds and resources.
//!
//! [`levels`] computes every model level on one picture. The other modules compare two levels or derive the
//! worst case of a comparison. [`acceptance`] checks the results against [`bounds`].

pub mod acceptance;
pub mod bounds;
pub mod displacement;
pub mod errors;
pub mod levels;
pub mod range;
pub mod resources;
pub mod worst_case;
