//! `hoverlock-nav`: messages from a file or the standard input, JSON lines on the standard output.

use hoverlock_arm::framing::Decoder;
use hoverlock_arm::navigator::{Navigator, Next};
use std::ffi::OsString;
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const HELP: &str = "\
hoverlock-nav [--camera FILE] [STREAM]

Displacement from a reference, in metres, out of feature records and telemetry.
Reads messages from the file STREAM, or from the standard input; writes one JSON line per frame.
With --camera the ARINC 429 words of the commands wide and narrow go to FILE, four bytes each, least significant first.
Ends with status 0 at the end of the stream or the command to stop, with status 2 where the input cannot be
read or the FPGA is not the one this program was built for.

Example: hoverlock-nav flight.hln > track.jsonl
";

/// Bytes of the longest line, and more.
const LINE: usize = 4096;

/// What the command line names.
#[derive(Default)]
struct Arguments {
    stream: Option<PathBuf>,
    camera: Option<PathBuf>,
    help: bool,
}

fn main() -> ExitCode {
    let outcome = arguments(std::env::args_os().skip(1)).and_then(|arguments| run(&arguments));
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("hoverlock-nav: {error}");
            ExitCode::from(2)
        }
    }
}

fn arguments(mut given: impl Iterator<Item = OsString>) -> Result<Arguments, String> {
    let mut arguments = Arguments::default();
    while let Some(argument) = given.next() {
        if argument == "--help" {
            arguments.help = true;
        } else if argument == "--camera" {
            let file = given.next().ok_or("--camera takes a file; see hoverlock-nav --help")?;
            arguments.camera = Some(file.into());
        } else if argument.as_encoded_bytes().starts_with(b"-") {
            return Err(format!("unknown option {}; see hoverlock-nav --help", argument.display()));
        } else if arguments.stream.replace(argument.into()).is_some() {
            return Err("one stream at most; see hoverlock-nav --help".into());
        }
    }
    Ok(arguments)
}

fn run(arguments: &Arguments) -> Result<(), String> {
    if arguments.help {
        print!("{HELP}");
        return Ok(());
    }
    let named = |path: &Path, error: io::Error| format!("{}: {error}", path.display());
    // The stream first: a camera's file is not emptied for a stream that is not there.
    let stream =
        arguments.stream.as_ref().map(|path| File::open(path).map_err(|error| named(path, error))).transpose()?;
    let camera = arguments.camera.as_ref().map(|path| File::create(path).map_err(|error| named(path, error)));
    let mut camera = camera.transpose()?;
    match stream {
        Some(mut stream) => navigate(&mut stream, camera.as_mut()),
        None => navigate(&mut io::stdin().lock(), camera.as_mut()),
    }
}

fn navigate(source: &mut impl Read, mut camera: Option<&mut File>) -> Result<(), String> {
    let mut decoder = Decoder::default();
    let mut navigator = Navigator::default();
    let mut text = Vec::with_capacity(LINE);
    let mut output = io::stdout().lock();
    let mut written = Ok(());
    'stream: loop {
        let more = decoder.read(source).map_err(|error| format!("reading the stream: {error}"))?;
        while let Some(raw) = decoder.message() {
            let next = navigator.take(&raw, &mut |line| {
                line.write(&mut text);
                if written.is_ok() {
                    written = output.write_all(&text);
                }
            });
            let next = next.map_err(|error| error.to_string())?;
            if let (Some(word), Some(camera)) = (navigator.camera_word().map_err(|e| e.to_string())?, &mut camera) {
                camera.write_all(&word.to_le_bytes()).map_err(|error| format!("writing to the camera: {error}"))?;
            }
            if next == Next::Stop || written.is_err() {
                break 'stream;
            }
        }
        if !more {
            break;
        }
    }
    navigator.finish(&mut |line| {
        line.write(&mut text);
        if written.is_ok() {
            written = output.write_all(&text);
        }
    });
    written.and_then(|()| output.flush()).map_err(|error| format!("writing lines: {error}"))?;
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
