//! Sets `HOVERLOCK_COMMIT` to `git describe` of the sources, or to `no repository`.

use std::process::Command;

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    String::from_utf8(output.stdout).ok().map(|text| text.trim().to_owned()).filter(|text| !text.is_empty())
}

fn main() {
    // With optional locks `git describe` would rewrite the index, and every build would start another one.
    let commit = git(&["--no-optional-locks", "describe", "--always", "--dirty", "--abbrev=12"]);
    println!("cargo::rustc-env=HOVERLOCK_COMMIT={}", commit.as_deref().unwrap_or("no repository"));
    for file in ["HEAD", "logs/HEAD", "index"] {
        if let Some(path) = git(&["rev-parse", "--git-path", file]) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    // The first edit of a tracked file makes the sources dirty. Later ones change nothing until the index changes, so
    // they start no build of this crate and of those above it.
    if commit.is_some_and(|commit| !commit.ends_with("-dirty")) {
        let tracked = git(&["ls-files", "-z", "--", ":/"]).unwrap_or_default();
        tracked.split_terminator('\0').for_each(|path| println!("cargo::rerun-if-changed={path}"));
    }
}
