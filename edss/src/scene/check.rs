//! Parsing and checking of scene files; every error has the line of its key.

use std::path::{Path, PathBuf};

use hoverlock_pictures::{Limits, PictureFile, demo_dir};
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use super::{Ground, Relief, Scene};
use crate::{strict, toml_text};

/// An error in a scene file, shown as `line N: KEY: why`.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("line {line}: {key}{}{why}", if key.is_empty() { "" } else { ": " })]
pub struct SceneError {
    /// Line number, from 1.
    pub line: usize,
    /// Key with its tables, such as `relief.hills.rms_m`; empty if the file is not valid TOML.
    pub key: String,
    /// Description of the error and of the valid values.
    pub why: String,
}

/// Smallest number of columns and rows of a map of heights, whose slopes are those between neighbours.
const MIN_MAP_SIDE: usize = 2;

/// Largest number of objects of one kind in a scene.
const MAX_OBJECTS: usize = 2000;

/// Parses the scene in the table `key` of a text, or in the whole text.
pub(super) fn parse(text: &str, key: Option<&str>, folder: &Path) -> Result<Scene, SceneError> {
    let refused =
        |offset: usize, key: String, why: String| SceneError { line: toml_text::line(text, offset), key, why };
    let document = DeTable::parse(text).map_err(|error| {
        refused(error.span().map_or(0, |span| span.start), String::new(), toml_text::message(&error))
    })?;
    let document = Spanned::new(document.span(), DeValue::Table(document.into_inner()));
    let root = key.and_then(|key| document.get_ref().get(key)).unwrap_or(&document);
    let (begin, empty) = (root.span().start, DeTable::new());
    let table = root.get_ref().as_table().unwrap_or(&empty);
    // A key of the text: that of the scene, if it has one, and the key within.
    let named = |inner: String| match key {
        Some(key) if inner.is_empty() => key.to_owned(),
        Some(key) => format!("{key}.{inner}"),
        None => inner,
    };
    let mut scene: Scene = strict::deserialize(ValueDeserializer::from(root.clone())).map_err(|error| {
        let start = error.span().map_or(begin, |span| span.start);
        // A missing table concerns the whole scene and not its first key.
        let whole = start == begin && error.message().starts_with("missing");
        let inner = if whole { String::new() } else { toml_text::key_at(table, start) };
        refused(start, named(inner), toml_text::message(&error))
    })?;
    match check(&mut scene, folder) {
        Ok(()) => Ok(scene),
        Err(Violation { path, why }) => Err(refused(offset_of(table, begin, &path), named(path.join(".")), why)),
    }
}

struct Violation {
    path: Vec<String>,
    why: String,
}

/// Returns the byte offset of the value at a path of keys and indices, or of the last table on the way that exists. The
/// first table begins at `begin`.
fn offset_of(table: &DeTable<'_>, begin: usize, path: &[String]) -> usize {
    let mut offset = begin;
    let mut tables = Some(table);
    let mut array = None;
    for step in path {
        let value = match (tables, array) {
            (Some(table), _) => match table.get_key_value(step.as_str()) {
                Some((key, value)) => {
                    offset = key.span().start;
                    value
                }
                None => return offset,
            },
            (_, Some(values)) => {
                let values: &toml::de::DeArray<'_> = values;
                let Some(value) = step.parse().ok().and_then(|index: usize| values.get(index)) else { return offset };
                offset = value.span().start;
                value
            }
            _ => return offset,
        };
        (tables, array) = (value.get_ref().as_table(), value.get_ref().as_array());
    }
    offset
}

type CheckResult = Result<(), Violation>;

fn path_of(path: &str) -> Vec<String> {
    path.split('.').map(str::to_owned).collect()
}

fn within(path: &str, value: f64, least: f64, most: f64) -> CheckResult {
    // Not-a-number fails both comparisons.
    let passes = value >= least && value <= most;
    let why = || format!("{value} is out of range: {least} to {most}");
    if passes { Ok(()) } else { Err(Violation { path: path_of(path), why: why() }) }
}

fn point_within(path: &str, at: [f64; 2]) -> CheckResult {
    at.iter().enumerate().try_for_each(|(i, &value)| within(&format!("{path}.{i}"), value, -10_000.0, 10_000.0))
}

fn check(scene: &mut Scene, folder: &Path) -> CheckResult {
    match &mut scene.ground {
        Ground::Picture(picture) => {
            within("ground.picture.texel_m", picture.texel_m, 1e-4, 10.0)?;
            within("ground.picture.grain", picture.grain, 0.0, 1.0)?;
            find("ground.picture.file", &mut picture.file, 1, folder)?;
        }
        Ground::Field(field) => {
            within("ground.field.parcel_m", field.parcel_m, 10.0, 100.0)?;
            within("ground.field.trees", field.trees.into(), 0.0, MAX_OBJECTS as f64)?;
        }
        Ground::Town(town) => {
            within("ground.town.block_m", town.block_m, 40.0, 100.0)?;
            let counts = [("trees", town.trees), ("moving_cars", town.moving_cars), ("parked_cars", town.parked_cars)];
            for (key, count) in counts {
                within(&format!("ground.town.{key}"), count.into(), 0.0, MAX_OBJECTS as f64)?;
            }
        }
        Ground::Asphalt(asphalt) => within("ground.asphalt.side_m", asphalt.side_m, 0.0, 10_000.0)?,
        Ground::Grass(_) => {}
        Ground::Water(water) => {
            within("ground.water.wave_m", water.wave_m, 0.5, 100.0)?;
            within("ground.water.slope", water.slope, 0.01, 0.5)?;
            within("ground.water.wind_to_deg", water.wind_to_deg, -360.0, 360.0)?;
        }
    }
    match &mut scene.relief {
        None => {}
        Some(Relief::Hills(hills)) => {
            within("relief.hills.rms_m", hills.rms_m, 0.0, 50.0)?;
            within("relief.hills.wavelength_m", hills.wavelength_m, 10.0, 10_000.0)?;
            within("relief.hills.octaves", hills.octaves.into(), 1.0, 5.0)?;
        }
        Some(Relief::Map(map)) => {
            within("relief.map.texel_m", map.texel_m, 0.01, 1000.0)?;
            within("relief.map.height_m", map.height_m, 0.0, 200.0)?;
            find("relief.map.file", &mut map.file, MIN_MAP_SIDE, folder)?;
        }
    }
    within("sun.azimuth_deg", scene.sun.azimuth_deg, -360.0, 360.0)?;
    within("sun.elevation_deg", scene.sun.elevation_deg, 5.0, 90.0)?;
    within("brightness", scene.brightness, 0.0, 10.0)?;
    if let Some(mist) = scene.mist {
        within("mist.extinction_per_m", mist.extinction_per_m, 0.0, 1.0)?;
    }
    for (key, fall) in [("rain", scene.rain), ("snow", scene.snow)] {
        if let Some(fall) = fall {
            within(&format!("{key}.per_m3"), fall.per_m3, 0.0, 200.0)?;
        }
    }
    check_objects(scene)
}

fn check_objects(scene: &Scene) -> CheckResult {
    let counts = [
        ("building", scene.building.len()),
        ("tree", scene.tree.len()),
        ("car", scene.car.len()),
        ("helipad", scene.helipad.len()),
    ];
    for (key, count) in counts {
        if count > MAX_OBJECTS {
            return Err(Violation {
                path: vec![key.into()],
                why: format!("{count} are too many: at most {MAX_OBJECTS}"),
            });
        }
    }
    for (i, building) in scene.building.iter().enumerate() {
        point_within(&format!("building.{i}.at_m"), building.at_m)?;
        for side in 0..2 {
            within(&format!("building.{i}.size_m.{side}"), building.size_m[side], 0.1, 500.0)?;
        }
        within(&format!("building.{i}.height_m"), building.height_m, 0.05, 200.0)?;
        within(&format!("building.{i}.yaw_deg"), building.yaw_deg, -360.0, 360.0)?;
    }
    for (i, tree) in scene.tree.iter().enumerate() {
        point_within(&format!("tree.{i}.at_m"), tree.at_m)?;
        within(&format!("tree.{i}.radius_m"), tree.radius_m, 0.1, 20.0)?;
        within(&format!("tree.{i}.height_m"), tree.height_m, 0.2, 60.0)?;
    }
    for (i, car) in scene.car.iter().enumerate() {
        point_within(&format!("car.{i}.from_m"), car.from_m)?;
        point_within(&format!("car.{i}.to_m"), car.to_m)?;
        within(&format!("car.{i}.speed_m_per_s"), car.speed_m_per_s, 0.0, 100.0)?;
        if car.from_m == car.to_m {
            let path = path_of(&format!("car.{i}.to_m"));
            return Err(Violation {
                path,
                why: "must differ from from_m: a standing car has speed_m_per_s = 0".into(),
            });
        }
    }
    for (i, pad) in scene.helipad.iter().enumerate() {
        point_within(&format!("helipad.{i}.at_m"), pad.at_m)?;
        within(&format!("helipad.{i}.diameter_m"), pad.diameter_m, 1.0, 100.0)?;
        within(&format!("helipad.{i}.heading_deg"), pad.heading_deg, -360.0, 360.0)?;
    }
    Ok(())
}

/// Replaces the name of a picture file by its path, and checks its header. The picture has at least `min_side` columns
/// and rows.
fn find(path: &str, file: &mut PathBuf, min_side: usize, folder: &Path) -> CheckResult {
    let refuse = |why: String| Err(Violation { path: path_of(path), why });
    let fetched = demo_dir().map(|pictures| pictures.join(&*file));
    let Some(found) = [Some(folder.join(&*file)), fetched].into_iter().flatten().find(|path| path.is_file()) else {
        return refuse(format!(
            "{} is neither in {} nor among the photographs that `make demo` fetches: name a picture or run it",
            file.display(),
            if folder.as_os_str().is_empty() { Path::new(".") } else { folder }.display(),
        ));
    };
    match PictureFile::open(&found, &Limits::default()).and_then(|picture| picture.require(min_side, min_side)) {
        Ok(_) => *file = found,
        Err(error) => return refuse(error.to_string()),
    }
    Ok(())
}
