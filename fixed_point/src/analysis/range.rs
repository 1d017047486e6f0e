//! Ranges observed at every node of the processing chain, against the formats of the nodes.
//!
//! Values are those of `streaming`, in DN, before any rounding. Against the node's format a value `v` is
//!
//! - *overflow* if it is outside `min .. max + LSB/2` (it rounds to a value outside the format),
//! - *underflow* where `0 < |v| < LSB/2`: it rounds to 0,
//! - *in range* otherwise.
//!
//! The histogram counts `floor(log2 |v|)`; zeros are counted separately. `unused` is the number of leading magnitude
//! bits that no value used: the bits of the format, less the sign bit, less the bits of the largest raw integer
//! observed. An observed range is no proof: the state reaches full scale as soon as a picture does.

use std::fmt;

use hoverlock_reference::image::plane::Plane;

use crate::analysis::levels::{Level, LevelPlanes, Levels};
use crate::model::design::rings;
use crate::model::stages::Stage;
use hoverlock_design::{DesignPoint, Format};

/// Lowest bin of the histogram: `2^-24 <= |v| < 2^-23` and all that is smaller.
const MIN_EXPONENT: i32 = -24;

/// Highest bin: `2^23 <= |v|`.
const MAX_EXPONENT: i32 = 23;

const BINS: usize = (MAX_EXPONENT - MIN_EXPONENT + 1) as usize;

/// A node of the processing chain whose value is stored in a format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Node {
    /// The camera sample.
    Pixel,
    /// The output of one stage of one smoother.
    Stage(usize, Stage),
    /// The signed difference `d_k`.
    Difference(usize),
    /// The magnitude `DOG_k`.
    Dog(usize),
    /// The windowed maximum `MaxDOG_k`.
    MaxDog(usize),
}

impl Node {
    /// Returns the nodes of a design, in the order of the chain.
    pub fn all(design: &DesignPoint) -> Vec<Node> {
        let mut nodes = vec![Node::Pixel];
        for (smoother, look_ahead) in design.look_ahead.iter().enumerate() {
            nodes.extend(Stage::chain(*look_ahead).map(|stage| Node::Stage(smoother, stage)));
        }
        nodes.extend((0..design.pairs()).map(Node::Difference));
        nodes.extend((0..design.pairs()).map(Node::Dog));
        nodes.extend((0..design.pairs()).map(Node::MaxDog));
        nodes
    }

    /// Returns the format of the node in DN; `d_k` has the bits of the state and a sign.
    pub fn format(self, design: &DesignPoint) -> Format {
        match self {
            Node::Pixel => design.pixel_dn(),
            Node::Stage(..) => design.state_dn(),
            Node::Difference(_) => design.state_dn().with_sign(),
            Node::Dog(_) | Node::MaxDog(_) => design.dog(),
        }
    }
}

impl fmt::Display for Node {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Node::Pixel => f.pad("pixel"),
            Node::Stage(smoother, stage) => f.pad(&format!("G{smoother} {stage}")),
            Node::Difference(k) => f.pad(&format!("d{k}")),
            Node::Dog(k) => f.pad(&format!("DOG{k}")),
            Node::MaxDog(k) => f.pad(&format!("MaxDOG{k}")),
        }
    }
}

/// Relation of a value, or of a bin of the histogram, to a format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Fit {
    /// Within the range, and not rounded to 0 unless it is 0.
    InRange,
    /// It rounds to a value outside the format.
    Overflow,
    /// It is not 0 and rounds to 0.
    Underflow,
}

/// The values observed at one node.
#[derive(Debug, Clone, PartialEq)]
pub struct Observed {
    /// The node of the chain that was observed.
    pub node: Node,
    /// The format of the node in DN.
    pub format: Format,
    /// Number of values.
    pub values: u64,
    /// Number of zeros.
    pub zeros: u64,
    /// Smallest and largest value, DN; `None` before the first value.
    pub range: Option<(f64, f64)>,
    /// Values outside the format's range.
    pub overflows: u64,
    /// Values that are not 0 and round to 0.
    pub underflows: u64,
    /// Samples that saturated in the integers of `bit_true`.
    pub saturated: u64,
    histogram: [u64; BINS],
}

impl Observed {
    /// Makes the counters of a node, without values.
    pub fn new(node: Node, design: &DesignPoint) -> Self {
        Self {
            node,
            format: node.format(design),
            values: 0,
            zeros: 0,
            range: None,
            overflows: 0,
            underflows: 0,
            saturated: 0,
            histogram: [0; BINS],
        }
    }

    /// Adds all samples of a plane, DN.
    pub fn see(&mut self, plane: &Plane<f64>) {
        let (half, min, max) = (self.format.lsb() / 2.0, self.lowest(), self.highest());
        let (mut low, mut high) = self.range.unwrap_or((f64::INFINITY, f64::NEG_INFINITY));
        for &value in plane.as_slice() {
            (low, high) = (low.min(value), high.max(value));
            self.overflows += u64::from(value <= min - half || value >= max + half);
            if value == 0.0 {
                self.zeros += 1;
            } else {
                self.underflows += u64::from(value.abs() < half);
                self.histogram[(exponent(value).clamp(MIN_EXPONENT, MAX_EXPONENT) - MIN_EXPONENT) as usize] += 1;
            }
        }
        self.values += plane.as_slice().len() as u64;
        self.range = Some((low, high));
    }

    /// Returns the pairs of exponent `e` and number of values in `2^e <= |v| < 2^(e+1)`, all bins in order.
    pub fn histogram(&self) -> impl Iterator<Item = (i32, u64)> {
        (MIN_EXPONENT..).zip(self.histogram)
    }

    /// Compares a bin with the format by its middle, `1.5 * 2^e`.
    pub fn fit(&self, exponent: i32) -> Fit {
        let middle = 1.5 * f64::from(exponent).exp2();
        match () {
            () if middle >= self.highest() + self.format.lsb() / 2.0 => Fit::Overflow,
            () if middle < self.format.lsb() / 2.0 => Fit::Underflow,
            () => Fit::InRange,
        }
    }

    /// Returns the number of magnitude bits that the largest value needs at this LSB; 0 if all values are 0.
    pub fn used_bits(&self) -> u32 {
        let largest = self.range.map_or(0.0, |(low, high)| high.max(-low));
        let raw = (largest / self.format.lsb()).round();
        if raw < 1.0 { 0 } else { exponent(raw) as u32 + 1 }
    }

    /// Returns the number of leading magnitude bits that no value used; negative if bits are missing.
    pub fn unused_bits(&self) -> i32 {
        self.format.bits() as i32 - i32::from(self.format.is_signed()) - self.used_bits() as i32
    }

    /// Returns the narrowest format with this LSB that represents all values observed, or `None` if it needs more than
    /// 32 bits.
    pub fn proposal(&self) -> Option<Format> {
        let integer_bits = self.used_bits().max(1) as i32 - i32::from(self.format.fraction_bits());
        let sign = if self.format.is_signed() { 's' } else { 'u' };
        format!("{sign}{integer_bits}.{}", self.format.fraction_bits()).parse().ok()
    }

    fn lowest(&self) -> f64 {
        self.format.value(self.format.min_raw())
    }

    fn highest(&self) -> f64 {
        self.format.value(self.format.max_raw())
    }

    fn merge(&mut self, other: &Self) {
        self.values += other.values;
        self.zeros += other.zeros;
        self.overflows += other.overflows;
        self.underflows += other.underflows;
        self.saturated += other.saturated;
        self.range = match (self.range, other.range) {
            (Some((a, b)), Some((c, d))) => Some((a.min(c), b.max(d))),
            (own, other) => own.or(other),
        };
        self.histogram.iter_mut().zip(other.histogram).for_each(|(mine, others)| *mine += others);
    }
}

/// Returns `floor(log2 |value|)` of a finite value other than 0.
fn exponent(value: f64) -> i32 {
    // A subnormal number has exponent bits of 0 and falls into the lowest bin.
    ((value.to_bits() >> 52) & 0x7ff) as i32 - 1023
}

/// The values observed at all nodes of one design point.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranges {
    nodes: Vec<Observed>,
}

impl Ranges {
    /// Makes the counters of all nodes of a design, without values.
    pub fn new(design: &DesignPoint) -> Self {
        Self { nodes: Node::all(design).into_iter().map(|node| Observed::new(node, design)).collect() }
    }

    /// Returns the counters of all nodes, in the order of the chain.
    pub fn nodes(&self) -> &[Observed] {
        &self.nodes
    }

    /// Adds a frame: values from `streaming`, saturated samples from `bit_true`.
    pub fn see(&mut self, levels: &Levels, pixels: &Plane<u16>) {
        self.node(Node::Pixel).see(&levels.dn(pixels));
        let smooth = |smoother| {
            levels.stages(Level::Streaming, smoother, pixels, |stage, plane| {
                self.node(Node::Stage(smoother, stage)).see(plane);
            })
        };
        let smoothed = (0..levels.design().smoothers()).map(smooth).collect();
        let LevelPlanes { signed_dog, dog, max_dog, .. } = LevelPlanes::of(smoothed, rings(levels.design()));
        let saturated = levels.bit_true_planes(pixels).saturated;
        for k in 0..dog.len() {
            self.node(Node::Difference(k)).see(&signed_dog[k]);
            self.node(Node::Dog(k)).see(&dog[k]);
            self.node(Node::Dog(k)).saturated += saturated[k];
            self.node(Node::MaxDog(k)).see(&max_dog[k]);
        }
    }

    /// Adds the values observed by another instance for the same design point.
    ///
    /// # Panics
    /// The nodes differ.
    pub fn merge(&mut self, other: &Self) {
        assert!(self.nodes.iter().map(|n| (n.node, n.format)).eq(other.nodes.iter().map(|n| (n.node, n.format))));
        self.nodes.iter_mut().zip(&other.nodes).for_each(|(mine, others)| mine.merge(others));
    }

    fn node(&mut self, node: Node) -> &mut Observed {
        self.nodes.iter_mut().find(|observed| observed.node == node).expect("every node of the design point is there")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pictures::{Content, Picture};
    use hoverlock_design::KT27;

    fn seen(node: Node, design: &DesignPoint, values: &[f64]) -> Observed {
        let mut observed = Observed::new(node, design);
        observed.see(&Plane::from_vec(values.len(), 1, values.to_vec()).unwrap());
        observed
    }

    #[test]
    fn counters_agree_with_the_format() {
        // DOG: 15 bits, LSB 0.5, up to 16383.5 DN.
        let observed = seen(Node::Dog(0), &KT27, &[0.0, 0.2, 0.25, 1.0, 5.9, 16383.7, 16383.75, 20000.0]);
        assert_eq!((observed.values, observed.zeros), (8, 1));
        assert_eq!((observed.underflows, observed.overflows), (1, 2));
        assert_eq!(observed.range, Some((0.0, 20000.0)));
        let bins: Vec<_> = observed.histogram().filter(|(_, count)| *count > 0).collect();
        assert_eq!(bins, [(-3, 1), (-2, 1), (0, 1), (2, 1), (13, 2), (14, 1)]);
        // 20000 DN are 40000 LSB: 16 bits, one more than there are.
        assert_eq!((observed.used_bits(), observed.unused_bits()), (16, -1));
        assert_eq!(observed.proposal().unwrap().to_string(), "u15.1");
        assert_eq!([-4, -3, -2, 13, 14].map(|e| observed.fit(e)), {
            use Fit::{InRange, Overflow, Underflow};
            [Underflow, Underflow, InRange, InRange, Overflow]
        });
    }

    #[test]
    fn small_values_leave_bits_unused() {
        let observed = seen(Node::Dog(1), &KT27, &[0.0, 3.0, 100.0]);
        // 200 LSB are 8 bits of 15.
        assert_eq!((observed.used_bits(), observed.unused_bits()), (8, 7));
        assert_eq!(observed.proposal().unwrap().to_string(), "u7.1");
        let signed = seen(Node::Difference(1), &KT27, &[-100.0, 3.0]);
        // 400 LSB are 9 bits of 18, the sign bit not counted.
        assert_eq!((signed.format.to_string().as_str(), signed.used_bits(), signed.unused_bits()), ("s16.2", 9, 9));
        assert_eq!(signed.proposal().unwrap().to_string(), "s7.2");
        let nothing = seen(Node::Dog(0), &KT27, &[0.0, 0.0]);
        assert_eq!((nothing.used_bits(), nothing.unused_bits()), (0, 15));
        // A coarse DoG has a negative number of fraction bits.
        let coarse = KT27.with_override("dog_bits=12").unwrap();
        assert_eq!(seen(Node::Dog(0), &coarse, &[1000.0]).proposal().unwrap().to_string(), "u10.-2");
    }

    #[test]
    fn every_node_is_observed_and_frames_add_up() {
        let levels = Levels::new(&KT27).unwrap();
        let draw = |content| Picture { width: 50, height: 40, seed: 3, content }.draw();
        let frames = [
            draw(Content::Noise { low: 1000, high: 40000 }),
            draw(Content::Edge { dx: 1, dy: 2, at: 60, values: [0, 65535] }),
        ];
        let mut both = Ranges::new(&KT27);
        // The camera sample, 51 stages, and three nodes of each of two pairs.
        assert_eq!(both.nodes().len(), 1 + 51 + 6);
        frames.iter().for_each(|frame| both.see(&levels, frame));
        for observed in both.nodes() {
            assert_eq!(observed.values, 2 * 50 * 40, "{}", observed.node);
            assert_eq!((observed.overflows, observed.saturated), (0, 0), "{}", observed.node);
            assert_eq!(observed.zeros + observed.histogram().map(|(_, n)| n).sum::<u64>(), observed.values);
            assert!(observed.unused_bits() >= 0, "{}", observed.node);
        }
        let planes = levels.planes(Level::Streaming, &frames[1]);
        let largest = planes.dog[1].as_slice().iter().copied().fold(0.0, f64::max);
        let dog = both.nodes().iter().find(|observed| observed.node == Node::Dog(1)).unwrap();
        assert_eq!(dog.range.unwrap().1, largest);

        let mut merged = Ranges::new(&KT27);
        for frame in &frames {
            let mut one = Ranges::new(&KT27);
            one.see(&levels, frame);
            merged.merge(&one);
        }
        assert_eq!(merged, both);
    }
}
