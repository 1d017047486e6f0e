//! Whole frames as slices, without the scheduler: two evaluations of the model in each clock cycle and nothing else.
//!
//! The loop does what a [`Source`](super::stream::Source) and a [`Sink`](super::stream::Sink) do in the scheduler,
//! cycle for cycle: outputs are sampled before the rising edge and inputs change after it. Here the inputs change
//! together with the falling edge; a register that samples at the rising edge cannot tell the difference.
//!
//! One beat is one element of the slice. Where `data` is wider than 64 bits, one beat is several elements of 32 bits,
//! the lowest first.
//!
//! Writes that are buffered are put before the first edge. Tasks do not run during a transfer, and no other clock may
//! run; a timer that is over by then wakes its task at the next run. Waves, if they are recorded, are written at every
//! half cycle.

mod half_cycle;
mod sides;

use self::half_cycle::HalfCycles;
pub use self::sides::Element;
use self::sides::{Receiver, Sender, StreamSignals};
use super::stream::Dialect;
use super::{Pause, Violation};
use crate::bench::error::Error;
use crate::bench::sim::{Clock, Dut, Sim};

/// The options of a transfer. The default sends one packet without pauses and expects nothing.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The cycles in which the source offers no new beat.
    pub idle: Pause,
    /// The cycles in which the sink is not ready.
    pub stall: Pause,
    /// Beats in each packet sent, marked by `startofpacket` and `endofpacket` (or `tlast`); 0: all beats are one
    /// packet.
    pub packet: usize,
    /// Beats to receive before the transfer ends.
    pub expect: usize,
    /// Packets to receive before the transfer ends, for designs whose packets have no known length.
    pub packets: usize,
    /// Clock cycles after which a transfer that has not ended is an error; 0: 100 000 plus 16 for each beat sent or
    /// expected.
    pub max_cycles: u64,
}

/// The counts of a transfer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Report {
    /// Clock cycles it took.
    pub cycles: u64,
    /// Beats that the design accepted.
    pub sent: usize,
    /// Beats that the design sent.
    pub received: usize,
    /// Packets that the design completed.
    pub packets: usize,
}

/// A stream through the design, from slice to vector.
pub struct Bulk<I: Element, O: Element> {
    clock: Clock,
    input: StreamSignals<I>,
    output: StreamSignals<O>,
}

impl<I: Element, O: Element> Bulk<I, O> {
    /// Finds the streams whose signals begin with `input` and `output`, at a clock of the harness.
    ///
    /// # Errors
    /// If a signal is missing, if `I` or `O` is not the type Verilator stores that `data` in, if `input` is driven by
    /// the design, or if the ready latency is over 64 cycles.
    pub fn new(dut: &Dut, clock: &Clock, input: &str, output: &str, dialect: Dialect) -> Result<Bulk<I, O>, Error> {
        dialect.check()?;
        let (input, output) =
            (StreamSignals::find(dut, input, dialect, true)?, StreamSignals::find(dut, output, dialect, false)?);
        Ok(Bulk { clock: clock.clone(), input, output })
    }

    /// Returns how many elements of the slices one beat of the input and of the output has: 1, unless `data` is wider
    /// than 64 bits.
    pub fn parts(&self) -> (usize, usize) {
        (self.input.parts, self.output.parts)
    }

    /// Sends `elements` and appends what comes out to `received`, until all beats are sent and what is expected has
    /// come.
    ///
    /// # Errors
    /// If the elements do not fit `data` or make no whole beats, if packets are expected of a stream that does not mark
    /// their end, if another clock runs, if the Verilog ends or fails, or if the transfer does not end within
    /// [`Options::max_cycles`].
    pub fn transfer(
        &mut self,
        sim: &mut Sim,
        elements: &[I],
        received: &mut Vec<O>,
        options: &Options,
    ) -> Result<Report, Error> {
        self.check(elements, options)?;
        let dut = sim.dut();
        let own = is_running_alone(&dut, &self.clock)?;
        self.clock.stop();
        let result = self.run(&dut, elements, received, options);
        // The clock is low now; the next rising edge is half a period away, as it was before.
        let resumed = if own { self.clock.start(self.clock.low()) } else { Ok(()) };
        dut.handle_messages()?;
        let report = result?;
        resumed?;
        Ok(report)
    }

    /// Checks that the elements can be sent and that the stream can end as the options ask.
    fn check(&self, elements: &[I], options: &Options) -> Result<(), Error> {
        let (input, output) = (&self.input, &self.output);
        if !elements.len().is_multiple_of(input.parts) {
            return Err(Error::bench(format!(
                "{}: {} elements make no whole beats of {} elements",
                input.name,
                elements.len(),
                input.parts
            )));
        }
        if let Some(element) = input.first_too_large(elements) {
            return Err(Error::bench(format!("{}: the element {element} does not fit `data`", input.name)));
        }
        if options.packets > 0 && output.last.is_none() {
            return Err(Error::bench(format!("{}: packets are expected, and nothing marks their end", output.name)));
        }
        Ok(())
    }

    fn run(&mut self, dut: &Dut, elements: &[I], received: &mut Vec<O>, options: &Options) -> Result<Report, Error> {
        let count = elements.len() / self.input.parts;
        let max = match options.max_cycles {
            0 => 100_000 + 16 * (count + options.expect) as u64,
            max => max,
        };
        let mut sender = Sender::new(&self.input, elements, options);
        let mut receiver = Receiver::new(&self.output, received, options);
        let (high, low) = (self.clock.high(), self.clock.low());
        let mut half_cycles = HalfCycles::new(dut, self.clock.signal());
        let mut cycles = 0u64;
        // SAFETY: every pointer is into the model of `dut`, which is borrowed here; ports take values masked or checked
        // before; nothing else is made, bound or dropped on this thread in the loop.
        unsafe {
            sender.withdraw();
            receiver.withdraw();
            let mut model = half_cycles.begin()?;
            loop {
                // What the scheduler would put after the last rising edge is put here, with the falling one.
                sender.offer();
                receiver.offer();
                model = half_cycles.falling(model, low)?;
                receiver.sample();
                sender.sample();
                model = half_cycles.rising(model, high)?;
                cycles += 1;
                if (sender.is_done() && receiver.is_done()) || cycles >= max {
                    break;
                }
                model = half_cycles.check_wall_clock(model)?;
            }
            drop(model);
            sender.withdraw();
            receiver.withdraw();
        }
        half_cycles.end()?;
        dut.handle_messages()?;
        if sender.is_done() && receiver.is_done() {
            return Ok(Report { cycles, sent: sender.sent, received: receiver.beats, packets: receiver.packets });
        }
        Err(Violation {
            bus: format!("{} -> {}", self.input.name, self.output.name),
            rule: format!(
                "the transfer did not end within {max} cycles: {} of {count} beats taken, {} of {} given, {} of {} \
                 packets",
                sender.sent, receiver.beats, options.expect, receiver.packets, options.packets
            ),
            time: half_cycles.now(),
        }
        .into())
    }
}

/// Returns whether a clock runs.
///
/// # Errors
/// If another one does.
fn is_running_alone(dut: &Dut, clock: &Clock) -> Result<bool, Error> {
    let own = clock.signal().id().index() as u32;
    let clocks = dut.core().clocks.borrow();
    let mut running = clocks.iter().filter(|c| c.running);
    if running.any(|c| c.signal != own) {
        return Err(Error::bench("one clock is driven without the scheduler: stop the others, or use tasks"));
    }
    Ok(clocks.iter().any(|c| c.running))
}

/// Runs cycles of one clock without the scheduler: the fastest way to let a design run. The clock runs on afterwards.
/// Tasks do not run; a timer that is over by then wakes its task at the next run.
///
/// # Errors
/// If another clock runs, if the Verilog ends or fails, if the time on the wall is over, or if the clock's signal
/// cannot be written.
pub fn run_cycles(sim: &mut Sim, clock: &Clock, cycles: u64) -> Result<(), Error> {
    let dut = sim.dut();
    is_running_alone(&dut, clock)?;
    clock.stop();
    let mut half_cycles = HalfCycles::new(&dut, clock.signal());
    let mut run = || -> Result<(), Error> {
        // SAFETY: as in `Bulk::run`.
        unsafe {
            let mut model = half_cycles.begin()?;
            for _ in 0..cycles {
                model = half_cycles.falling(model, clock.low())?;
                model = half_cycles.rising(model, clock.high())?;
                model = half_cycles.check_wall_clock(model)?;
            }
        }
        Ok(())
    };
    let ran = run();
    let ended = half_cycles.end();
    dut.handle_messages()?;
    clock.start(clock.low())?;
    ran.and(ended)
}
