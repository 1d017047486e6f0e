//! The loop: frame, features, estimate, and back to the helicopter.

use std::collections::VecDeque;
use std::time::Instant;

use hoverlock_arm::arinc429::{self, Control};
use hoverlock_arm::message::{Command, InertialSample, Telemetry};
use hoverlock_edss::camera::{FIELD_OF_VIEW_RANGE_DEG, FRAME_RATE};
use hoverlock_edss::flight::{Fix, Flight, Hold, Moment, Setup};
use hoverlock_edss::render::Renderer;
use hoverlock_edss::scene::Scene;
use hoverlock_edss::world::{Exposure, World, frame_time};
use hoverlock_reference::motion::observation::SensorErrors;
use nalgebra::{Matrix2, Vector2};

use super::outcome::HoverOutcome;
use super::summary::Row;
use super::{CameraView, HoverError, HoverSettings};
use crate::chain::{Chain, FlightLine, FrameOutput};
use crate::monitor::{FrameProgress, Monitor};
use crate::pages::animation;
use crate::pages::hover::Picture;
use crate::pages::still::reduced;
use crate::sequence::telemetry::{MAX_RANGE_M, MIN_RANGE_M};

/// Time from the exposure of a frame until the autopilot has its estimate, s: one frame for exposure and read-out, then
/// the flight program.
const ESTIMATE_LATENCY_S: f64 = 0.1;

/// Time at which the narrow view is commanded, s.
const NARROW_AFTER_S: f64 = 2.0;

/// Largest number of frames that the page shows with their matches.
const MAX_STILLS: usize = 9;

/// Largest number of columns of such a frame.
const STILL_COLUMNS: usize = 480;

/// Largest number of frames of the animation.
const MAX_ANIMATION_FRAMES: usize = 60;

/// Largest number of columns of the camera's picture in the animation.
const ANIMATION_COLUMNS: usize = 342;

/// Standard error of the range while the laser has no reading, m.
const HELD_RANGE_ERROR_M: f64 = 10.0;

/// Returns the number of frames of a hover.
fn frame_count(seconds: f64) -> usize {
    (seconds * FRAME_RATE).round() as usize + 1
}

/// Returns the helicopter and the air of a hover.
pub(super) fn setup(settings: &HoverSettings) -> Setup {
    Setup { height: settings.height_m, gust_rms: settings.gusts_m_s, altitude: settings.altitude, ..Setup::default() }
}

/// Flies a hover over a scene that was loaded.
pub(super) fn fly(
    settings: &HoverSettings,
    scene: &Scene,
    renderer: Renderer,
    monitor: &dyn Monitor,
) -> Result<HoverOutcome, HoverError> {
    let started = Instant::now();
    let setup = setup(settings);
    let mut world = World::new(renderer, &setup, settings.scenario.optics(), FIELD_OF_VIEW_RANGE_DEG[1], settings.seed);
    let mut blind = Flight::new(&Setup { mode: Hold::ImuOnly, ..setup }, settings.seed);
    let mut running: Option<Chain> = None;
    let mut due: VecDeque<(f64, Option<Fix>)> = VecDeque::new();
    let mut arrival = 0.0f64;
    let mut origin = Vector2::zeros();
    let mut outcome = HoverOutcome::new(settings, scene, &setup, ESTIMATE_LATENCY_S);
    let frames = frame_count(settings.seconds);
    let mut range = settings.height_m;
    // Samples of the IMU since the last frame that was not lost.
    let mut since_shown = Vec::new();
    for number in 0..frames {
        let time = frame_time(number);
        while let Some((at, fix)) = due.front().copied().filter(|(at, _)| *at <= time) {
            due.pop_front();
            world.apply_fix(at, fix);
        }
        world.obstruction = settings.scenario.obstruction(time);
        world.set_gust(settings.scenario.gust(time));
        for (rates, force) in settings.scenario.inertial_steps(number) {
            world.add_inertial_bias(&rates.into(), &force.into());
        }
        let exposure = world.expose(time)?;
        if number == 0 {
            blind.engage();
        }
        let without_vision = blind.advance(time);
        let telemetry = telemetry(settings, number, &exposure, &setup, &mut range);
        let chain = match &mut running {
            Some(chain) => chain,
            none => none.insert(Chain::start(
                settings.features,
                &settings.design,
                settings.flight_program,
                &exposure.frame,
                settings.scenario.calibration.as_ref(),
                monitor,
            )?),
        };
        command(settings, number, chain, &mut world)?;
        let samples = inertial(&exposure);
        chain.inertial(&samples)?;
        since_shown.extend(samples);
        if settings.scenario.is_dropped(time) {
            chain.lose(&exposure.frame)?;
            continue;
        }
        let output = chain.process(&telemetry, &exposure.frame, settings.scenario.delivery(time))?;
        if output.line.is_reference() {
            world.engage();
            origin = exposure.moment.camera.ground();
        }
        // A late estimate delays those behind it: they come through one link.
        arrival = arrival.max(time + ESTIMATE_LATENCY_S + settings.scenario.delay(time));
        due.push_back((arrival, fix(&output.line, time)));
        outcome.rows.push(Row {
            truth: exposure.moment.row(),
            origin,
            line: output.line.clone(),
            telemetry,
            blind: without_vision.camera.ground(),
            is_blind: scene.is_water() || settings.scenario.is_blind(time),
        });
        keep_pictures(&mut outcome, number, frames, &exposure, &output);
        let progress = FrameProgress {
            number,
            frames,
            picture: &exposure.frame,
            telemetry: &telemetry,
            inertial: &since_shown,
            quality: output.line.quality,
            distance_m: outcome.rows.last().map(|row| row.displacement().norm()),
            row: outcome.rows.last(),
        };
        monitor.frame(&progress).map_err(HoverError::Stopped)?;
        since_shown.clear();
    }
    let (cycles, first_difference) = running.map_or((None, None), |chain| (chain.cycles(), chain.first_difference()));
    outcome.finish(scene, frames, cycles, first_difference, started.elapsed().as_secs_f64());
    Ok(outcome)
}

/// Sends the commands that are due at a frame, and zooms the camera if the flight program asks for it.
fn command(settings: &HoverSettings, number: usize, chain: &mut Chain, world: &mut World) -> Result<(), HoverError> {
    let commands = [
        (settings.view == CameraView::Narrow).then_some((NARROW_AFTER_S, Command::Narrow)),
        settings.renew_after_s.map(|at| (at, Command::Renew)),
    ];
    let due = commands.into_iter().flatten().filter(|(at, _)| number == (at * FRAME_RATE).round() as usize);
    for command in due.map(|(_, command)| command).chain(settings.scenario.commands(number)) {
        if let Some(word) = chain.command(command)?
            && let (_, Control::Zoom(degrees)) = arinc429::decode(word)?
        {
            world.camera.zoom(degrees);
        }
    }
    Ok(())
}

/// Converts the samples of the inertial sensor to the form of the message stream. Those before time 0 are left out.
fn inertial(exposure: &Exposure) -> Vec<InertialSample> {
    let samples = exposure.inertial.iter().filter(|sample| sample.time >= 0.0);
    let converted = samples.map(|sample| InertialSample {
        time_us: (1e6 * sample.time).round() as u64,
        rates: sample.rates.into(),
        force: sample.force.into(),
    });
    converted.collect()
}

/// Returns the telemetry of a frame. While the laser has no reading, its last range is held with a large standard
/// error.
fn telemetry(
    settings: &HoverSettings,
    number: usize,
    exposure: &Exposure,
    setup: &Setup,
    last_range: &mut f64,
) -> Telemetry {
    let range = settings.scenario.range(exposure.readings.time, exposure.readings.range);
    let error = if range.is_some() { setup.laser_noise } else { HELD_RANGE_ERROR_M };
    *last_range = range.unwrap_or(*last_range);
    let half = (exposure.field_of_view / 2.0).tan() / (1.0 + settings.scenario.camera.focal);
    Telemetry {
        frame: number as u32,
        time_us: (1e6 * (exposure.readings.time + settings.scenario.camera.delay_s)).round() as u64,
        attitude: exposure.readings.attitude,
        range: last_range.clamp(MIN_RANGE_M, MAX_RANGE_M),
        field_of_view: 2.0 * half.atan(),
        sensors: SensorErrors { tilt: setup.tilt_noise, heading: setup.heading_noise, range: error },
    }
}

/// Converts a line to the fix that the autopilot receives.
fn fix(line: &FlightLine, exposed: f64) -> Option<Fix> {
    let [xx, xy, yx, yy] = line.covariance_m2?;
    let covariance = Matrix2::new(xx, xy, yx, yy);
    let (displacement, velocity) = (line.displacement()?, line.velocity());
    Some(Fix { displacement, covariance, velocity, height: None, yaw: line.yaw_rad, exposed })
}

/// Keeps the pictures of the frame of the last row that page and animation show.
fn keep_pictures(outcome: &mut HoverOutcome, number: usize, frames: usize, exposure: &Exposure, output: &FrameOutput) {
    let every = |count: usize| frames.div_ceil(count).max(1);
    // Frames that did not arrive have no row.
    let frame = outcome.rows.len() - 1;
    if number.is_multiple_of(every(MAX_STILLS)) {
        let (step, small) = reduced(&exposure.frame, STILL_COLUMNS);
        outcome.stills.push(Picture { frame, small, step, inliers: output.inliers.clone() });
    }
    if number.is_multiple_of(every(MAX_ANIMATION_FRAMES)) {
        let (step, picture) = reduced(&exposure.frame, ANIMATION_COLUMNS);
        let estimate = output.line.displacement();
        let inliers = if estimate.is_some() { &output.inliers[..] } else { &[] };
        let Moment { time, wind, .. } = exposure.moment;
        outcome.scenes.push(animation::Scene {
            picture,
            inliers: inliers.iter().map(|pair| pair.current / step as f64).collect(),
            time,
            place: outcome.rows[frame].displacement(),
            estimate,
            wind: wind.xy(),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hover::{Event, Scenario, hover};

    /// After a capture the animation counts from the new reference, as table and plots do.
    #[test]
    fn the_animation_counts_from_the_reference() {
        let scenario = Scenario { events: vec![Event::Capture { t: 1.0 }], ..Scenario::default() };
        let scene = "helipad-in-mist".into();
        let settings = HoverSettings { scene, seconds: 1.4, gusts_m_s: 5.0, scenario, ..HoverSettings::default() };
        let outcome = hover(&settings, &()).unwrap();
        let last = outcome.rows.last().unwrap();
        assert!((last.origin - outcome.rows[0].origin).norm() > 1e-3, "{last:?}: no new reference");
        let places = outcome.scenes.iter().map(|scene| scene.place);
        assert!(places.eq(outcome.rows.iter().map(Row::displacement)));
    }
}
