//! The simulator: ground, air, camera, sensors and a helicopter in wind, so that the loop can be closed on a desk.
//!
//! | module | its one reason |
//! |---|---|
//! | [`aircraft`] | a helicopter about hover |
//! | [`autopilot`] | attitude, heading, height and place held by what the sensors and vision say |
//! | [`camera`] | radiance becomes a frame of 16-bit samples |
//! | [`flight`] | helicopter, wind, sensors and autopilot in one clock |
//! | [`pose`] | where a camera is and how it is turned |
//! | [`random`] | one seeded stream of numbers for each purpose |
//! | [`render`] | what a camera sees of it |
//! | [`scene`] | what is seen, read from a text file |
//! | [`sensors`] | inertial sensor and laser rangefinder |
//! | [`wind`] | gusts by Dryden's spectra |
//! | [`world`] | scene, helicopter and camera in one clock, frame by frame |
//!
//! **World.** `X_e` and `Y_e` horizontal, `Z` down, metres, as in [`hoverlock_reference::motion::orthophoto`]; `Z = 0`
//! is the mean ground, so that a camera 50 m up has `Z = -50`. Everything is a function of its inputs and of a seed.

pub mod aircraft;
pub mod autopilot;
pub mod camera;
pub mod flight;
pub mod pose;
pub mod random;
pub mod render;
pub mod scene;
pub mod sensors;
pub mod wind;
pub mod world;
