//! Simulated cycles per second of CPU time, each way of driving against the plain Verilator loop in C++.
//!
//! `cargo bench -p hoverlock-harness` prints medians of several runs and their ratio to the C++ loop of the same run,
//! for a small design and for the Hoverlock top; with `-- small` or `-- top` for that one alone.

mod measure;
mod small;
mod top;

use hoverlock_harness::Error;

fn main() -> Result<(), Error> {
    let folder = tempfile::tempdir().map_err(|e| Error::bench(e.to_string()))?;
    let wanted: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let is_wanted = |part: &str| wanted.is_empty() || wanted.iter().any(|name| name == part);
    if is_wanted("small") {
        println!("A small stream design\n");
        small::table(folder.path())?;
        println!();
    }
    if is_wanted("top") {
        println!("The Hoverlock top\n");
        top::table(folder.path())?;
        println!();
    }
    if is_wanted("small") {
        small::start_times(folder.path())?;
    }
    Ok(())
}
