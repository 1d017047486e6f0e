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
use super::{KNOT, Renderer, Row, SKY, Surface, Viewpoint};

/// Columns of a tile.
const TILE: usize = 32;
/// Pixels by which a thing may be seen beside its outline: lenses bend straight lines.
const MARGIN: f64 = 4.0;
/// Rows of a tile, and of a band that is computed at a time.
pub const BAND: usize = 16;

/// Things at one time, and the tiles of a frame they are in.
pub struct Cast {
    centres: Vec<Vector3<f64>>,
    across: usize,
    /// What a pixel of a tile may see.
    seen: Vec<Vec<u32>>,
    /// What may throw a shadow on what it sees.
    shading: Vec<Vec<u32>>,
    /// Those of them that move: the shadows of the others lie on the ground already.
    moving: Vec<Vec<u32>>,
}

/// What a pixel sees, as a number that changes at an edge: 0 for ground outside the shadows of what moves.
type Mark = u32;

/// A row's rays, what they see, and the brightness of the ground.
pub struct Seen {
    /// The rays.
    pub row: Row,
    /// Where the camera was.
    pub viewpoint: Viewpoint,
    /// What each pixel sees.
    pub marks: Vec<Mark>,
    /// The light that the ground sends back.
    pub ground: Vec<f32>,
}

impl Seen {
    /// A row of `width` pixels, empty.
    pub fn new(width: usize, viewpoint: Viewpoint) -> Self {
        Self { row: Row::new(width), viewpoint, marks: vec![0; width], ground: vec![0.0; width] }
    }
}

/// Eight points of a pixel of which no two share a row or a column.
pub const RAYS: [[f32; 2]; 8] = [
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
        let at = |(thing, centre): (&Thing, &Vector3<f64>)| {
            if thing.is_still() { *centre } else { renderer.centre(thing, time) }
        };
        let centres: Vec<Vector3<f64>> = renderer.things.iter().zip(&renderer.centres).map(at).collect();
        let (across, down) = (size[0].div_ceil(TILE), size[1].div_ceil(BAND));
        let mut seen = vec![Vec::new(); across * down];
        let (mut shading, mut moving) = (seen.clone(), seen.clone());
        let lowest = renderer.lowest();
        let composed = matches!(renderer.surface, Surface::Land(_));
        for (k, (thing, centre)) in renderer.things.iter().zip(&centres).enumerate() {
            if composed && !thing.is_solid() {
                continue;
            }
            let (points, radius) = thing.hull();
            let points: Vec<Vector3<f64>> = points.iter().map(|point| centre + point.cast()).collect();
            // Where its shadow ends: at the lowest ground, along the sunlight.
            let shadow = |point: &Vector3<f64>| {
                let fall = (-point.z + f64::from(radius) - lowest).max(0.0);
                point - renderer.to_sun * (fall / -renderer.to_sun.z)
            };
            let Some(mut outline) = pixels(lens, ends, &points, radius.into()) else { continue };
            list(&mut seen, [across, down], &outline, k as u32);
            if thing.is_solid() {
                let shadows: Vec<Vector3<f64>> = points.iter().map(shadow).collect();
                let Some(shaded) = pixels(lens, ends, &shadows, radius.into()) else { continue };
                outline.extend(shaded);
                list(&mut shading, [across, down], &outline, k as u32);
                if !thing.is_still() {
                    list(&mut moving, [across, down], &outline, k as u32);
                }
            }
        }
        Self { centres, across, seen, shading, moving }
    }

    /// Whether there is a thing in the tiles of a row.
    pub fn any(&self, y: usize) -> bool {
        let first = self.tile(0, y);
        (first..first + self.across).any(|tile| !self.seen[tile].is_empty() || !self.moving[tile].is_empty())
    }

    /// The tile of a pixel.
    fn tile(&self, x: usize, y: usize) -> usize {
        (y / BAND) * self.across + x / TILE
    }
}

/// Pixels whose hull spheres about some points are seen within, by a camera at two places; `None` where one of them is
/// not in front of it.
fn pixels(lens: &Lens, ends: [&Viewpoint; 2], points: &[Vector3<f64>], radius: f64) -> Option<Vec<Vector2<f64>>> {
    let mut found = Vec::with_capacity(points.len() * 8);
    for viewpoint in ends {
        let to_camera = viewpoint.rotation.transpose();
        for point in points {
            let seen = to_camera * (point - viewpoint.origin);
            // As good as behind the camera, or around it.
            if seen.z < 1.2 * radius + 0.1 {
                return None;
            }
            let pixel = lens.pixel(seen);
            // Off the axis a sphere is an ellipse, longer by 1 / cos^2; beyond a slope of 2 nothing is in any frame.
            let stretch = 1.0 + (seen.xy() / seen.z).norm_squared().min(4.0);
            let reach = lens.camera.focal() * radius / (seen.z - radius) * stretch;
            let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
            found.extend(corners.map(|(x, y)| pixel + Vector2::new(x, y) * reach));
        }
    }
    Some(found)
}

/// Adds a thing to the tiles that the hull of some pixels comes near.
fn list(tiles: &mut [Vec<u32>], [across, down]: [usize; 2], outline: &[Vector2<f64>], thing: u32) {
    let side = Vector2::new(TILE as f64, BAND as f64);
    let low = outline.iter().fold(Vector2::repeat(f64::INFINITY), |low, p| low.inf(p)).add_scalar(-MARGIN);
    let high = outline.iter().fold(Vector2::repeat(f64::NEG_INFINITY), |high, p| high.sup(p)).add_scalar(MARGIN);
    let range = |axis: usize, count: usize| {
        let tile = |v: f64| (v / side[axis]).floor().clamp(0.0, count as f64) as usize;
        if high[axis] < 0.0 { 0..0 } else { tile(low[axis])..(tile(high[axis]) + 1).min(count) }
    };
    let (rows, columns) = (range(1, down), range(0, across));
    if rows.is_empty() || columns.is_empty() {
        return;
    }
    let hull = hull(outline);
    for y in rows {
        for x in columns.clone() {
            let middle = Vector2::new(x as f64 + 0.5, y as f64 + 0.5).component_mul(&side);
            // Outside one of the hull's edges by more than the tile reaches.
            let apart = (0..hull.len()).any(|k| {
                let (a, b) = (hull[k], hull[(k + 1) % hull.len()]);
                let normal = Vector2::new(b.y - a.y, a.x - b.x);
                let reach = 0.5 * normal.abs().dot(&side) + MARGIN * normal.norm();
                normal.dot(&(middle - a)) > reach
            });
            if !apart {
                tiles[y * across + x].push(thing);
            }
        }
    }
}

/// Convex hull, each edge with the inside on its left where `y` is up (monotone chain, Andrew 1979).
fn hull(points: &[Vector2<f64>]) -> Vec<Vector2<f64>> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut hull: Vec<Vector2<f64>> = Vec::new();
    let forth = sorted.iter();
    let back = sorted.iter().rev().skip(1);
    let turn = |a: Vector2<f64>, b: Vector2<f64>, c: Vector2<f64>| (b - a).perp(&(c - b));
    let mut floor = 2;
    for (k, &point) in forth.chain(back).enumerate() {
        if k == sorted.len() {
            floor = hull.len() + 1;
        }
        while hull.len() >= floor && turn(hull[hull.len() - 2], hull[hull.len() - 1], point) <= 0.0 {
            hull.pop();
        }
        hull.push(point);
    }
    hull.pop();
    hull
}

impl Renderer {
    /// Paint on the ground, before it is lit.
    pub(super) fn paint(&self, cast: &Cast, seen: &mut Seen, y: usize, pixel: f32) {
        let Seen { row, viewpoint, ground, .. } = seen;
        for (tile, albedo) in ground.chunks_mut(TILE).enumerate() {
            for &k in &cast.seen[cast.tile(tile * TILE, y)] {
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
        let Seen { row, viewpoint, marks, ground } = seen;
        let mut ignored = vec![0.0; if out.is_some() { 0 } else { marks.len() }];
        let out = out.unwrap_or(&mut ignored);
        for tile in 0..marks.len().div_ceil(TILE) {
            let near = self.near(cast, tile * TILE, y, viewpoint);
            if near.seen.is_empty() && near.moving.is_empty() {
                continue;
            }
            for x in tile * TILE..((tile + 1) * TILE).min(marks.len()) {
                let (block, lane) = (x / KNOT, x % KNOT);
                let ray = Ray { direction: row.direction(x), ground: row.along[block][lane] };
                let (mark, radiance) = self.see(&near, &ray, ground[x], row, x, grain);
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
        let mut tile = (usize::MAX, Near::default());
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
                tile = (x / TILE, self.near(cast, x, y, &here.viewpoint));
            }
            let (block, lane) = (x / KNOT, x % KNOT);
            let (middle, along) = (row.direction(x), row.along[block][lane]);
            let depth = along * middle.z;
            let sum: f32 = RAYS
                .iter()
                .map(|[dx, dy]| {
                    let direction = middle + right * *dx + down * *dy;
                    let ray = Ray { direction, ground: depth / direction.z };
                    self.see(&tile.1, &ray, here.ground[x], row, x, grain).1
                })
                .sum();
            out[x] = sum / RAYS.len() as f32;
        }
    }

    /// The solids of a tile, and where they are from the camera.
    fn near(&self, cast: &Cast, x: usize, y: usize, viewpoint: &Viewpoint) -> Near<'_> {
        let placed = |&k: &u32| {
            let thing = &self.things[k as usize];
            let centre = (cast.centres[k as usize] - viewpoint.origin).map(|v| v as f32);
            thing.is_solid().then_some(Placed { thing, centre, mark: k + 1 })
        };
        let tile = cast.tile(x, y);
        Near {
            seen: cast.seen[tile].iter().filter_map(placed).collect(),
            shading: cast.shading[tile].iter().filter_map(placed).collect(),
            moving: cast.moving[tile].iter().filter_map(placed).collect(),
            anchor: viewpoint.origin.xy(),
        }
    }

    /// What a ray sees, and the radiance from there; `ground` is the light that the ground sends back.
    fn see(&self, near: &Near<'_>, ray: &Ray, ground: f32, row: &Row, x: usize, grain: &NearGrain<'_>) -> (Mark, f32) {
        let mut first: Option<(Hit, &Placed<'_>)> = None;
        for thing in &near.seen {
            let limit = first.map_or(ray.ground, |(hit, _)| hit.along);
            if let Some(hit) = thing.thing.hit(&-thing.centre, &ray.direction, limit) {
                first = Some((hit, thing));
            }
        }
        let (block, part) = (x / KNOT, (x % KNOT) as f32 / KNOT as f32);
        let (a, b) = (&row.knots[block], &row.knots[block + 1]);
        let along = first.map_or(ray.ground, |(hit, _)| hit.along);
        let point = ray.direction * along;
        let (shaded, reflected) = match first {
            None if self.is_shaded(&near.moving, &point) => (true, self.shadowed(near, &point, ground)),
            None => (false, ground),
            Some((hit, thing)) => {
                let facing = (hit.normal.dot(&self.to_sun.map(|v| v as f32)) / -self.to_sun.z as f32).max(0.0);
                let (facing, albedo) = if !hit.leaves {
                    let [fine] = grain.sample(&[point.x], &[point.y], a.footprint);
                    let courses = courses(&hit, &(point - thing.centre), a.footprint);
                    (facing, hit.albedo * (1.0 + 0.07 * fine[HARD] + courses))
                } else {
                    // Leaves let light through, and lie at all angles.
                    let [fine] = grain.sample(&[point.x + 0.7 * point.z], &[point.y - 0.5 * point.z], a.footprint);
                    (0.25 + 0.75 * facing, hit.albedo * (1.0 + 0.30 * fine[LEAF]).max(0.2))
                };
                let shaded = facing > 0.0 && self.is_shaded(&near.shading, &(point + hit.normal * 0.02));
                (shaded, albedo * (SKY + (1.0 - SKY) * if shaded { 0.0 } else { facing }))
            }
        };
        // Within a crown there are no edges: leaves are rough, and eight rays for each would take half the time.
        let mark = match first {
            None => u32::from(shaded),
            Some((hit, thing)) if hit.leaves => (thing.mark << 8) | 0x80,
            Some((hit, thing)) => (thing.mark << 8) | 0x80 | (hit.part << 1) | u32::from(shaded),
        };
        let transmission = a.transmission + part * (b.transmission - a.transmission);
        // What stands above the ground is nearer.
        let transmission =
            if first.is_some() && self.extinction > 0.0 { transmission.powf(along / ray.ground) } else { transmission };
        (mark, self.radiance(reflected, transmission))
    }

    /// The light of ground in the shadow of something that moves: without the sun, unless that was missing before.
    fn shadowed(&self, near: &Near<'_>, point: &Vector3<f32>, ground: f32) -> f32 {
        if near.shading.iter().any(|thing| thing.thing.is_still() && thing.shades(point, &self.to_sun)) {
            return ground;
        }
        let at = near.anchor + point.xy().map(f64::from);
        let slope = self.relief.as_ref().map_or([0.0; 2], |relief| relief.at(at).slope);
        ground * SKY / (SKY + (1.0 - SKY) * self.sunlight(slope))
    }

    fn is_shaded(&self, shading: &[Placed<'_>], point: &Vector3<f32>) -> bool {
        shading.iter().any(|thing| thing.shades(point, &self.to_sun))
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

/// The solids of a tile.
#[derive(Default)]
struct Near<'a> {
    seen: Vec<Placed<'a>>,
    shading: Vec<Placed<'a>>,
    moving: Vec<Placed<'a>>,
    /// The camera's place over the ground.
    anchor: Vector2<f64>,
}

struct Placed<'a> {
    thing: &'a Thing,
    /// From the camera.
    centre: Vector3<f32>,
    mark: Mark,
}

impl Placed<'_> {
    /// Whether it throws a shadow on a point.
    fn shades(&self, point: &Vector3<f32>, to_sun: &Vector3<f64>) -> bool {
        self.thing.shades(&(point - self.centre), &to_sun.map(|v| v as f32))
    }
}

struct Ray {
    direction: Vector3<f32>,
    /// Way along the direction to the ground.
    ground: f32,
}
