//! The Verilated top between bus models of the harness: a source at the video port, a sink at the feature port, a
//! master at the registers.

use hoverlock_design::DesignPoint;
use hoverlock_harness::bus::avalon_mm::Master;
use hoverlock_harness::bus::stream::{Dialect, Ports, Rules, Sink, Source};
use hoverlock_harness::bus::{Reset, Switch};
use hoverlock_harness::model::InstanceOptions;
use hoverlock_harness::sim::{Dut, Signal, Sim};
use hoverlock_harness::{Error, Time};

use crate::Simulator;

/// Half a clock cycle: 100 MHz.
pub(crate) const HALF_CYCLE: Time = Time::ns(5);

/// Clock cycles of the reset, before cycle 0.
pub(crate) const RESET_CYCLES: u64 = 5;

/// Both streams take a beat where `valid` and `ready` are 1.
const AVALON: Dialect = Dialect::Avalon { ready_latency: 0 };

/// Bits of a symbol of the feature stream: a word of a record.
const WORD_BITS: u32 = 32;

/// The top in a simulation, its clock running.
pub struct Top {
    /// The signals of the top by name.
    pub dut: Dut,
    /// `clock`: 100 MHz; the first rising edge comes after 5 ns.
    pub clock: Signal,
    /// `reset`, synchronous, active high.
    pub reset: Signal,
    /// Sends frames of pixels; a symbol is a pixel.
    pub video: Source,
    /// Takes packets of records; a symbol is a word, the last word of a record first.
    pub features: Sink,
    /// While it is on, the sink is in reset: it is not ready, and checks nothing.
    pub feature_reset: Switch,
    /// Accesses the registers by the index of their word.
    pub registers: Master,
    /// `irq`.
    pub irq: Signal,
}

/// Makes a simulation of the top. Its first content of registers and memories follows from the seed.
///
/// # Errors
/// If the model cannot be loaded.
pub fn simulation(simulator: &Simulator, seed: u64) -> Result<Sim, Error> {
    let options = InstanceOptions { seed, plusargs: simulator.plusargs().to_vec() };
    let sim = Sim::new(simulator.library().instance_with(&options)?)?;
    // No register of the top samples at the falling edge, and no output depends on an input without a register.
    sim.defer_writes(true);
    Ok(sim)
}

impl Top {
    /// Starts the clock of a simulation, and the bus models at the ports of its top. What is to run before the source
    /// and the sink in each cycle must be registered before this. `rules` says what a broken rule of the feature stream
    /// does.
    ///
    /// # Errors
    /// If the top has other ports.
    pub fn new(dut: &Dut, design: &DesignPoint, rules: Rules) -> Result<Self, Error> {
        let clock = dut.clock_with("clock", HALF_CYCLE, HALF_CYCLE, HALF_CYCLE)?.signal().clone();
        let reset = dut.signal("reset")?;
        let feature_reset = Switch::default();
        let pixels = Ports::find(dut, "video_", AVALON)?.symbols_of(design.pixel.bits())?;
        let records = Ports::find(dut, "feature_", AVALON)?.symbols_of(WORD_BITS)?;
        Ok(Self {
            video: Source::new(dut, &clock, pixels, None)?,
            features: Sink::new(dut, &clock, records, Some(Reset::while_on(&feature_reset)), rules)?,
            registers: Master::new(dut, &clock, "csr_", 1)?,
            irq: dut.signal("irq")?,
            dut: dut.clone(),
            clock,
            reset,
            feature_reset,
        })
    }

    /// Holds the top in reset for `cycles` cycles, and the sink for one more, in which the reset reaches the pipeline.
    ///
    /// # Errors
    /// If `reset` cannot be written.
    pub async fn reset_for(&self, cycles: u64) -> Result<(), Error> {
        self.feature_reset.set(true);
        self.reset.set(1)?;
        self.clock.cycles(cycles).await;
        self.reset.set(0)?;
        self.clock.rising_edge().await;
        self.feature_reset.set(false);
        Ok(())
    }

    /// Reads the register at a byte address; the data come one cycle after the request.
    ///
    /// # Errors
    /// If there is no such address.
    pub async fn read(&self, address: u32) -> Result<u32, Error> {
        Ok(self.registers.read(u64::from(address / 4)).await? as u32)
    }

    /// Writes the register at a byte address in one cycle.
    ///
    /// # Errors
    /// If there is no such address.
    pub async fn write(&self, address: u32, value: u32) -> Result<(), Error> {
        self.registers.write(u64::from(address / 4), value.into()).await
    }
}
