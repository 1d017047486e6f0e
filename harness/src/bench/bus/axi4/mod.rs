//! AXI4 with bursts: a master that drives a slave in the design and checks its answers, a memory for a master in the
//! design, and a checker that only listens.
//!
//! A burst is one address and `len + 1` beats of data, the last of them marked by `wlast` or `rlast`; its addresses
//! increase by the bytes of a beat. The master has one write and one read in flight at a time. A broken rule of the
//! slave ends the access with a [`Violation`].

mod checker;
mod memory;

use std::cell::RefCell;
use std::rc::Rc;

pub use self::checker::Checker;
pub use self::memory::Memory;
use super::axi_lite::{Ports, Response, response};
use super::handshake::Offer;
use super::{Pause, Violation, optional};
use crate::bench::error::Error;
use crate::bench::sim::{Dut, Lock, Signal, both};
use crate::engine::error::ModelError;

/// The greatest number of beats in a burst.
const MAX_BURST_BEATS: usize = 256;
/// The page size in bytes: a burst must not cross a multiple of it.
const PAGE_BYTES: u64 = 4096;
/// The code of increasing addresses in `awburst` and `arburst`.
const INCREMENTING: u64 = 1;

/// The signals of one direction that AXI4 has and AXI4-Lite does not.
struct Extra {
    len: Signal,
    size: Option<Signal>,
    burst: Option<Signal>,
    id: Option<Signal>,
    last: Signal,
    /// The id that comes back.
    answer_id: Option<Signal>,
}

impl Extra {
    fn find(dut: &Dut, prefix: &str, address: &str, data: &str, answer: &str) -> Result<Extra, ModelError> {
        let maybe = |name: String| optional(dut, prefix, &name);
        Ok(Extra {
            len: dut.signal(&format!("{prefix}{address}len"))?,
            size: maybe(format!("{address}size"))?,
            burst: maybe(format!("{address}burst"))?,
            id: maybe(format!("{address}id"))?,
            last: dut.signal(&format!("{prefix}{data}last"))?,
            answer_id: maybe(format!("{answer}id"))?,
        })
    }

    fn set_address(&self, beats: usize, bytes: u64) -> Result<(), Error> {
        self.len.set(beats as u64 - 1)?;
        let others = [(&self.size, u64::from(bytes.trailing_zeros())), (&self.burst, INCREMENTING), (&self.id, 0)];
        for (signal, value) in others {
            signal.as_ref().map_or(Ok(()), |signal| signal.set(value))?;
        }
        Ok(())
    }
}

/// A master that reads and writes a slave of the design in bursts, and checks the slave.
#[derive(Clone)]
pub struct Master(Rc<Inner>);

struct Inner {
    dut: Dut,
    ports: Ports,
    write: Extra,
    read: Extra,
    writing: Lock,
    reading: Lock,
    idle: RefCell<Pause>,
}

impl Master {
    /// Creates a master for the slave whose signals begin with `prefix`, such as `s_axi_`.
    ///
    /// # Errors
    /// If a signal other than `wstrb`, `bresp`, `rresp`, those of size, burst and id is missing, or one that a master
    /// drives is driven by the design.
    pub fn new(dut: &Dut, clock: &Signal, prefix: &str) -> Result<Master, Error> {
        let ports = Ports::find(dut, clock, prefix)?;
        for signal in [&ports.aw.0, &ports.w.0, &ports.ar.0, &ports.b.1, &ports.r.1] {
            signal.set(0)?;
        }
        let write = Extra::find(dut, prefix, "aw", "w", "b")?;
        let read = Extra::find(dut, prefix, "ar", "r", "r")?;
        let lock = |what: &str| dut.lock(&format!("{} {what}", ports.name));
        let (writing, reading, idle) = (lock("write"), lock("read"), RefCell::default());
        Ok(Master(Rc::new(Inner { dut: dut.clone(), ports, write, read, writing, reading, idle })))
    }

    /// Sets in which cycles it pauses between beats: as source of write data, and as sink of read data.
    pub fn set_pause(&self, pause: Pause) {
        *self.0.idle.borrow_mut() = pause;
    }

    /// Writes words, of the width of the data, from a byte address on.
    ///
    /// # Errors
    /// If the burst is longer than 256 beats, crosses 4 KiB, or begins between two words; if a value does not fit its
    /// signal; [`Violation`] if the slave breaks a rule. A response other than OKAY is returned.
    pub async fn write_burst(&self, address: u64, words: &[u64]) -> Result<Response, Error> {
        self.0.check(address, words.len())?;
        let _turn = self.0.writing.lock().await;
        let ports = &self.0.ports;
        let address_channel = async {
            ports.aw_address.set(address)?;
            self.0.write.set_address(words.len(), self.0.bytes())?;
            ports.offer(&ports.aw).await
        };
        let (a, d) = both(address_channel, self.0.send(words)).await;
        a?;
        d?;
        let answer = || (response(&ports.b_response), self.0.write.answer_id.as_ref().map_or(0, Signal::get));
        let (answered, id) = ports.accept(&ports.b, answer).await?;
        self.0.rule(id == 0, || format!("bid is {id}, not 0"))?;
        Ok(answered)
    }

    /// Reads words, of the width of the data, from a byte address on. The response is the first that is not OKAY.
    ///
    /// # Errors
    /// As [`Master::write_burst`].
    pub async fn read_burst(&self, address: u64, count: usize) -> Result<(Vec<u64>, Response), Error> {
        self.0.check(address, count)?;
        let _turn = self.0.reading.lock().await;
        let ports = &self.0.ports;
        ports.ar_address.set(address)?;
        self.0.read.set_address(count, self.0.bytes())?;
        ports.offer(&ports.ar).await?;
        self.0.receive(count).await
    }
}

impl Inner {
    /// Returns the width of a beat in bytes.
    fn bytes(&self) -> u64 {
        u64::from(self.ports.r_data.width() / 8).max(1)
    }

    fn check(&self, address: u64, beats: usize) -> Result<(), Error> {
        let (name, bytes) = (&self.ports.name, self.bytes());
        let max = MAX_BURST_BEATS.min(self.write.len.mask().min(self.read.len.mask()) as usize + 1);
        if beats == 0 || beats > max {
            return Err(Error::Bench(format!("'{name}' takes bursts of 1 to {max} beats, not {beats}")));
        }
        if !address.is_multiple_of(bytes) {
            return Err(Error::Bench(format!(
                "'{name}': a burst begins at a multiple of {bytes}, not at {address:#x}"
            )));
        }
        if address / PAGE_BYTES != (address + bytes * beats as u64 - 1) / PAGE_BYTES {
            return Err(Error::Bench(format!(
                "'{name}': {beats} beats from {address:#x} on cross a multiple of 4 KiB"
            )));
        }
        Ok(())
    }

    fn rule(&self, kept: bool, rule: impl Fn() -> String) -> Result<(), Error> {
        if kept {
            return Ok(());
        }
        Err(Violation { bus: self.ports.name.clone(), rule: rule(), time: self.dut.now() }.into())
    }

    async fn send(&self, words: &[u64]) -> Result<(), Error> {
        let ports = &self.ports;
        if let Some(strobe) = &ports.w_strobe {
            strobe.set(strobe.mask())?;
        }
        for (at, word) in words.iter().enumerate() {
            while self.idle.borrow_mut().next_cycle() {
                ports.w.0.set(0)?;
                ports.clock.rising_edge().await;
            }
            ports.w.0.set(1)?;
            ports.w_data.set(*word)?;
            self.write.last.set(u64::from(at + 1 == words.len()))?;
            loop {
                ports.clock.rising_edge().await;
                self.rule(!ports.b.0.is_high(), || "bvalid before the last beat was taken".into())?;
                if ports.w.1.is_high() {
                    break;
                }
            }
        }
        Ok(ports.w.0.set(0)?)
    }

    async fn receive(&self, count: usize) -> Result<(Vec<u64>, Response), Error> {
        let ports = &self.ports;
        let (mut words, mut worst) = (Vec::with_capacity(count), Response::Okay);
        let mut offer = Offer::default();
        while words.len() < count {
            let ready = !self.idle.borrow_mut().next_cycle();
            ports.r.1.set(u64::from(ready))?;
            ports.clock.rising_edge().await;
            let beat = ports.r.0.is_high().then(|| (ports.r_data.get(), self.read.last.is_high()));
            let (taken, broken) = offer.cycle(beat, ready);
            self.rule(broken.is_none(), || format!("r: {}", broken.as_deref().unwrap_or_default()))?;
            let Some((word, last)) = taken else { continue };
            words.push(word);
            let expected = words.len() == count;
            self.rule(last == expected, || format!("rlast is {} at beat {} of {count}", u8::from(last), words.len()))?;
            let id = self.read.answer_id.as_ref().map_or(0, Signal::get);
            self.rule(id == 0, || format!("rid is {id}, not 0"))?;
            if worst == Response::Okay {
                worst = response(&ports.r_response);
            }
        }
        ports.r.1.set(0)?;
        Ok((words, worst))
    }
}
