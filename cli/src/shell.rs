//! `hoverlock completions` and `hoverlock man`: completion scripts and manual pages, generated from the definition of
//! the command line.

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap_complete::Shell;
use clap_mangen::Man;

use crate::output::{Batch, Folder, print};
use crate::{Verdict, definition};

/// Print the completion script of a shell
///
/// Example: hoverlock completions bash > ~/.local/share/bash-completion/completions/hoverlock
#[derive(clap::Args)]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Write the manual pages, one for each verb
///
/// Example: hoverlock man ~/.local/share/man/man1
#[derive(clap::Args)]
pub struct ManArgs {
    /// The folder to write hoverlock.1, hoverlock-sim.1 and the others into
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

pub fn completions(args: &CompletionsArgs) -> Result<Verdict> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut definition(), "hoverlock", &mut script);
    print(&String::from_utf8_lossy(&script))?;
    Ok(Verdict::Pass)
}

pub fn man(args: &ManArgs) -> Result<Verdict> {
    let mut command = definition().disable_help_subcommand(true);
    command.build();
    let mut pages = Vec::new();
    render(&command, &mut pages)?;
    let folder = Folder::new(&args.folder)?;
    let mut batch = Batch::default();
    for (name, page) in &pages {
        batch.add(&args.folder.join(name), page)?;
    }
    batch.keep()?;
    drop(folder);
    print(&format!("{} pages in {}\n", pages.len(), crate::output::shown(&args.folder)))?;
    Ok(Verdict::Pass)
}

/// Renders the page of a command, and those of its verbs.
fn render(command: &clap::Command, pages: &mut Vec<(String, Vec<u8>)>) -> Result<()> {
    let name = command.get_display_name().unwrap_or_else(|| command.get_name()).to_owned();
    let mut page = Vec::new();
    Man::new(command.clone()).render(&mut page).with_context(|| format!("the page of {name} cannot be made"))?;
    pages.push((format!("{name}.1"), page));
    command.get_subcommands().try_for_each(|verb| render(verb, pages))
}
