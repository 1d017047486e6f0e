//! Properties of a scene that decide what accuracy to expect.

use super::{Ground, Relief, Scene};

impl Scene {
    /// Returns `true` if the ground is water, on which no pattern stays in place.
    pub fn is_water(&self) -> bool {
        matches!(self.ground, Ground::Water(_))
    }

    /// Returns `true` if the ground is level and has no buildings, and no trees but those that grow in a field.
    pub fn is_flat(&self) -> bool {
        let level = match &self.relief {
            None => true,
            Some(Relief::Hills(hills)) => hills.rms_m == 0.0,
            Some(Relief::Map(_)) => false,
        };
        level && self.building.is_empty() && self.tree.is_empty() && !matches!(self.ground, Ground::Town(_))
    }
}
