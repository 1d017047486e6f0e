//! Draws flights at random: each is a list of ingredients, which together are the text of a scenario file.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Largest number of random streams of a flight, one for each kind of ingredient.
const STREAMS: u64 = 64;

/// Times at which faults begin, s.
const FAULT_TIMES_S: [f64; 2] = [2.0, 14.0];

/// Half the width of the picture of the wide view on the ground, relative to the height.
const HALF_VIEW: f64 = 0.45;

/// The part of a scenario file to which the text of an ingredient belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    /// Keys before the first table.
    Setting,
    /// Keys of the table `camera`.
    Camera,
    /// Keys of the table `scene`.
    Scene,
    /// Tables of the scene.
    Object,
    /// Tables of events: faults and commands.
    Event,
}

/// An ingredient of a random flight: weather, an object, an error of the camera, or a fault.
#[derive(Debug, Clone, PartialEq)]
pub struct Ingredient {
    /// The kind, such as `sun`.
    pub kind: &'static str,
    /// The value that describes it best, such as the elevation of the sun in degrees.
    pub value: String,
    part: Part,
    text: String,
}

/// A random flight. Equal seeds and numbers give equal flights. An ingredient does not depend on the others, except
/// that objects, hills and mist are drawn for the height, and that water takes the place of ground and relief.
#[derive(Debug, Clone, PartialEq)]
pub struct RandomFlight {
    /// Seed of the campaign.
    pub seed: u64,
    /// Number of the flight, from 1.
    pub number: u32,
    /// Duration, s.
    pub seconds: f64,
    /// The ingredients. What is missing has the value of a quiet hover over a field.
    pub ingredients: Vec<Ingredient>,
}

/// The ground of a flight without that ingredient.
const PLAIN_GROUND: &str = "[scene.ground.field]\nparcel_m = 40.0\n";

impl RandomFlight {
    /// Draws flight `number` of `seed`.
    pub fn draw(seed: u64, number: u32, seconds: f64) -> Self {
        let mut draw = Draw { seed, number, ingredients: Vec::new() };
        let height = draw.place();
        draw.scenery(height);
        draw.weather(height);
        draw.calibration();
        draw.camera_faults();
        draw.sensor_faults();
        Self { seed, number, seconds, ingredients: draw.ingredients }
    }

    /// Returns the ingredients as `kind=value`, separated by spaces.
    pub fn described(&self) -> String {
        let each: Vec<String> = self.ingredients.iter().map(|one| format!("{}={}", one.kind, one.value)).collect();
        each.join(" ")
    }

    /// Returns the flight without ingredient `index`.
    pub fn without(&self, index: usize) -> Self {
        let mut fewer = self.clone();
        if index < fewer.ingredients.len() {
            fewer.ingredients.remove(index);
        }
        fewer
    }

    /// Returns the scenario file of the flight.
    pub fn scenario(&self) -> String {
        let Self { seed, number, seconds, .. } = self;
        let mut text = format!("# Random flight {number} of seed {seed}: {}\n", self.described());
        // Writing to a String cannot fail.
        let _ = writeln!(text, "seconds = {seconds:?}\nseed = {}", self.flight_seed());
        let of = |part: Part| -> String {
            self.ingredients.iter().filter(|one| one.part == part).map(|one| one.text.as_str()).collect()
        };
        text += &of(Part::Setting);
        for (table, part) in [("camera", Part::Camera), ("scene", Part::Scene)] {
            let keys = of(part);
            if !keys.is_empty() {
                let _ = write!(text, "\n[{table}]\n{keys}");
            }
        }
        if !self.ingredients.iter().any(|one| ["ground", "water"].contains(&one.kind)) {
            text += "\n";
            text += PLAIN_GROUND;
        }
        text + &of(Part::Object) + &of(Part::Event)
    }

    /// Returns the seed of wind, sensors, camera and scene.
    fn flight_seed(&self) -> u64 {
        // TOML has signed numbers.
        (self.seed.wrapping_mul(100_000).wrapping_add(u64::from(self.number))) & (u64::MAX >> 1)
    }
}

/// A flight that is being drawn.
struct Draw {
    seed: u64,
    number: u32,
    ingredients: Vec<Ingredient>,
}

/// The random numbers of an ingredient.
struct Numbers(ChaCha8Rng);

impl Numbers {
    fn uniform(&mut self, min: f64, max: f64) -> f64 {
        min + (max - min) * self.0.random::<f64>()
    }

    /// Draws a number whose logarithm is uniform.
    fn log_uniform(&mut self, min: f64, max: f64) -> f64 {
        min * libm::pow(max / min, self.0.random::<f64>())
    }

    /// Draws a whole number, both limits included.
    fn count(&mut self, min: u32, max: u32) -> u32 {
        self.0.random_range(min..=max)
    }

    /// Draws the begin of a fault, s.
    fn time(&mut self) -> f64 {
        let [min, max] = FAULT_TIMES_S;
        self.uniform(min, max)
    }

    /// Draws a point on the ground at most `reach` from the middle along each axis, m.
    fn place(&mut self, reach: f64) -> [f64; 2] {
        [self.uniform(-reach, reach), self.uniform(-reach, reach)]
    }
}

impl Draw {
    /// Adds an ingredient with a probability. `draw` returns its value and its text.
    fn add(
        &mut self,
        kind: &'static str,
        part: Part,
        probability: f64,
        draw: impl FnOnce(&mut Numbers) -> (String, String),
    ) {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let index = KINDS.iter().position(|one| *one == kind).unwrap_or(KINDS.len());
        random.set_stream(u64::from(self.number) * STREAMS + index as u64);
        if random.random::<f64>() < probability {
            let (value, text) = draw(&mut Numbers(random));
            self.ingredients.push(Ingredient { kind, value, part, text });
        }
    }

    /// Draws height, profile and view; returns the height, m.
    fn place(&mut self) -> f64 {
        let mut height = 50.0;
        self.add("height", Part::Setting, 1.0, |random| {
            height = random.log_uniform(15.0, 200.0).round();
            (format!("{height}"), format!("height_m = {height:?}\n"))
        });
        self.add("climb", Part::Setting, 0.15, |random| {
            let profile = ["smooth", "abrupt"][random.count(0, 1) as usize];
            (profile.into(), format!("altitude = '{profile}'\n"))
        });
        self.add("narrow", Part::Setting, 0.25, |_| ("10".into(), "view = 'narrow'\n".into()));
        height
    }

    fn scenery(&mut self, height: f64) {
        self.add("water", Part::Object, 0.08, |random| {
            let (wave, slope) = (random.log_uniform(1.0, 30.0), random.log_uniform(0.03, 0.3));
            let wind_to = random.uniform(0.0, 360.0);
            let keys = format!("wave_m = {wave:.1}\nslope = {slope:.3}\nwind_to_deg = {wind_to:.0}.0\n");
            (format!("{wave:.1}"), format!("\n[scene.ground.water]\n{keys}"))
        });
        if !self.ingredients.iter().any(|one| one.kind == "water") {
            self.land(height);
        }
        self.objects(height);
    }

    /// Draws ground that stays in place, and its relief.
    fn land(&mut self, height: f64) {
        self.add("ground", Part::Object, 1.0, |random| {
            let (name, keys) = match random.count(0, 9) {
                0..4 => (
                    "field",
                    format!("parcel_m = {:.1}\ntrees = {}\n", random.uniform(20.0, 60.0), random.count(0, 300)),
                ),
                4..7 => {
                    let [trees, moving, parked] = [300, 30, 80].map(|most| random.count(0, most));
                    ("town", format!("trees = {trees}\nmoving_cars = {moving}\nparked_cars = {parked}\n"))
                }
                7..9 => ("asphalt", format!("side_m = {:.1}\n", random.log_uniform(20.0, 400.0))),
                _ => ("grass", String::new()),
            };
            (name.into(), format!("\n[scene.ground.{name}]\n{keys}"))
        });
        self.add("relief", Part::Object, 0.45, |random| {
            let wave = random.log_uniform(40.0, 400.0);
            // Four octaves at 0.043 of the wavelength have slopes above 1, which the renderer refuses.
            let rms = random.log_uniform(0.3, 8.0).min(0.03 * wave).min(0.1 * height);
            let octaves = random.count(1, 4);
            let keys = format!("rms_m = {rms:.2}\nwavelength_m = {wave:.0}.0\noctaves = {octaves}\n");
            (format!("{rms:.1}"), format!("\n[scene.relief.hills]\n{keys}"))
        });
    }

    fn objects(&mut self, height: f64) {
        let reach = HALF_VIEW * height;
        self.add("buildings", Part::Object, 0.3, |random| {
            let count = random.count(1, 6);
            let mut text = String::new();
            for _ in 0..count {
                let [x, y] = random.place(reach);
                let [a, b] = [0; 2].map(|_| random.uniform(5.0, 20.0));
                let tall = random.uniform(3.0, (0.35 * height).clamp(4.0, 25.0));
                let roof = ["flat", "gable"][random.count(0, 1) as usize];
                let yaw = random.uniform(0.0, 180.0);
                let _ = write!(
                    text,
                    "\n[[scene.building]]\nat_m = [{x:.1}, {y:.1}]\nsize_m = [{a:.1}, {b:.1}]\nheight_m = {tall:.1}\n\
                     yaw_deg = {yaw:.0}.0\nroof = '{roof}'\n"
                );
            }
            (count.to_string(), text)
        });
        self.add("trees", Part::Object, 0.25, |random| {
            let count = random.count(3, 60);
            let mut text = String::new();
            for _ in 0..count {
                let [x, y] = random.place(reach);
                let (radius, tall) = (random.uniform(1.0, 5.0), random.uniform(2.0, (0.3 * height).clamp(3.0, 16.0)));
                let _ = write!(
                    text,
                    "\n[[scene.tree]]\nat_m = [{x:.1}, {y:.1}]\nradius_m = {radius:.1}\nheight_m = {tall:.1}\n"
                );
            }
            (count.to_string(), text)
        });
        self.add("cars", Part::Object, 0.3, |random| {
            let count = random.count(4, 60);
            let turn = random.uniform(0.0, TAU);
            let (sin, cos) = libm::sincos(turn);
            let mut text = String::new();
            for _ in 0..count {
                let [along, lane] = random.place(reach.max(10.0));
                // Lanes are 3.5 m apart.
                let lane = (lane / 3.5).round() * 3.5;
                let half = random.uniform(15.0, 40.0);
                let [from, to] = [along - half, along + half].map(|s| [s * cos - lane * sin, s * sin + lane * cos]);
                let speed = random.uniform(1.0, 15.0);
                let _ = write!(
                    text,
                    "\n[[scene.car]]\nfrom_m = [{:.1}, {:.1}]\nto_m = [{:.1}, {:.1}]\nspeed_m_per_s = {speed:.2}\n",
                    from[0], from[1], to[0], to[1]
                );
            }
            (count.to_string(), text)
        });
        self.add("helipad", Part::Object, 0.12, |random| {
            let [x, y] = random.place(0.5 * reach);
            let (size, turn) = (random.uniform(8.0, 25.0), random.uniform(0.0, 360.0));
            let keys = format!("at_m = [{x:.1}, {y:.1}]\ndiameter_m = {size:.1}\nheading_deg = {turn:.0}.0\n");
            (format!("{size:.0}"), format!("\n[[scene.helipad]]\n{keys}"))
        });
    }

    fn weather(&mut self, height: f64) {
        self.add("sun", Part::Object, 1.0, |random| {
            let (azimuth, elevation) = (random.uniform(0.0, 360.0), random.uniform(5.0, 90.0));
            let keys = format!("azimuth_deg = {azimuth:.0}.0\nelevation_deg = {elevation:.1}\n");
            (format!("{elevation:.0}"), format!("\n[scene.sun]\n{keys}"))
        });
        self.add("gusts", Part::Setting, 1.0, |random| {
            let gusts = random.uniform(0.0, 5.0);
            (format!("{gusts:.1}"), format!("gusts_m_s = {gusts:.1}\n"))
        });
        self.add("mist", Part::Object, 0.2, |random| {
            // The contrast that mist leaves over the height.
            let contrast = random.uniform(0.1, 0.8);
            let extinction = -libm::log(contrast) / height;
            (format!("{contrast:.2}"), format!("\n[scene.mist]\nextinction_per_m = {extinction:.5}\n"))
        });
        for (kind, probability) in [("rain", 0.12), ("snow", 0.06)] {
            self.add(kind, Part::Object, probability, |random| {
                let drops = random.log_uniform(3.0, 60.0);
                (format!("{drops:.0}"), format!("\n[scene.{kind}]\nper_m3 = {drops:.1}\n"))
            });
        }
        self.add("night", Part::Scene, 0.12, |random| {
            let brightness = random.log_uniform(0.03, 0.3);
            (format!("{brightness:.2}"), format!("brightness = {brightness:.3}\n"))
        });
    }

    /// Draws errors of the camera: at most one standard deviation that the flight program assumes, dust, and frames
    /// stamped late, of which it knows nothing.
    fn calibration(&mut self) {
        for (kind, key, probability, [min, max]) in [
            ("distortion", "k1", 0.35, [-0.05, 0.05]),
            ("shutter", "readout_s", 0.3, [0.0, 0.015]),
            ("focal", "focal", 0.35, [-0.01, 0.01]),
        ] {
            self.add(kind, Part::Camera, probability, |random| {
                let value = random.uniform(min, max);
                (format!("{value:.4}"), format!("{key} = {value:.5}\n"))
            });
        }
        self.add("boresight", Part::Camera, 0.25, |random| {
            let angles = [0; 3].map(|_| random.uniform(-0.2, 0.2));
            let largest = angles.iter().fold(0.0f64, |largest, angle| largest.max(angle.abs()));
            let [roll, pitch, yaw] = angles;
            (format!("{largest:.2}"), format!("boresight_deg = [{roll:.3}, {pitch:.3}, {yaw:.3}]\n"))
        });
        self.add("delay", Part::Camera, 0.15, |random| {
            let delay = random.uniform(0.0, 0.01);
            (format!("{delay:.4}"), format!("delay_s = {delay:.5}\n"))
        });
        self.add("specks", Part::Camera, 0.15, |random| {
            let specks = random.log_uniform(3.0, 300.0).round();
            (format!("{specks}"), format!("specks = {specks}\n"))
        });
    }

    /// Adds an event with a duration (s) within limits. `keys` draws its other keys.
    fn fault(
        &mut self,
        event: &'static str,
        probability: f64,
        [min, max]: [f64; 2],
        keys: impl FnOnce(&mut Numbers) -> String,
    ) {
        self.add(event, Part::Event, probability, |random| {
            let (begin, seconds, keys) = (random.time(), random.log_uniform(min, max), keys(random));
            let text = format!("\n[[event]]\nt = {begin:.2}\nevent = '{event}'\nseconds = {seconds:.2}\n{keys}");
            (format!("{seconds:.2}"), text)
        });
    }

    fn camera_faults(&mut self) {
        self.fault("black", 0.12, [0.2, 3.0], |_| String::new());
        self.fault("cloud", 0.15, [0.2, 3.0], |random| format!("density = {:.2}\n", random.uniform(0.5, 1.0)));
        self.fault("light", 0.12, [0.1, 2.0], |random| format!("factor = {:.2}\n", random.log_uniform(0.2, 5.0)));
        let spot = |random: &mut Numbers| {
            let [x, y] = [0; 2].map(|_| random.uniform(0.0, 1.0));
            format!("at = [{x:.2}, {y:.2}]\nradius = {:.3}\n", random.log_uniform(0.02, 0.3))
        };
        self.fault("glare", 0.1, [0.2, 6.0], |random| {
            let strength = random.log_uniform(0.2, 5.0);
            format!("{}strength = {strength:.2}\n", spot(random))
        });
        self.fault("drop", 0.1, [0.5, 20.0], spot);
        self.fault("dropped", 0.15, [0.07, 1.5], |_| String::new());
        self.fault("late", 0.1, [0.1, 3.0], |random| format!("delay_s = {:.2}\n", random.uniform(0.05, 0.4)));
        self.fault("repeated", 0.08, [0.1, 5.0], |_| String::new());
        self.add("renew", Part::Event, 0.08, |random| {
            let time = random.time();
            (format!("{time:.1}"), format!("\n[[event]]\nt = {time:.2}\nevent = 'renew'\n"))
        });
        self.add("zoom", Part::Event, 0.08, |random| {
            let time = random.time();
            let back = time + random.uniform(1.0, 6.0);
            let text = [("narrow", time), ("wide", back)]
                .map(|(event, t)| format!("\n[[event]]\nt = {t:.2}\nevent = '{event}'\n"));
            (format!("{time:.1}"), text.concat())
        });
    }

    fn sensor_faults(&mut self) {
        self.fault("gust", 0.15, [1.0, 5.0], |random| {
            let [x, y, down] = [3.0, 3.0, 1.0].map(|most| random.uniform(-most, most));
            format!("wind_m_per_s = [{x:.2}, {y:.2}, {down:.2}]\n")
        });
        self.fault("laser", 0.12, [0.05, 1.5], |random| format!("factor = {:.2}\n", random.log_uniform(0.4, 2.5)));
        self.add("laser-at-capture", Part::Event, 0.06, |random| {
            let factor = random.log_uniform(0.4, 2.5);
            let text = format!("\n[[event]]\nt = 0.0\nevent = 'laser'\nseconds = 0.06\nfactor = {factor:.2}\n");
            (format!("{factor:.2}"), text)
        });
        self.fault("laser-lost", 0.12, [0.3, 6.0], |_| String::new());
        self.add("imu-bias", Part::Event, 0.1, |random| {
            let (time, mut three) = (random.time(), |most: f64| [0; 3].map(|_| random.uniform(-most, most)));
            let (rates, force) = (three(0.06), three(0.04));
            let [rates, force] = [rates, force].map(|v| v.map(|value| format!("{value:.4}")).join(", "));
            let keys = format!("rates_deg_per_s = [{rates}]\nforce_m_per_s2 = [{force}]\n");
            (format!("{time:.1}"), format!("\n[[event]]\nt = {time:.2}\nevent = 'imu-bias'\n{keys}"))
        });
    }
}

/// The kinds of ingredients. The index is that of the random stream, so a new kind is added at the end.
const KINDS: [&str; 37] = [
    "height",
    "climb",
    "narrow",
    "ground",
    "relief",
    "buildings",
    "trees",
    "cars",
    "helipad",
    "sun",
    "gusts",
    "mist",
    "rain",
    "snow",
    "night",
    "distortion",
    "shutter",
    "focal",
    "black",
    "cloud",
    "light",
    "dropped",
    "late",
    "repeated",
    "renew",
    "zoom",
    "laser",
    "laser-at-capture",
    "laser-lost",
    "imu-bias",
    "boresight",
    "delay",
    "specks",
    "glare",
    "drop",
    "gust",
    "water",
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::path::Path;

    use crate::hover::HoverSettings;

    /// Returns the settings of a flight; a text that is no scenario fails.
    fn settings(flight: &RandomFlight) -> HoverSettings {
        let mut settings = HoverSettings::default();
        let text = flight.scenario();
        settings.apply_scenario(&text, Path::new("a.toml")).unwrap_or_else(|error| panic!("{error}\n{text}"));
        settings
    }

    #[test]
    fn every_flight_is_a_valid_scenario_with_a_valid_scene() {
        let mut drawn = BTreeSet::new();
        for number in 1..=400 {
            let flight = RandomFlight::draw(5, number, 20.0);
            let settings = settings(&flight);
            assert!(settings.scenario.scene.is_some());
            assert!((15.0..=200.0).contains(&settings.height_m) && settings.gusts_m_s <= 5.0);
            assert_eq!((settings.seconds, settings.seed), (20.0, 500_000 + u64::from(number)));
            drawn.extend(flight.ingredients.iter().map(|one| one.kind));
        }
        assert_eq!(drawn, BTreeSet::from(KINDS));
    }

    #[test]
    fn a_number_is_one_flight_and_a_missing_ingredient_changes_no_other() {
        let draw = |seed, number| RandomFlight::draw(seed, number, 20.0);
        assert_eq!(draw(3, 7), draw(3, 7));
        assert!(draw(3, 7) != draw(3, 8) && draw(3, 7) != draw(4, 7));
        let flight = draw(3, 7);
        for index in 0..flight.ingredients.len() {
            let fewer = flight.without(index);
            let mut kept = flight.ingredients.clone();
            kept.remove(index);
            assert_eq!(fewer.ingredients, kept);
            assert!(settings(&fewer).scenario.scene.is_some());
        }
    }
}
