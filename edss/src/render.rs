//! What a camera sees of a scene: `radiance = T albedo light + (1 - T) air`, one ray a pixel, filtered textures.
//!
//! A pixel's ray is intersected with the ground in closed form, or with the relief by Newton's iteration at every 8th
//! pixel of a row and linearly between. The ground's brightness comes from textures that are filtered beforehand for
//! every distance ([`mip`]), so that one sample a pixel is enough; only the edges of things are sampled more often.
//! What never changes on the ground is composed once and kept ([`patch`]).
//! Light is Lambert's (1760) on the slope of the ground. Mist weakens contrast along the ray by `T = exp(-b r)`
//! (Koschmieder 1924).
//!
//! | module | its one reason |
//! |---|---|
//! | [`view`] | from pixel to ray and back |
//! | [`mip`] | a texture filtered beforehand for every distance |
//! | [`noise`] | gradient noise |
//! | [`grain`] | fine structure of the ground |
//! | [`land`] | larger structure of the ground |
//! | [`relief`] | height of the ground |
//! | [`patch`] | composed ground, kept from frame to frame |
//! | [`compose`] | what a patch of it shows |
//! | [`thing`] | what stands, lies or drives on the ground |
//! | [`crown`] | the balls of a tree's crown |
//! | [`water`] | waves and glint |
//! | [`fall`] | rain and snow |
//! | [`overlay`] | which things a pixel sees, edges and shadows |
//!
//! A frame is a function of scene, seed and shot: rows are computed independently and patches do not depend on the
//! frames before, so that it has the same bits for every number of threads.

#![allow(clippy::needless_range_loop)]

mod compose;
mod crown;
mod fall;
mod grain;
mod land;
mod mip;
mod noise;
mod overlay;
mod patch;
mod relief;
mod thing;
mod view;
mod water;

use hoverlock_pictures::{Picture, PictureError};
use hoverlock_reference::image::plane::Plane;
use multiversion::multiversion;
use nalgebra::{Matrix3, Vector2, Vector3};
use rand::RngExt;
use rayon::prelude::*;

use crate::pose::Pose;
use crate::random::{Purpose, stream};
use crate::scene::{Ground, Scene, Tree};
use fall::Drops;
use grain::{GREEN, Grain, HARD, NearGrain, SOIL};
use land::Material;
use mip::{Laid, MIRRORED, Mip, Near};
use overlay::{BAND, Cast, Seen};
use patch::{AtHand, Key, Lattice, Patches, lattices};
use relief::Relief;
use thing::Thing;
use view::Corrections;
pub use view::Lens;
use water::{Mirror, NearWaves, Waves};

/// One exposure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shot {
    /// Camera and lens.
    pub lens: Lens,
    /// Where the camera is at the first row.
    pub first: Pose,
    /// Where it is at the last row; equal for a global shutter.
    pub last: Pose,
    /// From the start of the scene, s.
    pub time: f64,
}

/// Why a scene cannot be rendered.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// A picture of the scene is damaged.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// A picture that shows nothing, on which no feature can be found.
    #[error("ground.picture.file: {0}: every pixel has the same value; name a picture of the ground")]
    Constant(String),
    /// A camera could not see all of the ground.
    #[error(
        "relief: slopes up to {slope:.2} are too steep: at most 1; lower rms_m or height_m, or lengthen wavelength_m"
    )]
    Steep {
        /// Greatest, m/m.
        slope: f64,
    },
}

/// A scene made ready: textures, their filtered levels, heights.
pub struct Renderer {
    surface: Surface,
    grain: Grain,
    relief: Option<Relief>,
    things: Vec<Thing>,
    /// Where they are at time 0.
    centres: Vec<Vector3<f64>>,
    /// The ground is level and nothing that stands still shades it.
    even: bool,
    patches: Patches,
    drops: Vec<Drops>,
    to_sun: Vector3<f64>,
    brightness: f32,
    extinction: f64,
}

/// What gives the ground its brightness.
enum Surface {
    Picture { picture: Laid<u16, 1, MIRRORED>, grain: f32 },
    Land(Laid<u32, 4, MIRRORED>),
    Water(Waves),
}

/// Scattered light relative to white ground in full sun, as in `hoverlock_pictures::conditions`.
const AIR_LIGHT: f32 = 0.55;
/// Light from the sky: what is left of the sunlight in a shadow.
const SKY: f32 = 0.3;
/// Pixels from one exact intersection of a row to the next.
const KNOT: usize = 8;
/// Rays are followed this far, m.
const FARTHEST: f64 = 10_000.0;
/// Least part of a ray's motion that must be downwards; what looks higher sees far ground.
const DOWNWARDS: f32 = 0.02;

impl Renderer {
    /// Makes a scene ready; what is random in it follows from `seed`.
    ///
    /// # Errors
    /// A picture is damaged, or the relief is too steep.
    pub fn new(scene: &Scene, seed: u64) -> Result<Self, RenderError> {
        let mut random = stream(seed, Purpose::Scene);
        let [grain_seed, relief_seed] = [random.random(), random.random()];
        let relief = match &scene.relief {
            None => None,
            Some(crate::scene::Relief::Hills(hills)) if hills.rms_m == 0.0 => None,
            Some(crate::scene::Relief::Hills(hills)) => Some(Relief::hills(hills, relief_seed)),
            Some(crate::scene::Relief::Map(map)) => {
                Some(Relief::map(&Picture::open(&map.file)?.luma, map.texel_m, map.height_m))
            }
        };
        if let Some(slope) = relief.as_ref().map(Relief::steepest).filter(|&slope| slope > 1.0) {
            return Err(RenderError::Steep { slope });
        }
        let mut things = things(scene);
        let surface = match &scene.ground {
            Ground::Picture(ground) => {
                let luma = Picture::open(&ground.file)?.luma;
                let (width, height) = (luma.width(), luma.height());
                if luma.as_slice().iter().all(|value| *value == luma.as_slice()[0]) {
                    return Err(RenderError::Constant(ground.file.display().to_string()));
                }
                let middle = Vector2::new(width as f64, height as f64) / 2.0;
                let picture = Laid::new(Mip::new(width, height, luma.as_slice()), ground.texel_m, 0.0, middle);
                Surface::Picture { picture, grain: ground.grain as f32 }
            }
            Ground::Field(field) => {
                let landscape = land::field::Landscape::new(field.parcel_m as f32, &mut random);
                for at in landscape.edges(&mut random, field.trees as usize) {
                    let radius_m = random.random_range(1.4..3.6);
                    let tree =
                        Tree { at_m: [at.x, at.y], radius_m, height_m: radius_m * random.random_range(2.0..3.0) };
                    things.push(Thing::tree(&tree, random.random()));
                }
                Surface::Land(land::map(|p| landscape.at(p)))
            }
            Ground::Town(keys) => {
                let town = land::town::Town::new(keys.block_m as f32, &mut random);
                things.extend(town.things(keys, &mut random));
                Surface::Land(land::map(|p| town.at(p)))
            }
            Ground::Water(water) => Surface::Water(Waves::new(water, random.random())),
            Ground::Grass(_) => {
                let meadow = land::apron::Apron::new(0.0, &mut random);
                Surface::Land(land::map(|p| meadow.at(p)))
            }
            Ground::Asphalt(asphalt) => {
                let apron = land::apron::Apron::new(asphalt.side_m as f32, &mut random);
                Surface::Land(land::map(|p| apron.at(p)))
            }
        };
        let to_sun = scene.to_sun();
        things.iter_mut().for_each(|thing| thing.light(&to_sun.map(|v| v as f32)));
        let brightness = scene.brightness as f32;
        let rain = scene.rain.map(|fall| Drops::rain(&fall, brightness, random.random()));
        let snow = scene.snow.map(|fall| Drops::snow(&fall, brightness, random.random()));
        let ground = |p| relief.as_ref().map_or(0.0, |relief| relief.at(p).h);
        let centres = things.iter().map(|thing| thing.centre(0.0, ground)).collect();
        let even = relief.is_none() && !things.iter().any(|thing| thing.is_solid() && thing.is_still());
        Ok(Self {
            surface,
            grain: Grain::new(grain_seed),
            centres,
            even,
            patches: Patches::default(),
            relief,
            things,
            drops: rain.into_iter().chain(snow).collect(),
            to_sun,
            brightness,
            extinction: scene.mist.map_or(0.0, |mist| mist.extinction_per_m),
        })
    }

    /// What the camera sees: radiance, 1 for white ground in full sun at brightness 1.
    pub fn render(&self, shot: &Shot, out: &mut Plane<f32>) {
        self.patches.begin();
        let frame = Frame::new(self, shot, [out.width(), out.height()]);
        let bands = out.as_mut_slice().par_chunks_mut(frame.size[0] * BAND);
        bands.enumerate().for_each(|(band, out)| self.band(&frame, band * BAND, out));
        self.drops.iter().for_each(|drops| drops.draw(shot, out));
    }

    /// The rows of a frame from `first` on.
    fn band(&self, frame: &Frame<'_>, first: usize, out: &mut [f32]) {
        let width = frame.size[0];
        let rows = out.len() / width;
        let compose = |key: Key| self.compose(key);
        let mut patches = AtHand::new(&self.patches, &compose);
        // Edges are found by the rows above and below, too.
        let mut seen: Vec<Seen> = Vec::with_capacity(rows + 2);
        for k in 0..rows + 2 {
            let y = (first + k).saturating_sub(1).min(frame.size[1] - 1);
            let inner = (1..=rows).contains(&k);
            let viewpoint = frame.viewpoint(y);
            let mut here = Seen::new(width, viewpoint);
            if inner || frame.cast.any(y) {
                here.row.aim(&frame.inverse, frame.corrections.as_ref(), &viewpoint.rotation, y);
                self.meet(&mut here.row, &viewpoint, frame.pixel);
            }
            let anchor = viewpoint.origin.xy();
            if inner {
                let out = &mut out[(k - 1) * width..k * width];
                self.lay(frame, &mut here, y, &mut patches);
                veil(&here.ground, &here.row.knots, self.brightness, out);
                self.look(&frame.cast, &mut here, y, &self.grain.near(anchor), Some(out));
            } else {
                self.look(&frame.cast, &mut here, y, &self.grain.near(anchor), None);
            }
            seen.push(here);
        }
        for (k, out) in out.chunks_exact_mut(width).enumerate() {
            let grain = self.grain.near(seen[k + 1].viewpoint.origin.xy());
            let rows = [&seen[k], &seen[k + 1], &seen[k + 2]];
            self.refine(&frame.cast, rows, first + k, &frame.inverse, &grain, out);
        }
    }

    /// The light that the ground along a row sends back.
    fn lay(&self, frame: &Frame<'_>, here: &mut Seen, y: usize, patches: &mut AtHand<'_>) {
        let anchor = here.viewpoint.origin.xy();
        let gain = self.brightest();
        let mut sample = |row: &Row, out: &mut [f32]| sample_patches(row, out, patches, &lattices(anchor), gain);
        match &self.surface {
            Surface::Picture { picture, grain } => {
                let near = self.grain.near(anchor);
                shade_picture(&here.row, &mut here.ground, &picture.near(anchor), *grain, &near);
            }
            Surface::Land(_) => return sample(&here.row, &mut here.ground),
            Surface::Water(waves) => {
                let mirrors = self.mirrors(&here.row);
                shade_water(&here.row, &mut here.ground, &waves.near(anchor, frame.shot.time), &mirrors);
            }
        }
        self.paint(&frame.cast, here, y, frame.pixel as f32);
        if !self.even {
            let mut light = vec![0.0; here.ground.len()];
            sample(&here.row, &mut light);
            here.ground.iter_mut().zip(light).for_each(|(ground, light)| *ground *= light);
        }
    }

    /// Where the centre of a thing is at a time.
    fn centre(&self, thing: &Thing, time: f64) -> Vector3<f64> {
        thing.centre(time, |p| self.relief.as_ref().map_or(0.0, |relief| relief.at(p).h))
    }

    /// Height of the lowest ground, m.
    fn lowest(&self) -> f64 {
        self.relief.as_ref().map_or(0.0, |relief| relief.limits()[0])
    }

    /// Distance, m, from `origin` along a `direction` of length 1 to the first terrain or thing; `None` where nothing
    /// is met within 10 km.
    pub fn range(&self, time: f64, origin: Vector3<f64>, direction: Vector3<f64>) -> Option<f64> {
        let ray = direction.map(|v| v as f32);
        let mut nearest = self.terrain(origin, direction);
        for thing in self.things.iter().filter(|thing| thing.is_solid()) {
            let from = (origin - self.centre(thing, time)).map(|v| v as f32);
            let limit = nearest.map_or(FARTHEST as f32, |range| range as f32);
            if let Some(hit) = thing.hit(&from, &ray, limit) {
                nearest = Some(hit.along.into());
            }
        }
        nearest
    }

    /// The point of the scene that a pixel sees at `time`, m; `None` where it sees nothing.
    pub fn ground(&self, lens: &Lens, pose: &Pose, pixel: Vector2<f64>, time: f64) -> Option<Vector3<f64>> {
        let direction = (pose.attitude.rotation() * lens.direction(pixel)).normalize();
        let range = self.range(time, pose.position, direction)?;
        Some(pose.position + direction * range)
    }

    /// Distance to the terrain, m.
    fn terrain(&self, origin: Vector3<f64>, direction: Vector3<f64>) -> Option<f64> {
        let [low, high] = self.relief.as_ref().map_or([0.0; 2], Relief::limits);
        let top = -origin.z;
        // Above the highest ground and not going down, or below the lowest.
        if direction.z <= 1e-9 || top < low {
            return None;
        }
        let range = match &self.relief {
            None => top / direction.z,
            Some(relief) => {
                let motion = direction.xy() / direction.z;
                let depth = if relief.steepest() * motion.norm() < 0.9 {
                    relief.depth(origin.xy(), top, motion, top, 16)
                } else {
                    march(relief, origin.xy(), top, motion, [(top - high).max(0.0), top - low])?
                };
                depth / direction.z
            }
        };
        (0.0..=FARTHEST).contains(&range).then_some(range)
    }

    /// Where the rays of a row meet the ground, and how it is lit there.
    fn meet(&self, row: &mut Row, viewpoint: &Viewpoint, pixel: f64) {
        let top = -viewpoint.origin.z;
        let from = viewpoint.origin.xy();
        let mut depth = top;
        for k in 0..row.knots.len() {
            let x = k * KNOT;
            let direction = row.direction(x).map(f64::from);
            let down = direction.z.max(DOWNWARDS.into());
            if let Some(relief) = &self.relief {
                let steps = if k == 0 { 12 } else { 2 };
                depth = relief.depth(from, top, direction.xy() / down, depth, steps);
            }
            let range = depth / down * direction.norm();
            row.knots[k] = Knot {
                depth: depth as f32,
                footprint: libm::log2f((depth.max(0.01) / down * pixel) as f32),
                transmission: if self.extinction > 0.0 { libm::expf((-self.extinction * range) as f32) } else { 1.0 },
            };
        }
        land_points(row);
    }

    /// The slope that mirrors the sun into the camera, at each knot.
    fn mirrors(&self, row: &Row) -> Vec<Mirror> {
        let mirror = |k: usize| {
            let to_camera = -row.direction(k * KNOT).map(f64::from).normalize();
            let half = to_camera + self.to_sun;
            // A slope s has its normal along (-s, 1) with height upwards.
            Mirror { slope: [(half.x / half.z) as f32, (half.y / half.z) as f32] }
        };
        (0..row.knots.len()).map(mirror).collect()
    }

    /// Sunlight on a slope relative to level ground, without what the sky gives.
    fn sunlight(&self, slope: [f64; 2]) -> f32 {
        // The normal is (-dh/dX, -dh/dY, 1) with height upwards, and Z is downwards.
        let normal = Vector3::new(-slope[0], -slope[1], -1.0).normalize();
        (normal.dot(&self.to_sun).max(0.0) / -self.to_sun.z) as f32
    }

    /// `T L + (1 - T) air`, at the brightness of the scene.
    #[inline(always)]
    fn radiance(&self, reflected: f32, transmission: f32) -> f32 {
        self.brightness * (AIR_LIGHT + transmission * (reflected - AIR_LIGHT))
    }
}

/// The ground of a row through the mist.
#[multiversion(targets("x86_64+avx2"))]
fn veil(ground: &[f32], knots: &[Knot], brightness: f32, out: &mut [f32]) {
    for ((out, ground), pair) in out.chunks_mut(KNOT).zip(ground.chunks(KNOT)).zip(knots.windows(2)) {
        let (first, slope) = (pair[0].transmission, (pair[1].transmission - pair[0].transmission) / KNOT as f32);
        for (l, (out, ground)) in out.iter_mut().zip(ground).enumerate() {
            *out = brightness * (AIR_LIGHT + (first + l as f32 * slope) * (ground - AIR_LIGHT));
        }
    }
}

/// What is the same for all rows of a frame.
struct Frame<'a> {
    shot: &'a Shot,
    size: [usize; 2],
    inverse: Matrix3<f64>,
    corrections: Option<Corrections>,
    /// Width of a pixel at a distance of 1.
    pixel: f64,
    cast: Cast,
}

impl<'a> Frame<'a> {
    fn new(renderer: &Renderer, shot: &'a Shot, size: [usize; 2]) -> Self {
        let ends = [&Viewpoint::new(&shot.first), &Viewpoint::new(&shot.last)];
        Self {
            shot,
            size,
            inverse: shot.lens.camera.inverse(),
            corrections: Corrections::new(&shot.lens, size[0], size[1]),
            pixel: 1.0 / shot.lens.camera.focal(),
            cast: Cast::new(renderer, shot.time, &shot.lens, ends, size),
        }
    }

    /// Where the camera is at a row.
    fn viewpoint(&self, y: usize) -> Viewpoint {
        let part = if self.size[1] > 1 { y as f64 / (self.size[1] - 1) as f64 } else { 0.0 };
        Viewpoint::new(&self.shot.first.towards(&self.shot.last, part))
    }
}

/// What a scene names one by one.
fn things(scene: &Scene) -> Vec<Thing> {
    let pads = scene.helipad.iter().map(Thing::helipad);
    let buildings = scene.building.iter().map(Thing::building);
    let trees = scene.tree.iter().enumerate().map(|(k, tree)| Thing::tree(tree, k as u32));
    let cars = scene.car.iter().map(|car| Thing::car(car, 0.0));
    pads.chain(buildings).chain(trees).chain(cars).collect()
}

/// Crossing of a ray with a relief between two depths, by steps of half a cell and bisection.
fn march(relief: &Relief, from: Vector2<f64>, top: f64, motion: Vector2<f64>, depths: [f64; 2]) -> Option<f64> {
    let above = |depth: f64| top - depth - relief.at(from + motion * depth).h;
    let step = 0.5 * relief.cell() / motion.norm();
    let [first, last] = depths;
    let (mut before, end) = (first, last.min(first + FARTHEST / motion.norm()));
    if above(before) < 0.0 {
        return None;
    }
    loop {
        let after = (before + step).min(end);
        if above(after) <= 0.0 {
            let (mut high, mut low) = (before, after);
            for _ in 0..40 {
                let middle = 0.5 * (high + low);
                if above(middle) > 0.0 { high = middle } else { low = middle }
            }
            return Some(low);
        }
        if after >= end {
            return None;
        }
        before = after;
    }
}

/// A camera's position and rotation.
#[derive(Clone, Copy)]
struct Viewpoint {
    origin: Vector3<f64>,
    rotation: Matrix3<f64>,
}

impl Viewpoint {
    fn new(pose: &Pose) -> Self {
        Self { origin: pose.position, rotation: pose.attitude.rotation() }
    }
}

/// What is known exactly at every 8th pixel of a row.
#[derive(Debug, Clone, Copy, Default)]
struct Knot {
    depth: f32,
    transmission: f32,
    /// `log2` of the width of a pixel on the ground in m.
    footprint: f32,
}

/// The rays of a row of pixels and where they meet the ground; all lengths are m from below the camera.
struct Row {
    /// Direction of each ray in the world, with 1 along the optical axis; as far as the last knot.
    directions: [Vec<f32>; 3],
    knots: Vec<Knot>,
    x: Vec<[f32; KNOT]>,
    y: Vec<[f32; KNOT]>,
    /// Way along the ray's direction.
    along: Vec<[f32; KNOT]>,
}

impl Row {
    fn new(width: usize) -> Self {
        let knots = (width - 1) / KNOT + 2;
        let rays = (knots - 1) * KNOT + 1;
        let zeros = |count: usize| vec![0f32; count];
        Self {
            directions: [zeros(rays), zeros(rays), zeros(rays)],
            knots: vec![Knot::default(); knots],
            x: vec![[0.0; KNOT]; knots - 1],
            y: vec![[0.0; KNOT]; knots - 1],
            along: vec![[0.0; KNOT]; knots - 1],
        }
    }

    fn aim(&mut self, inverse: &Matrix3<f64>, corrections: Option<&Corrections>, rotation: &Matrix3<f64>, y: usize) {
        let start = inverse * Vector3::new(0.0, y as f64, 1.0);
        aim(&mut self.directions, [start.x, inverse[(0, 0)], start.y], corrections, &rotation.map(|v| v as f32));
    }

    fn direction(&self, x: usize) -> Vector3<f32> {
        let [dx, dy, dz] = &self.directions;
        Vector3::new(dx[x], dy[x], dz[x])
    }
}

/// Rays of a row of normalised coordinates `(start + step x, v)`.
#[multiversion(targets("x86_64+avx2"))]
fn aim(
    directions: &mut [Vec<f32>; 3],
    [start, step, v]: [f64; 3],
    corrections: Option<&Corrections>,
    rotation: &Matrix3<f32>,
) {
    let [dx, dy, dz] = directions;
    let rotation: [[f32; 3]; 3] = (*rotation).into();
    let [a, b, c] = rotation;
    for (x, ((dx, dy), dz)) in dx.iter_mut().zip(dy).zip(dz).enumerate() {
        // f64 along the row keeps the pixel grid regular to 1e-9.
        let (mut u, mut v) = ((start + step * f64::from(x as i32)) as f32, v as f32);
        if let Some(corrections) = corrections {
            let scale = corrections.at(u * u + v * v);
            (u, v) = (u * scale, v * scale);
        }
        *dx = a[0] * u + b[0] * v + c[0];
        *dy = a[1] * u + b[1] * v + c[1];
        *dz = a[2] * u + b[2] * v + c[2];
    }
}

/// Points on the ground between the knots.
#[multiversion(targets("x86_64+avx2"))]
fn land_points(row: &mut Row) {
    let [dx, dy, dz] = &row.directions;
    let directions = dx.chunks_exact(KNOT).zip(dy.chunks_exact(KNOT)).zip(dz.chunks_exact(KNOT));
    let points = row.along.iter_mut().zip(row.x.iter_mut().zip(&mut row.y));
    for ((pair, ((dx, dy), dz)), (along, (x, y))) in row.knots.windows(2).zip(directions).zip(points) {
        let (first, slope) = (pair[0].depth, (pair[1].depth - pair[0].depth) * (1.0 / KNOT as f32));
        for l in 0..KNOT {
            let depth = (first + l as f32 * slope).max(0.01);
            along[l] = depth / dz[l].max(DOWNWARDS);
            x[l] = dx[l] * along[l];
            y[l] = dy[l] * along[l];
        }
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn shade_picture(row: &Row, out: &mut [f32], picture: &Near<'_, u16, 1, MIRRORED>, weight: f32, grain: &NearGrain<'_>) {
    for (k, out) in out.chunks_mut(KNOT).enumerate() {
        let (x, y, footprint) = (&row.x[k], &row.y[k], row.knots[k].footprint);
        let mut albedo = picture.sample(x, y, footprint);
        if weight > 0.0 {
            let fine = grain.sample(x, y, footprint);
            for l in 0..KNOT {
                albedo[l][0] *= (1.0 + weight * 0.7 * (fine[l][GREEN] + fine[l][HARD])).max(0.0);
            }
        }
        for (out, [albedo]) in out.iter_mut().zip(albedo) {
            *out = albedo;
        }
    }
}

/// The light of composed ground.
#[multiversion(targets("x86_64+avx2"))]
fn sample_patches(row: &Row, out: &mut [f32], patches: &mut AtHand<'_>, lattices: &[Lattice], gain: f32) {
    for (k, out) in out.chunks_mut(KNOT).enumerate() {
        let light = patches.sample(lattices, &row.x[k], &row.y[k], row.knots[k].footprint);
        for l in 0..out.len() {
            out[l] = gain * light[l];
        }
    }
}

/// Albedo of a line of points with one `y`, seen by pixels of `2^footprint` m.
#[multiversion(targets("x86_64+avx2"))]
fn ground_row(
    x: &[[f32; KNOT]],
    y: f32,
    footprint: f32,
    land: &Near<'_, u32, 4, MIRRORED>,
    grain: &NearGrain<'_>,
    out: &mut [[f32; KNOT]],
) {
    for (x, out) in x.iter().zip(out) {
        let material = land.sample(x, &[y; KNOT], footprint);
        let fine = grain.sample(x, &[y; KNOT], footprint);
        for (out, (material, fine)) in out.iter_mut().zip(material.into_iter().zip(fine)) {
            *out = ground_albedo(&land::material(material), fine);
        }
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn shade_water(row: &Row, out: &mut [f32], waves: &NearWaves<'_>, mirrors: &[Mirror]) {
    for (k, out) in out.chunks_mut(KNOT).enumerate() {
        let radiance = waves.radiance(&row.x[k], &row.y[k], row.knots[k].footprint, [mirrors[k], mirrors[k + 1]]);
        for (out, radiance) in out.iter_mut().zip(radiance) {
            *out = radiance;
        }
    }
}

#[inline(always)]
fn ground_albedo(material: &Material, fine: [f32; 4]) -> f32 {
    let [green, soil, hard] = material.grain;
    material.albedo * (1.0 + green * fine[GREEN] + soil * fine[SOIL] + hard * fine[HARD]).max(0.05)
}
