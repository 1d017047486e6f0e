//! One key of a design file: unit, meaning, limits, and access to its field of a [`DesignPoint`].

use std::fmt;
use std::ops::RangeInclusive;

use toml::Value;

use crate::hardware::CONSTRAINTS;
use crate::{DesignError, DesignPoint, Format, KEYS};

/// A key of a design file.
pub struct Key {
    /// The key as written in a file.
    pub name: &'static str,
    /// Unit of the value, or of each element of a list.
    pub unit: &'static str,
    /// What the value determines, without unit and limits.
    pub meaning: &'static str,
    pub(crate) kind: Kind,
}

/// Type and limits of a value, and the field that holds it.
pub(crate) enum Kind {
    /// A whole number in a range.
    Whole(RangeInclusive<u32>, Field<u32>),
    /// A power of two in a range.
    PowerOfTwo(RangeInclusive<u32>, Field<u32>),
    /// An unsigned format with integer and fraction bits in ranges.
    Format { integer: IntegerBits, fraction: RangeInclusive<i8>, field: Field<Format> },
    /// A list of whole numbers in a range.
    Wholes(RangeInclusive<u32>, Length, Field<Vec<u32>>),
    /// A list of numbers in a range.
    Reals(RangeInclusive<f64>, Length, Field<Vec<f64>>),
    /// One of some names, and access to it by its index.
    Name(&'static [&'static str], NamedField),
}

/// Integer bits that a format may have.
pub(crate) enum IntegerBits {
    Range(RangeInclusive<i8>),
    /// As many as the pixel of the same design has.
    OfPixel,
}

/// Length of a list.
#[derive(Clone, Copy)]
pub(crate) enum Length {
    PerSmoother,
    PerScalePair,
}

/// Access to a field of a [`DesignPoint`].
pub(crate) struct Field<T> {
    pub get: fn(&DesignPoint) -> &T,
    pub get_mut: fn(&mut DesignPoint) -> &mut T,
}

/// Access to a field of a [`DesignPoint`] whose values have names, by the index of the name.
pub(crate) struct NamedField {
    pub get: fn(&DesignPoint) -> usize,
    pub set: fn(&mut DesignPoint, usize),
}

/// Makes the [`Kind`] of a field of a choice.
macro_rules! named {
    ($choice:ident, $field:ident) => {
        Kind::Name(
            $choice::NAMES,
            NamedField {
                get: |design| design.$field as usize,
                set: |design, index| design.$field = $choice::ALL[index],
            },
        )
    };
}
pub(crate) use named;

/// Makes the [`Field`] of a path such as `threshold.target`.
macro_rules! field {
    ($($path:ident).+) => {
        Field { get: |design| &design.$($path).+, get_mut: |design| &mut design.$($path).+ }
    };
}
pub(crate) use field;

/// The value of a key in a design.
///
/// It is displayed as in an override: formats without quotes, lists in brackets.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(untagged)]
#[allow(missing_docs, reason = "each variant is named like its type")]
pub enum KeyValue {
    Whole(u32),
    Format(Format),
    Wholes(Vec<u32>),
    Reals(Vec<f64>),
    Name(&'static str),
}

impl fmt::Display for KeyValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole(number) => write!(f, "{number}"),
            Self::Format(format) => write!(f, "{format}"),
            Self::Wholes(numbers) => write!(f, "{numbers:?}"),
            Self::Reals(numbers) => write!(f, "{numbers:?}"),
            Self::Name(name) => write!(f, "{name}"),
        }
    }
}

impl KeyValue {
    /// Returns the value as TOML.
    pub(crate) fn to_toml(&self) -> String {
        match self {
            Self::Format(_) | Self::Name(_) => format!("\"{self}\""),
            other => other.to_string(),
        }
    }
}

impl Length {
    fn of(self, design: &DesignPoint) -> usize {
        match self {
            Self::PerSmoother => design.smoothers(),
            Self::PerScalePair => design.pairs(),
        }
    }

    fn unit(self) -> &'static str {
        match self {
            Self::PerSmoother => "one for each smoother",
            Self::PerScalePair => "one for each scale pair",
        }
    }
}

impl Key {
    /// Returns the key of [`KEYS`] with this name, or `None` if there is none.
    pub fn named(name: &str) -> Option<&'static Self> {
        KEYS.iter().find(|key| key.name == name)
    }

    /// Returns the value of this key in `design`.
    pub fn value(&self, design: &DesignPoint) -> KeyValue {
        match &self.kind {
            Kind::Whole(_, field) | Kind::PowerOfTwo(_, field) => KeyValue::Whole(*(field.get)(design)),
            Kind::Format { field, .. } => KeyValue::Format(*(field.get)(design)),
            Kind::Wholes(_, _, field) => KeyValue::Wholes((field.get)(design).clone()),
            Kind::Reals(_, _, field) => KeyValue::Reals((field.get)(design).clone()),
            Kind::Name(names, field) => KeyValue::Name(names[(field.get)(design)]),
        }
    }

    /// Returns the allowed values, like `a whole number from 1 to 4096`. Those of `state` depend on the pixel of
    /// `design`.
    pub fn limits(&self, design: &DesignPoint) -> String {
        match &self.kind {
            Kind::Whole(range, _) => format!("a whole number {}", span(range)),
            Kind::PowerOfTwo(range, _) => format!("a power of two {}", span(range)),
            Kind::Format { integer, fraction, .. } => {
                let bits = integer.of(design);
                let (least, most) = (bits.start(), bits.end());
                let of_pixel =
                    if matches!(integer, IntegerBits::OfPixel) { ", with the bits of the pixel" } else { "" };
                format!("a format from u{least}.{} to u{most}.{}{of_pixel}", fraction.start(), fraction.end())
            }
            Kind::Wholes(range, length, _) => format!("a list of whole numbers {}, {}", span(range), length.unit()),
            Kind::Reals(range, length, _) => format!("a list of numbers {}, {}", span(range), length.unit()),
            Kind::Name(names, _) => format!("one of {}", names.join(", ")),
        }
    }

    /// Returns the requirements of the hardware, which may be stricter than [`Key::limits`], one sentence each.
    pub fn hardware_limits(&self) -> impl Iterator<Item = &'static str> {
        CONSTRAINTS.iter().filter(|constraint| constraint.key == self.name).map(|constraint| constraint.reason)
    }

    /// Sets the field of this key to a value of a file. Lengths of lists are checked by [`Key::check_length`].
    pub(crate) fn set(&self, design: &mut DesignPoint, value: &Value) -> Result<(), DesignError> {
        let rejected = self.rejected(value, self.limits(design));
        let is_set = match &self.kind {
            Kind::Whole(range, field) => assign(design, field, whole(value, range)),
            Kind::PowerOfTwo(range, field) => {
                assign(design, field, whole(value, range).filter(|number| number.is_power_of_two()))
            }
            Kind::Format { integer, fraction, field } => {
                let integer = integer.of(design);
                let format = value.as_str().and_then(|text| text.parse().ok());
                let is_allowed = |format: &Format| {
                    !format.is_signed()
                        && integer.contains(&format.integer_bits())
                        && fraction.contains(&format.fraction_bits())
                };
                assign(design, field, format.filter(is_allowed))
            }
            Kind::Wholes(range, _, field) => assign(design, field, list(value, |value| whole(value, range))),
            Kind::Reals(range, _, field) => assign(design, field, list(value, |value| real(value, range))),
            Kind::Name(names, field) => {
                let index = value.as_str().and_then(|text| names.iter().position(|name| *name == text));
                index.map(|index| (field.set)(design, index))
            }
        };
        is_set.ok_or(rejected)
    }

    /// Checks that a list has the length that the number of scale pairs requires.
    pub(crate) fn check_length(&self, design: &DesignPoint) -> Result<(), DesignError> {
        let (length, found) = match &self.kind {
            Kind::Wholes(_, length, field) => (*length, (field.get)(design).len()),
            Kind::Reals(_, length, field) => (*length, (field.get)(design).len()),
            _ => return Ok(()),
        };
        let (required, pairs) = (length.of(design), design.scale_pairs);
        if found == required {
            return Ok(());
        }
        let allowed = format!("scale_pairs = {pairs} needs a list of {required}, {}", length.unit());
        Err(self.rejected(self.value(design), allowed))
    }

    pub(crate) fn rejected(&self, value: impl fmt::Display, allowed: impl Into<String>) -> DesignError {
        let value = value.to_string().lines().collect::<Vec<_>>().join(" ");
        DesignError::Value { key: self.name, value, allowed: allowed.into() }
    }
}

impl IntegerBits {
    fn of(&self, design: &DesignPoint) -> RangeInclusive<i8> {
        match self {
            Self::Range(range) => range.clone(),
            Self::OfPixel => design.pixel.integer_bits()..=design.pixel.integer_bits(),
        }
    }
}

fn assign<T>(design: &mut DesignPoint, field: &Field<T>, value: Option<T>) -> Option<()> {
    *(field.get_mut)(design) = value?;
    Some(())
}

fn whole(value: &Value, range: &RangeInclusive<u32>) -> Option<u32> {
    let number = value.as_integer().and_then(|number| u32::try_from(number).ok());
    number.filter(|number| range.contains(number))
}

fn real(value: &Value, range: &RangeInclusive<f64>) -> Option<f64> {
    let number = value.as_float().or_else(|| value.as_integer().map(|number| number as f64));
    // NaN is in no range.
    number.filter(|number| range.contains(number))
}

fn list<T>(value: &Value, read: impl Fn(&Value) -> Option<T>) -> Option<Vec<T>> {
    value.as_array()?.iter().map(read).collect()
}

fn span<T: fmt::Display>(range: &RangeInclusive<T>) -> String {
    format!("from {} to {}", range.start(), range.end())
}
