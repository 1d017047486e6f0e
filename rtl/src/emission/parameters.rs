//! Modules with parameters: their headers, the numbers of their instances, and what their text says with these numbers.
//!
//! The texts are those of the emission: one port or parameter a line, an instance begins `MODULE #(.P(V), ..) NAME (`,
//! and a branch of a generate block begins `if (C) begin : NAME` and ends with an `end` as far from the margin.

use std::collections::BTreeMap;

/// Names with their values: parameters and local parameters.
pub type Scope = BTreeMap<String, i64>;

/// A port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Port {
    /// `true` for an output.
    pub is_output: bool,
    /// The range as written, `[BITS-1:0]`; empty for a bit.
    pub range: String,
    /// Name of the port.
    pub name: String,
}

impl Port {
    /// Returns the number of bits, or `None` if the range has an unknown name or form.
    pub fn width(&self, scope: &Scope) -> Option<i64> {
        if self.range.is_empty() { Some(1) } else { width(&self.range, scope) }
    }
}

/// Returns the bits of a range `[HIGH:LOW]`, or `None` if it has an unknown name or form.
pub fn width(range: &str, scope: &Scope) -> Option<i64> {
    let (high, low) = range.trim().strip_prefix('[')?.strip_suffix(']')?.split_once(':')?;
    Some(value(high, scope)? - value(low, scope)? + 1)
}

/// Splits a text into its modules, each from its line `module NAME` on.
pub fn modules(text: &str) -> Vec<(&str, &str)> {
    let mut starts: Vec<usize> = text.match_indices("module ").map(|(at, _)| at).collect();
    starts.retain(|at| *at == 0 || text[..*at].ends_with('\n'));
    let ends = starts.iter().skip(1).copied().chain([text.len()]);
    let named = starts.iter().zip(ends).filter_map(|(from, to)| {
        let module = &text[*from..to];
        Some((module["module ".len()..].split(|c: char| !is_of_name(c)).next()?, module))
    });
    named.collect()
}

fn is_of_name(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

/// Returns the parameters of a module with their defaults, in the order of its header.
pub fn parameters(text: &str) -> Vec<(String, String)> {
    let lines = text.lines().skip_while(|line| !line.starts_with("module ")).take_while(|line| *line != ");");
    lines.filter_map(|line| declared(line.trim().strip_prefix("parameter ")?)).collect()
}

/// Returns the ports of a module in the order of its header.
pub fn ports(text: &str) -> Vec<Port> {
    let lines = text.lines().skip_while(|line| !line.starts_with("module ")).take_while(|line| *line != ");");
    let port = |line: &str| {
        let (direction, rest) = line.trim().trim_end_matches(',').split_once(' ')?;
        let is_output = match direction {
            "input" => false,
            "output" => true,
            _ => return None,
        };
        let (kind, rest) = rest.trim_start().split_once(' ')?;
        if !["wire", "reg"].contains(&kind) {
            return None;
        }
        let (range, name) = rest.trim().rsplit_once(' ').unwrap_or(("", rest.trim()));
        Some(Port { is_output, range: range.trim().into(), name: name.into() })
    };
    lines.filter_map(port).collect()
}

/// Splits `[RANGE] NAME = VALUE` into name and value.
fn declared(text: &str) -> Option<(String, String)> {
    let (name, value) = text.split_once('=')?;
    let value = value.trim().trim_end_matches([',', ';']);
    Some((name.trim().rsplit(' ').next()?.to_owned(), value.to_owned()))
}

/// A module with the numbers of an instance.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Variant {
    /// Name of the module.
    pub module: String,
    /// Its parameters with their values, in the order of its header.
    pub parameters: Vec<(String, i64)>,
}

impl Variant {
    /// Returns the name by which reports call it: `delay(18, 16)`, and `lerp` where there are no parameters.
    pub fn label(&self) -> String {
        // A large number is a mask.
        let number = |value: i64| if value >= 1 << 16 { format!("{value:#x}") } else { value.to_string() };
        let values: Vec<String> = self.parameters.iter().map(|(_, value)| number(*value)).collect();
        if values.is_empty() { self.module.clone() } else { format!("{}({})", self.module, values.join(", ")) }
    }

    /// Returns the value of a parameter.
    pub fn parameter(&self, name: &str) -> Option<i64> {
        self.parameters.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }

    /// Returns the parameters, and the local parameters that follow from them.
    pub fn scope(&self, text: &str) -> Scope {
        let mut scope: Scope = self.parameters.iter().cloned().collect();
        for line in active(text, &scope).lines() {
            let local = line.trim().strip_prefix("localparam ").and_then(declared);
            if let Some((name, value)) = local.and_then(|(name, text)| Some((name, value(&text, &scope)?))) {
                scope.insert(name, value);
            }
        }
        scope
    }
}

/// An instance below a top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Instance {
    /// Names of the instances from the top down, joined by dots; empty for the top.
    pub path: String,
    /// Its module and numbers.
    pub variant: Variant,
}

/// Returns all instances of the modules of `texts` below the module `top`, the top first. Modules without a text are
/// left out, and so is an instance of a module in itself with the same numbers.
pub fn instances(texts: &BTreeMap<&str, &str>, top: &str) -> Vec<Instance> {
    let top = Variant { module: top.into(), parameters: defaults(texts.get(top).copied().unwrap_or_default()) };
    let mut found = vec![Instance { path: String::new(), variant: top }];
    // The instance that each is part of; that of the top is the top.
    let mut parents = vec![0];
    let mut at = 0;
    while at < found.len() {
        let Instance { path, variant } = found[at].clone();
        let text = texts.get(variant.module.as_str()).copied().unwrap_or_default();
        let scope = variant.scope(text);
        let above: Vec<usize> = std::iter::successors(Some(at), |at| (*at > 0).then(|| parents[*at])).collect();
        for line in active(text, &scope).lines() {
            let Some(Head { module, given, name }) = instance(line) else { continue };
            let Some(its) = texts.get(module) else { continue };
            let mut parameters = defaults(its);
            for (name, text) in given {
                let known = parameters.iter_mut().find(|(known, _)| *known == name);
                if let (Some((_, old)), Some(new)) = (known, value(text, &scope)) {
                    *old = new;
                }
            }
            let variant = Variant { module: module.into(), parameters };
            if above.iter().any(|at| found[*at].variant == variant) {
                continue;
            }
            let path = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
            found.push(Instance { path, variant });
            parents.push(at);
        }
        at += 1;
    }
    found
}

/// Returns each module with each set of numbers that it has below the module `top`, sorted.
pub fn variants(texts: &BTreeMap<&str, &str>, top: &str) -> Vec<Variant> {
    let mut variants: Vec<Variant> = instances(texts, top).into_iter().map(|instance| instance.variant).collect();
    variants.sort();
    variants.dedup();
    variants
}

/// Returns the parameters of a module with the values of their defaults.
fn defaults(text: &str) -> Vec<(String, i64)> {
    let (mut scope, mut found) = (Scope::new(), Vec::new());
    for (name, text) in parameters(text) {
        if let Some(value) = value(&text, &scope) {
            scope.insert(name.clone(), value);
            found.push((name, value));
        }
    }
    found
}

/// The first line of an instance.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Head<'a> {
    /// Name of the module.
    pub module: &'a str,
    /// The parameters that are given, with their expressions.
    pub given: Vec<(&'a str, &'a str)>,
    /// Name of the instance.
    pub name: &'a str,
}

/// Reads the first line of an instance; `None` for any other line.
pub fn instance(line: &str) -> Option<Head<'_>> {
    let (head, name) = line.trim().strip_suffix(" (")?.rsplit_once(' ')?;
    let is_name = |text: &str| text.chars().all(is_of_name);
    let (module, given) = match head.split_once(" #(") {
        Some((module, given)) => (module, given.strip_suffix(')')?),
        None => (head, ""),
    };
    if !is_name(module) || !is_name(name) || ["module", "if", "function"].contains(&module) || head.is_empty() {
        return None;
    }
    let mut parameters = Vec::new();
    for text in given.split(", ").filter(|text| !text.is_empty()) {
        parameters.push(text.strip_prefix('.')?.strip_suffix(')')?.split_once('(')?);
    }
    Some(Head { module, given: parameters, name })
}

/// Returns a text of the same length with blanks in place of the branches of generate blocks that are not taken.
pub fn active(text: &str, scope: &Scope) -> String {
    // Margin of each open branch, and whether it is taken.
    let mut open: Vec<(usize, bool)> = Vec::new();
    let mut kept = String::with_capacity(text.len());
    let mut scope = scope.clone();
    for line in text.split_inclusive('\n') {
        let trimmed = line.trim();
        let margin = line.len() - line.trim_start().len();
        let taken = |open: &[(usize, bool)]| open.iter().all(|(_, taken)| *taken);
        let is_of_open = open.last().is_some_and(|(at, _)| *at == margin);
        if is_of_open && trimmed.starts_with("end else begin : ") {
            if let Some((_, taken)) = open.last_mut() {
                *taken = !*taken;
            }
            kept += line;
            continue;
        }
        if is_of_open && trimmed == "end" {
            open.pop();
            kept += line;
            continue;
        }
        let condition = trimmed.strip_prefix("if (").and_then(|rest| rest.rsplit_once(") begin : "));
        if let Some((condition, _)) = condition {
            let is_taken = value(condition, &scope).is_none_or(|value| value != 0);
            if taken(&open) {
                kept += line
            } else {
                kept += &blank(line)
            };
            open.push((margin, is_taken));
            continue;
        }
        if !taken(&open) {
            kept += &blank(line);
            continue;
        }
        let local = trimmed.strip_prefix("localparam ").and_then(declared);
        if let Some((name, value)) = local.and_then(|(name, text)| Some((name, value(&text, &scope)?))) {
            scope.insert(name, value);
        }
        kept += line;
    }
    kept
}

fn blank(line: &str) -> String {
    line.chars().map(|c| if c == '\n' { '\n' } else { ' ' }).collect()
}

/// Returns the value of a constant expression, or `None` if it has an unknown name or form.
pub fn value(text: &str, scope: &Scope) -> Option<i64> {
    let mut parser = Parser { rest: text.trim(), scope };
    let value = parser.choice()?;
    parser.rest.is_empty().then_some(value)
}

/// Binary operators, the loosest first; within a row the longer first.
const OPERATORS: [&[&str]; 8] =
    [&["||"], &["&&"], &["|"], &["&"], &["==", "!="], &["<=", ">=", "<", ">"], &["<<", ">>"], &["+", "-"]];

struct Parser<'a> {
    rest: &'a str,
    scope: &'a Scope,
}

impl Parser<'_> {
    fn take(&mut self, token: &str) -> bool {
        match self.rest.strip_prefix(token) {
            Some(rest) => {
                self.rest = rest.trim_start();
                true
            }
            None => false,
        }
    }

    fn choice(&mut self) -> Option<i64> {
        let condition = self.binary(0)?;
        if !self.take("?") {
            return Some(condition);
        }
        let yes = self.choice()?;
        let no = self.take(":").then(|| self.choice())??;
        Some(if condition != 0 { yes } else { no })
    }

    fn binary(&mut self, level: usize) -> Option<i64> {
        let Some(operators) = OPERATORS.get(level) else { return self.product() };
        let mut left = self.binary(level + 1)?;
        loop {
            // `|` is no half of `||`, and `<` no half of `<<`.
            let is_longer = |operator: &str| {
                let doubled = self.rest.get(..2).unwrap_or_default();
                operator.len() == 1 && ["||", "&&", "<<", ">>", "<=", ">="].contains(&doubled)
            };
            let Some(operator) = operators.iter().find(|op| self.rest.starts_with(**op) && !is_longer(op)) else {
                return Some(left);
            };
            self.take(operator);
            let right = self.binary(level + 1)?;
            left = match *operator {
                "||" => i64::from(left != 0 || right != 0),
                "&&" => i64::from(left != 0 && right != 0),
                "|" => left | right,
                "&" => left & right,
                "==" => i64::from(left == right),
                "!=" => i64::from(left != right),
                "<=" => i64::from(left <= right),
                ">=" => i64::from(left >= right),
                "<" => i64::from(left < right),
                ">" => i64::from(left > right),
                "<<" => left.checked_shl(right.try_into().ok()?)?,
                ">>" => left.checked_shr(right.try_into().ok()?)?,
                "+" => left.checked_add(right)?,
                _ => left.checked_sub(right)?,
            };
        }
    }

    fn product(&mut self) -> Option<i64> {
        let mut left = self.operand()?;
        while self.take("*") {
            left = left.checked_mul(self.operand()?)?;
        }
        Some(left)
    }

    fn operand(&mut self) -> Option<i64> {
        if self.take("~") {
            return Some(!self.operand()?);
        }
        if self.take("(") {
            let value = self.choice()?;
            return self.take(")").then_some(value);
        }
        if self.take("$clog2(") {
            let value = u64::try_from(self.choice()?).ok()?;
            return self.take(")").then_some(i64::from(64 - value.saturating_sub(1).leading_zeros()));
        }
        let end = self.rest.find(|c: char| !(c.is_ascii_alphanumeric() || "_'".contains(c)));
        let (word, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = rest.trim_start();
        match word.split_once('\'') {
            Some((_, digits)) => {
                let radix = match digits.chars().next()? {
                    'd' => 10,
                    'h' => 16,
                    'b' => 2,
                    _ => return None,
                };
                i64::from_str_radix(&digits[1..], radix).ok()
            }
            None => word.parse().ok().or_else(|| self.scope.get(word).copied()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scope(pairs: &[(&str, i64)]) -> Scope {
        pairs.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
    }

    #[test]
    fn constant_expressions_have_the_values_of_the_language() {
        let scope = scope(&[("BITS", 18), ("STEPS", 16), ("LINES", 15)]);
        for (text, wanted) in [
            ("BITS*(STEPS+1)-1", Some(305)),
            ("$clog2(STEPS - 1)", Some(4)),
            ("$clog2(1)", Some(0)),
            ("STEPS > 1 ? $clog2(STEPS) : 1", Some(4)),
            ("(3 * LINES & ~LINES) >> 1", Some(16)),
            ("(LINES & ~(3 * LINES)) >> 1", Some(1)),
            ("1 << 3 | 28'h0", Some(8)),
            ("STEPS < 1 || STEPS > 33", Some(0)),
            ("10 - 3 - 2", Some(5)),
            ("STEPS - UNKNOWN", None),
            ("", None),
            ("1 +", None),
            ("1 << 64", None),
        ] {
            assert_eq!(value(text, &scope), wanted, "{text}");
        }
    }

    #[test]
    fn a_branch_that_is_not_taken_is_blank_and_nothing_moves() {
        let text = "module m;\ngenerate\n  if (N < 4) begin : short\n    wire a;\n  end else begin : long\n    \
                    localparam M = N - 1;\n    if (M == 8) begin : eight\n      wire b;\n    end\n  end\nendgenerate\n";
        let kept = |n| active(text, &scope(&[("N", n)]));
        assert!(kept(3).contains("wire a") && !kept(3).contains("wire b") && !kept(3).contains("localparam"));
        assert!(!kept(9).contains("wire a") && kept(9).contains("wire b"));
        assert!(!kept(5).contains("wire a") && !kept(5).contains("wire b") && kept(5).contains("localparam"));
        for n in [3, 5, 9] {
            assert_eq!(kept(n).len(), text.len());
        }
    }

    #[test]
    fn numbers_of_instances_follow_from_those_of_their_parent() {
        let delay = "module delay #(\n  parameter BITS = 16,\n  parameter STEPS = 4\n) (\n  input  wire clock,\n  \
                     input  wire [BITS-1:0] x,\n  output reg  [BITS-1:0] y\n);\nendmodule\n";
        let stage = "module stage #(\n  parameter DISTANCE = 1\n) (\n  input  wire clock\n);\n\
                     delay #(.BITS(18), .STEPS(DISTANCE + 4)) sample_delay (\n  .clock(clock)\n);\n\
                     delay other (\n  .clock(clock)\n);\nendmodule\n";
        let top = "module top (\n  input  wire clock\n);\nstage #(.DISTANCE(2)) stage_0 (\n);\nstage stage_1 (\n);\n";
        let texts = BTreeMap::from([("delay", delay), ("stage", stage), ("top", top)]);
        let found = instances(&texts, "top");
        let named: Vec<_> = found.iter().map(|it| (it.path.as_str(), it.variant.label())).collect();
        let wanted = [
            ("", "top"),
            ("stage_0", "stage(2)"),
            ("stage_1", "stage(1)"),
            ("stage_0.sample_delay", "delay(18, 6)"),
            ("stage_0.other", "delay(16, 4)"),
            ("stage_1.sample_delay", "delay(18, 5)"),
            ("stage_1.other", "delay(16, 4)"),
        ];
        assert_eq!(named, wanted.map(|(path, label)| (path, label.to_owned())));
        assert_eq!(variants(&texts, "top").len(), 6);
        let tree = "module tree #(\n  parameter N = 8\n) (\n  input  wire clock\n);\ngenerate\n  \
                    if (N > 1) begin : more\n    tree #(.N(N >> 1)) half (\n    );\n    \
                    tree #(.N(N / 2)) unknown (\n    );\n  end\nendgenerate\n";
        let found = instances(&BTreeMap::from([("tree", tree)]), "tree");
        let paths: Vec<_> = found.iter().map(|it| it.path.as_str()).collect();
        assert_eq!(paths, ["", "half", "half.half", "half.half.half"], "a number that is not known ends the walk");
        let port = &ports(delay)[1];
        assert_eq!((port.name.as_str(), port.width(&scope(&[("BITS", 18)]))), ("x", Some(18)));
    }
}
