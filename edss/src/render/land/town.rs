//! Streets and blocks: a rotated grid of uneven spacing. Each block has houses with gardens, a park, or a yard.

use nalgebra::Vector2;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::Material;
use crate::render::noise::{gradient, octaves, unit};
use crate::render::object::Object;
use crate::scene::{Building, Car, Roof, Town as Keys, Tree};

/// Half of the side of the square with streets, m.
const STREETS_HALF_EXTENT_M: f32 = 150.0;
/// Half of the side of the square with houses, cars and paint, m: a little more than the map.
const BUILT_HALF_EXTENT_M: f64 = 112.0;
/// Width of a pavement, m.
const PAVEMENT_WIDTH_M: f32 = 2.2;
/// Distance from the pavement to the middle of a house, m.
const HOUSE_SETBACK_M: f32 = 11.0;

/// A town, from which the map and the objects are generated.
pub struct Town {
    cos: f32,
    sin: f32,
    seed: u32,
    /// Streets across the first and the second axis, in order of position.
    streets: [Vec<Street>; 2],
}

#[derive(Debug, Clone, Copy)]
struct Street {
    at: f32,
    /// Half of the width of its road.
    half: f32,
}

/// A block without its pavements.
struct Block {
    low: [f32; 2],
    high: [f32; 2],
    seed: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LandUse {
    Houses,
    Park,
    Yard,
}

const LAWN: Material = Material { albedo: 0.34, grain: [0.19, 0.02, 0.0] };
const HEDGE: Material = Material { albedo: 0.15, grain: [0.26, 0.0, 0.0] };
const BED: Material = Material { albedo: 0.25, grain: [0.08, 0.17, 0.0] };
const ROAD: Material = Material { albedo: 0.21, grain: [0.0, 0.01, 0.11] };
const SLABS: Material = Material { albedo: 0.50, grain: [0.0, 0.02, 0.08] };

impl Town {
    /// Generates streets about `block` m apart.
    pub fn new(block: f32, random: &mut ChaCha8Rng) -> Self {
        let (sin, cos) = libm::sincosf(random.random_range(0.2..0.5f32));
        let mut streets = [0.7, 1.15f32].map(|scale| {
            let mut at = -STREETS_HALF_EXTENT_M - block * random.random::<f32>();
            let mut line = Vec::new();
            while at < STREETS_HALF_EXTENT_M + block {
                let half = if line.len() % 3 == 1 { 4.4 } else { 3.1 };
                line.push(Street { at, half });
                at += block * scale * random.random_range(0.85..1.2f32);
            }
            line
        });
        // A street passes near the middle, so that cars are seen from above it.
        let nearest = streets[0].iter().map(|street| street.at).min_by(|a, b| a.abs().total_cmp(&b.abs()));
        let shift = nearest.unwrap_or(0.0) + 9.0;
        streets[0].iter_mut().for_each(|street| street.at -= shift);
        Self { cos, sin, seed: random.random(), streets }
    }

    fn turned(&self, p: Vector2<f32>) -> [f32; 2] {
        [self.cos * p.x + self.sin * p.y, self.cos * p.y - self.sin * p.x]
    }

    fn world(&self, q: [f32; 2]) -> Vector2<f64> {
        Vector2::new(self.cos * q[0] - self.sin * q[1], self.cos * q[1] + self.sin * q[0]).cast()
    }

    /// Returns the index of the last street at or before a coordinate on an axis.
    fn between(&self, axis: usize, v: f32) -> usize {
        let line = &self.streets[axis];
        line.partition_point(|street| street.at <= v).clamp(1, line.len() - 1) - 1
    }

    fn block(&self, i: usize, j: usize) -> Block {
        let pair = |axis: usize, k: usize| (self.streets[axis][k], self.streets[axis][k + 1]);
        let ((a, b), (c, d)) = (pair(0, i), pair(1, j));
        let low = [a.at + a.half + PAVEMENT_WIDTH_M, c.at + c.half + PAVEMENT_WIDTH_M];
        let high = [b.at - b.half - PAVEMENT_WIDTH_M, d.at - d.half - PAVEMENT_WIDTH_M];
        Block { low, high, seed: self.seed.wrapping_add((i * 64 + j) as u32 * 7919) }
    }

    /// Returns the material at a point, m.
    pub fn at(&self, p: Vector2<f32>) -> Material {
        let q = self.turned(p);
        let places = [self.between(0, q[0]), self.between(1, q[1])];
        // Distance from the edge of the nearest road of each axis, and from its middle.
        let road = |axis: usize| {
            let (a, b) = (self.streets[axis][places[axis]], self.streets[axis][places[axis] + 1]);
            let (before, after) = (q[axis] - a.at, b.at - q[axis]);
            if before - a.half < after - b.half { (before - a.half, before) } else { (after - b.half, after) }
        };
        let (roads, dirt) = ([road(0), road(1)], octaves(p.x / 6.0, p.y / 6.0, 0, self.seed + 1, 5, 0.75));
        let edge = roads[0].0.min(roads[1].0);
        let mut material = if edge < 0.0 {
            let middle = if roads[0].0 < roads[1].0 { roads[0].1 } else { roads[1].1 };
            let mut road = ROAD;
            // Tyres polish two tracks a lane; patches where it was mended.
            let track = ((middle.abs() - 1.7).abs() - 0.75).abs();
            road.albedo *= 1.0 + 0.10 * (1.0 - track / 0.5).max(0.0) + 0.3 * dirt;
            let patch = unit((p.x / 5.0).floor() as i32 as u32, (p.y / 4.0).floor() as i32 as u32, self.seed + 5);
            if patch < 0.06 {
                road.albedo *= 0.78;
            }
            road
        } else if edge < 0.16 {
            Material { albedo: 0.62, grain: [0.0, 0.0, 0.06] }
        } else if edge < PAVEMENT_WIDTH_M {
            let mut slabs = SLABS;
            let joint = [q[0], q[1]].map(|v| (v / 1.5 - (v / 1.5).floor() - 0.5).abs());
            slabs.albedo *= 1.0 + 0.3 * dirt - if joint[0].max(joint[1]) > 0.46 { 0.18 } else { 0.0 };
            slabs
        } else {
            self.block(places[0], places[1]).at(q, p, dirt)
        };
        material.albedo = material.albedo.clamp(0.03, 0.95);
        material
    }

    /// Generates the objects: houses, trees, cars and the paint on the roads.
    pub fn objects(&self, keys: &Keys, random: &mut ChaCha8Rng) -> Vec<Object> {
        let mut objects = self.paint();
        let mut gardens = Vec::new();
        for i in 0..self.streets[0].len() - 1 {
            for j in 0..self.streets[1].len() - 1 {
                let block = self.block(i, j);
                let middle = [0, 1].map(|axis| 0.5 * (block.low[axis] + block.high[axis]));
                if self.world(middle).amax() < BUILT_HALF_EXTENT_M {
                    self.build(&block, &mut objects, &mut gardens);
                }
            }
        }
        for _ in 0..if gardens.is_empty() { 0 } else { keys.trees } {
            let at = gardens[random.random_range(0..gardens.len())];
            let shift = Vector2::new(random.random_range(-3.0..3.0f64), random.random_range(-3.0..3.0f64));
            let radius_m = random.random_range(1.0..3.2);
            let height_m = radius_m * random.random_range(2.0..3.0);
            let tree = Tree { at_m: [at.x + shift.x, at.y + shift.y], radius_m, height_m };
            objects.push(Object::tree(&tree, random.random()));
        }
        for _ in 0..keys.moving_cars {
            let (from, to) = self.random_lane(1.6, random);
            let speed_m_per_s = random.random_range(6.0..13.0);
            let car = Car { from_m: [from.x, from.y], to_m: [to.x, to.y], speed_m_per_s };
            objects.push(Object::car(&car, random.random_range(0.0..(to - from).norm())));
        }
        for _ in 0..keys.parked_cars {
            let (from, to) = self.random_lane(0.0, random);
            let car = Car { from_m: [from.x, from.y], to_m: [to.x, to.y], speed_m_per_s: 0.0 };
            objects.push(Object::car(&car, random.random_range(0.0..(to - from).norm())));
        }
        objects
    }

    /// Draws a line along a random street, `lane` m to the right of its middle, or at the kerb for 0.
    fn random_lane(&self, lane: f32, random: &mut ChaCha8Rng) -> (Vector2<f64>, Vector2<f64>) {
        let axis = usize::from(random.random::<bool>());
        let within: Vec<&Street> =
            self.streets[axis].iter().filter(|s| s.at.abs() < BUILT_HALF_EXTENT_M as f32).collect();
        let street = within[random.random_range(0..within.len())];
        let side = if random.random::<bool>() { 1.0 } else { -1.0f32 };
        let offset = if lane > 0.0 { lane } else { street.half - 1.05 };
        let end = |along: f32| {
            let mut q = [0.0; 2];
            q[axis] = street.at + side * offset;
            q[1 - axis] = along;
            self.world(q)
        };
        // Driving on the right, with the second axis to the right of the first.
        let forward = if axis == 1 { side } else { -side } * BUILT_HALF_EXTENT_M as f32;
        (end(-forward), end(forward))
    }

    fn build(&self, block: &Block, objects: &mut Vec<Object>, gardens: &mut Vec<Vector2<f64>>) {
        let yaw_deg = f64::from(self.sin.atan2(self.cos)).to_degrees();
        let size = [0, 1].map(|axis| block.high[axis] - block.low[axis]);
        let at = |s: f32, t: f32| self.world([block.low[0] + s, block.low[1] + t]);
        match block.kind() {
            LandUse::Houses => {
                let lots = block.lots();
                let width = size[0] / lots as f32;
                for lot in 0..2 * lots {
                    let (side, k) = (lot % 2, lot / 2);
                    let middle = (k as f32 + 0.5) * width;
                    let draw = |n: u32| unit(lot, n, block.seed);
                    let depth = |t: f32| if side == 0 { t } else { size[1] - t };
                    let house = at(middle + 1.2, depth(HOUSE_SETBACK_M + draw(1)));
                    let size_m = [9.0 + 3.0 * draw(2), 8.0 + 2.0 * draw(3)].map(f64::from);
                    let turned = draw(4) < 0.35;
                    let building = Building {
                        at_m: [house.x, house.y],
                        size_m: if turned { [size_m[1] + 1.0, size_m[0] - 1.0] } else { size_m },
                        height_m: f64::from(5.5 + 3.0 * draw(5)),
                        yaw_deg: yaw_deg + if turned { 90.0 } else { 0.0 },
                        roof: if draw(6) < 0.85 { Roof::Gable } else { Roof::Flat },
                    };
                    objects.push(Object::building(&building));
                    gardens.push(at(middle + 5.0 * (draw(7) - 0.5), depth(0.5 * size[1] - 3.5)));
                    gardens.push(at(middle + 0.4 * width, depth(3.0)));
                }
            }
            LandUse::Park => {
                for k in 0..14 {
                    gardens.push(at(size[0] * unit(k, 1, block.seed), size[1] * unit(k, 2, block.seed)));
                }
            }
            LandUse::Yard => {
                let hall = at(0.5 * size[0], 0.30 * size[1]);
                let building = Building {
                    at_m: [hall.x, hall.y],
                    size_m: [f64::from(0.8 * size[0]), f64::from(0.42 * size[1])],
                    height_m: f64::from(7.0 + 6.0 * unit(1, 3, block.seed)),
                    yaw_deg,
                    roof: Roof::Flat,
                };
                objects.push(Object::building(&building));
            }
        }
    }

    /// Returns the paint: dashes along the streets and bars across them at crossings.
    fn paint(&self) -> Vec<Object> {
        let mut marks = Vec::new();
        for axis in 0..2 {
            let cross = &self.streets[1 - axis];
            let along: Vector2<f32> = (self.world(if axis == 0 { [0.0, 1.0] } else { [1.0, 0.0] })).cast();
            for street in &self.streets[axis] {
                let mut bar = |across: f32, way: f32, half: [f32; 2]| {
                    let at = self.world(if axis == 0 { [across, way] } else { [way, across] });
                    if at.amax() < BUILT_HALF_EXTENT_M {
                        marks.push(Object::bar(at, along, half, 0.72));
                    }
                };
                for pair in cross.windows(2) {
                    let (start, end) = (pair[0].at + pair[0].half + 6.0, pair[1].at - pair[1].half - 6.0);
                    let count = ((end - start) / 6.0).floor().max(0.0) as usize;
                    for k in 0..count {
                        bar(street.at, start + 6.0 * k as f32 + 2.5, [1.5, 0.07]);
                    }
                    for way in [start - 3.2, end + 3.2] {
                        for k in -4..=4 {
                            let across = 0.95 * k as f32;
                            if across.abs() < street.half - 0.3 {
                                bar(street.at + across, way, [1.4, 0.25]);
                            }
                        }
                    }
                }
            }
        }
        marks
    }
}

impl Block {
    fn kind(&self) -> LandUse {
        match unit(1, 9, self.seed) {
            v if v < 0.66 => LandUse::Houses,
            v if v < 0.80 => LandUse::Park,
            _ => LandUse::Yard,
        }
    }

    fn lots(&self) -> u32 {
        (((self.high[0] - self.low[0]) / 17.0).round() as u32).max(1)
    }

    fn at(&self, q: [f32; 2], p: Vector2<f32>, dirt: f32) -> Material {
        let size = [0, 1].map(|axis| self.high[axis] - self.low[axis]);
        let (a, b) = (q[0] - self.low[0], q[1] - self.low[1]);
        let small = octaves(p.x / 1.5, p.y / 1.5, 0, self.seed + 2, 3, 0.8);
        let green =
            |material: Material| Material { albedo: material.albedo * (1.0 + 0.5 * dirt + 0.35 * small), ..material };
        match self.kind() {
            LandUse::Houses => {
                let width = size[0] / self.lots() as f32;
                let lot = (a / width).floor();
                let side = b > 0.5 * size[1];
                let (s, t) = (a - (lot + 0.5) * width, if side { size[1] - b } else { b });
                let draw = |n: u32| unit(2 * lot as u32 + u32::from(side), n, self.seed);
                let boundary = (0.5 * width - s.abs()).min(0.5 * size[1] - t);
                if (s + 0.5 * width - 2.4).abs() < 1.4 && t < 15.0 {
                    return Material { albedo: 0.44 * (1.0 + 0.3 * dirt), grain: [0.0, 0.03, 0.10] };
                }
                if (s - 1.2).abs() < 0.6 && t < HOUSE_SETBACK_M {
                    return Material { albedo: 0.55 * (1.0 + 0.3 * dirt), grain: [0.0, 0.02, 0.08] };
                }
                if boundary + 0.3 * small < 0.45 && t > 1.0 {
                    return green(HEDGE);
                }
                let terrace = HOUSE_SETBACK_M + 5.0;
                if (s - 1.2).abs() < 3.0 && (terrace..terrace + 3.0).contains(&t) {
                    return Material {
                        albedo: (0.36 + 0.2 * draw(20)) * (1.0 + 0.25 * dirt),
                        grain: [0.0, 0.03, 0.10],
                    };
                }
                let bed = (s - width * 0.3 * (draw(21) - 0.5)).abs() < 2.5 && (t - 21.0 - 3.0 * draw(22)).abs() < 1.5;
                if bed && draw(23) < 0.6 {
                    let rows = libm::sinf(s * 9.0);
                    return green(Material { albedo: BED.albedo * (1.0 + 0.25 * rows), ..BED });
                }
                if draw(24) < 0.15 && libm::hypotf(s - 1.0, (t - 22.0) * 1.4) < 3.0 {
                    return Material { albedo: 0.60, grain: [0.0, 0.0, 0.02] };
                }
                green(Material { albedo: LAWN.albedo * (0.75 + 0.5 * draw(25)), ..LAWN })
            }
            LandUse::Park => {
                let wobble = 4.0 * gradient(p.x / 25.0, p.y / 25.0, 0, self.seed + 8);
                let diagonal = (a / size[0] - b / size[1]).abs() * 0.7 * size[1] + wobble;
                let round = (libm::hypotf(a - 0.5 * size[0], b - 0.5 * size[1]) - 0.28 * size[1] + wobble).abs();
                if diagonal.abs().min(round) < 1.1 {
                    return Material { albedo: 0.58 * (1.0 + 0.3 * dirt), grain: [0.0, 0.13, 0.05] };
                }
                green(LAWN)
            }
            LandUse::Yard => {
                let mut asphalt = ROAD;
                asphalt.albedo = 0.27 * (1.0 + 0.35 * dirt);
                let bay = (a / 2.6 - (a / 2.6).floor() - 0.5).abs();
                let row = (b - 0.62 * size[1]).rem_euclid(0.30 * size[1]);
                if b > 0.60 * size[1] && b < 0.97 * size[1] && row < 5.0 && bay > 0.472 {
                    asphalt.albedo = 0.62;
                }
                asphalt
            }
        }
    }
}
