//! Things over the ground: which of them a pixel can see, what it sees, and their shadows.
//!
//! A frame is cut into tiles of 32 x 16 pixels; a tile lists the things whose bounding sphere, or whose shadow, can be
//! in it. A pixel tests the things of its tile: its ray for what it sees, and a ray from there to the sun for shadow.
//! A pixel that sees another face, another thing or another light than one of its four neighbours is on an edge: it
//! becomes the mean of eight rays within it.

use nalgebra::{Matrix3, Vector2, Vector3};

use super::grain::{HARD, LEAF, NearGrain};
use super::thing::{Hit, Thing};
use super::view::Lens;
use super::{KNOT, Renderer, Row, SKY, Viewpoint};

/// Columns of a tile.
const TILE: usize = 32;
/// Rows of a tile, and of a band that is computed at a time.
pub const BAND: usize = 16;

/// Things at one time, and the tiles of a frame they are in.
pub struct Cast {
    centres: Vec<Vector3<f64>>,
    across: usize,
    tiles: Vec<Vec<u32>>,
}

/// What a pixel sees, as a number that changes at an edge: 0 for lit ground.
type Mark = u32;

/// A row's rays, what they see, and the brightness of the ground.
pub struct Seen {
    /// The rays.
    pub row: Row,
    /// Where the camera was.
    pub viewpoint: Viewpoint,
    /// What each pixel sees.
    pub marks: Vec<Mark>,
    /// Albedo of the ground.
    pub albedo: Vec<f32>,
}

/// Eight points of a pixel of which no two share a row or a column.
const RAYS: [[f32; 2]; 8] = [
    [-0.4375, 0.0625],
    [-0.3125, -0.3125],
    [-0.1875, 0.3125],
    [-0.0625, -0.1875],
    [0.0625, 0.4375],
    [0.1875, -0.0625],
    [0.3125, -0.4375],
    [0.4375, 0.1875],
];

impl Cast {
    /// The things of a scene as they are at a time, over a frame seen from between two poses.
    pub fn new(renderer: &Renderer, time: f64, lens: &Lens, ends: [&Viewpoint; 2], size: [usize; 2]) -> Self {
        let centres: Vec<Vector3<f64>> = renderer.things.iter().map(|thing| renderer.centre(thing, time)).collect();
        let (across, down) = (size[0].div_ceil(TILE), size[1].div_ceil(BAND));
        let mut tiles = vec![Vec::new(); across * down];
        let lowest = renderer.lowest();
        for (k, (thing, centre)) in renderer.things.iter().zip(&centres).enumerate() {
            let radius = f64::from(thing.radius);
            let mut ends_of_shadow = vec![*centre];
            if thing.is_solid() {
                // From its top to the lowest ground, along the sunlight.
                let fall = (-centre.z + radius - lowest).max(0.0).min(2.0 * radius + thing.rise() + 10.0);
                ends_of_shadow.push(centre - renderer.to_sun * (fall / -renderer.to_sun.z));
            }
            let Some([low, high]) = bounds(lens, ends, &ends_of_shadow, radius) else { continue };
            let tile = |v: f64, side: usize, count: usize| (v / side as f64).floor().clamp(0.0, count as f64) as usize;
            if high.x < 0.0 || high.y < 0.0 {
                continue;
            }
            for y in tile(low.y, BAND, down)..(tile(high.y, BAND, down) + 1).min(down) {
                for x in tile(low.x, TILE, across)..(tile(high.x, TILE, across) + 1).min(across) {
                    tiles[y * across + x].push(k as u32);
                }
            }
        }
        Self { centres, across, tiles }
    }

    /// Things that may be seen by a pixel.
    fn near(&self, x: usize, y: usize) -> &[u32] {
        &self.tiles[(y / BAND) * self.across + x / TILE]
    }
}

/// Pixels between which spheres at some points are seen; `None` where one is not in front of the camera.
fn bounds(lens: &Lens, ends: [&Viewpoint; 2], points: &[Vector3<f64>], radius: f64) -> Option<[Vector2<f64>; 2]> {
    let mut limits = [Vector2::repeat(f64::INFINITY), Vector2::repeat(f64::NEG_INFINITY)];
    for viewpoint in ends {
        for point in points {
            let seen = viewpoint.rotation.transpose() * (point - viewpoint.origin);
            // As good as behind the camera, or around it.
            if seen.z < 1.2 * radius {
                return None;
            }
            // A sphere far off the axis is seen as an ellipse, longer by 1 / cos^2 than in the middle; beyond two
            // radians of slope nothing is in any frame.
            let slope = seen.xy() / seen.z;
            let stretch = (1.0 + slope.norm_squared()).min(5.0);
            let reach = lens.camera.focal() * radius / (seen.z - radius) * stretch + 3.0;
            let pixel = lens.pixel(seen);
            limits = [limits[0].inf(&pixel.add_scalar(-reach)), limits[1].sup(&pixel.add_scalar(reach))];
        }
    }
    Some(limits)
}

impl Renderer {
    /// Paint on the ground, before it is lit.
    pub(super) fn paint(&self, cast: &Cast, seen: &mut Seen, y: usize, pixel: f32) {
        let Seen { row, viewpoint, albedo, .. } = seen;
        for (tile, albedo) in albedo.chunks_mut(TILE).enumerate() {
            for &k in cast.near(tile * TILE, y) {
                let thing = &self.things[k as usize];
                if thing.is_solid() {
                    continue;
                }
                let centre = (cast.centres[k as usize] - viewpoint.origin).xy().map(|v| v as f32);
                for (i, albedo) in albedo.iter_mut().enumerate() {
                    let (block, lane) = ((tile * TILE + i) / KNOT, i % KNOT);
                    let p = Vector2::new(row.x[block][lane], row.y[block][lane]) - centre;
                    if p.norm_squared() < (thing.radius + 1.0).powi(2) {
                        *albedo = thing.painted(p, row.along[block][lane] * pixel, *albedo);
                    }
                }
            }
        }
    }

    /// What each pixel of a row sees, and the radiance where that is not lit ground.
    pub(super) fn look(&self, cast: &Cast, seen: &mut Seen, y: usize, grain: &NearGrain<'_>, out: Option<&mut [f32]>) {
        let Seen { row, viewpoint, marks, albedo } = seen;
        marks.fill(0);
        let mut ignored = vec![0.0; if out.is_some() { 0 } else { marks.len() }];
        let out = out.unwrap_or(&mut ignored);
        for tile in 0..marks.len().div_ceil(TILE) {
            let near = self.solids(cast, cast.near(tile * TILE, y), viewpoint);
            if near.is_empty() {
                continue;
            }
            for x in tile * TILE..((tile + 1) * TILE).min(marks.len()) {
                let (block, lane) = (x / KNOT, x % KNOT);
                let ray = Ray { direction: row.direction(x), ground: row.along[block][lane] };
                let (mark, radiance) = self.see(&near, &ray, albedo[x], row, x, grain);
                marks[x] = mark;
                if mark != 0 {
                    out[x] = radiance;
                }
            }
        }
    }

    /// The mean of eight rays for each pixel on an edge.
    pub(super) fn refine(
        &self,
        cast: &Cast,
        rows: [&Seen; 3],
        y: usize,
        inverse: &Matrix3<f64>,
        grain: &NearGrain<'_>,
        out: &mut [f32],
    ) {
        let [above, here, below] = rows;
        let row = &here.row;
        let step = here.viewpoint.rotation * inverse[(0, 0)];
        let (right, down) = (step.column(0).map(|v| v as f32), step.column(1).map(|v| v as f32));
        let (width, marks) = (here.marks.len(), &here.marks);
        let mut tile = (usize::MAX, Vec::new());
        for x in 0..width {
            let mark = marks[x];
            let same = above.marks[x] == mark
                && below.marks[x] == mark
                && marks[x.saturating_sub(1)] == mark
                && marks[(x + 1).min(width - 1)] == mark;
            if same {
                continue;
            }
            if tile.0 != x / TILE {
                tile = (x / TILE, self.solids(cast, cast.near(x, y), &here.viewpoint));
            }
            let (block, lane) = (x / KNOT, x % KNOT);
            let (middle, along) = (row.direction(x), row.along[block][lane]);
            let depth = along * middle.z;
            let sum: f32 = RAYS
                .iter()
                .map(|[dx, dy]| {
                    let direction = middle + right * *dx + down * *dy;
                    let ray = Ray { direction, ground: depth / direction.z };
                    self.see(&tile.1, &ray, here.albedo[x], row, x, grain).1
                })
                .sum();
            out[x] = sum / RAYS.len() as f32;
        }
    }

    /// The solids among some things, and where they are from the camera.
    fn solids<'a>(&'a self, cast: &Cast, near: &[u32], viewpoint: &Viewpoint) -> Vec<Near<'a>> {
        let solid = |&k: &u32| {
            let thing = &self.things[k as usize];
            let centre = (cast.centres[k as usize] - viewpoint.origin).map(|v| v as f32);
            thing.is_solid().then_some(Near { thing, centre, mark: k + 1 })
        };
        near.iter().filter_map(solid).collect()
    }

    fn see(
        &self,
        near: &[Near<'_>],
        ray: &Ray,
        albedo: f32,
        row: &Row,
        x: usize,
        grain: &NearGrain<'_>,
    ) -> (Mark, f32) {
        let mut first: Option<(Hit, &Near<'_>)> = None;
        for thing in near {
            let limit = first.map_or(ray.ground, |(hit, _)| hit.along);
            if let Some(hit) = thing.thing.hit(&-thing.centre, &ray.direction, limit) {
                first = Some((hit, thing));
            }
        }
        let (block, part) = (x / KNOT, (x % KNOT) as f32 / KNOT as f32);
        let (a, b) = (&row.knots[block], &row.knots[block + 1]);
        let along = first.map_or(ray.ground, |(hit, _)| hit.along);
        let point = ray.direction * along;
        let (facing, albedo) = match first {
            None => (a.light + part * (b.light - a.light), albedo),
            Some((hit, thing)) => {
                let facing = (hit.normal.dot(&self.to_sun.map(|v| v as f32)) / -self.to_sun.z as f32).max(0.0);
                if !hit.leaves {
                    let [fine] = grain.sample(&[point.x], &[point.y], a.footprint);
                    (
                        facing,
                        hit.albedo * (1.0 + 0.07 * fine[HARD] + courses(&hit, &(point - thing.centre), a.footprint)),
                    )
                } else {
                    // Leaves let light through, and lie at all angles.
                    let [fine] = grain.sample(&[point.x + 0.7 * point.z], &[point.y - 0.5 * point.z], a.footprint);
                    (0.25 + 0.75 * facing, hit.albedo * (1.0 + 0.30 * fine[LEAF]).max(0.2))
                }
            }
        };
        let lifted = first.map_or(point, |(hit, _)| point + hit.normal * 0.02);
        let shaded = facing > 0.0 && self.is_shaded(near, &lifted);
        let light = SKY + (1.0 - SKY) * if shaded { 0.0 } else { facing };
        let mark = first.map_or(0, |(hit, thing)| (thing.mark << 8) | (hit.part << 1) | 0x80) | u32::from(shaded);
        let transmission = a.transmission + part * (b.transmission - a.transmission);
        // What stands above the ground is nearer.
        let transmission =
            if first.is_some() && self.extinction > 0.0 { transmission.powf(along / ray.ground) } else { transmission };
        (mark, self.radiance(albedo * light, transmission))
    }

    fn is_shaded(&self, near: &[Near<'_>], point: &Vector3<f32>) -> bool {
        let sun = self.to_sun.map(|v| v as f32);
        near.iter().any(|thing| thing.thing.hit(&(point - thing.centre), &sun, f32::INFINITY).is_some())
    }
}

/// Brightness of courses of tiles on a roof, at a point of the thing; a pixel as wide as a course sees their mean.
fn courses(hit: &Hit, point: &Vector3<f32>, footprint: f32) -> f32 {
    if hit.course == 0.0 {
        return 0.0;
    }
    let down = hit.normal.xy().normalize().dot(&point.xy()) / hit.course;
    let seen = (1.0 - 1.5 * libm::exp2f(footprint) / hit.course).max(0.0);
    0.16 * seen * (2.0 * (down - down.floor()) - 1.0)
}

struct Near<'a> {
    thing: &'a Thing,
    /// From the camera.
    centre: Vector3<f32>,
    mark: Mark,
}

struct Ray {
    direction: Vector3<f32>,
    /// Way along the direction to the ground.
    ground: f32,
}
