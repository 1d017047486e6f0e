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

use hoverlock_rtl::emission::parameters::{self, Head, Scope, Variant, active, instance, variants};
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
    /// The module with the numbers of the instances that have the fault: `delay(18, 16)`.
    pub module: String,
    /// The file's name without `.v`.
    pub file: String,
    /// The line in the file, from 1.
    pub line: usize,
    pub kind: Kind,
    /// What the line says of it, and what stands there instead.
    pub original: String,
    pub fault: String,
    /// The instance whose port is wired wrongly, by its module with its numbers.
    pub at: Option<String>,
    /// Byte range of the expression in the file.
    site: (usize, usize),
    /// What is true in the instances that have the fault, where others have not: `BITS == 18 && STEPS == 16`.
    condition: String,
}

/// The name of a module without its numbers.
pub fn plain(module: &str) -> &str {
    module.split('(').next().unwrap_or(module)
}

/// The file with one fault in place, as by hand.
pub fn by_hand(source: &Source, mutant: &Mutant) -> String {
    let mut text = source.text.clone();
    let (from, to) = mutant.site;
    let fault = match mutant.condition.as_str() {
        "" => mutant.fault.clone(),
        condition => format!("({condition} ? ({}) : ({}))", mutant.fault, &source.text[from..to]),
    };
    text.replace_range(from..to, &fault);
    text
}

/// Whether Verilator's linter refuses the files with a fault, as the tests call it for the committed files, and takes
/// them without it. A slice beyond its word is no fault in a simulation, which reads it modulo the width.
pub fn is_refused_by_lint(sources: &[Source], mutant: &Mutant) -> bool {
    let is_clean = |text: &dyn Fn(&Source) -> String| {
        let folder = tempfile::tempdir().unwrap();
        let waivers = Path::new(env!("CARGO_MANIFEST_DIR")).join("../rtl/verilog/waivers.vlt");
        std::fs::copy(waivers, folder.path().join("waivers.vlt")).unwrap();
        let names: Vec<String> = sources.iter().map(|source| format!("{}.v", source.module)).collect();
        for (source, name) in sources.iter().zip(&names) {
            std::fs::write(folder.path().join(name), text(source)).unwrap();
        }
        let lint = Command::new("verilator")
            .args(["--lint-only", "-Wall", "--top-module", "hoverlock_top", "waivers.vlt"])
            .args(names)
            .current_dir(folder.path())
            .output();
        lint.unwrap().status.success()
    };
    let faulty = |source: &Source| {
        if source.module == mutant.file { by_hand(source, mutant) } else { source.text.clone() }
    };
    is_clean(&|source| source.text.clone()) && !is_clean(&faulty)
}

/// The file with the numbers of an instance as defaults.
fn with_defaults(text: &str, mutant: &Mutant) -> String {
    let of_instance = |line: &str| {
        let (declared, _) = line.trim().strip_prefix("parameter ")?.split_once(" = ")?;
        let name = declared.rsplit(' ').next()?;
        let number = mutant.condition.split(" && ").find_map(|one| one.strip_prefix(&format!("{name} == ")))?;
        let comma = if line.ends_with(',') { "," } else { "" };
        Some(format!("{}= {number}{comma}", line.split_once("= ")?.0))
    };
    text.lines().map(|line| of_instance(line).unwrap_or_else(|| line.to_owned()) + "\n").collect()
}

/// Whether Yosys proves the module with the fault equivalent to the original. Modules with instances are not tried.
pub fn is_proved_equivalent(sources: &[Source], mutant: &Mutant) -> bool {
    let Some(source) = sources.iter().find(|source| source.module == mutant.file) else { return false };
    if source.text.contains("\n  .clock(clock)") {
        return false;
    }
    let folder = tempfile::tempdir().unwrap();
    let named = |text: &str, name: &str| {
        with_defaults(text, mutant).replacen(&format!("module {} ", mutant.file), &format!("module {name} "), 1)
    };
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

/// All faults that can be put into the files, for each set of numbers that a module has.
pub fn all(sources: &[Source]) -> Vec<Mutant> {
    let texts: BTreeMap<&str, &str> =
        sources.iter().map(|source| (source.module.as_str(), source.text.as_str())).collect();
    let mut mutants: BTreeSet<Mutant> = BTreeSet::new();
    let variants = variants(&texts, "hoverlock_top");
    for variant in &variants {
        let Some(source) = sources.iter().find(|source| source.module == variant.module) else { continue };
        let is_only = variants.iter().filter(|other| other.module == variant.module).count() == 1;
        mutants.extend(Reader::new(source, variant, is_only, &texts).mutants());
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
        for (i, mutant) in mutants.iter().enumerate().filter(|(_, mutant)| mutant.file == source.module) {
            sites.entry(mutant.site).or_default().push((i + 1, mutant));
        }
        let mut text = source.text.clone();
        for (site, faults) in sites.iter().rev() {
            let original = &source.text[site.0..site.1];
            let one = |(i, mutant): &(usize, &Mutant)| {
                let and = if mutant.condition.is_empty() { "" } else { " && " };
                format!("mutation::id == {i}{and}{} ? ({}) : ", mutant.condition, mutant.fault)
            };
            let faults: String = faults.iter().map(one).collect();
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

/// Ports of a module: whether it is an output, and its width.
fn ports(text: &str, scope: &Scope) -> Widths {
    let port = |port: parameters::Port| {
        let width = usize::try_from(port.width(scope)?).ok()?;
        Some((port.name, (port.is_output, width)))
    };
    parameters::ports(text).into_iter().filter_map(port).collect()
}

/// The width of each signal inside of a module. One whose width is not the same in every round of a loop is left out.
fn signals(text: &str, scope: &Scope) -> BTreeMap<String, usize> {
    let mut signals = BTreeMap::new();
    for line in text.lines().skip_while(|line| *line != ");") {
        let line = line.trim();
        // An attribute says where a signal goes, not what it is.
        let line = line.strip_prefix("(*").and_then(|line| line.split_once("*) ")).map_or(line, |(_, line)| line);
        let declared = ["wire ", "reg "].iter().find_map(|kind| line.strip_prefix(kind));
        let Some(declared) = declared.filter(|_| !line.contains(" memory ")) else { continue };
        let (range, names) = match declared.split_once("] ").filter(|_| declared.starts_with('[')) {
            Some((range, names)) => (format!("{range}]"), names),
            None => ("[0:0]".to_owned(), declared),
        };
        let width = parameters::width(&range, scope).and_then(|width| usize::try_from(width).ok());
        let names = names.split('=').next().unwrap().split([',', ';']).map(str::trim);
        for name in names.filter(|name| !name.is_empty()) {
            signals.extend(width.map(|width| (name.to_owned(), width)));
        }
    }
    signals
}

struct Reader<'a> {
    variant: &'a Variant,
    condition: String,
    /// The file, with blanks where the numbers leave a branch out.
    text: String,
    texts: &'a BTreeMap<&'a str, &'a str>,
    scope: Scope,
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
    fn new(source: &Source, variant: &'a Variant, is_only: bool, texts: &'a BTreeMap<&'a str, &'a str>) -> Self {
        let scope = variant.scope(&source.text);
        let text = active(&source.text, &scope);
        let own = ports(&text, &scope);
        let mut widths: BTreeMap<String, usize> = own.iter().map(|(name, (_, width))| (name.clone(), *width)).collect();
        widths.extend(signals(&text, &scope));
        let equal: Vec<String> = variant.parameters.iter().map(|(name, value)| format!("{name} == {value}")).collect();
        let condition = if is_only { String::new() } else { equal.join(" && ") };
        // The same choices for a file whatever other files there are.
        let seed = variant.label().bytes().fold(7u64, |seed, byte| seed.wrapping_mul(31) + u64::from(byte));
        let draw = ChaCha8Rng::seed_from_u64(seed);
        Self { variant, condition, text, texts, scope, widths, takes: BTreeMap::new(), draw, mutants: Vec::new() }
    }

    fn mutants(mut self) -> Vec<Mutant> {
        let text = &self.text.clone();
        let body = text.find("\n);\n").map_or(0, |at| at + 4);
        // Statements by their first line; an expression may go on over lines up to its semicolon.
        let mut at = body;
        let mut within: Option<Variant> = None;
        let (mut in_reset, mut in_function) = (false, false);
        let mut statements: Vec<(Range<usize>, bool)> = Vec::new();
        while at < text.len() {
            let end = text[at..].find('\n').map_or(text.len(), |end| at + end);
            let line = &text[at..end];
            let trimmed = line.trim_start();
            let begin = at + line.len() - trimmed.len();
            // Numbers of the module, its loops and branches are no hardware.
            const NO_HARDWARE: [&str; 10] =
                ["//", "(*", "wire unused", "localparam", "initial", "$", "for (", "function", "genvar", "integer"];
            in_function = (in_function || trimmed.starts_with("function")) && !trimmed.starts_with("endfunction");
            let skipped = in_function
                || trimmed.contains(" begin : ")
                || NO_HARDWARE.iter().any(|word| trimmed.starts_with(word));
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
                if let (Some(inner), Some((port, _))) = (&within, connection.split_once('(')) {
                    let from = begin + 1 + port.len() + 1;
                    let to = closing(text, from);
                    self.connection(&inner.clone(), port, from..to);
                }
            } else if trimmed.ends_with(" (") {
                within = self.instance(trimmed);
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

    /// The module of an instance with its numbers.
    fn instance(&self, line: &str) -> Option<Variant> {
        let Head { module, given, .. } = instance(line)?;
        let number = |(name, text): (&str, &str)| Some((name.to_owned(), parameters::value(text, &self.scope)?));
        Some(Variant { module: module.into(), parameters: given.into_iter().map(number).collect::<Option<_>>()? })
    }

    fn add(&mut self, site: Range<usize>, kind: Kind, fault: String, at: Option<String>) {
        let text = &self.text;
        let original = text[site.clone()].split_whitespace().collect::<Vec<_>>().join(" ");
        if !is_balanced(&fault) || fault.split_whitespace().collect::<Vec<_>>().join(" ") == original {
            return;
        }
        self.mutants.push(Mutant {
            module: self.variant.label(),
            file: self.variant.module.clone(),
            line: text[..site.start].matches('\n').count() + 1,
            kind,
            original,
            fault,
            at,
            site: (site.start, site.end),
            condition: self.condition.clone(),
        });
    }

    fn condition(&mut self, site: Range<usize>) {
        let text = self.text[site.clone()].to_owned();
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

    fn connection(&mut self, inner: &Variant, port: &str, site: Range<usize>) {
        let text = self.text[site.clone()].to_owned();
        let Some(its) = self.texts.get(inner.module.as_str()) else { return };
        let Some((output, width)) = ports(its, &inner.scope(its)).get(port).copied() else { return };
        let module = inner.label();
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
        let text = self.text[range.clone()].to_owned();
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
            let index = self.text[from..closing_bracket(&self.text, from)].to_owned();
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
            && [condition, yes, no].into_iter().all(is_balanced)
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

    /// Each number one up, and one bit of it other.
    fn constants(&mut self, site: &Range<usize>, text: &str, kind: Kind) {
        self.plain_constants(site, text, kind);
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

    /// The same of numbers without a size, and of local parameters with their range, outside of brackets.
    fn plain_constants(&mut self, site: &Range<usize>, text: &str, kind: Kind) {
        let (mut at, mut depth) = (0, 0usize);
        while let Some(first) = text[at..].chars().next() {
            let end = text[at..].find(|c: char| !is_name(c) && c != '\'').map_or(text.len(), |end| at + end);
            if end == at {
                depth = match first {
                    '[' => depth + 1,
                    ']' => depth.saturating_sub(1),
                    _ => depth,
                };
                at += first.len_utf8();
                continue;
            }
            let word = &text[at..end];
            let is_local = word.chars().next().is_some_and(|c| c.is_ascii_uppercase());
            let value = if is_local { self.scope.get(word).copied() } else { word.parse().ok() };
            if let Some(value) = value.filter(|_| depth == 0) {
                let range = if text[end..].starts_with('[') { text[end..].find(']').map_or(0, |at| at + 1) } else { 0 };
                let close = end + range;
                let bit = self.draw.random_range(0..3);
                for other in [value + 1, value ^ 1 << bit] {
                    self.add(site.clone(), kind, format!("{}{other}{}", &text[..at], &text[close..]), None);
                }
            }
            at = end;
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

/// Whether a text has as many closing brackets of each kind as opening ones.
fn is_balanced(text: &str) -> bool {
    [('(', ')'), ('{', '}'), ('[', ']')]
        .into_iter()
        .all(|(open, close)| text.matches(open).count() == text.matches(close).count())
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
