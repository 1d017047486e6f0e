//! A bench for any core with one clock: its inputs are driven at random or from a table, and its outputs are compared
//! in each clock cycle with those of the run without a fault.
//!
//! In the first half of a cycle the clock is low: inputs change, a fault is written, the outputs settle and are
//! compared. Then the clock rises. Cycle 0 follows the reset.

use std::ops::Range;

use hoverlock_harness::build::Build;
use hoverlock_harness::model::{Direction, Library, Message, Model, SignalId, SignalInfo};
use hoverlock_harness::{BuildError, ModelError, nearest};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::class::Class;
use crate::draw::{Fault, Injection};
use crate::state::State;

/// Clock cycles of the reset.
const RESET_CYCLES: u64 = 4;

/// The most 32-bit words that the inputs or the outputs of a run may have, all cycles together: 1 GiB.
const MAX_WORDS: u64 = 1 << 28;

/// Names by which a clock is found, the most usual first.
const CLOCKS: [&str; 8] = ["clk", "clock", "clk_i", "i_clk", "aclk", "CLK", "wb_clk_i", "sys_clk"];

/// Names by which a reset that is active at 1 is found.
const RESETS: [&str; 7] = ["rst", "reset", "rst_i", "i_rst", "i_reset", "RST", "wb_rst_i"];

/// Names by which a reset that is active at 0 is found.
const LOW_RESETS: [&str; 8] = ["rst_n", "reset_n", "resetn", "rstn", "rst_ni", "aresetn", "nreset", "nrst"];

/// Why a core has no campaign.
#[derive(Debug, thiserror::Error)]
pub enum CoreError {
    /// The Verilog does not become a model.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The model cannot be used.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A port of that direction was named that the top does not have.
    #[error("the top has no {what} '{name}'{}", meant(.nearest))]
    NoSuchPort {
        /// What the port should be: `input`, `output`.
        what: &'static str,
        /// The name.
        name: String,
        /// Ports with similar names.
        nearest: Vec<String>,
    },
    /// No clock was named, and no input has the usual name of one.
    #[error("no input is named like a clock (clk, clock, ..): name it")]
    NoClock,
    /// A port cannot be driven or compared.
    #[error("port '{name}' {reason}")]
    Port {
        /// The name.
        name: String,
        /// Why not.
        reason: &'static str,
    },
    /// A value does not fit its input, or is no number.
    #[error("'{text}' is no value of input '{name}' of {width} bits")]
    Value {
        /// The input.
        name: String,
        /// Its width.
        width: u32,
        /// The text.
        text: String,
    },
    /// The table cannot be read.
    #[error("line {line}: {reason}")]
    Table {
        /// The line, from 1.
        line: usize,
        /// What is wrong.
        reason: String,
    },
    /// The run is too short, too long, or nothing is compared in it.
    #[error("{0}")]
    Run(String),
}

/// Returns the question about the name that was meant, if any is near.
fn meant(nearest: &[String]) -> String {
    nearest.first().map(|name| format!("; did you mean {name}?")).unwrap_or_default()
}

/// What drives the inputs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Stimulus {
    /// Every bit of every input is drawn from this seed in each cycle.
    Random(u64),
    /// The text of a table with commas: the first line names inputs, each other line has their values in a cycle, in
    /// decimal or with `0x`. An empty cell keeps the value before. Inputs without a column are 0.
    Table(String),
}

/// The options of a bench.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// The clock; `None` looks for a usual name.
    pub clock: Option<String>,
    /// The reset, and whether it is active at 0; `None` looks for a usual name, and runs without one if there is none.
    pub reset: Option<(String, bool)>,
    /// What drives the inputs.
    pub stimulus: Stimulus,
    /// Inputs that are constant, with their values.
    pub constants: Vec<(String, String)>,
    /// An output that is 1 in the cycles in which the other outputs count; `None` compares all in every cycle.
    pub valid: Option<String>,
    /// Outputs by which the core says that something is wrong.
    pub detect: Vec<String>,
    /// Clock cycles of a run after the reset; `None` takes the lines of the table, or 2000.
    pub cycles: Option<u64>,
    /// Clock cycles after the fault from which a wrong output is [`Class::Silent`] rather than [`Class::Recovered`].
    pub frame: u64,
}

/// Clock cycles of a run with random inputs.
const DEFAULT_CYCLES: u64 = 2000;

/// Some words of the inputs or outputs in a cycle.
#[derive(Debug, Clone)]
struct Port {
    name: String,
    width: u32,
    /// Its 32-bit words among those of a cycle.
    words: Range<usize>,
}

/// Ports with their place in the words of a cycle.
#[derive(Debug, Clone, Default)]
struct Layout {
    ports: Vec<Port>,
    words: usize,
}

impl Layout {
    fn add(&mut self, info: &SignalInfo) -> Result<(), CoreError> {
        let refused = |reason| Err(CoreError::Port { name: info.name.clone(), reason });
        if info.real || info.range.is_some() {
            return refused("is an array or a real, which cannot be driven or compared: wrap the core");
        }
        let words = self.words..self.words + info.width.div_ceil(32) as usize;
        self.words = words.end;
        self.ports.push(Port { name: info.name.clone(), width: info.width, words });
        Ok(())
    }

    fn find(&self, what: &'static str, name: &str) -> Result<&Port, CoreError> {
        self.ports.iter().find(|port| port.name == name).ok_or_else(|| CoreError::NoSuchPort {
            what,
            name: name.to_owned(),
            nearest: nearest(name, self.ports.iter().map(|port| port.name.as_str())),
        })
    }

    fn ids(&self, model: &Model) -> Result<Vec<SignalId>, ModelError> {
        self.ports.iter().map(|port| model.find(&port.name)).collect()
    }
}

/// A core with its stimulus and the run without a fault.
#[derive(Debug, Clone)]
pub struct Core {
    library: Library,
    state: State,
    clock: String,
    /// Name, and the level at which it is active.
    reset: Option<(String, u64)>,
    inputs: Layout,
    outputs: Layout,
    /// The words of the valid output among those of a cycle.
    valid: Option<Range<usize>>,
    /// The words of the outputs that say that something is wrong.
    detect: Vec<Range<usize>>,
    cycles: u64,
    frame: u64,
    /// The words of the inputs and of the outputs, cycle after cycle.
    driven: Vec<u32>,
    golden: Vec<u32>,
}

/// How a run ended.
#[derive(Default)]
struct Ending {
    /// The cycle in which the Verilog called `$finish`, or from which on the model cannot be evaluated any more.
    early: Option<u64>,
    /// The Verilog called `$error`, `$fatal` or `$stop`, or an assertion failed.
    complained: bool,
}

impl Core {
    /// Builds the core and runs it without a fault.
    ///
    /// # Errors
    /// If the Verilog does not become a model, an option does not fit it, or the run ends early or compares nothing.
    pub fn new(build: &Build, options: &Options) -> Result<Self, CoreError> {
        let library = build.clone().registers(true).compile()?;
        let model = library.instance()?;
        let signals: Vec<&SignalInfo> =
            model.signals().iter().filter(|signal| signal.direction != Direction::Internal).collect();
        let is_input =
            |name: &str| signals.iter().any(|s| s.name == name && s.direction == Direction::Input && s.width == 1);
        let clock = match &options.clock {
            Some(name) => name.clone(),
            None => CLOCKS.iter().find(|name| is_input(name)).ok_or(CoreError::NoClock)?.to_string(),
        };
        let usual = |names: &[&str], low: bool| names.iter().find(|n| is_input(n)).map(|n| ((*n).to_owned(), low));
        let reset = options.reset.clone().or_else(|| usual(&RESETS, false)).or_else(|| usual(&LOW_RESETS, true));
        for name in std::iter::once(&clock).chain(reset.iter().map(|(name, _)| name)) {
            if !is_input(name) {
                let names = signals.iter().map(|signal| signal.name.as_str()).filter(|name| is_input(name));
                return Err(CoreError::NoSuchPort {
                    what: "input of one bit",
                    name: name.clone(),
                    nearest: nearest(name, names),
                });
            }
        }
        let (mut inputs, mut outputs) = (Layout::default(), Layout::default());
        for signal in &signals {
            let is_wired = signal.name == clock || reset.as_ref().is_some_and(|(name, _)| *name == signal.name);
            match signal.direction {
                Direction::Input if !is_wired => inputs.add(signal)?,
                Direction::Output => outputs.add(signal)?,
                Direction::Inout => {
                    let reason = "is an inout, which is neither driven nor compared: wrap the core";
                    return Err(CoreError::Port { name: signal.name.clone(), reason });
                }
                _ => {}
            }
        }
        if outputs.words == 0 {
            return Err(CoreError::Run("the top has no outputs to compare".into()));
        }
        let place = |name: &String| Ok::<_, CoreError>(outputs.find("output", name)?.words.clone());
        let valid = options.valid.as_ref().map(place).transpose()?;
        let detect = options.detect.iter().map(place).collect::<Result<Vec<_>, _>>()?;
        let (driven, rows) = stimulus(&inputs, options)?;
        let mut core = Self {
            state: State::of(&model),
            library,
            clock,
            reset: reset.map(|(name, low)| (name, u64::from(!low))),
            cycles: rows,
            frame: options.frame,
            valid,
            detect,
            driven,
            golden: Vec::new(),
            inputs,
            outputs,
        };
        if core.window().is_empty() {
            let (cycles, frame) = (core.cycles, core.frame);
            return Err(CoreError::Run(format!("{cycles} cycles are no more than two frames of {frame}: run longer")));
        }
        if core.outputs.words as u64 * core.cycles > MAX_WORDS {
            return Err(CoreError::Run(format!("the outputs of {} cycles are over 1 GiB: run shorter", core.cycles)));
        }
        core.check_golden()?;
        Ok(core)
    }

    /// Runs without a fault and keeps the outputs.
    fn check_golden(&mut self) -> Result<(), CoreError> {
        let mut golden = Vec::with_capacity(self.outputs.words * self.cycles as usize);
        let ending = self.play(None, |_, words| golden.extend_from_slice(words))?;
        let fails = |text: String| Err(CoreError::Run(text));
        if let Some(cycle) = ending.early {
            return fails(format!("without a fault the Verilog ends the run in cycle {cycle}: run fewer cycles"));
        }
        if ending.complained {
            return fails("without a fault the Verilog reports an error: the stimulus breaks its rules".into());
        }
        let is_never = |valid: &Range<usize>| {
            let mut cycles = golden.chunks_exact(self.outputs.words);
            cycles.all(|words| is_zero(&words[valid.clone()]))
        };
        if self.valid.as_ref().is_some_and(is_never) {
            return fails("the valid output is never 1 without a fault: nothing would be compared".into());
        }
        self.golden = golden;
        Ok(())
    }

    /// Returns the registers and memories in which faults can be.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Returns the cycles in which a fault may happen: the run goes on for two frames after the last.
    pub fn window(&self) -> Range<u64> {
        0..self.cycles.saturating_sub(2 * self.frame)
    }

    /// Returns the clock, and the reset with the level at which it is active.
    pub fn clock_and_reset(&self) -> (&str, Option<(&str, u64)>) {
        (&self.clock, self.reset.as_ref().map(|(name, level)| (name.as_str(), *level)))
    }

    /// Returns the clock cycles of a run after the reset.
    pub fn cycles(&self) -> u64 {
        self.cycles
    }

    /// Returns how many outputs change in the run without a fault, and how many there are: outputs that never change
    /// show that the stimulus does not use the core.
    pub fn active_outputs(&self) -> (usize, usize) {
        let first = &self.golden[..self.outputs.words];
        let changes = |port: &&Port| {
            let mut cycles = self.golden.chunks_exact(self.outputs.words);
            cycles.any(|words| words[port.words.clone()] != first[port.words.clone()])
        };
        (self.outputs.ports.iter().filter(changes).count(), self.outputs.ports.len())
    }

    /// Runs the core with a fault.
    ///
    /// # Errors
    /// If the model cannot be made, or the fault is not in its state.
    pub fn run(&self, fault: &Fault) -> Result<Class, CoreError> {
        let width = self.outputs.words;
        let (mut last_wrong, mut detected) = (None, false);
        let ending = self.play(Some(fault), |cycle, words| {
            let golden = &self.golden[cycle as usize * width..][..width];
            if words != golden {
                detected |= self.detect.iter().flat_map(Range::clone).any(|at| words[at] & !golden[at] != 0);
                // Where only one of the two is valid, that alone is the difference.
                last_wrong = Some(cycle);
            }
        })?;
        Ok(match last_wrong {
            _ if ending.early.is_some() => Class::Hang,
            _ if detected || ending.complained => Class::Detected,
            None => Class::Masked,
            Some(cycle) if cycle < fault.cycle + self.frame => Class::Recovered,
            Some(_) => Class::Silent,
        })
    }

    /// Runs from the reset on, and gives the outputs of each cycle.
    fn play(&self, fault: Option<&Fault>, mut observe: impl FnMut(u64, &[u32])) -> Result<Ending, CoreError> {
        let mut model = self.library.instance()?;
        let clock = model.find(&self.clock)?;
        let find = |(name, level): &(String, u64)| Ok::<_, ModelError>((model.find(name)?, *level));
        let reset = self.reset.as_ref().map(find).transpose()?;
        let (inputs, outputs) = (self.inputs.ids(&model)?, self.outputs.ids(&model)?);
        let injection = fault.map(|fault| Injection::new(&model, &self.state, fault)).transpose()?;
        let mut ending = Ending::default();
        let mut seen = vec![0; self.outputs.words];
        let first = self.driven.get(..self.inputs.words).unwrap_or_default();
        drive(&mut model, &self.inputs, &inputs, first)?;
        if let Some((id, level)) = reset {
            model.set(id, level)?;
        }
        for _ in 0..RESET_CYCLES {
            for level in [0, 1] {
                model.set(clock, level)?;
                if !step(&mut model, &mut ending) {
                    return Ok(Ending { early: Some(0), ..ending });
                }
            }
        }
        if let Some((id, level)) = reset {
            model.set(id, 1 - level)?;
        }
        for cycle in 0..self.cycles {
            let words = &self.driven[cycle as usize * self.inputs.words..][..self.inputs.words];
            drive(&mut model, &self.inputs, &inputs, words)?;
            model.set(clock, 0)?;
            if let Some(injection) = &injection {
                injection.apply(&mut model, cycle)?;
            }
            let mut goes_on = step(&mut model, &mut ending);
            if goes_on {
                self.sample(&model, &outputs, &mut seen);
                observe(cycle, &seen);
                model.set(clock, 1)?;
                goes_on = step(&mut model, &mut ending);
            }
            if !goes_on {
                return Ok(Ending { early: Some(cycle), ..ending });
            }
        }
        Ok(ending)
    }

    /// Reads the outputs; those that do not count in this cycle are 0.
    fn sample(&self, model: &Model, ids: &[SignalId], seen: &mut [u32]) {
        for (port, id) in self.outputs.ports.iter().zip(ids) {
            let words = &mut seen[port.words.clone()];
            match words {
                [low] => *low = model.get(*id) as u32,
                [low, high] => {
                    let value = model.get(*id);
                    (*low, *high) = (value as u32, (value >> 32) as u32);
                }
                wide => wide.copy_from_slice(&model.get_words(*id)),
            }
        }
        if self.valid.as_ref().is_some_and(|valid| is_zero(&seen[valid.clone()])) {
            let counts = |at: usize| self.detect.iter().any(|words| words.contains(&at));
            seen.iter_mut().enumerate().filter(|(at, _)| !counts(*at)).for_each(|(_, word)| *word = 0);
        }
    }
}

/// Returns `true` if the value in these words is 0.
fn is_zero(words: &[u32]) -> bool {
    words.iter().all(|word| *word == 0)
}

/// Evaluates the model; returns `false` if the run ends here.
fn step(model: &mut Model, ending: &mut Ending) -> bool {
    let mut goes_on = model.eval().is_ok();
    for message in model.take_messages() {
        match message {
            Message::Finish { .. } => goes_on = false,
            Message::Stop { .. } => ending.complained = true,
            Message::Text(_) | Message::Fatal { .. } => {}
        }
    }
    goes_on
}

fn drive(model: &mut Model, layout: &Layout, ids: &[SignalId], words: &[u32]) -> Result<(), ModelError> {
    for (port, id) in layout.ports.iter().zip(ids) {
        match &words[port.words.clone()] {
            [low] => model.set(*id, u64::from(*low))?,
            wide => model.set_words(*id, wide)?,
        }
    }
    Ok(())
}

/// Returns the words of the inputs in all cycles, and the number of cycles.
fn stimulus(inputs: &Layout, options: &Options) -> Result<(Vec<u32>, u64), CoreError> {
    let constants = options
        .constants
        .iter()
        .map(|(name, text)| {
            let port = inputs.find("input", name)?;
            Ok((port.words.clone(), value(port, text)?))
        })
        .collect::<Result<Vec<_>, CoreError>>()?;
    let check = |cycles: u64| match cycles.saturating_mul(inputs.words as u64) {
        words if words > MAX_WORDS => {
            Err(CoreError::Run(format!("the inputs of {cycles} cycles are over 1 GiB: run shorter")))
        }
        _ => Ok(cycles),
    };
    let mut driven = Vec::new();
    let cycles = match &options.stimulus {
        Stimulus::Random(seed) => {
            let cycles = check(options.cycles.unwrap_or(DEFAULT_CYCLES))?;
            let mut random = ChaCha8Rng::seed_from_u64(*seed);
            for _ in 0..cycles {
                for port in &inputs.ports {
                    let unused = 32 * port.words.len() as u32 - port.width;
                    driven.extend(port.words.clone().map(|_| random.random::<u32>()));
                    if let Some(last) = driven.last_mut() {
                        *last &= u32::MAX >> unused;
                    }
                }
            }
            cycles
        }
        Stimulus::Table(text) => {
            let rows = table(inputs, text, &options.constants)?;
            let count = (rows.len() / inputs.words.max(1)) as u64;
            let cycles = check(options.cycles.unwrap_or(count))?;
            driven = rows;
            // After its last line the inputs keep their values.
            let last = driven.split_at(driven.len().saturating_sub(inputs.words)).1.to_vec();
            let missing = cycles.saturating_sub(count) as usize;
            driven.extend(std::iter::repeat_n(last, missing).flatten());
            driven.truncate(cycles as usize * inputs.words);
            cycles
        }
    };
    for row in driven.chunks_exact_mut(inputs.words.max(1)) {
        for (words, value) in &constants {
            row[words.clone()].copy_from_slice(value);
        }
    }
    Ok((driven, cycles))
}

/// Reads the table: the words of the inputs, line after line. It has no column of an input that is constant.
fn table(inputs: &Layout, text: &str, constants: &[(String, String)]) -> Result<Vec<u32>, CoreError> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let broken = |error: csv::Error| CoreError::Table {
        line: error.position().map_or(1, |at| at.line() as usize),
        reason: error.to_string(),
    };
    let mut columns = Vec::new();
    for name in reader.headers().map_err(broken)? {
        let port = inputs.find("input", name)?;
        if columns.iter().any(|other: &&Port| other.name == port.name) {
            return Err(CoreError::Table { line: 1, reason: format!("'{name}' has two columns") });
        }
        if let Some((_, value)) = constants.iter().find(|(constant, _)| *constant == port.name) {
            let reason = format!("'{name}' has a column and is set to {value}; leave one of them out");
            return Err(CoreError::Table { line: 1, reason });
        }
        columns.push(port);
    }
    let mut row = vec![0; inputs.words];
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(broken)?;
        for (port, cell) in columns.iter().zip(&record).filter(|(_, cell)| !cell.is_empty()) {
            let line = record.position().map_or(1, |at| at.line() as usize);
            let value = value(port, cell).map_err(|error| CoreError::Table { line, reason: error.to_string() })?;
            row[port.words.clone()].copy_from_slice(&value);
        }
        rows.extend_from_slice(&row);
    }
    if rows.is_empty() {
        return Err(CoreError::Table { line: 1, reason: "the table has no line with values of its inputs".into() });
    }
    Ok(rows)
}

/// Reads a value of a port, in decimal or with `0x`, as words.
fn value(port: &Port, text: &str) -> Result<Vec<u32>, CoreError> {
    let refused = || CoreError::Value { name: port.name.clone(), width: port.width, text: text.to_owned() };
    let digits = match text.strip_prefix("0x") {
        Some(digits) => digits.to_owned(),
        None => format!("{:x}", text.parse::<u128>().map_err(|_| refused())?),
    };
    let digits = digits.replace('_', "");
    if digits.is_empty() || !digits.chars().all(|c| c.is_ascii_hexdigit()) {
        return Err(refused());
    }
    let digits = digits.trim_start_matches('0');
    let mut words = vec![0u32; port.words.len()];
    for (at, digit) in digits.chars().rev().enumerate() {
        let digit = digit.to_digit(16).ok_or_else(refused)?;
        let place = words.get_mut(at / 8).ok_or_else(refused)?;
        *place |= digit << (4 * (at % 8));
    }
    let unused = 32 * words.len() as u32 - port.width;
    match words.last() {
        Some(last) if *last & !(u32::MAX >> unused) != 0 => Err(refused()),
        _ => Ok(words),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn port(width: u32) -> Port {
        Port { name: "d".into(), width, words: 0..width.div_ceil(32) as usize }
    }

    #[test]
    fn values_fit_their_port() {
        let read = |width, text: &str| value(&port(width), text).ok();
        assert_eq!(read(8, "255"), Some(vec![255]));
        assert_eq!(
            (read(8, "256"), read(8, "0x100"), read(8, "-1"), read(8, ""), read(8, "0x")),
            (None, None, None, None, None)
        );
        assert_eq!(read(70, "0x3f_0000_0001_0000_0002"), Some(vec![2, 1, 63]));
        assert_eq!((read(70, "0x40_0000_0000_0000_0000"), read(32, "4294967295")), (None, Some(vec![u32::MAX])));
        assert_eq!(read(32, "0x000000000ffffffff"), Some(vec![u32::MAX]));
    }

    fn inputs() -> Layout {
        let port = |name: &str, width, words| Port { name: name.into(), width, words };
        Layout { ports: vec![port("a", 4, 0..1), port("b", 40, 1..3)], words: 3 }
    }

    #[test]
    fn a_table_keeps_values_and_names_its_mistakes() {
        assert_eq!(table(&inputs(), "b,a\n0x100000002,3\n,4\n5,\n", &[]).unwrap(), [3, 2, 1, 4, 2, 1, 4, 5, 0]);
        let constants = [("a".to_owned(), "9".to_owned())];
        let message = table(&inputs(), "b,a\n1,2\n", &constants).unwrap_err().to_string();
        assert_eq!(message, "line 1: 'a' has a column and is set to 9; leave one of them out");
        let message = |text: &str| table(&inputs(), text, &[]).unwrap_err().to_string();
        assert_eq!(message("a\n16\n"), "line 2: '16' is no value of input 'a' of 4 bits");
        assert_eq!(message("a,c\n1,2\n"), "the top has no input 'c'; did you mean a?");
        assert_eq!(message("a,a\n1,2\n"), "line 1: 'a' has two columns");
        assert_eq!(message("a\n"), "line 1: the table has no line with values of its inputs");
        assert!(message("a,b\n1\n").starts_with("line 2: "));
    }

    fn options(stimulus: Stimulus, cycles: Option<u64>) -> Options {
        Options {
            clock: None,
            reset: None,
            stimulus,
            constants: vec![("a".into(), "9".into())],
            valid: None,
            detect: Vec::new(),
            cycles,
            frame: 1,
        }
    }

    #[test]
    fn inputs_fill_the_run() {
        let (words, cycles) = stimulus(&inputs(), &options(Stimulus::Table("b\n1\n2\n".into()), Some(4))).unwrap();
        assert_eq!((words, cycles), (vec![9, 1, 0, 9, 2, 0, 9, 2, 0, 9, 2, 0], 4));
        let (words, cycles) = stimulus(&inputs(), &options(Stimulus::Random(3), Some(1000))).unwrap();
        assert_eq!((words.len(), cycles), (3000, 1000));
        assert!(words.chunks_exact(3).all(|row| row[0] == 9 && row[2] < 256));
        assert!(words.chunks_exact(3).any(|row| row[2] > 200));
    }
}
