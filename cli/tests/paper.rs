//! `hoverlock scene`, `orthophoto` and `paper`, as a user runs them.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn hoverlock(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hoverlock")).args(arguments).current_dir(folder).output().unwrap()
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    let output = hoverlock(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn refused(folder: &Path, arguments: &[&str], words: &str) {
    let output = hoverlock(folder, arguments);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(stderr.contains(words) && stderr.trim_end().lines().count() == 1, "{stderr}");
}

#[test]
fn a_tilted_frame_warped_is_the_frame_from_above() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = json(folder, &["scene", "helipad-in-mist", "--out", "above.png", "--json"]);
    assert_eq!((&scene["width"], &scene["height"]), (&Value::from(1024), &Value::from(768)));
    let [roll, pitch, yaw] = [4.0f64, -3.0, 12.0];
    let look = format!("{roll},{pitch},{yaw}");
    hoverlock(folder, &["scene", "helipad-in-mist", "--look", &look, "--out", "tilted.png"]);
    // The apron is level, so the laser measures 50 m over the cosine of the tilt.
    let range = 50.0 / (roll.to_radians().cos() * pitch.to_radians().cos());
    let row = format!("roll_deg,pitch_deg,yaw_deg,range_m,fov_deg\n{roll},{pitch},{yaw},{range},50\n");
    fs::write(folder.join("row.csv"), row).unwrap();
    let warped = json(folder, &["orthophoto", "tilted.png", "--telemetry", "row.csv", "--out", "warped.png", "--json"]);
    assert!((warped["height_m"].as_f64().unwrap() - 50.0).abs() < 1e-6);
    let focal = 512.0 / 25f64.to_radians().tan();
    let pixel = warped["metres_per_pixel"].as_f64().unwrap();
    assert!((pixel - range / focal).abs() < 1e-9, "{pixel}");
    let found = json(folder, &["match", "above.png", "warped.png", "--model", "similarity", "--json"]);
    let h: Vec<f64> = found["homography"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    assert!((h[0] - 50.0 / focal / pixel).abs() < 2e-3 && h[1].abs() < 2e-3, "{h:?}");
    // The middle is where the laser hits.
    let moved = &found["displacement_px"];
    let axis = [roll, pitch].map(f64::to_radians);
    let expected = [axis[0].tan() * 50.0 / axis[1].cos() / pixel, axis[1].tan() * 50.0 / pixel];
    let turned = {
        let (sin, cos) = yaw.to_radians().sin_cos();
        [cos * expected[0] - sin * expected[1], sin * expected[0] + cos * expected[1]]
    };
    for i in 0..2 {
        assert!((moved[i].as_f64().unwrap() + turned[i]).abs() < 1.5, "{moved} {turned:?}");
    }
}

/// The page says which command states its numbers: each is pasted in the folder of the page, and must state them.
#[test]
fn each_command_of_the_page_states_its_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let page = json(folder.path(), &["paper", "--out", "page", "--json"]);
    let program = Path::new(env!("CARGO_BIN_EXE_hoverlock")).parent().unwrap();
    let mut compared = Vec::new();
    for item in page["items"].as_array().unwrap() {
        let (number, found) = (item["number"].as_str().unwrap(), item["found"].as_str().unwrap());
        let commands = item["commands"].as_array().unwrap();
        for command in commands {
            let line = command["line"].as_str().unwrap();
            let mut shell = Command::new("/bin/sh");
            shell.args(["-c", &format!("{line} --json")]).env("PATH", program).current_dir(folder.path().join("page"));
            let output = shell.output().unwrap();
            assert_eq!(output.status.code(), Some(0), "{line}: {}", String::from_utf8_lossy(&output.stderr));
            let stated: Value = serde_json::from_slice(&output.stdout).unwrap();
            for (member, value) in command["states"].as_object().unwrap() {
                assert_eq!(stated.pointer(member), Some(value), "{number}: {line}: {member}");
            }
            assert!(found.contains(&format!(" {} ", stated["inliers"])), "{number}: {line}: {stated}\n{found}");
        }
        // Numbers without a command are named as such.
        let only_here = item["only_here"].as_str().unwrap();
        assert!(number != "figure 11, formulas (9) to (11)" || only_here.starts_with("these numbers"), "{only_here}");
        compared.extend((!commands.is_empty()).then(|| number.to_owned()));
    }
    assert_eq!(compared, ["figure 7", "figure 9", "figure 10, formulas (1) to (8)", "figure 15"]);
}

#[test]
fn a_drawing_of_somebody_else_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["figure_12.svg", "field_1.png"] {
        let page = folder.path().join(name.replace('.', "_"));
        fs::create_dir(&page).unwrap();
        fs::write(page.join(name), "mine").unwrap();
        let reason = format!("{name}: is not a file of hoverlock paper");
        refused(folder.path(), &["paper", "--out", page.to_str().unwrap()], &reason);
        assert_eq!(fs::read_to_string(page.join(name)).unwrap(), "mine");
    }
}

#[test]
fn bad_places_and_telemetry_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    refused(folder, &["scene", "moon"], "moon");
    refused(folder, &["scene", "town", "--look", "80,0,0"], "80 degrees off the vertical");
    refused(folder, &["scene", "town", "--at", "1,2"], "three numbers");
    refused(folder, &["scene", "town", "--at", "0,0,-5"], "above the ground");
    refused(folder, &["scene", "town", "--at", "0,0,nan"], "nan");
    refused(folder, &["scene", "town", "--out", "town.bmp"], "png");
    assert_eq!(hoverlock(folder, &["scene", "field"]).status.code(), Some(0), "the folder of the default is made");
    fs::rename(folder.join("out/scene.png"), folder.join("field.png")).unwrap();
    fs::remove_dir(folder.join("out")).unwrap();
    fs::copy(folder.join("field.png"), folder.join("ground.png")).unwrap();
    let house = "[[building]]\nat_m = [0, 0]\nsize_m = [9, 9]\nheight_m = 60\n";
    fs::write(folder.join("own.toml"), format!("[ground.picture]\nfile = \"ground.png\"\ntexel_m = 0.1\n{house}"))
        .unwrap();
    refused(folder, &["scene", "own.toml", "--out", "ground.png"], "ground.png: is one of the inputs");
    refused(folder, &["scene", "own.toml", "--out", "own.png"], "the surface there is 60.0 m high");
    refused(folder, &["orthophoto", "field.png", "--telemetry", "absent.csv"], "absent.csv");
    fs::write(folder.join("row.csv"), "roll_deg,pitch_deg,yaw_deg,range_m,fov_deg\n95,0,0,50,50\n").unwrap();
    refused(folder, &["orthophoto", "field.png", "--telemetry", "row.csv"], "row");
    assert!(!folder.join("out").exists(), "a refused command leaves nothing");
}
