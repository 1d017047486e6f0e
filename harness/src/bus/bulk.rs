//! Whole frames as slices, without the scheduler: two evaluations a cycle and nothing else.
//!
//! The loop does what a [`Source`](super::stream::Source) and a [`Sink`](super::stream::Sink) do in the scheduler, cycle
//! for cycle: inputs change after the rising edge (here together with the falling one, which no register of the rising
//! edge can tell), outputs are sampled before it. One word of `data` is one element of the slice; of `data` wider than
//! 64 bits it is several elements of 32 bits, the lowest first.
//!
//! Tasks sleep meanwhile, other clocks must not run, and waves, if on, are written at every half cycle.

use super::stream::{Dialect, ReadyHistory, put_now};
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
    /// Packets to receive before the transfer ends, where nobody knows how many words they have.
    pub packets: usize,
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
    /// Elements in a word: more than one only if `data` is wider than 64 bits.
    parts: usize,
    /// Bits of a word's last element that are `data`.
    top_mask: u64,
    latency: u32,
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
    fn find(dut: &Dut, prefix: &str, dialect: Dialect, driven: bool) -> Result<Lane<T>, Error> {
        let t = if dialect == Dialect::Axi { "t" } else { "" };
        let (first, last) = if dialect == Dialect::Axi { ("", "tlast") } else { ("startofpacket", "endofpacket") };
        let some = |name: &str| if name.is_empty() { Ok(None) } else { super::optional(dut, prefix, name) };
        let info = dut.wide(&format!("{prefix}{t}data"))?.info();
        let (words, parts) = match info.storage {
            Storage::U8 => (8, 1),
            Storage::U16 => (16, 1),
            Storage::U32 => (32, 1),
            Storage::U64 => (64, 1),
            Storage::Wide(parts) => (32, parts as usize),
        };
        if words != T::BITS {
            return Err(Error::bench(format!(
                "'{}' is {} bits wide: its slice is of {words}-bit words, not of {}-bit ones",
                info.name,
                info.width,
                T::BITS
            )));
        }
        let in_last = info.width - 32 * (parts as u32 - 1);
        if driven && info.direction == Direction::Output {
            return Err(ModelError::NotWritable { signal: info.name, top: dut.top() }.into());
        }
        Ok(Lane {
            valid: dut.signal(&format!("{prefix}{t}valid"))?,
            ready: some(&format!("{t}ready"))?,
            data: info.data.cast(),
            parts,
            top_mask: u64::MAX >> (64 - in_last),
            latency: match dialect {
                Dialect::Avalon { ready_latency } => ready_latency,
                Dialect::Axi => 0,
            },
            first: some(first)?,
            last: some(last)?,
            name: prefix.trim_end_matches(['_', '$', '.']).to_owned(),
        })
    }

    fn is_ready(&self) -> bool {
        self.ready.as_ref().is_none_or(Signal::is_high)
    }

    /// Whether a valid word moves at the edge: with a ready latency, `ready` allowed it long before.
    #[inline(always)]
    fn moves(&self) -> bool {
        self.latency > 0 || self.is_ready()
    }

    /// Puts the word with that number into `data`.
    ///
    /// # Safety
    /// The slice must have it, the model must be alive and nobody reading.
    #[inline(always)]
    unsafe fn put(&self, words: &[T], number: usize) {
        // SAFETY: as the caller promises; `data` has `parts` elements.
        unsafe {
            if self.parts == 1 {
                *self.data = *words.get_unchecked(number);
            } else {
                std::ptr::copy_nonoverlapping(words.as_ptr().add(number * self.parts), self.data, self.parts);
            }
        }
    }

    /// Appends the word that `data` holds.
    ///
    /// # Safety
    /// The model must be alive.
    #[inline(always)]
    unsafe fn take(&self, into: &mut Vec<T>) {
        // SAFETY: as the caller promises; `data` has `parts` elements.
        unsafe {
            if self.parts == 1 {
                into.push(*self.data);
            } else {
                into.extend_from_slice(std::slice::from_raw_parts(self.data, self.parts));
            }
        }
    }
}

/// A stream through the design, from slice to vector.
pub struct Bulk<I: Element, O: Element> {
    clock: Clock,
    input: Lane<I>,
    output: Lane<O>,
}

impl<I: Element, O: Element> Bulk<I, O> {
    /// The streams whose signals begin with `input` and `output`, at a clock of the harness.
    pub fn new(dut: &Dut, clock: &Clock, input: &str, output: &str, dialect: Dialect) -> Result<Bulk<I, O>, Error> {
        if let Dialect::Avalon { ready_latency: 65.. } = dialect {
            return Err(Error::bench("the ready latency of a stream is at most 64 cycles"));
        }
        let (input, output) = (Lane::find(dut, input, dialect, true)?, Lane::find(dut, output, dialect, false)?);
        Ok(Bulk { clock: clock.clone(), input, output })
    }

    /// Elements of the slices for one word of the input and of the output: one each, unless `data` is wider than 64 bits.
    pub fn parts(&self) -> (usize, usize) {
        (self.input.parts, self.output.parts)
    }

    /// Sends words and appends what comes out to `received`, until all are sent and what is expected has come.
    pub fn transfer(
        &mut self,
        sim: &mut Sim,
        words: &[I],
        received: &mut Vec<O>,
        options: &Options,
    ) -> Result<Report, Error> {
        let parts = self.input.parts;
        if !words.len().is_multiple_of(parts) {
            return Err(Error::bench(format!(
                "{}: {} elements make no whole words of {parts}",
                self.input.name,
                words.len()
            )));
        }
        if let Some(word) = words.iter().skip(parts - 1).step_by(parts).find(|w| w.widen() & !self.input.top_mask != 0)
        {
            return Err(Error::bench(format!("{}: the word {} does not fit `data`", self.input.name, word.widen())));
        }
        if options.packets > 0 && self.output.last.is_none() {
            return Err(Error::bench(format!(
                "{}: packets are expected, and nothing marks their end",
                self.output.name
            )));
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
            100_000 + 16 * (words.len() / self.input.parts + options.expect) as u64
        };
        let count = words.len() / self.input.parts;
        let packet = if options.packet == 0 { count.max(1) } else { options.packet };
        let (mut idle, mut stall) = (options.idle.clone(), options.stall.clone());
        let clk = self.clock.signal().clone();
        let (input, output) = (&self.input, &self.output);
        let mut watch = core.wall_watch();
        let mut now = core.now();
        let (mut sent, mut given, mut packets, mut cycle) = (0, 0, 0, 0u64);
        let mut presented = false;
        let latency = input.latency;
        let mut history = ReadyHistory::default();
        // Words until the packet's end, counted down so that no division is in the loop.
        let mut left_in_packet = packet;
        let tracing = core.has_waves();
        received.reserve(options.expect * output.parts);
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
                    let allowed = latency == 0 || history.before(latency);
                    presented = sent < count && allowed && !idle.next_cycle();
                    put_now(&input.valid, u64::from(presented));
                    if presented {
                        input.put(words, sent);
                        put(&input.first, left_in_packet == packet);
                        put(&input.last, left_in_packet == 1 || sent + 1 == count);
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
                if output.valid.is_high() && output.moves() {
                    output.take(received);
                    given += 1;
                    packets += usize::from(output.last.as_ref().is_some_and(Signal::is_high));
                }
                if latency > 0 {
                    history.push(input.is_ready());
                }
                if presented && input.moves() {
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
                if sent == count && given >= options.expect && packets >= options.packets {
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
        let report = Report { cycles: cycle, sent, received: given, packets };
        if sent < count || given < options.expect || packets < options.packets {
            return Err(Violation {
                bus: format!("{} -> {}", input.name, output.name),
                rule: format!(
                    "the transfer did not end within {most} cycles: {sent} of {count} words taken, {given} of {} given, {packets} \
                     of {} packets",
                    options.expect, options.packets
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
