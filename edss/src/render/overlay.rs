//! Drawing of the objects on the ground: visibility, edges and shadows.
//!
//! A frame is divided into tiles of 32 x 16 pixels. A tile lists the objects whose bounding volume, or whose shadow,
//! may appear in it. A pixel tests the objects of its tile with its ray, and with a ray from the hit to the sun for
//! shadow. A pixel that differs from one of its four neighbours in face, object or shadow is on an edge; its value is
//! the mean of eight rays within it.

use multiversion::multiversion;
use nalgebra::{Matrix3, Vector2, Vector3};

use super::bundle::{Lanes, Placed, RAYS, Shadow, Vectors, first_hits, shaded};
use super::grain::{HARD, LEAF, LocalGrain};
use super::object::{Object, SurfaceAt};
use super::row::{KNOT_SPACING, Knot, Row, Viewpoint};
use super::shade::SKY_LIGHT;
use super::view::Lens;
use super::{Renderer, Surface};

/// Width of a tile, pixels.
const TILE_COLUMNS: usize = 32;
/// Tolerance for outlines bent by lens distortion, pixels.
const OUTLINE_MARGIN_PX: f64 = 4.0;
/// Height of a tile, and of a band that one thread renders, pixels.
pub const BAND_ROWS: usize = 16;

/// The objects that may appear in each tile of a frame.
pub struct ObjectTiles {
    centres: Vec<Vector3<f64>>,
    across: usize,
    /// Objects that may be visible in a tile.
    seen: Vec<Vec<u32>>,
    /// Objects at rest that may cast a shadow on something visible in a tile. Their shadows on the ground are part of
    /// the composed ground.
    still: Vec<Vec<u32>>,
    /// Moving objects that may cast a shadow on something visible in a tile.
    moving: Vec<Vec<u32>>,
}

/// A label of what a pixel sees, which changes at an edge; 0 for ground outside the shadows of moving objects.
type Label = u32;

/// A row of pixels in progress: rays, labels and light of the ground.
pub struct RowView {
    /// Rays and their intersections with the ground.
    pub row: Row,
    /// Position and rotation of the camera.
    pub viewpoint: Viewpoint,
    /// Label of each pixel.
    pub labels: Vec<Label>,
    /// Light reflected by the ground at each pixel.
    pub ground: Vec<f32>,
}

impl RowView {
    /// Creates a row of `width` pixels, as yet without rays.
    pub fn new(width: usize, viewpoint: Viewpoint) -> Self {
        Self { row: Row::new(width), viewpoint, labels: vec![0; width], ground: vec![0.0; width] }
    }
}

/// Eight sample points of a pixel, of which no two share a row or a column; pixels from its middle.
pub const SUBPIXEL_RAYS: [[f32; 2]; RAYS] = [
    [-0.4375, 0.0625],
    [-0.3125, -0.3125],
    [-0.1875, 0.3125],
    [-0.0625, -0.1875],
    [0.0625, 0.4375],
    [0.1875, -0.0625],
    [0.3125, -0.4375],
    [0.4375, 0.1875],
];

impl ObjectTiles {
    /// Lists the objects of a scene at a time, for a frame of `size` pixels exposed between two viewpoints.
    pub fn new(renderer: &Renderer, time: f64, lens: &Lens, ends: [&Viewpoint; 2], size: [usize; 2]) -> Self {
        let at = |(object, centre): (&Object, &Vector3<f64>)| {
            if object.is_static() { *centre } else { renderer.centre(object, time) }
        };
        let centres: Vec<Vector3<f64>> = renderer.objects.iter().zip(&renderer.centres).map(at).collect();
        let (across, down) = (size[0].div_ceil(TILE_COLUMNS), size[1].div_ceil(BAND_ROWS));
        let mut seen = vec![Vec::new(); across * down];
        let (mut still, mut moving) = (seen.clone(), seen.clone());
        let lowest = renderer.lowest_ground();
        let composed = matches!(renderer.surface, Surface::Land(_));
        for (k, (object, centre)) in renderer.objects.iter().zip(&centres).enumerate() {
            if composed && !object.is_solid() {
                continue;
            }
            let (points, radius) = object.bounding_spheres();
            let points: Vec<Vector3<f64>> = points.iter().map(|point| centre + point.cast()).collect();
            // The shadow ends at the lowest ground, along the sunlight.
            let shadow_end = |point: &Vector3<f64>| {
                let fall = (-point.z + f64::from(radius) - lowest).max(0.0);
                point - renderer.to_sun * (fall / -renderer.to_sun.z)
            };
            let Some(mut outline) = project_spheres(lens, ends, &points, radius.into()) else { continue };
            list_in_tiles(&mut seen, [across, down], &outline, k as u32);
            if object.is_solid() {
                let shadows: Vec<Vector3<f64>> = points.iter().map(shadow_end).collect();
                let Some(shaded) = project_spheres(lens, ends, &shadows, radius.into()) else { continue };
                outline.extend(shaded);
                let shading = if object.is_static() { &mut still } else { &mut moving };
                list_in_tiles(shading, [across, down], &outline, k as u32);
            }
        }
        Self { centres, across, seen, still, moving }
    }

    /// Returns `true` if a tile in the row of tiles at pixel row `y` lists an object.
    pub fn any(&self, y: usize) -> bool {
        let first = self.tile(0, y);
        (first..first + self.across).any(|tile| !self.seen[tile].is_empty() || !self.moving[tile].is_empty())
    }

    /// Returns the index of the tile of a pixel.
    fn tile(&self, x: usize, y: usize) -> usize {
        (y / BAND_ROWS) * self.across + x / TILE_COLUMNS
    }
}

/// Returns pixels whose convex hull contains a set of spheres, seen from two camera positions; `None` if one of the
/// spheres is not entirely in front of the camera.
fn project_spheres(
    lens: &Lens,
    ends: [&Viewpoint; 2],
    points: &[Vector3<f64>],
    radius: f64,
) -> Option<Vec<Vector2<f64>>> {
    let mut found = Vec::with_capacity(points.len() * 8);
    for viewpoint in ends {
        let to_camera = viewpoint.rotation.transpose();
        for point in points {
            let seen = to_camera * (point - viewpoint.origin);
            // The sphere reaches behind the camera, or contains it.
            if seen.z < 1.2 * radius + 0.1 {
                return None;
            }
            let pixel = lens.pixel(seen);
            // Off the axis a sphere appears as an ellipse, longer by 1 / cos^2; no frame reaches beyond a slope of 2.
            let stretch = 1.0 + (seen.xy() / seen.z).norm_squared().min(4.0);
            let reach = lens.camera.focal() * radius / (seen.z - radius) * stretch;
            let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
            found.extend(corners.map(|(x, y)| pixel + Vector2::new(x, y) * reach));
        }
    }
    Some(found)
}

/// Adds an object to the tiles that the convex hull of `outline` touches.
fn list_in_tiles(tiles: &mut [Vec<u32>], [across, down]: [usize; 2], outline: &[Vector2<f64>], object: u32) {
    let side = Vector2::new(TILE_COLUMNS as f64, BAND_ROWS as f64);
    let low = outline.iter().fold(Vector2::repeat(f64::INFINITY), |low, p| low.inf(p)).add_scalar(-OUTLINE_MARGIN_PX);
    let high =
        outline.iter().fold(Vector2::repeat(f64::NEG_INFINITY), |high, p| high.sup(p)).add_scalar(OUTLINE_MARGIN_PX);
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
            // A tile is separate if it is entirely outside one edge of the hull.
            let apart = (0..hull.len()).any(|k| {
                let (a, b) = (hull[k], hull[(k + 1) % hull.len()]);
                let normal = Vector2::new(b.y - a.y, a.x - b.x);
                let reach = 0.5 * normal.abs().dot(&side) + OUTLINE_MARGIN_PX * normal.norm();
                normal.dot(&(middle - a)) > reach
            });
            if !apart {
                tiles[y * across + x].push(object);
            }
        }
    }
}

/// Returns the convex hull; the inside is on the left of each edge if `y` is up (monotone chain, Andrew 1979).
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
    /// Applies paint to the albedo of the ground along a row.
    pub(super) fn paint(&self, tiles: &ObjectTiles, seen: &mut RowView, y: usize, pixel: f32) {
        let RowView { row, viewpoint, ground, .. } = seen;
        for (tile, albedo) in ground.chunks_mut(TILE_COLUMNS).enumerate() {
            for &k in &tiles.seen[tiles.tile(tile * TILE_COLUMNS, y)] {
                let object = &self.objects[k as usize];
                if object.is_solid() {
                    continue;
                }
                let centre = (tiles.centres[k as usize] - viewpoint.origin).xy().map(|v| v as f32);
                for (i, albedo) in albedo.iter_mut().enumerate() {
                    let (block, lane) = ((tile * TILE_COLUMNS + i) / KNOT_SPACING, i % KNOT_SPACING);
                    let p = Vector2::new(row.x[block][lane], row.y[block][lane]) - centre;
                    if p.norm_squared() < (object.radius + 1.0).powi(2) {
                        *albedo = object.albedo_with_paint(p, row.along[block][lane] * pixel, *albedo);
                    }
                }
            }
        }
    }

    /// Labels each pixel of a row, and writes the radiance of pixels that do not show lit ground to `out`.
    pub(super) fn draw_objects(
        &self,
        tiles: &ObjectTiles,
        seen: &mut RowView,
        y: usize,
        grain: &LocalGrain<'_>,
        out: Option<&mut [f32]>,
    ) {
        let RowView { row, viewpoint, labels, ground } = seen;
        let mut ignored = vec![0.0; if out.is_some() { 0 } else { labels.len() }];
        let out = out.unwrap_or(&mut ignored);
        for tile in 0..labels.len().div_ceil(TILE_COLUMNS) {
            let near = self.objects_at(tiles, tile * TILE_COLUMNS, y, viewpoint);
            if near.seen.is_empty() && near.shading.len() == near.still {
                continue;
            }
            let blocks = TILE_COLUMNS / KNOT_SPACING;
            for block in tile * blocks..((tile + 1) * blocks).min(labels.len().div_ceil(KNOT_SPACING)) {
                let pixels = block * KNOT_SPACING..((block + 1) * KNOT_SPACING).min(labels.len());
                let mut light = [0.0; RAYS];
                light[..pixels.len()].copy_from_slice(&ground[pixels.clone()]);
                let rays = BlockRays {
                    direction: row.directions(block),
                    ground: row.along[block],
                    light,
                    part: std::array::from_fn(|l| l as f32 / KNOT_SPACING as f32),
                    ends: [row.knots[block], row.knots[block + 1]],
                };
                let (found, radiance) = self.trace(&near, &rays, grain);
                for (x, (label, radiance)) in pixels.zip(found.into_iter().zip(radiance)) {
                    labels[x] = label;
                    if label != 0 {
                        out[x] = radiance;
                    }
                }
            }
        }
    }

    /// Replaces each pixel on an edge by the mean of eight rays. `rows` are the row itself between its neighbours.
    pub(super) fn antialias(
        &self,
        tiles: &ObjectTiles,
        rows: [&RowView; 3],
        y: usize,
        inverse: &Matrix3<f64>,
        grain: &LocalGrain<'_>,
        out: &mut [f32],
    ) {
        let [above, here, below] = rows;
        let row = &here.row;
        let step = here.viewpoint.rotation * inverse[(0, 0)];
        let (right, down) = (step.column(0).map(|v| v as f32), step.column(1).map(|v| v as f32));
        let (width, labels) = (here.labels.len(), &here.labels);
        let mut tile = (usize::MAX, TileObjects::default());
        for x in 0..width {
            let label = labels[x];
            let same = above.labels[x] == label
                && below.labels[x] == label
                && labels[x.saturating_sub(1)] == label
                && labels[(x + 1).min(width - 1)] == label;
            if same {
                continue;
            }
            if tile.0 != x / TILE_COLUMNS {
                tile = (x / TILE_COLUMNS, self.objects_at(tiles, x, y, &here.viewpoint));
            }
            let (block, lane) = (x / KNOT_SPACING, x % KNOT_SPACING);
            let (middle, along) = (row.direction(x), row.along[block][lane]);
            let depth = along * middle.z;
            let mut rays = BlockRays {
                direction: Vectors::all(&middle),
                ground: [0.0; RAYS],
                light: [here.ground[x]; RAYS],
                part: [lane as f32 / KNOT_SPACING as f32; RAYS],
                ends: [row.knots[block], row.knots[block + 1]],
            };
            for (l, [dx, dy]) in SUBPIXEL_RAYS.iter().enumerate() {
                let direction = middle + right * *dx + down * *dy;
                rays.direction.set(l, &direction);
                rays.ground[l] = depth / direction.z;
            }
            let (_, radiance) = self.trace(&tile.1, &rays, grain);
            out[x] = radiance.iter().sum::<f32>() / RAYS as f32;
        }
    }

    /// Returns the solid objects of the tile of a pixel, relative to the camera.
    fn objects_at(&self, tiles: &ObjectTiles, x: usize, y: usize, viewpoint: &Viewpoint) -> TileObjects<'_> {
        let placed = |&k: &u32| {
            let centre = (tiles.centres[k as usize] - viewpoint.origin).map(|v| v as f32);
            Placed { object: &self.objects[k as usize], centre }
        };
        let tile = tiles.tile(x, y);
        let solid = tiles.seen[tile].iter().filter(|k| self.objects[**k as usize].is_solid());
        let (labels, seen) = solid.map(|k| (k + 1, placed(k))).unzip();
        let (still, moving) = (&tiles.still[tile], &tiles.moving[tile]);
        TileObjects {
            seen,
            labels,
            shading: still.iter().chain(moving).map(placed).collect(),
            still: still.len(),
            anchor: viewpoint.origin.xy(),
        }
    }

    /// Traces rays and returns their labels and radiances.
    fn trace(&self, near: &TileObjects<'_>, rays: &BlockRays, grain: &LocalGrain<'_>) -> ([Label; RAYS], Lanes) {
        let to_sun = self.to_sun.map(|v| v as f32);
        let hits = first_hits(&near.seen, &rays.direction, &rays.ground);
        let mut points = rays.direction;
        let mut surfaces = [None; RAYS];
        // Points where the grain of surfaces is sampled, and points from which the sun is looked for.
        let (mut grained, mut raised) = ([[0.0; RAYS]; 2], rays.direction);
        let mut sunlight = [0.0; RAYS];
        for lane in 0..RAYS {
            let point = rays.direction.get(lane) * hits.along[lane];
            points.set(lane, &point);
            let Some((index, part)) = hits.surface(lane) else { continue };
            let placed = &near.seen[index];
            // From the camera, in the order of the intersection itself: the same bits.
            let surface = placed.object.surface(part, &(-placed.centre + point));
            // The height is that over the object, not over the camera: otherwise the pattern of leaves would slide over
            // the crown while the camera climbs.
            let z = if surface.leaves { point.z - placed.centre.z } else { 0.0 };
            (grained[0][lane], grained[1][lane]) = (point.x + 0.7 * z, point.y - 0.5 * z);
            raised.set(lane, &(point + surface.normal * 0.02));
            let facing = (surface.normal.dot(&to_sun) / -self.to_sun.z as f32).max(0.0);
            // Leaves transmit light and have all orientations.
            sunlight[lane] = if surface.leaves { 0.25 + 0.75 * facing } else { facing };
            surfaces[lane] = Some((surface, index, part));
        }
        let open = surfaces.map(|surface| surface.is_none());
        let is_hit = open.contains(&false);
        let fine = if is_hit { sample_grain(grain, &grained, rays.ends[0].footprint) } else { [[0.0; 4]; RAYS] };
        let shaded = |objects, points, open| shaded(objects, points, &to_sun, Shadow::OfSurface, open);
        let dark = shaded(&near.shading, &raised, sunlight.map(|sunlight| sunlight > 0.0));
        let (still, moving) = near.shading.split_at(near.still);
        let moving_shadow = shaded(moving, &points, open);
        let still_shadow = shaded(still, &points, moving_shadow);
        let mut labels = [0; RAYS];
        let mut radiances = [0.0; RAYS];
        for lane in 0..RAYS {
            let reflected = match surfaces[lane] {
                // The shadows of objects at rest are part of the light already.
                None if !moving_shadow[lane] || still_shadow[lane] => rays.light[lane],
                None => self.shadowed(near.anchor, &points.get(lane), rays.light[lane]),
                Some((surface, index, _)) => {
                    let albedo = if surface.leaves {
                        surface.albedo * (1.0 + 0.30 * fine[lane][LEAF]).max(0.2)
                    } else {
                        let point = points.get(lane) - near.seen[index].centre;
                        let courses = course_brightness(&surface, &point, rays.ends[0].footprint);
                        surface.albedo * (1.0 + 0.07 * fine[lane][HARD] + courses)
                    };
                    albedo * (SKY_LIGHT + (1.0 - SKY_LIGHT) * if dark[lane] { 0.0 } else { sunlight[lane] })
                }
            };
            // All of a crown has one label: it is rough anyway, and its edges would take half of the rendering time.
            labels[lane] = match surfaces[lane] {
                None => u32::from(moving_shadow[lane]),
                Some((surface, index, _)) if surface.leaves => (near.labels[index] << 8) | 0x80,
                Some((_, index, part)) => (near.labels[index] << 8) | 0x80 | (part << 1) | u32::from(dark[lane]),
            };
            let [a, b] = rays.ends.map(|knot| knot.transmission);
            let transmission = a + rays.part[lane] * (b - a);
            // An object is nearer than the ground behind it.
            let transmission = if surfaces[lane].is_some() && self.extinction > 0.0 {
                transmission.powf(hits.along[lane] / rays.ground[lane])
            } else {
                transmission
            };
            radiances[lane] = self.radiance(reflected, transmission);
        }
        (labels, radiances)
    }

    /// Returns the light of the sky alone on ground that reflects `light`, at a point relative to the `anchor`.
    fn shadowed(&self, anchor: Vector2<f64>, point: &Vector3<f32>, light: f32) -> f32 {
        let at = anchor + point.xy().map(f64::from);
        let slope = self.relief.as_ref().map_or([0.0; 2], |relief| relief.at(at).slope);
        light * SKY_LIGHT / (SKY_LIGHT + (1.0 - SKY_LIGHT) * self.sunlight(slope))
    }
}

/// Returns the relative brightness of the courses of tiles on a roof, at a point relative to the object. It fades as a
/// pixel approaches the width of a course.
fn course_brightness(surface: &SurfaceAt, point: &Vector3<f32>, footprint: f32) -> f32 {
    if surface.course == 0.0 {
        return 0.0;
    }
    let down = surface.normal.xy().normalize().dot(&point.xy()) / surface.course;
    let seen = (1.0 - 1.5 * libm::exp2f(footprint) / surface.course).max(0.0);
    0.16 * seen * (2.0 * (down - down.floor()) - 1.0)
}

/// Samples the grain at points `(x, y)` m from its anchor.
#[multiversion(targets("x86_64+avx2"))]
fn sample_grain(grain: &LocalGrain<'_>, points: &[Lanes; 2], footprint: f32) -> [[f32; 4]; RAYS] {
    grain.sample(&points[0], &points[1], footprint)
}

/// The solid objects of a tile.
#[derive(Default)]
struct TileObjects<'a> {
    seen: Vec<Placed<'a>>,
    /// A number of each of `seen`, from 1 on, that no other object has.
    labels: Vec<Label>,
    /// Those that may cast a shadow, the ones at rest first.
    shading: Vec<Placed<'a>>,
    /// Number of those at rest.
    still: usize,
    /// Point on the ground below the camera, m.
    anchor: Vector2<f64>,
}

/// The rays of eight pixels between two knots, or of eight samples within one of them.
struct BlockRays {
    direction: Vectors,
    /// Distance to the ground, in lengths of the direction.
    ground: Lanes,
    /// Light reflected by the ground.
    light: Lanes,
    /// Position between the knots, 0 to 1.
    part: Lanes,
    ends: [Knot; 2],
}
