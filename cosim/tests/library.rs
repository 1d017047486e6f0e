//! Hovers and campaigns through the library, as another program uses it.

use hoverlock_cosim::campaign::{Campaign, CampaignSettings, fly_row};
use hoverlock_cosim::hover::HoverError;
use hoverlock_cosim::{BoxError, FeatureSource, FrameProgress, HoverSettings, Monitor, fly_point, hover};
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

#[test]
fn an_outcome_serialises_to_its_summary_and_has_table_and_page() {
    let outcome = hover(&short(), &()).unwrap();
    let json: Value = serde_json::to_value(&outcome).unwrap();
    assert_eq!(json, serde_json::to_value(&outcome.summary).unwrap());
    assert_eq!((&json["pass"], &json["features"], &json["estimator"]), (&true.into(), &"fixed".into(), &"host".into()));
    assert_eq!((outcome.rows.len(), outcome.table().unwrap().lines().count()), (16, 17));
    assert!(outcome.page("a <program>").unwrap().contains("a &lt;program&gt;"));
}

#[test]
fn a_point_and_its_row_are_the_same_flight() {
    let settings = CampaignSettings {
        scenes: vec!["helipad-in-mist".into()],
        seeds: 1,
        gusts_m_s: vec![3.0],
        heights_m: vec![50.0],
        designs: Vec::new(),
        seconds: 1.0,
        features: FeatureSource::Fixed,
    };
    let [point] = &Campaign::new(&settings).unwrap().points[..] else { panic!() };
    let flown = fly_point(point, &()).unwrap();
    let row = format!("{},50,3,1,fixed,kt27,{},1\n", point.scene, point.inputs);
    let result = fly_row(&row, &()).unwrap();
    let rms: f64 = result.split(',').nth(10).unwrap().parse().unwrap();
    assert_eq!((rms, flown.point()), (flown.rms_m, point.clone()), "{result}");
    assert!(fly_row("moon\n", &()).is_err() && fly_row("", &()).is_err());
}
