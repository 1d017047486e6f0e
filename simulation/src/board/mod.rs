//! The top as a board has it: a camera at the pixel port, a DMA that writes the feature packets into a ring of buffers
//! in memory, a CPU at the register port. No board has been built; this is the order of things written in
//! `arm/INTEGRATION.md`, run.
//!
//! | module | content |
//! |---|---|
//! | `fpga` | the Verilated top, the camera and the DMA, clocked together |
//! | `dma` | descriptors, beats, responses: what of the modular scatter-gather DMA is used |
//! | `driver` | what the CPU does: register port, interrupt, ring |

mod dma;
mod driver;
mod fpga;

pub use driver::{Driver, Packet, RegisterPort};
