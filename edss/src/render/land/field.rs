//! Parcels of a farmed landscape: a square is split recursively, some splits are tracks, each part has a crop.

use nalgebra::Vector2;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::Material;
use crate::render::noise::{gradient, octaves};

/// Half of the side of the square that is split, m: it contains the rotated map.
const HALF_EXTENT_M: f32 = 150.0;
/// Half of the width of a track, m.
const TRACK_HALF_WIDTH_M: f32 = 1.7;

/// A farmed landscape as a tree of splits.
pub struct Landscape {
    cos: f32,
    sin: f32,
    seed: u32,
    root: Node,
}

enum Node {
    Split { along: usize, at: f32, track: bool, parts: Box<[Node; 2]> },
    Parcel(Parcel),
}

struct Parcel {
    low: [f32; 2],
    high: [f32; 2],
    crop: Crop,
    /// Axis along which the rows run.
    rows: usize,
    seed: u32,
}

/// The appearance of a crop.
#[derive(Clone, Copy)]
struct Crop {
    albedo: f32,
    /// Spacing of rows, m, and their contrast; 0 for none.
    row: [f32; 2],
    /// Spacing of tramlines or swaths, m, and their contrast.
    line: [f32; 2],
    blotch: f32,
    green: f32,
    soil: f32,
}

const CROPS: [Crop; 6] = [
    // Ploughed, ripe grain, maize, pasture, stubble, young crop.
    Crop { albedo: 0.24, row: [0.9, 0.16], line: [9.0, 0.10], blotch: 0.35, green: 0.02, soil: 0.17 },
    Crop { albedo: 0.58, row: [0.5, 0.05], line: [15.0, 0.35], blotch: 0.22, green: 0.11, soil: 0.02 },
    Crop { albedo: 0.33, row: [0.75, 0.22], line: [18.0, 0.20], blotch: 0.30, green: 0.17, soil: 0.05 },
    Crop { albedo: 0.38, row: [0.5, 0.0], line: [15.0, 0.0], blotch: 0.45, green: 0.20, soil: 0.02 },
    Crop { albedo: 0.52, row: [1.5, 0.08], line: [6.0, 0.12], blotch: 0.25, green: 0.06, soil: 0.12 },
    Crop { albedo: 0.42, row: [0.6, 0.14], line: [15.0, 0.30], blotch: 0.35, green: 0.10, soil: 0.10 },
];

const TRACK_SOIL: Material = Material { albedo: 0.62, grain: [0.01, 0.14, 0.05] };
const VERGE: Material = Material { albedo: 0.28, grain: [0.24, 0.04, 0.0] };

impl Landscape {
    /// Generates parcels of about `parcel` m.
    pub fn new(parcel: f32, random: &mut ChaCha8Rng) -> Self {
        let (sin, cos) = libm::sincosf(random.random_range(0.15..0.6f32));
        let mut last = 0;
        let root = split([-HALF_EXTENT_M; 2], [HALF_EXTENT_M; 2], parcel, 0, &mut last, random);
        Self { cos, sin, seed: random.random(), root }
    }

    fn turned(&self, p: Vector2<f32>) -> [f32; 2] {
        // Edges of fields follow the land: a slow wobble of a few metres.
        let wobble = |k: u32| 9.0 * gradient(p.x / 70.0, p.y / 70.0, 0, self.seed + k);
        [self.cos * p.x + self.sin * p.y + wobble(0), self.cos * p.y - self.sin * p.x + wobble(1)]
    }

    /// Returns the material at a point, m.
    pub fn at(&self, p: Vector2<f32>) -> Material {
        let q = self.turned(p);
        let ragged =
            0.5 * gradient(p.x / 0.7, p.y / 0.7, 0, self.seed + 2) + gradient(p.x / 5.0, p.y / 5.0, 0, self.seed + 3);
        let mut node = &self.root;
        loop {
            match node {
                Node::Split { along, at, track, parts } => {
                    let offset = q[*along] - at;
                    if *track && offset.abs() < TRACK_HALF_WIDTH_M + 1.3 {
                        return track_at(offset, q[1 - *along], ragged, self.seed);
                    }
                    node = &parts[usize::from(offset > 0.0)];
                }
                Node::Parcel(parcel) => return parcel.at(q, p, ragged),
            }
        }
    }

    /// Draws points for `count` trees along the edges of parcels, not on tracks, m.
    pub fn edges(&self, random: &mut ChaCha8Rng, count: usize) -> Vec<Vector2<f64>> {
        let mut parcels = Vec::new();
        self.root.parcels(&mut parcels);
        // One parcel in two has trees, so that they stand in rows and groups.
        let wooded: Vec<&Parcel> = parcels.into_iter().filter(|parcel| parcel.seed % 2 == 0).collect();
        if wooded.is_empty() {
            return Vec::new();
        }
        (0..count)
            .map(|_| {
                let parcel = wooded[random.random_range(0..wooded.len())];
                let axis = usize::from(random.random::<bool>());
                let mut q = [0f32; 2];
                q[axis] = random.random_range(parcel.low[axis]..parcel.high[axis]);
                q[1 - axis] = parcel.low[1 - axis] + 2.0;
                let turned = Vector2::new(self.cos * q[0] - self.sin * q[1], self.cos * q[1] + self.sin * q[0]);
                // The wobble, undone to first order.
                let back = self.turned(turned);
                let error = [q[0] - back[0], q[1] - back[1]];
                let moved =
                    Vector2::new(self.cos * error[0] - self.sin * error[1], self.cos * error[1] + self.sin * error[0]);
                (turned + moved).cast()
            })
            .collect()
    }
}

impl Node {
    fn parcels<'a>(&'a self, found: &mut Vec<&'a Parcel>) {
        match self {
            Node::Split { parts, .. } => parts.iter().for_each(|part| part.parcels(found)),
            Node::Parcel(parcel) => found.push(parcel),
        }
    }
}

fn split(low: [f32; 2], high: [f32; 2], parcel: f32, depth: u32, last: &mut usize, random: &mut ChaCha8Rng) -> Node {
    let size = [high[0] - low[0], high[1] - low[1]];
    let longer = usize::from(size[1] > size[0]);
    let enough = size[longer] < parcel * random.random_range(1.1..1.9f32);
    if enough || depth == 9 {
        // A crop other than that of the previous parcel, which is most often a neighbour.
        *last = (*last + random.random_range(1..CROPS.len())) % CROPS.len();
        return Node::Parcel(Parcel { low, high, crop: CROPS[*last], rows: longer, seed: random.random() });
    }
    let at = low[longer] + size[longer] * random.random_range(0.36..0.64f32);
    let track = (2..=4).contains(&depth) && random.random::<f32>() < 0.6;
    let gap = if track { TRACK_HALF_WIDTH_M + 1.3 } else { 0.0 };
    let (mut inner_high, mut inner_low) = (high, low);
    inner_high[longer] = at - gap;
    inner_low[longer] = at + gap;
    let first = split(low, inner_high, parcel, depth + 1, last, random);
    let second = split(inner_low, high, parcel, depth + 1, last, random);
    Node::Split { along: longer, at, track, parts: Box::new([first, second]) }
}

/// Returns the material of a track: two bare wheel marks with grass between and beside them.
fn track_at(offset: f32, along: f32, ragged: f32, seed: u32) -> Material {
    let wheel = (offset.abs() - 0.85).abs() - 0.45 + 0.25 * ragged;
    let bare = smooth(0.25, -0.15, wheel);
    let puddle = smooth(0.12, 0.2, gradient(along / 6.0, offset / 2.0, 0, seed + 9)) * bare;
    let mut material = VERGE.mix(TRACK_SOIL, bare);
    material.albedo *= 1.0 - 0.3 * puddle + 0.2 * ragged;
    material
}

impl Parcel {
    fn at(&self, q: [f32; 2], p: Vector2<f32>, ragged: f32) -> Material {
        let crop = &self.crop;
        let edge = |axis: usize| (q[axis] - self.low[axis]).min(self.high[axis] - q[axis]);
        let across = 1 - self.rows;
        let margin = edge(0).min(edge(1)) + 0.5 * ragged;
        if margin < 0.7 {
            let mut verge = VERGE;
            verge.albedo *= 1.0 + 0.5 * ragged;
            return verge;
        }
        // On the headland rows run along the edge.
        let headland = edge(self.rows) < 6.0;
        let (b, a) = if headland { (q[self.rows], q[across]) } else { (q[across], q[self.rows]) };
        let wobble = 0.25 * gradient(a / 9.0, b / 30.0, 0, self.seed);
        let patches = octaves(p.x / 22.0, p.y / 22.0, 0, self.seed + 1, 4, 0.7);
        let small = octaves(p.x / 2.0, p.y / 2.0, 0, self.seed + 6, 3, 0.8);
        let mut albedo = crop.albedo * (1.0 + crop.blotch * (patches + 0.6 * small));
        let gaps = 0.55 + 1.5 * gradient(a / 1.3, b / 0.8, 0, self.seed + 7);
        if crop.row[1] > 0.0 {
            let phase = (b + wobble) / crop.row[0];
            let wave = libm::sinf(std::f32::consts::TAU * (phase - phase.floor()));
            albedo *= 1.0 + crop.row[1] * wave * gaps.clamp(0.0, 1.3);
        }
        if crop.line[1] > 0.0 {
            let phase = (b + wobble) / crop.line[0];
            let from = ((phase - phase.floor()) - 0.5) * crop.line[0];
            let wheel = (from.abs() - 0.9).abs() - 0.2 + 0.2 * ragged;
            albedo *= 1.0 - crop.line[1] * smooth(0.12, -0.08, wheel);
        }
        let bare = smooth(0.3, 0.5, patches);
        let material = Material { albedo, grain: [crop.green, crop.soil, 0.0] };
        material.mix(Material { albedo: 0.9 * albedo + 0.05, grain: [0.3 * crop.green, crop.soil + 0.06, 0.0] }, bare)
    }
}

/// Returns 0 at `from`, 1 at `to` and a cubic between.
fn smooth(from: f32, to: f32, v: f32) -> f32 {
    let t = ((v - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
