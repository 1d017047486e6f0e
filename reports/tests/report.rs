//! A report from picture to files: page, JSON and JUnit agree, and a format with too few bits fails.

use std::sync::LazyLock;

use hoverlock_design::KT27;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reports::baseline::{self, Baseline};
use hoverlock_reports::hardware::{DeviceUtilisation, Hardware, MISMATCHES, ResourceEstimate, Simulated, StepResult};
use hoverlock_reports::study::{self, Commands, MIN_SIDE, Stage, Study, Subject, Unfit};
use hoverlock_reports::sweep::{self, Alternative};
use hoverlock_reports::{output, page};
use quick_junit::{Report, TestCaseStatus};
use serde_json::Value;

mod plots;

/// A picture of blocks of three sizes: features in every part of it.
fn subject(width: usize, height: usize) -> Subject {
    let hash = |x: usize, y: usize| {
        let mixed = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
        (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 48
    };
    let picture = Plane::from_fn(width, height, |x, y| {
        ((hash(x / 5, y / 5) + hash(x / 11, y / 11 + 1000) + hash(x / 23, y / 23 + 2000)) / 3) as u16
    });
    Subject { name: "blobs & <co>".into(), frame: picture.clone(), picture }
}

fn measured(width: usize, height: usize, change: &str) -> Study {
    of_subjects(&[subject(width, height)], change)
}

fn of_subjects(subjects: &[Subject], change: &str) -> Study {
    let design = KT27.with_override(change).unwrap();
    let commands = Commands { typed: "hoverlock report blobs.png", changed: &|changes| changes.join(" ") };
    study::run(subjects, &design, &commands, &|_| ()).unwrap()
}

static FULL: LazyLock<Study> = LazyLock::new(|| measured(440, 400, "dog_bits=15"));

/// The picture of [`FULL`], and one with too few features.
static WITH_UNFIT: LazyLock<Study> = LazyLock::new(|| {
    let unfit = Subject { name: "unfit".into(), ..subject(MIN_SIDE, MIN_SIDE) };
    of_subjects(&[subject(440, 400), unfit], "dog_bits=15")
});

/// Returns the skipped test cases of a study: class and name.
fn skipped(study: &Study) -> Vec<(String, String)> {
    let junit = Report::deserialize_from_str(&output::junit(study).unwrap()).unwrap();
    let cases = junit.test_suites.iter().flat_map(|suite| &suite.test_cases);
    let skipped = cases.filter(|case| matches!(case.status, TestCaseStatus::Skipped { .. }));
    skipped.map(|case| (case.classname.as_ref().unwrap().as_str().to_owned(), case.name.as_str().to_owned())).collect()
}

#[test]
fn the_design_point_passes_every_check() {
    let failed: Vec<_> = FULL.bounds.iter().filter(|row| !row.check.pass).collect();
    assert!(FULL.pass && failed.is_empty(), "{failed:?}");
}

#[test]
fn a_picture_that_judges_nothing_is_not_counted() {
    let mut study = WITH_UNFIT.clone();
    let refused = Unfit { picture: "flat.png".into(), condition: None, reason: "every pixel is 7".into() };
    study.add_refused(vec![refused]);
    assert_eq!((study.judges(), study.pictures_given), (vec!["blobs & <co>"], 3));
    assert_eq!(study.bounds, FULL.bounds);
    assert!(page::html(&study).unwrap().contains(": 1 of 3 pictures × 3 conditions"));
    let fit = "fit to judge a design".to_owned();
    let of_unfit = ["unfit, nominal", "unfit, combined", "unfit, fog", "unfit", "flat.png"];
    let skipped = skipped(&study);
    for class in of_unfit {
        assert!(skipped.contains(&(class.to_owned(), fit.clone())), "{class}: {skipped:?}");
    }
    // What it measures is in no curve and no result at the head of the page.
    assert_eq!((&study.sweeps, &study.costs), (&FULL.sweeps, &FULL.costs));
    let levels = study.levels.iter_mut().flat_map(|level| &mut level.measurements);
    levels.filter(|of| of.picture == "unfit").for_each(|of| of.error.rms = 1234.0);
    let html = page::html(&study).unwrap();
    assert!(!html.contains("<b>1234</b>") && !html.contains("DoG 1234 LSB rms"));
}

#[test]
fn checks_that_are_left_out_for_want_of_contrast_are_stated() {
    assert!(FULL.low_contrast.is_empty(), "{:?}", FULL.low_contrast);
    let mut faint = subject(440, 400);
    faint.frame = faint.frame.map(|dn| 30_000 + dn / 150);
    let study = of_subjects(&[faint], "dog_bits=15");
    let fog = study.low_contrast.iter().find(|of| of.condition == "fog").expect("it has hardly any contrast");
    assert!(fog.checks.contains(&"DoG SQNR") && fog.rms_lsb < 80.0, "{fog:?}");
    assert!(study.unchecked().contains(&fog.to_string()));
    let json: Value = serde_json::from_str(&output::json(&study).unwrap()).unwrap();
    assert_eq!(json["low_contrast"].as_array().map(Vec::len), Some(study.low_contrast.len()));
    let of_fog = ("blobs & <co>, fog".to_owned(), "DoG SQNR".to_owned());
    assert!(skipped(&study).contains(&of_fog), "{:?}", skipped(&study));
}

/// The LSB of this state is 64 DN, 256 of those of the default design.
#[test]
fn errors_of_the_smoothers_are_in_the_lsb_of_the_state() {
    let study = measured(120, 110, "pixel=u8.0");
    let of_stages = study.chains.iter().flat_map(|chain| &chain.stages);
    assert!(of_stages.clone().count() > 40 && of_stages.clone().all(|stage| stage.rms_lsb < 2.0), "{:?}", study.chains);
    assert!(of_stages.clone().any(|stage| stage.rms_lsb > 0.2), "{:?}", study.chains);
    let measured = study.levels.iter().flat_map(|level| &level.measurements);
    for of in measured {
        let lsb = if matches!(of.stage, Stage::Smoothed(_)) { 64.0 } else { 0.5 };
        assert_eq!(of.lsb_dn, lsb, "{:?}", of.stage);
    }
}

#[test]
fn a_design_that_rounds_beyond_the_bound_is_told_so() {
    assert_eq!(FULL.beyond_bound(), None);
    let coarse = measured(MIN_SIDE, MIN_SIDE, "dog_bits=11");
    let reason = coarse.beyond_bound().unwrap();
    assert!(reason.contains("dog_bits = 11") && reason.contains("4.6 LSB rms"), "{reason}");
    assert!(page::html(&coarse).unwrap().contains("dog_bits = 11: the bound of the DoG error"));
}

#[test]
fn a_baseline_of_another_picture_of_the_same_name_is_stated() {
    let text = output::json(&FULL).unwrap();
    let same = Baseline::parse(&text).unwrap().compare(&FULL);
    assert_eq!(same.other_inputs, [""; 0]);
    let (picture, bounds) = (&FULL.pictures[0].sha256, &FULL.provenance.bounds_sha256);
    let other = text.replace(picture.as_str(), &"0".repeat(64)).replace(bounds.as_str(), &"1".repeat(64));
    let compared = Baseline::parse(&other).unwrap().compare(&FULL);
    let [of_bounds, of_picture] = &compared.other_inputs[..] else { panic!("{:?}", compared.other_inputs) };
    assert!(of_bounds.starts_with("bounds.toml: sha256 111111111111 before, "), "{of_bounds}");
    assert!(of_picture.starts_with("blobs & <co>: sha256 000000000000 before, "), "{of_picture}");
    assert!(baseline::html(&compared).unwrap().contains("sha256 000000000000 before"));
}

#[test]
fn another_smoother_stands_beside_first_order_and_changes_no_check() {
    let other = measured(440, 400, "smoother=vyv");
    assert_eq!((&other.bounds, &other.alternatives), (&FULL.bounds, &FULL.alternatives));
    let [gaussian, first_order, vyv] = &other.smoothers[..] else { panic!("{:?}", other.smoothers) };
    let names = [gaussian, first_order, vyv].map(|row| (row.name.as_str(), row.order));
    assert_eq!(names, [("Gaussian", None), ("first-order", Some(1)), ("vyv", Some(3))]);
    let (near, far) = (vyv.approximation.unwrap(), first_order.approximation.unwrap());
    assert!(gaussian.approximation.is_none() && 3.0 * near.dog_rms_lsb < far.dog_rms_lsb, "{near:?} {far:?}");
    assert!(near.same_pixel_percent > far.same_pixel_percent && near.maxlbp_flips_percent < far.maxlbp_flips_percent);
    for row in [gaussian, first_order, vyv] {
        assert!(row.motions_found == 5 && row.motion_max_px.unwrap() < 0.5, "{row:?}");
        assert!(row.motion_median_px <= row.motion_max_px && row.repeated_percent > Some(50.0), "{row:?}");
    }
    assert!(vyv.rounding_rms_lsb > Some(0.0) && first_order.rounding_rms_lsb > Some(0.0));
    let page = page::html(&other).unwrap();
    for text in ["Smoothers side by side", "bit_true and the hardware stay first-order", "vyv in place of the Gaussian"]
    {
        assert!(page.contains(text), "{text}");
    }
    assert!(FULL.smoothers.is_empty() && !page::html(&FULL).unwrap().contains("Smoothers side by side"));
}

#[test]
fn a_format_with_too_few_bits_fails_and_the_failed_bound_is_named() {
    let narrow = measured(440, 400, "dog_bits=12");
    assert!(!narrow.pass);
    let row = narrow.bounds.iter().find(|row| row.check.name == "DoG error, rms" && !row.check.pass).unwrap();
    assert!(row.margin < 0.0 && row.picture.is_some() && row.condition.is_some());
    let html = page::html(&narrow).unwrap();
    assert!(html.contains(">FAIL<") && html.contains("<b>DoG error, rms</b>"));
    let junit = Report::deserialize_from_str(&output::junit(&narrow).unwrap()).unwrap();
    let cases = junit.test_suites.iter().flat_map(|suite| &suite.test_cases);
    let failures = cases.filter(|case| matches!(case.status, TestCaseStatus::NonSuccess { .. })).count();
    assert_eq!(failures, narrow.bounds.iter().filter(|row| !row.check.pass).count());
}

/// The planes of all levels of a picture are hundreds of megabytes, so no second picture may be begun meanwhile.
#[test]
fn pictures_are_measured_one_after_the_other() {
    let subjects = ["a", "b", "c", "d"].map(|name| Subject { name: name.into(), ..subject(200, 180) });
    let commands = Commands { typed: "hoverlock report", changed: &|_| String::new() };
    let steps = std::sync::Mutex::new(Vec::new());
    study::run(&subjects, &KT27, &commands, &|step| steps.lock().unwrap().push(step.to_owned())).unwrap();
    let names = |end: &str| -> Vec<char> {
        let steps = steps.lock().unwrap();
        steps.iter().filter(|step| step.ends_with(end)).filter_map(|step| step.chars().next()).collect()
    };
    for end in [", nominal", ", combined", ", fog", ", displacement"] {
        assert_eq!(names(end), ['a', 'b', 'c', 'd'], "{end}");
    }
    let words = names(", word lengths");
    assert!(words.len() > 40 && words.is_sorted(), "{words:?}");
    let order: Vec<String> = steps.lock().unwrap().iter().take(8).cloned().collect();
    assert_eq!(order[3], "a, displacement", "{order:?}");
    assert_eq!(order[7], "b, displacement", "{order:?}");
}

#[test]
fn the_json_report_has_the_documented_keys() {
    let json: Value = serde_json::from_str(&output::json(&FULL).unwrap()).unwrap();
    assert_eq!(json["pass"], Value::Bool(FULL.pass));
    let bounds = json["bounds"].as_array().unwrap();
    assert_eq!(bounds.len(), FULL.bounds.len());
    for (row, of) in bounds.iter().zip(&FULL.bounds) {
        assert_eq!(row["name"], of.check.name);
        // A JSON parser may differ in the last bit.
        let same = |key: &str, wanted: f64| (row[key].as_f64().unwrap() - wanted).abs() <= 1e-15 * wanted.abs();
        assert!(same("limit", of.check.limit) && same("measured", of.check.measured), "{row}");
        assert_eq!(row["pass"], of.check.pass);
    }
    let levels = json["levels"].as_array().unwrap();
    let names: Vec<_> = levels.iter().map(|level| level["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["ideal", "recursive", "streaming", "quantised", "bit_true", "rtl"]);
    let (hardware, models) = levels.split_last().unwrap();
    assert_eq!(hardware["hardware"]["simulation"]["status"], "not run");
    assert_eq!(models[0]["measurements"].as_array().map(Vec::len), Some(0), "the ideal level is the reference");
    for level in &models[1..] {
        // Seven stages under three conditions of one picture, and one kind of error only.
        let measurements = level["measurements"].as_array().unwrap();
        assert_eq!(measurements.len(), 21);
        let kind = if ["recursive", "streaming"].contains(&level["name"].as_str().unwrap()) {
            "approximation"
        } else {
            "quantisation"
        };
        assert!(measurements.iter().all(|m| m["kind"] == kind && m["rms"].as_f64().is_some()));
    }
    assert_eq!(json["provenance"]["configuration_sha256"].as_str().map(str::len), Some(64));
}

#[test]
fn the_page_needs_no_network_and_has_no_unset_value_or_open_tag() {
    let html = page::html(&FULL).unwrap();
    for attribute in ["src=\"", "href=\"", "url("] {
        for (at, _) in html.match_indices(attribute) {
            let target = &html[at + attribute.len()..(at + attribute.len() + 5).min(html.len())];
            let own = [output::NUMBERS, output::TABLE, output::TESTS].iter().any(|name| name.starts_with(target));
            assert!(target == "data:" || target.starts_with("#s") || own, "{attribute}{target}");
        }
    }
    assert!(
        !html.contains("http://")
            && !html.contains("https://")
            && !html.contains("@import")
            && html.matches("<script").count() == 1
            && html.contains("<script>//")
    );
    let body = &html[html.find("</style>").unwrap()..html.find("<script>").unwrap()];
    for text in body.split('<').filter_map(|piece| piece.split_once('>')).map(|(_, text)| text) {
        for word in text.split(|c: char| !c.is_alphanumeric()) {
            assert!(!["undefined", "NaN", "nan", "none", "None", "inf"].contains(&word), "{text}");
        }
    }
    assert!(html.contains("blobs &amp; &lt;co&gt;") && !html.contains("<co>"), "names are escaped");
    for tag in ["table", "figure", "svg", "div", "section", "main", "p"] {
        let opened = html.matches(&format!("<{tag}>")).count() + html.matches(&format!("<{tag} ")).count();
        assert_eq!(opened, html.matches(&format!("</{tag}>")).count(), "{tag}");
    }
    for section in 1..=11 {
        assert!(html.contains(&format!("<h2 id=\"s{section}\">")), "section {section}");
    }
    // The terms stand before their first section, with the name of the full list.
    let terms = &html[html.find("<h2 id=\"s0\">").unwrap()..html.find("<h2 id=\"s1\">").unwrap()];
    for term in ["DN", "LSB", "format", "DoG", "MaxLBP", "nominal", "combined", "fog"] {
        assert!(terms.contains(&format!("<dt>{term}</dt>")), "{term}");
    }
    assert!(terms.contains("docs/glossary.md"));
    assert!(html.len() < 4_000_000, "{} bytes for one picture", html.len());
}

#[test]
fn junit_has_one_test_case_for_each_check() {
    let report = Report::deserialize_from_str(&output::junit(&FULL).unwrap()).unwrap();
    // One more, skipped: the RTL was not simulated.
    assert_eq!(report.tests, FULL.bounds.len() + 1);
    assert_eq!(report.failures, 0);
    let suites: Vec<&str> = report.test_suites.iter().map(|suite| suite.name.as_str()).collect();
    let of_conditions = ["coefficients", "blobs & <co>, nominal", "blobs & <co>, combined", "blobs & <co>, fog"];
    assert_eq!(suites, [&of_conditions[..], &["hardware"]].concat());
}

/// The study with a made-up RTL simulation.
fn simulated(mismatches: u64, complete: bool) -> Study {
    let run = Simulated {
        picture: "blobs & <co>".into(),
        frames: 3,
        pixels: 528_000,
        cycles: 560_000,
        samples: 3_600_000,
        features: 2900,
        dropped: 0,
        mismatches,
        first_mismatch: (mismatches > 0).then(|| "DoG 1, frame 2, x 5, y 7: expected 0x0003 < 0x0004".into()),
        complete,
        cycles_per_pixel: Some(1.0),
        latency_lines: Some(63.4),
        feature_latency_lines: Some(81.5),
    };
    let estimate = ResourceEstimate {
        label: "Yosys estimate".into(),
        alm: 9_000,
        m10k: 400,
        dsp: 26,
        mul18: 51,
        registers: 17_000,
        logic_levels: 7,
        target_mhz: 100,
        alm_rule: "a".into(),
        levels_rule: "b".into(),
        fits_rule: "c".into(),
        devices: vec![DeviceUtilisation {
            name: "5AGXA1".into(),
            source: "believed".into(),
            has: [28_302, 800, 240],
            limits: [18_868, 533, 60],
            used_percent: [31.8, 50.0, 10.8],
            fits: true,
        }],
        modules: Vec::new(),
    };
    let hardware =
        Hardware { simulation: StepResult::Run { result: vec![run] }, estimate: StepResult::Run { result: estimate } };
    FULL.clone().with_hardware(hardware)
}

#[test]
fn rtl_mismatches_are_checked_only_where_the_simulation_ran() {
    let row = |study: &Study| study.bounds.iter().find(|row| row.check.name == MISMATCHES).cloned();
    // Not run: no check, one skipped test case, and a line on the page.
    assert!(row(&FULL).is_none());
    let junit = Report::deserialize_from_str(&output::junit(&FULL).unwrap()).unwrap();
    let cases = || junit.test_suites.iter().flat_map(|suite| &suite.test_cases);
    let skipped: Vec<_> =
        cases().filter(|case| matches!(case.status, TestCaseStatus::Skipped { .. })).map(|case| &case.name).collect();
    assert_eq!(skipped, [MISMATCHES]);
    assert_eq!(FULL.unchecked(), ["rtl against bit_true: no simulation was requested"]);
    assert!(page::html(&FULL).unwrap().contains("<li>rtl against bit_true: no simulation was requested</li>"));
    // No mismatch: one more check, and it passes.
    let equal = simulated(0, true);
    let checked = row(&equal).unwrap().check;
    assert!(equal.pass && checked.pass && checked.measured == 0.0 && checked.limit == 0.0);
    assert_eq!(equal.bounds.len(), FULL.bounds.len() + 1);
    let html = page::html(&equal).unwrap();
    assert!(html.contains("0 mismatches in 3\u{202f}600\u{202f}000 samples and 2\u{202f}900 features"));
    assert!(!html.to_lowercase().contains("not run"));
    // A mismatch: the report fails and names its position.
    let different = simulated(3, false);
    assert!(!different.pass && row(&different).unwrap().margin == -3.0);
    assert!(page::html(&different).unwrap().contains("DoG 1, frame 2, x 5, y 7"));
    // A comparison that is not complete fails, even without a mismatch.
    let silent = simulated(0, false);
    assert!(!silent.pass && row(&silent).unwrap().check.measured.is_nan());
}

#[test]
fn the_pareto_front_has_no_dominated_word_length() {
    let costs = &FULL.costs;
    // 5 of the state, 6 of the coefficients, 7 of the DoG, less invalid ones; the design point counts once.
    assert!(costs.len() <= 16 && costs.iter().filter(|cost| cost.chosen).count() == 1);
    // A state of 19 bits has the least error, and no Verilog.
    assert!(costs.iter().any(|cost| !cost.buildable) && costs.iter().all(|cost| cost.buildable || !cost.front));
    let built: Vec<_> = costs.iter().filter(|cost| cost.buildable).collect();
    for cost in costs {
        let dominated = built.iter().any(|other| {
            other.dog_rms_lsb < cost.dog_rms_lsb
                && other.resources.m10k <= cost.resources.m10k
                && other.resources.mul18 <= cost.resources.mul18
        });
        assert!(!(dominated && cost.front), "{cost:?}");
    }
    // The word length with the least error that can be built is on the front.
    let least = built.iter().min_by(|a, b| a.dog_rms_lsb.total_cmp(&b.dog_rms_lsb)).unwrap();
    assert!(least.front, "{least:?}");
}

#[test]
fn every_word_has_its_alternatives_and_the_design_passes_in_each() {
    for word in ["state", "coefficients", "DoG", "look-ahead", "pixel"] {
        let of: Vec<_> = FULL.alternatives.iter().filter(|alternative| alternative.word == word).collect();
        let own: Vec<_> = of.iter().filter(|alternative| alternative.chosen).collect();
        assert!(own.len() == 1 && own[0].pass && own[0].command.is_empty(), "{word}: {own:?}");
        // Every camera has a report of its own, which passes.
        if word == "pixel" {
            assert!(of.iter().all(|alternative| alternative.pass), "{of:?}");
            continue;
        }
        // A word far too short fails, names its check, and costs no more. A look-ahead shorter than the others may cost
        // a block more: the shared rows of pixels wait for the longest.
        let fails = of.iter().rfind(|alternative| !alternative.pass).unwrap();
        let worst = fails.worst.as_ref().unwrap();
        assert!(!worst.pass && fails.margin == Some(100.0 * (1.0 - worst.used)), "{fails:?}");
        assert!(word == "look-ahead" || fails.resources.m10k <= own[0].resources.m10k, "{fails:?}");
    }
    // The closest check of the design is that of the report.
    let used = FULL.bounds.iter().map(|row| row.check.used).fold(0.0, f64::max);
    let own = FULL.alternatives.iter().find(|alternative| alternative.chosen).unwrap();
    assert!((own.margin.unwrap() - 100.0 * (1.0 - used)).abs() < 1e-9);
}

#[test]
fn alternatives_are_in_order_and_the_cheapest_is_named() {
    let all = &FULL.alternatives;
    assert!(all.is_sorted_by_key(|alternative| !alternative.pass));
    let used = |of: &Alternative| of.worst.as_ref().map_or(0.0, |worst| worst.used);
    let failing: Vec<f64> = all.iter().filter(|alternative| !alternative.pass).map(used).collect();
    assert!(failing.len() > 3 && failing.is_sorted(), "{failing:?}");
    // A cheaper choice that passes is named, and one that cannot be built or is another camera is not.
    let price = |of: &Alternative| [of.resources.m10k, of.resources.alm, of.resources.dsp];
    let named = |all: &[Alternative]| sweep::cheapest(all).map(|of| (of.word, of.value.clone()));
    let own = all.iter().find(|alternative| alternative.chosen).unwrap();
    let mut all = all.clone();
    let cheap = all.iter().position(|of| of.word == "DoG" && price(of) < price(own)).unwrap();
    all.retain(|of| of.chosen || price(of) >= price(&FULL.alternatives[cheap]));
    let of_all = |all: &mut Vec<Alternative>, change: &dyn Fn(&mut Alternative)| {
        let at = all.iter().position(|of| of.value == FULL.alternatives[cheap].value).unwrap();
        change(&mut all[at]);
    };
    of_all(&mut all, &|of| of.pass = true);
    assert_eq!(named(&all), Some(("DoG", FULL.alternatives[cheap].value.clone())));
    of_all(&mut all, &|of| of.unbuildable = Some("a reason".into()));
    assert_ne!(named(&all), Some(("DoG", FULL.alternatives[cheap].value.clone())));
    of_all(&mut all, &|of| (of.unbuildable, of.word) = (None, "pixel"));
    assert!(named(&all).is_none_or(|(word, _)| word != "pixel"));
    // Coefficients of 18 bits pass in the models, and no register holds them.
    let wide = FULL.alternatives.iter().find(|other| other.value == "u0.18").unwrap();
    assert!(wide.pass && wide.unbuildable.is_some(), "{wide:?}");
}

#[test]
fn a_number_has_one_value_on_the_page() {
    let row = |name: &str| {
        let rows = FULL.bounds.iter().filter(|row| row.check.name == name);
        rows.map(|row| row.check.measured).fold(0.0, f64::max)
    };
    let chosen = FULL.costs.iter().find(|cost| cost.chosen).unwrap();
    assert_eq!(chosen.dog_rms_lsb, row("DoG error, rms"));
    assert_eq!(chosen.maxlbp_flips_percent, row("MaxLBP bits flipped"));
    let html = page::html(&FULL).unwrap();
    let tile = |value: f64| format!("<div class=\"tile\"><b>{value:.3}</b>");
    assert!(html.contains(&tile(row("DoG error, rms"))), "{}", tile(row("DoG error, rms")));
}

#[test]
fn the_table_of_checks_has_a_row_for_each() {
    let csv = output::csv(&FULL);
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 1 + FULL.bounds.len());
    assert!(lines[1..].iter().all(|line| line.contains(",true,")), "{csv}");
    assert!(lines.iter().any(|line| line.starts_with("blobs & <co>,fog,\"DoG error, rms\",")), "{csv}");
}

#[test]
fn the_smallest_picture_gives_equal_reports_twice_and_judges_nothing() {
    let once = measured(MIN_SIDE, MIN_SIDE, "dog_bits=15");
    let again = measured(MIN_SIDE, MIN_SIDE, "dog_bits=15");
    assert_eq!(output::json(&once).unwrap(), output::json(&again).unwrap());
    assert_eq!(page::html(&once).unwrap(), page::html(&again).unwrap());
    assert!(!once.pass && once.bounds.iter().all(|row| row.picture.is_none()));
    assert!(once.alternatives.iter().all(|alternative| !alternative.pass), "{:?}", once.alternatives);
    assert!(once.unfit.iter().any(|unfit| unfit.reason.contains("a verdict needs 200")), "{:?}", once.unfit);
}

#[test]
fn a_report_has_four_files() {
    let files = output::files(&FULL).unwrap();
    assert_eq!(files.each_ref().map(|(name, _)| *name), [output::PAGE, output::NUMBERS, output::TABLE, output::TESTS]);
    assert!(files.iter().all(|(_, content)| !content.is_empty()));
}
