//! APB: a master that drives a slave in the design, and a memory for a master in the design.
//!
//! ```text
//! clk      __/~~\__/~~\__/~~\__/~~\__
//! psel     ____/~~~~~~~~~~~~~~~~~\___   one setup cycle, then access cycles until pready is 1
//! penable  __________/~~~~~~~~~~~\___
//! pready   ________________/~~~~~\___
//! ```

use std::cell::RefCell;
use std::rc::Rc;

use super::axi_lite::Response;
use super::handshake::Offer;
use super::words::{Contents, has_contents};
use super::{Pause, Reset, Violation, optional};
use crate::error::{Error, ModelError};
use crate::sim::{Agent, Core, Dut, Edge, Lock, Signal};

struct Ports {
    name: String,
    clock: Signal,
    select: Signal,
    enable: Signal,
    address: Signal,
    write: Signal,
    write_data: Signal,
    strobe: Option<Signal>,
    read_data: Signal,
    ready: Option<Signal>,
    error: Option<Signal>,
}

impl Ports {
    fn find(dut: &Dut, clock: &Signal, prefix: &str) -> Result<Ports, ModelError> {
        let one = |name: &str| dut.signal(&format!("{prefix}{name}"));
        Ok(Ports {
            name: prefix.trim_end_matches(['_', '$', '.']).to_owned(),
            clock: clock.clone(),
            select: one("psel")?,
            enable: one("penable")?,
            address: one("paddr")?,
            write: one("pwrite")?,
            write_data: one("pwdata")?,
            strobe: optional(dut, prefix, "pstrb")?,
            read_data: one("prdata")?,
            ready: optional(dut, prefix, "pready")?,
            error: optional(dut, prefix, "pslverr")?,
        })
    }
}

/// Reads and writes registers of the design: one access at a time, in the order of the calls.
#[derive(Clone)]
pub struct Master {
    ports: Rc<Ports>,
    lock: Lock,
}

impl Master {
    /// The slave whose signals begin with `prefix`: `psel`, `penable`, `paddr`, `pwrite`, `pwdata`, `prdata`.
    ///
    /// # Errors
    /// If a signal other than `pready`, `pstrb` and `pslverr` is missing, or one that a master drives is driven by the
    /// design.
    pub fn new(dut: &Dut, clock: &Signal, prefix: &str) -> Result<Master, Error> {
        let ports = Ports::find(dut, clock, prefix)?;
        ports.select.set(0)?;
        ports.enable.set(0)?;
        let lock = dut.lock(&ports.name);
        Ok(Master { ports: Rc::new(ports), lock })
    }

    /// Writes a word, or the bytes of it that are 1 in `strobe`.
    ///
    /// # Errors
    /// If a value does not fit its signal. `pslverr` is no error here: it is returned.
    pub async fn write(&self, address: u64, data: u64, strobe: Option<u64>) -> Result<Response, Error> {
        let _turn = self.lock.lock().await;
        let ports = &self.ports;
        ports.write.set(1)?;
        ports.write_data.set(data)?;
        if let Some(signal) = &ports.strobe {
            signal.set(strobe.unwrap_or(signal.mask()))?;
        }
        Ok(self.access(address).await?.1)
    }

    /// Reads a word.
    ///
    /// # Errors
    /// If the address does not fit its signal. `pslverr` is no error here: it is returned.
    pub async fn read(&self, address: u64) -> Result<(u64, Response), Error> {
        let _turn = self.lock.lock().await;
        self.ports.write.set(0)?;
        if let Some(signal) = &self.ports.strobe {
            signal.set(0)?;
        }
        self.access(address).await
    }

    async fn access(&self, address: u64) -> Result<(u64, Response), Error> {
        let ports = &self.ports;
        ports.address.set(address)?;
        ports.select.set(1)?;
        ports.clock.rising_edge().await;
        ports.enable.set(1)?;
        loop {
            ports.clock.rising_edge().await;
            if ports.ready.as_ref().is_none_or(Signal::is_high) {
                break;
            }
        }
        let failed = ports.error.as_ref().is_some_and(Signal::is_high);
        let word = ports.read_data.get();
        ports.select.set(0)?;
        ports.enable.set(0)?;
        Ok((word, if failed { Response::SlaveError } else { Response::Okay }))
    }
}

/// A memory for a master in the design. Addresses count bytes; words are as wide as the data.
#[derive(Clone)]
pub struct Memory {
    contents: Contents,
    stall: Rc<RefCell<Pause>>,
}

has_contents!(Memory);

struct MemoryAgent {
    ports: Ports,
    reset: Option<Reset>,
    contents: Contents,
    stall: Rc<RefCell<Pause>>,
    /// Address, write, data, strobe.
    offer: Offer<(u64, bool, u64, u64)>,
    /// The setup cycle of an access is over.
    in_access: bool,
}

impl Memory {
    /// A memory of zeros at the signals that begin with `prefix`.
    ///
    /// # Errors
    /// As [`Master::new`], for the signals that a slave drives.
    pub fn new(dut: &Dut, clock: &Signal, prefix: &str, reset: Option<Reset>) -> Result<Memory, Error> {
        let ports = Ports::find(dut, clock, prefix)?;
        for signal in [&ports.ready, &ports.error].into_iter().flatten() {
            signal.set(0)?;
        }
        let contents = Contents::new(u64::from(ports.read_data.width() / 8).max(1));
        let memory = Memory { contents, stall: Rc::default() };
        let Memory { contents, stall } = memory.clone();
        let agent =
            MemoryAgent { ports, reset, contents, stall, offer: Offer::new("psel", "pready"), in_access: false };
        dut.core().add_agent(Box::new(agent), clock.id(), Edge::Rising);
        Ok(memory)
    }

    /// Sets in which access cycles `pready` is 0; without that signal, none.
    pub fn set_stall(&self, stall: Pause) {
        *self.stall.borrow_mut() = stall;
    }
}

impl Agent for MemoryAgent {
    fn edge(&mut self, core: &Core) -> Result<(), Error> {
        let ports = &self.ports;
        if self.reset.as_ref().is_some_and(Reset::is_active) {
            self.offer.clear();
            self.in_access = false;
            return Ok(());
        }
        let violation = |rule: String| Violation { bus: ports.name.clone(), rule, time: core.now() };
        let (selected, enabled) = (ports.select.is_high(), ports.enable.is_high());
        if selected && enabled != self.in_access {
            let cycle = if self.in_access { "an access" } else { "the setup" };
            return Err(violation(format!("penable is {} in {cycle} cycle", u8::from(enabled))).into());
        }
        let write = ports.write.is_high();
        let strobe = ports.strobe.as_ref().map_or(u64::MAX, Signal::get);
        let payload = || {
            let (data, strobe) = if write { (ports.write_data.get(), strobe) } else { (0, 0) };
            (ports.address.get(), write, data, strobe)
        };
        let ready = enabled && ports.ready.as_ref().is_none_or(Signal::is_high);
        let (taken, broken) = self.offer.cycle(selected.then(payload), ready);
        if let Some(rule) = broken {
            return Err(violation(rule).into());
        }
        if let Some((address, write, data, strobe)) = taken {
            self.contents.count();
            if write {
                self.contents.write(address, data, strobe);
            }
        }
        self.in_access = selected && taken.is_none();
        let answers = self.in_access && (ports.ready.is_none() || !self.stall.borrow_mut().next_cycle());
        if let Some(signal) = &ports.ready {
            signal.set(u64::from(answers))?;
        }
        if answers && !write {
            let word = self.contents.get(ports.address.get());
            ports.read_data.set(word & ports.read_data.mask())?;
        }
        Ok(())
    }
}
