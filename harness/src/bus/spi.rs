//! SPI: a master that drives a peripheral in the design, and a peripheral for a master in the design.
//!
//! ```text
//! cs       ~~\_______________________/~~   words follow one another while cs is active
//! sclk     _____/~~\__/~~\__/~~\________   CPOL 0; with CPOL 1 upside down
//! CPHA 0   --X  D0   X  D1 X  D2 X------   data is taken at the leading edge and changes at the trailing one
//! CPHA 1   -----X  D0 X  D1 X  D2 X-----   data changes at the leading edge and is taken at the trailing one
//! ```

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use super::inbox::Inbox;
use super::{Violation, line};
use crate::error::{Error, ModelError, SimError};
use crate::sim::{Dut, Lock, Signal, Wait};
use crate::time::Time;

/// The four lines, each of one bit.
#[derive(Clone)]
pub struct Lines {
    /// The serial clock.
    pub sclk: Signal,
    /// Data from the master.
    pub mosi: Signal,
    /// Data from the peripheral.
    pub miso: Signal,
    /// Chip select.
    pub cs: Signal,
}

impl Lines {
    /// The lines `sclk`, `mosi`, `miso` and `cs` whose names begin with `prefix`, such as `spi_`.
    ///
    /// # Errors
    /// If one of them is missing.
    pub fn find(dut: &Dut, prefix: &str) -> Result<Lines, ModelError> {
        let one = |name: &str| dut.signal(&format!("{prefix}{name}"));
        Ok(Lines { sclk: one("sclk")?, mosi: one("mosi")?, miso: one("miso")?, cs: one("cs")? })
    }
}

/// Which bit of a word is the first on the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// The highest.
    HighestFirst,
    /// The lowest.
    LowestFirst,
}

/// How words are sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Format {
    /// The level of `sclk` while it is idle: CPOL.
    pub idle_high: bool,
    /// Data is taken at the trailing edge of `sclk`, not at the leading one: CPHA.
    pub trailing: bool,
    /// Bits in a word, from 1 to 64.
    pub bits: u32,
    /// Which bit is the first.
    pub order: Order,
    /// The level of `cs` that selects.
    pub select_high: bool,
}

impl Format {
    /// Words of 8 bits, the highest first, `cs` active at 0, in a mode from 0 to 3: CPOL is its upper bit, CPHA its
    /// lower one.
    ///
    /// # Errors
    /// If there is no such mode.
    pub fn mode(mode: u32) -> Result<Format, Error> {
        if mode > 3 {
            return Err(Error::Bench(format!("an SPI mode from 0 to 3, not {mode}")));
        }
        let (idle_high, trailing) = (mode & 2 != 0, mode & 1 != 0);
        Ok(Format { idle_high, trailing, bits: 8, order: Order::HighestFirst, select_high: false })
    }

    fn check(&self, lines: &Lines) -> Result<(), Error> {
        if !(1..=64).contains(&self.bits) {
            return Err(Error::Bench(format!("an SPI word of 1 to 64 bits, not {}", self.bits)));
        }
        [&lines.sclk, &lines.mosi, &lines.miso, &lines.cs].into_iter().try_for_each(line::check)
    }

    /// The place in a word of the bit that is so many bits after the first.
    fn place(&self, at: u32) -> u32 {
        match self.order {
            Order::HighestFirst => self.bits - 1 - at,
            Order::LowestFirst => at,
        }
    }

    fn words_fit(&self, words: &[u64]) -> Result<(), Error> {
        match words.iter().find(|word| self.bits < 64 && **word >> self.bits != 0) {
            Some(word) => Err(Error::Bench(format!("{word:#x} does not fit an SPI word of {} bits", self.bits))),
            None => Ok(()),
        }
    }

    /// A word of ones: what an idle line at 1 gives.
    fn ones(&self) -> u64 {
        u64::MAX >> (64 - self.bits)
    }
}

/// Half a period of `sclk`.
#[derive(Clone)]
pub enum Half {
    /// A span of time.
    Time(Time),
    /// Rising edges of a clock; the lines change at them as registers of that clock do.
    Cycles(Signal, u64),
}

/// Drives a peripheral in the design.
#[derive(Clone)]
pub struct Master {
    dut: Dut,
    lines: Lines,
    format: Format,
    half: Half,
    lock: Lock,
}

impl Master {
    /// A master; no peripheral is selected.
    ///
    /// # Errors
    /// If a line is wider than a bit, `sclk`, `mosi` or `cs` is driven by the design, or the format or the half period
    /// is not possible.
    pub fn new(dut: &Dut, lines: &Lines, format: Format, half: Half) -> Result<Master, Error> {
        format.check(lines)?;
        if matches!(half, Half::Time(Time::ZERO) | Half::Cycles(_, 0)) {
            return Err(SimError::BadTime("half a period of sclk of 0".into()).into());
        }
        lines.sclk.set(u64::from(format.idle_high))?;
        lines.mosi.set(1)?;
        lines.cs.set(u64::from(!format.select_high))?;
        let lock = dut.lock("spi master");
        Ok(Master { dut: dut.clone(), lines: lines.clone(), format, half, lock })
    }

    /// Selects the peripheral, sends words one after the other, and returns the words that came back, one for each.
    ///
    /// # Errors
    /// If a word has more bits than the format.
    pub async fn transfer(&self, words: &[u64]) -> Result<Vec<u64>, Error> {
        self.format.words_fit(words)?;
        let _turn = self.lock.lock().await;
        let Format { trailing, bits, select_high, .. } = self.format;
        let bits_of = |word: u64| (0..bits).map(move |at| word >> self.format.place(at) & 1);
        let mut levels = words.iter().flat_map(|word| bits_of(*word)).collect::<VecDeque<u64>>();
        let mut next = || self.lines.mosi.set(levels.pop_front().unwrap_or(1));
        self.lines.cs.set(u64::from(select_high))?;
        if !trailing {
            next()?;
        }
        self.wait_half().await;
        let mut received = Vec::with_capacity(words.len());
        for _ in words {
            let mut word = 0;
            for at in 0..bits {
                for is_trailing in [false, true] {
                    if is_trailing == trailing {
                        word |= self.lines.miso.get() << self.format.place(at);
                    } else {
                        next()?;
                    }
                    self.lines.sclk.set(u64::from(self.format.idle_high == is_trailing))?;
                    self.wait_half().await;
                }
            }
            received.push(word);
        }
        self.lines.mosi.set(1)?;
        self.lines.cs.set(u64::from(!select_high))?;
        self.wait_half().await;
        Ok(received)
    }

    async fn wait_half(&self) {
        match &self.half {
            Half::Time(time) => self.dut.timer(*time).await,
            Half::Cycles(clock, count) => clock.cycles(*count).await,
        }
    }
}

/// Answers a master in the design: a word for each that it sends. A word that `cs` cuts short, or an `sclk` that is not
/// idle when `cs` becomes active, ends the run with a [`Violation`].
#[derive(Clone)]
pub struct Peripheral {
    format: Format,
    answers: Rc<RefCell<VecDeque<u64>>>,
    inbox: Inbox,
}

impl Peripheral {
    /// A peripheral; `miso` is 1 while it is not selected.
    ///
    /// # Errors
    /// If a line is wider than a bit, `miso` is driven by the design, or the format is not possible.
    pub fn new(dut: &Dut, lines: &Lines, format: Format) -> Result<Peripheral, Error> {
        format.check(lines)?;
        lines.miso.set(1)?;
        let name = lines.cs.info().name;
        let inbox = Inbox::new(dut, &format!("the SPI peripheral at {name} has a word"));
        let peripheral = Peripheral { format, answers: Rc::default(), inbox };
        let (kept, dut_of_task, lines) = (peripheral.clone(), dut.clone(), lines.clone());
        let task = dut.spawn(&format!("spi peripheral at {name}"), async move {
            loop {
                // Before its reset a design may seem to select: a frame begins with a change of `cs`.
                while kept.is_selected(&lines) {
                    lines.cs.value_change().await;
                }
                while !kept.is_selected(&lines) {
                    lines.cs.value_change().await;
                }
                let broken = kept.answer_frame(&dut_of_task, &lines).await?;
                lines.miso.set(1)?;
                if let Some(rule) = broken {
                    return Err::<(), Error>(Violation { bus: name, rule, time: dut_of_task.now() }.into());
                }
            }
        });
        dut.detach(task.id());
        Ok(peripheral)
    }

    fn is_selected(&self, lines: &Lines) -> bool {
        lines.cs.is_high() == self.format.select_high
    }

    /// Answers until `cs` is no longer active. Returns the rule that was broken.
    async fn answer_frame(&self, dut: &Dut, lines: &Lines) -> Result<Option<String>, Error> {
        let Format { idle_high, trailing, bits, .. } = self.format;
        if lines.sclk.is_high() != idle_high {
            let level = lines.sclk.get();
            return Ok(Some(format!("sclk is {level} when cs becomes active: CPOL is not {}", u64::from(idle_high))));
        }
        // The word that comes, its bits so far, and the answer, which is used up once a bit of it was taken.
        let (mut word, mut at, mut answer) = (0, 0, self.next_answer());
        let drive = |answer: u64, at: u32| lines.miso.set(answer >> self.format.place(at) & 1);
        if !trailing {
            drive(answer, 0)?;
        }
        loop {
            dut.first([lines.cs.value_change(), lines.sclk.value_change()]).await;
            if !self.is_selected(lines) {
                return Ok((at != 0).then(|| format!("cs ends after {at} of the {bits} bits of a word")));
            }
            let is_trailing = lines.sclk.is_high() == idle_high;
            if is_trailing != trailing {
                if at == 0 {
                    answer = self.next_answer();
                }
                drive(answer, at)?;
                continue;
            }
            if at == 0 {
                self.answers.borrow_mut().pop_front();
            }
            word |= lines.mosi.get() << self.format.place(at);
            at += 1;
            if at == bits {
                self.inbox.push(word);
                (word, at) = (0, 0);
            }
        }
    }

    fn next_answer(&self) -> u64 {
        self.answers.borrow().front().copied().unwrap_or(self.format.ones())
    }

    /// Adds words to answer with, one for each that comes; ones where there is none. The answer to a word is chosen
    /// at the edge of `sclk` that puts its first bit on `miso`.
    ///
    /// # Errors
    /// If a word has more bits than the format.
    pub fn answer(&self, words: &[u64]) -> Result<(), Error> {
        self.format.words_fit(words)?;
        self.answers.borrow_mut().extend(words);
        Ok(())
    }

    /// The next word.
    pub async fn recv(&self) -> u64 {
        self.inbox.recv().await
    }

    /// The wait for the next word, when none is there.
    pub fn arrived(&self) -> Wait {
        self.inbox.arrived()
    }

    /// The next word, if it has come.
    pub fn try_recv(&self) -> Option<u64> {
        self.inbox.try_recv()
    }

    /// Words that have come so far.
    pub fn count(&self) -> u64 {
        self.inbox.count()
    }
}
