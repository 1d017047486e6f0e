//! Design files, configurations and overrides: reading and writing.

use toml::{Table, Value};

use crate::{DesignError, DesignPoint, Format, KEYS, Key};

impl DesignPoint {
    /// Reads a design file, which has every key.
    ///
    /// # Errors
    /// As [`DesignPoint::with_toml`], and if a key is missing.
    pub fn from_file(text: &str) -> Result<Self, DesignError> {
        let table = parse(text)?;
        match KEYS.iter().find(|key| !table.contains_key(key.name)) {
            Some(key) => Err(DesignError::Missing(key.name)),
            None => Self::unset().changed(&table),
        }
    }

    /// Returns this design changed by a configuration: a TOML text with some of the keys.
    ///
    /// # Errors
    /// The text is not TOML, has an unknown key, or has a value that is out of range or does not fit the others.
    pub fn with_toml(&self, text: &str) -> Result<Self, DesignError> {
        self.changed(&parse(text)?)
    }

    /// Returns this design with one value changed: `KEY=VALUE`, the value as in TOML; quotes around a format are
    /// optional.
    ///
    /// # Errors
    /// As [`DesignPoint::with_toml`], and if the text is not of that form.
    pub fn with_override(&self, text: &str) -> Result<Self, DesignError> {
        self.with_overrides([text])
    }

    /// Returns this design with values changed together, so that lists follow the number of scale pairs. Of a key that
    /// is changed twice the later value counts.
    ///
    /// # Errors
    /// As [`DesignPoint::with_override`].
    pub fn with_overrides<'a>(&self, texts: impl IntoIterator<Item = &'a str>) -> Result<Self, DesignError> {
        self.changed(&texts.into_iter().map(entry).collect::<Result<_, _>>()?)
    }

    /// Returns the changes that make this design of `base`, as [`DesignPoint::with_overrides`] takes them.
    pub fn changes_of(&self, base: &Self) -> Vec<String> {
        let differs = |key: &&Key| key.value(self) != key.value(base);
        KEYS.iter().filter(differs).map(|key| format!("{}={}", key.name, key.value(self))).collect()
    }

    /// Returns this design with the values of a table, which are checked together.
    ///
    /// # Errors
    /// A key is unknown, or a value is out of range or does not fit the others.
    pub(crate) fn changed(&self, table: &Table) -> Result<Self, DesignError> {
        if let Some(key) = table.keys().find(|key| Key::named(key).is_none()) {
            return Err(DesignError::UnknownKey { key: key.clone() });
        }
        let mut changed = self.clone();
        for key in &KEYS {
            if let Some(value) = table.get(key.name) {
                key.set(&mut changed, value)?;
            }
            // The state has the integer bits of the pixel. If only the pixel is given, the fraction bits stay.
            if key.name == "pixel" {
                changed.state = Format::unsigned(changed.pixel.integer_bits(), changed.state.fraction_bits());
            }
        }
        changed.check()?;
        Ok(changed)
    }

    /// Checks that involve several values.
    fn check(&self) -> Result<(), DesignError> {
        for key in &KEYS {
            key.check_length(self)?;
            if key.name == "sigmas" && !self.sigmas.is_sorted_by(|narrow, wide| narrow < wide) {
                return Err(key.rejected(key.value(self), "they must rise from the narrowest to the widest"));
            }
        }
        Ok(())
    }

    /// Returns this design as TOML: every key, in the order of [`KEYS`], one line each.
    pub fn to_toml(&self) -> String {
        KEYS.iter().map(|key| format!("{} = {}\n", key.name, key.value(self).to_toml())).collect()
    }

    /// Returns this design as a design file: `heading` as [`comment`]s, then every key with its meaning, unit and
    /// limits.
    pub fn to_file(&self, heading: &[String]) -> String {
        let mut text: String = heading.iter().map(|line| format!("# {}\n", comment(line))).collect();
        text += "# DN: one step of a 16-bit sample; full scale is 2^16 DN. A camera of P bits has steps of \
                 2^(16 - P) DN.\n";
        for key in &KEYS {
            text += &format!("\n# {}\n# Unit: {}. Values: {}.\n", key.meaning, key.unit, key.limits(self));
            for limit in key.hardware_limits() {
                text += &format!("# In hardware: {limit}.\n");
            }
            text += &format!("{} = {}\n", key.name, key.value(self).to_toml());
        }
        text
    }
}

/// Returns a text that stays within a comment of one line in a design file, C, Rust, Verilog or a memory file: control
/// characters become spaces, and the beginning and end of a comment of C get one between their signs.
pub fn comment(text: &str) -> String {
    text.replace(char::is_control, " ").replace("*/", "* /").replace("/*", "/ *")
}

/// Returns key and value of `KEY=VALUE`.
pub(crate) fn entry(text: &str) -> Result<(String, Value), DesignError> {
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
    Ok((key.to_owned(), value))
}

pub(crate) fn parse(text: &str) -> Result<Table, DesignError> {
    text.parse().map_err(|error: toml::de::Error| {
        let line = error.span().map_or(1, |span| text[..span.start].lines().count().max(1));
        DesignError::Syntax(format!("line {line}: {}", error.message().lines().collect::<Vec<_>>().join(", ")))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::KT27;

    #[test]
    fn a_design_is_written_and_read_again() {
        let mut design = KT27.clone();
        for text in [
            "dog_bits=12",
            "state = u16.4",
            "sigmas=[1, 2.5, 6]",
            "coefficient=\"u0.12\"",
            "ring_radii=[9, 10]",
            "record_fifo=64",
            "smoother=deriche",
            "protection=parity",
        ] {
            design = design.with_override(text).unwrap();
        }
        assert_eq!(KT27.with_toml(&design.to_toml()).unwrap(), design);
        let file = design.to_file(&["What it is for.\nstate = \"u1.0\"".into()]);
        assert!(file.starts_with("# What it is for. state = \"u1.0\"\n"), "{file}");
        assert_eq!(DesignPoint::from_file(&file).unwrap(), design);
        assert_eq!((design.dog_bits, &*design.sigmas), (12, &[1.0, 2.5, 6.0][..]));
        // Twelve bits over the same quarter of full scale: one LSB is 4 DN, 64 LSB of a state with four fraction bits.
        assert_eq!((design.dog().lsb(), design.dog_shift()), (4.0, 6));
    }

    #[test]
    fn a_comment_is_one_line_and_does_not_end_early() {
        for (text, within) in [("a b.toml", "a b.toml"), ("a\nb\r\tc", "a b  c"), ("x*/y/*z*/*", "x* /y/ *z* / *")] {
            assert_eq!(comment(text), within);
        }
    }

    #[test]
    fn every_impossible_value_is_one_line_with_key_value_and_range() {
        for (text, key, value, range) in [
            ("sigmas = [nan, 3.2, 5.12]", "sigmas", "nan", "from 0.5 to 64"),
            ("sigmas = [2.0, inf, 5.12]", "sigmas", "inf", "from 0.5 to 64"),
            ("sigmas = [-2.0, 3.2, 5.12]", "sigmas", "-2.0", "from 0.5 to 64"),
            ("sigmas = [0, 3.2, 5.12]", "sigmas", "[0, 3.2, 5.12]", "from 0.5 to 64"),
            ("sigmas = [2.0, 3.2, 1e9]", "sigmas", "1000000000.0", "from 0.5 to 64"),
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
            ("smoother = 'gauss'", "smoother", "\"gauss\"", "one of first-order, deriche, yvv95, vyv"),
            ("smoother = 1", "smoother", "1", "one of first-order"),
            ("protection = 'ecc'", "protection", "\"ecc\"", "one of off, parity"),
            ("threshold_initial = 0", "threshold_initial", "0", "from 1 to 65535"),
            ("width = -1", "width", "-1", "from 1 to 4096"),
        ] {
            let message = KT27.with_toml(text).expect_err(text).to_string();
            for part in [key, value, range] {
                assert!(message.contains(part), "{message:?} does not name {part}");
            }
            assert_eq!(message.lines().count(), 1, "{message:?}");
        }
    }

    #[test]
    fn keys_and_syntax_are_checked() {
        let message = |text| KT27.with_toml(text).unwrap_err().to_string();
        assert!(message("dog_bit = 15").contains("unknown key `dog_bit`; the keys are width"));
        assert!(message("dog_bits = 15\nstate = ").contains("line 2"), "{}", message("dog_bits = 15\nstate = "));
        assert_eq!(message("dog_bits = 15\nstate = ").lines().count(), 1);
        for text in ["dog_bits", "=3", "dog_bits="] {
            assert_eq!(KT27.with_override(text), Err(DesignError::Override(text.into())));
        }
        assert!(matches!(KT27.with_override("dog_bits=1\nwidth=3"), Err(DesignError::Value { .. })));
    }
}
