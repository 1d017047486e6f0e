//! Avalon-MM: a master that drives a slave in the design, and a memory for a master in the design.
//!
//! ```text
//! clk            __/~~\__/~~\__/~~\__/~~\__
//! read | write   ____/~~~~~~~~~~~\_________   held, with address and data, while waitrequest is 1
//! waitrequest    ____/~~~~~\_______________
//! readdatavalid  ______________________/~~~   any number of cycles after the read was taken, or, without that
//! readdata       ----------------------<D>-   signal, `read_latency` cycles after it
//! ```
//!
//! With `burstcount` = n, one command moves n words. Address and count come with the first. A write gives one word in
//! each cycle in which `waitrequest` is 0, and may pause between words. A read gets each of its words with
//! `readdatavalid`.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use super::handshake::Offer;
use super::memory_contents::{MemoryContents, has_contents};
use super::{Pause, Random, Reset, Violation, optional};
use crate::bench::error::Error;
use crate::bench::sim::{Agent, Core, Dut, Edge, Lock, Signal};
use crate::engine::error::ModelError;

struct Ports {
    name: String,
    clock: Signal,
    address: Signal,
    read: Option<Signal>,
    write: Option<Signal>,
    write_data: Option<Signal>,
    read_data: Option<Signal>,
    wait_request: Option<Signal>,
    read_data_valid: Option<Signal>,
    byte_enable: Option<Signal>,
    burst_count: Option<Signal>,
}

impl Ports {
    fn find(dut: &Dut, clock: &Signal, prefix: &str) -> Result<Ports, ModelError> {
        let some = |name| optional(dut, prefix, name);
        Ok(Ports {
            name: prefix.trim_end_matches(['_', '$', '.']).to_owned(),
            clock: clock.clone(),
            address: dut.signal(&format!("{prefix}address"))?,
            read: some("read")?,
            write: some("write")?,
            write_data: some("writedata")?,
            read_data: some("readdata")?,
            wait_request: some("waitrequest")?,
            read_data_valid: some("readdatavalid")?,
            byte_enable: some("byteenable")?,
            burst_count: some("burstcount")?,
        })
    }

    fn needed<'a>(&self, signal: &'a Option<Signal>, what: &str) -> Result<&'a Signal, Error> {
        signal.as_ref().ok_or_else(|| Error::bench(format!("'{}' has no {what}", self.name)))
    }

    /// Sets `burstcount`, if there is one; an error if the slave does not take bursts of that length.
    fn set_burst(&self, words: usize) -> Result<(), Error> {
        match &self.burst_count {
            Some(count) if words as u64 <= count.mask() && words > 0 => Ok(count.set(words as u64)?),
            None if words == 1 => Ok(()),
            Some(count) => {
                Err(Error::bench(format!("'{}' takes bursts of 1 to {} words, not {words}", self.name, count.mask())))
            }
            None => Err(Error::bench(format!("'{}' has no burstcount: one word at a time", self.name))),
        }
    }
}

/// A master that reads and writes registers of the design: one access at a time, in the order of the calls.
#[derive(Clone)]
pub struct Master {
    ports: Rc<Ports>,
    lock: Lock,
    read_latency: u64,
}

impl Master {
    /// Creates a master for the slave whose signals begin with `prefix`. `read_latency` is the number of cycles from a
    /// read to its data; it is used only if there is no `readdatavalid`.
    ///
    /// # Errors
    /// If there is no `address`, or if `read` or `write` is driven by the design.
    pub fn new(dut: &Dut, clock: &Signal, prefix: &str, read_latency: u64) -> Result<Master, Error> {
        let ports = Ports::find(dut, clock, prefix)?;
        for signal in [&ports.read, &ports.write].into_iter().flatten() {
            signal.set(0)?;
        }
        let lock = dut.lock(&ports.name);
        Ok(Master { ports: Rc::new(ports), lock, read_latency })
    }

    /// Waits until the slave takes the command: an edge at which `waitrequest` is 0.
    async fn taken(&self) {
        loop {
            self.ports.clock.rising_edge().await;
            if self.ports.wait_request.as_ref().is_none_or(|w| !w.is_high()) {
                return;
            }
        }
    }

    /// Writes a word.
    ///
    /// # Errors
    /// If the slave has no `write` or `writedata`, or a value does not fit its signal.
    pub async fn write(&self, address: u64, data: u64) -> Result<(), Error> {
        let all = self.ports.byte_enable.as_ref().map_or(0, Signal::mask);
        self.write_bytes(address, data, all).await
    }

    /// Writes some bytes of a word.
    ///
    /// # Errors
    /// As [`Master::write`].
    pub async fn write_bytes(&self, address: u64, data: u64, byte_enable: u64) -> Result<(), Error> {
        self.write_words(address, &[data], byte_enable, Pause::Never).await
    }

    /// Writes words in one burst; `pause` says in which cycles it pauses between two words.
    ///
    /// # Errors
    /// As [`Master::write`], and if `burstcount` is missing or too narrow for the length.
    pub async fn write_burst(&self, address: u64, words: &[u64], pause: Pause) -> Result<(), Error> {
        let all = self.ports.byte_enable.as_ref().map_or(0, Signal::mask);
        self.write_words(address, words, all, pause).await
    }

    async fn write_words(&self, address: u64, words: &[u64], enable: u64, mut pause: Pause) -> Result<(), Error> {
        let _turn = self.lock.lock().await;
        let ports = &self.ports;
        let write = ports.needed(&ports.write, "write")?;
        let data = ports.needed(&ports.write_data, "writedata")?;
        ports.set_burst(words.len())?;
        ports.address.set(address)?;
        if let Some(signal) = &ports.byte_enable {
            signal.set(enable)?;
        }
        for (number, word) in words.iter().enumerate() {
            while number > 0 && pause.next_cycle() {
                write.set(0)?;
                ports.clock.rising_edge().await;
            }
            data.set(*word)?;
            write.set(1)?;
            self.taken().await;
        }
        Ok(write.set(0)?)
    }

    /// Reads a word.
    ///
    /// # Errors
    /// If the slave has no `read` or `readdata`, or the address does not fit its signal.
    pub async fn read(&self, address: u64) -> Result<u64, Error> {
        Ok(self.read_burst(address, 1).await?[0])
    }

    /// Reads words in one burst.
    ///
    /// # Errors
    /// As [`Master::read`], and if `readdatavalid` or `burstcount` is missing, or that is too narrow for the length.
    pub async fn read_burst(&self, address: u64, words: usize) -> Result<Vec<u64>, Error> {
        let _turn = self.lock.lock().await;
        let ports = &self.ports;
        let read = ports.needed(&ports.read, "read")?;
        let data = ports.needed(&ports.read_data, "readdata")?;
        if words != 1 && ports.read_data_valid.is_none() {
            return Err(Error::bench(format!("'{}' has no readdatavalid: one word at a time", ports.name)));
        }
        ports.set_burst(words)?;
        ports.address.set(address)?;
        if let Some(enable) = &ports.byte_enable {
            enable.set(enable.mask())?;
        }
        read.set(1)?;
        self.taken().await;
        read.set(0)?;
        if let Some(valid) = &ports.read_data_valid {
            let mut got = Vec::with_capacity(words);
            while got.len() < words {
                ports.clock.rising_edge().await;
                if valid.is_high() {
                    got.push(data.get());
                }
            }
            return Ok(got);
        }
        if self.read_latency > 0 {
            ports.clock.cycles(self.read_latency).await;
        }
        Ok(vec![data.get()])
    }
}

struct MemoryState {
    stall: Pause,
    latency: (u64, u64),
    random: Random,
    /// The distance between the addresses of a burst's words.
    step: u64,
}

/// A memory for a master in the design: words by address, with configurable stalls and latencies.
#[derive(Clone)]
pub struct Memory {
    contents: MemoryContents,
    state: Rc<RefCell<MemoryState>>,
}

has_contents!(Memory);

struct MemoryAgent {
    ports: Ports,
    reset: Option<Reset>,
    contents: MemoryContents,
    state: Rc<RefCell<MemoryState>>,
    cycle: u64,
    /// Reads in flight: the cycle of the response, and the word.
    answers: VecDeque<(u64, u64)>,
    /// The command, which must stay while `waitrequest` is 1.
    command: Offer<Command>,
    /// The write burst in progress: the next word's address, and the number of words to come.
    burst: Option<(u64, u64)>,
}

/// The command that a master gives in a cycle.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Command {
    address: u64,
    read: bool,
    write: bool,
    /// The data of a write.
    data: u64,
    count: u64,
}

impl Memory {
    /// Creates a memory of zeros at the signals that begin with `prefix`. Addresses have the unit of the master's
    /// `address`.
    ///
    /// # Errors
    /// If there is no `address`, or if `waitrequest` or `readdatavalid` is driven by the design.
    pub fn new(dut: &Dut, clock: &Signal, prefix: &str, reset: Option<Reset>) -> Result<Memory, Error> {
        let ports = Ports::find(dut, clock, prefix)?;
        for signal in [&ports.wait_request, &ports.read_data_valid].into_iter().flatten() {
            signal.set(0)?;
        }
        let state = MemoryState { stall: Pause::Never, latency: (1, 1), random: Random::new(0), step: 1 };
        let memory = Memory { contents: MemoryContents::new(1), state: Rc::new(RefCell::new(state)) };
        let Memory { contents, state } = memory.clone();
        let agent = MemoryAgent {
            ports,
            reset,
            contents,
            state,
            cycle: 0,
            answers: VecDeque::new(),
            command: Offer::default(),
            burst: None,
        };
        dut.core().add_agent(Box::new(agent), clock.id(), Edge::Rising);
        Ok(memory)
    }

    /// Sets in which cycles `waitrequest` is 1.
    pub fn set_stall(&self, stall: Pause) {
        self.state.borrow_mut().stall = stall;
    }

    /// Sets how many cycles an answer takes, from `min` (1 or more) to `max`, at random for each read.
    pub fn set_latency(&self, min: u64, max: u64, seed: u64) {
        let mut state = self.state.borrow_mut();
        state.latency = (min.max(1), max.max(min.max(1)));
        state.random = Random::new(seed);
    }

    /// Sets the distance between the addresses of a burst's words: 1 by default; the bytes of a word if addresses count
    /// bytes.
    pub fn set_step(&self, step: u64) {
        self.state.borrow_mut().step = step;
    }
}

impl Agent for MemoryAgent {
    fn edge(&mut self, core: &Core) -> Result<(), Error> {
        let put = |signal: &Option<Signal>, value: u64| signal.as_ref().map_or(Ok(()), |s| s.set(value));
        let high = |signal: &Option<Signal>| signal.as_ref().is_some_and(Signal::is_high);
        if self.reset.as_ref().is_some_and(Reset::is_active) {
            self.answers.clear();
            self.command.clear();
            self.burst = None;
            put(&self.ports.read_data_valid, 0)?;
            return Ok(());
        }
        self.cycle += 1;
        let mut state = self.state.borrow_mut();
        let (read, write) = (high(&self.ports.read), high(&self.ports.write));
        let violation = |rule: &str| Violation { bus: self.ports.name.clone(), rule: rule.into(), time: core.now() };
        if read && write {
            return Err(violation("read and write together").into());
        }
        let command = Command {
            address: self.ports.address.get(),
            read,
            write,
            data: self.ports.write_data.as_ref().filter(|_| write).map_or(0, Signal::get),
            count: self.ports.burst_count.as_ref().map_or(1, Signal::get),
        };
        let waits = high(&self.ports.wait_request);
        if self.command.cycle((read || write).then_some(command), !waits).1.is_some() {
            return Err(violation("the command changed while waitrequest was 1").into());
        }
        if (read || write) && command.count == 0 && self.burst.is_none() {
            return Err(violation("burstcount is 0").into());
        }
        if read && self.burst.is_some() {
            return Err(violation("a read inside a burst of writes").into());
        }
        if waits {
            // The command stays.
        } else if write {
            self.contents.count();
            // Address and count come with the first word.
            let (address, count) = self.burst.take().unwrap_or((command.address, command.count));
            if count > 1 {
                self.burst = Some((address.wrapping_add(state.step), count - 1));
            }
            let bytes = self.ports.byte_enable.as_ref().map_or(u64::MAX, Signal::get);
            self.contents.write(address, command.data, bytes);
        } else if read {
            for number in 0..command.count {
                self.contents.count();
                let address = command.address.wrapping_add(number * state.step);
                let word = self.contents.get(address);
                let (min, max) = state.latency;
                let latency = min + state.random.below(max - min + 1);
                let after = self.answers.back().map_or(0, |(cycle, _)| cycle + 1);
                self.answers.push_back(((self.cycle + latency - 1).max(after), word));
            }
        }
        let due = self.answers.front().is_some_and(|(cycle, _)| *cycle <= self.cycle);
        if due && let Some((_, word)) = self.answers.pop_front() {
            let data = self.ports.needed(&self.ports.read_data, "readdata")?;
            data.set(word & data.mask())?;
        }
        put(&self.ports.read_data_valid, u64::from(due))?;
        put(&self.ports.wait_request, u64::from(state.stall.next_cycle())).map_err(Error::from)
    }
}
