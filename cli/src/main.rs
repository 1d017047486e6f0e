//! `hoverlock <verb>`: the workspace from the command line.
//!
//! Results go to stdout, one JSON object with `--json`; progress and diagnostics go to stderr. The exit status is 0 where
//! the verb's gates hold, 1 where they do not, and 2 for bad usage or input, with one line that says what, where and why.

mod doctor;
mod output;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Co-design of a hover drift sensor: floating point, fixed point and RTL, and what each step costs.
#[derive(Parser)]
#[command(name = "hoverlock", version, max_term_width = 110)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    Doctor(doctor::Args),
}

/// Whether a verb's gates hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Verdict {
    Pass,
    Fail,
}

impl From<bool> for Verdict {
    fn from(pass: bool) -> Self {
        if pass { Self::Pass } else { Self::Fail }
    }
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().verb {
        Verb::Doctor(args) => doctor::run(&args),
    };
    match outcome {
        Ok(Verdict::Pass) => ExitCode::SUCCESS,
        Ok(Verdict::Fail) => ExitCode::from(1),
        Err(error) => {
            eprintln!("hoverlock: {error:#}");
            ExitCode::from(2)
        }
    }
}
