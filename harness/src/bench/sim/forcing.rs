//! Force, freeze and release: values that override what the design assigns.

use std::rc::Rc;

use super::scheduler::Core;
use super::signal::Wide;
use crate::engine::error::ModelError;
use crate::engine::model::SignalId;

/// A signal that can be forced, made so by [`Build::forceable`](crate::engine::build::Build::forceable).
///
/// A bit whose `enable` is 1 has the forced value, for the design as for the bench: `enable ? value : assigned`.
#[derive(Clone)]
pub struct Forcing {
    signal: Wide,
    enable: Wide,
    value: Wide,
}

impl Forcing {
    pub(crate) fn new(core: &Rc<Core>, signal: SignalId) -> Result<Forcing, ModelError> {
        let (enable, value) = core.model.borrow().force_of(signal)?;
        let of = |id| Wide::new(core, id);
        Ok(Forcing { signal: of(signal)?, enable: of(enable)?, value: of(value)? })
    }

    /// Forces the bits that are 1 in `bits` to those of `value`, both as 32-bit words, lowest first. Put like a write,
    /// when all tasks of this round have run.
    ///
    /// # Errors
    /// If the value or the bits do not fit the signal, or the region is `ReadOnly`.
    pub fn force(&self, value: &[u32], bits: &[u32]) -> Result<(), ModelError> {
        self.signal.info().check_words(value)?;
        let forced: Vec<u32> = value.iter().zip(bits).map(|(value, bits)| value & bits).collect();
        self.value.set_bits(bits, &forced)?;
        self.enable.set_bits(bits, bits)
    }

    /// Forces the bits that are 1 in `bits` to the values they have now.
    ///
    /// # Errors
    /// As [`Forcing::force`].
    pub fn freeze(&self, bits: &[u32]) -> Result<(), ModelError> {
        self.force(&self.signal.get(), bits)
    }

    /// Ends the force of the bits that are 1 in `bits`: they have again what the design assigns.
    ///
    /// # Errors
    /// As [`Forcing::force`].
    pub fn release(&self, bits: &[u32]) -> Result<(), ModelError> {
        self.enable.set_bits(bits, &[])
    }

    /// Returns a mask of all bits of the signal as 32-bit words, lowest first.
    pub fn all_bits(&self) -> Vec<u32> {
        let width = self.signal.width();
        (0..width.div_ceil(32)).map(|at| u32::MAX >> (32 - (width - 32 * at).min(32))).collect()
    }
}
