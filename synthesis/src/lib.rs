//! The resources of the top in an Arria V, from Debian's Yosys 0.23 (`synth_intel_alm -family arriav -noflatten`): a
//! *Yosys estimate*.
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
//! Verilog must be found again as block memory or MLAB with all of its bits ([`memory`]). `depth` computes the depth
//! of the logic.

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

/// Frequency of the clock that the design must reach, MHz.
pub const TARGET_MHZ: u32 = 100;

/// Largest number of DSP blocks that a design may use on any device.
pub const DSP_LIMIT: u64 = 60;

/// Derivation of the ALMs, for reports.
pub const ALM_RULE: &str = "for each instance max(ALUT6 + half of the smaller ALUTs, inverters and carry bits; \
                            registers / 4) \
                            + 10 for each MLAB of 20 bits x 32 words; no two instances share an ALM";

/// Definition of a logic level, for reports.
pub const LEVELS_RULE: &str = "longest path between registers, block memories, multipliers and pins that passes the \
                               module's logic; \
                               a LUT, an inverter, an MLAB's read or a whole carry chain is one level";

/// Condition under which a design fits a device, for reports.
pub const FITS_RULE: &str =
    "a third of the device's ALMs, M10K and DSP blocks stays free, and at most 60 DSP blocks are used";

/// An Arria V device: its resources, and whether the top fits it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Device {
    /// Name of the device.
    pub name: String,
    /// Source of the numbers of its resources.
    pub source: &'static str,
    /// Number of adaptive logic modules of the device.
    pub alm: u64,
    /// Number of 10-Kbit block memories of the device.
    pub m10k: u64,
    /// Number of DSP blocks of the device.
    pub dsp: u64,
    /// ALM, M10K and DSP blocks that the top uses, percent of the device.
    pub used_percent: [f64; 3],
    /// Largest numbers of ALM, M10K and DSP blocks that fit: two thirds of the device, and at most [`DSP_LIMIT`] DSP
    /// blocks.
    pub limits: [u64; 3],
    /// The top is within these limits.
    pub fits: bool,
}

/// The resources of one module, summed over its instances. Modules that it instantiates are not included.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModuleEstimate {
    /// Name of the module, and of its file.
    pub name: String,
    /// Number of instances in the top.
    pub instances: u64,
    /// Number of adaptive logic modules of all instances, by [`ALM_RULE`].
    pub alm: u64,
    /// Number of 10-Kbit block memories of all instances.
    pub m10k: u64,
    /// Number of MLABs of all instances: memories of 32 words x 20 bits in ALMs, ten each, which `alm` includes.
    pub mlab: u64,
    /// Number of 18 x 18 multipliers of all instances.
    pub mul18: u64,
    /// Number of DSP blocks of all instances, each for two 18 x 18, three 9 x 9 or one 27 x 27 multiplier.
    pub dsp: u64,
    /// Number of flip-flops of all instances.
    pub registers: u64,
    /// Levels of the longest path through its logic, by [`LEVELS_RULE`].
    pub logic_levels: u32,
    /// Delay of the slowest path through its logic, ps: Yosys's cell delays for Arria V, without wires.
    pub cell_delay_ps: u32,
    /// Start of the path with the most levels: instance and signal.
    pub path_from: String,
    /// End of that path.
    pub path_to: String,
}

/// A Yosys estimate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimate {
    /// `Yosys estimate`, for reports.
    pub label: &'static str,
    /// Version of Yosys.
    pub yosys: String,
    /// Number of adaptive logic modules, by [`ALM_RULE`].
    pub alm: u64,
    /// Number of 10-Kbit block memories.
    pub m10k: u64,
    /// Number of DSP blocks.
    pub dsp: u64,
    /// Number of 18 x 18 multipliers.
    pub mul18: u64,
    /// Number of MLABs: memories of 32 words x 20 bits in ALMs, ten each, which `alm` includes.
    pub mlab: u64,
    /// Number of flip-flops.
    pub registers: u64,
    /// Levels of the longest path of any module, by [`LEVELS_RULE`].
    pub logic_levels: u32,
    /// Delay of the slowest path of any module, ps: cells only, without wires.
    pub cell_delay_ps: u32,
    /// Number of multipliers with an operand or a product that is not registered.
    pub unregistered_multipliers: u64,
    /// Value of [`TARGET_MHZ`], for the JSON file.
    pub target_mhz: u32,
    /// Name of the smallest device of the family, to which `fits` refers.
    pub device: String,
    /// The top fits `device`.
    pub fits: bool,
    /// Value of [`FITS_RULE`], for the JSON file.
    pub fits_rule: &'static str,
    /// Value of [`ALM_RULE`], for the JSON file.
    pub alm_rule: &'static str,
    /// Value of [`LEVELS_RULE`], for the JSON file.
    pub levels_rule: &'static str,
    /// The devices of the family, the smallest first.
    pub devices: Vec<Device>,
    /// All modules; first the one with the greatest share of the ALMs or of the M10K.
    pub modules: Vec<ModuleEstimate>,
    /// All memories of the Verilog, with the blocks that hold them.
    pub memories: Vec<Memory>,
    /// Number of cells of each kind in the whole netlist.
    pub cells: BTreeMap<String, u64>,
}

/// The reason why there is no estimate.
#[derive(Debug, thiserror::Error)]
pub enum EstimateError {
    /// The Verilog cannot be found or emitted.
    #[error(transparent)]
    Emit(#[from] EmitError),
    /// Yosys cannot be started.
    #[error(
        "yosys cannot be started ({0}): install Debian's package yosys (0.23), or run `make demo` once, which does"
    )]
    Missing(std::io::Error),
    /// There is no folder for the netlist.
    #[error(transparent)]
    Cache(#[from] hoverlock_cache::NoCacheFolder),
    /// A source, or a file in the cache folder, cannot be read or written.
    #[error(
        "{path}: {source}; the estimate works in the user's cache folder, see HOVERLOCK_CACHE",
        path = path.display()
    )]
    File {
        /// Path of the file.
        path: std::path::PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// Yosys reports an error, is not a working version, or its netlist cannot be parsed.
    #[error("yosys fails: {0}")]
    Failed(String),
    /// The netlist is not that of the design: it has an unknown cell, a missing memory or a combinational loop.
    #[error("the estimate is not of the design: {0}")]
    Implausible(String),
}

/// Devices: name, source of the numbers, ALMs, M10K blocks and DSP blocks.
const DEVICES: [(&str, &str, u64, u64, u64); 5] = [
    ("5AGXA1", "unverified", 28_302, 800, 240),
    ("5AGXA3", "assumed equal to 5AGTC3, Intel 683440", 58_900, 1051, 396),
    ("5AGXA7", "assumed equal to 5AGTC7, Intel 683440", 91_680, 1366, 800),
    ("5AGXB3", "assumed equal to 5AGTD3, Intel 683440", 136_880, 1726, 1045),
    ("5AGXB7", "assumed equal to 5AGTD7, Intel 683440", 190_240, 2414, 1156),
];

/// Returns the name of the smallest device, and the ALMs, M10K and DSP blocks of it that a design may use.
pub fn smallest_device() -> (&'static str, [u64; 3]) {
    let (name, _, alm, m10k, dsp) = DEVICES[0];
    (name, limits(alm, m10k, dsp))
}

/// Returns two thirds of each number, and at most [`DSP_LIMIT`] DSP blocks.
fn limits(alm: u64, m10k: u64, dsp: u64) -> [u64; 3] {
    [2 * alm / 3, 2 * m10k / 3, (2 * dsp / 3).min(DSP_LIMIT)]
}

/// Computes the estimate from a netlist and the memories of its Verilog. `yosys` is the version of Yosys.
///
/// # Errors
/// If the logic has a combinational loop.
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
