//! What the top takes of an Arria V, from Debian's Yosys 0.23 (`synth_intel_alm -family arriav -noflatten`): a *Yosys
//! estimate*.
//!
//! Yosys counts ALUTs, registers, memories and multipliers of each module. From them, for each instance of it, its
//! children apart:
//!
//! ```text
//! ALM  = max(ceil(LUT), ceil(FF / 4)) + 10 MLAB       LUT  = ALUT6 + (ALUT2..5 + NOT + ALUT_ARITH) / 2
//! M10K = cells of that kind                           MLAB = ceil(width / 20) for each memory of at most 32 words
//! DSP  = ceil(18x18 / 2) + ceil(9x9 / 3) + 27x27      for all instances of a module together
//! ```
//!
//! An ALM holds one 6-input ALUT or two smaller ones, two bits of a carry chain and four registers; an MLAB is ten
//! ALMs. No two instances share an ALM here, nothing is optimised across their borders, and registers that Quartus
//! packs into multipliers and memories are counted: the estimate is high rather than low, and the parts add up to the
//! whole.
//!
//! What is estimated must be what is simulated: every cell must be known (no black box), and every memory of the
//! Verilog must be found again as block memory or MLAB with all of its bits ([`memory`]). How deep the logic is says
//! `depth`.

mod depth;
pub mod memory;
pub mod netlist;
mod yosys;

use std::collections::BTreeMap;

use serde::Serialize;

use self::memory::Memory;
use self::netlist::{Flat, Kind};
use hoverlock_rtl::emission::EmitError;

pub use self::yosys::{estimate, of};

/// The clock it is meant for, MHz.
pub const TARGET_MHZ: u32 = 100;

/// At most this many DSP blocks, whatever the device.
pub const DSP_LIMIT: u64 = 60;

/// How the ALMs are derived.
pub const ALM_RULE: &str = "for each instance max(ALUT6 + half of the smaller ALUTs, inverters and carry bits; \
                            registers / 4) \
                            + 10 for each MLAB of 20 bits x 32 words; no two instances share an ALM";

/// What a level is.
pub const LEVELS_RULE: &str = "longest path between registers, block memories, multipliers and pins that passes the \
                               module's logic; \
                               a LUT, an inverter, an MLAB's read or a whole carry chain is one level";

/// What fits.
pub const FITS_RULE: &str =
    "a third of the device's ALMs, M10K and DSP blocks stays free, and at most 60 DSP blocks are used";

/// What an Arria V offers, and whether the top fits it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Device {
    /// Name.
    pub name: String,
    /// Where its figures come from.
    pub source: &'static str,
    /// Adaptive logic modules.
    pub alm: u64,
    /// Block memories of 10 Kbit.
    pub m10k: u64,
    /// DSP blocks.
    pub dsp: u64,
    /// Share of each that the top takes, percent: ALM, M10K, DSP blocks.
    pub used_percent: [f64; 3],
    /// The most of each that leaves a third free, and no more DSP blocks than [`DSP_LIMIT`].
    pub limits: [u64; 3],
    /// The top keeps these limits.
    pub fits: bool,
}

/// What the instances of one module take, without what stands in modules of their own below.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModuleEstimate {
    /// Name of the module, and of its file.
    pub name: String,
    /// Number of instances in the top.
    pub instances: u64,
    /// Adaptive logic modules.
    pub alm: u64,
    /// Block memories of 10 Kbit.
    pub m10k: u64,
    /// Small memories of 32 words x 20 bits, in the ALMs.
    pub mlab: u64,
    /// Multipliers 18 x 18.
    pub mul18: u64,
    /// DSP blocks.
    pub dsp: u64,
    /// Registers.
    pub registers: u64,
    /// Levels of the longest path through its logic.
    pub logic_levels: u32,
    /// Delay of the slowest path through its logic, cells only, no wires: ps after Yosys's figures for Arria V.
    pub cell_delay_ps: u32,
    /// Where the path of most levels begins.
    pub path_from: String,
    /// Where it ends.
    pub path_to: String,
}

/// A Yosys estimate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimate {
    /// What this is.
    pub label: &'static str,
    /// Which Yosys.
    pub yosys: String,
    /// Adaptive logic modules.
    pub alm: u64,
    /// Block memories of 10 Kbit.
    pub m10k: u64,
    /// DSP blocks.
    pub dsp: u64,
    /// Multipliers 18 x 18.
    pub mul18: u64,
    /// Small memories of 32 words x 20 bits, in the ALMs.
    pub mlab: u64,
    /// Registers.
    pub registers: u64,
    /// Levels of the longest path.
    pub logic_levels: u32,
    /// Delay of the slowest path, cells only, no wires, ps.
    pub cell_delay_ps: u32,
    /// Multipliers with an operand or a product that is no register's.
    pub unregistered_multipliers: u64,
    /// The clock it is meant for, MHz.
    pub target_mhz: u32,
    /// The device it is for, the smallest of the family.
    pub device: String,
    /// It fits that one.
    pub fits: bool,
    /// What fits means.
    pub fits_rule: &'static str,
    /// How the ALMs are derived.
    pub alm_rule: &'static str,
    /// What a level is.
    pub levels_rule: &'static str,
    /// The smallest device and the next larger ones.
    pub devices: Vec<Device>,
    /// Each module, first the one with the greatest share of the ALMs or of the M10K.
    pub modules: Vec<ModuleEstimate>,
    /// Each memory of the Verilog, and what holds it.
    pub memories: Vec<Memory>,
    /// Cells as Yosys counts them.
    pub cells: BTreeMap<String, u64>,
}

/// Why there is no estimate.
#[derive(Debug, thiserror::Error)]
pub enum EstimateError {
    /// There is no Verilog.
    #[error(transparent)]
    Emit(#[from] EmitError),
    /// Yosys is not there.
    #[error(
        "yosys cannot be started ({0}): install Debian's package yosys (0.23), or run `make demo` once, which does"
    )]
    Missing(std::io::Error),
    /// There is no folder for the netlist.
    #[error(transparent)]
    Cache(#[from] hoverlock_cache::NoCacheFolder),
    /// A file beside Yosys cannot be written or read.
    #[error(
        "{path}: {source}; the estimate works in the user's cache folder, see HOVERLOCK_CACHE",
        path = path.display()
    )]
    File {
        /// Which.
        path: std::path::PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Yosys does not like something.
    #[error("yosys fails: {0}")]
    Failed(String),
    /// What Yosys wrote is not the netlist of the design, so its counts mean nothing.
    #[error("the estimate is not of the design: {0}")]
    Implausible(String),
}

/// Name, source of the figures, ALM, M10K blocks, DSP blocks.
const DEVICES: [(&str, &str, u64, u64, u64); 5] = [
    ("5AGXA1", "believed", 28_302, 800, 240),
    ("5AGXA3", "believed: as 5AGTC3, Intel 683440", 58_900, 1051, 396),
    ("5AGXA7", "believed: as 5AGTC7, Intel 683440", 91_680, 1366, 800),
    ("5AGXB3", "believed: as 5AGTD3, Intel 683440", 136_880, 1726, 1045),
    ("5AGXB7", "believed: as 5AGTD7, Intel 683440", 190_240, 2414, 1156),
];

/// Name of the smallest device, and its ALM, M10K and DSP blocks that a design may use.
pub fn smallest_device() -> (&'static str, [u64; 3]) {
    let (name, _, alm, m10k, dsp) = DEVICES[0];
    (name, limits(alm, m10k, dsp))
}

/// The most of each that leaves a third free, and no more DSP blocks than [`DSP_LIMIT`].
fn limits(alm: u64, m10k: u64, dsp: u64) -> [u64; 3] {
    [2 * alm / 3, 2 * m10k / 3, (2 * dsp / 3).min(DSP_LIMIT)]
}

/// From a netlist and the memories of its Verilog to resources.
///
/// # Errors
/// Where a memory is not found again, or the logic is no logic of this family.
fn derive(yosys: String, flat: &Flat, memories: Vec<Memory>) -> Result<Estimate, EstimateError> {
    let depths = depth::depths(flat)?;
    let mut modules = Vec::new();
    for (index, name) in flat.modules.iter().enumerate() {
        let instances = flat.instances.iter().filter(|instance| instance.module == index).count() as u64;
        // All instances of a module have the same cells.
        let Some(first) = flat.instances.iter().position(|instance| instance.module == index) else { continue };
        let mut cells: BTreeMap<Kind, u64> = BTreeMap::new();
        for cell in flat.cells.iter().filter(|cell| cell.instance == first) {
            *cells.entry(cell.kind).or_default() += 1;
        }
        let count = |kinds: &[Kind]| kinds.iter().filter_map(|kind| cells.get(kind)).sum::<u64>();
        let halves = count(&[Kind::Not, Kind::Alut2, Kind::Alut3, Kind::Alut4, Kind::Alut5, Kind::Arithmetic]);
        let registers = count(&[Kind::Register]);
        let mlab: u64 = memories.iter().filter(|memory| &memory.module == name).map(|memory| memory.mlab).sum();
        let alm = (count(&[Kind::Alut6]) + halves.div_ceil(2)).max(registers.div_ceil(4)) + 10 * mlab;
        let all = |kind: Kind| instances * count(&[kind]);
        let depth = &depths[index];
        modules.push(ModuleEstimate {
            name: name.clone(),
            instances,
            alm: instances * alm,
            m10k: all(Kind::M10k),
            mlab: instances * mlab,
            mul18: all(Kind::Mul18),
            dsp: all(Kind::Mul18).div_ceil(2) + all(Kind::Mul9).div_ceil(3) + all(Kind::Mul27),
            registers: all(Kind::Register),
            logic_levels: depth.levels,
            cell_delay_ps: depth.delay_ps,
            path_from: depth.from.clone(),
            path_to: depth.to.clone(),
        });
    }
    let sum = |of: fn(&ModuleEstimate) -> u64| modules.iter().map(of).sum::<u64>();
    let (alm, m10k, dsp) = (sum(|module| module.alm), sum(|module| module.m10k), sum(|module| module.dsp));
    // Line memories are M10K and no ALM, logic the other way round: the greater share of the two counts.
    let share = |part: u64, of: u64| part as f64 / of.max(1) as f64;
    let weight = |module: &ModuleEstimate| share(module.alm, alm).max(share(module.m10k, m10k));
    modules.sort_by(|a, b| weight(b).total_cmp(&weight(a)).then_with(|| a.name.cmp(&b.name)));
    let sum = |of: fn(&ModuleEstimate) -> u64| modules.iter().map(of).sum::<u64>();
    let devices: Vec<Device> = DEVICES
        .iter()
        .map(|&(name, source, alms, blocks, dsps)| {
            let (used, has) = ([alm, m10k, dsp], [alms, blocks, dsps]);
            let limits = limits(alms, blocks, dsps);
            Device {
                name: name.into(),
                source,
                alm: alms,
                m10k: blocks,
                dsp: dsps,
                used_percent: [0, 1, 2].map(|i| 100.0 * used[i] as f64 / has[i] as f64),
                limits,
                fits: (0..3).all(|i| used[i] <= limits[i]),
            }
        })
        .collect();
    let mut cells: BTreeMap<String, u64> = BTreeMap::new();
    for cell in &flat.cells {
        *cells.entry(cell.kind.name().into()).or_default() += 1;
    }
    Ok(Estimate {
        label: "Yosys estimate",
        yosys,
        alm,
        m10k,
        dsp,
        mul18: sum(|module| module.mul18),
        mlab: sum(|module| module.mlab),
        registers: sum(|module| module.registers),
        logic_levels: modules.iter().map(|module| module.logic_levels).max().unwrap_or_default(),
        cell_delay_ps: modules.iter().map(|module| module.cell_delay_ps).max().unwrap_or_default(),
        unregistered_multipliers: flat.unregistered_multipliers(),
        target_mhz: TARGET_MHZ,
        device: devices[0].name.clone(),
        fits: devices[0].fits,
        fits_rule: FITS_RULE,
        alm_rule: ALM_RULE,
        levels_rule: LEVELS_RULE,
        devices,
        modules,
        memories,
        cells,
    })
}
