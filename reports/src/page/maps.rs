//! Error maps and feature maps of each picture.

use serde::Serialize;

use crate::study::{PictureStudy, Study};

/// Error maps, feature map and feature counts of one picture.
#[derive(Debug, Serialize)]
pub(super) struct FigureView<'a> {
    name: &'a str,
    maps: Vec<(usize, bool, f64, f64, &'a str)>,
    condition: &'static str,
    features: &'a str,
    counts: &'a [[usize; 4]],
}

pub(super) fn views(study: &Study) -> Vec<FigureView<'_>> {
    study.pictures.iter().map(FigureView::of).collect()
}

impl<'a> FigureView<'a> {
    fn of(picture: &'a PictureStudy) -> Self {
        let figures = &picture.figures;
        Self {
            name: &picture.name,
            maps: figures
                .maps
                .iter()
                .map(|map| (map.scale, map.approximation, map.full, map.max, map.address.as_str()))
                .collect(),
            condition: figures.features.condition,
            features: &figures.features.svg,
            counts: &figures.features.counts,
        }
    }
}
