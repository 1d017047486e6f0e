//! `hoverlock-nav`: reads messages from a file or standard input, writes JSON lines to standard output.

use hoverlock_arm::bus::Mapped;
use hoverlock_arm::framing::Decoder;
use hoverlock_arm::hardware::{Fpga, Size};
use hoverlock_arm::line::Line;
use hoverlock_arm::mavlink;
use hoverlock_arm::message::PIXELS;
use hoverlock_arm::navigator::{Navigator, Next};
use hoverlock_arm::setup::{Thresholds, set_up};
use hoverlock_reference::motion::mark::{Part, mark};
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const HELP: &str = "\
hoverlock-nav [--mavlink FILE] [--camera FILE]
              [--registers DEVICE[@OFFSET] --size WIDTHxHEIGHT [--thresholds FINE,COARSE]] [STREAM]

Estimates the displacement from a reference, in metres, from feature records and telemetry.
Reads messages from the file STREAM or from standard input; writes one JSON line per frame.

  --mavlink FILE       writes each estimate as a MAVLink 2 message ODOMETRY; FILE may be the autopilot's serial port
  --camera FILE        writes the ARINC 429 words for the commands wide and narrow, four bytes each, least significant
                       first
  --registers DEVICE[@OFFSET]
                       configures and enables the FPGA first: DEVICE is /dev/uioN, or /dev/mem with the byte address
                       of the registers as OFFSET
  --size WIDTHxHEIGHT  frame size to configure, in pixels
  --thresholds FINE,COARSE
                       fixed thresholds, in 0.5 DN; without them the FPGA adjusts its thresholds automatically

Exits with status 0 at the end of the stream or at the command to stop, and with status 2 if the input cannot be read
or the FPGA is not the one this program was built for.

Example: hoverlock-nav flight.hln > track.jsonl
Example: hoverlock-nav --registers /dev/mem@0xff200000 --size 1024x768 < /run/records > track.jsonl
";

/// Initial capacity for a line of output, above the longest one.
const LINE_CAPACITY_BYTES: usize = 4096;

/// The parsed command line.
#[derive(Default)]
struct Arguments {
    stream: Option<PathBuf>,
    camera: Option<PathBuf>,
    mavlink: Option<PathBuf>,
    /// Path of the device and byte offset of the registers in it.
    registers: Option<(PathBuf, u64)>,
    size: Option<Size>,
    thresholds: Option<[u32; 2]>,
    help: bool,
}

fn main() -> ExitCode {
    let outcome = parse_arguments(std::env::args_os().skip(1)).and_then(|arguments| run(&arguments));
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("hoverlock-nav: {error}");
            ExitCode::from(2)
        }
    }
}

fn parse_arguments(mut given: impl Iterator<Item = OsString>) -> Result<Arguments, String> {
    let mut arguments = Arguments::default();
    while let Some(argument) = given.next() {
        let mut value = |what| given.next().ok_or_else(|| missing_value(&argument, what));
        match argument.to_str() {
            Some("--help") => arguments.help = true,
            Some("--camera") => arguments.camera = Some(value("a file")?.into()),
            Some("--mavlink") => arguments.mavlink = Some(value("a file")?.into()),
            Some("--registers") => arguments.registers = Some(parse_device(value("a device")?)?),
            Some("--size") => {
                let [width, height] = parse_pair(&argument, value("WIDTHxHEIGHT")?, 'x', "WIDTHxHEIGHT")?;
                arguments.size =
                    Some(Size::new(&Fpga::default(), width, height).map_err(|error| format!("--size: {error}"))?);
            }
            Some("--thresholds") => {
                let thresholds = parse_pair(&argument, value("FINE,COARSE")?, ',', "FINE,COARSE")?;
                if !thresholds.iter().all(|threshold| (1..=32767).contains(threshold)) {
                    return Err(format!("--thresholds: {thresholds:?} are not both from 1 to 32767"));
                }
                arguments.thresholds = Some(thresholds);
            }
            _ if argument.as_encoded_bytes().starts_with(b"-") => {
                return Err(format!("unknown option {}; see hoverlock-nav --help", argument.display()));
            }
            _ if arguments.stream.replace(PathBuf::from(&argument)).is_some() => {
                return Err("one stream at most; see hoverlock-nav --help".into());
            }
            _ => {}
        }
    }
    match &arguments {
        Arguments { registers: Some(_), size: None, .. } => {
            Err("--registers needs --size WIDTHxHEIGHT; see hoverlock-nav --help".into())
        }
        Arguments { registers: None, size, thresholds, .. } if size.is_some() || thresholds.is_some() => {
            Err("--size and --thresholds need --registers; see hoverlock-nav --help".into())
        }
        _ => Ok(arguments),
    }
}

fn missing_value(option: &OsStr, what: &str) -> String {
    format!("{} takes {what}; see hoverlock-nav --help", option.display())
}

/// Parses `DEVICE` or `DEVICE@OFFSET`.
fn parse_device(given: OsString) -> Result<(PathBuf, u64), String> {
    let Some((device, offset)) = given.to_str().and_then(|text| text.rsplit_once('@')) else {
        return Ok((given.into(), 0));
    };
    let parsed = match offset.strip_prefix("0x") {
        Some(digits) => u64::from_str_radix(digits, 16),
        None => offset.parse(),
    };
    let offset =
        parsed.map_err(|_| format!("--registers: `{offset}` after the @ is not a byte offset such as 0xff200000"))?;
    Ok((device.into(), offset))
}

/// Parses two numbers with a separator `between`; `form` names the expected form in the error.
fn parse_pair(option: &OsStr, given: OsString, between: char, form: &str) -> Result<[u32; 2], String> {
    let parsed = given.to_str().and_then(|text| {
        let (first, second) = text.split_once(between)?;
        Some([first.parse().ok()?, second.parse().ok()?])
    });
    parsed.ok_or_else(|| format!("{}: `{}` is not {form}", option.display(), given.display()))
}

fn run(arguments: &Arguments) -> Result<(), String> {
    if arguments.help {
        print!("{HELP}");
        return Ok(());
    }
    let named = |path: &Path, error: io::Error| format!("{}: {error}", path.display());
    // Output files are truncated last: not if the stream or the FPGA cannot be used.
    let opened = |path: &PathBuf| {
        let stream = File::open(path).map_err(|error| named(path, error))?;
        let about = stream.metadata().map_err(|error| named(path, error))?;
        if about.is_dir() {
            return Err(format!("{}: is a folder; give a stream of framed messages", path.display()));
        }
        Ok((stream, (about.dev(), about.ino())))
    };
    let stream = arguments.stream.as_ref().map(opened).transpose()?;
    if let (Some((device, offset)), Some(size)) = (&arguments.registers, arguments.size) {
        let thresholds = arguments
            .thresholds
            .map_or_else(Thresholds::default, |[fine, coarse]| Thresholds::Fixed([fine, coarse, 1]));
        let mut bus = Mapped::open(device, *offset).map_err(|error| error.to_string())?;
        set_up(&mut bus, &Fpga::default(), size, thresholds)
            .map_err(|error| format!("{}: {error}", device.display()))?;
    }
    let created = |path: &Option<PathBuf>| {
        let Some(path) = path else { return Ok(None) };
        let there = fs::metadata(path).ok().map(|there| (there.dev(), there.ino()));
        if there.is_some() && there == stream.as_ref().map(|(_, inode)| *inode) {
            return Err(format!("{}: is the stream; name another file", path.display()));
        }
        File::create(path).map(Some).map_err(|error| named(path, error))
    };
    let camera = created(&arguments.camera)?;
    let autopilot = created(&arguments.mavlink)?.map(|file| (file, mavlink::OdometryStream::default()));
    let output = Output {
        text: Vec::with_capacity(LINE_CAPACITY_BYTES),
        lines: io::stdout().lock(),
        autopilot,
        written: Ok(()),
    };
    match stream {
        Some((mut stream, _)) => navigate(&mut stream, camera, output),
        None => navigate(&mut io::stdin().lock(), camera, output),
    }
}

/// The destinations of the results.
struct Output {
    text: Vec<u8>,
    lines: io::StdoutLock<'static>,
    autopilot: Option<(File, mavlink::OdometryStream)>,
    /// The first error; nothing is written after it.
    written: Result<(), String>,
}

impl Output {
    fn write(&mut self, line: &Line) {
        if self.written.is_ok() {
            self.written = self.try_write(line);
        }
    }

    fn try_write(&mut self, line: &Line) -> Result<(), String> {
        line.write(&mut self.text);
        self.lines.write_all(&self.text).map_err(|error| format!("writing lines: {error}"))?;
        if let Some((file, stream)) = &mut self.autopilot
            && let Some(message) = stream.message(line)
        {
            file.write_all(message).map_err(|error| format!("writing to the autopilot: {error}"))?;
        }
        Ok(())
    }
}

fn navigate(source: &mut impl Read, mut camera: Option<File>, mut output: Output) -> Result<(), String> {
    let mut decoder = Decoder::default();
    let mut navigator = Navigator::default();
    let mut messages = false;
    'stream: loop {
        mark(Part::Transfer);
        let more = decoder.read(source).map_err(|error| format!("reading the stream: {error}"))?;
        while let Some(raw) = decoder.message() {
            messages = true;
            if raw.kind != PIXELS {
                mark(Part::Frame);
            }
            let next = navigator.take(&raw, &mut |line| {
                output.write(line);
                mark(Part::End);
                mark(Part::Frame);
            });
            mark(Part::Transfer);
            let next = next.map_err(|error| error.to_string())?;
            if let (Some(word), Some(camera)) = (navigator.camera_word().map_err(|e| e.to_string())?, &mut camera) {
                camera.write_all(&word.to_le_bytes()).map_err(|error| format!("writing to the camera: {error}"))?;
            }
            if next == Next::Stop || output.written.is_err() {
                break 'stream;
            }
        }
        if !more {
            break;
        }
    }
    navigator.finish(&mut |line| output.write(line));
    output.written?;
    output.lines.flush().map_err(|error| format!("writing lines: {error}"))?;
    if !messages && decoder.skipped() > 0 {
        return Err(format!("no message in {} bytes; give a stream of framed messages", decoder.skipped()));
    }
    let counts = navigator.counts();
    eprintln!(
        "hoverlock-nav: {} frames; {} messages repeated, {} refused, {} bytes skipped",
        counts.frames,
        counts.repeated,
        counts.refused,
        decoder.skipped()
    );
    Ok(())
}
