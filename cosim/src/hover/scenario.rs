//! Scenario files: a flight with its faults and commands, as TOML.
//!
//! ```toml
//! scene = "road.toml"
//! seconds = 12.0
//!
//! [[event]]
//! t = 4.0
//! event = "black"
//! seconds = 2.0
//! ```
//!
//! Keys beside `scene` and `event` replace the settings of the same name: `seconds`, `seed`, `height_m`, `gusts_m_s`,
//! `altitude`, `view`. A scene that is not built in is searched beside the scenario; a table `[scene]` is a scene
//! itself. `[camera]` has errors of the camera, and `[calibration]` what the flight program knows of them
//! ([`crate::sequence::calibration`]).

use std::f64::consts::TAU;
use std::fmt::{self, Display, Formatter};
use std::path::Path;

use hoverlock_arm::calibration::Calibration;
use hoverlock_arm::message::Command;
use hoverlock_edss::camera::{FIELD_OF_VIEW_RANGE_DEG, FRAME_RATE, FRAME_SIZE, Optics};
use hoverlock_edss::flight::Altitude;
use hoverlock_edss::obstruction::{Effect, Obstruction, Spot};
use hoverlock_edss::render::Lens;
use hoverlock_edss::scene::Scene;
use hoverlock_edss::{strict, toml_text};
use hoverlock_reference::motion::orthophoto::{Attitude, Camera};
use nalgebra::Vector3;
use serde::de::{IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use super::{CameraView, HoverSettings};
use crate::chain::Delivery;
use crate::toml_file::{SCENARIO, TomlFileError};

/// Errors of the camera. The flight program knows of them what a calibration says.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CameraErrors {
    /// Radial distortion of the lens, of normalised coordinates (Brown 1966): -1 to 1, and not so small that the lens
    /// folds within the widest view ([`Lens::min_k1`]).
    pub k1: f64,
    /// Time from the read-out of the first row to that of the last, s: 0 to 0.1.
    pub readout_s: f64,
    /// Relative error of the focal length in the telemetry: -0.1 to 0.1.
    pub focal: f64,
    /// Roll, pitch and yaw of the camera relative to the inertial sensor, degrees: -5 to 5 each.
    pub boresight_deg: [f64; 3],
    /// Time by which frames are stamped late, s: 0 to 0.1.
    pub delay_s: f64,
    /// Specks of dust on the sensor: 0 to 10000.
    pub specks: u32,
}

impl CameraErrors {
    /// Returns the first value that is out of range.
    fn invalid(&self) -> Option<OutOfRange> {
        let Self { k1, readout_s, focal, boresight_deg, delay_s, specks } = *self;
        let limits: [(_, &[f64], _, _); 6] = [
            ("k1", &[k1], -1.0, 1.0),
            ("readout_s", &[readout_s], 0.0, 0.1),
            ("focal", &[focal], -0.1, 0.1),
            ("delay_s", &[delay_s], 0.0, 0.1),
            ("specks", &[specks.into()], 0.0, 10_000.0),
            ("boresight_deg", &boresight_deg, -5.0, 5.0),
        ];
        limits.into_iter().find_map(|(key, values, min, max)| OutOfRange::first(key, values, min, max))
    }

    /// Returns what is wrong with the distortion of the lens. Every flight begins with the widest view.
    fn folded(&self) -> Option<String> {
        let [_, widest] = FIELD_OF_VIEW_RANGE_DEG;
        let (width, height) = FRAME_SIZE;
        let min = Lens::min_k1(&Camera::with_field_of_view(width, height, widest.to_radians()).ok()?, width, height);
        let k1 = self.k1;
        (k1 < min).then(|| {
            format!("k1 is {k1}, and must be at least {min:.3}: a lens below folds the corners of the frame over")
        })
    }
}

/// An event of a flight.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Event {
    /// The lens is covered.
    Black {
        /// Time of the event, s.
        t: f64,
        /// Duration, s.
        seconds: f64,
    },
    /// A cloud comes between: contrast is multiplied by 1 - `density`.
    Cloud {
        /// Time of the event, s.
        t: f64,
        /// Duration, s.
        seconds: f64,
        /// 0 (clear) to 1 (nothing is seen).
        density: f64,
    },
    /// The light changes suddenly by a factor.
    Light {
        /// Time of the event, s.
        t: f64,
        /// Duration, s.
        seconds: f64,
        /// Factor of the radiance, 0 to 100.
        factor: f64,
    },
    /// Light that the lens scatters: a bright spot that stays in its place in the picture.
    Glare {
        /// Time of the event, s.
        t: f64,
        /// Duration, s.
        seconds: f64,
        /// Its middle, as parts of the columns and of the rows: -1 to 2 each.
        at: [f64; 2],
        /// Its radius, as a part of the columns: 0.001 to 1.
        radius: f64,
        /// Its light in the middle, relative to the mean of the picture: 0 to 100.
        strength: f64,
    },
    /// A drop on the front glass.
    Drop {
        /// Time of the event, s.
        t: f64,
        /// Duration, s.
        seconds: f64,
        /// Its middle, as parts of the columns and of the rows: -1 to 2 each.
        at: [f64; 2],
        /// Its radius, as a part of the columns: 0.001 to 1.
        radius: f64,
    },
    /// A gust that swells and falls like `(1 - cos) / 2` (MIL-F-8785C, section 3.7.1.3).
    Gust {
        /// Time of the event, s.
        t: f64,
        /// Duration, s.
        seconds: f64,
        /// Its largest velocity along `X_e`, `Y_e` and down, m/s: -20 to 20 each.
        wind_m_per_s: [f64; 3],
    },
    /// Frames do not arrive.
    Dropped {
        /// Time of the event, s.
        t: f64,
        /// Duration, s.
        seconds: f64,
    },
    /// The laser reads wrong ranges.
    Laser {
        /// Time of the event, s.
        t: f64,
        /// Duration, s.
        seconds: f64,
        /// Factor of the range, 0.01 to 100.
        factor: f64,
    },
    /// The laser has no reading.
    LaserLost {
        /// Time of the event, s.
        t: f64,
        /// Duration, s.
        seconds: f64,
    },
    /// Estimates reach the autopilot late.
    Late {
        /// Time of the event, s.
        t: f64,
        /// Duration, s.
        seconds: f64,
        /// Delay beyond the usual one, s: 0 to 2.
        delay_s: f64,
    },
    /// Each message arrives twice.
    Repeated {
        /// Time of the event, s.
        t: f64,
        /// Duration, s.
        seconds: f64,
    },
    /// The constant errors of the inertial sensor change.
    ImuBias {
        /// Time of the event, s.
        t: f64,
        /// Change of the error of the angular rates, degrees/s: -1 to 1 each.
        rates_deg_per_s: [f64; 3],
        /// Change of the error of the specific force, m/s^2: -1 to 1 each.
        force_m_per_s2: [f64; 3],
    },
    /// The next frame becomes the reference.
    Capture {
        /// Time of the event, s.
        t: f64,
    },
    /// The reference is renewed.
    Renew {
        /// Time of the event, s.
        t: f64,
    },
    /// The camera zooms to its wide view.
    Wide {
        /// Time of the event, s.
        t: f64,
    },
    /// The camera zooms to its narrow view.
    Narrow {
        /// Time of the event, s.
        t: f64,
    },
}

impl Event {
    /// Returns begin and end, s.
    fn interval(&self) -> [f64; 2] {
        match *self {
            Self::Black { t, seconds }
            | Self::Cloud { t, seconds, .. }
            | Self::Light { t, seconds, .. }
            | Self::Glare { t, seconds, .. }
            | Self::Drop { t, seconds, .. }
            | Self::Gust { t, seconds, .. }
            | Self::Dropped { t, seconds }
            | Self::Laser { t, seconds, .. }
            | Self::LaserLost { t, seconds }
            | Self::Late { t, seconds, .. }
            | Self::Repeated { t, seconds } => [t, t + seconds],
            Self::Capture { t }
            | Self::Renew { t }
            | Self::Wide { t }
            | Self::Narrow { t }
            | Self::ImuBias { t, .. } => [t, t],
        }
    }

    /// Returns `true` if the event acts at a time (s).
    fn is_active(&self, time: f64) -> bool {
        let [begin, end] = self.interval();
        // Frame times are not exact in binary.
        (begin - 1e-9..end - 1e-9).contains(&time)
    }

    /// Returns the command, if the event is one that is due at a frame.
    fn command(&self, frame: usize) -> Option<Command> {
        let command = match self {
            Self::Capture { .. } => Command::Capture,
            Self::Renew { .. } => Command::Renew,
            Self::Wide { .. } => Command::Wide,
            Self::Narrow { .. } => Command::Narrow,
            _ => return None,
        };
        self.is_due(frame).then_some(command)
    }

    /// Returns `true` for the frame at which an event without a duration acts.
    fn is_due(&self, frame: usize) -> bool {
        frame == (self.interval()[0] * FRAME_RATE).round() as usize
    }

    /// Returns the first value that is out of range, with its name, and the range.
    fn invalid(&self) -> Option<OutOfRange> {
        let first = OutOfRange::first;
        let spot =
            |at: &[f64; 2], radius: f64| first("at", at, -1.0, 2.0).or_else(|| first("radius", &[radius], 0.001, 1.0));
        let [begin, end] = self.interval();
        let of_all = || first("t", &[begin], 0.0, 3600.0).or_else(|| first("seconds", &[end - begin], 0.0, 3600.0));
        of_all().or_else(|| match self {
            Self::Cloud { density, .. } => first("density", &[*density], 0.0, 1.0),
            Self::Light { factor, .. } => first("factor", &[*factor], 0.0, 100.0),
            Self::Laser { factor, .. } => first("factor", &[*factor], 0.01, 100.0),
            Self::Drop { at, radius, .. } => spot(at, *radius),
            Self::Glare { at, radius, strength, .. } => {
                spot(at, *radius).or_else(|| first("strength", &[*strength], 0.0, 100.0))
            }
            Self::Gust { wind_m_per_s, .. } => first("wind_m_per_s", wind_m_per_s, -20.0, 20.0),
            Self::Late { delay_s, .. } => first("delay_s", &[*delay_s], 0.0, 2.0),
            Self::ImuBias { rates_deg_per_s, force_m_per_s2, .. } => {
                first("rates_deg_per_s", rates_deg_per_s, -1.0, 1.0)
                    .or_else(|| first("force_m_per_s2", force_m_per_s2, -1.0, 1.0))
            }
            _ => None,
        })
    }
}

/// A value that is out of its range.
struct OutOfRange {
    key: &'static str,
    value: f64,
    min: f64,
    max: f64,
}

impl OutOfRange {
    /// Returns the first of the values of a key that is out of range.
    fn first(key: &'static str, values: &[f64], min: f64, max: f64) -> Option<Self> {
        let value = values.iter().copied().find(|value| !(min..=max).contains(value))?;
        Some(Self { key, value, min, max })
    }
}

impl Display for OutOfRange {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { key, value, min, max } = self;
        write!(f, "{key} is {value}, and must be {min} to {max}")
    }
}

/// Events and camera errors of a flight.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scenario {
    /// The events, in any order.
    pub events: Vec<Event>,
    /// Errors of the camera.
    pub camera: CameraErrors,
    /// What the flight program knows of them.
    pub calibration: Option<Calibration>,
    /// A scene that the scenario contains; it replaces that of [`HoverSettings::scene`].
    pub scene: Option<Scene>,
}

/// The key `scene`.
enum SceneKey {
    /// The name of a scene, or a file.
    Name(String),
    /// A table, which is the scene.
    Table,
}

impl<'de> Deserialize<'de> for SceneKey {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameOrTable;
        impl<'de> Visitor<'de> for NameOrTable {
            type Value = SceneKey;

            fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
                f.write_str("the name of a scene, a file, or a table")
            }

            fn visit_str<E>(self, name: &str) -> Result<SceneKey, E> {
                Ok(SceneKey::Name(name.to_owned()))
            }

            fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> Result<SceneKey, A::Error> {
                while table.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
                Ok(SceneKey::Table)
            }
        }
        deserializer.deserialize_any(NameOrTable)
    }
}

/// The keys of a scenario file beside `event`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    scene: SceneKey,
    seconds: Option<f64>,
    seed: Option<u64>,
    height_m: Option<f64>,
    gusts_m_s: Option<f64>,
    altitude: Option<Altitude>,
    view: Option<CameraView>,
    #[serde(default)]
    camera: CameraErrors,
    calibration: Option<Calibration>,
}

/// Reads the key `event` of a text: an array of tables.
fn read_events(text: &str, path: &Path, key: Option<Spanned<DeValue<'_>>>) -> Result<Vec<Event>, TomlFileError> {
    let refused =
        |offset: usize, why: &str| SCENARIO.invalid(path, format!("line {}: {why}", toml_text::line(text, offset)));
    let Some(key) = key else { return Ok(Vec::new()) };
    let Some(events) = key.get_ref().as_array() else {
        return Err(refused(key.span().start, "event: write [[event]] before the keys of each event"));
    };
    let read = |(index, event): (usize, &Spanned<DeValue<'_>>)| {
        let (begin, place) = (event.span(), format!("event {}: ", index + 1));
        let mut keys = event.get_ref().as_table().cloned().unwrap_or_default();
        let Some((name, kind)) = keys.remove_entry("event") else {
            return Err(refused(begin.start, &format!("{place}missing field `event`, which names it")));
        };
        let DeValue::String(kind) = kind.into_inner() else {
            return Err(refused(name.span().start, &format!("{place}event: give a name, such as \"black\"")));
        };
        let mut named = DeTable::new();
        named.insert(Spanned::new(name.span(), kind), Spanned::new(begin.clone(), DeValue::Table(keys.clone())));
        let named = Spanned::new(begin.clone(), DeValue::Table(named));
        let event: Event = strict::deserialize(ValueDeserializer::from(named))
            .map_err(|error| SCENARIO.located(text, path, &place, Some(&keys), &error))?;
        match event.invalid() {
            Some(wrong) => Err(refused(begin.start, &format!("{place}{wrong}"))),
            None => Ok(event),
        }
    };
    events.iter().enumerate().map(read).collect()
}

impl Scenario {
    /// Returns a remark for each event that begins after the end of a flight (s).
    pub(super) fn remarks(&self, seconds: f64) -> impl Iterator<Item = String> {
        let begins = self.events.iter().map(|event| event.interval()[0]).enumerate();
        begins.filter(move |(_, begin)| *begin > seconds).map(move |(index, begin)| {
            format!("event {}: begins at {begin} s, after the end of the flight at {seconds} s", index + 1)
        })
    }

    /// Returns the optics of the camera.
    pub(super) fn optics(&self) -> Optics {
        let CameraErrors { k1, readout_s, boresight_deg, specks, .. } = self.camera;
        let [roll, pitch, yaw] = boresight_deg.map(f64::to_radians);
        let boresight = Attitude { roll, pitch, yaw };
        Optics { distortion: [k1, 0.0], readout_time: readout_s, boresight, specks, ..Optics::default() }
    }

    /// Returns what is between scene and camera at a time (s).
    pub(super) fn obstruction(&self, time: f64) -> Obstruction {
        let spot = |event: &Event| match *event {
            Event::Glare { at, radius, strength, .. } => Some(Spot { at, radius, effect: Effect::Glare(strength) }),
            Event::Drop { at, radius, .. } => Some(Spot { at, radius, effect: Effect::Drop }),
            _ => None,
        };
        let active = || self.events.iter().filter(|event| event.is_active(time));
        let mut view = Obstruction { spots: active().filter_map(spot).collect(), ..Obstruction::default() };
        for event in active() {
            let (transmission, veil) = match *event {
                Event::Black { .. } => (0.0, 0.0),
                Event::Cloud { density, .. } => (1.0 - density, density),
                Event::Light { factor, .. } => (factor, 0.0),
                _ => continue,
            };
            view.transmission *= transmission;
            view.veil = view.veil * transmission + veil;
        }
        view
    }

    /// Returns the velocity of the gusts of the scenario at a time (s), m/s.
    pub(super) fn gust(&self, time: f64) -> Vector3<f64> {
        let at = |event: &Event| match *event {
            Event::Gust { t, seconds, wind_m_per_s } if event.is_active(time) => {
                Vector3::from(wind_m_per_s) * ((1.0 - libm::cos(TAU * (time - t) / seconds)) / 2.0)
            }
            _ => Vector3::zeros(),
        };
        self.events.iter().map(at).sum()
    }

    /// Returns `true` if the frame at a time (s) does not arrive.
    pub(super) fn is_dropped(&self, time: f64) -> bool {
        self.events.iter().any(|event| matches!(event, Event::Dropped { .. }) && event.is_active(time))
    }

    /// Returns `true` if the frame at a time (s) shows no texture of the ground, or does not arrive.
    pub(super) fn is_blind(&self, time: f64) -> bool {
        self.is_dropped(time) || self.obstruction(time).transmission < 0.05
    }

    /// Returns the range that the laser reports at a time (s) for its reading `range` (m).
    pub(super) fn range(&self, time: f64, range: Option<f64>) -> Option<f64> {
        self.events.iter().filter(|event| event.is_active(time)).fold(range, |range, event| match *event {
            Event::Laser { factor, .. } => range.map(|range| factor * range),
            Event::LaserLost { .. } => None,
            _ => range,
        })
    }

    /// Returns how the messages of the frame at a time (s) arrive.
    pub(super) fn delivery(&self, time: f64) -> Delivery {
        let is_repeated = |event: &Event| matches!(event, Event::Repeated { .. }) && event.is_active(time);
        if self.events.iter().any(is_repeated) { Delivery::Twice } else { Delivery::Once }
    }

    /// Returns the delay of the estimate of the frame at a time (s) beyond the usual one, s.
    pub(super) fn delay(&self, time: f64) -> f64 {
        let delay = |event: &Event| match event {
            Event::Late { delay_s, .. } if event.is_active(time) => *delay_s,
            _ => 0.0,
        };
        self.events.iter().map(delay).sum()
    }

    /// Returns the changes of the errors of the inertial sensor that are due at a frame: rates (rad/s) and specific
    /// force (m/s^2).
    pub(super) fn inertial_steps(&self, frame: usize) -> impl Iterator<Item = ([f64; 3], [f64; 3])> {
        self.events.iter().filter_map(move |event| match event {
            Event::ImuBias { rates_deg_per_s, force_m_per_s2, .. } if event.is_due(frame) => {
                Some((rates_deg_per_s.map(f64::to_radians), *force_m_per_s2))
            }
            _ => None,
        })
    }

    /// Returns the commands that are due at a frame.
    pub(super) fn commands(&self, frame: usize) -> impl Iterator<Item = Command> {
        self.events.iter().filter_map(move |event| event.command(frame))
    }
}

impl HoverSettings {
    /// Reads a scenario: its keys replace those settings, its events are added.
    ///
    /// # Errors
    /// The file cannot be read, has an unknown key, or a value out of range.
    pub fn read_scenario(&mut self, path: &Path) -> Result<(), TomlFileError> {
        self.apply_scenario(&SCENARIO.read(path)?, path)
    }

    /// Applies the text of a scenario, as [`HoverSettings::read_scenario`] does. Scene files are searched beside
    /// `path`.
    ///
    /// # Errors
    /// The text has an unknown key, or a value out of range.
    pub fn apply_scenario(&mut self, text: &str, path: &Path) -> Result<(), TomlFileError> {
        let invalid = |why: String| SCENARIO.invalid(path, why);
        let mut table = DeTable::parse(text).map_err(|error| SCENARIO.located(text, path, "", None, &error))?;
        let events = read_events(text, path, table.get_mut().remove("event"))?;
        let file: File = SCENARIO.deserialize(text, path, table)?;
        if let Some(wrong) = file.camera.invalid().map(|wrong| wrong.to_string()).or_else(|| file.camera.folded()) {
            return Err(invalid(format!("camera.{wrong}")));
        }
        // The keys of the file beside settings that are valid: a wrong option is not an error of the file.
        let valid = Self::default();
        let keys = Self {
            seconds: file.seconds.unwrap_or(valid.seconds),
            height_m: file.height_m.unwrap_or(valid.height_m),
            gusts_m_s: file.gusts_m_s.unwrap_or(valid.gusts_m_s),
            ..valid
        };
        keys.check().map_err(|error| invalid(error.to_string()))?;
        let calibration = file.calibration.map(Calibration::checked).transpose();
        let calibration = calibration.map_err(|error| invalid(format!("calibration.{error}")))?;
        let (scene, inline) = match file.scene {
            SceneKey::Table => {
                let folder = path.parent().unwrap_or(Path::new("."));
                let scene = Scene::parse_table(text, "scene", folder).map_err(|error| invalid(error.to_string()))?;
                (path.to_string_lossy().into_owned(), Some(scene))
            }
            SceneKey::Name(name) if Scene::named(&name).is_some() => (name, None),
            SceneKey::Name(file) => {
                let beside = path.parent().unwrap_or(Path::new(".")).join(file);
                (beside.to_string_lossy().into_owned(), None)
            }
        };
        self.scene = scene;
        self.seconds = file.seconds.unwrap_or(self.seconds);
        self.seed = file.seed.unwrap_or(self.seed);
        self.height_m = file.height_m.unwrap_or(self.height_m);
        self.gusts_m_s = file.gusts_m_s.unwrap_or(self.gusts_m_s);
        self.view = file.view.unwrap_or(self.view);
        self.altitude = file.altitude.unwrap_or(self.altitude);
        self.scenario = Scenario { events, camera: file.camera, calibration, scene: inline };
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<HoverSettings, String> {
        let mut settings = HoverSettings::default();
        settings.apply_scenario(text, Path::new("flights/a.toml")).map_err(|error| error.to_string())?;
        Ok(settings)
    }

    #[test]
    fn keys_replace_settings_and_events_act_in_their_interval() {
        let text = "scene = 'road.toml'\nheight_m = 60.0\nview = 'narrow'\n[camera]\nfocal = 0.01\n\
            [[event]]\nt = 4.0\nevent = 'black'\nseconds = 2.0\n\
            [[event]]\nt = 1.0\nevent = 'laser'\nseconds = 0.5\nfactor = 0.5\n[[event]]\nt = 3.0\nevent = 'renew'";
        let settings = read(text).unwrap();
        assert_eq!((settings.scene.as_str(), settings.height_m), ("flights/road.toml", 60.0));
        assert_eq!((settings.view, settings.seconds), (CameraView::Narrow, 10.0));
        let scenario = &settings.scenario;
        let dark = [3.9, 4.0, 5.9, 6.0].map(|time| scenario.obstruction(time).transmission == 0.0);
        assert_eq!(dark, [false, true, true, false]);
        assert_eq!([0.9, 1.2, 1.6].map(|time| scenario.range(time, Some(50.0))), [Some(50.0), Some(25.0), Some(50.0)]);
        assert_eq!(scenario.commands(45).collect::<Vec<_>>(), [Command::Renew]);
        assert_eq!(scenario.commands(44).count(), 0);
    }

    #[test]
    fn a_scenario_can_contain_its_scene_and_faults_of_link_and_sensors() {
        let text = "altitude = 'smooth'\n[scene.ground.field]\nparcel_m = 30.0\n\
            [[event]]\nt = 2.0\nevent = 'late'\nseconds = 1.0\ndelay_s = 0.2\n\
            [[event]]\nt = 3.0\nevent = 'repeated'\nseconds = 1.0\n\
            [[event]]\nt = 1.0\nevent = 'imu-bias'\nrates_deg_per_s = [0.0, 0.0, 180e-3]\n\
            force_m_per_s2 = [0.01, 0.0, 0.0]";
        let settings = read(text).unwrap();
        assert_eq!((settings.scene.as_str(), settings.altitude), ("flights/a.toml", Altitude::Smooth));
        let scenario = &settings.scenario;
        assert!(scenario.scene.as_ref().unwrap().is_flat());
        assert_eq!([1.9, 2.5, 3.1].map(|time| scenario.delay(time)), [0.0, 0.2, 0.0]);
        assert_eq!([2.5, 3.5].map(|time| scenario.delivery(time)), [Delivery::Once, Delivery::Twice]);
        let [(rates, force)] = scenario.inertial_steps(15).collect::<Vec<_>>()[..] else { panic!() };
        assert!((rates[2] - 1e-3 * std::f64::consts::PI).abs() < 1e-12 && force == [0.01, 0.0, 0.0]);
        assert_eq!(scenario.inertial_steps(16).count(), 0);
    }

    #[test]
    fn spots_gusts_and_errors_of_the_mounting_are_read() {
        let text = "scene = 'field'\n[camera]\nboresight_deg = [0.0, 180e-2, 0.0]\nspecks = 7\ndelay_s = 0.01\n\
            [[event]]\nt = 2.0\nevent = 'drop'\nseconds = 1.0\nat = [0.2, 0.3]\nradius = 0.1\n\
            [[event]]\nt = 2.5\nevent = 'glare'\nseconds = 1.0\nat = [0.5, 0.5]\nradius = 0.3\nstrength = 4.0\n\
            [[event]]\nt = 1.0\nevent = 'gust'\nseconds = 2.0\nwind_m_per_s = [3.0, 0.0, -1.0]";
        let scenario = read(text).unwrap().scenario;
        let optics = scenario.optics();
        assert!((optics.boresight.pitch - 1e-2 * std::f64::consts::PI).abs() < 1e-12 && optics.specks == 7);
        assert_eq!([1.9, 2.0, 2.6, 3.2].map(|time| scenario.obstruction(time).spots.len()), [0, 1, 2, 1]);
        let gusts = [0.9, 1.0, 1.5, 2.0].map(|time| scenario.gust(time).x);
        assert!(gusts.iter().zip([0.0, 0.0, 1.5, 3.0]).all(|(a, b)| (a - b).abs() < 1e-9), "{gusts:?}");
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        let refused = |text: &str, why: &str| {
            let error = read(text).unwrap_err();
            assert!(error.starts_with("scenario flights/a.toml: ") && error.contains(why), "{error}");
            assert_eq!(error.lines().count(), 1);
        };
        refused("scene = 'field'\nspeed = 3\n", "line 2: unknown field `speed`");
        refused("scene = 'field'\nseconds = 0.5\n", "seconds is 0.5, and must be 1 to 3600");
        refused("scene = 'field'\nheight_m = 5.0\n", "height must be between 10 and 300 m, not 5");
        refused("scene = 'field'\ngusts_m_s = nan\n", "rms of gusts must be between 0 and 5 m/s, not NaN");
        refused("scene = 'field'\n[[event]]\nt = 1.0\nevent = 'storm'\n", "unknown variant `storm`");
        refused(
            "scene = 'field'\n[[event]]\nt = -1.0\nevent = 'renew'\n",
            "line 2: event 1: t is -1, and must be 0 to 3600",
        );
        refused("scene = 'field'\n[camera]\nk1 = 3.0\n", "camera.k1 is 3, and must be -1 to 1");
        refused("scene = 'field'\n[camera]\nk1 = -0.44\n", "camera.k1 is -0.44, and must be at least -0.42");
        assert!(["-0.42", "1.0"].iter().all(|k1| read(&format!("scene = 'field'\n[camera]\nk1 = {k1}\n")).is_ok()));
        refused("scene = 'field'\n[camera]\nboresight_deg = [0.0, 9.0, 0.0]\n", "camera.boresight_deg is 9");
        let known = |k1| format!("scene = 'field'\n[calibration]\nk1 = {{ value = 0.01, {k1} }}\n");
        assert!(read(&known("sigma = 0.001")).is_ok_and(|settings| {
            settings.scenario.calibration.is_some_and(|calibration| calibration.k1.value == 0.01)
        }));
        refused(&known("sigma = -1.0"), "calibration.k1.sigma is -1, and must be 0 to 1");
        refused(&known("sigmas = 0.1"), "unknown field `sigmas`");
        refused(
            "scene = 'field'\n[camera]\nboresight_deg = [0.0, 0.0, 0.0, 1.0]\n",
            "camera.boresight_deg: invalid length 4",
        );
        refused("scene = 'field'\ncamera = [0.1, 0.0]\n", "line 2: camera: invalid type: sequence");
        let gust =
            "scene = 'field'\n[[event]]\nt = 1.0\nevent = 'gust'\nseconds = 1.0\nwind_m_per_s = [1.0, 0.0, 0.0, 9.0]\n";
        refused(gust, "line 6: event 1: wind_m_per_s: invalid length 4, expected an array of length 3");
        refused(
            "[scene.ground.grass]\n[[scene.tree]]\nat_m = [1, 2, 30]\nradius_m = 1\nheight_m = 2\n",
            "line 3: scene.tree.0.at_m: invalid length 3, expected an array of length 2",
        );
        let drop =
            "scene = 'field'\n[[event]]\nt = 1.0\nevent = 'drop'\nseconds = 1.0\nat = [0.5, 0.5]\nradius = 2.0\n";
        refused(drop, "line 2: event 1: radius is 2, and must be 0.001 to 1");
        refused("seconds = 3.0\n", "missing field `scene`");
        refused(
            "scene = 'field'\n[[event]]\nt = 1.0\nevent = 'late'\nseconds = 1.0\ndelay_s = 3.0\n",
            "line 2: event 1: delay_s is 3, and must be 0 to 2",
        );
        let second = |keys: &str| {
            format!("scene = 'field'\n\n[[event]]\nt = 1.0\nevent = 'renew'\n\n[[event]]\nt = 1.0\n{keys}\n")
        };
        refused(&second("event = 'black'\nsecs = 1.0"), "line 10: event 2: ");
        refused(&second("event = 'black'\nsecs = 1.0"), "secs");
        refused(&second("event = 'black'\nseconds = '1'"), "line 10: event 2: seconds: invalid type: string");
        refused(&second("event = 'black'"), "line 7: event 2: missing field `seconds`");
        refused(&second("seconds = 1.0"), "line 7: event 2: missing field `event`");
        refused(&second("event = 3"), "line 9: event 2: event: give a name");
        refused("scene = 'field'\nevent = 'black'\n", "line 2: event: write [[event]]");
        refused("scene = 3\n", "line 1: scene: invalid type: integer `3`, expected the name of a scene");
        refused("seconds = 'x'\nscene = 'field'\n", "line 1: seconds: invalid type");
        // A scene within has the lines of the scenario.
        let scene = "seconds = 1.0\n\n[scene]\nbrightness = 1.0\n[scene.ground.grass]\n";
        refused(
            &format!("{scene}\n[scene.mist]\nextinction_per_m = 3.0\n"),
            "line 8: scene.mist.extinction_per_m: 3 is out of range: 0 to 1",
        );
        refused(&format!("{scene}[scene.fog]\n"), "line 6: scene.fog: unknown field `fog`");
        refused("[scene]\nbrightness = 1.0\n", "line 1: scene: missing field `ground`");
    }

    #[test]
    fn events_after_the_end_are_remarked() {
        let text = "scene = 'field'\nseconds = 5.0\n[[event]]\nt = 5.0\nevent = 'renew'\n\
            [[event]]\nt = 5.5\nevent = 'black'\nseconds = 1.0\n";
        let settings = read(text).unwrap();
        let remarks: Vec<String> = settings.scenario.remarks(settings.seconds).collect();
        assert_eq!(remarks, ["event 2: begins at 5.5 s, after the end of the flight at 5 s"]);
    }
}
