//! Refinement in flight: the same hover with and without the pixels of its frames, over pictures that are moved
//! exactly.

mod support;

use hoverlock_arm::calibration::Calibration;
use hoverlock_arm::message::{self, Command, InertialSample, Telemetry};
use hoverlock_arm::navigator::Navigator;
use hoverlock_design::KT27;
use hoverlock_fixed_point::model::simd::SimdBitTrue;
use hoverlock_fixed_point::model::threshold::ThresholdController;
use hoverlock_reference::image::fourier::Spectrum;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::model::Pair;
use nalgebra::Vector2;
use support::{Source, fly};

/// Side of the pictures, px.
const SIDE: usize = 256;
/// Time between frames, us.
const FRAME_US: u64 = 66_667;
/// Movement of the ground between frames, px.
const STEP_PX: [f64; 2] = [0.31, -0.17];
/// Metres on the ground in a pixel.
const METRES_PER_PX: f64 = 0.1;

/// Returns the frames of a hover over the ground of a seed.
fn frames(side: usize, seed: u64, count: usize) -> Vec<Plane<u16>> {
    let spectrum = Spectrum::random(side, seed);
    (0..count).map(|frame| spectrum.picture(Vector2::from(STEP_PX) * frame as f64)).collect()
}

/// Creates the stream of the frames; those with an index in `with_pixels` bring their pixels. With a calibration the
/// stream has no samples of the IMU, and as many frames in four times the time.
fn stream(frames: &[Plane<u16>], with_pixels: impl Fn(usize) -> bool, without_imu: Option<&Calibration>) -> Source {
    let mut source = Source::default();
    let side = frames[0].width();
    source.send_registers(side, side).unwrap();
    if let Some(calibration) = without_imu {
        source.send(message::CALIBRATION, &calibration.encode()).unwrap();
    }
    source.send(message::COMMAND, &Command::Capture.encode()).unwrap();
    let mut model = SimdBitTrue::new(&KT27).unwrap();
    let mut controller = ThresholdController::new(&KT27);
    model.frame(&frames[0], controller.thresholds());
    controller.settle(model.maxima());
    let base = support::scene::telemetry(0);
    // As many metres as it takes.
    let field_of_view = 2.0 * (side as f64 * METRES_PER_PX / 2.0 / base.range).atan();
    let interval_us = if without_imu.is_some() { 4 * FRAME_US } else { FRAME_US };
    for (number, frame) in frames.iter().enumerate() {
        let time_us = interval_us * number as u64;
        let samples: Vec<InertialSample> = (0..14)
            .map(|i| time_us.saturating_sub(FRAME_US) + 5_000 * i)
            .filter(|at| *at <= time_us)
            .map(|time_us| InertialSample { time_us, rates: [0.0; 3], force: [0.0, 0.0, -9.80665] })
            .collect();
        if without_imu.is_none() {
            source.send(message::INERTIAL, &message::encode_inertial(&samples)).unwrap();
        }
        if with_pixels(number) {
            source.send_pixels(number as u32, frame).unwrap();
        }
        let telemetry = Telemetry { frame: number as u32, time_us, field_of_view, ..base };
        let features = model.frame(frame, controller.thresholds());
        source.send_frame(&telemetry, features, controller.thresholds()).unwrap();
    }
    source
}

/// Returns, for the frames from the tenth on, which all have an estimate, the errors of the inliers, px.
fn errors(source: &Source) -> Vec<Vec<f64>> {
    let (mut frame, mut errors) = (0, Vec::new());
    fly(&source.messages.concat(), Navigator::default(), |line, inliers| {
        if frame >= 10 {
            assert!(line.estimate.is_some(), "frame {frame}: {line:?}");
            let moved = Vector2::from(STEP_PX) * f64::from(frame);
            let miss = |pair: &Pair| (pair.current - pair.reference - moved).norm();
            errors.push(inliers.iter().map(miss).collect());
        }
        frame += 1;
    });
    errors
}

/// Returns the number of inliers within a thirtieth of a pixel in the frame that has fewest of them.
fn fewest_exact(source: &Source) -> usize {
    let exact = |errors: &Vec<f64>| errors.iter().filter(|error| **error < 1.0 / 30.0).count();
    errors(source).iter().map(exact).min().unwrap_or(0)
}

/// A picture of this size has 36 templates, of which those near the border are not cut. Some features of a picture
/// without noise are as exact; the templates come on top.
#[test]
fn with_pixels_patches_are_exact() {
    for seed in [1, 2, 3] {
        let frames = frames(SIDE, seed, 24);
        let [with, without] = [true, false].map(|pixels| fewest_exact(&stream(&frames, |_| pixels, None)));
        eprintln!("seed {seed}: {with} inliers within 1/30 px with pixels, {without} without");
        assert!(with >= 12 && with >= without + 10, "seed {seed}: {with} with pixels, {without} without");
    }
}

/// Pixels that come with some frames only, or with all but the reference, leave every frame its estimate.
#[test]
fn frames_without_pixels_are_tracked_by_features() {
    let frames = frames(SIDE, 4, 24);
    for which in [|frame: usize| frame == 0, |frame: usize| frame.is_multiple_of(2), |frame: usize| frame > 0] {
        let errors = errors(&stream(&frames, which, None));
        assert!(errors.len() == 14 && errors.iter().all(|errors| errors.len() >= 20), "{errors:?}");
    }
}

/// Without samples of the IMU each frame is searched, and what the search has found is refined if the camera is known.
#[test]
fn without_an_imu_the_patches_of_a_calibrated_camera_are_exact() {
    let frames = frames(2 * SIDE, 5, 16);
    let mut known = Calibration::default();
    (known.k1.sigma, known.readout_s.sigma, known.focal.sigma) = (1e-3, 1e-4, 1e-3);
    let [with, without] =
        [known, Calibration::default()].map(|calibration| errors(&stream(&frames, |_| true, Some(&calibration))));
    let largest = |errors: &[f64]| errors.iter().copied().fold(0.0, f64::max);
    assert!(with.iter().all(|errors| errors.len() >= 30 && largest(errors) < 0.1), "{with:?}");
    assert!(without.iter().all(|errors| largest(errors) > 0.1), "{without:?}");
}
