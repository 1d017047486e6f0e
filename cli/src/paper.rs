//! `hoverlock paper`: the published description, regenerated.

use std::path::PathBuf;

use anyhow::Result;
use clap::ValueHint;
use hoverlock_paper::page::{FILES, Numbers, PAGE, all_files};
use hoverlock_paper::{Item, items};
use indicatif::{ProgressBar, ProgressStyle};

use crate::Verdict;
use crate::output::{Batch, Folder, print, print_json, shown};
use crate::progress::LogLines;

/// Regenerate each figure and claim of the published description from today's code, on one page.
///
/// Each item says what is stated there, what was found here, whether the statement holds, and which command states the
/// numbers. Writes index.html, paper.json, each drawing as SVG, and the pictures that the commands read. A statement
/// that does not hold is a result, not an error: the status is 0 if the page was made.
///
/// Examples:
///   hoverlock paper
///   hoverlock paper --out paper --json
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// The folder for the page
    #[arg(long, value_name = "DIR", default_value = "out/paper", value_hint = ValueHint::DirPath)]
    out: PathBuf,
    /// One JSON object on stdout: commit items[] of number title stated found holds evidence commands[] only_here
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<Verdict> {
    let folder = Folder::of(&args.out, "paper", &FILES)?;
    let bar = ProgressBar::new(0).with_style(ProgressStyle::with_template("figures {bar:30} {pos}/{len}")?);
    let lines = LogLines::new();
    let items = items(|step, steps| {
        bar.set_length(steps as u64);
        bar.set_position(step as u64);
        lines.count(&bar, "groups of figures");
    })?;
    bar.finish_and_clear();
    let mut batch = Batch::default();
    for (name, bytes) in all_files(&items)? {
        batch.add(&args.out.join(name), &bytes)?;
    }
    batch.keep()?;
    drop(folder);
    if args.json {
        print_json(&Numbers::of(&items))?;
    } else {
        print(&format!("{}{}\n", table(&items), shown(&args.out.join(PAGE))))?;
    }
    Ok(Verdict::Pass)
}

/// Returns a line for each item: verdict, number, title.
fn table(items: &[Item]) -> String {
    let verdict = |item: &Item| match item.holds {
        Some(true) => "holds",
        Some(false) => "does not hold",
        None => "shown",
    };
    items.iter().map(|item| format!("{:<14} {}: {}\n", verdict(item), item.number, item.title)).collect()
}
