//! Faults put into the emitted Verilog, many in one model.
//!
//! Each fault replaces one expression of the committed files by another text. All chosen faults go into one set of
//! files, every expression `E` with faults `F_i` replaced by `mutation::id == i ? (F_i) : E`, and `+MUTANT=i` on the
//! command line of the simulation chooses one. So Verilator runs once for all of them, and fault 0, no fault at all, is
//! the control.

use std::{
    collections::{BTreeMap, BTreeSet},
    ops::Range,
    path::{Path, PathBuf},
    process::Command,
};

use rand::{RngExt, SeedableRng, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;

/// The kinds of fault, as engineers make them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    Operator,
    Comparison,
    Constant,
    Swap,
    Stuck,
    Width,
    Enable,
    Reset,
    ResetValue,
    Memory,
    Pipeline,
    Wiring,
}

impl Kind {
    pub const ALL: [Kind; 12] = [
        Kind::Operator,
        Kind::Comparison,
        Kind::Constant,
        Kind::Swap,
        Kind::Stuck,
        Kind::Width,
        Kind::Enable,
        Kind::Reset,
        Kind::ResetValue,
        Kind::Memory,
        Kind::Pipeline,
        Kind::Wiring,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Kind::Operator => "operator",
            Kind::Comparison => "comparison edge",
            Kind::Constant => "constant",
            Kind::Swap => "swapped operands",
            Kind::Stuck => "stuck bit",
            Kind::Width => "width",
            Kind::Enable => "enable",
            Kind::Reset => "reset missing",
            Kind::ResetValue => "reset value",
            Kind::Memory => "memory address or write",
            Kind::Pipeline => "pipeline stage dropped",
            Kind::Wiring => "wiring",
        }
    }
}

/// One fault.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Mutant {
    /// The module, which is its file's name.
    pub module: String,
    /// The line in the file, from 1.
    pub line: usize,
    pub kind: Kind,
    /// What the line says of it, and what stands there instead.
    pub original: String,
    pub fault: String,
    /// The instance whose port is wired wrongly, by its module.
    pub at: Option<String>,
    /// Byte range of the expression in the file.
    site: (usize, usize),
}

/// The file with one fault in place, as by hand.
pub fn by_hand(source: &Source, mutant: &Mutant) -> String {
    let mut text = source.text.clone();
    text.replace_range(mutant.site.0..mutant.site.1, &mutant.fault);
    text
}

/// Whether Yosys proves the module with the fault equivalent to the original. Modules with instances are not tried.
pub fn is_proved_equivalent(sources: &[Source], mutant: &Mutant) -> bool {
    let Some(source) = sources.iter().find(|source| source.module == mutant.module) else { return false };
    if source.text.contains("\n  .clock(clock)") {
        return false;
    }
    let folder = tempfile::tempdir().unwrap();
    let named =
        |text: &str, name: &str| text.replacen(&format!("module {} ", mutant.module), &format!("module {name} "), 1);
    std::fs::write(folder.path().join("gold.v"), named(&source.text, "gold")).unwrap();
    std::fs::write(folder.path().join("gate.v"), named(&by_hand(source, mutant), "gate")).unwrap();
    let script = "read_verilog gold.v gate.v; proc; memory_map; opt -full; equiv_make gold gate both; \
                  hierarchy -top both; clean -purge; equiv_simple -undef; equiv_induct -undef; equiv_status -assert";
    let yosys = Command::new("timeout").args(["30", "yosys", "-q", "-p", script]).current_dir(folder.path()).output();
    yosys.is_ok_and(|output| output.status.success())
}

/// A committed file.
pub struct Source {
    pub module: String,
    pub text: String,
}

pub fn read(paths: &[PathBuf]) -> Vec<Source> {
    let source = |path: &PathBuf| Source {
        module: path.file_stem().unwrap().to_string_lossy().into_owned(),
        text: std::fs::read_to_string(path).unwrap(),
    };
    paths.iter().map(source).collect()
}

/// All faults that can be put into the files.
pub fn all(sources: &[Source]) -> Vec<Mutant> {
    let ports: BTreeMap<&str, BTreeMap<String, (bool, usize)>> =
        sources.iter().map(|source| (source.module.as_str(), signals(&source.text).0)).collect();
    let mut mutants: BTreeSet<Mutant> = BTreeSet::new();
    for source in sources {
        mutants.extend(Reader::new(source, &ports).mutants());
    }
    mutants.into_iter().collect()
}

/// So many of them, every module with one at least, the rest in proportion; kinds in turn.
pub fn choose(all: &[Mutant], count: usize, seed: u64) -> Vec<Mutant> {
    let mut draw = ChaCha8Rng::seed_from_u64(seed);
    let modules: BTreeSet<&str> = all.iter().map(|mutant| mutant.module.as_str()).collect();
    let mut chosen: BTreeSet<&Mutant> = BTreeSet::new();
    if count >= 2 * modules.len() {
        for module in modules {
            let here: Vec<&Mutant> = all.iter().filter(|mutant| mutant.module == module).collect();
            chosen.insert(here.choose(&mut draw).unwrap());
        }
    }
    let mut kinds = Kind::ALL.iter().cycle();
    while chosen.len() < count.min(all.len()) {
        let kind = *kinds.next().unwrap();
        let here: Vec<&Mutant> = all.iter().filter(|mutant| mutant.kind == kind && !chosen.contains(mutant)).collect();
        if let Some(mutant) = here.choose(&mut draw) {
            chosen.insert(mutant);
        }
    }
    chosen.into_iter().cloned().collect()
}

/// Writes the files with all chosen faults; fault `i` is number `i + 1`. Gives their paths, the package first.
pub fn write(folder: &Path, sources: &[Source], mutants: &[Mutant]) -> Vec<PathBuf> {
    let put = |name: &str, text: &str| {
        let path = folder.join(name);
        // A file that has not changed keeps its time, so that the built model is found again.
        if std::fs::read_to_string(&path).ok().as_deref() != Some(text) {
            std::fs::write(&path, text).unwrap();
        }
        path
    };
    std::fs::create_dir_all(folder).unwrap();
    let package = "package mutation;\n  int id;\nendpackage\n\nmodule mutation_choice;\n  \
         initial if ($value$plusargs(\"MUTANT=%d\", mutation::id) == 0) mutation::id = 0;\nendmodule\n";
    let mut paths = vec![put("mutation.sv", package)];
    for source in sources {
        let mut sites: BTreeMap<(usize, usize), Vec<(usize, &Mutant)>> = BTreeMap::new();
        for (i, mutant) in mutants.iter().enumerate().filter(|(_, mutant)| mutant.module == source.module) {
            sites.entry(mutant.site).or_default().push((i + 1, mutant));
        }
        let mut text = source.text.clone();
        for (site, faults) in sites.iter().rev() {
            let original = &source.text[site.0..site.1];
            let faults: String =
                faults.iter().map(|(i, mutant)| format!("mutation::id == {i} ? ({}) : ", mutant.fault)).collect();
            text.replace_range(site.0..site.1, &format!("({faults}({original}))"));
        }
        if source.module == "hoverlock_top" {
            text = text.replace("\nendmodule", "\nmutation_choice mutation_choice ();\n\nendmodule");
        }
        paths.push(put(&format!("{}.sv", source.module), &text));
    }
    paths
}

type Widths = BTreeMap<String, (bool, usize)>;

/// Ports and other signals: whether it is an output, and its width.
fn signals(text: &str) -> (Widths, BTreeMap<String, usize>) {
    let (mut ports, mut others) = (BTreeMap::new(), BTreeMap::new());
    for line in text.lines() {
        let line = line.trim();
        // An attribute says where a signal goes, not what it is.
        let line = line.strip_prefix("(*").and_then(|line| line.split_once("*) ")).map_or(line, |(_, line)| line);
        let mut words = line.split_whitespace();
        let first = words.next().unwrap_or_default();
        if !["input", "output", "wire", "reg"].contains(&first) || line.contains(" memory ") {
            continue;
        }
        let rest = line.trim_start_matches(first).trim().trim_start_matches("wire").trim_start_matches("reg").trim();
        let (width, names) = match rest.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
            Some((range, names)) => (range.split(':').next().unwrap().parse::<usize>().unwrap() + 1, names),
            None => (1, rest),
        };
        let names = names.split('=').next().unwrap();
        for name in names.split([',', ';']).map(str::trim).filter(|name| !name.is_empty()) {
            if first == "input" || first == "output" {
                ports.insert(name.to_owned(), (first == "output", width));
            } else {
                others.insert(name.to_owned(), width);
            }
        }
    }
    (ports, others)
}

struct Reader<'a> {
    source: &'a Source,
    ports: &'a BTreeMap<&'a str, Widths>,
    widths: BTreeMap<String, usize>,
    /// What each plain register takes: `x <= y`.
    takes: BTreeMap<String, String>,
    draw: ChaCha8Rng,
    mutants: Vec<Mutant>,
}

fn is_name(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

impl<'a> Reader<'a> {
    fn new(source: &'a Source, ports: &'a BTreeMap<&'a str, Widths>) -> Self {
        let (own, others) = signals(&source.text);
        let mut widths: BTreeMap<String, usize> = own.iter().map(|(name, (_, width))| (name.clone(), *width)).collect();
        widths.extend(others);
        // The same choices for a file whatever other files there are.
        let seed = source.module.bytes().fold(7u64, |seed, byte| seed.wrapping_mul(31) + u64::from(byte));
        let draw = ChaCha8Rng::seed_from_u64(seed);
        Self { source, ports, widths, takes: BTreeMap::new(), draw, mutants: Vec::new() }
    }

    fn mutants(mut self) -> Vec<Mutant> {
        let text = &self.source.text;
        let body = text.find("\n);\n").map_or(0, |at| at + 4);
        // Statements by their first line; an expression may go on over lines up to its semicolon.
        let mut at = body;
        let mut instance: Option<String> = None;
        let mut in_reset = false;
        let mut statements: Vec<(Range<usize>, bool)> = Vec::new();
        while at < text.len() {
            let end = text[at..].find('\n').map_or(text.len(), |end| at + end);
            let line = &text[at..end];
            let trimmed = line.trim_start();
            let begin = at + line.len() - trimmed.len();
            let skipped = ["//", "(*", "wire unused", "localparam"].iter().any(|word| trimmed.starts_with(word));
            let conditional = ["if (", "else if (", "end else if ("].iter().find(|word| trimmed.starts_with(**word));
            if skipped || trimmed.is_empty() {
                // Nothing to go wrong.
            } else if let Some(condition) = conditional {
                let from = begin + condition.len();
                let to = closing(text, from);
                self.condition(from..to);
                in_reset = if &text[from..to] == "reset" { true } else { in_reset && !trimmed.contains("else") };
            } else if ["end else", "else", "always"].iter().any(|word| trimmed.starts_with(word)) {
                in_reset = false;
            } else if let Some(connection) = trimmed.strip_prefix('.') {
                if let (Some(module), Some((port, _))) = (&instance, connection.split_once('(')) {
                    let from = begin + 1 + port.len() + 1;
                    let to = closing(text, from);
                    self.connection(module.clone(), port, from..to);
                }
            } else if trimmed.ends_with(" (") {
                instance = trimmed.split_whitespace().next().map(str::to_owned);
            } else if trimmed.contains('=') {
                let end = at + text[at..].find(';').unwrap_or(0);
                statements.push((begin..end, in_reset));
                at = end;
                at += text[at..].find('\n').map_or(0, |end| end + 1);
                continue;
            }
            at = end + 1;
        }
        for (range, reset) in &statements {
            if let Some((target, value)) = split(&text[range.clone()]).filter(|_| !reset) {
                let plain = value.chars().all(is_name) && target.chars().all(is_name);
                if plain && text[range.clone()].contains("<=") {
                    self.takes.insert(target.to_owned(), value.to_owned());
                }
            }
        }
        for (range, reset) in statements {
            self.statement(range, reset);
        }
        self.mutants
    }

    fn add(&mut self, site: Range<usize>, kind: Kind, fault: String, at: Option<String>) {
        let text = &self.source.text;
        let original = text[site.clone()].split_whitespace().collect::<Vec<_>>().join(" ");
        let balanced = [('(', ')'), ('{', '}'), ('[', ']')]
            .into_iter()
            .all(|(open, close)| fault.matches(open).count() == fault.matches(close).count());
        if !balanced || fault.split_whitespace().collect::<Vec<_>>().join(" ") == original {
            return;
        }
        self.mutants.push(Mutant {
            module: self.source.module.clone(),
            line: text[..site.start].matches('\n').count() + 1,
            kind,
            original,
            fault,
            at,
            site: (site.start, site.end),
        });
    }

    fn condition(&mut self, site: Range<usize>) {
        let text = self.source.text[site.clone()].to_owned();
        if text == "reset" {
            self.add(site, Kind::Reset, "1'b0".into(), None);
            return;
        }
        self.add(site.clone(), Kind::Enable, "1'b1".into(), None);
        self.add(site.clone(), Kind::Enable, "1'b0".into(), None);
        if let Some((left, right)) = text.split_once(" & ") {
            self.add(site.clone(), Kind::Enable, left.into(), None);
            self.add(site.clone(), Kind::Enable, right.into(), None);
        }
        self.expression(site, &text, false);
    }

    fn connection(&mut self, module: String, port: &str, site: Range<usize>) {
        let text = self.source.text[site.clone()].to_owned();
        let Some((output, width)) = self.ports.get(module.as_str()).and_then(|ports| ports.get(port)).copied() else {
            return;
        };
        if output || port == "clock" {
            return;
        }
        let kind = if port == "reset" { Kind::Reset } else { Kind::Wiring };
        self.add(site.clone(), kind, format!("{width}'d0"), Some(module.clone()));
        let alike: Vec<String> = self
            .widths
            .iter()
            .filter(|(name, w)| **w == width && **name != text && *name != "clock")
            .map(|(name, _)| name.clone())
            .collect();
        if let Some(other) = alike.choose(&mut self.draw).cloned() {
            self.add(site.clone(), Kind::Wiring, other, Some(module.clone()));
        }
        let before = self.mutants.len();
        self.expression(site, &text, false);
        self.mutants[before..].iter_mut().for_each(|mutant| mutant.at = Some(module.clone()));
    }

    fn statement(&mut self, range: Range<usize>, reset: bool) {
        let text = self.source.text[range.clone()].to_owned();
        let Some((target, value)) = split(&text) else { return };
        let (target, value) = (target.to_owned(), value.to_owned());
        let site = range.end - value.len()..range.end;
        let clocked = text.contains("<=") && !text.starts_with("wire") && !text.starts_with("assign");
        let name: String = target.chars().take_while(|c| is_name(*c)).collect();
        let width = self.widths.get(&name).copied().filter(|_| name == target).unwrap_or(1);
        if reset {
            self.add(site.clone(), Kind::Reset, target, None);
            self.constants(&site, &value, Kind::ResetValue);
            return;
        }
        if let Some(index) = target.strip_prefix("memory[").and_then(|rest| rest.strip_suffix(']')) {
            self.add(site.clone(), Kind::Memory, target.clone(), None);
            let at = range.start + text.find('[').unwrap() + 1;
            self.address(at..at + index.len(), index);
        } else if clocked && name == target {
            // A register that never loads is an enable at fault.
            self.add(site.clone(), Kind::Enable, target.clone(), None);
        }
        if let Some(at) = value.find("memory[") {
            let from = site.start + at + 7;
            let index = self.source.text[from..closing_bracket(&self.source.text, from)].to_owned();
            self.address_in(&site, &value, &index);
        }
        if name == target && !value.contains('\'') {
            let bit = self.draw.random_range(0..width);
            self.add(site.clone(), Kind::Stuck, format!("({value}) | ({width}'d1 << {bit})"), None);
            let bit = self.draw.random_range(0..width);
            self.add(site.clone(), Kind::Stuck, format!("({value}) & ~({width}'d1 << {bit})"), None);
            if width > 1 {
                self.add(
                    site.clone(),
                    Kind::Width,
                    format!("({value}) & ({width}'d{} >> 1)", u128::MAX >> (128 - width.min(120))),
                    None,
                );
            }
        }
        if let Some(before) = self.takes.get(&value).cloned().filter(|_| clocked) {
            self.add(site.clone(), Kind::Pipeline, before, None);
        }
        self.expression(site, &value, clocked);
    }

    /// A memory's address on the left.
    fn address(&mut self, site: Range<usize>, index: &str) {
        let width = self.widths.get(index).copied().unwrap_or(1);
        self.add(site.clone(), Kind::Memory, format!("{index} + {width}'d1"), None);
        for other in self.alike(index, width) {
            self.add(site.clone(), Kind::Memory, other, None);
        }
    }

    /// A memory's address on the right.
    fn address_in(&mut self, site: &Range<usize>, value: &str, index: &str) {
        let width = self.widths.get(index).copied().unwrap_or(1);
        let with = |other: &str| value.replacen(&format!("memory[{index}]"), &format!("memory[{other}]"), 1);
        self.add(site.clone(), Kind::Memory, with(&format!("{index} ^ {width}'d1")), None);
        for other in self.alike(index, width) {
            self.add(site.clone(), Kind::Memory, with(&other), None);
        }
    }

    fn alike(&self, name: &str, width: usize) -> Vec<String> {
        let alike = self.widths.iter().filter(|(other, w)| **w == width && *other != name && width > 1);
        alike.map(|(other, _)| other.clone()).take(2).collect()
    }

    /// Faults inside an expression.
    fn expression(&mut self, site: Range<usize>, text: &str, clocked: bool) {
        const OPERATORS: [(&str, &str, Kind); 18] = [
            (" + ", " - ", Kind::Operator),
            (" - ", " + ", Kind::Operator),
            (" & ", " | ", Kind::Operator),
            (" | ", " & ", Kind::Operator),
            (" ^ ", " | ", Kind::Operator),
            (" * ", " + ", Kind::Operator),
            (" << ", " >> ", Kind::Operator),
            ("~", "", Kind::Operator),
            ("(|", "(&", Kind::Operator),
            ("= |", "= &", Kind::Operator),
            (" == ", " != ", Kind::Comparison),
            (" != ", " == ", Kind::Comparison),
            (" > ", " >= ", Kind::Comparison),
            (" > ", " < ", Kind::Comparison),
            (" >= ", " > ", Kind::Comparison),
            (" < ", " <= ", Kind::Comparison),
            (" <= ", " < ", Kind::Comparison),
            (" == ", " >= ", Kind::Comparison),
        ];
        for (from, to, kind) in OPERATORS {
            for (at, _) in text.match_indices(from) {
                self.add(site.clone(), kind, format!("{}{to}{}", &text[..at], &text[at + from.len()..]), None);
            }
        }
        self.constants(&site, text, Kind::Constant);
        // c ? a : b
        if let Some((condition, rest)) = text.split_once(" ? ")
            && let Some((yes, no)) = rest.split_once(" : ")
            && !no.contains(" ? ")
            && !yes.contains('(')
        {
            self.add(site.clone(), Kind::Swap, format!("{condition} ? {no} : {yes}"), None);
        }
        // a - b and {a, b}
        for separator in [" - ", " > ", " < ", " >= "] {
            let mut parts = text.split(separator);
            if let (Some(a), Some(b), None) = (parts.next(), parts.next(), parts.next())
                && [a, b].iter().all(|part| part.chars().all(|c| is_name(c) || "{}', ".contains(c)))
            {
                self.add(site.clone(), Kind::Swap, format!("{b}{separator}{a}"), None);
            }
        }
        if let Some(inside) = text.strip_prefix('{').and_then(|rest| rest.strip_suffix('}'))
            && !inside.contains('{')
        {
            let mut parts: Vec<&str> = inside.split(',').map(str::trim).collect();
            if parts.len() > 1 {
                let at = self.draw.random_range(0..parts.len() - 1);
                parts.swap(at, at + 1);
                self.add(site.clone(), Kind::Swap, format!("{{{}}}", parts.join(", ")), None);
            }
        }
        // A slice one bit short at its top, or shifted down by one bit.
        for (at, _) in text.match_indices('[') {
            let Some(inside) = text[at + 1..].split(']').next() else { continue };
            let Some((high, low)) = inside.split_once(':') else { continue };
            let (Ok(high), Ok(low)) = (high.parse::<usize>(), low.parse::<usize>()) else { continue };
            let with =
                |high: usize, low: usize| format!("{}[{high}:{low}]{}", &text[..at], &text[at + inside.len() + 2..]);
            if high > low {
                self.add(site.clone(), Kind::Width, with(high - 1, low), None);
            }
            if low > 0 {
                self.add(site.clone(), Kind::Width, with(high - 1, low - 1), None);
            }
        }
        // A register of a pipeline in an expression: what it took before.
        let names: BTreeSet<&str> = text.split(|c| !is_name(c)).collect();
        for name in names {
            if let Some(before) = self.takes.get(name).cloned().filter(|_| clocked && text != name) {
                self.add(site.clone(), Kind::Pipeline, rename(text, name, &before), None);
            }
        }
    }

    /// Each sized number one up, and one bit of it other.
    fn constants(&mut self, site: &Range<usize>, text: &str, kind: Kind) {
        for (quote, _) in text.match_indices('\'') {
            let from = text[..quote].rfind(|c: char| !c.is_ascii_digit()).map_or(0, |at| at + 1);
            let base = text[quote + 1..].chars().next().unwrap_or(' ');
            let digits: String = text[quote + 2..].chars().take_while(char::is_ascii_alphanumeric).collect();
            let radix = match base {
                'd' => 10,
                'h' => 16,
                'b' => 2,
                _ => continue,
            };
            let (Ok(width), Ok(value)) = (text[from..quote].parse::<u32>(), u128::from_str_radix(&digits, radix))
            else {
                continue;
            };
            // The position of a slice is a constant of 32 bits, of which nine are used.
            let bit = self.draw.random_range(0..if width == 32 { 9 } else { width.min(120) });
            let most = u128::MAX >> (128 - width.min(120));
            for other in [value.wrapping_add(1) & most, value ^ 1 << bit] {
                let rest = &text[quote + 2 + digits.len()..];
                self.add(site.clone(), kind, format!("{}{width}'h{other:x}{rest}", &text[..from]), None);
            }
        }
    }
}

/// `target = value`, the target without what declares it.
fn split(statement: &str) -> Option<(&str, &str)> {
    let (target, value) = match statement.split_once(" <= ").filter(|(target, _)| !target.contains('=')) {
        Some(pair) => pair,
        None => statement.split_once(" = ")?,
    };
    let target = target.trim().trim_start_matches("wire").trim_start_matches("assign").trim();
    let target = match target.strip_prefix('[') {
        Some(rest) => rest.split_once(']')?.1.trim(),
        None => target,
    };
    // A case item before it.
    let target = target.rsplit_once(": ").map_or(target, |(_, target)| target);
    Some((target, value.trim_start()))
}

/// The index of the bracket that closes the one before `from`.
fn closing(text: &str, from: usize) -> usize {
    let mut depth = 0;
    for (i, c) in text[from..].char_indices() {
        match c {
            '(' => depth += 1,
            ')' if depth == 0 => return from + i,
            ')' => depth -= 1,
            _ => {}
        }
    }
    text.len()
}

fn closing_bracket(text: &str, from: usize) -> usize {
    from + text[from..].find(']').unwrap_or(0)
}

/// Exchanges a whole name.
fn rename(text: &str, from: &str, to: &str) -> String {
    let mut result = String::new();
    let mut word = String::new();
    for c in text.chars().chain([' ']) {
        if is_name(c) {
            word.push(c);
        } else {
            result += if word == from { to } else { &word };
            word.clear();
            result.push(c);
        }
    }
    result.trim_end().to_owned()
}
