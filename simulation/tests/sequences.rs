//! Random sequences of frames from the ports against `bit_true`.
//!
//! 200 frames every day, 10 000 in the long test, and fewer of the other shipped designs. `HOVERLOCK_SEQUENCE_SEED`
//! begins elsewhere. A failure is shrunk and printed as a JSON text; saved to a file, `HOVERLOCK_SEQUENCE=file cargo
//! test -p hoverlock-simulation --test sequences` plays it again.

mod port_bench;
mod sequence;

use std::{sync::LazyLock, time::Instant};

use hoverlock_simulation::Simulator;
use port_bench::of_other_designs;
use sequence::{Sequence, campaign, shrink::shrunk};

static SIMULATOR: LazyLock<Simulator> = LazyLock::new(|| Simulator::new().expect("Verilator builds the top"));

fn exact(frames: usize) {
    if let Some(path) = std::env::var_os("HOVERLOCK_SEQUENCE") {
        let text = std::fs::read_to_string(&path).expect("the file of the sequence is read");
        let sequence: Sequence = serde_json::from_str(&text).expect("a sequence as it was printed");
        eprintln!("{:?}", sequence.play(&SIMULATOR).unwrap_or_else(|failure| panic!("{failure}")));
        return;
    }
    let seed = std::env::var("HOVERLOCK_SEQUENCE_SEED").ok().map_or(1, |seed| seed.parse().expect("a number"));
    let begin = Instant::now();
    match campaign(&SIMULATOR, seed, frames) {
        Ok(tally) => {
            eprintln!("{tally:?} in {:.0} s", begin.elapsed().as_secs_f64());
            assert!(tally.frames as usize > frames / 2 && tally.records > 0 && tally.dropped > 0, "{tally:?}");
        }
        Err(failed) => {
            let short = shrunk(&failed.sequence, 150, |sequence| sequence.play(&SIMULATOR).is_err());
            let last = short.play(&SIMULATOR).expect_err("what was shrunk fails");
            panic!("seed {}: {}\nshrunk: {last}\n{}", failed.sequence.seed, failed.what, short.text());
        }
    }
}

#[test]
fn two_hundred_frames_are_exact() {
    exact(200);
}

fn frames_of_other_designs_are_exact(frames: usize) {
    let found = of_other_designs(|simulator| match campaign(simulator, 1, frames) {
        Ok(tally) if tally.records > 0 => {
            eprintln!("{tally:?}");
            Vec::new()
        }
        Ok(tally) => vec![format!("{tally:?}")],
        Err(failed) => vec![format!("seed {}: {}", failed.sequence.seed, failed.what)],
    });
    assert_eq!(found, [""; 0]);
}

#[test]
fn fifty_frames_of_each_other_design_are_exact() {
    frames_of_other_designs_are_exact(50);
}

#[test]
#[ignore = "long: 1000 frames of each design, about 120 million cycles"]
fn a_thousand_frames_of_each_other_design_are_exact() {
    frames_of_other_designs_are_exact(1000);
}

#[test]
#[ignore = "long: 10 000 frames, about 400 million cycles"]
fn ten_thousand_frames_are_exact() {
    exact(10_000);
}
