//! What the top takes of an Arria V, from Debian's Yosys 0.23 (`synth_intel_alm -family arriav`): a *Yosys estimate*.
//!
//! Yosys counts ALUTs, registers, block memories and multipliers. From them:
//!
//! ```text
//! ALM = max(LUT, FF / 4) + MLAB        LUT  = ALUTs of 6 inputs + half of the smaller ones and of the carry chains'
//!                                      MLAB = 10 ALMs for each 20 bits of 32 words
//! DSP = ceil(18x18 / 2) + ceil(9x9 / 3) + 27x27
//! ```
//!
//! An ALM holds one 6-input ALUT or two smaller ones, two bits of a carry chain and four registers. Registers that Quartus packs
//! into the multipliers and memories are counted as registers here, so the estimate is high rather than low.

use std::{collections::BTreeMap, process::Command};

use serde::Serialize;

use crate::emit::{EmitError, files};

/// What an Arria V offers.
#[derive(Debug, Clone, Serialize)]
pub struct Device {
    /// Name.
    pub name: String,
    /// Adaptive logic modules.
    pub alm: u64,
    /// Block memories of 10 Kbit.
    pub m10k: u64,
    /// DSP blocks.
    pub dsp: u64,
    /// The top takes at most two thirds of each.
    pub fits: bool,
}

/// A Yosys estimate.
#[derive(Debug, Clone, Serialize)]
pub struct Estimate {
    /// Adaptive logic modules.
    pub alm: u64,
    /// Block memories of 10 Kbit.
    pub m10k: u64,
    /// DSP blocks.
    pub dsp: u64,
    /// Multipliers 18 x 18.
    pub mul18: u64,
    /// Registers.
    pub registers: u64,
    /// Cells as Yosys counts them.
    pub cells: BTreeMap<String, u64>,
    /// The device it is for, the smallest of the family.
    pub device: String,
    /// It fits that one with a third of everything free.
    pub fits: bool,
    /// The same for it and the next larger ones.
    pub devices: Vec<Device>,
}

/// Why there is no estimate.
#[derive(Debug, thiserror::Error)]
pub enum EstimateError {
    /// There is no Verilog.
    #[error(transparent)]
    Emit(#[from] EmitError),
    /// Yosys is not there, or does not run.
    #[error("yosys does not run: {0}; `hoverlock doctor` says how to get it")]
    Missing(std::io::Error),
    /// Yosys does not like something.
    #[error("yosys fails: {0}")]
    Failed(String),
    /// A memory or a multiplier was made of something else, so the counts mean nothing.
    #[error("the estimate is not of the design: {0}")]
    Implausible(String),
}

/// Name, ALM, M10K blocks, DSP blocks. A1 as believed (no vendor table at hand); A3 to B3 after Intel 683440.
const DEVICES: [(&str, u64, u64, u64); 4] = [
    ("5AGXA1", 28_302, 800, 240),
    ("5AGXA3", 58_900, 1051, 396),
    ("5AGXA7", 91_680, 1366, 800),
    ("5AGXB3", 136_880, 1726, 1045),
];

/// Runs Yosys on the Verilog the sources give now.
///
/// # Errors
/// Where Yosys is missing or fails.
pub fn estimate() -> Result<Estimate, EstimateError> {
    let folder = std::env::temp_dir().join(format!("hoverlock-estimate-{}", std::process::id()));
    let result = synthesise(&folder);
    let _ = std::fs::remove_dir_all(&folder);
    result
}

fn synthesise(folder: &std::path::Path) -> Result<Estimate, EstimateError> {
    std::fs::create_dir_all(folder).map_err(EstimateError::Missing)?;
    let mut script = String::new();
    for file in files()?.iter().filter(|file| file.path.ends_with(".v")) {
        let name = file.path.trim_start_matches("verilog/");
        std::fs::write(folder.join(name), &file.text).map_err(EstimateError::Missing)?;
        script += &format!("read_verilog {name}\n");
    }
    script += "synth_intel_alm -family arriav -top hoverlock_top\ntee -o stat.txt stat\n";
    std::fs::write(folder.join("run.ys"), script).map_err(EstimateError::Missing)?;
    let output =
        Command::new("yosys").current_dir(folder).args(["-q", "run.ys"]).output().map_err(EstimateError::Missing)?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr);
        return Err(EstimateError::Failed(text.lines().last().unwrap_or("no reason given").into()));
    }
    let stat = std::fs::read_to_string(folder.join("stat.txt")).map_err(EstimateError::Missing)?;
    derive(&stat)
}

fn derive(stat: &str) -> Result<Estimate, EstimateError> {
    let cells: BTreeMap<String, u64> = stat
        .lines()
        .filter_map(|line| {
            let (name, count) = line.trim().split_once(' ')?;
            Some((name.strip_prefix("MISTRAL_")?.to_owned(), count.trim().parse().ok()?))
        })
        .collect();
    let count = |name: &str| cells.get(name).copied().unwrap_or_default();
    let (m10k, mul18) = (count("M10K"), count("MUL18X18"));
    if m10k == 0 || mul18 == 0 {
        return Err(EstimateError::Implausible(format!("{m10k} memories and {mul18} multipliers were found")));
    }
    let small: u64 = ["NOT", "ALUT2", "ALUT3", "ALUT4", "ALUT5", "ALUT_ARITH"].into_iter().map(count).sum();
    let registers = count("FF");
    let alm = (count("ALUT6") + small.div_ceil(2)).max(registers.div_ceil(4)) + 10 * count("MLAB").div_ceil(20);
    let dsp = mul18.div_ceil(2) + count("MUL9X9").div_ceil(3) + count("MUL27X27");
    let fits = |(_, alms, memories, blocks): &(&str, u64, u64, u64)| {
        3 * alm <= 2 * alms && 3 * m10k <= 2 * memories && 3 * dsp <= 2 * blocks
    };
    let devices: Vec<Device> = DEVICES
        .iter()
        .map(|device| Device {
            name: device.0.into(),
            alm: device.1,
            m10k: device.2,
            dsp: device.3,
            fits: fits(device),
        })
        .collect();
    Ok(Estimate {
        alm,
        m10k,
        dsp,
        mul18,
        registers,
        cells,
        device: devices[0].name.clone(),
        fits: devices[0].fits,
        devices,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_become_resources() {
        let stat = "     MISTRAL_ALUT2   3\n     MISTRAL_ALUT6   4\n     MISTRAL_ALUT_ARITH 10\n     MISTRAL_FF  100\n     \
                    MISTRAL_M10K 7\n     MISTRAL_MLAB 21\n     MISTRAL_MUL18X18 51\n";
        let estimate = derive(stat).unwrap();
        // 13 small ALUTs fill 7 ALMs beside 4 large ones; 100 registers fill 25; 21 bits of MLAB take two of 10 ALMs.
        assert_eq!((estimate.alm, estimate.m10k, estimate.dsp, estimate.mul18), (25 + 20, 7, 26, 51));
        assert!(estimate.fits);
        assert!(derive("     MISTRAL_FF  100\n").is_err());
    }
}
