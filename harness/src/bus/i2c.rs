//! I2C: a master that drives a device in the design, and a memory device for a master in the design.
//!
//! ```text
//! sda  ~~\____X A6 X A5 ... X R/W X ack X D7 ...   ____/~~   open drain: 0 where anyone pulls the line down
//! scl  ~~~~\___/~~\_/~~\ ...                      __/~~~~~   a device that is not ready holds scl at 0
//!       start                                      stop
//! ```

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use super::{Violation, line};
use crate::error::{Error, SimError};
use crate::sim::{Dut, Lock, Signal};
use crate::time::Time;

/// An open-drain line between the design and one model, which pulls it down with 0 and releases it with 1.
#[derive(Clone)]
pub struct Line {
    level: Signal,
    released: Option<Signal>,
    drive: Signal,
    pulls: Rc<Cell<bool>>,
}

impl Line {
    /// A line whose level the design gives in `level`; `drive` is the input for the model's side. Both may be one
    /// `inout`.
    ///
    /// # Errors
    /// If a signal is wider than a bit, or `drive` is driven by the design.
    pub fn new(level: &Signal, drive: &Signal) -> Result<Line, Error> {
        Line::with(level, None, drive)
    }

    /// A line at the three signals of a pad: the design's value `out`, which counts where `tristate` is 0, and `input`,
    /// which gets the level of the line from the model.
    ///
    /// # Errors
    /// As [`Line::new`], for `input`.
    pub fn pad(dut: &Dut, out: &Signal, tristate: &Signal, input: &Signal) -> Result<Line, Error> {
        line::check(tristate)?;
        let pad = Line::with(out, Some(tristate.clone()), input)?;
        let task = dut.spawn(&format!("pad of {}", input.info().name), pad.clone().follow(dut.clone()));
        dut.detach(task.id());
        Ok(pad)
    }

    fn with(level: &Signal, released: Option<Signal>, drive: &Signal) -> Result<Line, Error> {
        line::check(level)?;
        line::check(drive)?;
        drive.set(1)?;
        Ok(Line { level: level.clone(), released, drive: drive.clone(), pulls: Rc::default() })
    }

    /// Keeps the level of the line at the design's input.
    async fn follow(self, dut: Dut) -> Result<(), Error> {
        loop {
            self.put()?;
            dut.first(self.of_design().map(Signal::value_change)).await;
        }
    }

    fn of_design(&self) -> impl Iterator<Item = &Signal> {
        std::iter::once(&self.level).chain(&self.released)
    }

    /// Pulls the line down, or releases it.
    fn set(&self, level: bool) -> Result<(), Error> {
        self.pulls.set(!level);
        self.put()
    }

    fn put(&self) -> Result<(), Error> {
        let level = if self.released.is_some() { self.is_high() } else { !self.pulls.get() };
        Ok(self.drive.set(u64::from(level))?)
    }

    fn is_high(&self) -> bool {
        !self.pulls.get() && self.of_design().any(Signal::is_high)
    }
}

/// What ends a bit: the fall of `scl`, or a change of `sda` before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Seen {
    Bit(bool),
    Start,
    Stop,
}

/// Both lines, as one side uses them.
#[derive(Clone)]
struct Bus {
    dut: Dut,
    scl: Line,
    sda: Line,
}

impl Bus {
    /// Waits for a change of the lines.
    async fn change(&self) {
        let signals = self.scl.of_design().chain(self.sda.of_design());
        let drives = [&self.scl.drive, &self.sda.drive];
        self.dut.first(signals.chain(drives).map(Signal::value_change)).await;
    }

    async fn scl_is(&self, high: bool) {
        while self.scl.is_high() != high {
            self.change().await;
        }
    }

    fn violation(&self, rule: String) -> Error {
        let bus = self.sda.level.info().name;
        Violation { bus, rule, time: self.dut.now() }.into()
    }
}

/// Reads and writes devices of the design. It sees other masters only as a line that is not as it left it.
#[derive(Clone)]
pub struct Master {
    bus: Bus,
    quarter: Time,
    active: Rc<Cell<bool>>,
    stretched: Rc<Cell<Time>>,
    lock: Lock,
}

impl Master {
    /// A master at so many bits a second; the bus is free.
    ///
    /// # Errors
    /// If the rate is 0 or a quarter of a bit is below 1 fs.
    pub fn new(dut: &Dut, scl: Line, sda: Line, rate: u64) -> Result<Master, Error> {
        let quarter = 250_000_000_000_000u64.checked_div(rate).unwrap_or(0);
        if quarter == 0 {
            return Err(SimError::BadTime(format!("{rate} bits a second on I2C")).into());
        }
        let bus = Bus { dut: dut.clone(), scl, sda };
        let lock = dut.lock("i2c master");
        Ok(Master { bus, quarter: Time::fs(quarter), active: Rc::default(), stretched: Rc::default(), lock })
    }

    /// Begins a transfer; within one, a repeated start.
    ///
    /// # Errors
    /// A [`Violation`] if a line is held at 0 where it must be free.
    pub async fn start(&self) -> Result<(), Error> {
        let _turn = self.lock.lock().await;
        self.begin().await
    }

    /// Ends a transfer; does nothing where none was begun.
    ///
    /// # Errors
    /// As [`Master::start`].
    pub async fn stop(&self) -> Result<(), Error> {
        let _turn = self.lock.lock().await;
        self.end().await
    }

    /// Sends a byte and returns whether it was acknowledged.
    ///
    /// # Errors
    /// If no transfer was begun; a [`Violation`] if `sda` is held at 0 where the master sends 1.
    pub async fn send(&self, byte: u8) -> Result<bool, Error> {
        let _turn = self.lock.lock().await;
        self.put_byte(byte).await
    }

    /// Receives a byte and acknowledges it, or not, which tells a device to stop sending.
    ///
    /// # Errors
    /// As [`Master::send`].
    pub async fn recv(&self, acknowledge: bool) -> Result<u8, Error> {
        let _turn = self.lock.lock().await;
        self.take_byte(acknowledge).await
    }

    /// A start, the address of 7 bits, and bytes to its device; no stop, so that a repeated start may follow.
    ///
    /// # Errors
    /// If the address or a byte is not acknowledged: a stop has been sent then. Else as [`Master::send`].
    pub async fn write(&self, address: u8, bytes: &[u8]) -> Result<(), Error> {
        let _turn = self.lock.lock().await;
        self.address(address, false).await?;
        for (at, byte) in bytes.iter().enumerate() {
            if !self.put_byte(*byte).await? {
                self.end().await?;
                return Err(Error::Bench(format!(
                    "the I2C device {address:#04x} did not acknowledge byte {at}, {byte:#04x}: it takes no more, or \
                     sees another byte"
                )));
            }
        }
        Ok(())
    }

    /// A start, the address of 7 bits, and `count` bytes from its device, the last not acknowledged; no stop.
    ///
    /// # Errors
    /// As [`Master::write`].
    pub async fn read(&self, address: u8, count: usize) -> Result<Vec<u8>, Error> {
        let _turn = self.lock.lock().await;
        self.address(address, true).await?;
        let mut bytes = Vec::with_capacity(count);
        for at in 1..=count {
            bytes.push(self.take_byte(at != count).await?);
        }
        Ok(bytes)
    }

    /// How long devices have held `scl` at 0 so far.
    pub fn stretched(&self) -> Time {
        self.stretched.get()
    }

    async fn address(&self, address: u8, read: bool) -> Result<(), Error> {
        if address > 0x7f {
            return Err(Error::Bench(format!(
                "an I2C address of 7 bits, not {address:#04x}: leave out the bit for read or write"
            )));
        }
        self.begin().await?;
        if self.put_byte(address << 1 | u8::from(read)).await? {
            return Ok(());
        }
        self.end().await?;
        Err(Error::Bench(format!(
            "no I2C device acknowledged the address {address:#04x}: compare it with the design's address of 7 bits, \
             and see that the device is out of reset"
        )))
    }

    async fn begin(&self) -> Result<(), Error> {
        let bus = &self.bus;
        if self.active.get() {
            self.wait(1).await;
            bus.sda.set(true)?;
            self.wait(1).await;
            self.release_scl().await?;
            self.wait(2).await;
        } else {
            // The bus must have been free for some time, which it has not where the models are new.
            self.wait(2).await;
        }
        if !bus.scl.is_high() || !bus.sda.is_high() {
            let held = if bus.scl.is_high() { "sda" } else { "scl" };
            return Err(bus.violation(format!("{held} is held at 0 where the master wants to send a start")));
        }
        bus.sda.set(false)?;
        self.wait(2).await;
        bus.scl.set(false)?;
        self.active.set(true);
        Ok(())
    }

    async fn end(&self) -> Result<(), Error> {
        if !self.active.replace(false) {
            return Ok(());
        }
        let bus = &self.bus;
        self.wait(1).await;
        bus.sda.set(false)?;
        self.wait(1).await;
        self.release_scl().await?;
        self.wait(2).await;
        bus.sda.set(true)?;
        self.wait(2).await;
        if bus.sda.is_high() {
            return Ok(());
        }
        Err(bus.violation("sda is held at 0 after the master sent a stop".into()))
    }

    /// Sends a bit, or releases `sda` for one to come, and returns the level.
    async fn bit(&self, bit: bool) -> Result<bool, Error> {
        if !self.active.get() {
            return Err(Error::Bench("a byte on I2C without a start before it".into()));
        }
        self.wait(1).await;
        self.bus.sda.set(bit)?;
        self.wait(1).await;
        self.release_scl().await?;
        self.wait(1).await;
        let level = self.bus.sda.is_high();
        self.wait(1).await;
        self.bus.scl.set(false)?;
        Ok(level)
    }

    async fn put_byte(&self, byte: u8) -> Result<bool, Error> {
        for at in (0..8).rev() {
            self.put_bit(byte >> at & 1 == 1).await?;
        }
        Ok(!self.bit(true).await?)
    }

    async fn put_bit(&self, bit: bool) -> Result<(), Error> {
        if self.bit(bit).await? == bit {
            return Ok(());
        }
        Err(self.bus.violation("sda is held at 0 where the master sends 1".into()))
    }

    async fn take_byte(&self, acknowledge: bool) -> Result<u8, Error> {
        let mut byte = 0;
        for _ in 0..8 {
            byte = byte << 1 | u8::from(self.bit(true).await?);
        }
        self.put_bit(!acknowledge).await?;
        Ok(byte)
    }

    async fn release_scl(&self) -> Result<(), Error> {
        self.bus.scl.set(true)?;
        self.bus.dut.read_write().await;
        let begun = self.bus.dut.now();
        self.bus.scl_is(true).await;
        self.stretched.set(self.stretched.get() + (self.bus.dut.now() - begun));
        Ok(())
    }

    async fn wait(&self, quarters: u64) {
        self.bus.dut.timer(Time::fs(self.quarter.as_fs() * quarters)).await;
    }
}

struct State {
    bytes: Vec<u8>,
    pointer: usize,
    stretch: Time,
    accesses: u64,
}

/// A memory device for a master in the design. The first bytes of a write set the pointer, the highest first, as many
/// as the size needs; each byte read or written moves it on by one, at the end to 0. A start or stop within a byte ends
/// the run with a [`Violation`].
#[derive(Clone)]
pub struct Memory {
    bus: Bus,
    address: u8,
    state: Rc<RefCell<State>>,
}

impl Memory {
    /// A memory of `size` zeros at an address of 7 bits.
    ///
    /// # Errors
    /// If the address has more than 7 bits or the size is 0.
    pub fn new(dut: &Dut, scl: Line, sda: Line, address: u8, size: usize) -> Result<Memory, Error> {
        if address > 0x7f || size == 0 {
            return Err(Error::Bench(format!(
                "an I2C memory of 1 byte at least at an address of 7 bits, not {size} at {address:#04x}"
            )));
        }
        let state = State { bytes: vec![0; size], pointer: 0, stretch: Time::ZERO, accesses: 0 };
        let bus = Bus { dut: dut.clone(), scl, sda };
        let memory = Memory { bus, address, state: Rc::new(RefCell::new(state)) };
        let kept = memory.clone();
        let task = dut.spawn(&format!("i2c memory {address:#04x}"), async move { kept.listen().await });
        dut.detach(task.id());
        Ok(memory)
    }

    /// The byte at an address, modulo the size.
    pub fn get(&self, at: usize) -> u8 {
        let state = self.state.borrow();
        state.bytes[at % state.bytes.len()]
    }

    /// Sets the byte at an address, modulo the size.
    pub fn set(&self, at: usize, byte: u8) {
        let mut state = self.state.borrow_mut();
        let size = state.bytes.len();
        state.bytes[at % size] = byte;
    }

    /// Sets how long `scl` is held at 0 after each acknowledged byte.
    pub fn set_stretch(&self, span: Time) {
        self.state.borrow_mut().stretch = span;
    }

    /// Bytes read and written so far, those of the pointer left out.
    pub fn accesses(&self) -> u64 {
        self.state.borrow().accesses
    }

    async fn listen(&self) -> Result<(), Error> {
        let mut started = false;
        loop {
            if !started {
                self.wait_for_start().await;
            }
            self.bus.scl_is(false).await;
            started = self.transfer().await? == Seen::Start;
        }
    }

    async fn wait_for_start(&self) {
        loop {
            let was = self.bus.sda.is_high();
            self.bus.change().await;
            if was && !self.bus.sda.is_high() && self.bus.scl.is_high() {
                return;
            }
        }
    }

    /// From the address to the start or stop that ends the transfer; a stop also where this memory is no part of it.
    async fn transfer(&self) -> Result<Seen, Error> {
        let first = match self.take_byte().await? {
            Ok(byte) => byte,
            Err(end) => return Ok(end),
        };
        if first >> 1 != self.address {
            return Ok(Seen::Stop);
        }
        self.put_bit(false).await?;
        self.hold_scl().await?;
        if first & 1 == 1 {
            while self.put_byte().await? {
                self.hold_scl().await?;
            }
            return Ok(Seen::Stop);
        }
        let size = self.state.borrow().bytes.len();
        let in_pointer = ((usize::BITS - (size - 1).leading_zeros()).div_ceil(8) as usize).max(1);
        let mut pointer = 0;
        for at in 0.. {
            let byte = match self.take_byte().await? {
                Ok(byte) => byte,
                Err(end) => return Ok(end),
            };
            if at < in_pointer {
                pointer = pointer << 8 | usize::from(byte);
                self.state.borrow_mut().pointer = pointer % size;
            } else {
                self.next_byte(|place| *place = byte);
            }
            self.put_bit(false).await?;
            self.hold_scl().await?;
        }
        Ok(Seen::Stop)
    }

    /// Uses the byte at the pointer and moves it on.
    fn next_byte<T>(&self, with: impl FnOnce(&mut u8) -> T) -> T {
        let mut state = self.state.borrow_mut();
        let at = state.pointer;
        state.pointer = (at + 1) % state.bytes.len();
        state.accesses += 1;
        with(&mut state.bytes[at])
    }

    /// Sends the byte at the pointer and returns whether it was acknowledged.
    async fn put_byte(&self) -> Result<bool, Error> {
        let byte = self.next_byte(|place| *place);
        for at in (0..8).rev() {
            self.put_bit(byte >> at & 1 == 1).await?;
        }
        match self.bit(true).await? {
            Seen::Bit(refused) => Ok(!refused),
            end => Err(self.cut(end, 8)),
        }
    }

    async fn put_bit(&self, bit: bool) -> Result<(), Error> {
        match self.bit(bit).await? {
            Seen::Bit(level) if level == bit => Ok(()),
            Seen::Bit(_) => Err(self.bus.violation("sda is held at 0 where the memory sends 1".into())),
            end => Err(self.bus.violation(format!("{} while the memory sends", name_of(end)))),
        }
    }

    /// The next byte, or the start or stop before it.
    async fn take_byte(&self) -> Result<Result<u8, Seen>, Error> {
        let mut byte = 0;
        for at in 0..8 {
            match self.bit(true).await? {
                Seen::Bit(bit) => byte = byte << 1 | u8::from(bit),
                end if at == 0 => return Ok(Err(end)),
                end => return Err(self.cut(end, at)),
            }
        }
        Ok(Ok(byte))
    }

    fn cut(&self, end: Seen, bits: u32) -> Error {
        self.bus.violation(format!("{} after {bits} bits of a byte", name_of(end)))
    }

    /// From the fall of `scl` to the next: puts a level on `sda` and sees what comes.
    async fn bit(&self, level: bool) -> Result<Seen, Error> {
        let Bus { scl, sda, .. } = &self.bus;
        sda.set(level)?;
        self.bus.scl_is(true).await;
        let level = sda.is_high();
        loop {
            self.bus.change().await;
            if !scl.is_high() {
                sda.set(true)?;
                return Ok(Seen::Bit(level));
            }
            if sda.is_high() != level {
                return Ok(if level { Seen::Start } else { Seen::Stop });
            }
        }
    }

    async fn hold_scl(&self) -> Result<(), Error> {
        let span = self.state.borrow().stretch;
        if span != Time::ZERO {
            self.bus.scl.set(false)?;
            self.bus.dut.timer(span).await;
            self.bus.scl.set(true)?;
        }
        Ok(())
    }
}

fn name_of(end: Seen) -> &'static str {
    if end == Seen::Start { "a start" } else { "a stop" }
}
