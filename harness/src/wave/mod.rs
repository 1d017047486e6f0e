//! Waves.
use crate::error::Error;
use crate::model::Model;
use crate::time::Time;

/// What is recorded, and where to.
#[derive(Default)]
pub(crate) struct Waves {}

impl Waves {
    pub fn sample(&mut self, _model: &mut Model, _now: Time) -> Result<(), Error> {
        Ok(())
    }
}
