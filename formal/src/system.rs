//! A transition system as Yosys writes it for SMT solvers, unrolled into queries without functions of states.
//!
//! `write_smt2` writes each signal as a function of a state. Here each signal becomes a constant per step: `v12_s3` is
//! signal 12 in step 3 of the copy `s`. The registers of a step are defined by the signals of the step before, so the
//! solver simplifies from step to step, and a signal with a fixed value, such as the number of a mutation, disappears.

mod part;

use std::collections::HashMap;
use std::fmt::Write;

pub(crate) use part::{Part, Parts};

/// A definition or declaration, as text with references to other signals.
#[derive(Debug, Clone)]
struct Signal {
    /// Sort of the value.
    sort: String,
    /// Its definition; `None` for an input or a register.
    body: Option<Vec<Piece>>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Piece {
    Text(String),
    Signal(usize),
}

/// A transition system: signals, registers with their next values, and the predicates of the proof.
#[derive(Debug, Clone)]
pub(crate) struct System {
    signals: Vec<Signal>,
    names: HashMap<String, usize>,
    /// Registers and memories: the signal, and its value in the next step.
    registers: Vec<(usize, Vec<Piece>)>,
    top: String,
    /// Functions of products, if products are abstracted: declarations.
    products: Vec<String>,
}

/// The values that a step of a copy starts from.
pub(crate) enum Start<'a> {
    /// Any values.
    Anything,
    /// The registers that the step of this name leads to.
    Step(&'a str),
    /// Inputs of the step of this name and its registers, but for those listed.
    Same(&'a str, &'a [usize]),
}

impl System {
    /// Reads what `write_smt2` wrote for a flat module. If `cut_products`, each product becomes a function of its
    /// operands of which only that is known.
    ///
    /// # Errors
    /// The beginning of the first statement that has another form.
    pub(crate) fn parse(text: &str, cut_products: bool) -> Result<Self, String> {
        let top = text.lines().find_map(|line| line.strip_prefix("; yosys-smt2-module ")).unwrap_or_default();
        let mut system = Self {
            signals: Vec::new(),
            names: HashMap::new(),
            registers: Vec::new(),
            top: top.trim().to_owned(),
            products: Vec::new(),
        };
        let text = without_comments(text);
        for statement in children(&text) {
            system
                .read(statement, cut_products)
                .ok_or_else(|| statement.lines().next().unwrap_or_default().chars().take(100).collect::<String>())?;
        }
        Ok(system)
    }

    /// Reads a statement; returns `None` if it has an unknown form.
    fn read(&mut self, statement: &str, cut_products: bool) -> Option<()> {
        let parts = children(statement.strip_prefix('(')?.strip_suffix(')')?);
        match parts.as_slice() {
            ["declare-fun", name, _, sort] => self.add(name, sort, None),
            ["define-fun", name, _, _, body] if *name == format!("|{}_t|", self.top) => {
                for equation in children(body.strip_prefix("(and")?.strip_suffix(')')?) {
                    let [_, value, next] = children(equation.strip_prefix('(')?.strip_suffix(')')?)[..] else {
                        return None;
                    };
                    let register = next.strip_prefix('(')?.split('|').nth(1)?;
                    let register = *self.names.get(register)?;
                    let value = self.pieces(value)?;
                    self.registers.push((register, value));
                }
            }
            ["define-fun", name, _, sort, body] => {
                let body = match cut_products {
                    true => self.cut_products(body, sort),
                    false => (*body).to_owned(),
                };
                let body = self.pieces(&body)?;
                self.add(name, sort, Some(body));
            }
            _ => {}
        }
        Some(())
    }

    fn add(&mut self, name: &str, sort: &str, body: Option<Vec<Piece>>) {
        self.names.insert(name.trim_matches('|').to_owned(), self.signals.len());
        self.signals.push(Signal { sort: sort.to_owned(), body });
    }

    /// Replaces `bvmul` by a function of its own for each sort.
    fn cut_products(&mut self, body: &str, sort: &str) -> String {
        let Some(rest) = body.strip_prefix("(bvmul ") else { return body.to_owned() };
        let name = format!("product{}", sort.chars().filter(char::is_ascii_digit).collect::<String>());
        let declaration = format!("(declare-fun {name} ({sort} {sort}) {sort})\n");
        if !self.products.contains(&declaration) {
            self.products.push(declaration);
        }
        format!("({name} {rest}")
    }

    /// Splits a text at its references `(|name| state)`.
    fn pieces(&self, text: &str) -> Option<Vec<Piece>> {
        let mut pieces = Vec::new();
        let mut rest = text;
        while let Some((before, name, after)) = rest.split_once("(|").and_then(|(before, from)| {
            let (name, after) = from.split_once('|')?;
            Some((before, name, after.strip_prefix(" state)")?))
        }) {
            pieces.push(Piece::Text(before.to_owned()));
            pieces.push(Piece::Signal(*self.names.get(name)?));
            rest = after;
        }
        // Anything else that names a signal would be lost.
        (!rest.contains('|')).then(|| pieces.push(Piece::Text(rest.to_owned())))?;
        Some(pieces)
    }

    /// Returns the signal of a name, with the module's name before it replaced by `|`.
    pub(crate) fn signal(&self, name: &str) -> Option<usize> {
        self.names.get(&format!("{}{name}", self.top)).copied()
    }

    /// Returns the input of this name: the wire of this name refers to it and to nothing else.
    pub(crate) fn input(&self, name: &str) -> Option<usize> {
        let body = self.signals[self.signal(&format!("_n {name}"))?].body.as_ref()?;
        let mut references = references(body);
        references.next().filter(|_| references.next().is_none())
    }

    /// Returns registers and memories of a part.
    pub(crate) fn registers(&self, part: &Part) -> impl Iterator<Item = usize> {
        self.registers.iter().map(|(at, _)| *at).filter(|at| part.has(*at))
    }

    /// Returns the signals that are needed for these and for the next values of the registers of a part.
    fn needed(&self, part: &Part, roots: &[usize]) -> Vec<bool> {
        let mut needed = vec![false; self.signals.len()];
        let mut open = roots.to_vec();
        for (register, value) in self.registers.iter().filter(|(at, _)| part.has(*at)) {
            open.push(*register);
            open.extend(references(value));
        }
        while let Some(at) = open.pop() {
            if !std::mem::replace(&mut needed[at], true) {
                open.extend(self.signals[at].body.iter().flatten().filter_map(reference));
            }
        }
        needed
    }

    /// Returns the head of a query.
    pub(crate) fn head(&self) -> String {
        format!("(set-logic QF_AUFBV)\n{}", self.products.concat())
    }

    /// Appends one step of a part to a query: all signals that the part's predicates, `roots` and its next step need.
    /// `fixed` is a signal that has one value, such as `#x0001`.
    pub(crate) fn step(
        &self,
        query: &mut String,
        part: &Part,
        name: &str,
        from: Start,
        fixed: (usize, &str),
        roots: &[usize],
    ) {
        let roots = [&part.properties, &part.assumptions, roots].concat();
        let needed = self.needed(part, &roots);
        let next: HashMap<usize, &Vec<Piece>> = self.registers.iter().map(|(at, value)| (*at, value)).collect();
        for (at, signal) in self.signals.iter().enumerate().filter(|(at, _)| needed[*at]) {
            let Signal { sort, body } = signal;
            let value = match (body, &from) {
                _ if at == fixed.0 => fixed.1.to_owned(),
                (Some(body), _) => render(body, name),
                (None, Start::Step(before)) if next.contains_key(&at) => render(next[&at], before),
                (None, Start::Same(other, but)) if !but.contains(&at) => format!("v{at}_{other}"),
                (None, _) => {
                    let _ = writeln!(query, "(declare-fun v{at}_{name} () {sort})");
                    continue;
                }
            };
            let _ = writeln!(query, "(define-fun v{at}_{name} () {sort} {value})");
        }
    }

    /// Appends to a query that a step of a part leads to another, the registers of which may have any values so far.
    pub(crate) fn transition(&self, query: &mut String, part: &Part, step: &str, next: &str) {
        for (register, value) in self.registers.iter().filter(|(at, _)| part.has(*at)) {
            let _ = writeln!(query, "(assert (= v{register}_{next} {}))", render(value, step));
        }
    }

    /// Returns the next value of a register as a text, from the signals of a step.
    pub(crate) fn next_value(&self, register: usize, step: &str) -> String {
        let value = self.registers.iter().find(|(at, _)| *at == register).map(|(_, value)| value);
        value.map_or(String::new(), |value| render(value, step))
    }
}

fn reference(piece: &Piece) -> Option<usize> {
    match piece {
        Piece::Signal(at) => Some(*at),
        Piece::Text(_) => None,
    }
}

fn references(pieces: &[Piece]) -> impl Iterator<Item = usize> {
    pieces.iter().filter_map(reference)
}

fn render(pieces: &[Piece], step: &str) -> String {
    let mut text = String::new();
    for piece in pieces {
        match piece {
            Piece::Text(part) => text += part,
            Piece::Signal(at) => drop(write!(text, "v{at}_{step}")),
        }
    }
    text
}

/// Removes comments, which begin with a semicolon outside of `|...|`.
fn without_comments(text: &str) -> String {
    let (mut kept, mut quoted, mut comment) = (String::with_capacity(text.len()), false, false);
    for letter in text.chars() {
        match letter {
            '\n' => comment = false,
            '|' if !comment => quoted = !quoted,
            ';' if !quoted => comment = true,
            _ => {}
        }
        if !comment {
            kept.push(letter);
        }
    }
    kept
}

/// Splits a text into its expressions: atoms and bracketed texts.
fn children(text: &str) -> Vec<&str> {
    let (mut found, mut start, mut depth, mut quoted) = (Vec::new(), None, 0usize, false);
    for (at, letter) in text.char_indices() {
        if quoted {
            quoted = letter != '|';
        } else if letter.is_whitespace() && depth == 0 {
            found.extend(start.take().map(|start: usize| &text[start..at]));
            continue;
        } else {
            match letter {
                '|' => quoted = true,
                '(' => depth += 1,
                ')' => depth = depth.saturating_sub(1),
                _ => {}
            }
        }
        if start.is_none() && !letter.is_whitespace() {
            start = Some(at);
        }
        if letter == ')' && depth == 0 && !quoted {
            found.extend(start.take().map(|start| &text[start..=at]));
        }
    }
    found.extend(start.map(|start| &text[start..]));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_brackets_and_semicolons_are_read() {
        let text = "; yosys-smt2-module t\n(declare-sort |t_s| 0)\n\
                    (declare-fun |t#0| (|t_s|) (_ BitVec 4)) ; a ( of t\n\
                    (define-fun |t_n a; (b| ((state |t_s|)) (_ BitVec 4) (bvmul (|t#0| state) #b0010))\n\
                    (define-fun |t_t| ((state |t_s|) (next_state |t_s|)) Bool (and\n  \
                    (= (|t_n a; (b| state) (|t#0| next_state)) ; |x\n))\n";
        let system = System::parse(text, true).unwrap();
        assert_eq!(system.registers.len(), 1);
        let mut query = system.head();
        let roots = [system.signal("_n a; (b").unwrap()];
        let whole = Part { signals: vec![true; 2], properties: Vec::new(), assumptions: Vec::new() };
        system.step(&mut query, &whole, "s0", Start::Anything, (99, ""), &roots);
        system.step(&mut query, &whole, "s1", Start::Step("s0"), (99, ""), &roots);
        assert_eq!(
            query,
            "(set-logic QF_AUFBV)\n(declare-fun product4 ((_ BitVec 4) (_ BitVec 4)) (_ BitVec 4))\n\
             (declare-fun v0_s0 () (_ BitVec 4))\n(define-fun v1_s0 () (_ BitVec 4) (product4 v0_s0 #b0010))\n\
             (define-fun v0_s1 () (_ BitVec 4) v1_s0)\n(define-fun v1_s1 () (_ BitVec 4) (product4 v0_s1 #b0010))\n"
        );
    }
}
