//! Drawing of the objects on the ground: visibility, edges and shadows.
//!
//! A frame is divided into tiles of 32 x 16 pixels. A tile lists the objects whose bounding volume, or whose shadow,
//! may appear in it. A pixel tests the objects of its tile with its ray, and with a ray from the hit to the sun for
//! shadow. A pixel that differs from one of its four neighbours in face, object or shadow is on an edge; its value is
//! the mean of eight rays within it.

use nalgebra::{Matrix3, Vector2, Vector3};

use super::grain::{HARD, LEAF, LocalGrain};
use super::object::{Hit, Object};
use super::row::{KNOT_SPACING, Row, Viewpoint};
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
    /// Objects that may cast a shadow on something visible in a tile.
    shading: Vec<Vec<u32>>,
    /// The moving ones of `shading`: shadows of the others are part of the composed ground.
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
pub const SUBPIXEL_RAYS: [[f32; 2]; 8] = [
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
        let (mut shading, mut moving) = (seen.clone(), seen.clone());
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
                list_in_tiles(&mut shading, [across, down], &outline, k as u32);
                if !object.is_static() {
                    list_in_tiles(&mut moving, [across, down], &outline, k as u32);
                }
            }
        }
        Self { centres, across, seen, shading, moving }
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
            if near.seen.is_empty() && near.moving.is_empty() {
                continue;
            }
            for x in tile * TILE_COLUMNS..((tile + 1) * TILE_COLUMNS).min(labels.len()) {
                let (block, lane) = (x / KNOT_SPACING, x % KNOT_SPACING);
                let ray = Ray { direction: row.direction(x), ground: row.along[block][lane] };
                let (label, radiance) = self.trace(&near, &ray, ground[x], row, x, grain);
                labels[x] = label;
                if label != 0 {
                    out[x] = radiance;
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
            let sum: f32 = SUBPIXEL_RAYS
                .iter()
                .map(|[dx, dy]| {
                    let direction = middle + right * *dx + down * *dy;
                    let ray = Ray { direction, ground: depth / direction.z };
                    self.trace(&tile.1, &ray, here.ground[x], row, x, grain).1
                })
                .sum();
            out[x] = sum / SUBPIXEL_RAYS.len() as f32;
        }
    }

    /// Returns the solid objects of the tile of a pixel, relative to the camera.
    fn objects_at(&self, tiles: &ObjectTiles, x: usize, y: usize, viewpoint: &Viewpoint) -> TileObjects<'_> {
        let placed = |&k: &u32| {
            let object = &self.objects[k as usize];
            let centre = (tiles.centres[k as usize] - viewpoint.origin).map(|v| v as f32);
            object.is_solid().then_some(Placed { object, centre, label: k + 1 })
        };
        let tile = tiles.tile(x, y);
        TileObjects {
            seen: tiles.seen[tile].iter().filter_map(placed).collect(),
            shading: tiles.shading[tile].iter().filter_map(placed).collect(),
            moving: tiles.moving[tile].iter().filter_map(placed).collect(),
            anchor: viewpoint.origin.xy(),
        }
    }

    /// Traces a ray and returns the label and the radiance; `ground` is the light reflected by the ground.
    fn trace(
        &self,
        near: &TileObjects<'_>,
        ray: &Ray,
        ground: f32,
        row: &Row,
        x: usize,
        grain: &LocalGrain<'_>,
    ) -> (Label, f32) {
        let mut first: Option<(Hit, &Placed<'_>)> = None;
        for object in &near.seen {
            let limit = first.map_or(ray.ground, |(hit, _)| hit.along);
            if let Some(hit) = object.object.hit(&-object.centre, &ray.direction, limit) {
                first = Some((hit, object));
            }
        }
        let (block, part) = (x / KNOT_SPACING, (x % KNOT_SPACING) as f32 / KNOT_SPACING as f32);
        let (a, b) = (&row.knots[block], &row.knots[block + 1]);
        let along = first.map_or(ray.ground, |(hit, _)| hit.along);
        let point = ray.direction * along;
        let (shaded, reflected) = match first {
            None if self.is_shaded(&near.moving, &point) => (true, self.shadowed(near, &point, ground)),
            None => (false, ground),
            Some((hit, object)) => {
                let facing = (hit.normal.dot(&self.to_sun.map(|v| v as f32)) / -self.to_sun.z as f32).max(0.0);
                let (facing, albedo) = if !hit.leaves {
                    let [fine] = grain.sample(&[point.x], &[point.y], a.footprint);
                    let courses = course_brightness(&hit, &(point - object.centre), a.footprint);
                    (facing, hit.albedo * (1.0 + 0.07 * fine[HARD] + courses))
                } else {
                    // Leaves transmit light and have all orientations. The height is that over the object, not over the
                    // camera: otherwise the pattern would slide over the crown while the camera climbs.
                    let z = point.z - object.centre.z;
                    let [fine] = grain.sample(&[point.x + 0.7 * z], &[point.y - 0.5 * z], a.footprint);
                    (0.25 + 0.75 * facing, hit.albedo * (1.0 + 0.30 * fine[LEAF]).max(0.2))
                };
                let shaded = facing > 0.0 && self.is_shaded(&near.shading, &(point + hit.normal * 0.02));
                (shaded, albedo * (SKY_LIGHT + (1.0 - SKY_LIGHT) * if shaded { 0.0 } else { facing }))
            }
        };
        // All of a crown has one label: it is rough anyway, and its edges would take half of the rendering time.
        let label = match first {
            None => u32::from(shaded),
            Some((hit, object)) if hit.leaves => (object.label << 8) | 0x80,
            Some((hit, object)) => (object.label << 8) | 0x80 | (hit.part << 1) | u32::from(shaded),
        };
        let transmission = a.transmission + part * (b.transmission - a.transmission);
        // An object is nearer than the ground behind it.
        let transmission =
            if first.is_some() && self.extinction > 0.0 { transmission.powf(along / ray.ground) } else { transmission };
        (label, self.radiance(reflected, transmission))
    }

    /// Returns the light of ground in the shadow of a moving object: that of the sky only, unless a static object
    /// shades the ground already.
    fn shadowed(&self, near: &TileObjects<'_>, point: &Vector3<f32>, ground: f32) -> f32 {
        if near.shading.iter().any(|object| object.object.is_static() && object.shades(point, &self.to_sun)) {
            return ground;
        }
        let at = near.anchor + point.xy().map(f64::from);
        let slope = self.relief.as_ref().map_or([0.0; 2], |relief| relief.at(at).slope);
        ground * SKY_LIGHT / (SKY_LIGHT + (1.0 - SKY_LIGHT) * self.sunlight(slope))
    }

    fn is_shaded(&self, shading: &[Placed<'_>], point: &Vector3<f32>) -> bool {
        shading.iter().any(|object| object.shades(point, &self.to_sun))
    }
}

/// Returns the relative brightness of the courses of tiles on a roof, at a point relative to the object. It fades as a
/// pixel approaches the width of a course.
fn course_brightness(hit: &Hit, point: &Vector3<f32>, footprint: f32) -> f32 {
    if hit.course == 0.0 {
        return 0.0;
    }
    let down = hit.normal.xy().normalize().dot(&point.xy()) / hit.course;
    let seen = (1.0 - 1.5 * libm::exp2f(footprint) / hit.course).max(0.0);
    0.16 * seen * (2.0 * (down - down.floor()) - 1.0)
}

/// The solid objects of a tile.
#[derive(Default)]
struct TileObjects<'a> {
    seen: Vec<Placed<'a>>,
    shading: Vec<Placed<'a>>,
    moving: Vec<Placed<'a>>,
    /// Point on the ground below the camera, m.
    anchor: Vector2<f64>,
}

/// An object with its position relative to the camera.
struct Placed<'a> {
    object: &'a Object,
    /// Centre relative to the camera, m.
    centre: Vector3<f32>,
    label: Label,
}

impl Placed<'_> {
    /// Returns `true` if the object shades a point given relative to the camera.
    fn shades(&self, point: &Vector3<f32>, to_sun: &Vector3<f64>) -> bool {
        self.object.shades(&(point - self.centre), &to_sun.map(|v| v as f32))
    }
}

/// The ray of a pixel or of a sample within it.
struct Ray {
    direction: Vector3<f32>,
    /// Distance to the ground, in lengths of the direction.
    ground: f32,
}
