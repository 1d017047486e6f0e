//! The motion between two lists of features: matching, RANSAC, and the displacement in metres.

pub mod budget;
pub mod estimate;
pub mod mark;
pub mod matching;
pub mod model;
pub mod orthophoto;
pub mod pose;
pub mod ransac;
pub mod refine;
pub mod refusal;
pub mod relief;
pub mod robust;
