//! `hoverlock <verb>`: the workspace from the command line.
//!
//! Results go to stdout, as one JSON object with `--json`; progress and diagnostics go to stderr. The exit status is 0
//! if the checks of the verb pass, 1 if one fails, and 2 for bad usage or input, with one line that names the cause.
#![allow(rustdoc::broken_intra_doc_links, reason = "documentation of arguments is help text, with a[i] for an index")]

mod choice;
mod coeffs;
mod cosim;
mod design;
mod design_file;
mod doctor;
mod explore;
mod fault;
mod formal;
mod hover;
mod interrupt;
mod matching;
mod orthophoto;
mod output;
mod paper;
mod picture;
mod progress;
mod random_sweep;
mod report;
mod rtl;
mod rtl_level;
mod scene;
mod shell;
mod sim;
mod sweep;

use std::process::ExitCode;
use std::sync::LazyLock;

use anyhow::{Result, bail};
use clap::error::ErrorKind;
use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use hoverlock_reports::provenance::COMMIT;

/// Version, and commit of the sources.
static VERSION: LazyLock<String> = LazyLock::new(|| format!("{} ({COMMIT})", env!("CARGO_PKG_VERSION")));

/// Co-design of a hover drift sensor: floating point, fixed point and RTL, and what each step costs.
#[derive(Parser)]
#[command(name = "hoverlock", version = VERSION.as_str(), max_term_width = 110, arg_required_else_help = false)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    Coeffs(coeffs::Args),
    Completions(shell::CompletionsArgs),
    Cosim(cosim::Args),
    Design(design_file::Args),
    Doctor(doctor::Args),
    Explore(explore::Args),
    Fault(Box<fault::Args>),
    Formal(formal::Args),
    Hover(hover::Args),
    Man(shell::ManArgs),
    Match(matching::Args),
    Orthophoto(orthophoto::Args),
    Paper(paper::Args),
    Report(report::Args),
    Rtl(rtl::Args),
    Scene(scene::Args),
    Sim(sim::Args),
    Sweep(sweep::Args),
}

/// The result of a verb's checks.
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

/// Returns the definition of the command line. Each paragraph of a verb's help is one line, for clap to wrap.
fn definition() -> clap::Command {
    let command = Cli::command();
    let verbs: Vec<String> = command.get_subcommands().map(|verb| verb.get_name().to_owned()).collect();
    verbs.into_iter().fold(command, |command, verb| command.mut_subcommand(verb, unwrapped))
}

/// Joins the lines of each paragraph of a verb's help; lines that are indented stay as they are.
fn unwrapped(mut verb: clap::Command) -> clap::Command {
    if let Some(text) = verb.get_about().map(ToString::to_string) {
        verb = verb.about(text.replace('\n', " ").trim_end_matches('.').to_owned());
    }
    if let Some(text) = verb.get_long_about().map(ToString::to_string) {
        verb = verb.long_about(join_paragraphs(&text));
    }
    verb
}

fn join_paragraphs(text: &str) -> String {
    let continues = |line: &str| line.starts_with(|char: char| !char.is_whitespace());
    let mut joined = String::new();
    let mut after_text = false;
    for line in text.lines() {
        if !joined.is_empty() {
            joined.push(if after_text && continues(line) { ' ' } else { '\n' });
        }
        joined.push_str(line);
        after_text = continues(line);
    }
    joined
}

fn main() -> ExitCode {
    interrupt::begin();
    let parsed = definition().try_get_matches().and_then(|matches| Cli::from_arg_matches(&matches));
    let outcome = parsed.map_or_else(usage, |cli| match cli.verb {
        Verb::Coeffs(args) => coeffs::run(&args),
        Verb::Completions(args) => shell::completions(&args),
        Verb::Cosim(args) => cosim::run(&args),
        Verb::Design(args) => design_file::run(&args),
        Verb::Doctor(args) => doctor::run(&args),
        Verb::Explore(args) => explore::run(&args),
        Verb::Fault(args) => fault::run(&args),
        Verb::Formal(args) => formal::run(&args),
        Verb::Hover(args) => hover::run(&args),
        Verb::Man(args) => shell::man(&args),
        Verb::Match(args) => matching::run(&args),
        Verb::Orthophoto(args) => orthophoto::run(&args),
        Verb::Paper(args) => paper::run(&args),
        Verb::Report(args) => report::run(&args),
        Verb::Rtl(args) => rtl::run(&args),
        Verb::Scene(args) => scene::run(&args),
        Verb::Sim(args) => sim::run(&args),
        Verb::Sweep(args) => sweep::run(&args),
    });
    match outcome {
        Ok(Verdict::Pass) => ExitCode::SUCCESS,
        Ok(Verdict::Fail) => ExitCode::from(1),
        Err(error) => {
            output::say(&message(&error));
            ExitCode::from(2)
        }
    }
}

/// Returns the message of an error with its causes, in one line. A cause that is in the message already is left out.
fn message(error: &anyhow::Error) -> String {
    error.chain().fold(String::new(), |text, cause| {
        // Libraries put each entry of a list on a line of its own, two columns in.
        let cause = cause.to_string().replace(":\n  ", ": ").replace("\n  ", "; ");
        match text.as_str() {
            "" => cause,
            text if text.contains(&cause) => text.to_owned(),
            text => format!("{text}: {cause}"),
        }
    })
}

/// Prints help and version, and turns an error of usage into one line with clap's suggestion.
fn usage(error: clap::Error) -> Result<Verdict> {
    if !error.use_stderr() {
        output::print(&error.render().ansi().to_string())?;
        return Ok(Verdict::Pass);
    }
    let text = error.render().to_string();
    let alone = [ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand, ErrorKind::MissingSubcommand];
    if alone.contains(&error.kind()) {
        let usage = text.lines().find_map(|line| line.trim().strip_prefix("Usage: ")).unwrap_or("hoverlock <COMMAND>");
        bail!("a verb is missing: {usage}; see --help");
    }
    let reason: Vec<&str> = text.lines().take_while(|line| !line.is_empty()).map(str::trim).collect();
    let tip: String =
        text.lines().filter_map(|line| line.trim().strip_prefix("tip: ")).map(|tip| format!("; {tip}")).collect();
    bail!("{}{tip}; see --help", reason.join(" ").trim_start_matches("error: "));
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context as _;
    use std::io;

    #[test]
    fn a_cause_is_not_repeated() {
        let full = || io::Error::other("the disk is full");
        let once = anyhow::Error::new(full()).context("a.png: cannot be written");
        assert_eq!(message(&once), "a.png: cannot be written: the disk is full");
        let twice =
            Err::<(), _>(full()).context("a.png: cannot be written: the disk is full; name another").unwrap_err();
        assert_eq!(message(&twice), "a.png: cannot be written: the disk is full; name another");
    }

    #[test]
    fn a_list_of_a_library_is_one_line() {
        let error = anyhow::anyhow!("verilator found errors:\n  a.v:1: x\n  b.v:2: y").context("sim");
        assert_eq!(message(&error), "sim: verilator found errors: a.v:1: x; b.v:2: y");
    }

    #[test]
    fn a_paragraph_of_help_is_one_line_and_a_list_is_not() {
        assert_eq!(join_paragraphs("a\nb\n\nIt is\n  y = x\nand\nz"), "a b\n\nIt is\n  y = x\nand z");
        for verb in definition().get_subcommands() {
            let about = verb.get_about().map(ToString::to_string).unwrap_or_default();
            assert!(!about.contains('\n') && !about.ends_with('.'), "{}: {about}", verb.get_name());
            let text = verb.get_long_about().map(ToString::to_string).unwrap_or_default();
            let lines: Vec<&str> = text.lines().collect();
            let is_text = |line: &str| line.starts_with(|char: char| !char.is_whitespace());
            assert!(lines.windows(2).all(|pair| !(is_text(pair[0]) && is_text(pair[1]))), "{}", verb.get_name());
        }
    }
}
