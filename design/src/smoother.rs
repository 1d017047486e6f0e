//! The smoother of the levels in floating point.

use std::fmt;

use serde::{Serialize, Serializer};

/// A family of recursive smoothers. The hardware and its bit-true model are first-order whatever a design names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SmootherKind {
    /// Two-sided first order, which the hardware has.
    FirstOrder,
    /// Deriche 1993, of order 4.
    Deriche,
    /// Young and van Vliet 1995.
    Yvv95,
    /// Van Vliet, Young and Verbeek 1998, of order 3.
    Vyv,
}

impl SmootherKind {
    /// All kinds, that of the hardware first.
    pub const ALL: [Self; 4] = [Self::FirstOrder, Self::Deriche, Self::Yvv95, Self::Vyv];

    /// Returns the name in a design file.
    pub fn name(self) -> &'static str {
        match self {
            Self::FirstOrder => "first-order",
            Self::Deriche => "deriche",
            Self::Yvv95 => "yvv95",
            Self::Vyv => "vyv",
        }
    }

    /// Returns the kind of this name; `None` if there is none.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

impl fmt::Display for SmootherKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl Serialize for SmootherKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}
