//! The design files that are built in.

use std::sync::LazyLock;

use crate::DesignPoint;

/// The design files that are built in, as name and text. The first one is the default.
pub const SHIPPED: [(&str, &str); 4] = [
    ("kt27", include_str!("../../designs/kt27.toml")),
    ("hd1080", include_str!("../../designs/hd1080.toml")),
    ("small", include_str!("../../designs/small.toml")),
    ("three_scales", include_str!("../../designs/three_scales.toml")),
];

/// The default design: the KT-27 camera with 1024 x 768 pixels of 16 bits, 15 frames a second.
pub static KT27: LazyLock<DesignPoint> = LazyLock::new(|| parse(SHIPPED[0].1));

impl Default for DesignPoint {
    fn default() -> Self {
        KT27.clone()
    }
}

impl DesignPoint {
    /// Returns the design that is built in under `name`, or `None` if there is none.
    pub fn shipped(name: &str) -> Option<Self> {
        SHIPPED.iter().find(|(known, _)| *known == name).map(|(_, text)| parse(text))
    }
}

fn parse(text: &str) -> DesignPoint {
    DesignPoint::from_file(text).expect("a test parses every built-in design file")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DesignError, KEYS};

    #[test]
    fn every_shipped_file_is_complete_and_the_default_is_the_first() {
        for (name, text) in SHIPPED {
            let design = DesignPoint::from_file(text).unwrap();
            assert_eq!(design.check_buildable(), Ok(()), "{name}");
            assert_eq!(DesignPoint::shipped(name), Some(design));
        }
        assert_eq!((DesignPoint::default(), DesignPoint::shipped("kt27").unwrap()), (KT27.clone(), KT27.clone()));
        assert_eq!(DesignPoint::shipped("large"), None);
    }

    #[test]
    fn a_file_without_one_of_the_keys_is_rejected() {
        for key in &KEYS {
            let lines: Vec<_> = SHIPPED[0].1.lines().filter(|line| !line.starts_with(key.name)).collect();
            assert_eq!(DesignPoint::from_file(&lines.join("\n")), Err(DesignError::Missing(key.name)));
        }
    }

    #[test]
    fn the_default_has_the_widths_of_the_committed_hardware() {
        assert_eq!((KT27.state.bits(), KT27.dog_shift(), KT27.max_dog()), (18, 1, 32767));
        // One DoG LSB is 0.5 DN: FS / 2^17.
        assert_eq!(KT27.dog().lsb(), 0.5);
    }
}
