//! The outcome of a hover: statistics, checks, the table and the page.

use std::time::Duration;

use hoverlock_edss::camera::FRAME_RATE;
use hoverlock_edss::flight::Setup;
use hoverlock_edss::scene::Scene;
use hoverlock_reports::page::PageError;
use hoverlock_reports::plot::PlotError;
use nalgebra::Vector2;
use serde::Serialize;

use super::checks::{self, FLAT_BOUND_M, RELIEF_BOUND_M};
use super::summary::{Row, Summary};
use super::{HoverSettings, table};
use crate::pages::animation::{self, apng};
use crate::pages::hover::{Frame, Hover, Picture, html};

/// The outcome of a hover. Serialised, it is its [`Summary`].
#[derive(Debug, Clone, Serialize)]
pub struct HoverOutcome {
    /// The statistics of the whole hover.
    #[serde(flatten)]
    pub summary: Summary,
    /// The checks in words.
    #[serde(skip)]
    pub checks: Vec<String>,
    /// The frames in order.
    #[serde(skip)]
    pub rows: Vec<Row>,
    #[serde(skip)]
    pub(super) stills: Vec<Picture>,
    #[serde(skip)]
    pub(super) scenes: Vec<animation::Scene>,
    /// The settings as the page shows them: name and value.
    #[serde(skip)]
    setup: Vec<(String, String)>,
}

impl HoverOutcome {
    /// Creates the outcome of a hover that begins. Each estimate is known `latency` seconds after its exposure.
    pub(super) fn new(settings: &HoverSettings, scene: &Scene, setup: &Setup, latency: f64) -> Self {
        let bound = if scene.is_flat() { FLAT_BOUND_M } else { RELIEF_BOUND_M };
        Self {
            rows: Vec::new(),
            stills: Vec::new(),
            scenes: Vec::new(),
            summary: Summary {
                pass: false,
                scene: settings.scene.clone(),
                features: settings.features,
                flight_program: settings.flight_program,
                seed: settings.seed,
                seconds: settings.seconds,
                height_m: settings.height_m,
                gusts_m_s: settings.gusts_m_s,
                rms_m: 0.0,
                max_m: 0.0,
                bound_m: (!scene.is_water()).then_some(bound),
                imu_only_rms_m: 0.0,
                imu_only_max_m: 0.0,
                error_rms_m: None,
                frames: 0,
                estimates: 0,
                available: None,
                misleading: 0,
                lost: 0,
                longest_loss_s: 0.0,
                references: 0,
                tilt_max_deg: 0.0,
                cycles: None,
                wall_s: 0.0,
                reason: None,
            },
            setup: described(settings, setup, latency),
            checks: Vec::new(),
        }
    }

    /// Returns the position of the helicopter without vision at the first frame, along `X_e` and `Y_e`, m.
    fn blind_target(&self) -> Vector2<f64> {
        self.rows.first().map_or(Vector2::zeros(), |row| row.blind)
    }

    /// Returns the number of frames with an estimate, and of all, among those that show the ground. They count from the
    /// first that has an estimate; from the reference on if none has.
    pub fn answered(&self) -> (usize, usize) {
        let first = self.rows.iter().position(|row| row.line.x_e_m.is_some()).unwrap_or(1);
        let in_view = || self.rows.iter().skip(first).filter(|row| !row.is_blind);
        (in_view().filter(|row| row.line.x_e_m.is_some()).count(), in_view().count())
    }

    /// Returns the mean normalised squared error (NEES), 2 if the covariance is true; `None` without an estimate.
    pub fn nees(&self) -> Option<f64> {
        let squares: Vec<f64> = self.rows.iter().filter_map(Row::normalised_squared_error).collect();
        (!squares.is_empty()).then(|| squares.iter().sum::<f64>() / squares.len() as f64)
    }

    /// Computes the statistics and the checks of the whole hover, which has had `frames` frames.
    pub(super) fn finish(
        &mut self,
        scene: &Scene,
        frames: usize,
        cycles: Option<u64>,
        first_difference: Option<usize>,
        wall_s: f64,
    ) {
        let (blind_target, (answered, in_view)) = (self.blind_target(), self.answered());
        let (summary, rows) = (&mut self.summary, &self.rows);
        (summary.rms_m, summary.max_m) = rms_and_max(rows.iter().map(|row| row.displacement().norm()));
        (summary.imu_only_rms_m, summary.imu_only_max_m) =
            rms_and_max(rows.iter().map(|row| (row.blind - blind_target).norm()));
        let errors: Vec<f64> = rows.iter().filter_map(|row| Some(row.error()?.norm())).collect();
        summary.estimates = errors.len();
        summary.error_rms_m = (!errors.is_empty()).then(|| rms_and_max(errors.into_iter()).0);
        summary.frames = rows.len();
        // Vision can only be lost after the first estimate.
        let first = rows.iter().position(|row| row.line.x_e_m.is_some()).unwrap_or(1);
        let lost = rows.iter().skip(first).filter(|row| row.line.x_e_m.is_none()).count();
        summary.lost = if summary.estimates > 0 { lost } else { 0 };
        summary.available = (summary.estimates > 0).then(|| answered as f64 / in_view.max(1) as f64);
        summary.misleading = rows.iter().filter(|row| row.is_misleading()).count();
        let estimated = rows.iter().filter(|row| row.line.x_e_m.is_some());
        let longest_loss = longest_loss(estimated.map(|row| row.telemetry.frame as usize), frames);
        summary.longest_loss_s = longest_loss as f64 / FRAME_RATE;
        let mut references: Vec<_> = rows.iter().filter_map(|row| row.line.reference).collect();
        references.dedup();
        summary.references = references.len();
        let tilt = rows.iter().flat_map(|row| [row.truth.roll, row.truth.pitch]).map(f64::abs).fold(0.0, f64::max);
        summary.tilt_max_deg = tilt.to_degrees();
        (summary.cycles, summary.wall_s) = (cycles, wall_s);

        let last_reason = rows.last().map_or(Some("no frame has arrived"), |row| row.line.reason.as_deref());
        let checks = checks::check(summary, scene.is_water(), first_difference, last_reason);
        let failed: Vec<&str> = checks.iter().filter(|check| !check.pass).map(|check| check.text.as_str()).collect();
        summary.pass = failed.is_empty();
        summary.reason = (!summary.pass).then(|| failed.join("; "));
        self.checks = checks.into_iter().map(|check| check.text).collect();
    }

    /// Returns the table of all frames as CSV: truth, estimate, sensors and wind, SI units and radians.
    ///
    /// # Errors
    /// A row cannot be written as CSV, which is a defect of this program.
    pub fn table(&self) -> Result<String, csv::Error> {
        table::table(&self.rows)
    }

    /// Renders the hover as one HTML page. `command` is shown as its origin.
    ///
    /// # Errors
    /// A plot, the animation or the template fails. Each is a defect of this program, not of the input.
    pub fn page(&self, command: &str) -> Result<String, PageError> {
        let (summary, blind_target) = (&self.summary, self.blind_target());
        let frame = |row: &Row| {
            let position = row.displacement();
            Frame {
                time: row.truth.time,
                truth: [position.x, position.y, -row.truth.z],
                status: row.line.status.clone(),
                reason: row.line.reason.clone(),
                estimate: row.line.estimate(),
                reference: row.line.reference,
                features: row.line.features,
                wind: [row.truth.wind_x, row.truth.wind_y, row.truth.wind_z],
                tilt: [row.truth.roll, row.truth.pitch].map(f64::to_degrees),
                field_of_view: row.telemetry.field_of_view.to_degrees(),
                blind: (row.blind - blind_target).norm(),
            }
        };
        let interval = self.scenes.get(1).map_or(0.1, |scene| scene.time - self.scenes[0].time);
        // Twice the true speed, but never so slow that a reader has to wait.
        let pause = Duration::from_secs_f64((interval / 2.0).clamp(0.05, 0.25));
        let reach = (1.2 * summary.max_m).clamp(0.25, 5.0);
        let animation = apng(&self.scenes, pause, reach).map_err(|error| PlotError::new("the animation", error))?;
        let hover = Hover {
            scene: summary.scene.clone(),
            setup: self.setup.clone(),
            features: summary.features.description(),
            estimator: summary.flight_program.description(),
            failure: summary.reason.clone(),
            checks: self.checks.clone(),
            hold: [summary.rms_m, summary.max_m],
            blind: [summary.imu_only_rms_m, summary.imu_only_max_m],
            error: summary.error_rms_m,
            bound: summary.bound_m,
            frames: self.rows.iter().map(frame).collect(),
            stills: self.stills.clone(),
            animation,
        };
        html(&hover, command)
    }
}

/// Returns the settings as the page shows them: name and value.
fn described(settings: &HoverSettings, setup: &Setup, latency: f64) -> Vec<(String, String)> {
    let degrees = |angle: f64| format!("{:.1} degrees rms", angle.to_degrees());
    let latency_ms = 1e3 * latency;
    let rows = [
        ("scene", settings.scene.clone()),
        ("height", format!("{} m over the mean ground", settings.height_m)),
        ("gusts", format!("{} m/s rms each horizontal component, Dryden's spectra", settings.gusts_m_s)),
        ("IMU", format!("{} of roll and pitch, {} of yaw", degrees(setup.tilt_noise), degrees(setup.heading_noise))),
        ("laser", format!("{} m rms", setup.laser_noise)),
        ("vision", format!("{FRAME_RATE} frames a second, each known {latency_ms:.0} ms after its exposure")),
        ("seed", settings.seed.to_string()),
    ];
    rows.map(|(name, value)| (name.to_owned(), value)).into()
}

/// Returns the largest number of successive frames without an estimate, after the first that has one or, if none has,
/// after frame 0. `estimated` are the numbers of the frames with an estimate, of `frames` in all; frames that did not
/// arrive count too.
fn longest_loss(mut estimated: impl Iterator<Item = usize>, frames: usize) -> usize {
    let first = estimated.next().unwrap_or(0);
    let steps = estimated.chain([frames]).scan(first, |before, number| {
        let lost = number - *before - 1;
        *before = number;
        Some(lost)
    });
    steps.max().unwrap_or(0)
}

/// Returns the root mean square and the largest of some values; 0 and 0 for none.
fn rms_and_max(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (mut squares, mut max, mut count) = (0.0, 0.0f64, 0usize);
    for value in values {
        squares += value * value;
        max = max.max(value);
        count += 1;
    }
    ((squares / count.max(1) as f64).sqrt(), max)
}

#[cfg(test)]
mod tests {
    use super::longest_loss;

    #[test]
    fn a_loss_is_from_one_estimate_to_the_next_or_to_the_end() {
        let longest = |estimated: &[usize]| longest_loss(estimated.iter().copied(), 10);
        assert_eq!([longest(&[3, 4, 5, 6, 7, 8, 9]), longest(&[0, 3, 8, 9])], [0, 4]);
        // The last frames, whether they arrived or not; all frames after the reference.
        assert_eq!([longest(&[2, 3]), longest(&[9]), longest(&[])], [6, 0, 9]);
    }
}
