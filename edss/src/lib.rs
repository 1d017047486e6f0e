//! The simulator: ground, air, camera, sensors and a helicopter in wind, so that the loop can be closed on a desk.
//!
//! | module | its one reason |
//! |---|---|
//! | [`pose`] | where a camera is and how it is turned |
//! | [`random`] | one seeded stream of numbers for each purpose |
//! | [`scene`] | what is seen, read from a text file |
//! | [`render`] | what a camera sees of it |
//!
//! **World.** `X_e` and `Y_e` horizontal, `Z` down, metres, as in [`hoverlock_reference::motion::orthophoto`]; `Z = 0`
//! is the mean ground, so that a camera 50 m up has `Z = -50`. Everything is a function of its inputs and of a seed.

pub mod pose;
pub mod random;
pub mod render;
pub mod scene;
