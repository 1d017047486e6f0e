//! The part of a transition system that a mutation can change.
//!
//! A claim about a family of modules is one system with an instance for each set of numbers, which share nothing but
//! free inputs. Two signals are in one part if one refers to the other, or is its next value. What free inputs alone
//! determine joins nothing: any of their values is possible beside any state of the other parts. Inputs that an
//! assumption is about are not free. Nor does a register join anything that has one value from the second step on, such
//! as the one that enables the assertions.
//!
//! The other parts have the runs that they have without the mutation, in which the proved properties hold. So a
//! question about properties, assumptions and registers of one part has the answer of the question about all of
//! them, as long as the assumptions of the other parts do not end a run. It has it sooner: a solver that looks for
//! a violation need not find states of the others.

use std::collections::HashMap;

use super::{Piece, System, reference, references};

/// Signals that a question is about.
#[derive(Debug, Clone)]
pub(crate) struct Part {
    /// For each signal, whether it is in the part.
    pub(super) signals: Vec<bool>,
    /// Predicates that are true as long as no property is violated.
    pub(crate) properties: Vec<usize>,
    /// Predicates that are assumed.
    pub(crate) assumptions: Vec<usize>,
}

impl Part {
    /// Returns `true` if a signal is in the part.
    pub(crate) fn has(&self, signal: usize) -> bool {
        self.signals[signal]
    }
}

/// The division of a system, for an input that selects a mutation.
#[derive(Debug)]
pub(crate) struct Parts {
    /// The input that selects.
    pub(crate) select: usize,
    /// The predicates of the whole system.
    properties: usize,
    assumptions: usize,
    /// A representative of each signal, which is the same for signals that are joined.
    representatives: Vec<usize>,
}

impl System {
    /// Divides the system. `properties` and `assumptions` are its predicates.
    pub(crate) fn parts(&self, select: usize, properties: usize, assumptions: usize) -> Parts {
        Parts { select, properties, assumptions, representatives: self.joined(select, assumptions) }
    }

    /// Returns the part that is everything.
    pub(crate) fn whole(&self, of: &Parts) -> Part {
        let signals = vec![true; self.signals.len()];
        Part { signals, properties: vec![of.properties], assumptions: vec![of.assumptions] }
    }

    /// Returns the part that changes if the selecting input has the value `number`: what compares the input with it,
    /// what depends on that, and what is joined to these. Yosys removes a mutation that changes nothing, and its part
    /// is empty. It is the whole system if Yosys wrote anything else than comparisons.
    pub(crate) fn part(&self, of: &Parts, number: usize) -> Part {
        let mut changed = vec![false; self.signals.len()];
        for (at, body) in self.bodies().filter(|(_, body)| references(body).any(|other| other == of.select)) {
            match compared(body) {
                Some(value) => changed[at] = value == number,
                // A name of the input.
                None if is_alias(body) => {}
                None => return self.whole(of),
            }
        }
        self.mark_users(&mut changed);
        let mut is_in = vec![false; self.signals.len()];
        for at in (0..changed.len()).filter(|at| changed[*at]) {
            is_in[of.representatives[at]] = true;
        }
        let mut signals: Vec<bool> = of.representatives.iter().map(|at| is_in[*at]).collect();
        self.registers.iter().filter(|(_, value)| is_constant(value)).for_each(|(at, _)| signals[*at] = true);
        let [properties, assumptions] = [of.properties, of.assumptions]
            .map(|predicate| self.conjuncts(predicate).into_iter().filter(|at| signals[*at]).collect());
        Part { properties, assumptions, signals }
    }

    /// Returns signals with their definitions, and registers with their next values.
    fn bodies(&self) -> impl Iterator<Item = (usize, &Vec<Piece>)> {
        let defined = self.signals.iter().enumerate().filter_map(|(at, signal)| Some((at, signal.body.as_ref()?)));
        defined.chain(self.registers.iter().map(|(at, value)| (*at, value)))
    }

    /// Marks the signals that refer to a marked one, and the registers whose next value does, until nothing changes.
    fn mark_users(&self, marked: &mut [bool]) {
        loop {
            let mut is_done = true;
            for (at, body) in self.bodies() {
                if !marked[at] && references(body).any(|other| marked[other]) {
                    marked[at] = true;
                    is_done = false;
                }
            }
            if is_done {
                return;
            }
        }
    }

    /// Returns a representative of each signal, which is the same for signals that are joined.
    fn joined(&self, select: usize, assumptions: usize) -> Vec<usize> {
        let values: HashMap<usize, &Vec<Piece>> = self.registers.iter().map(|(at, value)| (*at, value)).collect();
        // What has a state, or is assumed about, now or in an earlier step, or depends on either.
        let mut joins = vec![false; self.signals.len()];
        let mut open = self.conjuncts(assumptions);
        while let Some(at) = open.pop() {
            if at != select && !std::mem::replace(&mut joins[at], true) {
                open.extend(self.signals[at].body.iter().flatten().filter_map(reference));
                open.extend(values.get(&at).into_iter().flat_map(|value| references(value)));
            }
        }
        self.registers.iter().filter(|(_, value)| !is_constant(value)).for_each(|(at, _)| joins[*at] = true);
        self.mark_users(&mut joins);
        let predicates = ["_a", "_u", "_i", "_h"].map(|name| self.signal(name));
        let mut parents: Vec<usize> = (0..self.signals.len()).collect();
        for (at, body) in self.bodies() {
            if !joins[at] || predicates.contains(&Some(at)) {
                continue;
            }
            for other in references(body).filter(|other| joins[*other]) {
                let (one, other) = (root(&mut parents, at), root(&mut parents, other));
                parents[one] = other;
            }
        }
        (0..parents.len()).map(|at| root(&mut parents, at)).collect()
    }

    /// Returns the predicates of which a predicate is the conjunction; itself, if it is none.
    fn conjuncts(&self, predicate: usize) -> Vec<usize> {
        let Some(body) = &self.signals[predicate].body else { return vec![predicate] };
        let is_conjunction = body.iter().all(|piece| match piece {
            Piece::Signal(_) => true,
            Piece::Text(text) => ["", "(and", ")"].contains(&text.trim()),
        });
        if is_conjunction { references(body).collect() } else { vec![predicate] }
    }
}

/// Returns `true` for a next value that depends on nothing.
fn is_constant(value: &[Piece]) -> bool {
    references(value).next().is_none()
}

/// Returns the root of a tree, and halves the way to it.
fn root(parents: &mut [usize], mut at: usize) -> usize {
    while parents[at] != at {
        parents[at] = parents[parents[at]];
        at = parents[at];
    }
    at
}

/// Returns the number in `(= input number)`.
fn compared(body: &[Piece]) -> Option<usize> {
    let [Piece::Text(before), Piece::Signal(_), Piece::Text(after)] = body else { return None };
    let bits = after.trim().strip_prefix("#b")?.strip_suffix(')')?;
    (before.trim() == "(=").then(|| usize::from_str_radix(bits, 2).ok())?
}

/// Returns `true` for a definition that is another signal.
fn is_alias(body: &[Piece]) -> bool {
    let is_empty = |piece: &Piece| matches!(piece, Piece::Text(text) if text.trim().is_empty());
    body.iter().filter(|piece| !is_empty(piece)).count() == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two registers that add a free input, or take it with their own mutation; a third that stays what it is, and one
    /// that enables the properties.
    fn system(assumption: &str, first: &str) -> System {
        let signal =
            |name: &str, sort: &str, body: &str| format!("(define-fun |t{name}| ((state |t_s|)) {sort} {body})\n");
        let text = "; yosys-smt2-module t\n(declare-sort |t_s| 0)\n".to_owned()
            + &["#sel", "#in", "#a", "#b", "#c"]
                .map(|name| format!("(declare-fun |t{name}| (|t_s|) (_ BitVec 4))\n"))
                .concat()
            + "(declare-fun |t#on| (|t_s|) Bool)\n"
            + &signal("_n sel", "(_ BitVec 4)", "(|t#sel| state)")
            + &signal("#1", "Bool", first)
            + &signal("#2", "Bool", "(= (|t#sel| state) #b0010)")
            + &signal("#x", "(_ BitVec 4)", "(bvnot (|t#in| state))")
            + &signal("#d", "(_ BitVec 4)", "(ite (|t#1| state) (|t#x| state) (bvadd (|t#a| state) (|t#x| state)))")
            + &signal("#e", "(_ BitVec 4)", "(ite (|t#2| state) (|t#x| state) (bvadd (|t#b| state) (|t#x| state)))")
            + &signal("_a 0", "Bool", "(or (|t#on| state) (= (|t#a| state) #b0000))")
            + &signal("_a 1", "Bool", "(or (|t#on| state) (= (|t#b| state) #b0000))")
            + &signal("_u 0", "Bool", assumption)
            + &signal("_a", "Bool", "(and\n  (|t_a 0| state)\n  (|t_a 1| state)\n)")
            + &signal("_u", "Bool", "(|t_u 0| state)")
            + "(define-fun |t_t| ((state |t_s|) (next_state |t_s|)) Bool (and\n  \
               (= (|t#d| state) (|t#a| next_state))\n  (= (|t#e| state) (|t#b| next_state))\n  \
               (= (|t#c| state) (|t#c| next_state))\n  (= true (|t#on| next_state))\n))\n";
        System::parse(&text, false).unwrap()
    }

    /// Returns the registers, properties and assumptions of the part of a mutation.
    fn names(system: &System, number: usize) -> [Vec<&str>; 3] {
        let [select, all, assumed] = ["#sel", "_a", "_u"].map(|name| system.signal(name).unwrap());
        let part = system.part(&system.parts(select, all, assumed), number);
        let name = |at: &usize| system.names.iter().find(|(_, of)| *of == at).map_or("", |(name, _)| &name[1..]);
        let registers = system.registers(&part).map(|at| name(&at)).collect();
        [registers, part.properties.iter().map(name).collect(), part.assumptions.iter().map(name).collect()]
    }

    const COMPARED: &str = "(= (|t#sel| state) #b0001)";

    #[test]
    fn a_part_has_what_depends_on_the_mutation_and_not_what_shares_free_inputs() {
        let system = system("(= (|t#c| state) #b0000)", COMPARED);
        assert_eq!(names(&system, 1), [vec!["#a", "#on"], vec!["_a 0"], vec![]]);
        assert_eq!(names(&system, 2), [vec!["#b", "#on"], vec!["_a 1"], vec![]]);
        // Yosys found that this mutation changes nothing.
        assert_eq!(names(&system, 3), [vec!["#on"], vec![], vec![]]);
    }

    #[test]
    fn an_assumption_about_an_input_joins_all_that_depend_on_it() {
        let system = system("(= (|t#in| state) (|t#c| state))", COMPARED);
        for number in [1, 2] {
            assert_eq!(names(&system, number), [vec!["#a", "#b", "#c", "#on"], vec!["_a 0", "_a 1"], vec!["_u 0"]]);
        }
    }

    #[test]
    fn an_unknown_use_of_the_selecting_input_makes_the_part_everything() {
        let system = system("true", "(= ((_ extract 0 0) (|t#sel| state)) #b1)");
        for number in [1, 2, 3] {
            assert_eq!(names(&system, number), [vec!["#a", "#b", "#c", "#on"], vec!["_a"], vec!["_u"]]);
        }
    }
}
