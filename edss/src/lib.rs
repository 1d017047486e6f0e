//! The simulator: ground, wind, camera, sensors and a helicopter, to test the estimator in a closed loop.
//!
//! | module | its one job |
//! |---|---|
//! | `aircraft` | flight dynamics of a helicopter about hover |
//! | `autopilot` | holds attitude, heading, height and position from sensors and vision |
//! | [`camera`] | converts radiance into a frame of 16-bit samples |
//! | [`flight`] | steps helicopter, wind, sensors and autopilot together |
//! | [`obstruction`] | what is between the scene and the sensor |
//! | [`pose`] | position and attitude of a camera |
//! | [`random`] | one seeded stream of random numbers for each purpose |
//! | [`render`] | renders a scene as seen by a camera |
//! | [`scene`] | reads and checks scene files |
//! | `sensors` | inertial sensor and laser rangefinder |
//! | [`strict`] | deserialisation in which nothing is ignored |
//! | [`toml_text`] | the place of an error in a TOML text |
//! | [`wind`] | gusts with Dryden's spectra |
//! | [`world`] | steps scene, flight and camera together, frame by frame |
//!
//! **World frame.** `X_e` and `Y_e` horizontal, `Z` down, metres, as in [`hoverlock_reference::motion::orthophoto`];
//! `Z = 0` is the mean ground, so that a camera 50 m up has `Z = -50`. All results are functions of the inputs and a
//! seed.

mod aircraft;
mod autopilot;
pub mod camera;
pub mod flight;
pub mod obstruction;
pub mod pose;
pub mod random;
pub mod render;
pub mod scene;
mod sensors;
pub mod strict;
pub mod toml_text;
pub mod wind;
pub mod world;
