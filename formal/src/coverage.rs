//! Coverage of a claim: the share of mutations drawn by chance that its proof detects.
//!
//! Yosys draws mutations of the modules under the claim (`mutate -list`): a bit of a cell's port is inverted, constant,
//! or inverted by another bit. All of them are put into one transition system, where a constant input selects one.
//! Each is then in one of five classes, see [`Class`].
//!
//! A mutation is harmless if it changes no output in any run that the claim allows. This is an induction over pairs of
//! runs: original and mutant start a step with equal registers, the original is in a state that the claim's proved
//! properties allow, and inputs are equal; then outputs and registers are equal after it. Registers that differ are
//! taken out of the assumption, and the induction is repeated without them, until the rest is inductive or an output
//! differs.

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde::Serialize;
use tempfile::TempDir;

use crate::claim::{Claim, Hole};
use crate::engine::{
    CHECK_COMMANDS, EngineError, Solver, at_path, check_prepared, prepare_command, read_commands, run_yosys,
    top_option, write, write_commands,
};
use crate::prove::{Place, ProveError, prepare};
use crate::system::{Part, Parts, Start, System};

/// Name and width of the input that selects a mutation.
const SELECT: (&str, usize) = ("selected_mutation", 16);
/// Time for the search for a run from reset that violates a property, once the induction has failed.
const RUN_LIMIT: Duration = Duration::from_secs(1);
/// Largest number of mutations of a claim.
pub const MAX_MUTATIONS: u32 = 10_000;

/// A mutation that Yosys has drawn.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Mutation {
    /// Number in the drawing, from 1.
    pub number: usize,
    /// `inv`, `const0`, `const1`, or `cnot0` and `cnot1`: inverted if another bit of the port is 0 or 1.
    pub mode: String,
    /// Name of the module.
    pub module: String,
    /// Port of the cell, with the bit.
    pub port: String,
    /// Wire at the port, if it has a name in the source, with the bit.
    pub wire: Option<String>,
    /// Source file.
    pub file: String,
    /// Line of the cell in the source, from 1.
    pub line: usize,
    /// Text of this line.
    pub text: String,
    /// The command of Yosys that applies it, without `mutate`.
    #[serde(skip)]
    command: String,
}

/// The class of a mutation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// Changes no output in any run that the claim allows, which is proved.
    Harmless,
    /// A run from reset violates a property.
    Refuted,
    /// The induction fails. No run from reset was found that violates a property, in a few steps and seconds.
    Unproved,
    /// The claim is proved with the mutation in place, and the mutation is not proved to be harmless.
    Survivor,
    /// The time limit was reached, by the proof with the mutation in place or already by that without one.
    Undecided,
}

impl Class {
    /// Returns `true` if the proof fails with the mutation in place.
    pub fn is_killed(self) -> bool {
        matches!(self, Self::Refuted | Self::Unproved)
    }
}

/// Mutations of a claim, ready to be classified.
#[derive(Debug)]
pub struct Campaign<'a> {
    claim: &'a Claim,
    work: TempDir,
    system: System,
    mutations: Vec<Mutation>,
    /// What of the system the mutations can change.
    parts: Parts,
    /// Outputs of the modules, and inputs of those that the claim abstracts.
    outputs: Vec<usize>,
    limit: Duration,
    /// The claim without a mutation is proved within the time limit.
    is_decidable: bool,
}

/// The solver's answer to one query.
enum Reply {
    Unsatisfiable,
    /// With the names that are true.
    Satisfiable(Vec<usize>),
    TimedOut,
}

impl<'a> Campaign<'a> {
    /// Draws mutations of a claim and proves the claim without any. Fewer are drawn if the modules have fewer.
    ///
    /// # Errors
    /// If Yosys or the solver is missing or rejects the Verilog, or the claim is not proved without a mutation.
    pub fn new(claim: &'a Claim, place: &Place, mutations: u32, seed: u32) -> Result<Self, ProveError> {
        let wrong = |error| ProveError::Engine { claim: claim.name.clone(), error };
        let work = tempfile::tempdir().map_err(at_path(&std::env::temp_dir())).map_err(wrong)?;
        let folder = work.path();
        let mut sources = Vec::new();
        for path in prepare(claim, None, place.sources, folder)? {
            let Some(name) = path.file_name() else { continue };
            let copy = folder.join(name);
            if copy != path {
                fs::copy(&path, &copy).map_err(at_path(&path)).map_err(wrong)?;
            }
            sources.push(copy);
        }
        let read = read_commands(claim, &sources, folder).map_err(wrong)?;
        let drawn = draw(claim, &read, folder, place.sources, mutations as usize, seed).map_err(wrong)?;
        let model = folder.join("model.smt2");
        let (select, width) = SELECT;
        let design = folder.join("base.il");
        let design = fs::read_to_string(&design).map_err(at_path(&design)).map_err(wrong)?;
        let mut own = Vec::new();
        for path in &sources {
            own.push(fs::read_to_string(path).map_err(at_path(path)).map_err(wrong)?);
        }
        let own: Vec<&str> = own.iter().flat_map(|text| modules(text)).collect();
        let (top, outputs) = outputs(claim, &own, &design);
        // The clocks are those of the design without mutations, which may invert the clock of an instance.
        let prepare = prepare_command(claim);
        let mut script = format!("read_rtlil base.il\n{prepare}{CHECK_COMMANDS}design -reset\nread_rtlil base.il\n");
        // An output that the wrapper does not connect would disappear.
        for Output { module, port, .. } in &outputs {
            script += &format!("setattr -set keep 1 {module}/w:{port}\n");
        }
        script += &format!("mutate -ctrl {select} {width} 0 -mode none -module {top}\n");
        for Mutation { number, command, .. } in &drawn {
            script += &format!("mutate -ctrl {select} {width} {number} {command}\n");
        }
        script += &prepare;
        script += &write_commands(&model);
        run_yosys(&script, folder).and_then(|()| check_prepared(folder)).map_err(wrong)?;
        let text = fs::read_to_string(&model).map_err(at_path(&model)).map_err(wrong)?;
        let form = |reason: &str| EngineError::Refused { program: "yosys", reason: reason.into() };
        let system = System::parse(&text, claim.cut_products)
            .map_err(|statement| wrong(form(&format!("a statement has an unknown form: {statement}"))))?;
        let outputs = outputs
            .iter()
            .map(|Output { wire, .. }| {
                system.signal(&format!("_n {wire}")).ok_or_else(|| wrong(form(&format!("{wire} is absent"))))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let select = system.input(select).ok_or_else(|| wrong(form("no input selects a mutation")))?;
        let predicate = |name| predicate(&system, claim, name);
        let parts = system.parts(select, predicate("_a")?, predicate("_u")?);
        let mut campaign =
            Self { parts, claim, work, system, mutations: drawn, outputs, limit: place.limit, is_decidable: true };
        let none = campaign.name("none");
        let steps = claim.depth + u32::from(!claim.bounded);
        let whole = campaign.system.whole(&campaign.parts);
        let induction = match claim.bounded {
            true => Reply::Unsatisfiable,
            false => campaign.induction(&whole, 0, &none)?,
        };
        for reply in [induction, campaign.base(&whole, 0, steps, place.limit, &none)?] {
            match reply {
                Reply::Unsatisfiable => {}
                Reply::Satisfiable(_) => return Err(ProveError::Unproved { claim: claim.name.clone() }),
                Reply::TimedOut => campaign.is_decidable = false,
            }
        }
        Ok(campaign)
    }

    /// Mutations in the order in which they were drawn.
    pub fn mutations(&self) -> &[Mutation] {
        &self.mutations
    }

    /// Returns the class of a mutation, and the wall time that this took, s.
    ///
    /// # Errors
    /// If the solver fails.
    pub fn classify(&self, mutation: &Mutation) -> Result<(Class, f64), ProveError> {
        let start = Instant::now();
        let class = if self.is_decidable { self.class(mutation.number)? } else { Class::Undecided };
        Ok((class, start.elapsed().as_secs_f64()))
    }

    fn class(&self, number: usize) -> Result<Class, ProveError> {
        self.class_in(&self.system.part(&self.parts, number), number)
    }

    /// Returns the class of a mutation by questions about a part, which must have all that it changes.
    fn class_in(&self, part: &Part, number: usize) -> Result<Class, ProveError> {
        let induction = match self.claim.bounded {
            true => Reply::Unsatisfiable,
            false => self.induction(part, number, &self.name(&format!("step{number}")))?,
        };
        // A run from reset is evidence that is easier to understand than an induction that fails.
        let (steps, limit) = match induction {
            Reply::Satisfiable(_) => (self.claim.fault.max(self.claim.depth + 1), self.limit.min(RUN_LIMIT)),
            _ => (self.claim.depth + u32::from(!self.claim.bounded), self.limit),
        };
        let base = self.base(part, number, steps, limit, &self.name(&format!("base{number}")))?;
        Ok(match (base, induction) {
            (Reply::Satisfiable(_), _) => Class::Refuted,
            (_, Reply::Satisfiable(_)) => Class::Unproved,
            _ if self.is_harmless(part, number)? => Class::Harmless,
            (Reply::Unsatisfiable, Reply::Unsatisfiable) => Class::Survivor,
            _ => Class::Undecided,
        })
    }

    fn name(&self, query: &str) -> String {
        format!("{query}.smt2")
    }

    /// Appends a step with a mutation to a query about a part, with the signals `roots`.
    fn step(&self, query: &mut String, part: &Part, name: &str, from: Start, number: usize, roots: &[usize]) {
        let first: Vec<usize> = self.system.signal("_is").into_iter().collect();
        let value = format!("#x{number:04x}");
        self.system.step(query, part, name, from, (self.parts.select, &value), &[&first, roots].concat());
    }

    /// Is there a run from reset that violates a property within this number of steps? Asked step by step.
    fn base(&self, part: &Part, number: usize, steps: u32, limit: Duration, file: &str) -> Result<Reply, ProveError> {
        let initial = predicate(&self.system, self.claim, "_i")?;
        let mut query = self.system.head();
        for step in 0..steps {
            let [name, before] = [step, step.wrapping_sub(1)].map(|step| format!("s{step}"));
            let from = if step == 0 { Start::Anything } else { Start::Step(&before) };
            let roots: &[usize] = if step == 0 { &[initial] } else { &[] };
            self.step(&mut query, part, &name, from, number, roots);
            if step == 0 {
                query += &format!("(assert v{initial}_{name})\n");
            }
            query += &self.first_step(step, step == 0);
            let [allowed, holds] = [&part.assumptions, &part.properties].map(|of| all_of(of, &name));
            query += &format!("(assert {allowed})\n(push 1)\n(assert (not {holds}))\n(check-sat)\n(pop 1)\n");
            query += &format!("(assert {holds})\n");
        }
        self.solve(&query, &Series::Any, limit, file)
    }

    /// Are there `depth` steps without a violation that are followed by one? Asked with 0, 1 and more steps before the
    /// violation, as fewer often suffice for a proof. The first question has an easy answer that the solver builds on:
    /// without it `row_look_back` takes more than ten minutes in place of a second.
    fn induction(&self, part: &Part, number: usize, file: &str) -> Result<Reply, ProveError> {
        let depth = self.claim.depth;
        let mut query = self.system.head();
        for step in (0..=depth).rev() {
            let name = format!("s{step}");
            self.step(&mut query, part, &name, Start::Anything, number, &[]);
            query += &self.first_step(step, false);
            let [allowed, holds] = [&part.assumptions, &part.properties].map(|of| all_of(of, &name));
            let asked = if step == depth { format!("(not {holds})") } else { holds };
            query += &format!("(assert (and {allowed} {asked}))\n");
            if step < depth {
                self.system.transition(&mut query, part, &name, &format!("s{}", step + 1));
            }
            query += "(check-sat)\n";
        }
        self.solve(&query, &Series::All, self.limit, file)
    }

    /// States whether a step is the first of a run.
    fn first_step(&self, step: u32, first: bool) -> String {
        self.system.signal("_is").map_or(String::new(), |is| format!("(assert (= v{is}_s{step} {first}))\n"))
    }

    /// Runs the induction over pairs of runs.
    fn is_harmless(&self, part: &Part, number: usize) -> Result<bool, ProveError> {
        let outputs: Vec<usize> = self.outputs.iter().copied().filter(|at| part.has(*at)).collect();
        let mut different: Vec<usize> = Vec::new();
        loop {
            let mut query = self.system.head();
            self.step(&mut query, part, "s0", Start::Anything, 0, &outputs);
            self.step(&mut query, part, "s1", Start::Step("s0"), 0, &[]);
            self.step(&mut query, part, "m0", Start::Same("s0", &different), number, &outputs);
            for step in ["s0", "s1"] {
                query += &format!("(assert {})\n", all_of(&part.assumptions, step));
                if !self.claim.bounded {
                    query += &format!("(assert {})\n", all_of(&part.properties, step));
                }
            }
            let mut flags = Vec::new();
            for &output in &outputs {
                query += &format!("(define-fun d{} () Bool (distinct v{output}_s0 v{output}_m0))\n", flags.len());
                flags.push(output);
            }
            let registers = self.system.registers(part).filter(|at| !different.contains(at));
            for register in registers {
                let [one, two] = ["s0", "m0"].map(|step| self.system.next_value(register, step));
                query += &format!("(define-fun d{} () Bool (distinct {one} {two}))\n", flags.len());
                flags.push(register);
            }
            if flags.is_empty() {
                return Ok(true);
            }
            let any: String = (0..flags.len()).map(|at| format!(" d{at}")).collect();
            query += &format!("(assert (or{any}))\n");
            query += "(check-sat)\n";
            match self.solve(&query, &Series::One(flags.len()), self.limit, &self.name(&format!("pair{number}")))? {
                Reply::Unsatisfiable => return Ok(true),
                Reply::Satisfiable(now) if !now.is_empty() && now.iter().all(|&at| at >= outputs.len()) => {
                    different.extend(now.iter().map(|&at| flags[at]));
                }
                Reply::Satisfiable(_) | Reply::TimedOut => return Ok(false),
            }
        }
    }

    /// Runs the solver on a query.
    fn solve(&self, query: &str, series: &Series, limit: Duration, file: &str) -> Result<Reply, ProveError> {
        let wrong = |error| ProveError::Engine { claim: self.claim.name.clone(), error };
        let path = self.work.path().join(file);
        let (mut text, flags) = (query.to_owned(), matches!(series, Series::One(1..)));
        if let Series::One(flags @ 1..) = series {
            let values: String = (0..*flags).map(|at| format!(" d{at}")).collect();
            text += &format!("(get-value ({values}))\n");
        }
        write(&path, &text).map_err(wrong)?;
        let mut command = Command::new(Solver::Yices.find().map_err(wrong)?);
        command.arg(format!("--timeout={}", limit.as_secs().max(1)));
        if !flags {
            command.arg("--incremental");
        }
        let child = command.arg(&path).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn();
        let mut child = child.map_err(at_path(&path)).map_err(wrong)?;
        let output = child.stdout.take().map(BufReader::new);
        let reply = output.map_or(Ok(Reply::TimedOut), |output| series.read(output.lines().map_while(Result::ok)));
        // The rest of a series does not matter.
        drop(child.kill());
        child.wait().map_err(at_path(&path)).map_err(wrong)?;
        fs::remove_file(&path).map_err(at_path(&path)).map_err(wrong)?;
        reply.map_err(|reason| wrong(EngineError::Refused { program: "yices-smt2", reason }))
    }
}

/// Returns the predicate of this name: properties `_a`, assumptions `_u`, initial values `_i`.
fn predicate(system: &System, claim: &Claim, name: &str) -> Result<usize, ProveError> {
    let reason = format!("the transition system has no {name}");
    let error = EngineError::Refused { program: "yosys", reason };
    system.signal(name).ok_or_else(|| ProveError::Engine { claim: claim.name.clone(), error })
}

/// Returns the conjunction of predicates in a step.
fn all_of(predicates: &[usize], step: &str) -> String {
    let terms: String = predicates.iter().map(|at| format!(" v{at}_{step}")).collect();
    format!("(and true{terms})")
}

/// How the answers to the checks of a query make one.
enum Series {
    /// One check, and the values of this number of flags `d0`, `d1` and so on.
    One(usize),
    /// Satisfiable if any check is.
    Any,
    /// Satisfiable if all checks are.
    All,
}

impl Series {
    /// Reads the solver's answers up to the one that decides.
    fn read(&self, mut lines: impl Iterator<Item = String>) -> Result<Reply, String> {
        let mut reply = None;
        while let Some(line) = lines.next() {
            let now = match line.trim() {
                "unsat" => Reply::Unsatisfiable,
                "sat" => Reply::Satisfiable(Vec::new()),
                "unknown" | "interrupted" | "timeout" => return Ok(Reply::TimedOut),
                other => return Err(other.to_owned()),
            };
            match (self, &now) {
                (Self::One(_), Reply::Satisfiable(_)) => {
                    let values = lines.collect::<Vec<_>>().concat();
                    let is_true = |part: &str| part.trim().strip_prefix('d')?.split_once(" true")?.0.parse().ok();
                    return Ok(Reply::Satisfiable(values.split('(').filter_map(is_true).collect()));
                }
                (Self::One(_) | Self::All, Reply::Unsatisfiable) | (Self::Any, Reply::Satisfiable(_)) => {
                    return Ok(now);
                }
                _ => reply = Some(now),
            }
        }
        reply.ok_or_else(|| "no answer".to_owned())
    }
}

impl Hole {
    /// Returns `true` if the hole is about this mutation.
    pub fn matches(&self, mutation: &Mutation) -> bool {
        self.file == mutation.file && self.lines.iter().any(|line| mutation.text.contains(line.as_str()))
    }
}

/// Returns the names of the modules in a source.
fn modules(text: &str) -> impl Iterator<Item = &str> {
    let heads = text.lines().filter_map(|line| line.trim_start().strip_prefix("module "));
    heads.filter_map(|rest| rest.split(|c: char| !(c.is_alphanumeric() || c == '_')).find(|word| !word.is_empty()))
}

/// Draws mutations and writes the design that they are about as `base.il`.
fn draw(
    claim: &Claim,
    read: &str,
    folder: &Path,
    originals: &Path,
    number: usize,
    seed: u32,
) -> Result<Vec<Mutation>, EngineError> {
    let mut texts = BTreeMap::new();
    for file in &claim.sources {
        let path = originals.join(file);
        let name = path.file_name().map_or(file.clone(), |name| name.to_string_lossy().into_owned());
        texts.insert(name, fs::read_to_string(&path).map_err(at_path(&path))?);
    }
    let of_claim = texts.iter().filter(|(file, _)| !claim.elsewhere.contains_key(*file));
    let modules: Vec<&str> =
        of_claim.flat_map(|(_, text)| modules(text)).filter(|name| !claim.cut.iter().any(|cut| cut == name)).collect();
    let list = folder.join("mutations.txt");
    let top = top_option(claim);
    let mut asked = number;
    loop {
        // The first of a longer list are those of a shorter one.
        let script = format!(
            "{read}hierarchy -check {top}\nproc\nwrite_rtlil base.il\nmutate -list {asked} -seed {seed} -o \
             mutations.txt {}\n",
            selection(&modules)
        );
        run_yosys(&script, folder)?;
        let text = fs::read_to_string(&list).map_err(at_path(&list))?;
        let mut drawn: Vec<Mutation> = text.lines().filter_map(|line| Mutation::parse(line, &texts)).collect();
        if drawn.len() >= number || text.lines().count() < asked {
            drawn.truncate(number);
            (1..).zip(&mut drawn).for_each(|(number, mutation)| mutation.number = number);
            return Ok(drawn);
        }
        asked += number - drawn.len();
    }
}

/// Returns what selects modules in Yosys, which calls a module with parameters `$paramod..\NAME` or
/// `$paramod\NAME\P=V..`.
fn selection(modules: &[&str]) -> String {
    let one = |name: &&str| format!("{name} $paramod*\\{name} $paramod\\{name}\\*");
    modules.iter().map(one).collect::<Vec<_>>().join(" ")
}

/// Returns the name in the source of a module of Yosys, see [`selection`].
fn source_name(module: &str) -> &str {
    match module.strip_prefix("$paramod\\") {
        Some(rest) => rest.split('\\').next().unwrap_or_default(),
        None => module.rsplit('\\').next().unwrap_or_default(),
    }
}

impl Mutation {
    /// Reads a line of `mutate -list`. Returns `None` for pins that are no part of the modules: clocks, which the
    /// transition system does not have, enables of memories that are read without a clock, and observers of a proof.
    fn parse(line: &str, sources: &BTreeMap<String, String>) -> Option<Self> {
        let line = line.strip_prefix("mutate ")?;
        let words: Vec<&str> = line.split(' ').collect();
        let value = |key: &str| words.iter().position(|word| *word == key).and_then(|at| words.get(at + 1)).copied();
        let (mode, module, cell) = (value("-mode")?, value("-module")?, value("-cell")?);
        let (port, bit, wire) = (value("-port")?, value("-portbit")?, value("-wire"));
        let clock = ["CLK", "clock"].contains(&port) || wire == Some("clock");
        if clock || (cell.starts_with("$memrd") && port == "EN") {
            return None;
        }
        // The cell's place is the shortest range; that of a wire is its declaration.
        let places = words.iter().zip(words.iter().skip(1)).filter(|(key, _)| **key == "-src").map(|(_, value)| value);
        let places: Vec<(&str, usize)> = places
            .filter_map(|place| {
                let (file, range) = place.rsplit_once(':')?;
                Some((file, range.split(['.', '-']).next()?.parse().ok()?))
            })
            .filter(|(_, line)| *line > 0)
            .collect();
        // Observers are inserted at the end of the module.
        let observed = |(file, line): &(&str, usize)| {
            let text = sources.get(*file).map_or("", String::as_str);
            text.lines().position(|line| line.starts_with("endmodule")).unwrap_or_default() < *line
        };
        if places.iter().any(observed) {
            return None;
        }
        let declaration = |&(file, line): &(&str, usize)| {
            let text = sources.get(file).and_then(|text| text.lines().nth(line - 1)).unwrap_or_default().trim_start();
            ["module ", "input ", "output ", "reg ", "always "].iter().any(|word| text.starts_with(word))
        };
        let (file, line_number) =
            places.iter().find(|place| !declaration(place)).or(places.first()).copied().unwrap_or(("", 0));
        let text = sources.get(file).and_then(|text| text.lines().nth(line_number.wrapping_sub(1))).unwrap_or_default();
        let control = value("-ctrlbit").map_or(String::new(), |bit| format!(" by bit {bit}"));
        let command = ["-mode", "-module", "-cell", "-port", "-portbit", "-ctrlbit"]
            .iter()
            .filter_map(|key| Some(format!("{key} {}", value(key)?)))
            .collect::<Vec<_>>()
            .join(" ");
        Some(Self {
            number: 0,
            mode: format!("{mode}{control}"),
            module: module.to_owned(),
            port: format!("{port}[{bit}] of {cell}"),
            wire: wire.map(|wire| format!("{wire}[{}]", value("-wirebit").unwrap_or("0"))),
            file: file.to_owned(),
            line: line_number,
            text: text.trim().to_owned(),
            command,
        })
    }
}

/// Returns the names of what the surroundings of the modules under a claim see: outputs of the modules that the wrapper
/// instantiates, and inputs of those that the claim abstracts, after the name of the wrapper. `own` are the modules of
/// the claim's sources; `design` is written by `write_rtlil`.
fn outputs(claim: &Claim, own: &[&str], design: &str) -> (String, Vec<Output>) {
    let mut modules: BTreeMap<&str, Module> = BTreeMap::new();
    let (mut current, mut top, mut is_top) = ("", "", false);
    for line in design.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            ["attribute", "\\top", _] => is_top = true,
            ["module", name] if line.starts_with("module ") => {
                current = name.trim_start_matches('\\');
                if std::mem::take(&mut is_top) {
                    top = current;
                }
            }
            ["cell", kind, name] => {
                let names = [*kind, *name].map(|word| word.trim_start_matches('\\'));
                modules.entry(current).or_default().instances.push((names[0], names[1]));
            }
            ["wire", settings @ .., name] => {
                let of = modules.entry(current).or_default();
                let name = name.trim_start_matches('\\');
                if settings.contains(&"output") {
                    of.outputs.push(name);
                } else if settings.contains(&"input") {
                    of.inputs.push(name);
                }
            }
            _ => {}
        }
    }
    let mut found = Vec::new();
    let mut open = vec![(top, String::new())];
    while let Some((module, path)) = open.pop() {
        let Some(of) = modules.get(module) else { continue };
        for (kind, name) in &of.instances {
            let inner = format!("{path}{name}.");
            let source = source_name(kind);
            let Some(instance) = modules.get(kind).filter(|_| own.contains(&source)) else { continue };
            let ports: &[&str] = match (claim.cut.iter().any(|cut| cut == source), path.is_empty()) {
                (true, _) => &instance.inputs,
                (false, true) => &instance.outputs,
                (false, false) => &[],
            };
            found.extend(ports.iter().filter(|port| **port != "clock").map(|port| Output {
                module: (*kind).to_owned(),
                port: (*port).to_owned(),
                wire: format!("{inner}{port}"),
            }));
            open.push((kind, inner));
        }
    }
    (top.to_owned(), found)
}

/// A port that the surroundings of the modules under a claim see.
#[derive(Debug)]
struct Output {
    module: String,
    port: String,
    /// Name of its wire in the flat module.
    wire: String,
}

/// Ports and instances of a module.
#[derive(Debug, Default)]
struct Module<'a> {
    inputs: Vec<&'a str>,
    outputs: Vec<&'a str>,
    /// Type and name of each cell.
    instances: Vec<(&'a str, &'a str)>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::find_program;

    const HOLD: &str =
        "module hold #(parameter BITS = 2) (input wire clock, input wire enable, input wire [BITS-1:0] x,
  output reg [BITS-1:0] y, output wire [BITS-1:0] sum);
initial y = 0;
always @(posedge clock)
  if (enable)
    y <= x;
assign sum = x + y;
wire unused = ^sum;
endmodule
";
    /// Nothing is said of the sums. Without initial values an assumption about the first step makes both sides equal.
    fn properties(is_assumed: bool) -> String {
        let [initial, first, unless] = match is_assumed {
            true => ["", "reg begun = 0; always @(posedge clock) if (!begun) assume (enable);", "!begun || "],
            false => [" = 0", "reg begun = 1;", ""],
        };
        format!(
            "module hold_properties (input clock);
(* anyseq *) reg enable; (* anyseq *) reg [3:0] x;
wire [1:0] y_2, sum_2; wire [3:0] y_4, sum_4;
hold #(.BITS(2)) hold_2 (.clock(clock), .enable(enable), .x(x[1:0]), .y(y_2), .sum(sum_2));
hold #(.BITS(4)) hold_4 (.clock(clock), .enable(enable), .x(x), .y(y_4), .sum(sum_4));
{first}
reg [1:0] last_2{initial}; reg [3:0] last_4{initial};
always @(posedge clock) begin
  begun <= 1;
  if (enable) {{last_2, last_4}} <= {{x[1:0], x}};
  of_2: assert ({unless}y_2 == last_2);
  of_4: assert ({unless}y_4 == last_4);
end
endmodule
"
        )
    }

    #[test]
    fn the_part_of_a_mutation_gives_the_class_that_the_whole_gives() {
        if !["yosys", "yices-smt2"].iter().all(|program| find_program(program).is_some()) {
            eprintln!("SKIPPED: no yosys or no yices-smt2; `make test` installs them");
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("hold.v"), HOLD).unwrap();
        let (out, limit, solver) = (folder.path(), Duration::from_secs(100), Solver::default());
        let place = Place { sources: folder.path(), out, limit, solver };
        let settings = "statement = ''\nsources = ['hold.v']\ndepth = 2\ncover = 4\nfault = 4\n";
        for is_joined in [false, true] {
            let claim = Claim::parse("hold", settings, &properties(is_joined)).unwrap();
            let campaign = Campaign::new(&claim, &place, 60, 3).unwrap();
            let whole = campaign.system.whole(&campaign.parts);
            let mut seen = Vec::new();
            for mutation in campaign.mutations() {
                let part = campaign.system.part(&campaign.parts, mutation.number);
                let [registers, all] = [&part, &whole].map(|of| campaign.system.registers(of).count());
                assert!(is_joined || registers < all, "{mutation:?}: {registers} of {all} registers");
                let class = campaign.class_in(&part, mutation.number).unwrap();
                assert_eq!(class, campaign.class_in(&whole, mutation.number).unwrap(), "{mutation:?}");
                seen.push(class);
            }
            for class in [Class::Harmless, Class::Refuted, Class::Survivor] {
                assert!(seen.contains(&class), "{class:?}: {seen:?}");
            }
        }
    }
}
