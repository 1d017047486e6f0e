//! Whole streams through the navigator: results, memory, work, and the effect of damaged messages.

mod support;

use hoverlock_arm::calibration::Calibration;
use hoverlock_arm::framing::Decoder;
use hoverlock_arm::line::{Line, Reason, Status};
use hoverlock_arm::message::{self, Command, Telemetry};
use hoverlock_arm::navigator::{Navigator, WORK_UNITS};
use hoverlock_fixed_point::model::record::FeatureRecord;
use hoverlock_reference::motion::orthophoto::Attitude;
use proptest::prelude::*;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::OnceLock;
use support::adversarial::{self, Samples, Shape};
use support::scene::{self, FIELD_OF_VIEW, SIZE, displacement, records, seen, stream, telemetry};
use support::{Source, flown};

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

/// The system's allocator with a counter for each thread.
struct Counting;

// SAFETY: every call is passed on unchanged to the system's allocator; counting does not allocate.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // A thread that is ending has no counter any more.
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`, and the pointer came from the system.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        // SAFETY: the caller keeps the contract of `realloc`, and the pointer came from the system.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn lines(source: &Source) -> Vec<Line> {
    flown(&source.messages.concat(), Navigator::default())
}

/// Returns a stream whose next frame is captured.
fn capturing() -> Source {
    let mut source = Source::default();
    source.send_registers(SIZE.0, SIZE.1).unwrap();
    source.send(message::COMMAND, &Command::Capture.encode()).unwrap();
    source
}

/// Asserts that every frame after the first has an estimate within 5 cm of the truth.
fn assert_tracked(lines: &[Line]) {
    assert_eq!(lines[0].status, Status::Reference, "{:?}", lines[0]);
    for line in &lines[1..] {
        let estimate = line.estimate.unwrap_or_else(|| panic!("{line:?}"));
        let (x, y) = displacement(line.frame.unwrap());
        let miss = (estimate.x_e_m - x).hypot(estimate.y_e_m - y);
        assert!(miss < 0.05, "{miss} m: {line:?}");
    }
}

#[test]
fn a_flight_over_flat_ground_is_tracked_to_centimetres() {
    let lines = lines(&stream(600, 8));
    assert_eq!(lines.len(), 8);
    assert_tracked(&lines);
    assert!(lines[1..].iter().all(|line| line.status == Status::Estimate), "{lines:?}");
}

/// Returns for each frame of a stream how often memory was allocated until its line was written, and if that has an
/// estimate and a velocity.
fn written(source: &Source) -> Vec<(usize, [bool; 2])> {
    let mut navigator = Navigator::default();
    let mut text = Vec::with_capacity(4096);
    let mut frames = Vec::new();
    for message in &source.messages {
        let mut decoder = Decoder::default();
        let before = ALLOCATIONS.get();
        assert!(decoder.read(&mut &message[..]).unwrap());
        let raw = decoder.message().unwrap();
        navigator.take(&raw, &mut |line| line.write(&mut text)).unwrap();
        if raw.kind == message::FRAME {
            let allocated = ALLOCATIONS.get() - before;
            let has = |key: &str| text.windows(key.len()).any(|part| part == key.as_bytes());
            let is_line = text.starts_with(b"{\"frame\":");
            frames.push((allocated, [is_line && has("x_e_m"), is_line && has("velocity_covariance_m2_s2")]));
        }
    }
    frames
}

#[test]
fn after_the_first_frames_nothing_is_allocated() {
    let frames = written(&stream(1400, 8));
    assert_eq!(frames[0], (0, [false, false]), "the first frame is the reference");
    assert_eq!(frames[1..], [(0, [true, false]); 7]);
    let frames = written(&scene::steady(1400, 45));
    assert!(frames.iter().all(|(allocated, _)| *allocated == 0), "{frames:?}");
    assert_eq!(frames[44].1, [true, true]);
}

/// The same with the pixels of each frame and a keyframe from every second one.
#[test]
fn frames_with_pixels_allocate_nothing() {
    let frames = adversarial::repeated(Shape::Ground, Samples::Even, 14);
    let source = adversarial::stream(Shape::Ground, &frames, Some(&adversarial::texture()));
    let (mut navigator, mut estimates) = (Navigator::default(), 0);
    for message in &source.messages {
        let mut decoder = Decoder::default();
        assert!(decoder.read(&mut &message[..]).unwrap());
        let raw = decoder.message().unwrap();
        let before = ALLOCATIONS.get();
        navigator.take(&raw, &mut |line: &Line| estimates += usize::from(line.estimate.is_some())).unwrap();
        if [message::FRAME, message::PIXELS].contains(&raw.kind) {
            assert_eq!(ALLOCATIONS.get(), before, "message {} of kind {}", raw.sequence, raw.kind);
        }
    }
    assert!(estimates >= 10, "{estimates}");
}

#[test]
fn a_frame_that_would_run_late_says_so_and_gives_its_best() {
    let source = stream(600, 3);
    let work = |limit: u64| flown(&source.messages.concat(), Navigator::with_work(limit))[2].clone();
    let whole = work(u64::MAX);
    assert_eq!(whole.status, Status::Estimate);
    let none = work(1000);
    assert_eq!(none.status, Status::None);
    assert!(none.reason.as_ref().unwrap().to_string().contains("work allowed"), "{none:?}");
    // Every limit is respected. Between no estimate and the whole search there are limits that end the search early.
    let mut late = 0;
    for limit in (0..2 * WORK_UNITS).step_by(40_000) {
        let line = work(limit);
        assert!(line.work <= limit && (line.estimate.is_some() || line.reason.is_some()), "{line:?}");
        late += usize::from(line.status == Status::Late && line.estimate.is_some());
    }
    assert!(late > 0);
    assert_eq!(work(2 * WORK_UNITS).status, Status::Estimate);
}

#[test]
fn more_features_than_the_program_takes_are_counted_as_dropped() {
    let source = stream(1400, 2);
    let sent = records(1400, 1).len();
    let line = lines(&source)[1].clone();
    assert!(sent > 1024);
    assert_eq!((line.features, line.dropped), (1024, sent - 1024));
    assert!(line.estimate.is_some());
}

#[test]
fn telemetry_may_come_after_its_frame_or_be_lost() {
    let mut source = stream(300, 4);
    // Telemetry of frame 1 after its records; that of frame 2 lost.
    source.messages.swap(4, 5);
    source.messages.remove(6);
    let lines = lines(&source);
    assert_eq!(lines.iter().map(|line| line.frame).collect::<Vec<_>>(), [Some(0), Some(1), Some(2), Some(3)]);
    assert!(lines[1].estimate.is_some() && lines[3].estimate.is_some());
    assert_eq!(lines[2].reason, Some(Reason::Telemetry));
}

#[test]
fn a_restarted_source_keeps_the_reference() {
    let mut source = stream(300, 3);
    let mut again = Source::default();
    again.send_registers(SIZE.0, SIZE.1).unwrap();
    // The frame counter restarts; the ground has not moved.
    for frame in 0..2 {
        let telemetry = Telemetry { frame, ..telemetry(frame + 3) };
        again.send_frame(&telemetry, &records(300, frame + 3), &[2000, 2000]).unwrap();
    }
    source.messages.extend(again.messages);
    let lines = lines(&source);
    assert_eq!(lines.len(), 5);
    let (x, _) = displacement(4);
    assert!((lines[4].estimate.unwrap().x_e_m - x).abs() < 0.05);
    assert_eq!(lines[4].frame, Some(1));
}

#[test]
fn another_calibration_forgets_the_reference() {
    let mut source = stream(300, 2);
    let mut calibration = Calibration::default();
    let send = |source: &mut Source, calibration: &Calibration, frame| {
        source.send(message::CALIBRATION, &calibration.encode()).unwrap();
        source.send_frame(&telemetry(frame), &records(300, frame), &[2000, 2000]).unwrap();
    };
    // That of a camera that nobody has calibrated is the one before any came.
    send(&mut source, &calibration, 2);
    calibration.focal.value = 0.01;
    send(&mut source, &calibration, 3);
    let lines = lines(&source);
    assert!(lines[2].estimate.is_some(), "{:?}", lines[2]);
    assert_eq!(lines[3].reason, Some(Reason::Reference));
}

#[test]
fn a_clock_that_jumps_costs_no_frame() {
    let mut source = capturing();
    for (frame, time_us) in [0, 500_000, 5, u64::MAX, 133_334, 0].into_iter().enumerate() {
        let frame = frame as u32;
        source.send_frame(&Telemetry { time_us, ..telemetry(frame) }, &records(600, frame), &[2000, 2000]).unwrap();
    }
    assert_tracked(&lines(&source));
}

/// Without an IMU nothing says which of two ranges is right: the error of an estimate includes the displacement by
/// either. The third that contradicts the first corrects the height. A helicopter may have climbed or sunk by less
/// within a second, which the pictures then deny: those frames have no estimate.
#[test]
fn a_wrong_first_range_does_not_mislead() {
    for wrong in [1000.0, 200.0, 130.0, 50.0, 10.0] {
        let mut source = capturing();
        for frame in 0..20 {
            let range = if frame == 0 { wrong } else { 100.0 };
            let place = (0.5 * f64::from(frame), 0.0);
            let seen = seen(600, 1.0, place, FIELD_OF_VIEW, frame);
            source.send_frame(&Telemetry { range, ..telemetry(frame) }, &seen, &[2000; 2]).unwrap();
        }
        let lines = lines(&source);
        for line in &lines {
            let Some(estimate) = line.estimate else { continue };
            let miss = (estimate.x_e_m - 0.5 * f64::from(line.frame.unwrap())).hypot(estimate.y_e_m);
            assert!(miss < estimate.protection_level_m, "{wrong} m: off by {miss} m: {line:?}");
        }
        if wrong == 1000.0 {
            let last = lines[19].estimate.unwrap_or_else(|| panic!("{:?}", lines[19]));
            assert!((last.x_e_m - 9.5).hypot(last.y_e_m) < 0.05, "{last:?}");
        }
    }
}

/// A compass that is wrong by half a turn does not agree with pictures that have not turned.
#[test]
fn half_a_turn_of_the_heading_is_not_overlooked() {
    let mut source = capturing();
    for frame in 0..6 {
        let yaw = if frame == 4 { std::f64::consts::PI } else { 0.0 };
        let readings = Telemetry { attitude: Attitude { yaw, ..Attitude::default() }, ..telemetry(frame) };
        source.send_frame(&readings, &records(600, frame), &[2000; 2]).unwrap();
    }
    let lines = lines(&source);
    let level = |frame: usize| lines[frame].estimate.map_or(f64::INFINITY, |estimate| estimate.protection_level_m);
    assert!(level(3) < 1.0 && level(4) > 2.0 && level(5) < 1.0, "{lines:?}");
}

/// The laser points at the crown of a tree below the reference, which looks like steep ground, and then at the ground
/// beside it: the scale is wrong by an eighth at first, and the protection level says so.
#[test]
fn a_tree_below_the_reference_does_not_mislead() {
    const ON_THE_TREE: u32 = 60;
    let mut source = capturing();
    let place = |frame: u32| (2.0 * (0.3 * f64::from(frame)).sin(), 2.0 * (0.2 * f64::from(frame)).sin());
    for frame in 0..ON_THE_TREE + 40 {
        let (x, y) = place(frame);
        let on_the_tree = frame < ON_THE_TREE;
        let range = if on_the_tree { 88.0 + 0.6 * x - 0.5 * y } else { 100.0 };
        let time_us = 500_000 + u64::from(frame) * 66_667;
        source
            .send_frame(
                &Telemetry { range, time_us, ..telemetry(frame) },
                &seen(600, 1.0, place(frame), FIELD_OF_VIEW, frame),
                &[2000; 2],
            )
            .unwrap();
    }
    let lines = lines(&source);
    for line in &lines[9..] {
        let estimate = line.estimate.unwrap_or_else(|| panic!("{line:?}"));
        let (x, y) = place(line.frame.unwrap());
        let miss = (estimate.x_e_m - x).hypot(estimate.y_e_m - y);
        assert!(miss < 0.35 && miss < estimate.protection_level_m, "{miss} m: {line:?}");
    }
}

/// A roof of 24 m in a corner of the frame, and ground in its left half only: without an IMU the roof tilts what the
/// filter takes for the ground, and the protection level says so.
#[test]
fn a_roof_does_not_mislead() {
    let place = |frame: u32| (0.3 * (0.4 * f64::from(frame)).sin(), -0.2 * (0.3 * f64::from(frame)).sin());
    let mut source = capturing();
    for frame in 0..46 {
        source
            .send_frame(&telemetry(frame), &scene::seen_beside_a_roof(1000, place(frame), frame), &[2000; 2])
            .unwrap();
    }
    for line in &lines(&source)[1..] {
        let estimate = line.estimate.unwrap_or_else(|| panic!("{line:?}"));
        let (x, y) = place(line.frame.unwrap());
        let miss = (estimate.x_e_m - x).hypot(estimate.y_e_m - y);
        assert!(miss < 0.2 && miss < estimate.protection_level_m, "{miss} m: {line:?}");
    }
}

/// A hover of 10 s with samples of the IMU over a road on which cars have two thirds of the features, and ground that
/// comes and goes: about 20 landmarks a frame are at their place, which confirms the reference after 2 s.
#[test]
fn a_road_full_of_cars_keeps_its_estimate() {
    let mut source = capturing();
    for frame in 0..159 {
        let time_us = 66_667 * u64::from(frame);
        source.send(message::INERTIAL, &message::encode_inertial(&scene::samples(time_us))).unwrap();
        let records = scene::seen_on_a_road(1400, time_us as f64 / 1e6, frame);
        source.send_frame(&Telemetry { time_us, ..telemetry(frame) }, &records, &[2000; 2]).unwrap();
    }
    let lines = lines(&source);
    let mut answered = 0;
    for estimate in lines[31..].iter().filter_map(|line| line.estimate) {
        let miss = estimate.x_e_m.hypot(estimate.y_e_m);
        assert!(miss < 0.2 && miss < estimate.protection_level_m, "{miss} m: {estimate:?}");
        answered += 1;
    }
    let reasons = || lines[31..].iter().filter_map(|line| line.reason.as_ref());
    assert!(answered >= 125, "{answered} of 128: {:?}", reasons().collect::<Vec<_>>());
}

/// No reading has the velocity: the filter finds it in the pictures.
#[test]
fn the_velocity_is_that_of_the_flight() {
    let lines = lines(&scene::steady(600, 45));
    let last = lines[44].estimate.unwrap_or_else(|| panic!("{:?}", lines[44]));
    let velocity = last.velocity.unwrap_or_else(|| panic!("{last:?}"));
    let [x, y, z] = velocity.velocity_m_s;
    let [xx, .., zz] = velocity.velocity_covariance_m2_s2;
    let error = (x - scene::STEADY_M_S.0).hypot(y - scene::STEADY_M_S.1).hypot(z);
    assert!(error < 0.02 && error < 4.0 * (2.0 * xx + zz).sqrt(), "{error} m/s: {velocity:?}");
    let free = stream(600, 3);
    assert_eq!(flown(&free.messages.concat(), Navigator::default())[2].estimate.unwrap().velocity, None);
}

/// Returns the lines of a hover whose camera zooms by 2 % a frame from frame 40 on, up to that of `until`; `otherwise`
/// returns the records of frames from `from` on up to that, and the ground is in view for 3 s more.
fn blind_in_zoom([from, until]: [u32; 2], otherwise: impl Fn(u32, f64) -> Vec<FeatureRecord>) -> Vec<Line> {
    let mut source = capturing();
    for frame in 0..until + 45 {
        let time_us = 66_667 * u64::from(frame);
        let field_of_view = FIELD_OF_VIEW * 0.98f64.powi(frame.min(until).saturating_sub(40) as i32);
        source.send(message::INERTIAL, &message::encode_inertial(&scene::samples(time_us))).unwrap();
        let records = match (from..until).contains(&frame) {
            true => otherwise(frame, field_of_view),
            false => scene::seen(600, 1.0, (0.0, 0.0), field_of_view, frame),
        };
        source.send_frame(&Telemetry { time_us, field_of_view, ..telemetry(frame) }, &records, &[2000; 2]).unwrap();
    }
    let lines = lines(&source);
    let first = &lines[35..from as usize];
    assert!(first.iter().all(|line| line.estimate.is_some()), "{first:?}");
    lines
}

/// Asserts that all lines have an estimate that errs by less than `limit` (m) and its protection level.
fn assert_near_origin(lines: &[Line], limit: f64) {
    for line in lines {
        let estimate = line.estimate.unwrap_or_else(|| panic!("{line:?}"));
        let miss = estimate.x_e_m.hypot(estimate.y_e_m);
        assert!(miss < limit && miss < estimate.protection_level_m, "{miss} m: {line:?}");
    }
}

/// A blind camera shows noise that looks like features. Such a frame becomes a keyframe, as the others have another
/// scale, and the ground is found again all the same.
#[test]
fn noise_in_a_zoom_does_not_end_a_flight() {
    for until in [53, 65, 80] {
        let lines = blind_in_zoom([50, until], |frame, _| scene::seen_over_waves(600, 0.0, frame));
        let blind = &lines[50..until as usize];
        assert!(blind.iter().all(|line| line.estimate.is_none()), "{blind:?}");
        assert_near_origin(&lines[until as usize + 2..], 0.2);
    }
}

/// Ground that was in view before is found again after a bad frame, although its keyframe is new: the error of the
/// estimate does not grow by what the IMU did not know meanwhile.
#[test]
fn a_bad_frame_does_not_replace_a_new_keyframe() {
    let lines = blind_in_zoom([50, 51], |frame, _| scene::seen_over_waves(600, 0.0, frame));
    let keyframes = |lines: &[Line]| lines.iter().filter_map(|line| line.reference).collect::<Vec<_>>();
    let before = keyframes(&lines[45..50]);
    assert!(before.iter().all(|keyframe| (40..50).contains(keyframe) || *keyframe == 0), "{before:?}");
    let after = keyframes(&lines[51..52]);
    assert!(after.iter().all(|keyframe| before.contains(keyframe)), "{before:?}, then {after:?}");
    assert_near_origin(&lines[51..], 0.02);
}

/// Clouds that drift below the helicopter for 2 s: slow ones pass as ground, and the protection level knows.
#[test]
fn clouds_in_a_zoom_do_not_mislead() {
    for speed in [0.1, 0.2, 0.5, 1.0, 2.0] {
        let lines = blind_in_zoom([50, 80], |frame, field_of_view| {
            let moved = speed * f64::from(frame - 50) / 15.0;
            scene::seen(601, 1.0, (moved, 0.0), field_of_view, frame)
        });
        for line in &lines {
            let Some(estimate) = line.estimate else { continue };
            let miss = estimate.x_e_m.hypot(estimate.y_e_m);
            assert!(miss < estimate.protection_level_m, "{speed} m/s, {miss} m: {line:?}");
        }
        assert_near_origin(&lines[95..], 0.5);
    }
}

/// Without samples of the IMU in one frame the velocity is any, and it is not published until they have been complete
/// for half a second.
#[test]
fn a_gap_of_the_imu_hides_the_velocity() {
    let mut source = capturing();
    for frame in 0..60u32 {
        let time_us = 66_667 * u64::from(frame);
        if frame != 40 {
            source.send(message::INERTIAL, &message::encode_inertial(&scene::samples(time_us))).unwrap();
        }
        let records = scene::seen(600, 1.0, (0.0, 0.0), FIELD_OF_VIEW, frame);
        source.send_frame(&Telemetry { time_us, ..telemetry(frame) }, &records, &[2000; 2]).unwrap();
    }
    let lines = lines(&source);
    let has_velocity = |line: &Line| line.estimate.is_some_and(|estimate| estimate.velocity.is_some());
    assert!(lines[35..40].iter().all(has_velocity), "{:?}", &lines[35..40]);
    assert!(!lines[40..48].iter().any(has_velocity), "{:?}", &lines[40..48]);
    assert!(lines[48..].iter().all(has_velocity), "{:?}", &lines[48..]);
}

/// A flight over three footprints and back: keyframes are added and the origin stays. The errors of keyframes add up,
/// until the first is found again.
#[test]
fn the_reference_is_renewed_without_a_jump() {
    let place = |frame: u32| {
        let t = f64::from(if frame <= 60 { frame } else { 120 - frame });
        (4.0 * t, -t)
    };
    let mut source = capturing();
    for frame in 0..120 {
        let records = scene::seen(4000, 4.0, place(frame), scene::FIELD_OF_VIEW, frame);
        source.send_frame(&telemetry(frame), &records, &[2000, 2000]).unwrap();
    }
    let lines = lines(&source);
    let mut references = Vec::new();
    for line in &lines[1..] {
        let estimate = line.estimate.unwrap_or_else(|| panic!("{line:?}"));
        let (x, y) = place(line.frame.unwrap());
        let miss = (estimate.x_e_m - x).hypot(estimate.y_e_m - y);
        let [xx, .., yy] = estimate.covariance_m2;
        assert!(miss < 0.2 && miss < 5.0 * (xx + yy).sqrt(), "{miss} m: {line:?}");
        references.extend(line.reference);
    }
    references.dedup();
    assert!(references.len() > 6 && references.len() < 24, "{references:?}");
    let variance = |line: &Line| line.estimate.unwrap().covariance_m2[0];
    assert!(variance(&lines[119]) < variance(&lines[60]), "the first keyframe is found again");
}

/// Renewal on command keeps the origin; the command to capture sets a new one.
#[test]
fn a_reference_renewed_on_command_keeps_the_origin() {
    let mut source = stream(600, 5);
    source.send(message::COMMAND, &Command::Renew.encode()).unwrap();
    for frame in 5..8 {
        source.send_frame(&telemetry(frame), &records(600, frame), &[2000, 2000]).unwrap();
    }
    source.send(message::COMMAND, &Command::Capture.encode()).unwrap();
    for frame in 8..10 {
        source.send_frame(&telemetry(frame), &records(600, frame), &[2000, 2000]).unwrap();
    }
    let lines = lines(&source);
    assert_tracked(&lines[..8]);
    let references: Vec<_> = lines.iter().map(|line| line.reference).collect();
    let expected = [None, Some(0), Some(0), Some(0), Some(0), Some(0), Some(5), Some(5), None, Some(8)];
    assert_eq!(references, expected);
    assert_eq!(lines[8].status, Status::Reference);
    let (step, _) = displacement(1);
    assert!((lines[9].estimate.unwrap().x_e_m - step).abs() < 0.05);
}

/// A zoom from the wide view to half of it, by 2 % a frame: features are not invariant to scale, so references are
/// renewed.
#[test]
fn the_estimate_continues_through_a_zoom() {
    let mut source = capturing();
    for frame in 0..35 {
        let field_of_view = scene::FIELD_OF_VIEW * 0.98f64.powi(frame as i32);
        let place = (0.02 * f64::from(frame), 0.0);
        let records = scene::seen(3000, 1.0, place, field_of_view, frame);
        source.send_frame(&Telemetry { field_of_view, ..telemetry(frame) }, &records, &[2000, 2000]).unwrap();
    }
    for line in &lines(&source)[1..] {
        let estimate = line.estimate.unwrap_or_else(|| panic!("{line:?}"));
        let miss = (estimate.x_e_m - 0.02 * f64::from(line.frame.unwrap())).hypot(estimate.y_e_m);
        assert!(miss < 0.05, "{miss} m: {line:?}");
    }
}

/// Waves look like ground until they have moved on, so there is no estimate before most of the reference was found for
/// half a second after its capture.
#[test]
fn a_reference_is_confirmed_before_it_is_used() {
    let lines = hovered(12, |frame| records(600, frame));
    assert!(lines[1..8].iter().all(|line| line.reason == Some(Reason::Unconfirmed)), "{:?}", lines[1]);
    assert!(lines[8..].iter().all(|line| line.estimate.is_some()));
}

/// Waves may not confirm a reference because the clock was set back after its capture, or the source has restarted.
#[test]
fn the_wait_for_a_confirmation_begins_anew_with_another_clock() {
    for registers in [false, true] {
        let mut source = capturing();
        source.send_frame(&Telemetry { time_us: 9_000_000, ..telemetry(0) }, &records(600, 0), &[2000; 2]).unwrap();
        if registers {
            source.send_registers(SIZE.0, SIZE.1).unwrap();
        }
        let begin = if registers { 20_000_000 } else { 1_000_000 };
        for frame in 1..12 {
            let telemetry = Telemetry { time_us: begin + 66_667 * u64::from(frame), ..telemetry(frame) };
            source.send_frame(&telemetry, &records(600, frame), &[2000; 2]).unwrap();
        }
        let lines = lines(&source);
        assert!(lines[1..9].iter().all(|line| line.reason == Some(Reason::Unconfirmed)), "{registers}: {lines:?}");
        assert!(lines[9..].iter().all(|line| line.estimate.is_some()), "{registers}: {lines:?}");
    }
}

/// Returns the lines of `frames` frames, a 15th of a second apart, after a capture.
fn hovered(frames: u32, seen: impl Fn(u32) -> Vec<FeatureRecord>) -> Vec<Line> {
    let mut source = capturing();
    for frame in 0..frames {
        let telemetry = Telemetry { time_us: 66_667 * u64::from(frame), ..telemetry(frame) };
        source.send_frame(&telemetry, &seen(frame), &[2000, 2000]).unwrap();
    }
    lines(&source)
}

/// Over waves a few landmarks keep their form for a second.
#[test]
fn a_small_share_of_the_reference_confirms_it_after_two_seconds() {
    let lines = hovered(45, |frame| scene::seen_over_waves(800, 0.1, frame));
    let confirmed = lines.iter().position(|line| line.estimate.is_some());
    assert_eq!(confirmed, Some(30), "{:?}", lines[29]);
}

#[test]
fn a_reference_that_is_seldom_found_is_not_confirmed() {
    let seen = |frame: u32| if frame.is_multiple_of(4) { records(600, 0) } else { records(601, 0) };
    let lines = hovered(45, seen);
    assert!(lines.iter().skip(1).any(|line| line.reason == Some(Reason::Unconfirmed)));
    assert!(lines.iter().all(|line| line.estimate.is_none()), "{lines:?}");
}

#[test]
fn every_frame_without_an_estimate_has_its_reason() {
    let reasons = |source: &Source| -> Vec<Option<Reason>> { lines(source).into_iter().map(|l| l.reason).collect() };
    let mut source = Source::default();
    source.send_frame(&telemetry(0), &records(300, 0), &[2000, 2000]).unwrap();
    assert_eq!(reasons(&source), [Some(Reason::Registers)]);
    source.send_registers(SIZE.0, SIZE.1).unwrap();
    source.send_frame(&telemetry(1), &records(300, 1), &[2000, 2000]).unwrap();
    assert_eq!(reasons(&source)[1], Some(Reason::Reference));
    source.send(message::COMMAND, &Command::Capture.encode()).unwrap();
    source.send_frame(&telemetry(2), &records(300, 2), &[2000, 2000]).unwrap();
    let zoomed = Telemetry { field_of_view: 0.1, ..telemetry(3) };
    source.send_frame(&zoomed, &records(300, 3), &[2000, 2000]).unwrap();
    source.send_frame(&telemetry(4), &[], &[2000, 2000]).unwrap();
    source
        .send(message::FRAME, &message::encode_frame(5, &records(300, 5), 2, message::Unsent::default(), &[2000, 2000]))
        .unwrap();
    let mut outside = records(300, 6);
    outside[7].x = 1024;
    source
        .send(message::FRAME, &message::encode_frame(6, &outside, 0, message::Unsent::default(), &[2000, 2000]))
        .unwrap();
    source.send(message::FRAME, &[0; 32]).unwrap();
    // The sensors report a yaw of 20 degrees for a camera that has not turned.
    let turned =
        Telemetry { attitude: Attitude { yaw: 0.35, ..Attitude::default() }, time_us: 9_000_000, ..telemetry(7) };
    source.send_frame(&turned, &records(300, 7), &[2000, 2000]).unwrap();
    let reasons = reasons(&source);
    let texts: Vec<String> = reasons[3..].iter().map(|reason| reason.as_ref().unwrap().to_string()).collect();
    assert_eq!(reasons[2], None);
    for (text, part) in texts.iter().zip([
        "no keyframe is in view",
        "shows 0 features, and 8 are needed",
        "error bits 0x0002",
        "feature 7 lies outside",
        "without their trailer",
        "pictures and sensors disagree",
    ]) {
        assert!(text.contains(part), "{text:?} does not say {part:?}");
    }
    assert_eq!(texts.len(), 6);
}

/// The bits of a trailer are not at the places of the same errors in the register `status`.
#[test]
fn a_frame_with_any_error_bit_is_refused() {
    for bit in 0..16 {
        let errors = 1 << bit;
        let mut source = stream(600, 2);
        source.send(message::TELEMETRY, &telemetry(2).encode()).unwrap();
        let frame = message::encode_frame(2, &records(600, 2), errors, message::Unsent::default(), &[2000, 2000]);
        source.send(message::FRAME, &frame).unwrap();
        let last = lines(&source).pop().unwrap();
        assert_eq!((last.frame, last.reason, last.estimate), (Some(2), Some(Reason::Damaged(errors)), None));
    }
    use hoverlock_registers::record::{ERROR_INTERRUPTED, ERROR_LONG_FRAME, ERROR_SHORT_FRAME};
    assert_eq!([ERROR_SHORT_FRAME, ERROR_LONG_FRAME, ERROR_INTERRUPTED], [1, 2, 4], "as docs/algorithm.md says");
}

#[test]
fn another_fpga_is_refused() {
    let mut source = stream(10, 1);
    let mut payload = message::encode_registers(&[(0, 0x484c_434c)]);
    payload.extend([0; 8]);
    let mut other = Source::default();
    other.send(message::REGISTERS, &payload).unwrap();
    source.messages.splice(0..1, other.messages);
    let bytes = source.messages.concat();
    let mut decoder = Decoder::default();
    decoder.read(&mut &bytes[..]).unwrap();
    let refused = Navigator::default().take(&decoder.message().unwrap(), &mut |_| ());
    assert_eq!(
        refused.unwrap_err().to_string(),
        "register identification reads 0x484c434c, not 0x484c434b: no Hoverlock core at this address; correct the \
         base address"
    );
}

#[test]
fn a_register_block_of_a_wrong_length_is_counted_as_refused() {
    let mut source = Source::default();
    source.send(message::REGISTERS, &[0; 12]).unwrap();
    let bytes = source.messages.concat();
    let mut decoder = Decoder::default();
    decoder.read(&mut &bytes[..]).unwrap();
    let mut navigator = Navigator::default();
    navigator.take(&decoder.message().unwrap(), &mut |_| ()).unwrap();
    assert_eq!(navigator.counts().refused, 1);
}

/// The fate of a message on the link.
#[derive(Debug, Clone)]
enum Fate {
    Arrives,
    IsLost,
    ComesTwice,
    IsFlipped(prop::sample::Index),
    IsCut(prop::sample::Index),
    FollowsNoise(Vec<u8>),
    FollowsAFalseHeader(Vec<u8>),
}

fn fate() -> impl Strategy<Value = Fate> {
    let noise = || prop::collection::vec(any::<u8>(), 0..40);
    prop_oneof![
        6 => Just(Fate::Arrives),
        1 => Just(Fate::IsLost),
        1 => Just(Fate::ComesTwice),
        1 => any::<prop::sample::Index>().prop_map(Fate::IsFlipped),
        1 => any::<prop::sample::Index>().prop_map(Fate::IsCut),
        1 => noise().prop_map(Fate::FollowsNoise),
        1 => noise().prop_map(Fate::FollowsAFalseHeader),
    ]
}

/// Returns the messages of a flight with a restart of the source: frame and message numbers restart, clock and ground
/// continue.
fn flight() -> &'static [Vec<u8>] {
    static FLIGHT: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    FLIGHT.get_or_init(|| {
        let mut again = Source::default();
        again.send_registers(SIZE.0, SIZE.1).unwrap();
        for frame in 0..3 {
            let telemetry = Telemetry { frame, ..telemetry(frame + 4) };
            again.send_frame(&telemetry, &records(60, frame + 4), &[2000, 2000]).unwrap();
        }
        [stream(60, 4).messages, again.messages].concat()
    })
}

/// Returns the kind of an intact message, and its frame number if it is telemetry.
fn kind(message: &[u8]) -> (u32, u32) {
    let word = |at: usize| u32::from_le_bytes(message[at..at + 4].try_into().unwrap());
    (word(4), word(20))
}

proptest! {
    // Shrinking takes as long as the search and does not make a failure clearer here.
    #![proptest_config(ProptestConfig { cases: 10_000, max_shrink_iters: 100, ..ProptestConfig::default() })]

    /// Every frame whose message arrives intact has one line, in order, whatever happens to other messages; and if its
    /// telemetry arrived, too, it is not reported as missing.
    #[test]
    fn ten_thousand_damaged_streams_lose_no_intact_frame(fates in prop::collection::vec(fate(), flight().len())) {
        let mut bytes = Vec::new();
        let mut expected: Vec<(u32, bool)> = Vec::new();
        let mut telemetry = None;
        for (message, fate) in flight().iter().zip(&fates) {
            let (kind, first) = kind(message);
            let mut damaged = message.clone();
            let whole = match fate {
                Fate::Arrives => true,
                Fate::IsLost => { damaged.clear(); false }
                Fate::ComesTwice => { damaged.extend(message); true }
                Fate::IsFlipped(at) => {
                    let at = at.index(8 * damaged.len());
                    damaged[at / 8] ^= 1 << (at % 8);
                    false
                }
                // If only one byte were missing, one in 256 of the following bytes would complete the message.
                Fate::IsCut(at) => { damaged.truncate(at.index(damaged.len() - 4)); false }
                Fate::FollowsNoise(noise) => { damaged.splice(0..0, noise.iter().copied()); true }
                Fate::FollowsAFalseHeader(noise) => {
                    damaged.splice(0..0, b"HLNV".iter().chain(noise).copied());
                    true
                }
            };
            bytes.extend(damaged);
            if whole && kind == message::TELEMETRY {
                telemetry = Some(first);
            }
            if kind == message::FRAME {
                let trailer = message.len() - 4 - message::MIN_RECORD_BYTES;
                let number = u32::from_le_bytes(message[trailer..trailer + 4].try_into().unwrap());
                if whole {
                    expected.push((number, telemetry == Some(number)));
                }
                telemetry = None;
            }
        }
        let lines = flown(&bytes, Navigator::with_work(60_000));
        let found: Vec<_> = lines.iter().map(|line| line.frame).collect();
        prop_assert_eq!(found, expected.iter().map(|(number, _)| Some(*number)).collect::<Vec<_>>());
        for (line, (_, has_telemetry)) in lines.iter().zip(&expected) {
            let missing = line.reason == Some(Reason::Telemetry);
            prop_assert!(!(missing && *has_telemetry), "{:?}", line);
            prop_assert!((line.status == Status::None) == line.reason.is_some());
        }
    }
}
