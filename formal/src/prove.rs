//! A claim to a verdict: its proof, its covers and its mutants.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::Serialize;

use crate::claim::{Claim, Mutant};
use crate::engine::{Answer, Asked, EngineError, Question, ask, at_path, model};
use crate::replay;

/// Why there is no verdict.
#[derive(Debug, thiserror::Error)]
pub enum ProveError {
    /// Yosys or the solver.
    #[error("{claim}: {error}")]
    Engine {
        /// The claim.
        claim: String,
        /// What went wrong.
        error: EngineError,
    },
    /// A mutant that cannot be made.
    #[error("{claim}: mutant {number}: its text stands {found} times in {file}, not once; mend the claim's file")]
    Mutant {
        /// The claim.
        claim: String,
        /// From 1 on.
        number: usize,
        /// Where it should stand.
        file: String,
        /// How often it does.
        found: usize,
    },
}

/// What is done with a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Task {
    /// Its proof.
    Proof,
    /// Its covers.
    Cover,
    /// One of its mutants, from 0 on.
    Mutant(usize),
}

/// What came of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// For all time.
    Proved,
    /// For so many steps from reset.
    Bounded,
    /// Every cover is reached.
    Reached,
    /// The mutant violates a property within so many steps of reset.
    Refuted,
    /// The mutant makes the induction fail.
    Unproved,
    /// A property is violated, a cover is out of reach, or a mutant passes.
    Failed,
    /// The time was over.
    Timeout,
}

/// The result of a task.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outcome {
    /// Claim, and after a blank `cover` or `mutant N`.
    pub name: String,
    /// What came of it.
    pub status: Status,
    /// Whether that is as it should be.
    pub pass: bool,
    /// Wall time, s.
    pub seconds: f64,
    /// Largest memory of the solver, MiB.
    pub memory_mib: f64,
    /// What failed: the properties and the step.
    pub detail: String,
    /// The waveform of the violation.
    pub trace: Option<PathBuf>,
    /// The test that replays it, in Rust.
    pub replay: Option<PathBuf>,
    /// The inputs of the violation, one line a step.
    pub steps: Vec<String>,
}

/// Where Verilog is, where files may be written, and how long a question may take.
#[derive(Debug, Clone, Copy)]
pub struct Place<'a> {
    /// The folder of the sources that claims name.
    pub sources: &'a Path,
    /// For waveforms; made where needed.
    pub out: &'a Path,
    /// Of each question.
    pub limit: Duration,
}

/// A source with a fault in it: its file's name, and its text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Changed {
    /// The file that is replaced.
    pub file: String,
    /// What it is replaced by.
    pub text: String,
}

/// Does a task.
///
/// # Errors
/// Yosys or the solver is missing or refuses the Verilog; a mutant's text is not there.
pub fn run(claim: &Claim, task: Task, place: &Place) -> Result<Outcome, ProveError> {
    let changed = match task {
        Task::Mutant(at) => Some(changed(claim, at, place.sources)?),
        Task::Proof | Task::Cover => None,
    };
    judge(claim, task, changed.as_ref(), place)
}

/// Whether a claim holds with a fault in one of its sources: `Proved` or `Bounded` where it does, `Refuted` or
/// `Unproved` where its proof sees the fault. Passes where the claim holds.
///
/// # Errors
/// Yosys or the solver is missing or refuses the Verilog.
pub fn holds_with(claim: &Claim, fault: &Changed, place: &Place) -> Result<Outcome, ProveError> {
    let outcome = judge(claim, Task::Proof, Some(fault), place)?;
    let status = match (outcome.status, outcome.detail.starts_with("induction")) {
        (Status::Failed, true) => Status::Unproved,
        (Status::Failed, false) => Status::Refuted,
        (status, _) => status,
    };
    Ok(Outcome { status, ..outcome })
}

/// A claim's own mutant.
fn changed(claim: &Claim, at: usize, folder: &Path) -> Result<Changed, ProveError> {
    let Mutant { file, from, to } = &claim.mutants[at];
    let path = folder.join(file);
    let wrong = |error| ProveError::Engine { claim: claim.name.clone(), error };
    let text = fs::read_to_string(&path).map_err(at_path(&path)).map_err(wrong)?;
    match text.matches(from.as_str()).count() {
        1 => Ok(Changed { file: file.clone(), text: text.replacen(from.as_str(), to, 1) }),
        found => Err(ProveError::Mutant { claim: claim.name.clone(), number: at + 1, file: file.clone(), found }),
    }
}

/// A task over the sources, one of them changed.
fn judge(claim: &Claim, task: Task, changed: Option<&Changed>, place: &Place) -> Result<Outcome, ProveError> {
    let wrong = |error| ProveError::Engine { claim: claim.name.clone(), error };
    let work = tempfile::tempdir().map_err(at_path(&std::env::temp_dir())).map_err(wrong)?;
    let sources = prepare(claim, changed, place.sources, work.path())?;
    let system = model(claim, &sources, work.path()).map_err(wrong)?;
    let trace = work.path().join("trace.vcd");
    let mut told = Asked { answer: Answer::Passed, time: Duration::ZERO, memory: 0 };
    let mut put = |question| -> Result<Answer, ProveError> {
        let asked = ask(&system, question, place.limit, &trace).map_err(wrong)?;
        told.time += asked.time;
        told.memory = told.memory.max(asked.memory);
        Ok(asked.answer)
    };
    let (answer, base) = match task {
        Task::Cover => (put(Question::Cover(claim.cover))?, true),
        // A fault is best shown by a run from reset.
        Task::Proof | Task::Mutant(_) => match put(Question::Base(match task {
            Task::Mutant(_) => claim.fault,
            _ => claim.depth + 1,
        }))? {
            Answer::Passed if !claim.bounded => (put(Question::Step(claim.depth))?, false),
            answer => (answer, true),
        },
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
        (Answer::Passed, Status::Failed) => "the proof does not see this fault".to_owned(),
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
    // A violation, in a run from reset or in one that begins in the free state of the induction, and not a cover.
    let bench = trace.with_extension("v");
    let replay = if task == Task::Proof && kept.is_some() && bench.exists() {
        let folder = place.out.join(format!("{}_replay", claim.name));
        Some(replay::write(claim, &sources, &bench, &folder).map_err(wrong)?)
    } else {
        None
    };
    let (replay, steps) = replay.map_or((None, Vec::new()), |replay| (Some(replay.test), replay.steps));
    let (seconds, memory_mib) = (told.time.as_secs_f64(), told.memory as f64 / 1024.0);
    Ok(Outcome { name, status, pass, seconds, memory_mib, detail, trace: kept, replay, steps })
}

/// The sources of a claim: as they are, or copies in `work` where they are observed or changed, or golden.
fn prepare(claim: &Claim, changed: Option<&Changed>, folder: &Path, work: &Path) -> Result<Vec<PathBuf>, ProveError> {
    let wrong = |error| ProveError::Engine { claim: claim.name.clone(), error };
    let put = |name: &str, text: &str| {
        let copy = work.join(name);
        fs::write(&copy, text).map_err(at_path(&copy)).map_err(wrong)?;
        Ok(copy)
    };
    let mut paths = Vec::new();
    for file in &claim.sources {
        let path = folder.join(file);
        let changed = changed.filter(|changed| changed.file == *file);
        let observed: Vec<_> = claim.observe.iter().filter(|observe| observe.file == *file).collect();
        let golden = claim.golden.contains(file);
        if changed.is_none() && observed.is_empty() && !golden {
            paths.push(path);
            continue;
        }
        let as_it_is = fs::read_to_string(&path).map_err(at_path(&path)).map_err(wrong)?;
        if golden {
            paths.push(put(&format!("golden_{file}"), &renamed(&as_it_is, &claim.golden))?);
        }
        let mut text = changed.map_or(as_it_is, |changed| changed.text.clone());
        for observe in observed {
            if let Some(end) = text.rfind("endmodule") {
                text.insert_str(end, &format!("{}\n", observe.text));
            }
        }
        paths.push(put(file, &text)?);
    }
    Ok(paths)
}

/// A source with the modules of `files` named `golden_NAME`; a file has the name of its module.
fn renamed(text: &str, files: &[String]) -> String {
    let golden = |line: &str| {
        // A module's head, or an instance: the module, a blank, the instance's name and a bracket.
        let head = line.strip_prefix("module ").unwrap_or(line);
        let name = head.split(' ').next().unwrap_or_default();
        let known = line.ends_with(" (") && files.iter().any(|file| file.strip_suffix(".v") == Some(name));
        if known { line.replacen(name, &format!("golden_{name}"), 1) } else { line.to_owned() }
    };
    text.lines().map(|line| golden(line) + "\n").collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_names_of_golden_modules_change() {
        let text = "module pair (\n  input wire half\n);\nhalf half (\n  .x(half)\n);\nother half_2 (\n);\nendmodule\n";
        let golden = text.replace("module pair", "module golden_pair").replace("\nhalf half", "\ngolden_half half");
        assert_eq!(renamed(text, &["pair.v".into(), "half.v".into()]), golden);
    }
}
