//! The registers and memories of a model.

use hoverlock_harness::model::Model;

/// A register, or a memory that a clock writes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Register {
    /// The name below the top module, `u_core.state`.
    pub name: String,
    /// The module that declares it, as written in the source.
    pub module: String,
    /// Words: 1 for a register.
    pub words: usize,
    /// Bits of a word.
    pub width: u32,
}

impl Register {
    /// Returns the number of its bits.
    pub fn bits(&self) -> u64 {
        self.words as u64 * u64::from(self.width)
    }
}

/// A bit of a register or memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Bit {
    /// Index of the register in [`State::registers`].
    pub register: usize,
    /// The word of a memory, from its lowest index; 0 for a register.
    pub word: usize,
    /// The bit of the word, the lowest is 0.
    pub bit: u32,
}

/// A part of the state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Registers and memories.
    All,
    /// What is no array: flip-flops.
    Registers,
    /// Arrays.
    Memories,
}

/// The registers and memories of a model, and the part of them in which faults may be.
#[derive(Debug, Clone, Default)]
pub struct State {
    registers: Vec<Register>,
    /// Indices of the registers in which faults may be.
    chosen: Vec<usize>,
    /// The number of bits before each of these, and of all.
    before: Vec<u64>,
}

impl State {
    /// Returns the registers and memories of a model. It must be built with
    /// [`Build::registers`](hoverlock_harness::build::Build::registers): otherwise those inside are missing.
    pub fn of(model: &Model) -> Self {
        let signals = model.signals().iter().filter(|signal| signal.register && !signal.real);
        Self::new(signals.map(|signal| Register {
            name: signal.name.clone(),
            module: signal.module.clone(),
            words: signal.range.map_or(1, |(first, last)| first.abs_diff(last) as usize + 1),
            width: signal.width,
        }))
    }

    /// Creates a state of these registers, with faults in any of them.
    pub fn new(registers: impl IntoIterator<Item = Register>) -> Self {
        let state = Self { registers: registers.into_iter().collect(), ..Self::default() };
        state.choose(|_| true)
    }

    /// Chooses the registers in which faults may be.
    fn choose(self, is_wanted: impl Fn(&Register) -> bool) -> Self {
        let registers = self.registers;
        let chosen: Vec<usize> = (0..registers.len()).filter(|at| is_wanted(&registers[*at])).collect();
        let mut before = vec![0];
        let mut bits = 0;
        for at in &chosen {
            bits += registers[*at].bits();
            before.push(bits);
        }
        Self { registers, chosen, before }
    }

    /// Restricts faults to a part, and there to registers whose names or modules match one of the patterns, in which
    /// `*` stands for any text; no pattern restricts nothing.
    pub fn only(self, part: Part, patterns: &[String]) -> Self {
        let is_in_part = |register: &Register| match part {
            Part::All => true,
            Part::Registers => register.words == 1,
            Part::Memories => register.words > 1,
        };
        let is_named = |register: &Register| {
            patterns.is_empty()
                || patterns.iter().any(|pattern| matches(pattern, &register.name) || matches(pattern, &register.module))
        };
        self.choose(|register| is_in_part(register) && is_named(register))
    }

    /// Returns the registers, in the order of the Verilog.
    pub fn registers(&self) -> &[Register] {
        &self.registers
    }

    /// Returns the registers in which faults may be.
    pub fn chosen(&self) -> impl Iterator<Item = &Register> {
        self.chosen.iter().map(|at| &self.registers[*at])
    }

    /// Returns the number of bits in which faults may be.
    pub fn bits(&self) -> u64 {
        self.before.last().copied().unwrap_or(0)
    }

    /// Returns the register of a bit.
    ///
    /// # Panics
    /// If the bit is of another state.
    pub fn register(&self, bit: Bit) -> &Register {
        &self.registers[bit.register]
    }

    /// Returns the bit of a number from 0 to [`State::bits`] - 1, `None` beyond.
    pub fn bit(&self, number: u64) -> Option<Bit> {
        let place = self.before.partition_point(|before| *before <= number).checked_sub(1)?;
        let register = *self.chosen.get(place)?;
        let width = u64::from(self.registers[register].width);
        let within = number - self.before[place];
        Some(Bit { register, word: (within / width) as usize, bit: (within % width) as u32 })
    }
}

/// Returns `true` if a name matches a pattern in which `*` stands for any text.
fn matches(pattern: &str, name: &str) -> bool {
    match pattern.split_once('*') {
        None => pattern == name,
        Some((head, tail)) => name.strip_prefix(head).is_some_and(|rest| {
            rest.char_indices().map(|(at, _)| at).chain([rest.len()]).any(|at| matches(tail, &rest[at..]))
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn register(name: &str, module: &str, words: usize, width: u32) -> Register {
        Register { name: name.into(), module: module.into(), words, width }
    }

    #[test]
    fn every_bit_has_a_number() {
        let state = State::new([register("a", "t", 1, 3), register("u.m", "ram", 4, 5), register("b", "t", 1, 1)]);
        assert_eq!(state.bits(), 24);
        let all: Vec<Bit> = (0..24).map(|number| state.bit(number).unwrap()).collect();
        let at = |register, word, bit| Bit { register, word, bit };
        assert_eq!((all[0], all[2], all[3]), (at(0, 0, 0), at(0, 0, 2), at(1, 0, 0)));
        assert_eq!((all[8], all[22], all[23]), (at(1, 1, 0), at(1, 3, 4), at(2, 0, 0)));
        let distinct: std::collections::HashSet<_> = all.iter().collect();
        assert_eq!(distinct.len(), 24);
        assert_eq!((state.bit(24), State::default().bit(0)), (None, None));
    }

    #[test]
    fn a_part_is_chosen_by_name_or_module() {
        let state = State::new([register("a", "t", 1, 3), register("u.m", "ram", 4, 5), register("u.at", "ram", 1, 2)]);
        let only = |part, patterns: &[&str]| {
            let patterns: Vec<String> = patterns.iter().map(|text| (*text).to_owned()).collect();
            state.clone().only(part, &patterns)
        };
        let bits = |patterns: &[&str]| only(Part::All, patterns).bits();
        assert_eq!(
            (bits(&[]), bits(&["ram"]), bits(&["u.*"]), bits(&["*a*t"]), bits(&["a", "u.at"])),
            (25, 22, 22, 2, 5)
        );
        assert_eq!(bits(&["none"]), 0);
        let parts = [Part::All, Part::Registers, Part::Memories].map(|part| only(part, &[]).bits());
        assert_eq!(parts, [25, 5, 20]);
        // A bit keeps the index of its register in the whole.
        assert_eq!(only(Part::Registers, &["ram"]).bit(1), Some(Bit { register: 2, word: 0, bit: 1 }));
        assert_eq!(only(Part::Registers, &["ram"]).bit(2), None);
        assert_eq!(
            only(Part::All, &["ram"]).chosen().map(|register| register.name.as_str()).collect::<Vec<_>>(),
            ["u.m", "u.at"]
        );
    }
}
