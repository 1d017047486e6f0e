//! What can be expected of a scene.

use super::{Ground, Relief, Scene};

impl Scene {
    /// Nothing on it stays where it is.
    pub fn is_water(&self) -> bool {
        matches!(self.ground, Ground::Water(_))
    }

    /// No relief, and nothing stands on it.
    pub fn is_flat(&self) -> bool {
        let level = match &self.relief {
            None => true,
            Some(Relief::Hills(hills)) => hills.rms_m == 0.0,
            Some(Relief::Map(_)) => false,
        };
        level && self.building.is_empty() && self.tree.is_empty() && !matches!(self.ground, Ground::Town(_))
    }
}
