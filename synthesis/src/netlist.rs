//! A mapped netlist as Yosys writes it, and the same with its hierarchy unfolded: cells of known kinds between nets.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::EstimateError;

/// The JSON file that Yosys's `write_json` writes.
#[derive(Debug, Deserialize)]
pub struct Netlist {
    /// Modules by name, library cells among them.
    modules: BTreeMap<String, Module>,
}

#[derive(Debug, Deserialize)]
struct Module {
    attributes: BTreeMap<String, serde_json::Value>,
    ports: BTreeMap<String, Port>,
    cells: BTreeMap<String, Cell>,
}

#[derive(Debug, Deserialize)]
struct Port {
    bits: Vec<Bit>,
}

#[derive(Debug, Deserialize)]
struct Cell {
    #[serde(rename = "type")]
    kind: String,
    connections: BTreeMap<String, Vec<Bit>>,
}

/// A net of a module, or a constant.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
enum Bit {
    Net(usize),
    Constant(serde::de::IgnoredAny),
}

/// The kind of a cell of the family.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A look-up table with two inputs.
    Alut2,
    /// A look-up table with three inputs.
    Alut3,
    /// A look-up table with four inputs.
    Alut4,
    /// A look-up table with five inputs.
    Alut5,
    /// A look-up table with six inputs.
    Alut6,
    /// One bit of a carry chain.
    Arithmetic,
    /// An inverter.
    Not,
    /// A flip-flop.
    Register,
    /// One bit of 32 words in the ALMs.
    Mlab,
    /// A block memory.
    M10k,
    /// A multiplier 9 x 9.
    Mul9,
    /// A multiplier 18 x 18.
    Mul18,
    /// A multiplier 27 x 27.
    Mul27,
    /// A pin or the clock's buffer.
    Pin,
}

impl Kind {
    fn of(kind: &str) -> Option<Self> {
        Some(match kind.strip_prefix("MISTRAL_")? {
            "ALUT2" => Self::Alut2,
            "ALUT3" => Self::Alut3,
            "ALUT4" => Self::Alut4,
            "ALUT5" => Self::Alut5,
            "ALUT6" => Self::Alut6,
            "ALUT_ARITH" => Self::Arithmetic,
            "NOT" => Self::Not,
            "FF" => Self::Register,
            "MLAB" => Self::Mlab,
            "M10K" => Self::M10k,
            "MUL9X9" => Self::Mul9,
            "MUL18X18" => Self::Mul18,
            "MUL27X27" => Self::Mul27,
            "IB" | "OB" | "CLKBUF" => Self::Pin,
            _ => return None,
        })
    }

    /// Returns Yosys's name of the kind, without `MISTRAL_`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Alut2 => "ALUT2",
            Self::Alut3 => "ALUT3",
            Self::Alut4 => "ALUT4",
            Self::Alut5 => "ALUT5",
            Self::Alut6 => "ALUT6",
            Self::Arithmetic => "ALUT_ARITH",
            Self::Not => "NOT",
            Self::Register => "FF",
            Self::Mlab => "MLAB",
            Self::M10k => "M10K",
            Self::Mul9 => "MUL9X9",
            Self::Mul18 => "MUL18X18",
            Self::Mul27 => "MUL27X27",
            Self::Pin => "pin",
        }
    }

    /// Returns `true` if a port of such a cell is an output; all others are inputs.
    fn is_output(self, port: &str) -> bool {
        match self {
            Self::Arithmetic => matches!(port, "SO" | "CO"),
            Self::Mlab | Self::M10k => port == "B1DATA",
            Self::Mul9 | Self::Mul18 | Self::Mul27 => port == "Y",
            Self::Pin => matches!(port, "O" | "Q"),
            _ => port == "Q",
        }
    }
}

/// An instance of a module.
#[derive(Debug)]
pub struct Instance {
    /// Index of its module in [`Flat::modules`].
    pub module: usize,
    /// Names of the instances from the top down, joined by dots; empty for the top.
    pub path: String,
}

/// A cell of the unfolded netlist.
#[derive(Debug)]
pub struct FlatCell {
    /// Kind of the cell.
    pub kind: Kind,
    /// Index of the instance that contains it, in [`Flat::instances`].
    pub instance: usize,
    /// Name of the cell in its module.
    pub name: String,
    /// Port name and net number of each input bit that is not constant.
    pub inputs: Vec<(String, usize)>,
    /// Port name and net number of each output bit.
    pub outputs: Vec<(String, usize)>,
}

/// The netlist without hierarchy.
#[derive(Debug, Default)]
pub struct Flat {
    /// Names of the modules that it instantiates, the top first.
    pub modules: Vec<String>,
    /// Instances of modules, the top first.
    pub instances: Vec<Instance>,
    /// Cells of all instances.
    pub cells: Vec<FlatCell>,
    /// Number of nets; the nets of the cells are `0 .. nets`.
    pub nets: usize,
}

impl Flat {
    /// Unfolds a netlist from its top.
    ///
    /// # Errors
    /// If a cell is neither of the family nor an instance of a module with content.
    pub fn of(netlist: &Netlist, top: &str) -> Result<Self, EstimateError> {
        let mut unfolding = Unfolding { netlist, flat: Self::default(), joined: Vec::new() };
        unfolding.visit(top, String::new(), &BTreeMap::new())?;
        let Unfolding { mut flat, mut joined, .. } = unfolding;
        for cell in &mut flat.cells {
            for (_, net) in cell.inputs.iter_mut().chain(&mut cell.outputs) {
                *net = root(&mut joined, *net);
            }
        }
        flat.nets = joined.len();
        Ok(flat)
    }

    /// Returns the number of multipliers with an operand that is not the output of a register, or with a product that
    /// also goes elsewhere than to registers.
    pub fn unregistered_multipliers(&self) -> u64 {
        let (mut from_register, mut to_other) = (vec![false; self.nets], vec![false; self.nets]);
        for cell in &self.cells {
            if cell.kind == Kind::Register {
                cell.outputs.iter().for_each(|(_, net)| from_register[*net] = true);
            }
            let other = cell.inputs.iter().filter(|(port, _)| cell.kind != Kind::Register || port != "DATAIN");
            other.for_each(|(_, net)| to_other[*net] = true);
        }
        let bare = |cell: &&FlatCell| {
            matches!(cell.kind, Kind::Mul9 | Kind::Mul18 | Kind::Mul27)
                && (cell.inputs.iter().any(|(_, net)| !from_register[*net])
                    || cell.outputs.iter().any(|(_, net)| to_other[*net]))
        };
        self.cells.iter().filter(bare).count() as u64
    }

    /// Returns the path of a cell, given its index: instance and output signal, joined by a dot.
    pub fn path(&self, cell: usize) -> String {
        let cell = &self.cells[cell];
        let signal = cell.name.split("_MISTRAL").next().unwrap_or_default();
        let path = &self.instances[cell.instance].path;
        if path.is_empty() { signal.into() } else { format!("{path}.{signal}") }
    }
}

struct Unfolding<'a> {
    netlist: &'a Netlist,
    flat: Flat,
    /// Union-find over nets: a module may hand an input through to an output.
    joined: Vec<usize>,
}

fn root(joined: &mut [usize], mut net: usize) -> usize {
    while joined[net] != net {
        joined[net] = joined[joined[net]];
        net = joined[net];
    }
    net
}

impl Unfolding<'_> {
    fn visit(&mut self, name: &str, path: String, outside: &BTreeMap<usize, usize>) -> Result<(), EstimateError> {
        let black_box = || {
            EstimateError::Implausible(format!(
                "`{name}` at {path:?} is neither a cell of the family nor a module with content"
            ))
        };
        let netlist = self.netlist;
        let module = netlist.modules.get(name).ok_or_else(black_box)?;
        if module.attributes.contains_key("blackbox") {
            return Err(black_box());
        }
        let index = self.flat.modules.iter().position(|known| known == name).unwrap_or_else(|| {
            self.flat.modules.push(name.into());
            self.flat.modules.len() - 1
        });
        let instance = self.flat.instances.len();
        self.flat.instances.push(Instance { module: index, path: path.clone() });
        let mut nets = outside.clone();
        for (cell_name, cell) in &module.cells {
            if let Some(kind) = Kind::of(&cell.kind) {
                let mut flat =
                    FlatCell { kind, instance, name: cell_name.clone(), inputs: Vec::new(), outputs: Vec::new() };
                for (port, bits) in &cell.connections {
                    let pins = if kind.is_output(port) { &mut flat.outputs } else { &mut flat.inputs };
                    for bit in bits {
                        if let Bit::Net(bit) = bit {
                            pins.push((port.clone(), net(&mut nets, &mut self.joined, *bit)));
                        }
                    }
                }
                self.flat.cells.push(flat);
                continue;
            }
            let child = netlist.modules.get(&cell.kind);
            let mut inside = BTreeMap::new();
            for (port, declared) in child.map(|child| &child.ports).into_iter().flatten() {
                let Some(connected) = cell.connections.get(port) else { continue };
                for (theirs, ours) in declared.bits.iter().zip(connected) {
                    // A constant at a port drives nothing that the walk would have to know.
                    let (Bit::Net(theirs), Bit::Net(ours)) = (theirs, ours) else { continue };
                    let ours = net(&mut nets, &mut self.joined, *ours);
                    match inside.get(theirs) {
                        None => {
                            inside.insert(*theirs, ours);
                        }
                        Some(&other) => {
                            let (a, b) = (root(&mut self.joined, other), root(&mut self.joined, ours));
                            self.joined[a] = b;
                        }
                    }
                }
            }
            let below = if path.is_empty() { cell_name.clone() } else { format!("{path}.{cell_name}") };
            self.visit(&cell.kind, below, &inside)?;
        }
        Ok(())
    }
}

/// Returns the number of a module's net in the netlist without hierarchy.
fn net(nets: &mut BTreeMap<usize, usize>, joined: &mut Vec<usize>, bit: usize) -> usize {
    *nets.entry(bit).or_insert_with(|| {
        joined.push(joined.len());
        joined.len() - 1
    })
}
