//! Observed ranges as table rows: one row for each node, or one for all stages of a smoother.

use hoverlock_fixed_point::analysis::range::{Fit, Node, Observed, Ranges};
use serde::Serialize;

/// The range of one node, or of several nodes of one format.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RangeRow {
    /// Name of the node or nodes.
    pub node: String,
    /// The format, as text.
    pub format: String,
    /// LSB of the format, DN.
    pub lsb_dn: f64,
    /// Number of values observed.
    pub values: u64,
    /// Smallest value, DN.
    pub min: f64,
    /// Largest value, DN.
    pub max: f64,
    /// Leading magnitude bits that no value used.
    pub unused_bits: i32,
    /// Values that round to a value outside the format.
    pub overflow: u64,
    /// Nonzero values that round to zero.
    pub underflow: u64,
    /// Samples that saturated in `bit_true`.
    pub saturated: u64,
    /// The narrowest format with the same LSB that represents all values observed.
    pub proposal: String,
    /// Exponent, count, and `in range`, `overflow` or `underflow`.
    pub histogram: Vec<(i32, u64, &'static str)>,
}

impl RangeRow {
    /// Combines several nodes of one format under one name; `None` for an empty list.
    fn of(name: String, nodes: &[&Observed]) -> Option<Self> {
        let widest = nodes.iter().max_by_key(|node| node.used_bits())?;
        let sum = |count: fn(&Observed) -> u64| nodes.iter().map(|node| count(node)).sum();
        let ranges = || nodes.iter().filter_map(|node| node.range);
        let mut histogram: Vec<(i32, u64, &'static str)> = Vec::new();
        for (exponent, _) in widest.histogram() {
            let count = nodes.iter().flat_map(|n| n.histogram()).filter(|(e, _)| *e == exponent).map(|(_, c)| c).sum();
            let fit = match widest.fit(exponent) {
                Fit::InRange => "in range",
                Fit::Overflow => "overflow",
                Fit::Underflow => "underflow",
            };
            if count > 0 {
                histogram.push((exponent, count, fit));
            }
        }
        Some(Self {
            node: name,
            format: widest.format.to_string(),
            lsb_dn: widest.format.lsb(),
            values: sum(|node| node.values),
            min: ranges().map(|range| range.0).fold(f64::INFINITY, f64::min),
            max: ranges().map(|range| range.1).fold(f64::NEG_INFINITY, f64::max),
            unused_bits: widest.unused_bits(),
            overflow: sum(|node| node.overflows),
            underflow: sum(|node| node.underflows),
            saturated: sum(|node| node.saturated),
            proposal: widest.proposal().unwrap_or(widest.format).to_string(),
            histogram,
        })
    }

    /// Returns one row for each node.
    pub fn each(ranges: &Ranges) -> Vec<Self> {
        ranges.nodes().iter().filter_map(|node| Self::of(node.node.to_string(), &[node])).collect()
    }

    /// Returns one row for all stages of a smoother, and one for each other node.
    pub fn grouped(ranges: &Ranges, sigmas: &[f64]) -> Vec<Self> {
        let name = |node: Node| match node {
            Node::Stage(smoother, _) => {
                let sigma = sigmas.get(smoother).copied().unwrap_or_default();
                format!("state, σ {sigma}, all stages")
            }
            Node::Pixel => "pixel".into(),
            Node::Difference(k) => format!("signed DoG {k}, before rounding"),
            Node::Dog(k) => format!("DoG {k}"),
            Node::MaxDog(k) => format!("MaxDOG {k}"),
        };
        let mut groups: Vec<(String, Vec<&Observed>)> = Vec::new();
        for node in ranges.nodes() {
            let name = name(node.node);
            match groups.last_mut().filter(|(of, _)| *of == name) {
                Some((_, nodes)) => nodes.push(node),
                None => groups.push((name, vec![node])),
            }
        }
        groups.into_iter().filter_map(|(name, nodes)| Self::of(name, &nodes)).collect()
    }
}
