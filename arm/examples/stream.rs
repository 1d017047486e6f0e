//! Writes a stream from a folder of frames: `cargo run --release -p hoverlock-arm --example stream -- FOLDER STREAM`.

#[path = "../tests/support/mod.rs"]
mod support;

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    let [folder, stream] = &arguments[..] else {
        eprintln!("usage: stream FOLDER STREAM; the folder has frames NN.png and pseudo_gt.csv");
        return ExitCode::from(2);
    };
    let made = support::sequence(Path::new(folder)).and_then(|source| std::fs::write(stream, source.messages.concat()));
    match made {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("stream: {}: {error}", folder.display());
            ExitCode::from(2)
        }
    }
}
