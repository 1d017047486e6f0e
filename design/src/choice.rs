//! Values of a key that are names: the smoother of the levels in floating point, and the protection of memories.

use std::fmt;

use serde::{Serialize, Serializer};

/// Defines an enumeration whose values have names in a design file, and its display by these names.
macro_rules! choice {
    ($(#[$doc:meta])* $choice:ident { $($(#[$value_doc:meta])* $value:ident = $name:literal,)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum $choice {
            $($(#[$value_doc])* $value,)*
        }

        impl $choice {
            /// All values.
            pub const ALL: &[Self] = &[$(Self::$value),*];

            /// The names in a design file, in the order of [`Self::ALL`].
            pub(crate) const NAMES: &[&str] = &[$($name),*];

            /// Returns the name in a design file.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$value => $name,)*
                }
            }
        }

        impl fmt::Display for $choice {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.pad(self.name())
            }
        }

        impl Serialize for $choice {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.name())
            }
        }
    };
}

choice! {
    /// A family of recursive smoothers. The hardware and its bit-true model are first-order whatever a design names.
    SmootherKind {
        /// Two-sided first order, which the hardware has.
        FirstOrder = "first-order",
        /// Deriche 1993, of order 4.
        Deriche = "deriche",
        /// Young and van Vliet 1995.
        Yvv95 = "yvv95",
        /// Van Vliet, Young and Verbeek 1998, of order 3.
        Vyv = "vyv",
    }
}

choice! {
    /// What the block memories of the hardware keep besides the data. It changes no sample and no record.
    Protection {
        /// Memories hold the data alone, and a flipped bit shows nowhere.
        Off = "off",
        /// A parity bit with each sample, candidate and record: a flipped bit marks the frame that reads it.
        Parity = "parity",
    }
}
