//! Wishbone, classic cycles: a master that drives a slave in the design, and a memory for a master in the design.
//!
//! `cyc` and `stb` stay, with address and data, until a cycle in which `ack` (or `err`) is 1. Names are those of the
//! specification (Wishbone B4, 2010) with the design's `_i` and `_o`, or without; data as `dat_w` and `dat_r` too.

use std::cell::RefCell;
use std::rc::Rc;

use super::axi_lite::Response;
use super::handshake::Offer;
use super::words::{Contents, has_contents};
use super::{Pause, Reset, Violation};
use crate::error::{Error, ModelError};
use crate::sim::{Agent, Core, Dut, Edge, Lock, Signal};

struct Ports {
    name: String,
    clock: Signal,
    cycle: Signal,
    strobe: Signal,
    write: Signal,
    address: Signal,
    write_data: Signal,
    select: Option<Signal>,
    read_data: Signal,
    acknowledge: Signal,
    error: Option<Signal>,
}

impl Ports {
    /// `of_master` and `of_slave` end the names of the signals that each side drives.
    fn find(dut: &Dut, clock: &Signal, prefix: &str, of_master: &str, of_slave: &str) -> Result<Ports, ModelError> {
        // The first of several names that there is; the error is that of the first.
        let any = |names: &[String]| -> Result<Signal, ModelError> {
            let mut first = None;
            for name in names {
                match dut.signal(&format!("{prefix}{name}")) {
                    Err(error @ ModelError::NoSuchSignal { .. }) => drop(first.get_or_insert(error)),
                    other => return other,
                }
            }
            Err(first.unwrap_or(ModelError::NoSuchSignal {
                name: prefix.to_owned(),
                top: dut.top(),
                nearest: Vec::new(),
            }))
        };
        let some = |names: &[String]| match any(names) {
            Ok(signal) => Ok(Some(signal)),
            Err(ModelError::NoSuchSignal { .. }) => Ok(None),
            Err(other) => Err(other),
        };
        let from = |name: &str, side: &str| [format!("{name}{side}"), name.to_owned()];
        Ok(Ports {
            name: prefix.trim_end_matches(['_', '$', '.']).to_owned(),
            clock: clock.clone(),
            cycle: any(&from("cyc", of_master))?,
            strobe: any(&from("stb", of_master))?,
            write: any(&from("we", of_master))?,
            address: any(&from("adr", of_master))?,
            write_data: any(&[format!("dat{of_master}"), "dat_w".into()])?,
            select: some(&from("sel", of_master))?,
            read_data: any(&[format!("dat{of_slave}"), "dat_r".into()])?,
            acknowledge: any(&from("ack", of_slave))?,
            error: some(&from("err", of_slave))?,
        })
    }
}

/// Reads and writes a slave of the design: one access at a time, in the order of the calls.
#[derive(Clone)]
pub struct Master {
    ports: Rc<Ports>,
    lock: Lock,
}

impl Master {
    /// The slave whose signals begin with `prefix`, such as `wb_`.
    ///
    /// # Errors
    /// If a signal other than `sel` and `err` is missing, or one that a master drives is driven by the design.
    pub fn new(dut: &Dut, clock: &Signal, prefix: &str) -> Result<Master, Error> {
        let ports = Ports::find(dut, clock, prefix, "_i", "_o")?;
        ports.cycle.set(0)?;
        ports.strobe.set(0)?;
        let lock = dut.lock(&ports.name);
        Ok(Master { ports: Rc::new(ports), lock })
    }

    /// Writes a word, or the bytes of it that are 1 in `select`.
    ///
    /// # Errors
    /// If a value does not fit its signal. `err` is no error here: it is returned.
    pub async fn write(&self, address: u64, data: u64, select: Option<u64>) -> Result<Response, Error> {
        let _turn = self.lock.lock().await;
        self.ports.write.set(1)?;
        self.ports.write_data.set(data)?;
        Ok(self.access(address, select).await?.1)
    }

    /// Reads a word.
    ///
    /// # Errors
    /// If the address does not fit its signal. `err` is no error here: it is returned.
    pub async fn read(&self, address: u64) -> Result<(u64, Response), Error> {
        let _turn = self.lock.lock().await;
        self.ports.write.set(0)?;
        self.access(address, None).await
    }

    async fn access(&self, address: u64, select: Option<u64>) -> Result<(u64, Response), Error> {
        let ports = &self.ports;
        ports.address.set(address)?;
        if let Some(signal) = &ports.select {
            signal.set(select.unwrap_or(signal.mask()))?;
        }
        ports.cycle.set(1)?;
        ports.strobe.set(1)?;
        let failed = loop {
            ports.clock.rising_edge().await;
            let failed = ports.error.as_ref().is_some_and(Signal::is_high);
            if failed || ports.acknowledge.is_high() {
                break failed;
            }
        };
        let word = ports.read_data.get();
        ports.cycle.set(0)?;
        ports.strobe.set(0)?;
        Ok((word, if failed { Response::SlaveError } else { Response::Okay }))
    }
}

/// A memory for a master in the design: words by address, which counts as the master's `adr` does.
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
    /// Address, write, data, select.
    offer: Offer<(u64, bool, u64, u64)>,
}

impl Memory {
    /// A memory of zeros at the signals that begin with `prefix`.
    ///
    /// # Errors
    /// If a signal other than `sel` and `err` is missing, or one that a slave drives is driven by the design.
    pub fn new(dut: &Dut, clock: &Signal, prefix: &str, reset: Option<Reset>) -> Result<Memory, Error> {
        let ports = Ports::find(dut, clock, prefix, "_o", "_i")?;
        ports.acknowledge.set(0)?;
        if let Some(signal) = &ports.error {
            signal.set(0)?;
        }
        let memory = Memory { contents: Contents::new(1), stall: Rc::default() };
        let Memory { contents, stall } = memory.clone();
        let agent = MemoryAgent { ports, reset, contents, stall, offer: Offer::new("stb", "ack") };
        dut.core().add_agent(Box::new(agent), clock.id(), Edge::Rising);
        Ok(memory)
    }

    /// Sets in which cycles it does not answer.
    pub fn set_stall(&self, stall: Pause) {
        *self.stall.borrow_mut() = stall;
    }
}

impl Agent for MemoryAgent {
    fn edge(&mut self, core: &Core) -> Result<(), Error> {
        let ports = &self.ports;
        if self.reset.as_ref().is_some_and(Reset::is_active) {
            self.offer.clear();
            return Ok(ports.acknowledge.set(0)?);
        }
        let violation = |rule: String| Violation { bus: ports.name.clone(), rule, time: core.now() };
        if ports.strobe.is_high() && !ports.cycle.is_high() {
            return Err(violation("stb without cyc".into()).into());
        }
        let asks = ports.strobe.is_high();
        let payload = || {
            let write = ports.write.is_high();
            let select = ports.select.as_ref().map_or(u64::MAX, Signal::get);
            (ports.address.get(), write, if write { ports.write_data.get() } else { 0 }, select)
        };
        let (taken, broken) = self.offer.cycle(asks.then(payload), ports.acknowledge.is_high());
        if let Some(rule) = broken {
            return Err(violation(rule).into());
        }
        if let Some((address, write, data, select)) = taken {
            self.contents.count();
            if write {
                self.contents.write(address, data, select);
            }
        }
        let answers = asks && taken.is_none() && !self.stall.borrow_mut().next_cycle();
        ports.acknowledge.set(u64::from(answers))?;
        if answers {
            let word = self.contents.get(ports.address.get());
            ports.read_data.set(word & ports.read_data.mask())?;
        }
        Ok(())
    }
}
