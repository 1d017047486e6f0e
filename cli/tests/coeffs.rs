//! `hoverlock coeffs` as a user runs it: the known answers, the files, and one clear line for what is not possible.

use std::path::Path;
use std::process::{Command, Output};

fn coeffs(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hoverlock"));
    command.arg("coeffs").args(arguments).output().expect("the command runs")
}

fn sets(arguments: &[&str]) -> Vec<serde_json::Value> {
    let output = coeffs(&[arguments, &["--json"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one JSON object and nothing else");
    report["sets"].as_array().expect("a list of sets").clone()
}

#[test]
fn first_order_poles_are_the_known_ones() {
    let known = [(0.413876, 0.209), (0.625615, 0.207), (0.739042, 0.193), (0.825284, 0.184)];
    for (set, (a, l2)) in sets(&["--sigma", "1", "2", "3.2", "5.12"]).iter().zip(known) {
        assert!((set["a"][0].as_f64().unwrap() - a).abs() <= 0.5e-6, "{set}");
        assert!((set["l2"].as_f64().unwrap() - l2).abs() <= 0.5e-3, "{set}");
        assert_eq!(set["quantised"]["dc_gain"], 1.0);
    }
}

#[test]
fn the_design_point_s_integers_are_the_default() {
    let sets = sets(&["--sigma", "2", "3.2", "5.12"]);
    let lerp = |i: usize| sets[i]["quantised"]["lerp"].clone();
    assert_eq!(
        (lerp(0)["g"].clone(), lerp(1)["g"].clone(), lerp(2)["g"].clone()),
        (24536.into(), 17102.into(), 11450.into())
    );
    assert_eq!(lerp(0)["g_j"], serde_json::json!([40315, 47101, 56830, 64033, 65500]));
    assert_eq!(lerp(1)["g_j"], serde_json::json!([37685, 42386, 50478, 60180, 65021]));
    assert_eq!(lerp(2)["g_j"], serde_json::json!([35905, 38984, 44768, 53931, 62636, 65396]));
}

#[test]
fn published_recursions_are_the_known_ones() {
    let set = &sets(&["--sigma", "5", "--method", "yvv95"])[0];
    for (i, known) in [2.22555139, -1.69070625, 0.43897167].into_iter().enumerate() {
        assert!((set["a"][i].as_f64().unwrap() - known).abs() <= 0.5e-8, "{set}");
    }
    assert!((set["parameter"]["value"].as_f64().unwrap() - 3.972250).abs() <= 0.5e-6);
    assert!((set["sigma_eff"].as_f64().unwrap() - 5.556).abs() <= 0.5e-3);
    let exact = &sets(&["--sigma", "5", "--method", "yvv95", "--fit", "variance"])[0];
    assert!((exact["sigma_eff"].as_f64().unwrap() - 5.0).abs() < 1e-9, "{exact}");
    assert_eq!(sets(&["--sigma", "2", "--method", "alvarez-mazorra"])[0]["a"][0], 0.5);
}

#[test]
fn the_folder_holds_every_form_whole() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/coefficients");
    let output = coeffs(&["--sigma", "2", "3.2", "--out", out.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut names: Vec<String> =
        std::fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names.remove(0), ".hoverlock");
    let figures = ["dog0_frequency", "dog0_impulse", "smoother0_frequency", "smoother0_impulse", "smoother1_frequency"]
        .into_iter()
        .chain(["smoother1_impulse"])
        .map(|name| format!("{name}.svg"));
    let forms = ["h", "json", "md", "mif", "rs", "vh"].map(|ending| format!("coefficients.{ending}"));
    assert_eq!(names, forms.into_iter().chain(figures).collect::<Vec<_>>());
    made_again(&out, &names);
    // A design has a look-ahead for each smoother.
    let of_design = folder.path().join("small");
    assert!(coeffs(&["--design", "small", "--out", of_design.to_str().unwrap()]).status.success());
    made_again(&of_design, &names);
}

/// What a file says it was made by, makes it again.
fn made_again(out: &Path, names: &[String]) {
    let header = std::fs::read_to_string(out.join("coefficients.vh")).unwrap();
    let command = header.lines().next().unwrap().strip_prefix("// Written by: hoverlock coeffs ").unwrap();
    let again = out.with_extension("again");
    let mut arguments: Vec<&str> = command.split(' ').collect();
    arguments.extend(["--out", again.to_str().unwrap()]);
    assert!(coeffs(&arguments).status.success());
    for name in names {
        assert_eq!(std::fs::read(out.join(name)).unwrap(), std::fs::read(again.join(name)).unwrap(), "{name}");
    }
}

/// The path of a design is in a comment of each file, which must not end within it.
#[test]
fn a_path_with_the_end_of_a_comment_stays_in_the_comment() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("a*");
    std::fs::create_dir(&inside).unwrap();
    let design = inside.join("b\nc.toml");
    std::fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/../designs/small.toml"), &design).unwrap();
    let out = folder.path().join("out");
    let output = coeffs(&["--design", design.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let first = read("coefficients.h").lines().next().unwrap().to_owned();
    assert!(first.ends_with(" */") && first.matches("*/").count() == 1 && first.contains("a* /b c.toml"), "{first}");
    for (name, start) in [("coefficients.vh", "// Include"), ("coefficients.rs", ""), ("coefficients.mif", "WIDTH")] {
        let text = read(name);
        let second = text.lines().nth(1).unwrap();
        assert!(second.starts_with(start) && !second.contains("c.toml"), "{name}: {second}");
    }
}

/// The marker is written by its name: not through a link, and not over what is no text.
#[test]
fn a_marker_that_is_no_text_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (out, victim) = (folder.path().join("out"), folder.path().join("victim"));
    let marker = out.join(".hoverlock");
    std::fs::create_dir(&out).unwrap();
    let refused = |reason: &str| {
        let output = coeffs(&["--sigma", "2", "--out", out.to_str().unwrap()]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(reason), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    };
    std::fs::write(&victim, "mine").unwrap();
    for target in ["../victim", "../nothing"] {
        std::os::unix::fs::symlink(target, &marker).unwrap();
        refused(".hoverlock: is not a regular file");
        std::fs::remove_file(&marker).unwrap();
    }
    assert_eq!(std::fs::read_to_string(&victim).unwrap(), "mine");
    assert!(!folder.path().join("nothing").exists());
    std::fs::write(&marker, b"\xff\xfe").unwrap();
    refused(".hoverlock: cannot be read as text");
    assert_eq!(std::fs::read(&marker).unwrap(), b"\xff\xfe");
}

#[test]
fn what_is_not_possible_gets_one_line_and_status_two() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let file = file.path().to_str().unwrap();
    for (arguments, reason) in [
        (vec!["--sigma", "0"], "sigma 0 px"),
        (vec!["--sigma", "-2"], "sigma -2 px"),
        (vec!["--sigma", "nan"], "sigma NaN px"),
        (vec!["--sigma", "1e9"], "0.5 to 256 px"),
        (vec!["--sigma", "2", "--frac-bits", "0"], "0 fraction bits"),
        (vec!["--sigma", "2", "--frac-bits", "200"], "200 fraction bits"),
        (vec!["--sigma", "2", "--method", "deriche", "--order", "7"], "no order 7"),
        (vec!["--sigma", "2", "--method", "first-order", "--order", "2"], "no order 2"),
        (vec!["--sigma", "2", "--fit", "published"], "no published fit"),
        (vec!["--sigma", "2", "--method", "deriche", "--look-ahead", "5"], "leave it out"),
        (vec!["--sigma", "30", "--method", "vyv", "--frac-bits", "4"], "no rounding"),
        (vec!["--sigma", "2", "--out", file], file),
        (vec![], "--sigma"),
    ] {
        let output = coeffs(&arguments);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert_eq!(message.lines().count(), 1, "{arguments:?}: {message}");
        assert!(message.contains(reason), "{arguments:?}: {message}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
    }
}
