//! Scene files: ground, relief, objects on the ground, sun and weather, as TOML that users write.
//!
//! Every key with a dimension has its unit in its name; `edss/README.md` lists all keys. A key that is unknown, of the
//! wrong type or out of range is an error with its line, so that no part of a scene is ignored.

mod check;
mod kind;

use std::path::{Path, PathBuf};

use nalgebra::Vector2;
use serde::Deserialize;

pub use check::SceneError;

/// A scene, parsed and checked.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    pub(crate) ground: Ground,
    #[serde(default)]
    pub(crate) relief: Option<Relief>,
    #[serde(default)]
    pub(crate) sun: Sun,
    #[serde(default = "one")]
    pub(crate) brightness: f64,
    #[serde(default)]
    pub(crate) mist: Option<Mist>,
    #[serde(default)]
    pub(crate) rain: Option<Fall>,
    #[serde(default)]
    pub(crate) snow: Option<Fall>,
    #[serde(default)]
    pub(crate) building: Vec<Building>,
    #[serde(default)]
    pub(crate) tree: Vec<Tree>,
    #[serde(default)]
    pub(crate) car: Vec<Car>,
    #[serde(default)]
    pub(crate) helipad: Vec<Helipad>,
}

fn one() -> f64 {
    1.0
}

/// The kind of ground.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Ground {
    Picture(PictureGround),
    Field(Field),
    Town(Town),
    Asphalt(Asphalt),
    Grass(Grass),
    Water(Water),
}

/// A picture placed on the ground, its middle at the origin, columns along `X_e`, mirrored at its borders.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PictureGround {
    pub file: PathBuf,
    pub texel_m: f64,
    /// Amount of fine structure added, relative to the brightness.
    #[serde(default)]
    pub grain: f64,
}

/// Parcels of about `parcel_m`, tracks between them, trees along their edges.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Field {
    #[serde(default = "Field::parcel")]
    pub parcel_m: f64,
    #[serde(default)]
    pub trees: u32,
}

impl Field {
    fn parcel() -> f64 {
        40.0
    }
}

/// Blocks of about `block_m` between streets, with houses, gardens, trees and cars.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Town {
    #[serde(default = "Town::block")]
    pub block_m: f64,
    #[serde(default)]
    pub trees: u32,
    #[serde(default)]
    pub moving_cars: u32,
    #[serde(default)]
    pub parked_cars: u32,
}

impl Town {
    fn block() -> f64 {
        62.0
    }
}

/// A paved square with grass around it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Asphalt {
    pub side_m: f64,
}

/// A meadow without borders.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Grass {}

/// Waves of about `wave_m` and shorter that run downwind, with an rms slope of `slope`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Water {
    #[serde(default = "Water::wave")]
    pub wave_m: f64,
    #[serde(default = "Water::slope")]
    pub slope: f64,
    #[serde(default)]
    pub wind_to_deg: f64,
}

impl Water {
    fn wave() -> f64 {
        6.0
    }

    /// Cox and Munk (1954): mean square slope 0.003 + 0.00512 U, here for a wind of 4 m/s.
    fn slope() -> f64 {
        0.15
    }
}

/// Heights of the ground about its mean.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Relief {
    Hills(Hills),
    Map(HeightMap),
}

/// Smooth hills, `octaves` of them, each half as long as the one before.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Hills {
    pub rms_m: f64,
    pub wavelength_m: f64,
    #[serde(default = "Hills::octaves")]
    pub octaves: u32,
}

impl Hills {
    fn octaves() -> u32 {
        3
    }
}

/// A picture whose black and white are `height_m` apart, its mean at `Z = 0`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct HeightMap {
    pub file: PathBuf,
    pub texel_m: f64,
    pub height_m: f64,
}

/// The direction of the sun: azimuth from `X_e` towards `Y_e`, elevation over the horizon.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Sun {
    pub azimuth_deg: f64,
    pub elevation_deg: f64,
}

impl Default for Sun {
    fn default() -> Self {
        Self { azimuth_deg: 300.0, elevation_deg: 45.0 }
    }
}

/// Mist, as extinction along the ray.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Mist {
    pub extinction_per_m: f64,
}

/// Rain or snow, as drops or flakes per cubic metre of air.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Fall {
    pub per_m3: f64,
}

/// A box with a roof; `size_m` is along and across `yaw_deg`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Building {
    pub at_m: [f64; 2],
    pub size_m: [f64; 2],
    pub height_m: f64,
    #[serde(default)]
    pub yaw_deg: f64,
    #[serde(default)]
    pub roof: Roof,
}

/// The form of a roof.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Roof {
    #[default]
    Flat,
    Gable,
}

/// A tree, as a crown of leaves.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Tree {
    pub at_m: [f64; 2],
    pub radius_m: f64,
    pub height_m: f64,
}

/// A car that drives from one point to another, again and again.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Car {
    pub from_m: [f64; 2],
    pub to_m: [f64; 2],
    pub speed_m_per_s: f64,
}

/// A disc with a ring and an H, painted on the ground; `heading_deg` is the upright of the H.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Helipad {
    pub at_m: [f64; 2],
    pub diameter_m: f64,
    #[serde(default)]
    pub heading_deg: f64,
}

impl Scene {
    /// The names of the built-in scenes.
    pub const NAMES: [&str; 5] = ["field", "town", "helipad-in-mist", "open-water", "aerial"];

    /// Returns the TOML text of the built-in scene `name`; `None` if the name is not in [`Scene::NAMES`].
    pub fn named(name: &str) -> Option<&'static str> {
        match name {
            "field" => Some(include_str!("../scenes/field.toml")),
            "town" => Some(include_str!("../scenes/town.toml")),
            "helipad-in-mist" => Some(include_str!("../scenes/helipad-in-mist.toml")),
            "open-water" => Some(include_str!("../scenes/open-water.toml")),
            "aerial" => Some(include_str!("../scenes/aerial.toml")),
            _ => None,
        }
    }

    /// Parses and checks the text of a scene. Picture files are searched in `folder`, then among the photographs that
    /// `make demo` fetches.
    ///
    /// # Errors
    /// If the text has an error; the message starts with its line, and the caller puts the file name before it.
    pub fn parse(text: &str, folder: &Path) -> Result<Self, SceneError> {
        check::parse(text, None, folder)
    }

    /// Parses and checks the scene in the table `key` of a text, as [`Scene::parse`] does. Lines are those of the text.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub fn parse_table(text: &str, key: &str, folder: &Path) -> Result<Self, SceneError> {
        check::parse(text, Some(key), folder)
    }

    /// Returns the paths of the picture files that the scene is made from.
    pub fn pictures(&self) -> Vec<&Path> {
        let ground = match &self.ground {
            Ground::Picture(picture) => Some(picture.file.as_path()),
            _ => None,
        };
        let relief = match &self.relief {
            Some(Relief::Map(map)) => Some(map.file.as_path()),
            _ => None,
        };
        [ground, relief].into_iter().flatten().collect()
    }

    /// Returns the scene with empty paths of its picture files.
    pub fn without_paths(&self) -> Self {
        let mut scene = self.clone();
        if let Ground::Picture(picture) = &mut scene.ground {
            picture.file = PathBuf::new();
        }
        if let Some(Relief::Map(map)) = &mut scene.relief {
            map.file = PathBuf::new();
        }
        scene
    }

    /// Returns the direction to the sun, of length 1.
    pub(crate) fn to_sun(&self) -> nalgebra::Vector3<f64> {
        let (sa, ca) = libm::sincos(self.sun.azimuth_deg.to_radians());
        let (se, ce) = libm::sincos(self.sun.elevation_deg.to_radians());
        nalgebra::Vector3::new(ca * ce, sa * ce, -se)
    }
}

/// Converts a pair of coordinates into a point on the ground, m.
pub(crate) fn point(at: [f64; 2]) -> Vector2<f64> {
    Vector2::new(at[0], at[1])
}
