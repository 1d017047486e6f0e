//! Looks at every cycle of a stream: checks the rules and puts beats together to frames.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use super::Frame;
use super::ports::{Beat, Ports, ReadyHistory};
use crate::bench::bus::handshake::Offer;
use crate::bench::bus::{Reset, Violation};
use crate::bench::error::Error;
use crate::bench::sim::{Dut, Event};
use crate::engine::time::Time;

/// The effect of a broken rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rules {
    /// It ends the run.
    #[default]
    Strict,
    /// It is added to a list.
    Recorded,
}

pub(super) struct Collector {
    pub frames: VecDeque<Frame>,
    pub open: Option<Frame>,
    pub beats: u64,
    pub arrived: Event,
    pub violations: Vec<Violation>,
}

/// A checker of every cycle that also assembles beats to frames. `W` is that of [`Beat`].
pub(super) struct Listener<const W: usize> {
    pub ports: Ports,
    reset: Option<Reset>,
    strict: bool,
    history: ReadyHistory,
    /// The beat, which must stay until it is taken.
    offer: Offer<Beat<W>>,
    collector: Rc<RefCell<Collector>>,
}

impl<const W: usize> Listener<W> {
    pub fn new(ports: Ports, reset: Option<Reset>, rules: Rules, collector: &Rc<RefCell<Collector>>) -> Listener<W> {
        Listener {
            ports,
            reset,
            strict: rules == Rules::Strict,
            history: ReadyHistory::default(),
            offer: Offer::new("beat"),
            collector: collector.clone(),
        }
    }

    /// Checks one cycle; an error if a rule was broken and the rules are strict.
    #[inline]
    pub fn cycle(&mut self, now: Time) -> Result<(), Error> {
        let latency = self.ports.latency();
        let valid = self.ports.valid.is_high();
        let ready = self.ports.is_ready();
        let mut broken: Vec<String> = Vec::new();
        let was_ready = latency == 0 || self.history.before(latency);
        self.history.push(ready);
        if valid && !was_ready {
            broken.push(format!("valid without ready {latency} cycles before"));
        }
        let offered = valid.then(|| self.ports.get());
        if latency == 0 {
            broken.extend(self.offer.watch(offered.as_ref(), ready));
        }
        // With a latency, `ready` allowed this beat long ago.
        if let Some(beat) = &offered
            && (ready || latency > 0)
        {
            self.take(beat, &mut broken);
        }
        if !broken.is_empty() {
            let violations = broken.into_iter().map(|rule| Violation { bus: self.ports.name.clone(), rule, time: now });
            let mut collector = self.collector.borrow_mut();
            collector.violations.extend(violations);
            if self.strict
                && let Some(first) = collector.violations.first()
            {
                return Err(first.clone().into());
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn take(&mut self, beat: &Beat<W>, broken: &mut Vec<String>) {
        let ports = &self.ports;
        let mut collector = self.collector.borrow_mut();
        let collector = &mut *collector;
        collector.beats += 1;
        if ports.first.is_some() {
            match (&collector.open, beat.first) {
                (None, false) => broken.push("a beat outside of a packet: no startofpacket".into()),
                (Some(_), true) => broken.push("startofpacket inside a packet".into()),
                _ => {}
            }
        }
        if let (Some(empty), Some(_)) = (&ports.empty, &ports.last) {
            let lanes = empty.get();
            if lanes != 0 && !beat.last {
                broken.push(format!("empty is {lanes} before endofpacket"));
            } else if lanes >= u64::from(ports.lanes) {
                broken.push(format!("empty is {lanes} of {} symbols", ports.lanes));
            }
        }
        if let Some(open) = &collector.open
            && (open.channel, open.destination) != (beat.channel, beat.destination)
        {
            broken.push("channel changed inside a packet".into());
        }
        let frame = collector.open.get_or_insert_with(|| Frame {
            channel: beat.channel,
            destination: beat.destination,
            ..Frame::default()
        });
        frame.error = beat.error;
        for at in 0..ports.lanes {
            if beat.keep >> at & 1 == 1 {
                frame.symbols.push(ports.extract(&beat.data, at));
            }
        }
        if beat.last {
            collector.frames.extend(collector.open.take());
        }
        if beat.last || ports.last.is_none() {
            collector.arrived.set();
        }
    }

    pub fn in_reset(&mut self) -> bool {
        let active = self.reset.as_ref().is_some_and(Reset::is_active);
        if active {
            self.offer.clear();
            self.history = ReadyHistory::default();
            // Its sender is reset too, and begins with a new one.
            if self.ports.last.is_some() {
                self.collector.borrow_mut().open = None;
            }
        }
        active
    }
}

pub(super) fn new_collector(dut: &Dut, ports: &Ports) -> Rc<RefCell<Collector>> {
    Rc::new(RefCell::new(Collector {
        frames: VecDeque::new(),
        open: None,
        beats: 0,
        arrived: dut.event(&format!("{} has a frame", ports.name)),
        violations: Vec::new(),
    }))
}
