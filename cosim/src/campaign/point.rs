//! One point of a campaign, before and after its hover.

use hoverlock_design::DesignPoint;
use hoverlock_edss::scene::Scene;
use hoverlock_fixed_point::analysis::resources::{Resources, resources};
use hoverlock_reports::provenance::{COMMIT, sha256};
use serde::{Deserialize, Serialize};

use super::{CampaignError, table};
use crate::chain::FeatureSource;
use crate::hover::{CameraView, HoverSettings, hover, load_scene, scene_identity};
use crate::monitor::Monitor;

/// A hover to be flown. The fields are the first columns of the table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Name or file of the scene.
    pub scene: String,
    /// Height over the mean ground, m.
    pub height_m: f64,
    /// The field of view of the camera.
    pub view: CameraView,
    /// Rms of each horizontal component of the gusts, m/s.
    pub gusts_m_s: f64,
    /// Duration of the hover, s.
    pub seconds: f64,
    /// The source of the features.
    pub features: FeatureSource,
    /// Name, file or changes of the design; see [`DesignPoint::load_or_change`].
    pub design: String,
    /// Hash of scene and design, hexadecimal. A file that was changed since gives another point.
    pub inputs: String,
    /// Seed of wind, sensors, camera and scene.
    pub seed: u64,
}

/// A hover that has been flown: a row of the table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FlownPoint {
    /// See [`Point::scene`].
    pub scene: String,
    /// See [`Point::height_m`].
    pub height_m: f64,
    /// See [`Point::view`].
    pub view: CameraView,
    /// See [`Point::gusts_m_s`].
    pub gusts_m_s: f64,
    /// See [`Point::seconds`].
    pub seconds: f64,
    /// See [`Point::features`].
    pub features: FeatureSource,
    /// See [`Point::design`].
    pub design: String,
    /// See [`Point::inputs`].
    pub inputs: String,
    /// See [`Point::seed`].
    pub seed: u64,
    /// Commit of the program that flew it.
    pub commit: String,
    /// M10K blocks of the design, by the memory model.
    pub m10k: u64,
    /// Multipliers 18 x 18 of the design, by the memory model.
    pub mul18: u64,
    /// Rms distance from the target, m.
    pub rms_m: f64,
    /// Largest distance from the target, m.
    pub max_m: f64,
    /// Rms distance of the helicopter with its IMU only, m.
    pub imu_only_rms_m: f64,
    /// Rms of estimate less truth, m; `None` without an estimate.
    pub error_rms_m: Option<f64>,
    /// Number of frames.
    pub frames: usize,
    /// Number of frames without an estimate after the first that has one.
    pub lost: usize,
    /// Every check passes.
    pub pass: bool,
    /// The checks that fail; empty if all pass.
    pub reason: String,
}

impl Point {
    /// Returns a text that is different for different points.
    pub fn key(&self) -> String {
        let Self { scene, height_m, view, gusts_m_s, seconds, features, design, inputs, seed } = self;
        format!("{scene}|{height_m}|{view}|{gusts_m_s}|{seconds}|{features}|{design}|{inputs}|{seed}")
    }
}

impl FlownPoint {
    /// Returns the point that was flown.
    pub fn point(&self) -> Point {
        Point {
            scene: self.scene.clone(),
            height_m: self.height_m,
            view: self.view,
            gusts_m_s: self.gusts_m_s,
            seconds: self.seconds,
            features: self.features,
            design: self.design.clone(),
            inputs: self.inputs.clone(),
            seed: self.seed,
        }
    }
}

/// Returns a hash of scene and design: see [`scene_identity`].
///
/// # Errors
/// A picture file cannot be read.
pub(super) fn hash_of_inputs(scene: &Scene, design: &DesignPoint) -> Result<String, CampaignError> {
    let mut digest = sha256(format!("{} {}", scene_identity(scene)?, design.to_toml()));
    digest.truncate(8);
    Ok(digest)
}

/// Flies a point. Equal points give equal results on every machine.
///
/// # Errors
/// Scene or design cannot be loaded or are not those of the campaign, the hover fails, or the monitor stops it.
pub fn fly_point(point: &Point, monitor: &dyn Monitor) -> Result<FlownPoint, CampaignError> {
    let design = DesignPoint::load_or_change(&point.design)?;
    if hash_of_inputs(&load_scene(&point.scene)?, &design)? != point.inputs {
        return Err(CampaignError::OtherInputs { scene: point.scene.clone(), design: point.design.clone() });
    }
    let Resources { m10k, mul18, .. } = resources(&design);
    let settings = HoverSettings {
        scene: point.scene.clone(),
        design,
        features: point.features,
        seconds: point.seconds,
        seed: point.seed,
        height_m: point.height_m,
        view: point.view,
        gusts_m_s: point.gusts_m_s,
        ..HoverSettings::default()
    };
    let summary = hover(&settings, monitor)?.summary;
    Ok(FlownPoint {
        scene: point.scene.clone(),
        height_m: point.height_m,
        view: point.view,
        gusts_m_s: point.gusts_m_s,
        seconds: point.seconds,
        features: point.features,
        design: point.design.clone(),
        inputs: point.inputs.clone(),
        seed: point.seed,
        commit: COMMIT.to_owned(),
        m10k,
        mul18,
        rms_m: summary.rms_m,
        max_m: summary.max_m,
        imu_only_rms_m: summary.imu_only_rms_m,
        error_rms_m: summary.error_rms_m,
        frames: summary.frames,
        lost: summary.lost,
        pass: summary.pass,
        reason: summary.reason.unwrap_or_default(),
    })
}

/// Flies the point of a row of CSV and returns the row of its result, both without a header. A worker of a cluster
/// calls it.
///
/// # Errors
/// The text is not a row, or those of [`fly_point`].
pub fn fly_row(row: &str, monitor: &dyn Monitor) -> Result<String, CampaignError> {
    Ok(table::to_row(&fly_point(&table::from_row(row)?, monitor)?)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_design::KT27;

    #[test]
    fn a_changed_scene_or_design_is_another_point() {
        let of = |scene: &str, change: &str| {
            let scene = Scene::parse(scene, ".".as_ref()).unwrap();
            hash_of_inputs(&scene, &KT27.with_override(change).unwrap()).unwrap()
        };
        let field = Scene::named("field").unwrap();
        let own = of(field, "dog_bits=15");
        assert!(own.len() == 8 && own == of(&format!("# a comment\n{field}"), "dog_bits=15"));
        assert_ne!(own, of(&field.replace("rms_m = 3.0", "rms_m = 3.1"), "dog_bits=15"));
        assert_ne!(own, of(field, "dog_bits=14"));
        // The inputs of the rows that have been flown.
        let parsed = Scene::parse(field, ".".as_ref()).unwrap();
        assert_eq!(scene_identity(&parsed).unwrap(), format!("{parsed:?}"));

        let of_picture = |sample: u8| {
            let folder = tempfile::tempdir().unwrap();
            let picture = folder.path().join("ground.pgm");
            std::fs::write(&picture, [b"P5\n2 1\n255\n\x00", &[sample][..]].concat()).unwrap();
            of(&format!("[ground.picture]\nfile = {picture:?}\ntexel_m = 0.1\n"), "dog_bits=15")
        };
        assert_ne!(of_picture(1), of_picture(2));
        // Another folder is not another scene.
        assert_eq!(of_picture(1), of_picture(1));
    }
}
