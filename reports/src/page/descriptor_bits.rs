//! The plots of flipped descriptor bits.

use hoverlock_fixed_point::analysis::errors::{Flips, MarginBin};

use crate::colour::Rgb;
use crate::plot::{Axis, BLUE, Chart, GREEN, GREY, Mark, ORANGE, PlotError, RED, Series, VIOLET};
use crate::study::Study;

/// Plots the flips of each bit, flips against margin, and the number of bits with each margin; all pictures and
/// conditions.
pub(super) fn plots(study: &Study) -> Result<Vec<String>, PlotError> {
    let pairs = study.flips.first().map_or(0, |(_, flips)| flips.per_bit.len() / 64);
    let mut all = Flips::of_pairs(pairs);
    study.flips.iter().for_each(|(_, flips)| all.add(flips));
    let percent = |flipped: u64, of: u64| 100.0 * flipped as f64 / of.max(1) as f64;
    let groups = [("MaxLBP", [BLUE, VIOLET, GREY]), ("sign", [ORANGE, GREEN, RED])];
    let groups: Vec<(String, Rgb)> = groups
        .iter()
        .flat_map(|(kind, colours)| (0..pairs).map(move |k| (format!("{kind}, scale {k}"), colours[k])))
        .collect();
    let series = groups.iter().enumerate().map(|(group, (name, colour))| Series {
        name: name.clone(),
        colour: *colour,
        mark: Mark::Bars(0.8),
        points: (32 * group..32 * (group + 1))
            .map(|bit| (bit as f64, percent(all.per_bit[bit], all.features)))
            .collect(),
    });
    let top = all.per_bit.iter().map(|&flipped| percent(flipped, all.features)).fold(0.01, f64::max);
    let bits = all.per_bit.len();
    let ticks = (0..=bits).step_by(16).map(|bit| (bit as f64 - 0.5, bit.to_string())).collect();
    let per_bit = Chart {
        title: String::new(),
        size: (1040, 250),
        x: Axis::ticked("descriptor bit", -1.0, bits as f64, ticks),
        y: Axis::linear("flipped, %", 0.0, 1.25 * top),
        series: series.collect(),
        rules: Vec::new(),
    };
    let edges: Vec<(f64, String)> = (0..Flips::MARGIN_BINS)
        .map(|bin| (bin as f64, if bin == 0 { "<½".into() } else { format_octave(bin) }))
        .collect();
    let kinds = [("MaxLBP", BLUE, &all.maxlbp_margin), ("sign", ORANGE, &all.sign_margin)];
    let rate = kinds.map(|(name, colour, bins)| Series {
        name: name.into(),
        colour,
        mark: Mark::LineDots,
        points: bins
            .iter()
            .enumerate()
            .filter(|(_, bin)| bin.flipped > 0)
            .map(|(bin_index, bin)| (bin_index as f64, percent(bin.flipped, bin.bits)))
            .collect(),
    });
    let x = || Axis::ticked("margin in streaming, LSB", -0.5, Flips::MARGIN_BINS as f64 - 0.5, edges.clone());
    let against_margin = Chart {
        title: "bits flipped, by margin".into(),
        size: (520, 280),
        x: x(),
        y: Axis::log("flipped, % of the bits at this margin", 1e-3, 100.0),
        series: rate.into(),
        rules: Vec::new(),
    };
    let total = |bins: &[MarginBin]| bins.iter().map(|bin| bin.bits).sum::<u64>();
    let share = kinds.map(|(name, colour, bins)| Series {
        name: name.into(),
        colour,
        mark: Mark::LineDots,
        points: bins
            .iter()
            .enumerate()
            .map(|(bin_index, bin)| (bin_index as f64, percent(bin.bits, total(bins))))
            .collect(),
    });
    let population = Chart {
        title: "bits at each margin".into(),
        size: (520, 280),
        x: x(),
        y: Axis::log("% of all bits", 1e-3, 100.0),
        series: share.into(),
        rules: Vec::new(),
    };
    [per_bit, against_margin, population].iter().map(Chart::svg).collect()
}

/// Returns the lower edge of a margin bin as text, LSB.
fn format_octave(bin: usize) -> String {
    match bin {
        1 => "½".into(),
        _ => {
            let edge = 1u64 << (bin - 2);
            if edge >= 1024 { format!("{}k", edge / 1024) } else { edge.to_string() }
        }
    }
}
