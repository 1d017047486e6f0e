//! `hoverlock <verb>`: the workspace from the command line.
//!
//! Results go to stdout, one JSON object with `--json`; progress and diagnostics go to stderr. The exit status is 0 where
//! the verb's gates hold, 1 where they do not, and 2 for bad usage or input, with one line that says what, where and why.

mod coeffs;
mod doctor;
mod matching;
mod output;
mod picture;
mod report;
mod rtl;
mod rtl_level;
mod sim;

use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::{Parser, Subcommand};

/// Co-design of a hover drift sensor: floating point, fixed point and RTL, and what each step costs.
#[derive(Parser)]
#[command(name = "hoverlock", version, max_term_width = 110, arg_required_else_help = false)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    Coeffs(coeffs::Args),
    Doctor(doctor::Args),
    Match(matching::Args),
    Report(report::Args),
    Rtl(rtl::Args),
    Sim(sim::Args),
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
    let outcome = Cli::try_parse().map_or_else(usage, |cli| match cli.verb {
        Verb::Coeffs(args) => coeffs::run(&args),
        Verb::Doctor(args) => doctor::run(&args),
        Verb::Match(args) => matching::run(&args),
        Verb::Report(args) => report::run(&args),
        Verb::Rtl(args) => rtl::run(&args),
        Verb::Sim(args) => sim::run(&args),
    });
    match outcome {
        Ok(Verdict::Pass) => ExitCode::SUCCESS,
        Ok(Verdict::Fail) => ExitCode::from(1),
        Err(error) => {
            eprintln!("hoverlock: {error:#}");
            ExitCode::from(2)
        }
    }
}

/// Help and version as they are; an error of usage as one line, like every other.
fn usage(error: clap::Error) -> Result<Verdict> {
    if !error.use_stderr() {
        output::print(&error.render().to_string())?;
        return Ok(Verdict::Pass);
    }
    let text = error.render().to_string();
    let reason: Vec<&str> = text.lines().take_while(|line| !line.is_empty()).map(str::trim).collect();
    bail!("{}; see --help", reason.join(" ").trim_start_matches("error: "));
}
