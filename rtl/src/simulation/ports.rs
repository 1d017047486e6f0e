//! The ports of the top by their names: one list for all who drive it.

use hoverlock_harness::model::{Model, RawSignal, SignalId};

use hoverlock_harness::ModelError;

/// Handles of the ports. They belong to the model they were found in.
pub struct Ports {
    /// `clock`.
    pub clock: RawSignal<u8>,
    /// `reset`.
    pub reset: RawSignal<u8>,
    /// `video_valid`.
    pub valid: RawSignal<u8>,
    /// `video_data`.
    pub data: RawSignal<u16>,
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
            data: model.raw("video_data")?,
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
