//! UART: a source that drives a line into the design, and a sink that listens to a line out of it.
//!
//! ```text
//! ~~~~~~\____/ D0 X D1 X ... X D7 X parity /~~~~~~   a start bit, data from the lowest bit on, stop bits
//! ```

use super::Violation;
use super::inbox::Inbox;
use crate::error::{Error, SimError};
use crate::sim::{Dut, Lock, Signal, Wait};
use crate::time::Time;

/// The bit that makes the number of ones in data and parity even or odd.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parity {
    /// Even.
    Even,
    /// Odd.
    Odd,
}

/// How a character is sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Format {
    /// Bits of data, from 5 to 9.
    pub bits: u32,
    /// The parity bit, if there is one.
    pub parity: Option<Parity>,
    /// Stop bits that a source sends, 1 or 2. A sink looks at the first.
    pub stop_bits: u32,
    /// The time of a bit.
    pub bit: Time,
}

impl Format {
    /// Eight bits without parity and one stop bit, at so many bits a second.
    ///
    /// # Errors
    /// If the rate is 0.
    pub fn baud(rate: u64) -> Result<Format, Error> {
        if rate == 0 {
            return Err(SimError::BadTime("a baud rate of 0".into()).into());
        }
        let second = 1_000_000_000_000_000u64;
        Ok(Format { bits: 8, parity: None, stop_bits: 1, bit: Time::fs((second + rate / 2) / rate) })
    }

    fn check(&self) -> Result<(), Error> {
        if !(5..=9).contains(&self.bits) || !(1..=2).contains(&self.stop_bits) || self.bit < Time::fs(2) {
            return Err(Error::Bench(format!("a UART of 5 to 9 bits and 1 or 2 stop bits, not {self:?}")));
        }
        Ok(())
    }

    fn parity_of(&self, value: u64) -> Option<u64> {
        let ones = u64::from(value.count_ones() & 1);
        self.parity.map(|parity| if parity == Parity::Even { ones } else { 1 - ones })
    }
}

/// Drives a line into the design.
#[derive(Clone)]
pub struct Source {
    dut: Dut,
    line: Signal,
    format: Format,
    lock: Lock,
}

impl Source {
    /// A source on an input; the line is idle, at 1.
    ///
    /// # Errors
    /// If the format is not possible, or the design drives the line.
    pub fn new(dut: &Dut, line: &Signal, format: Format) -> Result<Source, Error> {
        format.check()?;
        line.set(1)?;
        Ok(Source { dut: dut.clone(), line: line.clone(), format, lock: dut.lock("uart") })
    }

    /// Sends characters, one after the other, and returns when the last stop bit is over.
    ///
    /// # Errors
    /// If a character has more bits than the format.
    pub async fn send(&self, values: &[u64]) -> Result<(), Error> {
        let Format { bits, stop_bits, bit, .. } = self.format;
        if let Some(value) = values.iter().find(|value| **value >> bits != 0) {
            return Err(Error::Bench(format!("{value:#x} does not fit a character of {bits} bits")));
        }
        let _turn = self.lock.lock().await;
        for value in values {
            let data = (0..bits).map(|at| value >> at & 1);
            let stop = std::iter::repeat_n(1, stop_bits as usize);
            for level in std::iter::once(0).chain(data).chain(self.format.parity_of(*value)).chain(stop) {
                self.line.set(level)?;
                self.dut.timer(bit).await;
            }
        }
        Ok(())
    }
}

/// Listens to a line out of the design. A character with a wrong parity or stop bit ends the run with a [`Violation`].
#[derive(Clone)]
pub struct Sink {
    inbox: Inbox,
}

impl Sink {
    /// A sink on a line.
    ///
    /// # Errors
    /// If the format is not possible.
    pub fn new(dut: &Dut, line: &Signal, format: Format) -> Result<Sink, Error> {
        format.check()?;
        let name = line.info().name;
        let sink = Sink { inbox: Inbox::new(dut, &format!("{name} has a character")) };
        let (dut_of_task, line, kept) = (dut.clone(), line.clone(), sink.clone());
        let task_name = format!("uart sink of {name}");
        let task = dut.spawn(&task_name, async move { kept.listen(&dut_of_task, &line, format, &name).await });
        dut.detach(task.id());
        Ok(sink)
    }

    async fn listen(&self, dut: &Dut, line: &Signal, format: Format, name: &str) -> Result<(), Error> {
        let half = Time::fs(format.bit.as_fs() / 2);
        loop {
            line.falling_edge().await;
            dut.timer(half).await;
            if line.is_high() {
                continue; // shorter than half a bit: no start bit
            }
            let mut value = 0;
            for at in 0..format.bits {
                dut.timer(format.bit).await;
                value |= u64::from(line.is_high()) << at;
            }
            let violation = |rule: String| Violation { bus: name.to_owned(), rule, time: dut.now() };
            if let Some(parity) = format.parity_of(value) {
                dut.timer(format.bit).await;
                if line.get() != parity {
                    return Err(violation(format!("the parity bit of {value:#x} is {}", line.get())).into());
                }
            }
            dut.timer(format.bit).await;
            if !line.is_high() {
                return Err(violation(format!("the stop bit after {value:#x} is 0")).into());
            }
            self.inbox.push(value);
        }
    }

    /// The next character.
    pub async fn recv(&self) -> u64 {
        self.inbox.recv().await
    }

    /// The wait for the next character, when none is there.
    pub fn arrived(&self) -> Wait {
        self.inbox.arrived()
    }

    /// The next character, if it has come.
    pub fn try_recv(&self) -> Option<u64> {
        self.inbox.try_recv()
    }

    /// Characters that have come so far.
    pub fn count(&self) -> u64 {
        self.inbox.count()
    }
}
