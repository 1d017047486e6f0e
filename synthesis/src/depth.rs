//! `depth(e) = arrival(in) + w(e) + departure(out)` over every edge `e` of a module's logic; the largest is the
//! module's depth.
//!
//! Registers, block memories, multipliers and pins begin and end paths. Edges lead through LUTs, inverters, carry
//! chains and the asynchronous read of an MLAB. In levels `w` is 1, and 0 along a carry chain, so that an adder of any
//! width is one level. In picoseconds `w` is the cell's delay, an arrival begins with the time from the clock to the
//! output of a register or a block memory, and a departure ends with the set-up time of what takes the signal, as Yosys
//! has them for Arria V (`intel_alm/common/alm_sim.v`, `mem_sim.v`, `dff_sim.v`). Wires are not in it, nor is a
//! multiplier, whose own registers are in its block.

use crate::{
    EstimateError,
    netlist::{Flat, FlatCell, Kind},
};

/// The longest path through a module's logic.
#[derive(Debug, Clone, Default)]
pub struct Depth {
    /// Number of levels.
    pub levels: u32,
    /// Delay of the slowest path from clock edge to set-up, ps.
    pub delay_ps: u32,
    /// Start of the path with the most levels: instance and signal.
    pub from: String,
    /// End of that path.
    pub to: String,
}

struct Edge {
    from: usize,
    to: usize,
    cell: usize,
    levels: u32,
    delay_ps: u32,
}

/// Returns the delay of a cell from an input to an output, ps; `None` if there is no combinational path between them.
fn delay_ps(cell: &FlatCell, from: &str, to: &str) -> Option<u32> {
    let pick = |pins: &str, delays: &[u32]| pins.find(from).and_then(|at| delays.get(at)).copied();
    match cell.kind {
        Kind::Alut6 => pick("ABCDEF", &[387, 375, 316, 317, 319, 76]),
        Kind::Alut5 => pick("ABCDE", &[375, 316, 317, 319, 76]),
        Kind::Alut4 => pick("ABCD", &[316, 317, 319, 76]),
        Kind::Alut3 => pick("ABC", &[316, 317, 76]),
        Kind::Alut2 => pick("AB", &[316, 76]),
        Kind::Not => pick("A", &[76]),
        Kind::Arithmetic => {
            let pin = ["A", "B", "C", "D0", "D1", "CI"].iter().position(|pin| *pin == from)?;
            Some(if to == "SO" { [744, 732, 562, 576, 511, 249] } else { [629, 623, 530, 514, 696, 10] }[pin])
        }
        // The slowest address bit.
        Kind::Mlab => (from == "B1ADDR").then_some(370),
        _ => None,
    }
}

/// Returns the delay from the clock edge to the output of a cell, ps.
fn clock_to_output_ps(kind: Kind) -> u32 {
    match kind {
        Kind::Register => 470,
        Kind::M10k => 787,
        _ => 0,
    }
}

/// Returns the set-up time of the slowest input of a cell at which paths end, ps.
fn set_up_ps(kind: Kind) -> u32 {
    match kind {
        Kind::Mlab => 62,
        Kind::M10k => 126,
        _ => 0,
    }
}

/// Computes the depth of each module, in the order of [`Flat::modules`].
///
/// # Errors
/// If the logic has a combinational loop.
pub fn depths(flat: &Flat) -> Result<Vec<Depth>, EstimateError> {
    let mut edges = Vec::new();
    let (mut driver, mut sink) = (vec![None; flat.nets], vec![None; flat.nets]);
    let mut set_up = vec![0; flat.nets];
    for (index, cell) in flat.cells.iter().enumerate() {
        cell.outputs.iter().for_each(|(_, net)| driver[*net] = Some(index));
        for (input, from) in &cell.inputs {
            let mut passes = false;
            for (output, to) in &cell.outputs {
                if let Some(delay_ps) = delay_ps(cell, input, output) {
                    let levels = u32::from(!(cell.kind == Kind::Arithmetic && input == "CI"));
                    edges.push(Edge { from: *from, to: *to, cell: index, levels, delay_ps });
                    passes = true;
                }
            }
            if !passes {
                sink[*from] = Some(index);
                set_up[*from] = set_up[*from].max(set_up_ps(cell.kind));
            }
        }
    }
    let clock_to_output: Vec<u32> = driver
        .iter()
        .map(|driver| driver.map_or(0, |index: usize| clock_to_output_ps(flat.cells[index].kind)))
        .collect();
    let mut leaving = vec![Vec::new(); flat.nets];
    let mut waiting = vec![0usize; flat.nets];
    for (index, edge) in edges.iter().enumerate() {
        leaving[edge.from].push(index);
        waiting[edge.to] += 1;
    }
    // Nets in the order of the data: each after all that lead to it.
    let mut order: Vec<usize> = (0..flat.nets).filter(|net| waiting[*net] == 0).collect();
    let mut next = 0;
    while next < order.len() {
        for &edge in &leaving[order[next]] {
            let to = edges[edge].to;
            waiting[to] -= 1;
            if waiting[to] == 0 {
                order.push(to);
            }
        }
        next += 1;
    }
    if order.len() < flat.nets {
        let looped = (0..flat.nets).find(|net| waiting[*net] > 0).and_then(|net| driver[net]);
        let path = looped.map(|cell| flat.path(cell)).unwrap_or_default();
        return Err(EstimateError::Implausible(format!("combinational loop at {path}")));
    }
    let longest = |weight: fn(&Edge) -> u32, begin: &[u32], end: &[u32]| {
        let alone = |times: &[u32]| times.iter().map(|time| (*time, None)).collect::<Vec<_>>();
        let (mut arrival, mut departure) = (alone(begin), alone(end));
        for &net in &order {
            for &index in &leaving[net] {
                let edge = &edges[index];
                let length = arrival[net].0 + weight(edge);
                if arrival[edge.to].1.is_none() || length > arrival[edge.to].0 {
                    arrival[edge.to] = (length, Some(net));
                }
            }
        }
        for &net in order.iter().rev() {
            for &index in &leaving[net] {
                let edge = &edges[index];
                let length = departure[edge.to].0 + weight(edge);
                // What takes the signal here may need it earlier than what takes it further on.
                let alone = departure[net].1.is_none() && length >= departure[net].0;
                if alone || length > departure[net].0 {
                    departure[net] = (length, Some(edge.to));
                }
            }
        }
        (arrival, departure)
    };
    let none = vec![0; flat.nets];
    let levels = longest(|edge| edge.levels, &none, &none);
    let delays = longest(|edge| edge.delay_ps, &clock_to_output, &set_up);
    let mut found = vec![Depth::default(); flat.modules.len()];
    let mut deepest: Vec<Option<&Edge>> = vec![None; flat.modules.len()];
    for edge in &edges {
        let module = flat.instances[flat.cells[edge.cell].instance].module;
        let depth = &mut found[module];
        let length = levels.0[edge.from].0 + edge.levels + levels.1[edge.to].0;
        if length > depth.levels {
            depth.levels = length;
            deepest[module] = Some(edge);
        }
        depth.delay_ps = depth.delay_ps.max(delays.0[edge.from].0 + edge.delay_ps + delays.1[edge.to].0);
    }
    let end_of = |ways: &[(u32, Option<usize>)], mut net: usize| {
        while let Some(further) = ways[net].1 {
            net = further;
        }
        net
    };
    for (depth, edge) in found.iter_mut().zip(deepest) {
        let Some(edge) = edge else { continue };
        let (from, to) = (end_of(&levels.0, edge.from), end_of(&levels.1, edge.to));
        let path = |cell: Option<usize>| cell.map(|cell| flat.path(cell)).unwrap_or_default();
        (depth.from, depth.to) = (path(driver[from]), path(sink[to]));
    }
    Ok(found)
}
