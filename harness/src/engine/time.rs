//! Simulation time: whole femtoseconds in 64 bits, which is 5.1 hours.

use std::fmt;
use std::ops::{Add, AddAssign, Mul, Sub};

/// A number and unit that are no simulation time; the text says why.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct InvalidTime(String);

/// A point in simulation time, or a span of it, in femtoseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Time(u64);

impl Time {
    /// Time 0.
    pub const ZERO: Time = Time(0);

    /// Returns `n` femtoseconds.
    pub const fn fs(n: u64) -> Time {
        Time(n)
    }

    /// Returns `n` picoseconds; saturates at the greatest time (5.1 hours).
    pub const fn ps(n: u64) -> Time {
        Time(n.saturating_mul(1_000))
    }

    /// Returns `n` nanoseconds; saturates at the greatest time.
    pub const fn ns(n: u64) -> Time {
        Time(n.saturating_mul(1_000_000))
    }

    /// Returns `n` microseconds; saturates at the greatest time.
    pub const fn us(n: u64) -> Time {
        Time(n.saturating_mul(1_000_000_000))
    }

    /// Returns `n` milliseconds; saturates at the greatest time.
    pub const fn ms(n: u64) -> Time {
        Time(n.saturating_mul(1_000_000_000_000))
    }

    /// Returns `n` seconds; saturates at the greatest time.
    pub const fn s(n: u64) -> Time {
        Time(n.saturating_mul(1_000_000_000_000_000))
    }

    /// Returns a number of a unit (`fs`, `ps`, `ns`, `us`, `ms`, `s` or `sec`), exactly.
    ///
    /// # Errors
    /// If the unit is unknown, or the value is negative, above 18 000 s or not a whole number of femtoseconds.
    pub fn from_unit(value: f64, unit: &str) -> Result<Time, InvalidTime> {
        let scale = match unit {
            "fs" => 1.0,
            "ps" => 1e3,
            "ns" => 1e6,
            "us" => 1e9,
            "ms" => 1e12,
            "s" | "sec" => 1e15,
            _ => return Err(InvalidTime(format!("no unit '{unit}': fs, ps, ns, us, ms or s"))),
        };
        let femtoseconds = value * scale;
        if !(0.0..1.8e19).contains(&femtoseconds) {
            return Err(InvalidTime(format!("{value} {unit} is not a time from 0 to 18000 s")));
        }
        let whole = femtoseconds.round();
        // A double has 53 bits: the difference between 0.1 ns and 100000 fs is rounding, not a fraction of a
        // femtosecond.
        if (femtoseconds - whole).abs() > 1e-3 + femtoseconds * 1e-15 {
            return Err(InvalidTime(format!("{value} {unit} is not a whole number of femtoseconds")));
        }
        Ok(Time(whole as u64))
    }

    /// Returns the time in femtoseconds.
    pub const fn as_fs(self) -> u64 {
        self.0
    }

    /// Returns the sum, or the greatest time.
    pub const fn saturating_add(self, other: Time) -> Time {
        Time(self.0.saturating_add(other.0))
    }
}

impl Add for Time {
    type Output = Time;
    fn add(self, other: Time) -> Time {
        self.saturating_add(other)
    }
}

impl AddAssign for Time {
    fn add_assign(&mut self, other: Time) {
        *self = *self + other;
    }
}

impl Sub for Time {
    type Output = Time;
    fn sub(self, other: Time) -> Time {
        Time(self.0.saturating_sub(other.0))
    }
}

impl Mul<u64> for Time {
    type Output = Time;
    fn mul(self, n: u64) -> Time {
        Time(self.0.saturating_mul(n))
    }
}

impl fmt::Display for Time {
    /// Writes the time in nanoseconds without trailing zeros: `10 ns`, `2.5 ns`, `0.000001 ns`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (whole, rest) = (self.0 / 1_000_000, self.0 % 1_000_000);
        if rest == 0 {
            write!(f, "{whole} ns")
        } else {
            let digits = format!("{rest:06}");
            write!(f, "{whole}.{} ns", digits.trim_end_matches('0'))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_exact_and_printed_shortly() {
        assert_eq!(Time::from_unit(0.1, "ns").unwrap(), Time::ps(100));
        assert_eq!(Time::from_unit(3.0, "s").unwrap(), Time::s(3));
        assert_eq!(Time::ns(10).to_string(), "10 ns");
        assert_eq!(Time::ps(2500).to_string(), "2.5 ns");
        assert_eq!(Time::fs(1).to_string(), "0.000001 ns");
        assert_eq!(Time::s(u64::MAX), Time::fs(u64::MAX));
    }

    #[test]
    fn half_a_femtosecond_and_unknown_units_are_refused() {
        assert!(Time::from_unit(0.5, "fs").is_err());
        assert!(Time::from_unit(-1.0, "ns").is_err());
        assert!(Time::from_unit(f64::NAN, "ns").is_err());
        assert!(Time::from_unit(1.0, "step").is_err());
        assert!(Time::from_unit(1e9, "s").is_err());
    }
}
