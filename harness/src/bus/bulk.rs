//! Whole frames as slices, without the scheduler: two evaluations a cycle and nothing else.
//!
//! The loop does what a [`Source`](super::stream::Source) and a [`Sink`](super::stream::Sink) do in the scheduler, cycle
//! for cycle: inputs change after the rising edge (here together with the falling one, which no register of the rising
//! edge can tell), outputs are sampled before it. One word of `data` is one element of the slice.
//!
//! Tasks sleep meanwhile, other clocks must not run, and waves, if on, are written at every half cycle.

use super::stream::{Dialect, put_now};
use super::{Pause, Violation};
use crate::error::{Error, ModelError};
use crate::model::{Direction, Storage, Word};
use crate::sim::{Clock, Dut, Signal, Sim};
use crate::time::Time;

/// What a transfer does besides moving data.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// When the source holds back.
    pub idle: Pause,
    /// When the sink is not ready.
    pub stall: Pause,
    /// Words to send before the next packet begins, each with `startofpacket` and `endofpacket` (or `tlast`) around
    /// it; 0: all in one packet.
    pub packet: usize,
    /// Words to receive before the transfer ends.
    pub expect: usize,
    /// Cycles after which a transfer that has not ended is an error; 0: 16 for each word plus 100 000.
    pub most_cycles: u64,
}

/// How a transfer went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Report {
    /// Clock cycles it took.
    pub cycles: u64,
    /// Words the design took.
    pub sent: usize,
    /// Words the design gave.
    pub received: usize,
    /// Packets it gave.
    pub packets: usize,
}

struct Lane<T: Word> {
    valid: Signal,
    ready: Option<Signal>,
    data: *mut T,
    first: Option<Signal>,
    last: Option<Signal>,
    name: String,
}

/// The native width of a slice's elements as 64 bits and back.
pub trait Element: Word {
    /// Widens.
    fn widen(self) -> u64;
}

impl Element for u8 {
    fn widen(self) -> u64 {
        u64::from(self)
    }
}
impl Element for u16 {
    fn widen(self) -> u64 {
        u64::from(self)
    }
}
impl Element for u32 {
    fn widen(self) -> u64 {
        u64::from(self)
    }
}
impl Element for u64 {
    fn widen(self) -> u64 {
        self
    }
}

impl<T: Word> Lane<T> {
    fn find(dut: &Dut, prefix: &str, dialect: Dialect, driven: bool) -> Result<(Lane<T>, u64), Error> {
        let t = if dialect == Dialect::Axi { "t" } else { "" };
        let (first, last) = if dialect == Dialect::Axi { ("", "tlast") } else { ("startofpacket", "endofpacket") };
        let some = |name: &str| if name.is_empty() { Ok(None) } else { super::optional(dut, prefix, name) };
        let data = dut.signal(&format!("{prefix}{t}data"))?;
        let info = data.info();
        let words = match info.storage {
            Storage::U8 => 8,
            Storage::U16 => 16,
            Storage::U32 => 32,
            Storage::U64 => 64,
            Storage::Wide(_) => 0,
        };
        if words != T::BITS {
            return Err(Error::bench(format!(
                "'{}' is {} bits wide: its slice is of {words}-bit words, not of {}-bit ones",
                info.name,
                info.width,
                T::BITS
            )));
        }
        if driven && info.direction == Direction::Output {
            return Err(ModelError::NotWritable { signal: info.name, top: dut.top() }.into());
        }
        let lane = Lane {
            valid: dut.signal(&format!("{prefix}{t}valid"))?,
            ready: some(&format!("{t}ready"))?,
            data: data.data().cast(),
            first: some(first)?,
            last: some(last)?,
            name: prefix.trim_end_matches(['_', '$', '.']).to_owned(),
        };
        Ok((lane, data.mask()))
    }

    fn is_ready(&self) -> bool {
        self.ready.as_ref().is_none_or(Signal::is_high)
    }
}

/// A stream through the design, from slice to vector.
pub struct Bulk<I: Element, O: Element> {
    clock: Clock,
    input: Lane<I>,
    output: Lane<O>,
    input_mask: u64,
}

impl<I: Element, O: Element> Bulk<I, O> {
    /// The streams whose signals begin with `input` and `output`, at a clock of the harness. No ready latency.
    pub fn new(dut: &Dut, clock: &Clock, input: &str, output: &str, dialect: Dialect) -> Result<Bulk<I, O>, Error> {
        if let Dialect::Avalon { ready_latency: 1.. } = dialect {
            return Err(Error::bench("the bulk path has no ready latency: use a Source and a Sink"));
        }
        let (input, input_mask) = Lane::find(dut, input, dialect, true)?;
        let (output, _) = Lane::find(dut, output, dialect, false)?;
        Ok(Bulk { clock: clock.clone(), input, output, input_mask })
    }

    /// Sends words and appends what comes out to `received`, until all are sent and `expect` have come.
    pub fn transfer(
        &mut self,
        sim: &mut Sim,
        words: &[I],
        received: &mut Vec<O>,
        options: &Options,
    ) -> Result<Report, Error> {
        if let Some(word) = words.iter().find(|w| w.widen() & !self.input_mask != 0) {
            return Err(Error::bench(format!("{}: the word {} does not fit `data`", self.input.name, word.widen())));
        }
        let dut = sim.dut();
        let core = dut.core();
        let running = core.clocks.borrow().iter().filter(|c| c.running).count();
        let own = core.clocks.borrow().iter().any(|c| c.running && c.signal == self.clock.signal().id().index() as u32);
        if running > usize::from(own) {
            return Err(Error::bench("the bulk path keeps one clock: stop the others, or use a Source and a Sink"));
        }
        self.clock.stop();
        let result = self.cycles(&dut, words, received, options);
        // The clock is low now; the next rising edge is half a period away, as it was before.
        let resumed = if own { self.clock.start(self.clock.low()) } else { Ok(()) };
        dut.handle_messages()?;
        let report = result?;
        resumed?;
        Ok(report)
    }

    fn cycles(&mut self, dut: &Dut, words: &[I], received: &mut Vec<O>, options: &Options) -> Result<Report, Error> {
        let core = dut.core().clone();
        let (high, low) = (self.clock.high(), self.clock.low());
        let most = if options.most_cycles > 0 {
            options.most_cycles
        } else {
            100_000 + 16 * (words.len() + options.expect) as u64
        };
        let packet = if options.packet == 0 { words.len().max(1) } else { options.packet };
        let (mut idle, mut stall) = (options.idle.clone(), options.stall.clone());
        let clk = self.clock.signal().clone();
        let (input, output) = (&self.input, &self.output);
        let mut watch = core.wall_watch();
        let mut now = core.now();
        let start = received.len();
        let (mut sent, mut packets, mut cycle) = (0, 0, 0u64);
        let mut presented = false;
        // Words until the packet's end, counted down so that no division is in the loop.
        let mut left_in_packet = packet;
        let tracing = core.has_waves();
        received.reserve(options.expect);
        let mut model = core.model.borrow_mut();
        // SAFETY: every pointer is into the model borrowed here; ports take values masked or checked before; the model
        // is bound below and nothing else is made, bound or dropped on this thread in the loop.
        unsafe {
            let put = |signal: &Option<Signal>, value: bool| {
                if let Some(signal) = signal {
                    put_now(signal, u64::from(value));
                }
            };
            put_now(&input.valid, 0);
            put(&output.ready, false);
            model.set_time(now);
            put_now(&clk, 0);
            model.eval()?;
            model.bind();
            loop {
                // What the scheduler would have put after the last rising edge, here with the falling one.
                if !presented {
                    presented = sent < words.len() && !idle.next_cycle();
                    put_now(&input.valid, u64::from(presented));
                    if presented {
                        *input.data = words[sent];
                        put(&input.first, left_in_packet == packet);
                        put(&input.last, left_in_packet == 1 || sent + 1 == words.len());
                    }
                }
                put(&output.ready, !stall.next_cycle());
                put_now(&clk, 0);
                model.eval_bound();
                if model.has_messages() {
                    core.set_now(now);
                    drop(model);
                    listen(dut)?;
                    model = core.model.borrow_mut();
                    model.bind();
                }
                if tracing {
                    core.waves.borrow_mut().sample(&mut model, now)?;
                }
                now += low;
                if output.valid.is_high() && output.is_ready() {
                    received.push(*output.data);
                    packets += usize::from(output.last.as_ref().is_some_and(Signal::is_high));
                }
                if presented && input.is_ready() {
                    sent += 1;
                    presented = false;
                    left_in_packet = if left_in_packet == 1 { packet } else { left_in_packet - 1 };
                }
                model.set_time(now);
                put_now(&clk, 1);
                model.eval_bound();
                if model.has_messages() {
                    core.set_now(now);
                    drop(model);
                    listen(dut)?;
                    model = core.model.borrow_mut();
                    model.bind();
                }
                if tracing {
                    core.waves.borrow_mut().sample(&mut model, now)?;
                }
                now += high;
                cycle += 1;
                if sent == words.len() && received.len() - start >= options.expect {
                    break;
                }
                if cycle >= most {
                    break;
                }
                if watch.is_due() {
                    core.set_now(now);
                    // A report looks into the model.
                    drop(model);
                    core.check_wall_clock(&mut watch)?;
                    model = core.model.borrow_mut();
                    model.bind();
                }
            }
            put_now(&input.valid, 0);
            put(&output.ready, false);
            put_now(&clk, 0);
            model.set_time(now);
            model.eval()?;
        }
        drop(model);
        core.set_now(now);
        dut.handle_messages()?;
        let report = Report { cycles: cycle, sent, received: received.len() - start, packets };
        if sent < words.len() || report.received < options.expect {
            return Err(Violation {
                bus: format!("{} -> {}", input.name, output.name),
                rule: format!(
                    "the transfer did not end within {most} cycles: {sent} of {} words taken, {} of {} given",
                    words.len(),
                    report.received,
                    options.expect
                ),
                time: now,
            }
            .into());
        }
        Ok(report)
    }
}

/// Takes in what the Verilog said: text goes to the log, errors and `$finish` end the transfer.
fn listen(dut: &Dut) -> Result<(), Error> {
    dut.handle_messages()?;
    dut.core().check_finished()
}

/// Cycles of a clock alone, without the scheduler: the fastest way to let a design run.
pub fn run_cycles(sim: &mut Sim, clock: &Clock, cycles: u64) -> Result<(), Error> {
    let dut = sim.dut();
    let core = dut.core().clone();
    let clk = clock.signal().clone();
    clock.stop();
    let mut watch = core.wall_watch();
    let mut now: Time = core.now();
    let mut model = core.model.borrow_mut();
    // SAFETY: as in `Bulk::cycles`.
    let ended = unsafe {
        put_now(&clk, 0);
        model.eval()?;
        model.bind();
        let mut ended: Result<(), Error> = Ok(());
        for _ in 0..cycles {
            put_now(&clk, 0);
            model.eval_bound();
            now += clock.low();
            model.set_time(now);
            put_now(&clk, 1);
            model.eval_bound();
            now += clock.high();
            if model.has_messages() {
                core.set_now(now);
                drop(model);
                ended = listen(&dut);
                model = core.model.borrow_mut();
                model.bind();
                if ended.is_err() {
                    break;
                }
            }
            if watch.is_due() {
                core.set_now(now);
                drop(model);
                ended = core.check_wall_clock(&mut watch);
                model = core.model.borrow_mut();
                model.bind();
                if ended.is_err() {
                    break;
                }
            }
        }
        put_now(&clk, 0);
        model.set_time(now);
        ended.and(model.eval().map_err(Error::from))
    };
    drop(model);
    core.set_now(now);
    dut.handle_messages()?;
    clock.start(clock.low())?;
    ended
}
