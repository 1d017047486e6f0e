//! The ports of the top by their names: one list for all who drive it.

use hoverlock_harness::model::{Model, RawSignal, SignalId};

use hoverlock_harness::ModelError;

/// A signal of up to 32 bits, whose type in the model depends on its width.
#[derive(Debug, Clone, Copy)]
pub enum Narrow {
    /// Up to 8 bits.
    Byte(RawSignal<u8>),
    /// Up to 16 bits.
    Half(RawSignal<u16>),
    /// Up to 32 bits.
    Word(RawSignal<u32>),
}

impl Narrow {
    /// Finds it.
    ///
    /// # Errors
    /// Where the model has no such signal, or one of more than 32 bits.
    pub fn find(model: &Model, name: &str) -> Result<Self, ModelError> {
        if let Ok(byte) = model.raw(name) {
            return Ok(Self::Byte(byte));
        }
        if let Ok(half) = model.raw(name) {
            return Ok(Self::Half(half));
        }
        model.raw(name).map(Self::Word)
    }

    /// Reads the value.
    ///
    /// # Safety
    /// As [`RawSignal::get`].
    #[inline(always)]
    pub unsafe fn get(self) -> u32 {
        // SAFETY: the caller's.
        unsafe {
            match self {
                Self::Byte(signal) => signal.get().into(),
                Self::Half(signal) => signal.get().into(),
                Self::Word(signal) => signal.get(),
            }
        }
    }

    /// Writes a value, which must fit the signal.
    ///
    /// # Safety
    /// As [`RawSignal::set`].
    #[inline(always)]
    pub unsafe fn set(self, value: u32) {
        // SAFETY: the caller's.
        unsafe {
            match self {
                Self::Byte(signal) => signal.set(value as u8),
                Self::Half(signal) => signal.set(value as u16),
                Self::Word(signal) => signal.set(value),
            }
        }
    }
}

/// Handles of the ports. They belong to the model they were found in.
pub struct Ports {
    /// `clock`.
    pub clock: RawSignal<u8>,
    /// `reset`.
    pub reset: RawSignal<u8>,
    /// `video_valid`.
    pub valid: RawSignal<u8>,
    /// `video_data`.
    pub data: Narrow,
    /// `video_startofpacket`.
    pub first: RawSignal<u8>,
    /// `video_endofpacket`.
    pub last: RawSignal<u8>,
    /// `video_ready`.
    pub ready: RawSignal<u8>,
    /// `feature_ready`.
    pub feature_ready: RawSignal<u8>,
    /// `feature_valid`.
    pub feature_valid: RawSignal<u8>,
    /// `feature_startofpacket`.
    pub feature_first: RawSignal<u8>,
    /// `feature_endofpacket`.
    pub feature_last: RawSignal<u8>,
    /// `feature_data`, 256 bits.
    pub feature_data: SignalId,
    /// `csr_address`, in 32-bit words.
    pub csr_address: RawSignal<u8>,
    /// `csr_write`.
    pub csr_write: RawSignal<u8>,
    /// `csr_read`.
    pub csr_read: RawSignal<u8>,
    /// `csr_readdata`.
    pub csr_readdata: RawSignal<u32>,
    /// `csr_writedata`.
    pub csr_writedata: RawSignal<u32>,
    /// `irq`.
    pub irq: RawSignal<u8>,
}

impl Ports {
    /// Finds all of them.
    ///
    /// # Errors
    /// Where the model has no such port, or one of another width.
    pub fn find(model: &Model) -> Result<Self, ModelError> {
        Ok(Self {
            clock: model.raw("clock")?,
            reset: model.raw("reset")?,
            valid: model.raw("video_valid")?,
            data: Narrow::find(model, "video_data")?,
            first: model.raw("video_startofpacket")?,
            last: model.raw("video_endofpacket")?,
            ready: model.raw("video_ready")?,
            feature_ready: model.raw("feature_ready")?,
            feature_valid: model.raw("feature_valid")?,
            feature_first: model.raw("feature_startofpacket")?,
            feature_last: model.raw("feature_endofpacket")?,
            feature_data: model.find("feature_data")?,
            csr_address: model.raw("csr_address")?,
            csr_write: model.raw("csr_write")?,
            csr_read: model.raw("csr_read")?,
            csr_readdata: model.raw("csr_readdata")?,
            csr_writedata: model.raw("csr_writedata")?,
            irq: model.raw("irq")?,
        })
    }
}
