//! What is measured about the model: the model levels, errors between two of them, ranges, bounds and the resources they cost.
//!
//! [`levels`] computes every model level on one picture. The other modules compare two levels, or derive what a comparison can
//! show at worst. [`acceptance`] checks the results against [`bounds`].

pub mod acceptance;
pub mod bounds;
pub mod displacement;
pub mod errors;
pub mod levels;
pub mod range;
pub mod resources;
pub mod worst_case;
