//! Hovers and campaigns through the library, as another program uses it.

use hoverlock_arm::calibration::Measured;
use hoverlock_cosim::campaign::{Campaign, CampaignSettings, Point, fly_row};
use hoverlock_cosim::hover::{CameraView, Event, HoverError, Scenario};
use hoverlock_cosim::sequence::{self, Sequence};
use hoverlock_cosim::{BoxError, FeatureSource, FrameProgress, HoverSettings, Monitor, fly_point, hover};
use hoverlock_pictures::Limits;
use hoverlock_reference::image::plane::Plane;
use serde_json::Value;

/// A hover of one second over flat ground.
fn short() -> HoverSettings {
    HoverSettings { scene: "helipad-in-mist".into(), seconds: 1.0, ..HoverSettings::default() }
}

/// A monitor that stops a run after a frame.
struct StopAfter(usize);

impl Monitor for StopAfter {
    fn frame(&self, frame: &FrameProgress<'_>) -> Result<(), BoxError> {
        assert!(frame.number <= self.0 && frame.frames == 16, "{frame:?}");
        if frame.number == self.0 { Err("enough".into()) } else { Ok(()) }
    }
}

#[test]
fn a_monitor_stops_a_hover() {
    let stopped = hover(&short(), &StopAfter(2)).unwrap_err();
    assert!(matches!(&stopped, HoverError::Stopped(cause) if cause.to_string() == "enough"), "{stopped}");
}

#[test]
fn settings_out_of_range_are_refused() {
    for seconds in [0.0, f64::NAN, 1e9] {
        assert!(matches!(hover(&HoverSettings { seconds, ..short() }, &()), Err(HoverError::Seconds(_))));
    }
    assert!(matches!(hover(&HoverSettings { gusts_m_s: 6.0, ..short() }, &()), Err(HoverError::Setup(_))));
    let unknown = hover(&HoverSettings { scene: "moon".into(), ..short() }, &()).unwrap_err();
    assert!(unknown.to_string().contains("helipad-in-mist"), "{unknown}");
}

/// A lost frame has no row, and those after it are answered; a repeated message changes nothing.
#[test]
fn lost_and_repeated_messages_disturb_no_other_frame() {
    let events = |events: Vec<Event>| HoverSettings {
        seconds: 2.0,
        scenario: Scenario { events, ..Scenario::default() },
        ..short()
    };
    let quiet = hover(&events(Vec::new()), &()).unwrap();
    let lossy = hover(&events(vec![Event::Dropped { t: 1.0, seconds: 0.2 }]), &()).unwrap();
    assert_eq!((quiet.rows.len(), lossy.rows.len()), (31, 28));
    assert_eq!(lossy.answered(), (lossy.rows.len() - 8, lossy.rows.len() - 8));
    assert_eq!(lossy.summary.longest_loss_s, 0.2);
    let twice = hover(&events(vec![Event::Repeated { t: 0.5, seconds: 1.0 }]), &()).unwrap();
    assert_eq!(twice.table().unwrap(), quiet.table().unwrap());
}

/// After a capture the truth counts from the new reference, so the estimates stay right.
#[test]
fn the_truth_counts_from_the_reference() {
    let scenario = Scenario { events: vec![Event::Capture { t: 2.0 }], ..Scenario::default() };
    let outcome = hover(&HoverSettings { seconds: 4.0, gusts_m_s: 5.0, scenario, ..short() }, &()).unwrap();
    let references: Vec<_> = outcome.rows.iter().filter(|row| row.line.is_reference()).collect();
    let [first, second] = references[..] else { panic!("{} references", references.len()) };
    assert_eq!((first.truth.time, second.truth.time), (0.0, 2.0));
    let apart = (second.position() - first.position()).norm();
    assert!(apart > 0.05, "references only {apart} m apart");
    let last = outcome.rows.last().unwrap();
    assert!(last.error().unwrap().norm() < 0.05 && last.origin == second.position(), "{last:?}");
}

#[test]
fn an_outcome_serialises_to_its_summary_and_has_table_and_page() {
    let outcome = hover(&short(), &()).unwrap();
    let json: Value = serde_json::to_value(&outcome).unwrap();
    assert_eq!(json, serde_json::to_value(&outcome.summary).unwrap());
    assert_eq!((&json["pass"], &json["features"], &json["estimator"]), (&true.into(), &"fixed".into(), &"host".into()));
    assert_eq!((outcome.rows.len(), outcome.table().unwrap().lines().count()), (16, 17));
    assert!(outcome.page("a <program>").unwrap().contains("a &lt;program&gt;"));
}

/// The first row of a picture is read out at the time of the telemetry; a frame from its middle begins later, and takes
/// less time.
#[test]
fn a_frame_has_its_part_of_the_read_out() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, content: &[u8]| std::fs::write(folder.path().join(name), content).unwrap();
    let picture = sequence::png(&Plane::from_fn(80, 101, |x, y| (x * y) as u16)).unwrap();
    put("1.png", &picture);
    put("2.png", &picture);
    put("calibration.toml", b"readout_s = { value = 0.02, sigma = 0.004 }\n");
    let read = |rows: usize| sequence::read(folder.path(), &Limits::default(), (80, rows), &()).unwrap();
    let times = |sequence: &Sequence| sequence.telemetry.iter().map(|telemetry| telemetry.time_us).collect::<Vec<_>>();
    // Without telemetry there is no clock whose time a row could have.
    assert_eq!(times(&read(71)), times(&read(101)));
    put("telemetry.csv", b"time_s,roll_deg,pitch_deg,yaw_deg,range_m,fov_deg\n1,0,0,0,9,50\n2,0,0,0,9,50\n");
    let [whole, part] = [read(101), read(71)];
    assert_eq!((times(&whole), times(&part)), (vec![1_000_000, 2_000_000], vec![1_003_000, 2_003_000]));
    let readout = |sequence: &Sequence| sequence.calibration.unwrap().readout_s;
    assert_eq!((readout(&whole).value, readout(&whole).sigma), (0.02, 0.004));
    let Measured { value, sigma } = readout(&part);
    assert!((value - 0.014).abs() < 1e-12 && (sigma - 0.0028).abs() < 1e-12, "{value} {sigma}");
}

#[test]
fn a_point_and_its_row_are_the_same_flight() {
    let settings = CampaignSettings {
        scenes: vec!["helipad-in-mist".into()],
        seeds: 1,
        gusts_m_s: vec![3.0],
        heights_m: vec![50.0],
        views: vec![CameraView::Narrow],
        designs: Vec::new(),
        variants: Vec::new(),
        seconds: 3.0,
        features: FeatureSource::Fixed,
    };
    let [point] = &Campaign::new(&settings).unwrap().points[..] else { panic!() };
    let flown = fly_point(point, &()).unwrap();
    let row = format!("{},50,narrow,3,3,fixed,kt27,{},1\n", point.scene, point.inputs);
    let result = fly_row(&row, &()).unwrap();
    let rms: f64 = result.split(',').nth(12).unwrap().parse().unwrap();
    assert_eq!((rms, flown.point()), (flown.rms_m, point.clone()), "{result}");
    let wide = fly_point(&Point { view: CameraView::Wide, ..point.clone() }, &()).unwrap();
    assert_ne!((wide.rms_m, wide.point().key()), (rms, point.key()));
    assert!(fly_row("moon\n", &()).is_err() && fly_row("", &()).is_err());
}
