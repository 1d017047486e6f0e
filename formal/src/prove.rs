//! Running a claim: its proof, its covers and its mutants.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::Serialize;

use crate::claim::{Claim, Mutant};
use crate::engine::{Answer, EngineError, Question, Solved, Solver, at_path, build_model, solve};
use crate::replay;

/// The reason why a task has no result.
#[derive(Debug, thiserror::Error)]
pub enum ProveError {
    /// Yosys or the solver failed.
    #[error("{claim}: {error}")]
    Engine {
        /// Name of the claim.
        claim: String,
        /// Error of the engine.
        error: EngineError,
    },
    /// The claim is not proved without a mutation, so a proof that fails with one means nothing.
    #[error("{claim}: not proved without a mutation: correct the claim")]
    Unproved {
        /// Name of the claim.
        claim: String,
    },
    /// The text of a mutant does not occur exactly once.
    #[error("{claim}: mutant {number}: its text occurs {found} times in {file}, not once; correct the claim's file")]
    Mutant {
        /// Name of the claim.
        claim: String,
        /// Number of the mutant, from 1.
        number: usize,
        /// Name of the source file.
        file: String,
        /// Number of occurrences.
        found: usize,
    },
}

impl ProveError {
    /// Returns `true` if the task is about covers and the properties have none.
    pub fn is_without_covers(&self) -> bool {
        matches!(self, Self::Engine { error: EngineError::Empty("cover"), .. })
    }
}

/// A task of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Task {
    /// Prove the claim.
    Proof,
    /// Reach all covers.
    Cover,
    /// Try to prove the claim with this mutant, counted from 0.
    Mutant(usize),
}

/// The status of a finished task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// The claim is proved for all time.
    Proved,
    /// The claim is proved for `depth` steps from reset.
    Bounded,
    /// All covers are reached.
    Reached,
    /// The mutant violates a property in a run from reset.
    Refuted,
    /// The mutant makes the induction fail.
    Unproved,
    /// A property is violated, a cover is not reached, or a mutant passes.
    Failed,
    /// The time limit was reached.
    Timeout,
}

/// The result of a task.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outcome {
    /// Name of the claim, followed by ` cover` or ` mutant N` for these tasks.
    pub name: String,
    /// Status of the task.
    pub status: Status,
    /// `true` if the status is the expected one.
    pub pass: bool,
    /// Wall time of the solver, s.
    pub seconds: f64,
    /// Processor time of the solver, s.
    pub processor_seconds: f64,
    /// Peak memory of the solver, MiB.
    pub memory_mib: f64,
    /// Properties that failed, and the step.
    pub detail: String,
    /// Waveform of the counter-example (VCD).
    pub trace: Option<PathBuf>,
    /// Rust test that replays the counter-example.
    pub replay: Option<PathBuf>,
    /// Inputs of the counter-example, one line per step.
    pub steps: Vec<String>,
}

/// The folders, the time limit and the solver for a task.
#[derive(Debug, Clone, Copy)]
pub struct Place<'a> {
    /// Folder of the Verilog sources that claims name.
    pub sources: &'a Path,
    /// Folder for waveforms and replays; created if needed.
    pub out: &'a Path,
    /// Time limit of each question to the solver.
    pub limit: Duration,
    /// The solver.
    pub solver: Solver,
}

/// A source file with a fault in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FaultySource {
    /// Name of the file that is replaced.
    pub file: String,
    /// Complete text with the fault.
    pub text: String,
}

/// Runs a task of a claim. A failed task leaves its waveform, and a failed proof also a replay, in `place.out`.
///
/// # Errors
/// If Yosys or the solver is missing or rejects the Verilog, or the text of a mutant does not occur exactly once.
pub fn run(claim: &Claim, task: Task, place: &Place) -> Result<Outcome, ProveError> {
    let changed = match task {
        Task::Mutant(at) => Some(mutate(claim, at, place.sources)?),
        Task::Proof | Task::Cover => None,
    };
    run_with(claim, task, changed.as_ref(), place)
}

/// Tries to prove a claim with a fault in one of its sources. The status is `Proved` or `Bounded` if the claim holds
/// with the fault (it passes then), and `Refuted` or `Unproved` if the proof detects it.
///
/// # Errors
/// If Yosys or the solver is missing or rejects the Verilog.
pub fn holds_with(claim: &Claim, fault: &FaultySource, place: &Place) -> Result<Outcome, ProveError> {
    let outcome = run_with(claim, Task::Proof, Some(fault), place)?;
    let status = match (outcome.status, outcome.detail.starts_with("induction")) {
        (Status::Failed, true) => Status::Unproved,
        (Status::Failed, false) => Status::Refuted,
        (status, _) => status,
    };
    Ok(Outcome { status, ..outcome })
}

/// Inserts a mutant of the claim into its source.
fn mutate(claim: &Claim, at: usize, folder: &Path) -> Result<FaultySource, ProveError> {
    let Mutant { file, from, to } = &claim.mutants[at];
    let path = folder.join(file);
    let wrong = |error| ProveError::Engine { claim: claim.name.clone(), error };
    let text = fs::read_to_string(&path).map_err(at_path(&path)).map_err(wrong)?;
    match text.matches(from.as_str()).count() {
        1 => Ok(FaultySource { file: file.clone(), text: text.replacen(from.as_str(), to, 1) }),
        found => Err(ProveError::Mutant { claim: claim.name.clone(), number: at + 1, file: file.clone(), found }),
    }
}

/// Runs a task over the sources, one of which may be replaced.
fn run_with(claim: &Claim, task: Task, changed: Option<&FaultySource>, place: &Place) -> Result<Outcome, ProveError> {
    let wrong = |error| ProveError::Engine { claim: claim.name.clone(), error };
    let work = tempfile::tempdir().map_err(at_path(&std::env::temp_dir())).map_err(wrong)?;
    let sources = prepare(claim, changed, place.sources, work.path())?;
    let system = build_model(claim, &sources, work.path()).map_err(wrong)?;
    let trace = work.path().join("trace.vcd");
    let mut total = Solved { answer: Answer::Passed, time: Duration::ZERO, processor: Duration::ZERO, memory: 0 };
    let mut put = |question| -> Result<Answer, ProveError> {
        // A run that is found needs no second opinion, and Z3 may take minutes to find one.
        let is_search = matches!(question, Question::Assumptions(_) | Question::Cover(_));
        let solver = if is_search { Solver::default() } else { place.solver };
        let solved = solve(solver, &system, question, place.limit, &trace).map_err(wrong)?;
        total.time += solved.time;
        total.processor += solved.processor;
        total.memory = total.memory.max(solved.memory);
        Ok(solved.answer)
    };
    let (answer, base) = match task {
        Task::Cover => (put(Question::Cover(claim.cover))?, true),
        Task::Proof | Task::Mutant(_) => {
            let steps = if let Task::Mutant(_) = task { claim.fault } else { claim.depth + 1 };
            // A fault leaves the assumptions, which the proof without it has checked.
            let satisfied = match (task, changed) {
                (Task::Proof, None) => put(Question::Assumptions(steps))?,
                _ => Answer::Passed,
            };
            // A mutant is first searched for a run from reset, which is easier to understand than a failed induction.
            let base = if satisfied == Answer::Passed { put(Question::Base(steps))? } else { satisfied };
            match base {
                Answer::Passed if !claim.bounded => (put(Question::Step(claim.depth))?, false),
                answer => (answer, true),
            }
        }
    };
    let proved = if claim.bounded { Status::Bounded } else { Status::Proved };
    let (status, pass) = match (task, &answer) {
        (Task::Proof, Answer::Passed) => (proved, true),
        (Task::Cover, Answer::Passed) => (Status::Reached, true),
        (Task::Mutant(_), Answer::Passed) | (Task::Proof | Task::Cover, Answer::Failed { .. }) => {
            (Status::Failed, false)
        }
        (Task::Mutant(_), Answer::Failed { .. }) => (if base { Status::Refuted } else { Status::Unproved }, true),
        (_, Answer::TimedOut) => (Status::Timeout, false),
    };
    let detail = match (&answer, status) {
        (Answer::Failed { names, step }, Status::Failed) if task == Task::Cover => {
            format!("not reached within {} steps: {}", step.max(&claim.cover), names.join(", "))
        }
        (Answer::Failed { names, step }, _) if base => format!("step {step}: {}", names.join(", ")),
        (Answer::Failed { names, .. }, _) => format!("induction: {}", names.join(", ")),
        (Answer::Passed, Status::Failed) => "the proof does not detect this fault".to_owned(),
        _ => String::new(),
    };
    let name = match task {
        Task::Proof => claim.name.clone(),
        Task::Cover => format!("{} cover", claim.name),
        Task::Mutant(at) => format!("{} mutant {}", claim.name, at + 1),
    };
    let kept = if status == Status::Failed && trace.exists() {
        let kept = place.out.join(format!("{}.vcd", name.replace(' ', "_")));
        fs::create_dir_all(place.out).and_then(|()| fs::copy(&trace, &kept)).map_err(at_path(&kept)).map_err(wrong)?;
        Some(kept)
    } else {
        None
    };
    // Only proofs are replayed: a cover is not a violation, and a mutant is expected to fail.
    let bench = trace.with_extension("v");
    let replay = if task == Task::Proof && kept.is_some() && bench.exists() {
        let folder = place.out.join(format!("{}_replay", claim.name));
        Some(replay::write(claim, &sources, &bench, &folder).map_err(wrong)?)
    } else {
        None
    };
    let (replay, steps) = replay.map_or((None, Vec::new()), |replay| (Some(replay.test), replay.steps));
    let [seconds, processor_seconds] = [total.time, total.processor].map(|time| time.as_secs_f64());
    let memory_mib = total.memory as f64 / 1024.0;
    Ok(Outcome { name, status, pass, seconds, processor_seconds, memory_mib, detail, trace: kept, replay, steps })
}

/// Returns the sources of a claim: the originals, or copies in `work` if they are observed, changed, cut or golden.
pub(crate) fn prepare(
    claim: &Claim,
    changed: Option<&FaultySource>,
    folder: &Path,
    work: &Path,
) -> Result<Vec<PathBuf>, ProveError> {
    let wrong = |error| ProveError::Engine { claim: claim.name.clone(), error };
    let put = |name: &str, text: &str| {
        // A source may be beside the folder.
        let copy = work.join(Path::new(name).file_name().unwrap_or_default());
        fs::write(&copy, text).map_err(at_path(&copy)).map_err(wrong)?;
        Ok(copy)
    };
    let mut paths = Vec::new();
    for file in &claim.sources {
        let path = folder.join(file);
        let changed = changed.filter(|changed| changed.file == *file);
        let observed: Vec<_> = claim.observe.iter().filter(|observe| observe.file == *file).collect();
        let golden = claim.golden.contains(file);
        let cut = file.strip_suffix(".v").is_some_and(|name| claim.cut.iter().any(|cut| cut == name));
        if changed.is_none() && observed.is_empty() && !golden && !cut {
            paths.push(path);
            continue;
        }
        let original = fs::read_to_string(&path).map_err(at_path(&path)).map_err(wrong)?;
        if golden {
            paths.push(put(&format!("golden_{file}"), &rename_golden(&original, &claim.golden))?);
        }
        let mut text = changed.map_or(original, |changed| changed.text.clone());
        for observe in observed {
            if let Some(end) = text.rfind("endmodule") {
                text.insert_str(end, &format!("{}\n", observe.text));
            }
        }
        paths.push(put(file, &if cut { without_contents(&text) } else { text })?);
    }
    Ok(paths)
}

/// Returns a module without its contents: its outputs may have any value in each step. Its inputs stay visible, and so
/// does each parameter `P`, as `parameter_P`.
fn without_contents(text: &str) -> String {
    let mut head: String = text.lines().take_while(|line| *line != ");").map(|line| format!("{line}\n")).collect();
    let parameters =
        head.lines().filter_map(|line| line.trim().strip_prefix("parameter ")?.split_once(" =")?.0.rsplit(' ').next());
    let parameters: String = parameters.map(|name| format!("wire [31:0] parameter_{name} = {name};\n")).collect();
    head = head.replace("output reg ", "output wire ");
    // Yosys takes a module with nothing in it for a black box, which it does not flatten.
    head + ");\nwire abstracted;\n" + &parameters + "endmodule\n"
}

/// Renames the modules of `files` in a source to `golden_NAME`; a file has the name of its module.
fn rename_golden(text: &str, files: &[String]) -> String {
    let golden = |line: &str| {
        // The head of a module, or an instance: module name, blank, parameters or instance name, bracket.
        let head = line.strip_prefix("module ").unwrap_or(line);
        let name = head.split(' ').next().unwrap_or_default();
        let known = line.ends_with('(') && files.iter().any(|file| file.strip_suffix(".v") == Some(name));
        if known { line.replacen(name, &format!("golden_{name}"), 1) } else { line.to_owned() }
    };
    text.lines().map(|line| golden(line) + "\n").collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_names_of_golden_modules_change() {
        let text = "module pair #(\n  parameter N = 1\n) (\n  input wire half\n);\nhalf #(.N(N)) half (\n  .x(half)\n);\
                    \nother half_2 (\n);\nendmodule\n";
        let golden = text.replace("module pair", "module golden_pair").replace("\nhalf #", "\ngolden_half #");
        assert_eq!(rename_golden(text, &["pair.v".into(), "half.v".into()]), golden);
    }
}
