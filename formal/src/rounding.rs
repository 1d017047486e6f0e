//! Worst-case rounding errors of the smoothers and the DoG, for every picture of any size.
//!
//! Errors `e` are relative to exact arithmetic with the same coefficients, in state LSB. Each stage is a lerp,
//! `y = (1 - g) p + g q + r`, `|r| <= 1/2` (proved of the Verilog: claim `lerp`), so
//!
//! ```text
//! look-ahead, look-back  |e| <= (1 - g_j) |e_p| + g_j |e_q| + 1/2, of pixels 0     => |e| <= E_(n+1) = E_n + 1/2
//! recursion              |e[n]| <= (1 - g) |e[n-1]| + g E_n + 1/2, |e[0]| <= E_n  => |e| <= E_n + 1/(2 g)
//! DoG, its LSB     2^s state LSB, rounded half up                 => |e| <= (E + E') / 2^s + 1/2
//! saturation       |d| <= FS S + E + E' < 2^s 2^N - 2^(s-1)       => DOG <= 2^N - 1
//! ```
//!
//! `E`, `E'` are the bounds of the pair's smoothers, `N` the DoG's bits, `s` its shift, `S` half the L1 norm of the
//! difference of the kernels (`kernel`). Samples at a border have no larger errors than others.
//!
//! Each line is a query to the solver in linear real arithmetic (QF_LRA), with the raw coefficients as rationals: the
//! errors of the inputs are within their bounds, and that of the output is not. The claim is proved if all queries are
//! unsatisfiable; for the recursion this is the induction over the rows.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use crate::claim::Assumption;
use crate::engine::{EngineError, Solver, at_path};
use crate::prove::{Outcome, Status, Task};

mod kernel;

/// The raw coefficients of a smoother.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Smoother {
    /// Coefficient of the recursion, LSB `2^-coefficient_bits`.
    pub g: u32,
    /// Coefficient of each look-ahead stage `j`, which spans `2^j` samples, LSB `2^-coefficient_bits`.
    pub g_j: Vec<u32>,
}

/// The parameters of a design on which the claims depend.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Design {
    /// Smoothers from the narrowest to the widest; each with the next forms a DoG.
    pub smoothers: Vec<Smoother>,
    /// Fraction bits of the coefficients, at most 24.
    pub coefficient_bits: u32,
    /// Largest state, state LSB.
    pub full_scale: u32,
    /// `s`: one LSB of the DoG is `2^s` of the state; at least 1.
    pub dog_shift: u32,
    /// `N`: word length of a DoG without its sign.
    pub dog_bits: u32,
}

/// A claim about the numbers of a design.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Subject {
    /// The rounding errors are within [`Bounds`].
    Rounding,
    /// No DoG saturates.
    Saturation,
}

impl Subject {
    /// All claims.
    pub const ALL: [Self; 2] = [Self::Rounding, Self::Saturation];

    /// Returns the name of the claim, unique among all claims.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rounding => "rounding",
            Self::Saturation => "saturation",
        }
    }

    /// Returns the claim in words.
    pub fn statement(self) -> &'static str {
        match self {
            Self::Rounding => {
                "For every picture of any size, borders included: no stage of a smoother and no DoG differs by more \
                 than the bounds below from the same coefficients in exact arithmetic."
            }
            Self::Saturation => "For every picture of any size, borders included: no DoG saturates.",
        }
    }

    /// Returns the assumptions.
    pub fn assumed(self) -> Vec<Assumption> {
        let by = |text: &str, assertion: &str| Assumption {
            text: text.into(),
            by: vec![assertion.into()],
            ..Assumption::default()
        };
        let computed = "half the L1 norm of the kernels' difference is computed in integers, rounded outward, not by \
                        the solver";
        match self {
            Self::Rounding => vec![by("a stage errs by at most half an LSB", "lerp.half_lsb")],
            Self::Saturation => vec![
                by("the worst-case errors", "rounding"),
                Assumption { text: computed.into(), hole: Some(7), ..Assumption::default() },
            ],
        }
    }

    /// Returns the faults that must make the proof fail, in words.
    pub fn faults(self) -> &'static [&'static str] {
        match self {
            Self::Rounding => &[
                "the recursion's coefficient of the widest smoother one LSB smaller",
                "the rounding of a stage left out of the bound",
                "the rounding of the DoG left out of the bound",
            ],
            Self::Saturation => &["the DoG one bit shorter", "half the recursion's coefficient of the widest smoother"],
        }
    }
}

/// Units of a bound per LSB: bounds are integers in millionths of an LSB, rounded up.
const MICRO_PER_LSB: u64 = 1_000_000;

/// The bounds of the errors of a design.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bounds {
    /// For each smoother the error of each stage in order, 10^-6 state LSB.
    pub stages: Vec<Vec<u64>>,
    /// Error of each DoG, 10^-6 DoG LSB.
    pub dog: Vec<u64>,
    /// Largest `|d|` of each pair, with rounding errors, 10^-6 state LSB.
    pub largest: Vec<u64>,
}

impl Bounds {
    /// Computes the bounds by the equations of the module.
    pub fn of(design: &Design) -> Self {
        let stages: Vec<Vec<u64>> = design
            .smoothers
            .iter()
            .map(|smoother| {
                let dead_band = (MICRO_PER_LSB << (design.coefficient_bits - 1)).div_ceil(u64::from(smoother.g));
                let m = smoother.g_j.len() as u64;
                let halves = |stages: u64| stages * MICRO_PER_LSB / 2;
                let columns = (1..=m).map(halves);
                columns.chain((m..=3 * m).map(|stages| dead_band + halves(stages))).collect()
            })
            .collect();
        let last: Vec<u64> = stages.iter().map(|of| of[of.len() - 1]).collect();
        let sums: Vec<u64> = last.windows(2).map(|pair| pair[0] + pair[1]).collect();
        let exact = design.smoothers.windows(2).map(|pair| exact_difference(design, pair));
        let largest = exact.zip(&sums).map(|(exact, sum)| exact + sum).collect();
        let dog = sums.iter().map(|sum| sum.div_ceil(1 << design.dog_shift) + MICRO_PER_LSB / 2).collect();
        Self { stages, dog, largest }
    }
}

/// Returns `FS S`, the largest `|d|` in exact arithmetic, 10^-6 state LSB.
fn exact_difference(design: &Design, pair: &[Smoother]) -> u64 {
    let share = kernel::largest_difference(&pair[0], &pair[1], design.coefficient_bits);
    (share * u128::from(design.full_scale) * u128::from(MICRO_PER_LSB)).div_ceil(1 << 62) as u64
}

/// Returns the smallest `|d|` that saturates, state LSB: `(|d| + 2^(s-1)) >> s = 2^N`.
fn saturation_limit(design: &Design) -> u64 {
    (1 << (design.dog_shift + design.dog_bits)) - (1 << (design.dog_shift - 1))
}

/// Returns the stages of a smoother in order, with their names and coefficients.
fn stages(smoother: &Smoother) -> impl Iterator<Item = (String, u32)> {
    let numbered = |kind: &'static str| smoother.g_j.iter().enumerate().map(move |(j, g)| (format!("{kind}_{j}"), *g));
    let columns = numbered("column_look_ahead").rev();
    let rows = numbered("row_look_back").chain(numbered("row_look_ahead"));
    columns.chain(std::iter::once(("recursion".to_owned(), smoother.g))).chain(rows)
}

/// A query: a name, and constraints that must be unsatisfiable for a proof.
struct Query {
    name: String,
    text: String,
}

/// Constrains `|x| <= micro / 10^6`.
fn within(x: &str, micro: u64) -> String {
    format!("(assert (<= (/ (- {micro}.0) {MICRO_PER_LSB}.0) {x} (/ {micro}.0 {MICRO_PER_LSB}.0)))\n")
}

/// Constrains `|x|` to exceed the bound, or with `reached` to come within two millionths of it.
fn beyond(x: &str, micro: u64, reached: bool) -> String {
    let (relation, micro) = if reached { (">=", micro - 2) } else { (">", micro) };
    format!("(assert ({relation} (ite (>= {x} 0.0) {x} (- {x})) (/ {micro}.0 {MICRO_PER_LSB}.0)))\n")
}

/// Declares real variables.
fn declare_reals(names: &[&str]) -> String {
    names.iter().map(|name| format!("(declare-const {name} Real)\n")).collect()
}

/// Returns the constraints of a stage: `p` and `q` are the bounds of the errors of its inputs, `after` that of its
/// output, in millionths. For the recursion `p` is its own state.
fn stage(design: &Design, g: u32, (p, q, after): (u64, u64, u64), reached: bool) -> String {
    let one = 1u64 << design.coefficient_bits;
    declare_reals(&["p", "q", "r", "y"])
        + &within("p", p)
        + &within("q", q)
        + &within("r", MICRO_PER_LSB / 2)
        + &format!("(assert (= y (+ (* (/ {}.0 {one}.0) p) (* (/ {g}.0 {one}.0) q) r)))\n", one - u64::from(g))
        + &beyond("y", after, reached)
}

/// Returns the queries of claim `rounding`: whether a bound can be exceeded or, with `reached`, be reached.
fn rounding_queries(design: &Design, bounds: &Bounds, reached: bool) -> Vec<Query> {
    let mut queries = Vec::new();
    for (k, (smoother, bounds)) in design.smoothers.iter().zip(&bounds.stages).enumerate() {
        // The inputs of the first stage are the picture, which is exact.
        let inputs = std::iter::once(&0).chain(bounds);
        for (((name, g), &q), &y) in stages(smoother).zip(inputs).zip(bounds) {
            let p = if name == "recursion" { y } else { q };
            let name = format!("smoother {k}, {name}");
            queries.push(Query { name, text: stage(design, g, (p, q, y), reached) });
        }
    }
    let scale = 1u64 << design.dog_shift;
    let last: Vec<u64> = bounds.stages.iter().map(|of| of[of.len() - 1]).collect();
    for (k, (pair, &dog)) in last.windows(2).zip(&bounds.dog).enumerate() {
        let text = declare_reals(&["exact", "narrow", "wide", "d", "r", "dog", "e"])
            + &within("narrow", pair[0])
            + &within("wide", pair[1])
            + &within("r", scale / 2 * MICRO_PER_LSB)
            + "(assert (= d (+ exact (- narrow wide))))\n"
            + &format!("(assert (= (* {scale}.0 dog) (+ (ite (>= d 0.0) d (- d)) r)))\n")
            + &format!("(assert (= e (- dog (/ (ite (>= exact 0.0) exact (- exact)) {scale}.0))))\n")
            + &beyond("e", dog, reached);
        queries.push(Query { name: format!("DoG {k}"), text });
    }
    queries
}

/// Returns the queries of claim `saturation`: whether a `|d|` can saturate or, with `reached`, be as large as its
/// bound.
fn saturation_queries(design: &Design, bounds: &Bounds, reached: bool) -> Vec<Query> {
    let query = |(k, largest): (usize, &u64)| {
        let last = |of: &[u64]| of[of.len() - 1];
        let text = declare_reals(&["exact", "narrow", "wide", "d"])
            + &within("exact", exact_difference(design, &design.smoothers[k..=k + 1]))
            + &within("narrow", last(&bounds.stages[k]))
            + &within("wide", last(&bounds.stages[k + 1]))
            + "(assert (= d (+ exact (- narrow wide))))\n"
            + &if reached {
                beyond("d", *largest, true)
            } else {
                format!("(assert (>= (ite (>= d 0.0) d (- d)) {}.0))\n", saturation_limit(design))
            };
        Query { name: format!("DoG {k}"), text }
    };
    bounds.largest.iter().enumerate().map(query).collect()
}

/// Runs a task of a claim about a design: its proof; its covers, which show that each bound can be reached; or a fault
/// of [`Subject::faults`], which must make it fail. A failed task leaves its queries in `out`.
///
/// # Errors
/// If the solver is missing or does not answer.
pub fn run(design: &Design, subject: Subject, task: Task, solver: Solver, out: &Path) -> Result<Outcome, EngineError> {
    let mut changed = design.clone();
    let mut bounds = Bounds::of(design);
    if let Task::Mutant(at) = task {
        let last = changed.smoothers.len() - 1;
        match (subject, at) {
            (Subject::Rounding, 0) => changed.smoothers[last].g -= 1,
            (Subject::Rounding, 1) => {
                bounds.stages[last].iter_mut().skip(4).for_each(|bound| *bound -= MICRO_PER_LSB / 2)
            }
            (Subject::Rounding, _) => bounds.dog.iter_mut().for_each(|bound| *bound -= MICRO_PER_LSB / 2),
            (Subject::Saturation, 0) => changed.dog_bits -= 1,
            (Subject::Saturation, _) => changed.smoothers[last].g /= 2,
        }
    }
    let cover = task == Task::Cover;
    let queries = match subject {
        Subject::Rounding => rounding_queries(&changed, &bounds, cover),
        Subject::Saturation => saturation_queries(&changed, &bounds, cover),
    };
    let answers = solve(solver, &queries)?;
    let wrong: Vec<&str> = queries
        .iter()
        .zip(&answers.satisfiable)
        .filter(|(_, met)| **met != cover)
        .map(|(of, _)| of.name.as_str())
        .collect();
    let (status, pass) = match (task, wrong.is_empty()) {
        (Task::Proof, true) => (Status::Proved, true),
        (Task::Cover, true) => (Status::Reached, true),
        (Task::Mutant(_), false) => (Status::Refuted, true),
        _ => (Status::Failed, false),
    };
    let detail = match (task, wrong.is_empty()) {
        (Task::Mutant(_), true) => "the proof does not detect this fault".to_owned(),
        (_, true) => String::new(),
        (Task::Cover, false) => format!("bound not reached: {}", wrong.join("; ")),
        (_, false) => format!("bound exceeded: {}", wrong.join("; ")),
    };
    let name = match task {
        Task::Proof => subject.name().to_owned(),
        Task::Cover => format!("{} cover", subject.name()),
        Task::Mutant(at) => format!("{} mutant {}", subject.name(), at + 1),
    };
    let trace = if status == Status::Failed {
        let kept = out.join(format!("{}.smt2", name.replace(' ', "_")));
        fs::create_dir_all(out).and_then(|()| fs::write(&kept, &answers.script)).map_err(at_path(&kept))?;
        Some(kept)
    } else {
        None
    };
    let Answers { seconds, processor_seconds, memory_mib, .. } = answers;
    let (replay, steps) = (None, Vec::new());
    Ok(Outcome { name, status, pass, seconds, processor_seconds, memory_mib, detail, trace, replay, steps })
}

/// The answers of the solver to a list of queries.
struct Answers {
    script: String,
    /// `true` for each query whose constraints are satisfiable.
    satisfiable: Vec<bool>,
    seconds: f64,
    processor_seconds: f64,
    memory_mib: f64,
}

/// Runs the solver on the queries.
fn solve(solver: Solver, queries: &[Query]) -> Result<Answers, EngineError> {
    let (program, at) = (solver.program().0, solver.find()?);
    // Options, and the names of processor time and memory in the statistics.
    let (options, names): (&[&str], _) = match solver {
        Solver::Yices => (&["--incremental", "--stats"], [":total-run-time", ":mem-usage"]),
        Solver::Z3 => (&["-st"], [":total-time", ":memory"]),
    };
    let blocks = queries.iter().map(|of| format!("; {}\n(push 1)\n{}(check-sat)\n(pop 1)\n", of.name, of.text));
    let script = "(set-logic QF_LRA)\n".to_owned() + &blocks.collect::<String>();
    let work = tempfile::tempdir().map_err(at_path(&std::env::temp_dir()))?;
    let file = work.path().join("questions.smt2");
    fs::write(&file, &script).map_err(at_path(&file))?;
    let start = Instant::now();
    let output = Command::new(&at).args(options).arg(&file).stdin(Stdio::null()).output();
    let output = output.map_err(at_path(&at))?;
    let seconds = start.elapsed().as_secs_f64();
    let output_text = String::from_utf8_lossy(&output.stdout);
    let mut satisfiable = Vec::new();
    let [mut processor_seconds, mut memory_mib] = [0.0; 2];
    for line in output_text.lines().map(|line| line.trim_matches([' ', '(', ')'])) {
        match line {
            "sat" => satisfiable.push(true),
            "unsat" => satisfiable.push(false),
            _ => {
                let value = |name| line.strip_prefix(name).and_then(|rest: &str| rest.trim().parse().ok());
                processor_seconds = value(names[0]).unwrap_or(processor_seconds);
                memory_mib = value(names[1]).unwrap_or(memory_mib);
            }
        }
    }
    // A missing answer must not count as a proof.
    if satisfiable.len() != queries.len() || !output.status.success() {
        let reason = output_text.lines().find(|line| line.contains("error")).unwrap_or("no answer").to_owned();
        return Err(EngineError::Refused { program, reason });
    }
    Ok(Answers { script, satisfiable, seconds, processor_seconds, memory_mib })
}

/// Returns the bounds as Markdown. `measured` are the largest errors of the DoGs that were measured, DoG LSB; `of`
/// describes the measurement.
pub fn table(design: &Design, measured: &[f64], of: &str) -> String {
    let bounds = Bounds::of(design);
    // Rounded up, as the bound itself.
    let three = |micro: u64| format!("{:.3}", micro.div_ceil(1000) as f64 / 1000.0);
    let mut text =
        "| smoother | after the column stages | recursion | after the row stages back | smoother's output |\n\
                    |---|---|---|---|---|\n"
            .to_owned();
    for (k, (of, smoother)) in bounds.stages.iter().zip(&design.smoothers).enumerate() {
        let m = smoother.g_j.len();
        let ends = [m - 1, m, 2 * m, 3 * m].map(|n| three(of[n]));
        text += &format!("| {k} | {} |\n", ends.join(" | "));
    }
    text += "\nState LSB; the recursion adds `1 / (2 g)`, each other stage half an LSB.\n\n\
         | DoG | error, proved, DoG LSB | measured, DoG LSB | largest \\|d\\|, proved, state LSB | saturates from |\n\
         |---|---|---|---|---|\n";
    for (k, (dog, largest)) in bounds.dog.iter().zip(&bounds.largest).enumerate() {
        let measured = measured.get(k).map_or("-".to_owned(), |measured| format!("{measured:.2}"));
        text +=
            &format!("| {k} | {} | {measured} | {} | {} |\n", three(*dog), three(*largest), saturation_limit(design));
    }
    text + &format!("\nMeasured: {of}.\n")
}
