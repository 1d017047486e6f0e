//! The loop: frame, features, estimate, and back to the helicopter.

use std::collections::VecDeque;
use std::time::Instant;

use anyhow::{Result, anyhow};
use hoverlock_arm::arinc429::{self, Control};
use hoverlock_arm::message::{Command, Telemetry};
use hoverlock_design::DesignPoint;
use hoverlock_edss::camera::{FIELD_OF_VIEW_RANGE_DEG, FRAME_RATE, Optics};
use hoverlock_edss::flight::{Fix, Flight, Hold, Moment, Setup};
use hoverlock_edss::render::Renderer;
use hoverlock_edss::scene::Scene;
use hoverlock_edss::world::{Exposure, World, frame_time};
use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reports::animation;
use hoverlock_reports::hover::Picture;
use hoverlock_reports::still::reduced;
use nalgebra::Matrix2;

use super::outcome::{Outcome, Row};
use super::save::Saved;
use super::{Course, View};
use crate::chain::{Chain, Line, Written};

/// From the exposure of a frame until the autopilot has its estimate, s: exposure and read-out a frame's time, then the
/// flight program.
const LATENCY: f64 = 0.1;

/// When the narrow view is asked for, s.
const ACQUIRED: f64 = 2.0;

/// Frames that are shown with their matches.
const STILLS: usize = 9;
/// Columns of one.
const STILL_COLUMNS: usize = 480;

/// Frames of the animation at most, and their columns.
const SCENES: usize = 60;
const SCENE_COLUMNS: usize = 342;

/// Standard error of a range that is not a reading, m.
const GUESSED: f64 = 10.0;

/// Frames of a hover.
pub fn frames(seconds: f64) -> usize {
    (seconds * FRAME_RATE).round() as usize + 1
}

/// Flies; `tell` gets a word about each frame.
pub fn fly(
    course: &Course,
    design: &DesignPoint,
    scene: &Scene,
    renderer: Renderer,
    mut saved: Option<Saved>,
    tell: &mut dyn FnMut(String),
) -> Result<Outcome> {
    let started = Instant::now();
    let setup =
        Setup { height: course.height, gust_rms: course.gusts, altitude: course.altitude.into(), ..Setup::default() };
    setup.check()?;
    let mut world = World::new(renderer, &setup, Optics::default(), FIELD_OF_VIEW_RANGE_DEG[1], course.seed);
    let mut blind = Flight::new(&Setup { mode: Hold::ImuOnly, ..setup }, course.seed);
    let mut flight_program: Option<Chain> = None;
    let mut due: VecDeque<(f64, Option<Fix>)> = VecDeque::new();
    let mut outcome = Outcome::new(course, scene, &setup, LATENCY);
    let frames = frames(course.seconds);
    let mut range = course.height;
    for number in 0..frames {
        let time = frame_time(number);
        while let Some((at, fix)) = due.front().copied().filter(|(at, _)| *at <= time) {
            due.pop_front();
            world.apply_fix(at, fix);
        }
        let exposure = world.expose(time)?;
        if number == 0 {
            world.engage();
            blind.engage();
        }
        let without = blind.advance(time);
        let telemetry = telemetry(number, &exposure, &setup, &mut range);
        let chain = match &mut flight_program {
            Some(chain) => chain,
            none => none.insert(Chain::start(course.features, design, course.estimator, &exposure.frame)?),
        };
        let commands = [
            (course.view == View::Narrow).then_some((ACQUIRED, Command::Narrow)),
            course.renew.map(|at| (at, Command::Renew)),
        ];
        for (at, command) in commands.into_iter().flatten() {
            if number == (at * FRAME_RATE).round() as usize
                && let Some(word) = chain.command(command)?
                && let (_, Control::Zoom(degrees)) = arinc429::decode(word)?
            {
                world.camera.zoom(degrees);
            }
        }
        let written = chain.frame(&telemetry, &exposure.frame)?;
        if let Some(saved) = &mut saved {
            saved.frame(number, &exposure.frame, &telemetry)?;
        }
        due.push_back((time + LATENCY, fix(&written.read, time)));
        let row = Row::new(&exposure, &telemetry, &written, without.camera.ground());
        tell(row.told(&outcome));
        outcome.rows.push(row);
        picture(&mut outcome, number, frames, &exposure, &written);
    }
    let chain = flight_program.ok_or_else(|| anyhow!("a hover without frames"))?;
    if let Some(saved) = saved {
        saved.keep()?;
    }
    outcome.finish(&chain, scene, started.elapsed().as_secs_f64());
    Ok(outcome)
}

/// What the sensors say of a frame. Where the laser has met nothing its last range goes on, known to little.
fn telemetry(number: usize, exposure: &Exposure, setup: &Setup, last: &mut f64) -> Telemetry {
    let error = if exposure.readings.range.is_some() { setup.laser_noise } else { GUESSED };
    *last = exposure.readings.range.unwrap_or(*last);
    Telemetry {
        frame: number as u32,
        time_us: (1e6 * exposure.readings.time).round() as u64,
        attitude: exposure.readings.attitude,
        range: last.max(0.1),
        field_of_view: exposure.field_of_view,
        sensors: SensorErrors { tilt: setup.tilt_noise, heading: setup.heading_noise, range: error },
    }
}

/// What the autopilot gets of a line.
fn fix(line: &Line, exposed: f64) -> Option<Fix> {
    let [xx, xy, yx, yy] = line.covariance_m2?;
    let covariance = Matrix2::new(xx, xy, yx, yy);
    Some(Fix { displacement: line.displacement()?, covariance, height: None, yaw: line.yaw_rad, exposed })
}

/// Keeps what page and animation show of a frame.
fn picture(outcome: &mut Outcome, number: usize, frames: usize, exposure: &Exposure, written: &Written) {
    let every = |count: usize| frames.div_ceil(count).max(1);
    if number.is_multiple_of(every(STILLS)) {
        let (step, small) = reduced(&exposure.frame, STILL_COLUMNS);
        outcome.stills.push(Picture { frame: number, small, step, inliers: written.inliers.clone() });
    }
    if number.is_multiple_of(every(SCENES)) {
        let (step, picture) = reduced(&exposure.frame, SCENE_COLUMNS);
        let estimate = written.read.displacement();
        let inliers = if estimate.is_some() { &written.inliers[..] } else { &[] };
        let Moment { time, camera, wind, .. } = exposure.moment;
        outcome.scenes.push(animation::Scene {
            picture,
            inliers: inliers.iter().map(|pair| pair.current / step as f64).collect(),
            time,
            place: camera.ground() - outcome.target(),
            estimate,
            wind: wind.xy(),
        });
    }
}
