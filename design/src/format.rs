//! Fixed-point formats: a raw integer of `w = s + i + f` bits represents the value `raw * 2^-f`.
//!
//! `u16.2` has no sign, `i = 16` integer bits and `f = 2` fraction bits, so 18 bits in all: `0 ..= 2^16 - 2^-2` with an
//! LSB of `2^-2`. `s14.1` is two's complement, sign bit not counted: `-2^14 ..= 2^14 - 2^-1`. Either number may be
//! negative: `u14.-2` has 12 bits and an LSB of 4.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Largest number of bits of a format. The product of a raw integer and a coefficient of 30 bits then fits 64 bits.
pub const MAX_BITS: u32 = 32;

/// The reason why a text is not a format.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FormatError {
    /// Not of the form `u16.2` or `s14.1`.
    #[error("`{0}` is not a format: write u or s, integer bits, a point, fraction bits, like u16.2")]
    Syntax(String),
    /// No bits, or more than 32.
    #[error("`{text}` has {bits} bits; a format has 1 to {MAX_BITS}")]
    Width {
        /// The text given.
        text: String,
        /// Its number of bits.
        bits: i32,
    },
}

/// A fixed-point format: sign, integer bits and fraction bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Format {
    signed: bool,
    integer_bits: i8,
    fraction_bits: i8,
}

impl Format {
    /// Makes an unsigned format.
    ///
    /// # Panics
    /// The format has no bits or more than 32. In a constant this is a compile-time error.
    pub const fn unsigned(integer_bits: i8, fraction_bits: i8) -> Self {
        let bits = integer_bits as i32 + fraction_bits as i32;
        assert!(bits >= 1 && bits <= MAX_BITS as i32, "a format has 1 to 32 bits");
        Self { signed: false, integer_bits, fraction_bits }
    }

    /// Returns the signed format with the same magnitude bits.
    ///
    /// # Panics
    /// The format has 32 magnitude bits already.
    pub const fn with_sign(self) -> Self {
        let format = Self { signed: true, ..self };
        assert!(format.bits() <= MAX_BITS, "no bit is left for the sign");
        format
    }

    /// Returns `true` if the format has a sign bit.
    pub const fn is_signed(self) -> bool {
        self.signed
    }

    /// Returns the number of bits before the point, without the sign bit.
    pub const fn integer_bits(self) -> i8 {
        self.integer_bits
    }

    /// Returns the number of bits after the point.
    pub const fn fraction_bits(self) -> i8 {
        self.fraction_bits
    }

    /// Returns the number of bits, sign bit included.
    pub const fn bits(self) -> u32 {
        (self.signed as i32 + self.integer_bits as i32 + self.fraction_bits as i32) as u32
    }

    /// Returns the LSB, `2^-f`.
    pub fn lsb(self) -> f64 {
        f64::from(-i32::from(self.fraction_bits)).exp2()
    }

    /// Returns the smallest raw integer.
    pub const fn min_raw(self) -> i64 {
        if self.signed { -(1 << (self.bits() - 1)) } else { 0 }
    }

    /// Returns the largest raw integer.
    pub const fn max_raw(self) -> i64 {
        (1 << (self.bits() - self.signed as u32)) - 1
    }

    /// Returns the value of a raw integer, `raw * 2^-f`.
    pub fn value(self, raw: i64) -> f64 {
        raw as f64 * self.lsb()
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&format!("{}{}.{}", if self.signed { 's' } else { 'u' }, self.integer_bits, self.fraction_bits))
    }
}

impl FromStr for Format {
    type Err = FormatError;

    fn from_str(text: &str) -> Result<Self, FormatError> {
        let syntax = || FormatError::Syntax(text.into());
        let (signed, numbers) = match (text.strip_prefix('u'), text.strip_prefix('s')) {
            (Some(rest), _) => (false, rest),
            (_, Some(rest)) => (true, rest),
            _ => return Err(syntax()),
        };
        let (integer, fraction) = numbers.split_once('.').ok_or_else(syntax)?;
        let number = |digits: &str| {
            let plain = !digits.starts_with('+');
            digits.parse::<i8>().ok().filter(|_| plain).ok_or_else(syntax)
        };
        let (integer_bits, fraction_bits) = (number(integer)?, number(fraction)?);
        let bits = i32::from(signed) + i32::from(integer_bits) + i32::from(fraction_bits);
        if !(1..=MAX_BITS as i32).contains(&bits) {
            return Err(FormatError::Width { text: text.into(), bits });
        }
        Ok(Self { signed, integer_bits, fraction_bits })
    }
}

impl TryFrom<String> for Format {
    type Error = FormatError;

    fn try_from(text: String) -> Result<Self, FormatError> {
        text.parse()
    }
}

impl From<Format> for String {
    fn from(format: Format) -> Self {
        format.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn design_formats_have_the_widths_of_the_hardware() {
        for (text, bits, lsb, max) in
            [("u16.2", 18, 0.25, 262_143), ("u0.16", 16, 1.0 / 65536.0, 65535), ("u14.1", 15, 0.5, 32767)]
        {
            let format: Format = text.parse().unwrap();
            assert_eq!((format.bits(), format.lsb(), format.max_raw()), (bits, lsb, max));
            assert_eq!(format.to_string(), text);
        }
        let signed: Format = "s14.1".parse().unwrap();
        assert_eq!((signed.bits(), signed.min_raw(), signed.max_raw()), (16, -32768, 32767));
        assert_eq!("u14.-2".parse::<Format>().unwrap().lsb(), 4.0);
    }

    #[test]
    fn invalid_formats_are_refused() {
        for text in ["", "16.2", "u16", "u.2", "u16.", "u16.2.1", "u+16.2", "q16.2", "u 16.2", "u999.2", "uNaN.1"] {
            assert_eq!(text.parse::<Format>(), Err(FormatError::Syntax(text.into())));
        }
        for (text, bits) in [("u0.0", 0), ("u16.100", 116), ("u-3.1", -2), ("u120.120", 240)] {
            assert_eq!(text.parse::<Format>(), Err(FormatError::Width { text: text.into(), bits }));
        }
    }

    proptest! {
        #[test]
        fn text_and_format_convert_both_ways(signed: bool, integer in -20i8..=20, fraction in -20i8..=20) {
            let text = format!("{}{integer}.{fraction}", if signed { 's' } else { 'u' });
            if let Ok(format) = text.parse::<Format>() {
                prop_assert_eq!(format.to_string(), text);
            } else {
                let bits = i32::from(signed) + i32::from(integer) + i32::from(fraction);
                prop_assert!(!(1..=32).contains(&bits));
            }
        }
    }
}
