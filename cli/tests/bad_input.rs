//! Every verb, given something broken: one clear line that names it, exit status 2, no panic, nothing half-written.
//! Given something merely unusual (16-bit, RGBA, CMYK, another size): a right answer.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use image::{DynamicImage, ImageBuffer, Luma};
use tempfile::TempDir;

/// A 320 x 240 texture of smooth spots: bilinear interpolation of hashed lattice values, 7 px apart.
fn texture(x: u32, y: u32) -> u8 {
    // Mixed between the products: a linear hash repeats nearly, and ground that repeats is refused.
    let mixed = |v: u32| (v ^ (v >> 15)).wrapping_mul(0x27D4_EB2F);
    let lattice = |i: u32, j: u32| {
        let seed = i.wrapping_mul(0x9E37_79B9).wrapping_add(j.wrapping_mul(0x85EB_CA6B));
        f64::from(mixed(mixed(seed)) >> 24)
    };
    let (i, j, u, v) = (x / 7, y / 7, f64::from(x % 7) / 7.0, f64::from(y % 7) / 7.0);
    let along = |j: u32| lattice(i, j) * (1.0 - u) + lattice(i + 1, j) * u;
    (along(j) * (1.0 - v) + along(j + 1) * v) as u8
}

/// A folder of pictures, good and bad.
struct Pictures(TempDir);

impl Pictures {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let gray = DynamicImage::ImageLuma8(ImageBuffer::from_fn(320, 240, |x, y| Luma([texture(x, y)])));
        gray.save(at("gray.png")).unwrap();
        DynamicImage::ImageLuma16(gray.to_luma16()).save(at("sixteen.png")).unwrap();
        DynamicImage::ImageRgb8(gray.to_rgb8()).save(at("rgb.png")).unwrap();
        DynamicImage::ImageRgba8(gray.to_rgba8()).save(at("rgba.png")).unwrap();
        gray.crop_imm(3, 2, 300, 220).save(at("other size.png")).unwrap();
        fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cmyk.jpg"), at("cmyk.jpg")).unwrap();
        let whole = fs::read(at("gray.png")).unwrap();
        fs::write(at("truncated.png"), &whole[..whole.len() / 2]).unwrap();
        let whole = fs::read(at("cmyk.jpg")).unwrap();
        fs::write(at("truncated.jpg"), &whole[..whole.len() * 3 / 4]).unwrap();
        fs::write(at("text.png"), "This is not a picture.\n").unwrap();
        fs::write(at("empty.png"), "").unwrap();
        fs::create_dir(at("folder.png")).unwrap();
        let flat = |w, h, v: u8| DynamicImage::ImageLuma8(ImageBuffer::from_pixel(w, h, Luma([v])));
        flat(1, 1, 9).save(at("one.png")).unwrap();
        flat(320, 240, 128).save(at("constant.png")).unwrap();
        let strip = DynamicImage::ImageLuma8(ImageBuffer::from_fn(20_000, 20, |x, y| Luma([texture(x, y)])));
        strip.save(at("strip.png")).unwrap();
        Self(folder)
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).display().to_string()
    }
}

fn hoverlock(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hoverlock")).args(args).output().unwrap()
}

/// Status 2, nothing on stdout, and the last line of stderr is the one diagnostic, which holds `named`.
#[track_caller]
fn assert_refused(args: &[&str], named: &str) {
    let output = hoverlock(args);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{args:?}\n{stderr}");
    assert!(output.stdout.is_empty(), "{args:?} wrote to stdout");
    assert!(!stderr.contains("panicked"), "{args:?}\n{stderr}");
    let diagnostics: Vec<&str> = stderr.lines().filter(|line| line.starts_with("hoverlock: ")).collect();
    assert_eq!(diagnostics.len(), 1, "{args:?}\n{stderr}");
    assert!(diagnostics[0].contains(named), "{args:?}: `{named}` is not named\n{stderr}");
}

/// Status 0 or 1 (a verdict, not a refusal), one JSON object on stdout, no panic.
#[track_caller]
fn assert_answered(args: &[&str]) -> serde_json::Value {
    let output = hoverlock(args);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{args:?}: {:?}\n{stderr}", output.status);
    assert!(!stderr.contains("panicked"), "{args:?}\n{stderr}");
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{args:?}: {error}\n{stderr}"))
}

const BAD_PICTURES: [&str; 9] = [
    "missing.png",
    "folder.png",
    "text.png",
    "truncated.png",
    "truncated.jpg",
    "empty.png",
    "one.png",
    "constant.png",
    "strip.png",
];

/// Those among them that are good files. Among several pictures they are listed and judge nothing.
const UNFIT_PICTURES: [&str; 3] = ["one.png", "constant.png", "strip.png"];

/// A folder that cannot be made, because a file stands where its parent would be.
fn unwritable(pictures: &Pictures) -> String {
    PathBuf::from(pictures.path("gray.png")).join("out").display().to_string()
}

#[test]
fn match_refuses_bad_pictures_on_either_side() {
    let pictures = Pictures::new();
    let good = pictures.path("gray.png");
    for name in BAD_PICTURES {
        let bad = pictures.path(name);
        assert_refused(&["match", &bad, &good], name);
        assert_refused(&["match", &good, &bad, "--json"], name);
    }
    assert_refused(&["match", &good, &good, "--overlay", &unwritable(&pictures)], "gray.png/out");
}

#[test]
fn match_answers_unusual_pictures() {
    let pictures = Pictures::new();
    let good = pictures.path("gray.png");
    for name in ["sixteen.png", "rgb.png", "rgba.png"] {
        let answer = assert_answered(&["match", &good, &pictures.path(name), "--json"]);
        assert_eq!(answer["ok"], true, "{name}: {answer}");
        // The samples are the same (257 v in 16 bits, luma of equal channels), so the motion is none.
        for axis in 0..2 {
            let moved = answer["displacement_px"][axis].as_f64().unwrap();
            assert!(moved.abs() < 1e-6, "{name}: {answer}");
        }
    }
    // The other one was cut out at (3, 2), so the ground at its centre (149.5, 109.5) lies at (152.5, 111.5) of this.
    let answer = assert_answered(&["match", &good, &pictures.path("other size.png"), "--json"]);
    assert_eq!(answer["ok"], true, "{answer}");
    for (axis, expected) in [-3.0, -2.0].into_iter().enumerate() {
        let moved = answer["displacement_px"][axis].as_f64().unwrap();
        assert!((moved - expected).abs() < 0.1, "{answer}");
    }
    assert_answered(&["match", &pictures.path("cmyk.jpg"), &pictures.path("cmyk.jpg"), "--json"]);
}

#[test]
fn report_refuses_bad_pictures_and_leaves_nothing_behind() {
    let pictures = Pictures::new();
    let out = pictures.path("out");
    for name in BAD_PICTURES {
        assert_refused(&["report", &pictures.path(name), "--out", &out], name);
        if !UNFIT_PICTURES.contains(&name) {
            assert_refused(&["report", &pictures.path("gray.png"), &pictures.path(name), "--out", &out], name);
        }
        assert!(!Path::new(&out).exists(), "{name} left {out} behind");
    }
    let unfit = UNFIT_PICTURES.map(|name| pictures.path(name));
    for name in UNFIT_PICTURES {
        assert_refused(&["report", &unfit[0], &unfit[1], &unfit[2], "--out", &out], &format!("{name}: unfit"));
        assert!(!Path::new(&out).exists(), "{name} left {out} behind");
    }
    assert_refused(&["report", &pictures.path("gray.png"), "--out", &unwritable(&pictures)], "gray.png/out");
    assert_refused(&["report"], "");
}

#[test]
fn report_lists_unfit_pictures_beside_one_that_is_fit() {
    let pictures = Pictures::new();
    let [gray, out] = [pictures.path("gray.png"), pictures.path("out")];
    let unfit = UNFIT_PICTURES.map(|name| pictures.path(name));
    let answer = assert_answered(&["report", &unfit[0], &unfit[1], &gray, &unfit[2], "--json", "--out", &out]);
    let judged = |row: &serde_json::Value| row["picture"].is_null() || row["picture"] == "gray";
    assert!(answer["bounds"].as_array().unwrap().iter().all(judged), "{answer}");
    for (name, reason) in UNFIT_PICTURES.into_iter().zip(["79 x 79", "every pixel", "79 x 79"]) {
        let listed = answer["unfit"].as_array().unwrap().iter();
        let of: Vec<_> = listed.filter(|unfit| unfit["picture"].as_str().unwrap().ends_with(name)).collect();
        assert!(of.len() == 1 && of[0]["reason"].as_str().unwrap().contains(reason), "{name}: {of:?}");
    }
}

#[test]
fn report_refuses_bad_configurations() {
    let pictures = Pictures::new();
    let good = pictures.path("gray.png");
    let out = pictures.path("out");
    for (setting, named) in [
        ("sigmas=[nan, 3.2, 5.12]", "sigmas"),
        ("sigmas=[0.0, 3.2, 5.12]", "sigmas"),
        ("nonsense=1", "nonsense"),
        ("dog_bits", "--config: dog_bits is neither KEY=VALUE nor a configuration file"),
    ] {
        assert_refused(&["report", &good, "--out", &out, "--config", setting], named);
    }
    let file = pictures.path("design.toml");
    fs::write(&file, "sigmas = [nan, 3.2, 5.12]\n").unwrap();
    assert_refused(&["report", &good, "--out", &out, "--config", &file], "design.toml");
    assert_refused(&["report", &good, "--out", &out, "--config", &pictures.path("none.toml")], "none.toml");
    assert!(!Path::new(&out).exists());
}

#[test]
fn coeffs_refuses_numbers_without_meaning() {
    let pictures = Pictures::new();
    for sigma in ["0", "-1", "1e9", "nan", "inf"] {
        let value = format!("--sigma={sigma}");
        assert_refused(&["coeffs", &value], "sigma");
    }
    for bits in ["0", "200"] {
        assert_refused(&["coeffs", "--sigma", "2.0", "--frac-bits", bits], "frac");
    }
    assert_refused(&["coeffs", "--sigma", "2.0", "--method", "deriche", "--order", "9"], "order");
    assert_refused(&["coeffs", "--sigma", "2.0", "--out", &unwritable(&pictures)], "gray.png/out");
}

#[test]
fn sim_refuses_bad_pictures_and_options_before_it_simulates() {
    let pictures = Pictures::new();
    let good = pictures.path("gray.png");
    for name in BAD_PICTURES {
        assert_refused(&["sim", &good, &pictures.path(name)], name);
    }
    let wave = format!("{}.fst", unwritable(&pictures));
    for (option, value, named) in [
        ("--frames", "0", "frames"),
        ("--stall", "0.96", "0.96"),
        ("--stall", "-1", "--stall"),
        ("--stall", "nan", "NaN"),
        ("--sink-opens", "soon", "sink-opens"),
        ("--wave", &wave, "gray.png/out.fst"),
        ("--wave", &pictures.path("run.txt"), ".fst or .vcd"),
        ("--wave", &pictures.path("folder.fst"), "folder.fst"),
        ("--wave-cycles", "0", "wave-cycles"),
        ("--wave-from", "7", "--wave"),
    ] {
        if value.ends_with("folder.fst") {
            fs::create_dir(value).unwrap();
        }
        assert_refused(&["sim", &good, &format!("{option}={value}")], named);
    }
    // Nothing is left beside the pictures: neither waves nor what was begun of them.
    let folder = Path::new(&good).parent().unwrap();
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let left: Vec<_> = names.filter(|name| name.starts_with(".hoverlock") || name.starts_with("run.")).collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn usage_errors_have_status_2() {
    for args in [&["no-such-verb"][..], &["match", "one picture"], &["coeffs"], &["doctor", "--no-such-option"]] {
        assert_eq!(hoverlock(args).status.code(), Some(2), "{args:?}");
    }
}
