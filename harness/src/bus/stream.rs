//! Avalon-ST and AXI4-Stream: frames of symbols, some of them in each beat, with `valid` and `ready`.
//!
//! A frame is a list of symbols (bytes, pixels). A beat carries as many as fit into `data`: in Avalon-ST the first in
//! the highest bits, with `empty` counting the lanes that are not used at the end; in AXI4-Stream the first in the lowest
//! byte, with `tkeep` marking the lanes that are.
//!
//! ```text
//! clk    __/~~\__/~~\__/~~\__/~~\__/~~\__      a beat moves at an edge where valid and ready are 1;
//! valid  ____/~~~~~~~~~~~~~~~~~\_________      with a ready latency of L, where valid is 1, and valid may
//! ready  __________/~~~~~~~~~~~\_________      only be 1 L cycles after ready was
//! data   ----< A       >< B   >----------
//! ```

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use super::{Pause, Reset, Violation, optional};
use crate::error::{Error, ModelError};
use crate::model::{Direction, SignalInfo, Storage, store};
use crate::sim::{Agent, Core, Dut, Edge, Event, Signal};
use crate::time::Time;

/// The widest `data`, in 64-bit words.
const WORDS: usize = 8;

/// Which names and which order of symbols.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// `valid ready data startofpacket endofpacket empty channel error`.
    Avalon {
        /// Cycles from `ready` to the beat it allows.
        ready_latency: u32,
    },
    /// `tvalid tready tdata tlast tkeep tid tdest tuser`.
    Axi,
}

/// A packet, or a stretch of an unpacketised stream.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Frame {
    /// Its symbols.
    pub symbols: Vec<u64>,
    /// `channel`, or `tid`.
    pub channel: u64,
    /// `error`, or `tuser`, of its last beat.
    pub error: u64,
    /// `tdest`.
    pub destination: u64,
}

impl Frame {
    /// A frame of symbols of any unsigned type.
    pub fn new<T: Copy + Into<u64>>(symbols: &[T]) -> Frame {
        Frame { symbols: symbols.iter().map(|s| (*s).into()).collect(), ..Frame::default() }
    }

    /// The same on a channel.
    pub fn on_channel(mut self, channel: u64) -> Frame {
        self.channel = channel;
        self
    }

    /// The same with an `error` or `tuser`.
    pub fn with_error(mut self, error: u64) -> Frame {
        self.error = error;
        self
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Beat {
    data: [u64; WORDS],
    first: bool,
    last: bool,
    /// Lanes used, from the first symbol's on.
    keep: u64,
    channel: u64,
    error: u64,
    destination: u64,
}

/// A data port of up to 512 bits.
#[derive(Clone)]
struct DataPort {
    name: String,
    data: *mut u8,
    storage: Storage,
    index: u32,
    width: u32,
}

impl DataPort {
    fn find(dut: &Dut, name: &str) -> Result<DataPort, ModelError> {
        let model = dut.core().model.borrow();
        let id = model.find(name)?;
        let info: &SignalInfo = model.info(id);
        if info.range.is_some() || info.width as usize > 64 * WORDS {
            return Err(ModelError::TooWide { signal: info.name.clone(), width: info.width });
        }
        Ok(DataPort {
            name: info.name.clone(),
            data: info.data,
            storage: info.storage,
            index: id.index() as u32,
            width: info.width,
        })
    }

    fn get(&self) -> [u64; WORDS] {
        let mut words = [0; WORDS];
        // SAFETY: the agent that owns this port lives inside the core that owns the model.
        unsafe {
            match self.storage {
                Storage::Wide(count) => {
                    for at in 0..count as usize {
                        words[at / 2] |= u64::from(*self.data.cast::<u32>().add(at)) << (32 * (at % 2));
                    }
                }
                storage => words[0] = crate::model::load(self.data, storage),
            }
        }
        words
    }

    fn put(&self, core: &Core, value: &[u64; WORDS]) -> Result<(), ModelError> {
        match self.storage {
            Storage::Wide(count) => {
                let words: [u32; 2 * WORDS] = std::array::from_fn(|at| (value[at / 2] >> (32 * (at % 2))) as u32);
                core.write_words(self.index, &words[..count as usize])
            }
            _ => core.write(self.index, value[0]),
        }
    }
}

/// The signals of a stream.
#[derive(Clone)]
pub struct Ports {
    name: String,
    dialect: Dialect,
    valid: Signal,
    ready: Option<Signal>,
    data: DataPort,
    first: Option<Signal>,
    last: Option<Signal>,
    empty: Option<Signal>,
    keep: Option<Signal>,
    channel: Option<Signal>,
    error: Option<Signal>,
    destination: Option<Signal>,
    symbol_bits: u32,
    lanes: u32,
}

impl Ports {
    /// The signals whose names begin with `prefix` (such as `in_`, `s_axis_` or `video$`). Those beside `valid` and
    /// `data` may be missing. A symbol is a byte if `data` is made of bytes, else the whole of `data`.
    pub fn find(dut: &Dut, prefix: &str, dialect: Dialect) -> Result<Ports, Error> {
        let t = if dialect == Dialect::Axi { "t" } else { "" };
        let some = |name: &str| optional(dut, prefix, name);
        let avalon = |name: &str| if dialect == Dialect::Axi { Ok(None) } else { some(name) };
        let axi = |name: &str| if dialect == Dialect::Axi { some(name) } else { Ok(None) };
        let data = DataPort::find(dut, &format!("{prefix}{t}data"))?;
        let symbol_bits = if data.width.is_multiple_of(8) { 8 } else { data.width };
        let ports = Ports {
            name: prefix.trim_end_matches(['_', '$', '.']).to_owned(),
            dialect,
            valid: dut.signal(&format!("{prefix}{t}valid"))?,
            ready: some(&format!("{t}ready"))?,
            first: avalon("startofpacket")?,
            last: if dialect == Dialect::Axi { axi("tlast")? } else { avalon("endofpacket")? },
            empty: avalon("empty")?,
            keep: axi("tkeep")?,
            channel: if dialect == Dialect::Axi { axi("tid")? } else { avalon("channel")? },
            error: if dialect == Dialect::Axi { axi("tuser")? } else { avalon("error")? },
            destination: axi("tdest")?,
            symbol_bits: 0,
            lanes: 0,
            data,
        };
        ports.symbols_of(symbol_bits)
    }

    /// The same with symbols of so many bits.
    pub fn symbols_of(mut self, bits: u32) -> Result<Ports, Error> {
        if bits == 0 || bits > 64 || !self.data.width.is_multiple_of(bits) || self.data.width / bits > 64 {
            return Err(Error::bench(format!(
                "symbols of {bits} bits do not fill '{}', which is {} bits wide",
                self.data.name, self.data.width
            )));
        }
        self.symbol_bits = bits;
        self.lanes = self.data.width / bits;
        Ok(self)
    }

    /// Symbols in a beat.
    pub fn lanes(&self) -> u32 {
        self.lanes
    }

    fn latency(&self) -> u32 {
        match self.dialect {
            Dialect::Avalon { ready_latency } => ready_latency,
            Dialect::Axi => 0,
        }
    }

    fn all_lanes(&self) -> u64 {
        u64::MAX >> (64 - self.lanes)
    }

    /// Bit position of the lane that holds the `at`th symbol of a beat.
    fn lane_shift(&self, at: u32) -> u32 {
        match self.dialect {
            Dialect::Avalon { .. } => (self.lanes - 1 - at) * self.symbol_bits,
            Dialect::Axi => at * self.symbol_bits,
        }
    }

    fn insert(&self, data: &mut [u64; WORDS], at: u32, symbol: u64) {
        let shift = self.lane_shift(at);
        let (word, bit) = ((shift / 64) as usize, shift % 64);
        data[word] |= symbol << bit;
        if bit + self.symbol_bits > 64 {
            data[word + 1] |= symbol >> (64 - bit);
        }
    }

    fn extract(&self, data: &[u64; WORDS], at: u32) -> u64 {
        let shift = self.lane_shift(at);
        let (word, bit) = ((shift / 64) as usize, shift % 64);
        let mut symbol = data[word] >> bit;
        if bit + self.symbol_bits > 64 {
            symbol |= data[word + 1] << (64 - bit);
        }
        symbol & (u64::MAX >> (64 - self.symbol_bits))
    }

    /// How many beats a frame takes; an error if it cannot be sent.
    fn beats(&self, frame: &Frame) -> Result<usize, Error> {
        let lanes = self.lanes as usize;
        let count = frame.symbols.len().div_ceil(lanes);
        if count == 0 {
            return Err(Error::bench(format!("{}: a frame of no symbols cannot be sent", self.name)));
        }
        let partial = !frame.symbols.len().is_multiple_of(lanes);
        if partial && self.keep.is_none() && self.empty.is_none() {
            return Err(Error::bench(format!(
                "{}: {} symbols do not fill beats of {lanes}, and there is neither `empty` nor `tkeep`",
                self.name,
                frame.symbols.len()
            )));
        }
        for (what, signal, value) in [
            ("channel", &self.channel, frame.channel),
            ("error", &self.error, frame.error),
            ("destination", &self.destination, frame.destination),
        ] {
            let fits = signal.as_ref().map_or(value == 0, |s| value & !s.mask() == 0);
            if !fits {
                return Err(Error::bench(format!("{}: {what} {value} does not fit its signal", self.name)));
            }
        }
        let largest = u64::MAX >> (64 - self.symbol_bits);
        if let Some(symbol) = frame.symbols.iter().find(|symbol| **symbol > largest) {
            return Err(Error::bench(format!("{}: symbol {symbol} does not fit {} bits", self.name, self.symbol_bits)));
        }
        Ok(count)
    }

    /// The beat that begins with the `at`th symbol of a frame.
    #[inline]
    fn beat(&self, frame: &Frame, at: usize) -> Beat {
        let end = frame.symbols.len().min(at + self.lanes as usize);
        let symbols = &frame.symbols[at..end];
        let mut beat = Beat {
            first: at == 0,
            last: end == frame.symbols.len(),
            keep: u64::MAX >> (64 - symbols.len()),
            channel: frame.channel,
            error: frame.error,
            destination: frame.destination,
            ..Beat::default()
        };
        if self.lanes == 1 {
            beat.data[0] = symbols[0];
        } else {
            (0..).zip(symbols).for_each(|(lane, symbol)| self.insert(&mut beat.data, lane, *symbol));
        }
        beat
    }

    fn put(&self, core: &Core, beat: &Beat) -> Result<(), Error> {
        let put = |signal: &Option<Signal>, value: u64| signal.as_ref().map_or(Ok(()), |s| s.set(value & s.mask()));
        self.valid.set(1)?;
        self.data.put(core, &beat.data)?;
        put(&self.first, u64::from(beat.first))?;
        put(&self.last, u64::from(beat.last))?;
        put(&self.empty, u64::from(self.lanes - beat.keep.count_ones()))?;
        put(&self.keep, beat.keep)?;
        put(&self.channel, beat.channel)?;
        put(&self.error, beat.error)?;
        put(&self.destination, beat.destination)?;
        Ok(())
    }

    fn get(&self) -> Beat {
        let get = |signal: &Option<Signal>, missing: u64| signal.as_ref().map_or(missing, Signal::get);
        let empty = get(&self.empty, 0).min(64) as u32;
        let last = get(&self.last, 0) != 0;
        let used = match (&self.keep, &self.empty) {
            (Some(keep), _) => keep.get(),
            (None, Some(_)) if last => self.all_lanes() >> empty.min(self.lanes),
            _ => self.all_lanes(),
        };
        Beat {
            data: self.data.get(),
            first: get(&self.first, 0) != 0,
            last,
            keep: used,
            channel: get(&self.channel, 0),
            error: get(&self.error, 0),
            destination: get(&self.destination, 0),
        }
    }

    fn is_ready(&self) -> bool {
        self.ready.as_ref().is_none_or(Signal::is_high)
    }

    fn require_input(&self, signal: &Signal) -> Result<(), Error> {
        let info = signal.info();
        if info.direction == Direction::Output {
            return Err(ModelError::NotWritable { signal: info.name, top: "the design".into() }.into());
        }
        Ok(())
    }
}

/// Remembers in which of the last cycles `ready` was 1.
#[derive(Clone, Copy, Default)]
pub(super) struct ReadyHistory(u64);

impl ReadyHistory {
    pub fn push(&mut self, ready: bool) {
        self.0 = self.0 << 1 | u64::from(ready);
    }

    /// Whether `ready` was 1 so many cycles before the one after the last push.
    pub fn before(self, latency: u32) -> bool {
        self.0 >> (latency - 1) & 1 == 1
    }
}

// ---- source

struct SourceState {
    frames: VecDeque<Frame>,
    /// Symbols of the first frame that were taken.
    taken: usize,
    /// Beats of all frames still to be taken.
    pending: usize,
    pause: Pause,
    presented: bool,
    sent: u64,
    idle: Event,
}

/// Drives a stream into the design.
#[derive(Clone)]
pub struct Source {
    ports: Ports,
    state: Rc<RefCell<SourceState>>,
}

struct SourceAgent {
    ports: Ports,
    reset: Option<Reset>,
    history: ReadyHistory,
    state: Rc<RefCell<SourceState>>,
}

impl Source {
    /// A source at a clock; idle until something is sent.
    pub fn new(dut: &Dut, clock: &Signal, ports: Ports, reset: Option<Reset>) -> Result<Source, Error> {
        ports.require_input(&ports.valid)?;
        ports.valid.set(0)?;
        let idle = dut.event(&format!("{} idle", ports.name));
        idle.set();
        let state = SourceState {
            frames: VecDeque::new(),
            taken: 0,
            pending: 0,
            pause: Pause::Never,
            presented: false,
            sent: 0,
            idle,
        };
        let state = Rc::new(RefCell::new(state));
        let agent = SourceAgent { ports: ports.clone(), reset, history: ReadyHistory::default(), state: state.clone() };
        dut.core().add_agent(Box::new(agent), clock.id(), Edge::Rising);
        Ok(Source { ports, state })
    }

    /// In which cycles it holds back between beats.
    pub fn set_pause(&self, pause: Pause) {
        self.state.borrow_mut().pause = pause;
    }

    /// Queues a frame.
    pub fn send(&self, frame: &Frame) -> Result<(), Error> {
        let beats = self.ports.beats(frame)?;
        let mut state = self.state.borrow_mut();
        state.frames.push_back(frame.clone());
        state.pending += beats;
        state.idle.clear();
        Ok(())
    }

    /// Until everything queued was taken by the design.
    pub async fn drained(&self) {
        let idle = self.state.borrow().idle.clone();
        idle.wait().await;
    }

    /// Everything queued was taken, as an event.
    pub fn idle(&self) -> Event {
        self.state.borrow().idle.clone()
    }

    /// Beats the design has taken.
    pub fn sent(&self) -> u64 {
        self.state.borrow().sent
    }

    /// Beats still to be taken.
    pub fn pending(&self) -> usize {
        self.state.borrow().pending
    }
}

impl Agent for SourceAgent {
    fn edge(&mut self, core: &Core) -> Result<(), Error> {
        let mut state = self.state.borrow_mut();
        let state = &mut *state;
        let latency = self.ports.latency();
        if self.reset.as_ref().is_some_and(Reset::is_active) {
            state.presented = false;
            self.history = ReadyHistory::default();
            return Ok(self.ports.valid.set(0)?);
        }
        let ready = self.ports.is_ready();
        self.history.push(ready);
        if state.presented && (latency > 0 || ready) {
            state.sent += 1;
            state.pending -= 1;
            state.presented = false;
            state.taken += self.ports.lanes as usize;
            if state.frames.front().is_some_and(|frame| state.taken >= frame.symbols.len()) {
                state.frames.pop_front();
                state.taken = 0;
            }
            if state.pending == 0 {
                state.idle.set();
            }
        }
        if state.presented {
            return Ok(());
        }
        let held = state.pause.next_cycle();
        let allowed = latency == 0 || self.history.before(latency);
        match state.frames.front() {
            Some(frame) if allowed && !held => {
                self.ports.put(core, &self.ports.beat(frame, state.taken))?;
                state.presented = true;
            }
            _ => self.ports.valid.set(0)?,
        }
        Ok(())
    }
}

// ---- sink and monitor

struct Collector {
    frames: VecDeque<Frame>,
    open: Option<Frame>,
    beats: u64,
    arrived: Event,
    violations: Vec<Violation>,
}

/// Looks at every beat, puts frames together and checks the rules.
struct Listener {
    ports: Ports,
    reset: Option<Reset>,
    strict: bool,
    history: ReadyHistory,
    /// The beat that was offered and not taken.
    waiting: Option<Beat>,
    collector: Rc<RefCell<Collector>>,
}

impl Listener {
    /// Takes in one cycle; an error if a rule was broken and the rules are strict.
    fn cycle(&mut self, now: Time) -> Result<(), Error> {
        let latency = self.ports.latency();
        let valid = self.ports.valid.is_high();
        let ready = self.ports.is_ready();
        let mut broken: Vec<String> = Vec::new();
        let was_ready = latency == 0 || self.history.before(latency);
        self.history.push(ready);
        if valid && !was_ready {
            broken.push(format!("valid without ready {latency} cycles before"));
        }
        if latency == 0 {
            if let Some(offered) = self.waiting.take() {
                if !valid {
                    broken.push("valid fell before ready came".into());
                } else if self.ports.get() != offered {
                    broken.push("the beat changed while valid waited for ready".into());
                }
            }
            if valid && !ready {
                self.waiting = Some(self.ports.get());
            }
        }
        if valid && (latency > 0 || ready) {
            self.take(&mut broken);
        }
        if !broken.is_empty() {
            let violations = broken.into_iter().map(|rule| Violation { bus: self.ports.name.clone(), rule, time: now });
            let mut collector = self.collector.borrow_mut();
            collector.violations.extend(violations);
            if self.strict
                && let Some(first) = collector.violations.first()
            {
                return Err(first.clone().into());
            }
        }
        Ok(())
    }

    fn take(&mut self, broken: &mut Vec<String>) {
        let ports = &self.ports;
        let beat = ports.get();
        let mut collector = self.collector.borrow_mut();
        let collector = &mut *collector;
        collector.beats += 1;
        if ports.first.is_some() {
            match (&collector.open, beat.first) {
                (None, false) => broken.push("a beat outside of a packet: no startofpacket".into()),
                (Some(_), true) => broken.push("startofpacket inside a packet".into()),
                _ => {}
            }
        }
        if let (Some(empty), Some(_)) = (&ports.empty, &ports.last) {
            let lanes = empty.get();
            if lanes != 0 && !beat.last {
                broken.push(format!("empty is {lanes} before endofpacket"));
            } else if lanes >= u64::from(ports.lanes) {
                broken.push(format!("empty is {lanes} of {} symbols", ports.lanes));
            }
        }
        if let Some(open) = &collector.open
            && (open.channel, open.destination) != (beat.channel, beat.destination)
        {
            broken.push("channel changed inside a packet".into());
        }
        let frame = collector.open.get_or_insert_with(|| Frame {
            channel: beat.channel,
            destination: beat.destination,
            ..Frame::default()
        });
        frame.error = beat.error;
        for at in 0..ports.lanes {
            if beat.keep >> at & 1 == 1 {
                frame.symbols.push(ports.extract(&beat.data, at));
            }
        }
        if beat.last {
            collector.frames.extend(collector.open.take());
        }
        if beat.last || ports.last.is_none() {
            collector.arrived.set();
        }
    }

    fn in_reset(&mut self) -> bool {
        let active = self.reset.as_ref().is_some_and(Reset::is_active);
        if active {
            self.waiting = None;
            self.history = ReadyHistory::default();
        }
        active
    }
}

fn new_collector(dut: &Dut, ports: &Ports) -> Rc<RefCell<Collector>> {
    Rc::new(RefCell::new(Collector {
        frames: VecDeque::new(),
        open: None,
        beats: 0,
        arrived: dut.event(&format!("{} has a frame", ports.name)),
        violations: Vec::new(),
    }))
}

macro_rules! listening {
    ($name:ident) => {
        impl $name {
            /// The next frame, waiting for it.
            pub async fn recv(&self) -> Frame {
                loop {
                    if let Some(frame) = self.try_recv() {
                        return frame;
                    }
                    let arrived = self.collector.borrow().arrived.clone();
                    arrived.wait().await;
                }
            }

            /// The next frame, if there is one.
            pub fn try_recv(&self) -> Option<Frame> {
                let mut collector = self.collector.borrow_mut();
                let frame = collector.frames.pop_front();
                if collector.frames.is_empty() {
                    collector.arrived.clear();
                }
                frame
            }

            /// The next symbols of a stream without packets, waiting for them.
            pub async fn recv_symbols(&self, count: usize) -> Vec<u64> {
                loop {
                    {
                        let mut collector = self.collector.borrow_mut();
                        if let Some(open) = collector.open.as_mut().filter(|open| open.symbols.len() >= count) {
                            let rest = open.symbols.split_off(count);
                            return std::mem::replace(&mut open.symbols, rest);
                        }
                        collector.arrived.clear();
                    }
                    let arrived = self.collector.borrow().arrived.clone();
                    arrived.wait().await;
                }
            }

            /// Set while a frame waits to be fetched.
            pub fn arrived(&self) -> Event {
                self.collector.borrow().arrived.clone()
            }

            /// Frames that wait to be fetched.
            pub fn len(&self) -> usize {
                self.collector.borrow().frames.len()
            }

            /// Whether no frame waits to be fetched.
            pub fn is_empty(&self) -> bool {
                self.len() == 0
            }

            /// Beats seen.
            pub fn beats(&self) -> u64 {
                self.collector.borrow().beats
            }

            /// Rules that were broken, where they do not end the run.
            pub fn violations(&self) -> Vec<Violation> {
                self.collector.borrow().violations.clone()
            }
        }
    };
}

/// Whether broken rules end the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rules {
    /// They do.
    #[default]
    Strict,
    /// They are only kept in a list.
    Recorded,
}

/// Takes a stream from the design.
#[derive(Clone)]
pub struct Sink {
    pause: Rc<RefCell<Pause>>,
    collector: Rc<RefCell<Collector>>,
}

struct SinkAgent {
    listener: Listener,
    pause: Rc<RefCell<Pause>>,
}

impl Sink {
    /// A sink at a clock, ready from the next edge on.
    pub fn new(dut: &Dut, clock: &Signal, ports: Ports, reset: Option<Reset>, rules: Rules) -> Result<Sink, Error> {
        if let Some(ready) = &ports.ready {
            ports.require_input(ready)?;
            ready.set(0)?;
        }
        let collector = new_collector(dut, &ports);
        let pause = Rc::new(RefCell::new(Pause::Never));
        let listener = Listener {
            ports,
            reset,
            strict: rules == Rules::Strict,
            history: ReadyHistory::default(),
            waiting: None,
            collector: collector.clone(),
        };
        dut.core().add_agent(Box::new(SinkAgent { listener, pause: pause.clone() }), clock.id(), Edge::Rising);
        Ok(Sink { pause, collector })
    }

    /// In which cycles it is not ready.
    pub fn set_pause(&self, pause: Pause) {
        *self.pause.borrow_mut() = pause;
    }
}

listening!(Sink);

impl Agent for SinkAgent {
    fn edge(&mut self, core: &Core) -> Result<(), Error> {
        let in_reset = self.listener.in_reset();
        if !in_reset {
            self.listener.cycle(core.now())?;
        }
        if let Some(ready) = &self.listener.ports.ready {
            let hold = in_reset || self.pause.borrow_mut().next_cycle();
            ready.set(u64::from(!hold))?;
        }
        Ok(())
    }
}

/// Listens to a stream between others.
#[derive(Clone)]
pub struct Monitor {
    collector: Rc<RefCell<Collector>>,
}

struct MonitorAgent(Listener);

impl Monitor {
    /// A monitor at a clock.
    pub fn new(dut: &Dut, clock: &Signal, ports: Ports, reset: Option<Reset>, rules: Rules) -> Result<Monitor, Error> {
        let collector = new_collector(dut, &ports);
        let listener = Listener {
            ports,
            reset,
            strict: rules == Rules::Strict,
            history: ReadyHistory::default(),
            waiting: None,
            collector: collector.clone(),
        };
        dut.core().add_agent(Box::new(MonitorAgent(listener)), clock.id(), Edge::Rising);
        Ok(Monitor { collector })
    }
}

listening!(Monitor);

impl Agent for MonitorAgent {
    fn edge(&mut self, core: &Core) -> Result<(), Error> {
        if self.0.in_reset() { Ok(()) } else { self.0.cycle(core.now()) }
    }
}

/// Puts a value into a port at once; for the bulk path, which has no regions.
///
/// # Safety
/// The model must be alive and nobody reading.
pub(super) unsafe fn put_now(signal: &Signal, value: u64) {
    // SAFETY: as the caller promises.
    unsafe { store(signal.data(), signal.storage(), value) };
}
