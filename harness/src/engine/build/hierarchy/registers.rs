//! Which variables are registers: those that an `always` block with an edge in its sensitivity list assigns.
//!
//! A target of `<=` in such a block is a register. A target of `=` in one may be a mere name for an expression, such as
//! a loop variable; it is a register if some block, or a continuous assignment, reads it before it assigns it.

use std::collections::{HashMap, HashSet};

use super::Declaration;

/// How a statement refers to a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// Its value is used, or a part of its name selects.
    Read,
    /// It is the target of `=`.
    Assigned,
    /// It is the target of `<=`.
    Clocked,
}

/// A reference to a variable.
pub struct Reference {
    /// The named blocks around the reference, with a dot after each.
    pub blocks: String,
    pub name: String,
    pub access: Access,
}

/// An `always` or `initial` block, or everything outside of these: its references in the order of evaluation.
#[derive(Default)]
pub struct Process {
    /// Whether its sensitivity list has an edge.
    pub has_edge: bool,
    pub references: Vec<Reference>,
}

/// The references of a module.
#[derive(Default)]
pub struct References {
    processes: Vec<Process>,
    outside: HashSet<(String, String)>,
}

impl References {
    /// Adds a block that is complete.
    pub fn add(&mut self, process: Process) {
        self.processes.push(process);
    }

    /// Adds the body of a task. What it assigns with `=` depends on who calls it, and is no register.
    pub fn add_task(&mut self, references: Vec<Reference>) {
        let references = references.into_iter().filter(|reference| reference.access != Access::Assigned).collect();
        self.processes.push(Process { has_edge: true, references });
    }

    /// Adds a reference outside of any block: a continuous assignment, or a connection of an instance.
    pub fn add_outside(&mut self, reference: Reference) {
        self.outside.insert((reference.blocks, reference.name));
    }

    /// Returns which of the declared variables of the module are registers.
    pub fn registers(&self, declared: &[Declaration]) -> Vec<bool> {
        let mut places: HashMap<(&str, &str), usize> = HashMap::new();
        for (at, variable) in declared.iter().enumerate() {
            places.insert((&variable.blocks, &variable.name), at);
        }
        // The declaration in the innermost of the enclosing blocks that has one.
        let find = |blocks: &str, name: &str| {
            let mut blocks = blocks;
            loop {
                if let Some(at) = places.get(&(blocks, name)) {
                    return Some(*at);
                }
                let inner = blocks.strip_suffix('.')?;
                blocks = inner.rfind('.').map_or("", |dot| &blocks[..=dot]);
            }
        };
        let mut is_read: Vec<bool> = declared.iter().map(|variable| variable.port.is_some()).collect();
        for (blocks, name) in &self.outside {
            find(blocks, name).into_iter().for_each(|at| is_read[at] = true);
        }
        for process in &self.processes {
            let mut met = HashSet::new();
            for reference in &process.references {
                if let Some(at) = find(&reference.blocks, &reference.name)
                    && met.insert(at)
                {
                    is_read[at] |= reference.access == Access::Read;
                }
            }
        }
        let mut found = vec![false; declared.len()];
        for reference in self.processes.iter().filter(|process| process.has_edge).flat_map(|p| &p.references) {
            if let Some(at) = find(&reference.blocks, &reference.name) {
                found[at] |= match reference.access {
                    Access::Clocked => true,
                    Access::Assigned => is_read[at],
                    Access::Read => false,
                };
            }
        }
        found
    }
}
