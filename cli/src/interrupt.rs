//! Removes incomplete files and folders, and ends the programs that were started, when SIGINT (Ctrl-C) or SIGTERM ends
//! the command.
//!
//! SIGBUS is handled too: Verilator's FST writer maps its files into memory, and the system sends this signal if the
//! disk is full.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, Once, PoisonError};

use rustix::process::{Pid, Signal as ProcessSignal, kill_process};
use signal_hook::consts::{SIGBUS, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use signal_hook::low_level;

use crate::output::MARKER;

/// Temporary files and folders, the latest last.
static PENDING: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

static WATCH: Once = Once::new();

/// A file or folder that a signal removes while this value exists.
pub struct Pending(PathBuf);

impl Pending {
    /// Registers `path` for removal by a signal; dropping the value ends that.
    pub fn new(path: &Path) -> Self {
        begin();
        // The current folder may change, so the path is made absolute now.
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        PENDING.lock().unwrap_or_else(PoisonError::into_inner).push(path.clone());
        Self(path)
    }
}

impl Drop for Pending {
    fn drop(&mut self) {
        let mut pending = PENDING.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = pending.iter().position(|path| *path == self.0) {
            pending.remove(at);
        }
    }
}

/// Installs the handlers, once. If that fails, files are still removed in all cases but a signal.
pub fn begin() {
    WATCH.call_once(|| drop(watch()));
}

/// Ends the programs that this process started, and those that they started: compilers, Verilator, solvers. A shell
/// sends SIGINT to all of them, but `kill` and job control reach the command alone.
pub fn end_descendants() {
    let parents: Vec<(i32, i32)> =
        fs::read_dir("/proc").into_iter().flatten().flatten().filter_map(|entry| parent(&entry.path())).collect();
    let mut found = vec![std::process::id() as i32];
    let mut next = 0;
    while let Some(&id) = found.get(next) {
        found.extend(parents.iter().filter(|(_, parent)| *parent == id).map(|(child, _)| *child));
        next += 1;
    }
    for id in found.into_iter().skip(1).filter_map(Pid::from_raw) {
        let _ = kill_process(id, ProcessSignal::TERM);
    }
}

/// Returns the ids of a process and of its parent, from its folder in `/proc`.
fn parent(folder: &Path) -> Option<(i32, i32)> {
    let id = folder.file_name()?.to_str()?.parse().ok()?;
    let stat = fs::read_to_string(folder.join("stat")).ok()?;
    // The name of the program is in parentheses and may contain anything; state and parent follow it.
    let parent = stat.rsplit_once(')')?.1.split_whitespace().nth(1)?.parse().ok()?;
    Some((id, parent))
}

/// Removes a file if its folder has no other.
pub fn remove_if_alone(file: &Path) {
    let others = file.parent().and_then(|folder| fs::read_dir(folder).ok()).map_or(0, Iterator::count);
    if others == 1 {
        let _ = fs::remove_file(file);
    }
}

fn remove(paths: &[PathBuf]) {
    let (markers, files): (Vec<_>, Vec<_>) =
        paths.iter().filter(|path| !path.is_dir()).partition(|path| path.ends_with(MARKER));
    for path in files {
        // The FST writer's second file.
        let mut hierarchy = path.clone().into_os_string();
        hierarchy.push(".hier");
        let _ = (fs::remove_file(path), fs::remove_file(hierarchy));
    }
    markers.iter().for_each(|marker| remove_if_alone(marker));
    // Only those that are empty go; they are registered from the deepest up.
    for path in paths.iter().filter(|path| path.is_dir()) {
        let _ = fs::remove_dir(path);
    }
}

fn watch() -> io::Result<()> {
    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    std::thread::Builder::new().name("signals".into()).spawn(move || {
        for signal in signals.forever() {
            // The lock is held to the end, so that nothing new is registered and created after the removal.
            let pending = PENDING.lock().unwrap_or_else(PoisonError::into_inner);
            remove(&pending);
            end_descendants();
            let _ = low_level::emulate_default_handler(signal);
            drop(pending);
        }
    })?;
    let full = || {
        // This waits for no lock and does nothing but system calls on short-lived strings. The thread that faulted is
        // inside the FST writer, which holds no lock of the allocator while it stores samples.
        if let Ok(pending) = PENDING.try_lock() {
            remove(&pending);
        }
        let message =
            b"hoverlock: the waves cannot be written: no space left on the disk; free some, or lower --wave-cycles\n";
        let _ = rustix::io::write(rustix::stdio::stderr(), message);
        low_level::exit(2);
    };
    // SAFETY: the handler ends the process. It reads a list behind `try_lock`, so it cannot wait for the thread it
    // interrupted; what it allocates may meet an allocator in the middle of its work only where that work itself
    // faulted, and then the process was lost in any case.
    unsafe { low_level::register(SIGBUS, full) }?;
    Ok(())
}
