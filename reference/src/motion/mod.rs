//! The motion between two lists of features: matching, RANSAC, and the displacement in metres.
//!
//! | module | job |
//! |---|---|
//! | [`matching`] | pairs of similar features |
//! | [`model`] | shift, similarity, affine map and homography, fitted by least squares |
//! | [`ransac`], `robust` | the motion that most pairs agree on, and its last fit |
//! | [`estimator`], [`estimate`] | matching and search in rounds, and their result |
//! | [`refine`] | positions refined on the raw frames |
//! | `standard_error` | the standard error of a motion at a place of the picture |
//! | [`refusal`], `repeating_ground`, [`sensor_pattern`] | reasons to reject an estimate |
//! | [`orthophoto`], [`observation`] | camera, attitude and ground, and their standard errors |
//! | [`pose`], `relief` | displacement in metres, over plane ground and over hills |
//! | [`budget`], [`mark`] | counted work, and marks for the instruction counter |

pub mod budget;
pub mod estimate;
pub mod estimator;
pub mod mark;
pub mod matching;
pub mod model;
pub mod observation;
pub mod orthophoto;
pub mod pose;
pub mod ransac;
pub mod refine;
pub mod refusal;
pub mod relief;
mod repeating_ground;
mod robust;
pub mod sensor_pattern;
mod standard_error;
