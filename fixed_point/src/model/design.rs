//! The design point: all parameters of the hardware.
//!
//! A camera sample has `P` bits, 8 to 16. One DN is a step of a 16-bit sample, so full scale is `FS = 2^16` DN for
//! every camera, and a step of the camera is `2^(16-P)` DN. Two designs are compared in DN. The formats of pixel and
//! state count in steps of the camera: the state keeps `f` fraction bits, one LSB is `2^(16-P-f)` DN. `DOG_k` has `N`
//! bits over a quarter of full scale, so one LSB is `2^(14-N)` DN whatever `P` is: 0.5 DN at `N = 15`, 4 DN at
//! `N = 12`. Thresholds, responses and neighbours of a record are in that LSB, its position in pixels. From the state's
//! LSB to that of the DoG is a shift by `s = f + P - 2 - N` bits, 1 at the default design point.
//!
//! The window of the maxima and the radius of MaxDOG are parameters of the algorithm. They are in
//! [`hoverlock_reference::features::maxima`] and [`hoverlock_reference::features::maxlbp`], the same for every level
//! and every design.
//!
//! A design file, `designs/NAME.toml`, is TOML with all keys of [`DesignPoint::KEYS`]. A configuration has some of them
//! and changes a design: a key that is absent keeps its value.

use std::borrow::Cow;
use std::fmt::Display;

use hoverlock_reference::features::feature::MAX_PAIRS;
use hoverlock_reference::features::maxlbp::{LARGEST_RING, Ring};
use hoverlock_reference::image::plane::Plane;
use serde::Serialize;
use toml::{Table, Value};

use crate::model::coefficients::MAX_FRACTION_BITS;
use crate::model::format::Format;

/// Integer bits of the DoG magnitude in DN: its range is `FS/4 = 2^14` DN.
pub const DOG_RANGE_BITS: i8 = 14;

/// Bits of the scale of DN.
pub const DN_BITS: u32 = 16;

/// Target and initial value of the automatic threshold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct AutomaticThreshold {
    /// Target number of features of one scale in one frame.
    pub target: u32,
    /// `T_k` of the first frame, LSB of the DoG; clipped to the largest value of the DoG.
    pub initial: u32,
}

/// The parameters of the model levels, the bit-true model and the hardware.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DesignPoint {
    /// Largest width of a frame, px.
    pub width: u32,
    /// Largest height of a frame, px.
    pub height: u32,
    /// Format of the camera sample, `u8.0` to `u16.0`, in steps of the camera.
    pub pixel: Format,
    /// Format of the filter state and of the line memories, in steps of the camera: the pixel's integer bits.
    pub state: Format,
    /// Format of the coefficients `g` and `g_j`.
    pub coefficient: Format,
    /// Scale pairs `k`, 1 to 3, chained: pair `k` is the difference of smoothers `k` and `k + 1`, so there is one
    /// smoother more.
    pub scale_pairs: u32,
    /// `sigma` of each smoother, pixels, rising.
    pub sigmas: Cow<'static, [f64]>,
    /// Look-ahead `m` of each smoother: `m` stages span `2^m - 1` samples.
    pub look_ahead: Cow<'static, [u32]>,
    /// `N`: bits of the DoG magnitude and of its maxima, over the range `FS/4`.
    pub dog_bits: u32,
    /// Radius of the ring of each scale pair, px.
    pub ring_radii: Cow<'static, [u32]>,
    /// The automatic threshold.
    pub threshold: AutomaticThreshold,
    /// Candidates that can wait for their rings, a power of two.
    pub candidate_queue: u32,
    /// Records that can wait for the DMA, a power of two.
    pub record_fifo: u32,
}

/// The design point of the KT-27 camera: 1024 x 768 pixels of 16 bits, 15 frames a second.
pub const KT27: DesignPoint = DesignPoint {
    width: 1024,
    height: 768,
    pixel: Format::unsigned(16, 0),
    state: Format::unsigned(16, 2),
    coefficient: Format::unsigned(0, 16),
    scale_pairs: 2,
    sigmas: Cow::Borrowed(&[2.0, 3.2, 5.12]),
    look_ahead: Cow::Borrowed(&[5, 5, 6]),
    dog_bits: 15,
    ring_radii: Cow::Borrowed(&[12, 16]),
    // Real ground of full contrast settles between 985 and 8240 LSB.
    threshold: AutomaticThreshold { target: 512, initial: 2048 },
    candidate_queue: 512,
    record_fifo: 512,
};

/// The design files that are built in: name and text.
pub const SHIPPED: [(&str, &str); 4] = [
    ("kt27", include_str!("../../../designs/kt27.toml")),
    ("hd1080", include_str!("../../../designs/hd1080.toml")),
    ("small", include_str!("../../../designs/small.toml")),
    ("three_scales", include_str!("../../../designs/three_scales.toml")),
];

impl Default for DesignPoint {
    fn default() -> Self {
        KT27
    }
}

/// Why a configuration is invalid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DesignError {
    /// The text is not TOML.
    #[error("the design is not TOML: {0}")]
    Syntax(String),
    /// Unknown key.
    #[error("unknown key `{key}`; the keys are {}", DesignPoint::KEYS.join(", "))]
    UnknownKey {
        /// The key given.
        key: String,
    },
    /// Value out of range.
    #[error("{key} = {value} is not possible: {allowed}")]
    Value {
        /// The key given.
        key: String,
        /// The value given.
        value: String,
        /// The allowed values.
        allowed: String,
    },
    /// A design file that leaves a key out.
    #[error("the key `{0}` is missing; a design file has all of {keys}", keys = DesignPoint::KEYS.join(", "))]
    Missing(&'static str),
    /// An override without a value.
    #[error("`{0}` is not of the form KEY=VALUE, like dog_bits=12")]
    Override(String),
}

impl DesignPoint {
    /// The keys of a configuration.
    pub const KEYS: [&str; 14] = [
        "width",
        "height",
        "pixel",
        "state",
        "coefficient",
        "scale_pairs",
        "sigmas",
        "look_ahead",
        "dog_bits",
        "ring_radii",
        "threshold_target",
        "threshold_initial",
        "candidate_queue",
        "record_fifo",
    ];

    /// The design file that is built in under a name; `None` where there is none.
    ///
    /// # Errors
    /// As [`DesignPoint::from_file`], which a test excludes.
    pub fn shipped(name: &str) -> Option<Result<Self, DesignError>> {
        SHIPPED.iter().find(|(known, _)| *known == name).map(|(_, text)| Self::from_file(text))
    }

    /// The design of a design file, which has every key.
    ///
    /// # Errors
    /// As [`DesignPoint::from_toml`], and where a key is missing.
    pub fn from_file(text: &str) -> Result<Self, DesignError> {
        let table = parsed(text)?;
        match Self::KEYS.into_iter().find(|key| !table.contains_key(*key)) {
            Some(key) => Err(DesignError::Missing(key)),
            None => Self::default().changed(&table),
        }
    }

    /// The default design point changed by the keys of a TOML text.
    ///
    /// # Errors
    /// The text is not TOML, has an unknown key or a value out of range.
    pub fn from_toml(text: &str) -> Result<Self, DesignError> {
        Self::default().with_toml(text)
    }

    /// This design point changed by the keys of a TOML text.
    ///
    /// # Errors
    /// As [`DesignPoint::from_toml`].
    pub fn with_toml(&self, text: &str) -> Result<Self, DesignError> {
        self.changed(&parsed(text)?)
    }

    /// This design point with one value changed: `KEY=VALUE`, the value as in TOML; quotes around a format are
    /// optional.
    ///
    /// # Errors
    /// As [`DesignPoint::from_toml`], and the text is not of that form.
    pub fn with_override(&self, text: &str) -> Result<Self, DesignError> {
        let (key, value) = text.split_once('=').ok_or_else(|| DesignError::Override(text.into()))?;
        let (key, value) = (key.trim(), value.trim());
        if key.is_empty() || value.is_empty() {
            return Err(DesignError::Override(text.into()));
        }
        let value = format!("v = {value}")
            .parse::<Table>()
            .ok()
            .and_then(|mut table| if table.len() == 1 { table.remove("v") } else { None })
            .unwrap_or_else(|| Value::String(value.into()));
        self.changed(&Table::from_iter([(key.to_owned(), value)]))
    }

    fn changed(&self, table: &Table) -> Result<Self, DesignError> {
        let mut changed = self.clone();
        for (key, value) in table {
            changed.set(key, value)?;
        }
        changed.check()?;
        Ok(changed)
    }

    fn set(&mut self, key: &str, value: &Value) -> Result<(), DesignError> {
        let given = Given { key, value };
        match key {
            "width" => self.width = given.whole(1..=4096)?,
            "height" => self.height = given.whole(1..=4096)?,
            "pixel" => {
                self.pixel = given.format("u8.0 to u16.0, the camera sample", |format| {
                    !format.is_signed() && (8..=16).contains(&format.integer_bits()) && format.fraction_bits() == 0
                })?;
                // A state that is not given keeps its fraction bits. `pixel` comes before `state`, keys being sorted.
                self.state = Format::unsigned(self.pixel.integer_bits(), self.state.fraction_bits());
            }
            "state" => {
                let integer = self.pixel.integer_bits();
                let allowed = format!("u{integer}.0 to u{integer}.12: the bits of the pixel and fraction bits");
                self.state = given.format(&allowed, |format| {
                    !format.is_signed()
                        && format.integer_bits() == integer
                        && (0..=12).contains(&format.fraction_bits())
                })?;
            }
            "coefficient" => {
                self.coefficient = given.format("u0.4 to u0.31", |format| {
                    let bits = 4..=MAX_FRACTION_BITS as i8;
                    !format.is_signed() && format.integer_bits() == 0 && bits.contains(&format.fraction_bits())
                })?;
            }
            "scale_pairs" => self.scale_pairs = given.whole(1..=MAX_PAIRS as u32)?,
            "sigmas" => self.sigmas = given.list(|given| given.real(0.3..=64.0))?,
            "look_ahead" => self.look_ahead = given.list(|given| given.whole(1..=10))?,
            "dog_bits" => self.dog_bits = given.whole(2..=16)?,
            "ring_radii" => self.ring_radii = given.list(|given| given.whole(4..=LARGEST_RING))?,
            "threshold_target" => self.threshold.target = given.whole(1..=65535)?,
            "threshold_initial" => self.threshold.initial = given.whole(1..=65535)?,
            "candidate_queue" => self.candidate_queue = given.depth()?,
            "record_fifo" => self.record_fifo = given.depth()?,
            _ => return Err(DesignError::UnknownKey { key: key.into() }),
        }
        Ok(())
    }

    /// Checks that involve several values.
    fn check(&self) -> Result<(), DesignError> {
        let (pairs, smoothers) = (self.scale_pairs, self.smoothers());
        let lists = [
            ("sigmas", self.sigmas.len(), format!("{:?}", self.sigmas), smoothers, "smoother"),
            ("look_ahead", self.look_ahead.len(), format!("{:?}", self.look_ahead), smoothers, "smoother"),
            ("ring_radii", self.ring_radii.len(), format!("{:?}", self.ring_radii), self.pairs(), "scale pair"),
        ];
        if let Some((key, _, value, wanted, of)) = lists.into_iter().find(|(_, length, _, wanted, _)| length != wanted)
        {
            return Err(DesignError::Value {
                key: key.into(),
                value,
                allowed: format!("scale_pairs = {pairs} needs a list of {wanted}, one for each {of}"),
            });
        }
        if !self.sigmas.is_sorted_by(|narrow, wide| narrow < wide) {
            return Err(DesignError::Value {
                key: "sigmas".into(),
                value: format!("{:?}", self.sigmas),
                allowed: "they must rise from the narrowest to the widest".into(),
            });
        }
        Ok(())
    }

    /// Scale pairs, so also DoG planes.
    pub fn pairs(&self) -> usize {
        self.scale_pairs as usize
    }

    /// The ring of each scale pair.
    pub fn rings(&self) -> Vec<Ring> {
        self.ring_radii.iter().map(|radius| Ring::of_radius(*radius)).collect()
    }

    /// Smoothers: neighbouring scale pairs share one.
    pub fn smoothers(&self) -> usize {
        self.pairs() + 1
    }

    /// The step of the camera is `2^n` DN.
    pub fn step_bits(&self) -> u32 {
        DN_BITS - self.pixel.bits()
    }

    /// A picture of 16-bit samples as this camera takes it, in its steps: the upper bits of each sample.
    pub fn samples(&self, picture: &Plane<u16>) -> Plane<u16> {
        let shift = self.step_bits();
        picture.map(|sample| sample >> shift)
    }

    /// Format of the pixel in DN: the same bits, `u16.-8` for 8 of them.
    pub fn pixel_dn(&self) -> Format {
        self.in_dn(self.pixel)
    }

    /// Format of the state in DN.
    pub fn state_dn(&self) -> Format {
        self.in_dn(self.state)
    }

    fn in_dn(&self, format: Format) -> Format {
        let shift = self.step_bits() as i8;
        Format::unsigned(format.integer_bits() + shift, format.fraction_bits() - shift)
    }

    /// Format of the DoG magnitude and of MaxDOG, in DN.
    pub fn dog(&self) -> Format {
        Format::unsigned(DOG_RANGE_BITS, self.dog_bits as i8 - DOG_RANGE_BITS)
    }

    /// Largest raw DoG magnitude, `2^N - 1`.
    pub fn max_dog(&self) -> u32 {
        (1 << self.dog_bits) - 1
    }

    /// `s`: one DoG LSB is `2^s` state LSB; negative where the DoG LSB is the smaller.
    pub fn dog_shift(&self) -> i32 {
        i32::from(self.state_dn().fraction_bits()) + i32::from(DOG_RANGE_BITS) - self.dog_bits as i32
    }

    /// This design point as a design file: `heading` as comments, one line each, then every key with its meaning.
    pub fn to_file(&self, heading: &[String]) -> String {
        let mut text: String = heading.iter().map(|line| format!("# {line}\n")).collect();
        text += "# DN: one step of a 16-bit sample; full scale is 2^16 DN. A camera of P bits has steps of \
                 2^(16 - P) DN.\n";
        for (line, comment) in self.to_toml().lines().zip(Self::COMMENTS) {
            text += &format!("\n# {comment}\n{line}\n");
        }
        text
    }

    /// The meaning of each of [`DesignPoint::KEYS`].
    const COMMENTS: [&str; 14] = [
        "Columns of the largest frame, px. The line memories hold the next power of two.",
        "Rows of the camera's frame, px. Pictures are cut to it; the hardware takes 64 to 2048 rows.",
        "Camera sample: u8.0 to u16.0, in steps of the camera.",
        "Filter state and line memories, in steps of the camera: the integer bits of the pixel, and fraction bits.",
        "Filter coefficients g and g_j.",
        "Scale pairs, 1 to 3: pair k is the difference of smoothers k and k + 1, so there is one smoother more.",
        "sigma of each smoother, px, rising.",
        "Look-ahead m of each smoother, stages: m stages reach 2^m - 1 px.",
        "Bits of a response, its sign apart, over a quarter of full scale: one LSB is 2^(14 - dog_bits) DN.",
        "Radius of the ring of each scale pair, px: 4 to 16, in hardware 9 to 16.",
        "Features of one scale pair in a frame that the automatic threshold aims at.",
        "Threshold before the first frame, LSB of the response.",
        "Candidates that can wait for their rings, a power of two: 64 to 4096. More are dropped and counted.",
        "Records that can wait for the DMA, a power of two: 64 to 4096. The last 16 are kept for the ends of frames.",
    ];

    /// This design point as TOML with all keys.
    pub fn to_toml(&self) -> String {
        let values: [Value; Self::KEYS.len()] = [
            self.width.into(),
            self.height.into(),
            self.pixel.to_string().into(),
            self.state.to_string().into(),
            self.coefficient.to_string().into(),
            self.scale_pairs.into(),
            self.sigmas.to_vec().into(),
            self.look_ahead.to_vec().into(),
            self.dog_bits.into(),
            self.ring_radii.to_vec().into(),
            self.threshold.target.into(),
            self.threshold.initial.into(),
            self.candidate_queue.into(),
            self.record_fifo.into(),
        ];
        Self::KEYS.iter().zip(values).map(|(key, value)| format!("{key} = {value}\n")).collect()
    }
}

fn parsed(text: &str) -> Result<Table, DesignError> {
    text.parse().map_err(|error: toml::de::Error| {
        let line = error.span().map_or(1, |span| text[..span.start].lines().count().max(1));
        DesignError::Syntax(format!("line {line}: {}", error.message().lines().collect::<Vec<_>>().join(", ")))
    })
}

/// A value with its key, for error messages.
struct Given<'a> {
    key: &'a str,
    value: &'a Value,
}

impl Given<'_> {
    fn refused(&self, allowed: impl Into<String>) -> DesignError {
        let value = self.value.to_string().lines().collect::<Vec<_>>().join(" ");
        DesignError::Value { key: self.key.into(), value, allowed: allowed.into() }
    }

    fn whole(&self, range: std::ops::RangeInclusive<u32>) -> Result<u32, DesignError> {
        let number = self.value.as_integer().and_then(|number| u32::try_from(number).ok());
        number
            .filter(|number| range.contains(number))
            .ok_or_else(|| self.refused(format!("a whole number {}", span(&range))))
    }

    fn depth(&self) -> Result<u32, DesignError> {
        let depth = self.whole(64..=4096)?;
        if depth.is_power_of_two() { Ok(depth) } else { Err(self.refused("a power of two from 64 to 4096")) }
    }

    fn real(&self, range: std::ops::RangeInclusive<f64>) -> Result<f64, DesignError> {
        let number = self.value.as_float().or_else(|| self.value.as_integer().map(|number| number as f64));
        // NaN is in no range.
        number.filter(|number| range.contains(number)).ok_or_else(|| self.refused(format!("a number {}", span(&range))))
    }

    fn format(&self, allowed: &str, possible: impl Fn(Format) -> bool) -> Result<Format, DesignError> {
        let format = self.value.as_str().and_then(|text| text.parse().ok());
        format.filter(|format| possible(*format)).ok_or_else(|| self.refused(format!("a format from {allowed}")))
    }

    fn list<T: Clone>(
        &self,
        read: impl Fn(&Given) -> Result<T, DesignError>,
    ) -> Result<Cow<'static, [T]>, DesignError> {
        let values = self.value.as_array().ok_or_else(|| self.refused("a list"))?;
        values
            .iter()
            .map(|value| {
                read(&Given { key: self.key, value }).map_err(|error| match error {
                    DesignError::Value { allowed, .. } => self.refused(format!("each must be {allowed}")),
                    other => other,
                })
            })
            .collect()
    }
}

fn span<T: Display>(range: &std::ops::RangeInclusive<T>) -> String {
    format!("from {} to {}", range.start(), range.end())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_the_design_point() {
        assert_eq!(DesignPoint::from_toml("").unwrap(), KT27);
        assert_eq!((KT27.state.bits(), KT27.dog_shift(), KT27.max_dog()), (18, 1, 32767));
        // One DoG LSB is 0.5 DN: FS / 2^17.
        assert_eq!(KT27.dog().lsb(), 0.5);
    }

    #[test]
    fn the_shipped_designs_are_complete_and_the_first_is_the_default() {
        let designs = SHIPPED.map(|(_, text)| DesignPoint::from_file(text).unwrap());
        assert_eq!(designs[0], KT27);
        assert_eq!(DesignPoint::shipped("small"), Some(Ok(designs[2].clone())));
        assert_eq!(DesignPoint::shipped("large"), None);
        let without: String =
            SHIPPED[0].1.lines().filter(|line| !line.starts_with("dog_bits")).collect::<Vec<_>>().join("\n");
        assert_eq!(DesignPoint::from_file(&without), Err(DesignError::Missing("dog_bits")));
    }

    #[test]
    fn a_camera_of_eight_bits_has_steps_of_256_dn() {
        let design = KT27.with_override("pixel=u8.0").unwrap();
        assert_eq!((design.state.to_string(), design.step_bits()), ("u8.2".into(), 8));
        assert_eq!((design.pixel_dn().to_string(), design.state_dn().to_string()), ("u16.-8".into(), "u16.-6".into()));
        // An LSB of the DoG stays half a DN, now 2^7 times smaller than an LSB of the state.
        assert_eq!((design.dog().lsb(), design.dog_shift()), (0.5, -7));
        let picture = Plane::from_vec(2, 1, vec![0x12ff, 0xffff]).unwrap();
        assert_eq!(design.samples(&picture).as_slice(), [0x12, 0xff]);
        assert_eq!(KT27.samples(&picture), picture);
    }

    #[test]
    fn written_out_and_read_again() {
        let mut design = KT27;
        for text in [
            "dog_bits=12",
            "state = u16.4",
            "sigmas=[1, 2.5, 6]",
            "coefficient=\"u0.12\"",
            "ring_radii=[9, 10]",
            "record_fifo=64",
        ] {
            design = design.with_override(text).unwrap();
        }
        assert_eq!(DesignPoint::from_toml(&design.to_toml()).unwrap(), design);
        let file = design.to_file(&["What it is for.".into()]);
        assert!(file.starts_with("# What it is for.\n"));
        assert_eq!(DesignPoint::from_file(&file).unwrap(), design);
        assert_eq!((design.dog_bits, &*design.sigmas), (12, &[1.0, 2.5, 6.0][..]));
        // Twelve bits over the same quarter of full scale: one LSB is 4 DN, 64 LSB of a state with four fraction bits.
        assert_eq!((design.dog().lsb(), design.dog_shift()), (4.0, 6));
    }

    #[test]
    fn every_impossible_value_is_one_line_with_key_value_and_range() {
        for (text, key, value, range) in [
            ("sigmas = [nan, 3.2, 5.12]", "sigmas", "nan", "from 0.3 to 64"),
            ("sigmas = [2.0, inf, 5.12]", "sigmas", "inf", "from 0.3 to 64"),
            ("sigmas = [-2.0, 3.2, 5.12]", "sigmas", "-2.0", "from 0.3 to 64"),
            ("sigmas = [0, 3.2, 5.12]", "sigmas", "[0, 3.2, 5.12]", "from 0.3 to 64"),
            ("sigmas = [2.0, 3.2, 1e9]", "sigmas", "1000000000.0", "from 0.3 to 64"),
            ("sigmas = [3.2, 2.0, 5.12]", "sigmas", "[3.2, 2.0, 5.12]", "rise"),
            ("sigmas = [2.0, 3.2]", "sigmas", "[2.0, 3.2]", "scale_pairs = 2 needs a list of 3, one for each smoother"),
            ("sigmas = 2.0", "sigmas", "2.0", "a list"),
            (
                "scale_pairs = 3",
                "sigmas",
                "[2.0, 3.2, 5.12]",
                "scale_pairs = 3 needs a list of 4, one for each smoother",
            ),
            (
                "scale_pairs = 1\nsigmas = [2.0, 3.2]",
                "look_ahead",
                "[5, 5, 6]",
                "needs a list of 2, one for each smoother",
            ),
            ("scale_pairs = 4", "scale_pairs", "4", "from 1 to 3"),
            ("scale_pairs = 0", "scale_pairs", "0", "from 1 to 3"),
            ("coefficient = 'u0.0'", "coefficient", "\"u0.0\"", "u0.4 to u0.31"),
            ("coefficient = 'u0.200'", "coefficient", "\"u0.200\"", "u0.4 to u0.31"),
            ("state = 'u15.2'", "state", "\"u15.2\"", "u16.0 to u16.12"),
            ("state = 18", "state", "18", "u16.0 to u16.12"),
            ("pixel = 'u7.0'", "pixel", "\"u7.0\"", "u8.0 to u16.0"),
            ("pixel = 'u8.0'\nstate = 'u16.2'", "state", "\"u16.2\"", "u8.0 to u8.12"),
            ("look_ahead = [5, 5, 63]", "look_ahead", "[5, 5, 63]", "from 1 to 10"),
            ("look_ahead = [0, 5, 6]", "look_ahead", "[0, 5, 6]", "from 1 to 10"),
            ("dog_bits = 0", "dog_bits", "0", "from 2 to 16"),
            ("dog_bits = 15.5", "dog_bits", "15.5", "from 2 to 16"),
            ("dog_bits = '''1\n5'''", "dog_bits", "1", "from 2 to 16"),
            ("ring_radii = [12]", "ring_radii", "[12]", "needs a list of 2, one for each scale pair"),
            ("ring_radii = [3, 16]", "ring_radii", "[3, 16]", "from 4 to 16"),
            ("ring_radii = [12, 17]", "ring_radii", "[12, 17]", "from 4 to 16"),
            ("candidate_queue = 500", "candidate_queue", "500", "a power of two from 64 to 4096"),
            ("record_fifo = 32", "record_fifo", "32", "from 64 to 4096"),
            ("threshold_initial = 0", "threshold_initial", "0", "from 1 to 65535"),
            ("width = -1", "width", "-1", "from 1 to 4096"),
        ] {
            let message = DesignPoint::from_toml(text).expect_err(text).to_string();
            for part in [key, value, range] {
                assert!(message.contains(part), "{message:?} does not name {part}");
            }
            assert_eq!(message.lines().count(), 1, "{message:?}");
        }
    }

    #[test]
    fn keys_and_syntax_are_checked() {
        let message = |text| DesignPoint::from_toml(text).unwrap_err().to_string();
        assert!(message("dog_bit = 15").contains("unknown key `dog_bit`; the keys are width"));
        assert!(message("dog_bits = 15\nstate = ").contains("line 2"), "{}", message("dog_bits = 15\nstate = "));
        assert_eq!(message("dog_bits = 15\nstate = ").lines().count(), 1);
        for text in ["dog_bits", "=3", "dog_bits="] {
            assert_eq!(KT27.with_override(text), Err(DesignError::Override(text.into())));
        }
        assert!(matches!(KT27.with_override("dog_bits=1\nwidth=3"), Err(DesignError::Value { .. })));
    }
}
