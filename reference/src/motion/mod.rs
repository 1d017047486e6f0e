//! From two lists of features to the motion between them: matching, RANSAC, and the displacement in metres.

pub mod estimate;
pub mod matching;
pub mod model;
pub mod orthophoto;
pub mod pose;
pub mod ransac;
pub mod refine;
pub mod refusal;
pub mod relief;
pub mod robust;
