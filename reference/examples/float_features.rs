//! Extracts the float features of one picture repeatedly on one thread and prints one JSON object: the number of
//! features and the seconds of each run. `benches/vs_orb.py` runs it alternately with OpenCV's ORB.
//!
//! Usage: `cargo run --release --example float_features -- IMAGE [RUNS]`

use std::{process::ExitCode, time::Instant};

use hoverlock_pictures::Picture;
use hoverlock_reference::features::extractor::Selection;
use hoverlock_reference::features::fast::FastExtractor;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next();
    let runs = arguments.next().map_or(Some(20), |n| n.parse().ok());
    let (Some(path), Some(runs @ 1..)) = (path, runs) else {
        eprintln!("usage: float_features IMAGE [RUNS]");
        return ExitCode::from(2);
    };
    match measure(&path, runs) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

/// Prints the timings of `runs` extractions.
fn measure(path: &str, runs: usize) -> Result<(), Box<dyn std::error::Error>> {
    let frame = Picture::open(path)?.crop(1024, 768);
    let mut extractor = FastExtractor::new(Selection::default())?;
    // The first run sizes the buffers.
    let features = extractor.extract(&frame.luma).len();
    let seconds = (0..runs).map(|_| {
        let start = Instant::now();
        std::hint::black_box(extractor.extract(std::hint::black_box(&frame.luma)));
        format!("{:.6}", start.elapsed().as_secs_f64())
    });
    let seconds: Vec<String> = seconds.collect();
    println!(r#"{{"features": {features}, "seconds": [{}]}}"#, seconds.join(", "));
    Ok(())
}
