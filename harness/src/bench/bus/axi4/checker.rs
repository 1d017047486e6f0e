//! The rules of AXI4, looked at in every cycle: for both sides, without driving anything.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use super::{Extra, MAX_BURST_BEATS, PAGE_BYTES};
use crate::bench::bus::axi_lite::Ports;
use crate::bench::bus::handshake::Offer;
use crate::bench::bus::{Reset, Violation};
use crate::bench::error::Error;
use crate::bench::sim::{Agent, Core, Dut, Edge, Signal};
use crate::engine::error::ModelError;

/// The kind of a burst: how its addresses follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Fixed,
    Increasing,
    Wrapping,
    Reserved,
}

/// An address channel's payload: one burst.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Command {
    pub address: u64,
    pub beats: u64,
    /// Bytes of a beat.
    pub bytes: u64,
    kind: Kind,
    pub id: u64,
}

impl Command {
    /// Returns the byte address of a beat (AMBA AXI and ACE protocol specification, A3.4.1).
    pub fn address_of(&self, beat: u64) -> u64 {
        let aligned = self.address / self.bytes * self.bytes;
        let next = aligned.wrapping_add(beat * self.bytes);
        match self.kind {
            _ if beat == 0 => self.address,
            Kind::Fixed => self.address,
            Kind::Increasing | Kind::Reserved => next,
            Kind::Wrapping => {
                let whole = self.bytes * self.beats;
                let low = self.address / whole * whole;
                low + (next - low) % whole
            }
        }
    }

    /// Returns the rule that the burst breaks on a bus of `bytes` bytes, or `None`.
    fn broken(&self, bus_bytes: u64) -> Option<String> {
        let beats = self.beats;
        if self.bytes > bus_bytes {
            return Some(format!("beats of {} bytes on a bus of {bus_bytes}", self.bytes));
        }
        match self.kind {
            Kind::Reserved => Some("burst is 3, which is reserved".into()),
            Kind::Fixed if beats > 16 => Some(format!("a fixed burst of {beats} beats: 16 at most")),
            Kind::Wrapping if ![2, 4, 8, 16].contains(&beats) => Some(format!("a wrapping burst of {beats} beats")),
            Kind::Wrapping if !self.address.is_multiple_of(self.bytes) => {
                Some(format!("a wrapping burst begins at {:#x}, between two beats", self.address))
            }
            Kind::Increasing
                if self.address / PAGE_BYTES
                    != (self.address_of(beats - 1) + self.bytes - 1).max(self.address) / PAGE_BYTES =>
            {
                Some(format!("{beats} beats from {:#x} on cross a multiple of 4 KiB", self.address))
            }
            _ => None,
        }
    }
}

/// A beat of write data: data, strobe, last.
pub(super) type WriteBeat = (u64, u64, bool);

/// The payloads that were transferred in a cycle.
#[derive(Default)]
pub(super) struct Transferred {
    pub write: Option<Command>,
    pub beat: Option<WriteBeat>,
    pub read: Option<Command>,
}

/// The signals of a bus and what is in flight on it.
pub(super) struct Watch {
    pub ports: Ports,
    pub write: Extra,
    pub read: Extra,
    reset: Option<Reset>,
    flight: Flight,
}

#[derive(Default)]
struct Flight {
    aw: Offer<Command>,
    w: Offer<WriteBeat>,
    ar: Offer<Command>,
    b: Offer<(u64, u64)>,
    r: Offer<(u64, u64, bool, u64)>,
    /// Write bursts whose data is not complete.
    writes: VecDeque<Command>,
    /// Beats of the burst of data in progress, and of complete bursts whose address has not arrived.
    beats: u64,
    complete: VecDeque<u64>,
    /// Ids of writes that are complete and not answered.
    unanswered: Vec<u64>,
    /// Reads in flight, each with the number of beats received.
    reads: Vec<(Command, u64)>,
}

impl Watch {
    pub fn find(dut: &Dut, clock: &Signal, prefix: &str, reset: Option<Reset>) -> Result<Watch, ModelError> {
        let ports = Ports::find(dut, clock, prefix)?;
        let write = Extra::find(dut, prefix, "aw", "w", "b")?;
        let read = Extra::find(dut, prefix, "ar", "r", "r")?;
        Ok(Watch { ports, write, read, reset, flight: Flight::default() })
    }

    /// Returns the width of the data in bytes.
    pub fn bytes(&self) -> u64 {
        u64::from(self.ports.r_data.width() / 8).max(1)
    }

    fn command(&self, address: &Signal, extra: &Extra) -> Command {
        let kind = match extra.burst.as_ref().map_or(1, Signal::get) {
            0 => Kind::Fixed,
            1 => Kind::Increasing,
            2 => Kind::Wrapping,
            _ => Kind::Reserved,
        };
        let bytes = extra.size.as_ref().map_or(self.bytes(), |size| 1 << size.get());
        let id = extra.id.as_ref().map_or(0, Signal::get);
        Command { address: address.get(), beats: (extra.len.get() + 1).min(MAX_BURST_BEATS as u64), bytes, kind, id }
    }

    /// Returns `true` if the reset is active, and forgets what is in flight then.
    pub fn in_reset(&mut self) -> bool {
        let active = self.reset.as_ref().is_some_and(Reset::is_active);
        if active {
            self.flight = Flight::default();
        }
        active
    }

    /// Looks at one cycle.
    ///
    /// # Errors
    /// The rule that was broken.
    pub fn cycle(&mut self) -> Result<Transferred, String> {
        let bytes = self.bytes();
        let (ports, high) = (&self.ports, |signal: &Signal| signal.is_high());
        let id = |signal: &Option<Signal>| signal.as_ref().map_or(0, Signal::get);
        let aw = high(&ports.aw.0).then(|| self.command(&ports.aw_address, &self.write));
        let ar = high(&ports.ar.0).then(|| self.command(&ports.ar_address, &self.read));
        let strobe = || ports.w_strobe.as_ref().map_or(u64::MAX, Signal::get);
        let w = high(&ports.w.0).then(|| (ports.w_data.get(), strobe(), self.write.last.is_high()));
        let b = high(&ports.b.0).then(|| (id(&ports.b_response), id(&self.write.answer_id)));
        let r = high(&ports.r.0)
            .then(|| (ports.r_data.get(), id(&ports.r_response), self.read.last.is_high(), id(&self.read.answer_id)));
        let flight = &mut self.flight;
        let (write, broken_aw) = flight.aw.cycle(aw, high(&ports.aw.1));
        let (beat, broken_w) = flight.w.cycle(w, high(&ports.w.1));
        let (read, broken_ar) = flight.ar.cycle(ar, high(&ports.ar.1));
        let (answer, broken_b) = flight.b.cycle(b, high(&ports.b.1));
        let (word, broken_r) = flight.r.cycle(r, high(&ports.r.1));
        let channels = [("aw", broken_aw), ("w", broken_w), ("ar", broken_ar), ("b", broken_b), ("r", broken_r)];
        if let Some((name, rule)) = channels.into_iter().find_map(|(name, rule)| Some((name, rule?))) {
            return Err(format!("{name}: {rule}"));
        }
        // Answers first: they may not be of what is taken at this very edge.
        if let Some((_, id)) = b {
            let at = flight.unanswered.iter().position(|of| *of == id);
            let at = at.ok_or_else(|| format!("b: an answer of id {id}, of which no write is complete"))?;
            if answer.is_some() {
                flight.unanswered.remove(at);
            }
        }
        if let Some((_, _, last, id)) = r {
            let at = flight.reads.iter().position(|(of, _)| of.id == id);
            let at = at.ok_or_else(|| format!("r: data of id {id}, of which no read is in flight"))?;
            let (command, came) = &mut flight.reads[at];
            if last != (*came + 1 == command.beats) {
                return Err(format!("rlast is {} at beat {} of {}", u8::from(last), *came + 1, command.beats));
            }
            if word.is_some() {
                *came += 1;
                if last {
                    flight.reads.remove(at);
                }
            }
        }
        for (name, command) in [("aw", write), ("ar", read)] {
            if let Some(rule) = command.and_then(|command| command.broken(bytes)) {
                return Err(format!("{name}: {rule}"));
            }
        }
        flight.reads.extend(read.map(|command| (command, 0)));
        flight.writes.extend(write);
        flight.take_beat(beat)?;
        Ok(Transferred { write, beat, read })
    }
}

impl Flight {
    /// Puts bursts of data and their addresses together, which may come in any order.
    fn take_beat(&mut self, beat: Option<WriteBeat>) -> Result<(), String> {
        if let Some((.., last)) = beat {
            self.beats += 1;
            if last {
                self.complete.push_back(std::mem::take(&mut self.beats));
            } else if self.beats == MAX_BURST_BEATS as u64 {
                return Err(format!("wlast is 0 at beat {MAX_BURST_BEATS}"));
            }
        }
        while let (Some(command), Some(beats)) = (self.writes.front(), self.complete.front()) {
            if command.beats != *beats {
                return Err(format!("wlast is 1 at beat {beats} of {}", command.beats));
            }
            self.unanswered.push(command.id);
            self.writes.pop_front();
            self.complete.pop_front();
        }
        match self.writes.front() {
            Some(command) if self.beats >= command.beats => {
                Err(format!("wlast is 0 at beat {} of {}", self.beats, command.beats))
            }
            _ => Ok(()),
        }
    }
}

/// A checker of the rules of both sides of a bus; master and slave are in the design or in the bench.
#[derive(Clone)]
pub struct Checker(Rc<RefCell<Counts>>);

#[derive(Default)]
struct Counts {
    writes: u64,
    reads: u64,
}

struct CheckerAgent {
    watch: Watch,
    counts: Rc<RefCell<Counts>>,
}

impl Checker {
    /// Creates a checker of the bus whose signals begin with `prefix`. A broken rule ends the run with a [`Violation`].
    ///
    /// # Errors
    /// If a signal other than `wstrb`, `bresp`, `rresp`, those of size, burst and id is missing.
    pub fn new(dut: &Dut, clock: &Signal, prefix: &str, reset: Option<Reset>) -> Result<Checker, Error> {
        let watch = Watch::find(dut, clock, prefix, reset)?;
        let counts: Rc<RefCell<Counts>> = Rc::default();
        let agent = CheckerAgent { watch, counts: counts.clone() };
        dut.core().add_agent(Box::new(agent), clock.id(), Edge::Rising);
        Ok(Checker(counts))
    }

    /// Returns how many write and read bursts have been addressed so far.
    pub fn bursts(&self) -> (u64, u64) {
        let counts = self.0.borrow();
        (counts.writes, counts.reads)
    }
}

impl Agent for CheckerAgent {
    fn edge(&mut self, core: &Core) -> Result<(), Error> {
        if self.watch.in_reset() {
            return Ok(());
        }
        let taken = self.watch.cycle().map_err(|rule| self.watch.violation(rule, core))?;
        let mut counts = self.counts.borrow_mut();
        counts.writes += u64::from(taken.write.is_some());
        counts.reads += u64::from(taken.read.is_some());
        Ok(())
    }
}

impl Watch {
    pub fn violation(&self, rule: String, core: &Core) -> Violation {
        Violation { bus: self.ports.name.clone(), rule, time: core.now() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_addresses_of_bursts_follow_their_kind() {
        let of = |kind, address| Command { address, beats: 4, bytes: 4, kind, id: 0 };
        let addresses = |command: Command| [0, 1, 2, 3].map(|beat| command.address_of(beat));
        assert_eq!(addresses(of(Kind::Increasing, 0x102)), [0x102, 0x104, 0x108, 0x10c]);
        assert_eq!(addresses(of(Kind::Wrapping, 0x108)), [0x108, 0x10c, 0x100, 0x104]);
        assert_eq!(addresses(of(Kind::Fixed, 0x104)), [0x104; 4]);
        assert!(of(Kind::Wrapping, 0x102).broken(4).is_some() && of(Kind::Increasing, 0xff8).broken(4).is_some());
        assert!(of(Kind::Increasing, 0xff0).broken(4).is_none() && of(Kind::Increasing, 0).broken(2).is_some());
    }
}
