//! The renderer: `radiance = T albedo light + (1 - T) air`, one ray a pixel, filtered textures.
//!
//! The ray of a pixel is intersected with level ground in closed form, or with the relief by Newton's iteration at
//! every 8th pixel of a row and linear interpolation between. The brightness of the ground comes from textures filtered
//! in advance for every distance (`mip`), so that one sample a pixel is enough; only edges of objects are sampled
//! more often. The static part of the ground is composed once and kept (`patch`). Illumination is Lambertian on the
//! slope of the ground. Mist reduces contrast along the ray by `T = exp(-b r)` (Koschmieder 1924).
//!
//! | module | its one job |
//! |---|---|
//! | `view` | converts pixels to rays and back |
//! | `row` | the rays of a row of pixels |
//! | `rays` | intersections of rays with the ground and objects |
//! | `shade` | light of the sun and the sky, and mist |
//! | `mip` | textures filtered in advance for every distance |
//! | `noise` | gradient noise |
//! | `grain` | fine structure of the ground |
//! | `land` | larger structure of the ground |
//! | `relief` | height of the ground |
//! | `patch` | storage for composed ground, kept between frames |
//! | `compose` | composes a patch of ground |
//! | `object` | objects on the ground: buildings, trees, cars, paint |
//! | `bundle` | eight rays at once |
//! | `crown` | the balls of a tree's crown |
//! | `water` | waves and glint |
//! | `fall` | rain and snow |
//! | `overlay` | draws objects, their edges and shadows |
//!
//! A frame is a function of scene, seed and shot. Rows are computed independently, and patches do not depend on earlier
//! frames, so a frame has the same bits for every number of threads.

mod bundle;
mod compose;
mod crown;
mod fall;
mod grain;
mod land;
mod mip;
mod noise;
mod object;
mod overlay;
mod patch;
mod rays;
mod relief;
mod row;
mod shade;
mod view;
mod water;

use hoverlock_pictures::{Picture, PictureError};
use hoverlock_reference::image::plane::Plane;
use nalgebra::{Matrix3, Vector2, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::pose::Pose;
use crate::random::{Purpose, stream};
use crate::scene::{Ground, Scene, Tree};
use fall::Drops;
use grain::Grain;
use mip::{MIRRORED, Mip, PlacedTexture};
use object::Object;
use overlay::{BAND_ROWS, ObjectTiles, RowView};
use patch::{BandPatches, Key, PatchStore, lattices};
use relief::Relief;
use row::{Row, Viewpoint};
use shade::{apply_mist, sample_patches, shade_picture, shade_water};
use view::Corrections;
pub use view::Lens;
use water::Waves;

/// The camera, its motion and the time of one exposure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shot {
    /// Camera and lens distortion.
    pub lens: Lens,
    /// Pose of the camera at the first row.
    pub first: Pose,
    /// Pose at the last row; the same as `first` for a global shutter.
    pub last: Pose,
    /// Time since the start of the scene, s.
    pub time: f64,
}

/// The reason why a scene cannot be rendered.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// A picture file of the scene cannot be read.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// All pixels of the ground picture are equal, so it has no features.
    #[error("ground.picture.file: {0}: every pixel has the same value; name a picture of the ground")]
    NoContrast(String),
    /// Slopes of the relief would hide parts of the ground from the camera.
    #[error(
        "relief: slopes up to {slope:.2} are too steep: at most 1; lower rms_m or height_m, or lengthen wavelength_m"
    )]
    TooSteep {
        /// Largest slope of the relief, m/m.
        slope: f64,
    },
}

/// A scene prepared for rendering: textures with their filtered levels, heights, objects.
pub struct Renderer {
    surface: Surface,
    grain: Grain,
    relief: Option<Relief>,
    objects: Vec<Object>,
    /// Centre of each object at time 0, m.
    centres: Vec<Vector3<f64>>,
    /// The ground is level and no static object casts a shadow on it.
    evenly_lit: bool,
    patches: PatchStore,
    /// Rain and snow.
    drops: Vec<Drops>,
    to_sun: Vector3<f64>,
    brightness: f32,
    /// Extinction of the mist, 1/m.
    extinction: f64,
}

/// The source of the ground's brightness.
enum Surface {
    Picture { picture: PlacedTexture<u16, 1, MIRRORED>, grain: f32 },
    Land(PlacedTexture<u32, 4, MIRRORED>),
    Water(Waves),
}

impl Surface {
    /// Prepares the textures of the ground, and appends the generated buildings, trees and cars to `objects`.
    fn new(ground: &Ground, objects: &mut Vec<Object>, random: &mut ChaCha8Rng) -> Result<Self, RenderError> {
        Ok(match ground {
            Ground::Picture(ground) => {
                let luma = Picture::open(&ground.file)?.luma;
                let (width, height) = (luma.width(), luma.height());
                if luma.as_slice().iter().all(|value| *value == luma.as_slice()[0]) {
                    return Err(RenderError::NoContrast(ground.file.display().to_string()));
                }
                let middle = Vector2::new(width as f64, height as f64) / 2.0;
                let picture = PlacedTexture::new(Mip::new(width, height, luma.as_slice()), ground.texel_m, 0.0, middle);
                Self::Picture { picture, grain: ground.grain as f32 }
            }
            Ground::Field(field) => {
                let landscape = land::field::Landscape::new(field.parcel_m as f32, random);
                for at in landscape.edges(random, field.trees as usize) {
                    let radius_m = random.random_range(1.4..3.6);
                    let tree =
                        Tree { at_m: [at.x, at.y], radius_m, height_m: radius_m * random.random_range(2.0..3.0) };
                    objects.push(Object::tree(&tree, random.random()));
                }
                Self::Land(land::map(|p| landscape.at(p)))
            }
            Ground::Town(keys) => {
                let town = land::town::Town::new(keys.block_m as f32, random);
                objects.extend(town.objects(keys, random));
                Self::Land(land::map(|p| town.at(p)))
            }
            Ground::Water(water) => Self::Water(Waves::new(water, random.random())),
            Ground::Grass(_) => {
                let meadow = land::apron::Apron::new(0.0, random);
                Self::Land(land::map(|p| meadow.at(p)))
            }
            Ground::Asphalt(asphalt) => {
                let apron = land::apron::Apron::new(asphalt.side_m as f32, random);
                Self::Land(land::map(|p| apron.at(p)))
            }
        })
    }
}

impl Renderer {
    /// Prepares a scene. Everything random in it follows from `seed`.
    ///
    /// # Errors
    /// If a picture cannot be read, the ground picture has no contrast, or the relief is too steep.
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
            return Err(RenderError::TooSteep { slope });
        }
        let mut objects = listed_objects(scene);
        let surface = Surface::new(&scene.ground, &mut objects, &mut random)?;
        let to_sun = scene.to_sun();
        objects.iter_mut().for_each(|object| object.set_sun(&to_sun.map(|v| v as f32)));
        let brightness = scene.brightness as f32;
        let rain = scene.rain.map(|fall| Drops::rain(&fall, brightness, random.random()));
        let snow = scene.snow.map(|fall| Drops::snow(&fall, brightness, random.random()));
        let ground = |p| relief.as_ref().map_or(0.0, |relief| relief.at(p).h);
        let centres = objects.iter().map(|object| object.centre(0.0, ground)).collect();
        let evenly_lit = relief.is_none() && !objects.iter().any(|object| object.is_solid() && object.is_static());
        Ok(Self {
            surface,
            grain: Grain::new(grain_seed),
            centres,
            evenly_lit,
            patches: PatchStore::default(),
            relief,
            objects,
            drops: rain.into_iter().chain(snow).collect(),
            to_sun,
            brightness,
            extinction: scene.mist.map_or(0.0, |mist| mist.extinction_per_m),
        })
    }

    /// Renders a frame into `out` as radiance, relative to white ground in full sun at brightness 1.
    pub fn render(&self, shot: &Shot, out: &mut Plane<f32>) {
        self.patches.begin();
        let frame = Frame::new(self, shot, [out.width(), out.height()]);
        let bands = out.as_mut_slice().par_chunks_mut(frame.size[0] * BAND_ROWS);
        bands.enumerate().for_each(|(band, out)| self.render_band(&frame, band * BAND_ROWS, out));
        self.drops.iter().for_each(|drops| drops.draw(shot, out));
    }

    /// Renders the rows of a band, of which `first` is the first.
    fn render_band(&self, frame: &Frame<'_>, first: usize, out: &mut [f32]) {
        let width = frame.size[0];
        let rows = out.len() / width;
        let compose = |key: Key| self.compose(key);
        let mut patches = BandPatches::new(&self.patches, &compose);
        // The search for edges needs the rows above and below, too.
        let mut seen: Vec<RowView> = Vec::with_capacity(rows + 2);
        for k in 0..rows + 2 {
            let y = (first + k).saturating_sub(1).min(frame.size[1] - 1);
            let inner = (1..=rows).contains(&k);
            let viewpoint = frame.viewpoint(y);
            let mut here = RowView::new(width, viewpoint);
            if inner || frame.tiles.any(y) {
                here.row.aim(&frame.inverse, frame.corrections.as_ref(), &viewpoint.rotation, y);
                self.intersect_row(&mut here.row, &viewpoint, frame.pixel);
            }
            let anchor = viewpoint.origin.xy();
            if inner {
                let out = &mut out[(k - 1) * width..k * width];
                self.light_ground(frame, &mut here, y, &mut patches);
                apply_mist(&here.ground, &here.row.knots, self.brightness, out);
                self.draw_objects(&frame.tiles, &mut here, y, &self.grain.local(anchor), Some(out));
            } else {
                self.draw_objects(&frame.tiles, &mut here, y, &self.grain.local(anchor), None);
            }
            seen.push(here);
        }
        for (k, out) in out.chunks_exact_mut(width).enumerate() {
            let grain = self.grain.local(seen[k + 1].viewpoint.origin.xy());
            let rows = [&seen[k], &seen[k + 1], &seen[k + 2]];
            self.antialias(&frame.tiles, rows, first + k, &frame.inverse, &grain, out);
        }
    }

    /// Computes the light reflected by the ground along a row, relative to white ground in full sun.
    fn light_ground(&self, frame: &Frame<'_>, here: &mut RowView, y: usize, patches: &mut BandPatches<'_>) {
        let anchor = here.viewpoint.origin.xy();
        let gain = self.full_scale_light();
        let mut sample = |row: &Row, out: &mut [f32]| sample_patches(row, out, patches, &lattices(anchor), gain);
        match &self.surface {
            Surface::Picture { picture, grain } => {
                let near = self.grain.local(anchor);
                shade_picture(&here.row, &mut here.ground, &picture.local(anchor), *grain, &near);
            }
            Surface::Land(_) => return sample(&here.row, &mut here.ground),
            Surface::Water(waves) => {
                let mirrors = self.sun_reflections(&here.row);
                shade_water(&here.row, &mut here.ground, &waves.local(anchor, frame.shot.time), &mirrors);
            }
        }
        self.paint(&frame.tiles, here, y, frame.pixel as f32);
        if !self.evenly_lit {
            let mut light = vec![0.0; here.ground.len()];
            sample(&here.row, &mut light);
            here.ground.iter_mut().zip(light).for_each(|(ground, light)| *ground *= light);
        }
    }

    /// Returns the centre of an object at a time, m.
    fn centre(&self, object: &Object, time: f64) -> Vector3<f64> {
        object.centre(time, |p| self.relief.as_ref().map_or(0.0, |relief| relief.at(p).h))
    }

    /// Returns the height of the lowest ground, m.
    fn lowest_ground(&self) -> f64 {
        self.relief.as_ref().map_or(0.0, |relief| relief.limits()[0])
    }
}

/// The quantities that all rows of a frame share.
struct Frame<'a> {
    shot: &'a Shot,
    size: [usize; 2],
    inverse: Matrix3<f64>,
    corrections: Option<Corrections>,
    /// Width of a pixel at a distance of 1 along the optical axis.
    pixel: f64,
    tiles: ObjectTiles,
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
            tiles: ObjectTiles::new(renderer, shot.time, &shot.lens, ends, size),
        }
    }

    /// Returns position and rotation of the camera at row `y`.
    fn viewpoint(&self, y: usize) -> Viewpoint {
        let part = if self.size[1] > 1 { y as f64 / (self.size[1] - 1) as f64 } else { 0.0 };
        Viewpoint::new(&self.shot.first.interpolate(&self.shot.last, part))
    }
}

/// Creates the objects that the scene file lists individually.
fn listed_objects(scene: &Scene) -> Vec<Object> {
    let pads = scene.helipad.iter().map(Object::helipad);
    let buildings = scene.building.iter().map(Object::building);
    let trees = scene.tree.iter().enumerate().map(|(k, tree)| Object::tree(tree, k as u32));
    let cars = scene.car.iter().map(|car| Object::car(car, 0.0));
    pads.chain(buildings).chain(trees).chain(cars).collect()
}
