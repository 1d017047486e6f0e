//! A memory for an AXI4 master in the design. It takes bursts of all kinds, and checks the master.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use super::checker::{Command, Watch, WriteBeat};
use crate::bench::bus::memory_contents::{MemoryContents, has_contents};
use crate::bench::bus::{Pause, Reset};
use crate::bench::error::Error;
use crate::bench::sim::{Agent, Core, Dut, Edge, Signal};

/// The pauses of the channels `aw`, `w`, `ar`, `b` and `r`.
type Stalls = Rc<RefCell<[Pause; 5]>>;

/// A memory for a master in the design. Addresses count bytes; words are as wide as the data, at most 64 bits.
#[derive(Clone)]
pub struct Memory {
    contents: MemoryContents,
    stalls: Stalls,
}

has_contents!(Memory);

struct MemoryAgent {
    watch: Watch,
    contents: MemoryContents,
    stalls: Stalls,
    writes: VecDeque<Command>,
    beats: VecDeque<WriteBeat>,
    /// Beats of the first write that were put.
    put: u64,
    /// Ids of writes to be answered.
    answers: VecDeque<u64>,
    reads: VecDeque<Command>,
    /// Beats of the first read that were taken.
    sent: u64,
}

impl Memory {
    /// Creates a memory of zeros at the signals that begin with `prefix`, such as `m_axi_`.
    ///
    /// # Errors
    /// If a signal other than `wstrb`, `bresp`, `rresp`, those of size, burst and id is missing, or one that a slave
    /// drives is driven by the design.
    pub fn new(dut: &Dut, clock: &Signal, prefix: &str, reset: Option<Reset>) -> Result<Memory, Error> {
        let watch = Watch::find(dut, clock, prefix, reset)?;
        watch.silence()?;
        let bytes = watch.bytes();
        let memory = Memory { contents: MemoryContents::new(bytes), stalls: Stalls::default() };
        let Memory { contents, stalls } = memory.clone();
        let agent = MemoryAgent {
            watch,
            contents,
            stalls,
            writes: VecDeque::new(),
            beats: VecDeque::new(),
            put: 0,
            answers: VecDeque::new(),
            reads: VecDeque::new(),
            sent: 0,
        };
        dut.core().add_agent(Box::new(agent), clock.id(), Edge::Rising);
        Ok(memory)
    }

    /// Sets the cycles in which each channel stalls. Every channel has its own position in a pattern, or its own random
    /// numbers.
    pub fn set_stall(&self, stall: Pause) {
        *self.stalls.borrow_mut() = std::array::from_fn(|channel| stall.of_channel(channel as u64));
    }
}

impl Watch {
    /// Takes nothing and offers nothing.
    fn silence(&self) -> Result<(), Error> {
        let ports = &self.ports;
        for signal in [&ports.aw.1, &ports.w.1, &ports.ar.1, &ports.b.0, &ports.r.0] {
            signal.set(0)?;
        }
        Ok(())
    }
}

impl MemoryAgent {
    /// Puts the beats whose address is known.
    fn write(&mut self) -> Result<(), String> {
        let bytes = self.watch.bytes();
        while let (Some(command), Some((data, strobe, last))) = (self.writes.front(), self.beats.front().copied()) {
            let address = command.address_of(self.put);
            let (low, high) = (address % bytes, address % bytes / command.bytes * command.bytes + command.bytes);
            let lanes = (low..high).fold(0u64, |lanes, lane| lanes | 1 << lane);
            // Without a strobe, all bytes of the beat.
            let strobe = if strobe == u64::MAX { lanes } else { strobe };
            if strobe & !lanes != 0 {
                return Err(format!("wstrb is {strobe:#b} in a beat at {address:#x} whose bytes are {lanes:#b}"));
            }
            self.contents.write(address, data, strobe);
            self.contents.count();
            self.put += 1;
            self.beats.pop_front();
            if last {
                self.answers.push_back(command.id);
                self.writes.pop_front();
                self.put = 0;
            }
        }
        Ok(())
    }

    fn clear(&mut self) -> Result<(), Error> {
        (self.put, self.sent) = (0, 0);
        self.writes.clear();
        self.beats.clear();
        self.answers.clear();
        self.reads.clear();
        self.watch.silence()
    }
}

fn put(signal: &Option<Signal>, value: u64) -> Result<(), Error> {
    signal.as_ref().map_or(Ok(()), |signal| Ok(signal.set(value)?))
}

impl Agent for MemoryAgent {
    fn edge(&mut self, core: &Core) -> Result<(), Error> {
        if self.watch.in_reset() {
            return self.clear();
        }
        let taken = self.watch.cycle().map_err(|rule| self.watch.violation(rule, core))?;
        self.writes.extend(taken.write);
        self.beats.extend(taken.beat);
        self.write().map_err(|rule| self.watch.violation(rule, core))?;
        self.reads.extend(taken.read);

        let ports = &self.watch.ports;
        let mut stalls = self.stalls.borrow_mut();
        // An answer stays until it is taken; the next may come at the same edge.
        let taken = |channel: &(Signal, Signal)| channel.0.is_high() && channel.1.is_high();
        let b_taken = taken(&ports.b);
        if b_taken {
            self.answers.pop_front();
        }
        if !ports.b.0.is_high() || b_taken {
            let offer = self.answers.front().copied().filter(|_| !stalls[3].next_cycle());
            ports.b.0.set(u64::from(offer.is_some()))?;
            put(&ports.b_response, 0)?;
            put(&self.watch.write.answer_id, offer.unwrap_or(0))?;
        }
        let r_taken = taken(&ports.r);
        if r_taken {
            self.contents.count();
            self.sent += 1;
            if self.reads.front().is_some_and(|command| command.beats == self.sent) {
                self.reads.pop_front();
                self.sent = 0;
            }
        }
        if !ports.r.0.is_high() || r_taken {
            let offer = self.reads.front().copied().filter(|_| !stalls[4].next_cycle());
            ports.r.0.set(u64::from(offer.is_some()))?;
            put(&ports.r_response, 0)?;
            if let Some(command) = offer {
                let word = self.contents.get(command.address_of(self.sent));
                ports.r_data.set(word & ports.r_data.mask())?;
                self.watch.read.last.set(u64::from(self.sent + 1 == command.beats))?;
                put(&self.watch.read.answer_id, command.id)?;
            }
        }
        for ((_, ready), stall) in [&ports.aw, &ports.w, &ports.ar].into_iter().zip(stalls.iter_mut()) {
            ready.set(u64::from(!stall.next_cycle()))?;
        }
        Ok(())
    }
}
