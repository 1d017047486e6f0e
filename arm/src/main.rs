//! `hoverlock-nav`: messages from a file or the standard input, JSON lines on the standard output.

use hoverlock_arm::framing::Decoder;
use hoverlock_arm::navigator::{Navigator, Next};
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const HELP: &str = "\
hoverlock-nav [STREAM]

Displacement from a reference, in metres, out of feature records and telemetry.
Reads messages from the file STREAM, or from the standard input; writes one JSON line per frame.
Ends with status 0 at the end of the stream or the command to stop, with status 2 where the input cannot be
read or the FPGA is not the one this program was built for.

Example: hoverlock-nav flight.hln > track.jsonl
";

/// Bytes of the longest line, and more.
const LINE: usize = 4096;

fn main() -> ExitCode {
    let mut arguments = std::env::args_os().skip(1);
    let stream = arguments.next().map(PathBuf::from);
    if stream.as_deref().is_some_and(|argument| argument == Path::new("--help")) {
        print!("{HELP}");
        return ExitCode::SUCCESS;
    }
    let unknown = stream.as_deref().is_some_and(|argument| argument.as_os_str().as_encoded_bytes().starts_with(b"-"));
    if unknown || arguments.next().is_some() {
        eprintln!("hoverlock-nav: one argument at most, the file of a stream; see hoverlock-nav --help");
        return ExitCode::from(2);
    }
    match run(stream.as_deref()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("hoverlock-nav: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(stream: Option<&Path>) -> Result<(), String> {
    match stream {
        Some(path) => {
            let mut file = File::open(path).map_err(|error| format!("{}: {error}", path.display()))?;
            navigate(&mut file)
        }
        None => navigate(&mut io::stdin().lock()),
    }
}

fn navigate(source: &mut impl Read) -> Result<(), String> {
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
            if next.map_err(|error| error.to_string())? == Next::Stop || written.is_err() {
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
