//! AXI4-Lite: a master that drives a slave in the design, and a memory for a master in the design.
//!
//! Five channels, each with `valid` and `ready`: write address, write data, write response, read address, read data.
//! Write address and write data may come in any order. A response other than OKAY is returned to the caller.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use super::handshake::Offer;
use super::memory_contents::{MemoryContents, has_contents};
use super::{Pause, Reset, Violation, optional};
use crate::bench::error::Error;
use crate::bench::sim::{Agent, Core, Dut, Edge, Lock, Signal, both};
use crate::engine::error::ModelError;
use crate::engine::time::Time;

/// The response of a slave (`bresp`, `rresp`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Response {
    /// OKAY.
    Okay,
    /// SLVERR: the slave reports an error.
    SlaveError,
    /// DECERR: there is no slave at that address.
    DecodeError,
    /// EXOKAY (1), which AXI4-Lite does not have.
    Reserved,
}

impl Response {
    fn of(code: u64) -> Response {
        match code {
            0 => Response::Okay,
            2 => Response::SlaveError,
            3 => Response::DecodeError,
            _ => Response::Reserved,
        }
    }
}

pub(super) struct Ports {
    pub name: String,
    pub clock: Signal,
    pub aw: (Signal, Signal),
    pub aw_address: Signal,
    pub w: (Signal, Signal),
    pub w_data: Signal,
    pub w_strobe: Option<Signal>,
    pub b: (Signal, Signal),
    pub b_response: Option<Signal>,
    pub ar: (Signal, Signal),
    pub ar_address: Signal,
    pub r: (Signal, Signal),
    pub r_data: Signal,
    pub r_response: Option<Signal>,
}

impl Ports {
    pub fn find(dut: &Dut, clock: &Signal, prefix: &str) -> Result<Ports, ModelError> {
        let one = |name: &str| dut.signal(&format!("{prefix}{name}"));
        let pair = |name: &str| Ok::<_, ModelError>((one(&format!("{name}valid"))?, one(&format!("{name}ready"))?));
        Ok(Ports {
            name: prefix.trim_end_matches(['_', '$', '.']).to_owned(),
            clock: clock.clone(),
            aw: pair("aw")?,
            aw_address: one("awaddr")?,
            w: pair("w")?,
            w_data: one("wdata")?,
            w_strobe: optional(dut, prefix, "wstrb")?,
            b: pair("b")?,
            b_response: optional(dut, prefix, "bresp")?,
            ar: pair("ar")?,
            ar_address: one("araddr")?,
            r: pair("r")?,
            r_data: one("rdata")?,
            r_response: optional(dut, prefix, "rresp")?,
        })
    }

    /// Keeps `valid` at 1 until an edge at which `ready` is 1.
    pub async fn offer(&self, channel: &(Signal, Signal)) -> Result<(), Error> {
        channel.0.set(1)?;
        loop {
            self.clock.rising_edge().await;
            if channel.1.is_high() {
                return Ok(channel.0.set(0)?);
            }
        }
    }

    /// Keeps `ready` at 1 until an edge at which `valid` is 1.
    pub async fn accept<T>(&self, channel: &(Signal, Signal), take: impl Fn() -> T) -> Result<T, Error> {
        channel.1.set(1)?;
        loop {
            self.clock.rising_edge().await;
            if channel.0.is_high() {
                let taken = take();
                channel.1.set(0)?;
                return Ok(taken);
            }
        }
    }
}

pub(super) fn response(signal: &Option<Signal>) -> Response {
    Response::of(signal.as_ref().map_or(0, Signal::get))
}

/// A master that reads and writes registers of the design: one write and one read at a time.
#[derive(Clone)]
pub struct Master {
    ports: Rc<Ports>,
    writing: Lock,
    reading: Lock,
    dut: Dut,
    idle: Rc<RefCell<Pause>>,
}

impl Master {
    /// Creates a master for the slave whose signals begin with `prefix`, such as `s_axi_`.
    ///
    /// # Errors
    /// If a signal other than `wstrb`, `bresp` and `rresp` is missing, or one that a master drives is driven by the
    /// design.
    pub fn new(dut: &Dut, clock: &Signal, prefix: &str) -> Result<Master, Error> {
        let ports = Ports::find(dut, clock, prefix)?;
        for signal in [&ports.aw.0, &ports.w.0, &ports.ar.0, &ports.b.1, &ports.r.1] {
            signal.set(0)?;
        }
        let (writing, reading) =
            (dut.lock(&format!("{} write", ports.name)), dut.lock(&format!("{} read", ports.name)));
        Ok(Master { ports: Rc::new(ports), writing, reading, dut: dut.clone(), idle: Rc::default() })
    }

    /// Sets in which cycles it waits before it uses a channel.
    pub fn set_pause(&self, pause: Pause) {
        *self.idle.borrow_mut() = pause;
    }

    async fn wait_idle(&self) {
        while self.idle.borrow_mut().next_cycle() {
            self.ports.clock.rising_edge().await;
        }
    }

    /// Writes a word.
    ///
    /// # Errors
    /// If a value does not fit its signal. A response other than OKAY is no error here: it is returned.
    pub async fn write(&self, address: u64, data: u64) -> Result<Response, Error> {
        let all = self.ports.w_strobe.as_ref().map_or(0, Signal::mask);
        self.write_bytes(address, data, all).await
    }

    /// Writes some bytes of a word.
    ///
    /// # Errors
    /// As [`Master::write`].
    pub async fn write_bytes(&self, address: u64, data: u64, strobe: u64) -> Result<Response, Error> {
        let _turn = self.writing.lock().await;
        let ports = &self.ports;
        let address_channel = async {
            self.wait_idle().await;
            ports.aw_address.set(address)?;
            ports.offer(&ports.aw).await
        };
        let data_channel = async {
            self.wait_idle().await;
            ports.w_data.set(data)?;
            if let Some(signal) = &ports.w_strobe {
                signal.set(strobe)?;
            }
            ports.offer(&ports.w).await
        };
        let (a, d) = both(address_channel, data_channel).await;
        a?;
        d?;
        self.wait_idle().await;
        ports.accept(&ports.b, || response(&ports.b_response)).await
    }

    /// Reads a word.
    ///
    /// # Errors
    /// If the address does not fit its signal. A response other than OKAY is no error here: it is returned.
    pub async fn read(&self, address: u64) -> Result<(u64, Response), Error> {
        let _turn = self.reading.lock().await;
        let ports = &self.ports;
        self.wait_idle().await;
        ports.ar_address.set(address)?;
        ports.offer(&ports.ar).await?;
        self.wait_idle().await;
        ports.accept(&ports.r, || (ports.r_data.get(), response(&ports.r_response))).await
    }

    /// Returns the simulation time.
    pub fn now(&self) -> Time {
        self.dut.now()
    }
}

/// The pauses of the channels `aw`, `w`, `ar`, `b` and `r`.
type Stalls = Rc<RefCell<[Pause; 5]>>;

/// A memory for a master in the design. Addresses count bytes; words are as wide as the data.
#[derive(Clone)]
pub struct Memory {
    contents: MemoryContents,
    stalls: Stalls,
}

has_contents!(Memory);

struct MemoryAgent {
    ports: Ports,
    reset: Option<Reset>,
    contents: MemoryContents,
    stalls: Stalls,
    addresses: VecDeque<u64>,
    data: VecDeque<(u64, u64)>,
    responses: u64,
    reads: VecDeque<u64>,
    /// What the master offers on `aw`, `w` and `ar`.
    offers: [Offer<(u64, u64)>; 3],
}

impl Memory {
    /// Creates a memory of zeros at the signals that begin with `prefix`, such as `m_axi_`.
    ///
    /// # Errors
    /// If a signal other than `wstrb`, `bresp` and `rresp` is missing, or one that a slave drives is driven by the
    /// design.
    pub fn new(dut: &Dut, clock: &Signal, prefix: &str, reset: Option<Reset>) -> Result<Memory, Error> {
        let ports = Ports::find(dut, clock, prefix)?;
        for signal in [&ports.aw.1, &ports.w.1, &ports.ar.1, &ports.b.0, &ports.r.0] {
            signal.set(0)?;
        }
        let bytes = u64::from(ports.r_data.width() / 8).max(1);
        let memory = Memory { contents: MemoryContents::new(bytes), stalls: Stalls::default() };
        let Memory { contents, stalls } = memory.clone();
        let agent = MemoryAgent {
            ports,
            reset,
            contents,
            stalls,
            addresses: VecDeque::new(),
            data: VecDeque::new(),
            responses: 0,
            reads: VecDeque::new(),
            offers: Default::default(),
        };
        dut.core().add_agent(Box::new(agent), clock.id(), Edge::Rising);
        Ok(memory)
    }

    /// Sets in which cycles each channel stalls.
    pub fn set_stall(&self, stall: Pause) {
        *self.stalls.borrow_mut() = std::array::from_fn(|channel| stall.of_channel(channel as u64));
    }
}

impl Agent for MemoryAgent {
    fn edge(&mut self, core: &Core) -> Result<(), Error> {
        let ports = &self.ports;
        if self.reset.as_ref().is_some_and(Reset::is_active) {
            self.addresses.clear();
            self.data.clear();
            self.reads.clear();
            self.responses = 0;
            self.offers.iter_mut().for_each(Offer::clear);
            for signal in [&ports.aw.1, &ports.w.1, &ports.ar.1, &ports.b.0, &ports.r.0] {
                signal.set(0)?;
            }
            return Ok(());
        }
        let strobe = ports.w_strobe.as_ref().map_or(u64::MAX, Signal::get);
        let channels = [
            ("aw", &ports.aw, (ports.aw_address.get(), 0)),
            ("w", &ports.w, (ports.w_data.get(), strobe)),
            ("ar", &ports.ar, (ports.ar_address.get(), 0)),
        ];
        for (at, (name, (valid, ready), payload)) in channels.into_iter().enumerate() {
            let (taken, broken) = self.offers[at].cycle(valid.is_high().then_some(payload), ready.is_high());
            if let Some(rule) = broken {
                let rule = format!("{name}: {rule}");
                return Err(Violation { bus: ports.name.clone(), rule, time: core.now() }.into());
            }
            let Some(payload) = taken else { continue };
            match at {
                0 => self.addresses.push_back(payload.0),
                1 => self.data.push_back(payload),
                _ => self.reads.push_back(payload.0),
            }
        }
        let mut stalls = self.stalls.borrow_mut();
        while !self.addresses.is_empty() && !self.data.is_empty() {
            if let (Some(address), Some((data, strobe))) = (self.addresses.pop_front(), self.data.pop_front()) {
                self.contents.write(address, data, strobe);
                self.contents.count();
                self.responses += 1;
            }
        }
        // A response stays until it is taken; the next may come at the same edge.
        let b_taken = ports.b.0.is_high() && ports.b.1.is_high();
        if b_taken {
            self.responses -= 1;
        }
        if !ports.b.0.is_high() || b_taken {
            let offer = self.responses > 0 && !stalls[3].next_cycle();
            ports.b.0.set(u64::from(offer))?;
            if let Some(signal) = &ports.b_response {
                signal.set(0)?;
            }
        }
        let r_taken = ports.r.0.is_high() && ports.r.1.is_high();
        if r_taken {
            self.reads.pop_front();
            self.contents.count();
        }
        if !ports.r.0.is_high() || r_taken {
            let offer = !self.reads.is_empty() && !stalls[4].next_cycle();
            ports.r.0.set(u64::from(offer))?;
            if let (true, Some(address)) = (offer, self.reads.front()) {
                let word = self.contents.get(*address);
                ports.r_data.set(word & ports.r_data.mask())?;
            }
            if let Some(signal) = &ports.r_response {
                signal.set(0)?;
            }
        }
        for ((_, ready), stall) in [&ports.aw, &ports.w, &ports.ar].into_iter().zip(stalls.iter_mut()) {
            ready.set(u64::from(!stall.next_cycle()))?;
        }
        Ok(())
    }
}
