//! The command under damaged pictures, configurations and arguments: it answers or refuses, whatever it is given.
//!
//! A run fails where the command panics or is ended by a signal, takes more than five seconds, or needs more than a
//! gigabyte (the limit of its address space, so an allocation above it aborts). One seed gives one sequence of inputs;
//! `HOVERLOCK_FUZZ_SEED` chooses another, `HOVERLOCK_FUZZ_SECONDS` says how long it runs (20). What fails is kept in
//! the folder for temporary files, and its command is printed.

use std::fs;
use std::io::{Cursor, Read as _};
use std::os::unix::process::ExitStatusExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgb};

/// What a run may take.
const MAX_RUN_TIME: Duration = Duration::from_secs(5);
/// Address space, kB.
const MEMORY: u32 = 1_000_000;

/// A sequence of numbers with a seed (Steele, Lea and Flood 2014: SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit.max(1) as u64) as usize
    }

    fn pick<'a, T: ?Sized>(&mut self, from: &[&'a T]) -> &'a T {
        from[self.below(from.len())]
    }
}

fn setting(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// Small pictures of every format and depth.
fn seeds() -> Vec<(&'static str, Vec<u8>)> {
    let value =
        |x: u32, y: u32| (x.wrapping_mul(2_654_435_761).wrapping_add(y.wrapping_mul(40_503) * (x + 3)) >> 9) as u8;
    let grey = DynamicImage::ImageLuma8(ImageBuffer::from_fn(90, 80, |x, y| Luma([value(x / 5, y / 5)])));
    let rgb = DynamicImage::ImageRgb8(ImageBuffer::from_fn(90, 80, |x, y| Rgb([value(x, y), x as u8, y as u8])));
    let rgba = DynamicImage::ImageRgba8(rgb.to_rgba8());
    let deep = DynamicImage::ImageRgb16(rgb.to_rgb16());
    let mut all = Vec::new();
    for picture in [&grey, &rgb, &rgba, &deep, &DynamicImage::ImageLuma16(grey.to_luma16())] {
        for (ending, format) in [
            ("png", ImageFormat::Png),
            ("jpg", ImageFormat::Jpeg),
            ("pnm", ImageFormat::Pnm),
            ("tiff", ImageFormat::Tiff),
            ("webp", ImageFormat::WebP),
            ("bmp", ImageFormat::Bmp),
        ] {
            let mut bytes = Cursor::new(Vec::new());
            if picture.write_to(&mut bytes, format).is_ok() {
                all.push((ending, bytes.into_inner()));
            }
        }
    }
    all.push(("pgm", [&b"P2 90 80 255\n"[..], "17 200 ".repeat(3600).as_bytes()].concat()));
    let cmyk = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cmyk.jpg");
    all.push(("jpg", fs::read(cmyk).unwrap()));
    all
}

/// Numbers at the edges of what a header can say.
const EDGES: [u32; 10] = [0, 1, 7, 255, 20_000, 30_000, 65_535, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff];

/// Damages a picture: bytes, pieces, sizes in the header, checksums put right again now and then.
fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..1 + random.below(4) {
        if bytes.is_empty() {
            return;
        }
        let length = bytes.len();
        // Most of what decides stands in the header.
        let at = if random.below(2) == 0 { random.below(length.min(64)) } else { random.below(length) };
        match random.below(8) {
            0 => bytes[at] ^= 1 << random.below(8),
            1 => bytes[at] = random.next() as u8,
            2 => bytes.truncate(at),
            3 => {
                let edge = EDGES[random.below(EDGES.len())];
                let edge = if random.below(2) == 0 { edge.to_be_bytes() } else { edge.to_le_bytes() };
                let end = (at + 4).min(length);
                bytes[at..end].copy_from_slice(&edge[..end - at]);
            }
            4 => {
                let many = random.below(200).min(length - at);
                let piece = bytes[at..at + many].to_vec();
                let to = random.below(length);
                bytes.splice(to..to, piece);
            }
            5 => {
                bytes.drain(at..(at + random.below(60)).min(length));
            }
            6 => {
                let more = random.below(3000);
                bytes.extend((0..more).map(|i| (i * 37) as u8));
            }
            _ => large_header(bytes, random),
        }
    }
    if bytes.starts_with(b"\x89PNG") && random.below(2) == 0 {
        mend_png(bytes);
    }
}

/// A well-formed header of a huge picture.
fn large_header(bytes: &mut Vec<u8>, random: &mut Random) {
    let sides = [5_000u32, 7_000, 20_000, 65_000];
    let (width, height) = (sides[random.below(4)], sides[random.below(4)]);
    if bytes.starts_with(b"\x89PNG") && bytes.len() > 24 {
        bytes[16..20].copy_from_slice(&width.to_be_bytes());
        bytes[20..24].copy_from_slice(&height.to_be_bytes());
        mend_png(bytes);
    } else if bytes.starts_with(b"BM") && bytes.len() > 26 {
        bytes[18..22].copy_from_slice(&width.to_le_bytes());
        bytes[22..26].copy_from_slice(&height.to_le_bytes());
    } else if bytes.starts_with(b"P") {
        let rest = bytes.get(13..).unwrap_or_default().to_vec();
        let kind = 2 + random.below(5);
        *bytes = [format!("P{kind} {width} {height} 255\n").as_bytes(), &rest].concat();
    } else if let Some(at) = bytes.windows(2).position(|pair| pair[0] == 0xff && matches!(pair[1], 0xc0 | 0xc2))
        && at + 9 <= bytes.len()
    {
        bytes[at + 5..at + 7].copy_from_slice(&(height as u16).to_be_bytes());
        bytes[at + 7..at + 9].copy_from_slice(&(width as u16).to_be_bytes());
    }
}

/// Gives every chunk of a PNG the checksum of what it holds now.
fn mend_png(bytes: &mut [u8]) {
    let mut at = 8;
    while let Some(length) = bytes.get(at..at + 4) {
        let length = u32::from_be_bytes([length[0], length[1], length[2], length[3]]) as usize;
        let Some(sum) = at.checked_add(8).and_then(|start| start.checked_add(length)) else { return };
        if sum + 4 > bytes.len() {
            return;
        }
        let crc = !bytes[at + 4..sum].iter().fold(!0u32, |crc, &byte| {
            let step = |crc: u32, _| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
            (0..8).fold(crc ^ u32::from(byte), step)
        });
        bytes[sum..sum + 4].copy_from_slice(&crc.to_be_bytes());
        at = sum + 4;
    }
}

/// A word that an option may get.
fn word(random: &mut Random) -> String {
    const WORDS: [&str; 30] = [
        "0",
        "1",
        "-1",
        "2.0",
        "3.2",
        "nan",
        "inf",
        "-inf",
        "1e308",
        "1e-308",
        "18446744073709551615",
        "4294967296",
        "-9223372036854775808",
        "",
        " ",
        "\n",
        "ü",
        "%s%n",
        "../../..",
        "/dev/null",
        "/dev/zero",
        "-",
        "--",
        "--help",
        "true",
        "u16.2",
        "u99.99",
        "[1,2,3]",
        "homography",
        "first-order",
    ];
    match random.below(4) {
        0 => format!("{}", random.next() as i64 >> random.below(64)),
        1 => format!("{:e}", f64::from_bits(random.next())),
        _ => WORDS[random.below(WORDS.len())].to_owned(),
    }
}

/// The arguments of one run.
fn arguments(random: &mut Random, good: &Path, bad: &Path, folder: &Path) -> Vec<String> {
    let path = |path: &Path| path.display().to_string();
    let mut args: Vec<String> = match random.below(10) {
        // Mostly pictures: that is where strangers write the input.
        0..=4 => vec!["match".into(), path(bad), path(good)],
        5 => vec!["match".into(), path(good), path(bad), "--features".into(), "fixed".into()],
        6 => {
            const KEYS: [&str; 11] = [
                "width",
                "height",
                "sigmas",
                "state",
                "dog_bits",
                "look_ahead",
                "look_ahead_error",
                "pixel",
                "ring_radii",
                "record_fifo",
                "x",
            ];
            let mut args = vec!["report".into(), path(bad), "--out".into(), path(&folder.join("none/of/it"))];
            for _ in 0..1 + random.below(3) {
                args.push("--config".into());
                args.push(format!("{}={}", KEYS[random.below(KEYS.len())], word(random)));
            }
            // A picture too small for a report: what is tried is the configuration.
            args[1] = path(&folder.join("small.pgm"));
            args
        }
        7 => {
            let toml = folder.join("design.toml");
            let keys = ["width", "sigmas", "state", "dog_bits", "look_ahead"];
            let mut text = String::new();
            for _ in 0..random.below(5) {
                text += &format!("{} = {}\n", random.pick(&keys), word(random));
            }
            let mut bytes = text.into_bytes();
            if random.below(2) == 0 {
                damage(&mut bytes, random);
            }
            fs::write(&toml, bytes).unwrap();
            vec!["report".into(), path(&folder.join("small.pgm")), "--config".into(), path(&toml)]
        }
        8 => {
            let options =
                ["--sigma", "--method", "--order", "--fit", "--frac-bits", "--look-ahead", "--look-ahead-error"];
            let methods = ["first-order", "alvarez-mazorra", "deriche", "yvv95", "vyv"];
            let sigma = format!("{}", 0.5 + random.below(1000) as f64 / 37.0);
            let mut args =
                vec!["coeffs".into(), "--sigma".into(), sigma, "--method".into(), random.pick(&methods).into()];
            for _ in 0..random.below(3) {
                args.push(format!("{}={}", random.pick(&options), word(random)));
            }
            args
        }
        _ => {
            let options =
                ["--frames", "--stall", "--seed", "--sink-opens", "--wave", "--wave-cycles", "--max-megapixels"];
            let mut args = vec!["sim".into(), path(bad)];
            for _ in 0..random.below(3) {
                args.push(format!("{}={}", random.pick(&options), word(random)));
            }
            args
        }
    };
    if random.below(2) == 0 {
        args.push("--json".into());
    }
    if random.below(20) == 0 {
        let at = random.below(args.len() + 1);
        args.insert(at, word(random));
    }
    args.retain(|arg| !arg.contains('\0'));
    args
}

/// Runs the command within its limits; why it failed.
fn run(args: &[String], folder: &Path) -> Result<(), String> {
    let mut child = Command::new("/bin/sh")
        .args(["-c", &format!("ulimit -v {MEMORY}; ulimit -c 0; exec \"$0\" \"$@\"")])
        .arg(env!("CARGO_BIN_EXE_hoverlock"))
        .args(args)
        .current_dir(folder)
        // No Verilator and no Yosys: what is tried is the command.
        .env("PATH", "")
        .env("RAYON_NUM_THREADS", "2")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| error.to_string())?;
    let mut stderr = child.stderr.take().ok_or("no stderr")?;
    let reader = std::thread::spawn(move || {
        let mut said = Vec::new();
        let _ = stderr.by_ref().take(1 << 20).read_to_end(&mut said);
        String::from_utf8_lossy(&said).into_owned()
    });
    let started = Instant::now();
    let status = loop {
        match child.try_wait().map_err(|error| error.to_string())? {
            Some(status) => break status,
            None if started.elapsed() > MAX_RUN_TIME => {
                let _ = (child.kill(), child.wait());
                return Err(format!("it took more than {MAX_RUN_TIME:?}"));
            }
            None => std::thread::sleep(Duration::from_millis(2)),
        }
    };
    let said = reader.join().map_err(|_| "the reader panicked")?;
    match (status.code(), status.signal()) {
        (Some(0..=2), _) if !said.contains("panicked") => {}
        (code, signal) => return Err(format!("status {code:?}, signal {signal:?}\n{said}")),
    }
    let lines: Vec<&str> = said.lines().filter(|line| line.starts_with("hoverlock: ")).collect();
    if status.code() == Some(2) && lines.len() != said.lines().count() {
        return Err(format!("a refusal that is not in separate lines:\n{said}"));
    }
    Ok(())
}

#[test]
#[ignore = "20 seconds of random input, or as many as HOVERLOCK_FUZZ_SECONDS says"]
fn no_input_brings_the_command_down() {
    let (seed, seconds) = (setting("HOVERLOCK_FUZZ_SEED", 1), setting("HOVERLOCK_FUZZ_SECONDS", 20));
    let mut random = Random(seed);
    let seeds = seeds();
    let folder = tempfile::tempdir().unwrap();
    let good = folder.path().join("good.png");
    fs::write(&good, &seeds[0].1).unwrap();
    fs::write(folder.path().join("small.pgm"), [&b"P5 70 70 255\n"[..], &[9; 4900]].concat()).unwrap();
    let started = Instant::now();
    let (mut runs, mut failed) = (0u64, Vec::new());
    while started.elapsed() < Duration::from_secs(seconds) {
        let (ending, mut bytes) = seeds[random.below(seeds.len())].clone();
        damage(&mut bytes, &mut random);
        let bad: PathBuf = folder.path().join(format!("bad.{ending}"));
        fs::write(&bad, &bytes).unwrap();
        let args = arguments(&mut random, &good, &bad, folder.path());
        runs += 1;
        if let Err(reason) = run(&args, folder.path()) {
            let kept = std::env::temp_dir().join(format!("hoverlock-fuzz-{seed}-{runs}.{ending}"));
            fs::write(&kept, &bytes).unwrap();
            eprintln!("run {runs}: hoverlock {args:?} (bad is kept as {}): {reason}", kept.display());
            failed.push(runs);
        }
        assert!(failed.len() < 20, "seed {seed}: {failed:?}");
    }
    eprintln!("seed {seed}: {runs} runs in {seconds} s, {} failed", failed.len());
    assert!(failed.is_empty(), "seed {seed}: runs {failed:?}");
}
