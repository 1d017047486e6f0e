//! A campaign of hovers: seeds x scenes x heights x views x gusts x designs.
//!
//! A point is one hover. The points are flown by the threads of this process, or by the workers of a Dask cluster.
//! Either way a point is the same hover with the same seed, so its numbers are equal to the last bit; they travel as
//! rows of CSV, whose numbers are read back exactly. A finished point is appended to a table at once, and the next run
//! with the same table does not fly it again.

mod cluster;
mod error;
mod local;
mod point;
pub mod random;
mod statistics;
mod table;

use std::collections::BTreeMap;
use std::path::Path;

use hoverlock_design::DesignPoint;
use hoverlock_edss::camera::FRAME_SIZE;
use hoverlock_reports::journal::Lock;
use hoverlock_reports::provenance::COMMIT;
use serde::Serialize;

pub use cluster::Cluster;
pub use error::CampaignError;
use local::LongStepsOnly;
pub use point::{FlownPoint, Point, fly_point, fly_row};
pub use statistics::DesignStatistics;

use crate::chain::FeatureSource;
use crate::hover::{CameraView, load_scene};
use crate::monitor::{BoxError, Monitor};

/// Name of the default design, which is part of every campaign.
pub const DEFAULT_DESIGN: &str = "kt27";

/// The inputs of a campaign.
#[derive(Debug, Clone, PartialEq)]
pub struct CampaignSettings {
    /// Names of scenes, or scene files.
    pub scenes: Vec<String>,
    /// Number of seeds; they begin at 1.
    pub seeds: u64,
    /// Rms of each horizontal component of the gusts, m/s.
    pub gusts_m_s: Vec<f64>,
    /// Heights over the mean ground, m.
    pub heights_m: Vec<f64>,
    /// Fields of view of the camera.
    pub views: Vec<CameraView>,
    /// Designs beside [`DEFAULT_DESIGN`] whose points must pass too: names or design files.
    pub designs: Vec<String>,
    /// Designs that are flown for comparison only: names, design files, or changes of the default like `dog_bits=12`.
    pub variants: Vec<String>,
    /// Duration of each hover, s.
    pub seconds: f64,
    /// The source of the features.
    pub features: FeatureSource,
}

/// Where the points of a campaign are flown.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// On all cores of this machine.
    Local,
    /// By the workers of a Dask cluster.
    Cluster(Cluster),
}

/// The progress of a campaign.
#[derive(Debug)]
pub enum CampaignProgress<'a> {
    /// The table was read.
    Started {
        /// Number of points that the table has.
        known: usize,
        /// Number of all points.
        points: usize,
    },
    /// A point was flown and appended to the table.
    Flown(&'a FlownPoint),
}

/// A function that receives the progress of a campaign. An error stops it.
pub type ReportProgress<'a> = &'a mut (dyn FnMut(CampaignProgress<'_>) -> Result<(), BoxError> + Send);

/// A campaign whose inputs have been checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Campaign {
    /// All points, scene by scene.
    pub points: Vec<Point>,
    /// Names of the designs whose points must pass.
    pub checked: Vec<String>,
}

/// The result of a campaign. Serialised, it is the JSON object of `hoverlock sweep`.
#[derive(Debug, Clone, Serialize)]
pub struct CampaignOutcome {
    /// Every point of the checked designs passes its checks.
    pub pass: bool,
    /// Names of the checked designs: the default, and those that were named as designs.
    pub checked: Vec<String>,
    /// All points in the order of [`Campaign::points`].
    pub points: Vec<FlownPoint>,
    /// Names of the designs on the Pareto front of error and memory.
    pub pareto: Vec<String>,
    /// Statistics of each design over its points.
    #[serde(skip)]
    pub designs: Vec<DesignStatistics>,
}

impl Campaign {
    /// Loads scenes and designs, and lists the points.
    ///
    /// # Errors
    /// A scene or a design cannot be loaded, a design is smaller than the camera's frames, or float features, which
    /// have no word lengths, are combined with several designs.
    pub fn new(settings: &CampaignSettings) -> Result<Self, CampaignError> {
        let default = [DEFAULT_DESIGN.to_owned()];
        let checked = distinct(default.iter().chain(&settings.designs));
        let names = distinct(checked.iter().chain(&settings.variants));
        if settings.features == FeatureSource::Float && names.len() > 1 {
            return Err(CampaignError::FloatHasNoWords);
        }
        let mut designs: Vec<(&String, DesignPoint)> = Vec::new();
        for name in &names {
            let design = DesignPoint::load_or_change(name)?;
            if (design.width as usize) < FRAME_SIZE.0 || (design.height as usize) < FRAME_SIZE.1 {
                let (width, height) = (design.width, design.height);
                return Err(CampaignError::SmallDesign { name: name.clone(), width, height });
            }
            designs.push((name, design));
        }
        let mut points = Vec::new();
        let (heights_m, views) = (distinct(&settings.heights_m), distinct(&settings.views));
        let gusts_m_s = distinct(&settings.gusts_m_s);
        for scene_name in distinct(&settings.scenes) {
            let scene = load_scene(&scene_name)?;
            for &height_m in &heights_m {
                for &view in &views {
                    for &gusts_m_s in &gusts_m_s {
                        for (name, design) in &designs {
                            let inputs = point::hash_of_inputs(&scene, design)?;
                            points.extend((1..=settings.seeds).map(|seed| Point {
                                scene: scene_name.clone(),
                                height_m,
                                view,
                                gusts_m_s,
                                seconds: settings.seconds,
                                features: settings.features,
                                design: (*name).clone(),
                                inputs: inputs.clone(),
                                seed,
                            }));
                        }
                    }
                }
            }
        }
        Ok(Self { points, checked })
    }

    /// Flies the points that the table does not have, and appends each to it. At the end the table is written in the
    /// order of the points, whoever flew them.
    ///
    /// # Errors
    /// The table cannot be read or written, another process is writing it, a point cannot be flown, or `progress` stops
    /// the campaign. The table keeps the points that were finished.
    pub fn run(
        &self,
        table: &Path,
        place: &Place,
        monitor: &dyn Monitor,
        progress: ReportProgress<'_>,
    ) -> Result<CampaignOutcome, CampaignError> {
        let lock = Lock::new(table)?;
        let mut known = table::read(table, |flown: &FlownPoint| flown.point().key())?;
        let left: Vec<Point> = self.points.iter().filter(|point| !known.contains_key(&point.key())).cloned().collect();
        if !left.is_empty() {
            lock.check_append()?;
        }
        let points = self.points.len();
        progress(CampaignProgress::Started { known: points - left.len(), points }).map_err(CampaignError::Stopped)?;
        let mut keep = |flown: FlownPoint| -> Result<(), CampaignError> {
            table::append(table, &flown)?;
            progress(CampaignProgress::Flown(&flown)).map_err(CampaignError::Stopped)?;
            known.insert(flown.point().key(), flown);
            Ok(())
        };
        match place {
            Place::Local => local::fly_all(&left, |point| fly_point(point, &LongStepsOnly(monitor)), &mut keep)?,
            Place::Cluster(cluster) => cluster.fly_all(&left, monitor, &mut keep)?,
        }
        let flown: Vec<FlownPoint> = self.points.iter().filter_map(|point| known.get(&point.key()).cloned()).collect();
        if flown.len() < points {
            return Err(CampaignError::MissingPoints { flown: flown.len(), points });
        }
        if !left.is_empty() {
            flown.iter().for_each(|flown| drop(known.remove(&flown.point().key())));
            // Points of other campaigns follow, in an order of their own.
            let others: BTreeMap<String, FlownPoint> = known.into_iter().collect();
            table::replace(table, flown.iter().chain(others.values()))?;
        }
        Ok(CampaignOutcome::new(self.checked.clone(), flown))
    }
}

impl CampaignOutcome {
    /// Judges the points of the checked designs, and compares all designs.
    fn new(checked: Vec<String>, points: Vec<FlownPoint>) -> Self {
        let designs = statistics::by_design(&points);
        Self {
            pass: points.iter().all(|point| !checked.contains(&point.design) || point.pass),
            checked,
            points,
            pareto: designs.iter().filter(|design| design.pareto).map(|design| design.name.clone()).collect(),
            designs,
        }
    }

    /// Returns the number of points that were flown by another commit than that of this program.
    pub fn of_other_commits(&self) -> usize {
        self.points.iter().filter(|point| point.commit != COMMIT).count()
    }

    /// Returns the points of the checked designs that fail.
    pub fn failures(&self) -> impl Iterator<Item = &FlownPoint> {
        self.points.iter().filter(|point| self.checked.contains(&point.design) && !point.pass)
    }
}

/// Returns the values in their order, each once.
fn distinct<'a, T: Clone + PartialEq + 'a>(values: impl IntoIterator<Item = &'a T>) -> Vec<T> {
    values.into_iter().fold(Vec::new(), |mut seen, value| {
        if !seen.contains(value) {
            seen.push(value.clone());
        }
        seen
    })
}

#[cfg(test)]
mod tests {
    use super::statistics::tests::flown;
    use super::*;

    #[test]
    fn a_point_that_is_named_twice_is_one_point() {
        let settings = |scenes: &[&str], heights_m: &[f64], designs: &[&str]| CampaignSettings {
            scenes: scenes.iter().map(|&name| name.to_owned()).collect(),
            seeds: 2,
            gusts_m_s: vec![3.0],
            heights_m: heights_m.to_vec(),
            views: vec![CameraView::Wide],
            designs: designs.iter().map(|&name| name.to_owned()).collect(),
            variants: Vec::new(),
            seconds: 10.0,
            features: FeatureSource::Fixed,
        };
        let once = Campaign::new(&settings(&["field", "town"], &[50.0, 100.0], &[])).unwrap();
        assert_eq!(once.points.len(), 8);
        let twice = settings(&["field", "town", "field"], &[50.0, 100.0, 50.0], &[DEFAULT_DESIGN]);
        assert_eq!(Campaign::new(&twice).unwrap(), once);
    }

    #[test]
    fn a_campaign_checks_the_designs_that_it_was_given() {
        let points = vec![flown(DEFAULT_DESIGN, 1, 291, 0.04, true), flown("own.toml", 1, 200, 0.4, false)];
        let judged = |checked: &[&str]| {
            CampaignOutcome::new(checked.iter().map(|name| (*name).to_owned()).collect(), points.clone())
        };
        let (both, default) = (judged(&[DEFAULT_DESIGN, "own.toml"]), judged(&[DEFAULT_DESIGN]));
        assert!(!both.pass && default.pass);
        assert_eq!((both.failures().count(), default.failures().count()), (1, 0));
        let page = both.page("hoverlock sweep --design own.toml").unwrap();
        assert!(page.contains("1 of 2 hovers of kt27, own.toml pass"), "{page}");
    }
}
