//! Flights with a vision of known errors.

use hoverlock_edss::flight::{Fix, Flight, Moment, Setup};
use hoverlock_edss::pose::Pose;
use hoverlock_edss::random::{Purpose, normal, stream};
use nalgebra::{Matrix2, Vector2};
use std::collections::VecDeque;

const FRAME: f64 = 1.0 / 15.0;

fn level(pose: Pose) -> Option<f64> {
    Some(pose.height() / pose.attitude.rotation()[(2, 2)])
}

/// Moments at each frame of a flight with a vision of 2 cm white noise that comes two frames late; `sees` says whether
/// a frame has an estimate.
fn fly(setup: &Setup, seed: u64, seconds: f64, sees: impl Fn(f64) -> bool) -> Vec<Moment> {
    let mut flight = Flight::new(setup, seed);
    let mut random = stream(seed, Purpose::Camera);
    let mut late: VecDeque<Option<Fix>> = VecDeque::new();
    let frames = (seconds / FRAME) as usize;
    (0..frames)
        .map(|frame| {
            let time = frame as f64 * FRAME;
            let moment = flight.advance(time, &mut level);
            let noise = Vector2::new(normal(&mut random), normal(&mut random)) * 0.02;
            let fix = Fix {
                displacement: moment.camera.ground() + noise,
                covariance: Matrix2::identity() * 4e-4,
                height: None,
                yaw: None,
                exposed: time,
            };
            late.push_back(sees(time).then_some(fix));
            if late.len() > 1 {
                flight.advance(time + 0.1 - FRAME, &mut level);
                flight.take(late.pop_front().flatten());
            }
            moment
        })
        .collect()
}

fn rms(moments: &[Moment]) -> f64 {
    (moments.iter().map(|m| m.camera.ground().norm_squared()).sum::<f64>() / moments.len() as f64).sqrt()
}

/// Largest roll and pitch, degrees.
fn tilt(moments: &[Moment]) -> f64 {
    let largest = |m: &Moment| m.camera.attitude.roll.abs().max(m.camera.attitude.pitch.abs());
    moments.iter().map(largest).fold(0.0, f64::max).to_degrees()
}

#[test]
fn the_place_is_held_in_gusts() {
    for height in [50.0, 100.0] {
        for seed in 0..3 {
            let moments = fly(&Setup { height, ..Setup::default() }, seed, 60.0, |_| true);
            let told = format!("{height} m, seed {seed}: {:.4} m, {:.2} degrees", rms(&moments), tilt(&moments));
            eprintln!("{told}");
            assert!(rms(&moments) <= 0.08 && tilt(&moments) <= 5.0, "{told}");
        }
    }
}
