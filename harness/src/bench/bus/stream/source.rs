//! Drives a stream into the design.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use super::Frame;
use super::ports::{Ports, ReadyHistory, WORDS};
use crate::bench::bus::{Pause, Random, Reset};
use crate::bench::error::Error;
use crate::bench::sim::{Agent, Core, Dut, Edge, Event, Signal};

struct SourceState {
    frames: VecDeque<Frame>,
    /// Symbols of the first frame that the design has accepted.
    taken: usize,
    /// Beats of all frames that the design has not accepted yet.
    pending: usize,
    pause: Pause,
    /// Cycles of the first frame's gap that have passed.
    gap: u64,
    /// The source of random values for the other signals while `valid` is 0, if asked for.
    noise: Option<Random>,
    presented: bool,
    sent: u64,
    idle: Event,
}

/// A source: drives a stream into the design.
#[derive(Clone)]
pub struct Source {
    ports: Ports,
    state: Rc<RefCell<SourceState>>,
}

/// The source's part at the clock; `W` is that of a beat.
struct SourceAgent<const W: usize> {
    ports: Ports,
    reset: Option<Reset>,
    history: ReadyHistory,
    state: Rc<RefCell<SourceState>>,
}

impl Source {
    /// Creates a source at a clock; it is idle until something is sent.
    ///
    /// # Errors
    /// If `valid` is driven by the design.
    pub fn new(dut: &Dut, clock: &Signal, ports: Ports, reset: Option<Reset>) -> Result<Source, Error> {
        ports.require_input(&ports.valid)?;
        ports.valid.set(0)?;
        let idle = dut.event(&format!("{} idle", ports.name));
        idle.set();
        let state = SourceState {
            frames: VecDeque::new(),
            taken: 0,
            pending: 0,
            pause: Pause::Never,
            gap: 0,
            noise: None,
            presented: false,
            sent: 0,
            idle,
        };
        let state = Rc::new(RefCell::new(state));
        let agent: Box<dyn Agent> = if ports.is_narrow() {
            Box::new(SourceAgent::<1>::new(&ports, reset, &state))
        } else {
            Box::new(SourceAgent::<WORDS>::new(&ports, reset, &state))
        };
        dut.core().add_agent(agent, clock.id(), Edge::Rising);
        Ok(Source { ports, state })
    }

    /// Sets in which cycles it offers no new beat.
    pub fn set_pause(&self, pause: Pause) {
        self.state.borrow_mut().pause = pause;
    }

    /// Drives random values on all signals but `valid` in cycles in which it offers no beat: a design must not look at
    /// them. By default they keep the values of the last beat.
    pub fn randomize_idle(&self, seed: u64) {
        self.state.borrow_mut().noise = Some(Random::new(seed));
    }

    /// Discards everything queued, the beat on offer included, as a reset of the sender does. `valid` falls at the next
    /// edge.
    pub fn clear(&self) {
        let mut state = self.state.borrow_mut();
        state.frames.clear();
        (state.taken, state.pending, state.gap, state.presented) = (0, 0, 0, false);
        state.idle.set();
    }

    /// Queues a frame.
    ///
    /// # Errors
    /// If the frame is empty, does not fill whole beats where neither `empty` nor `tkeep` says so, or has a symbol,
    /// channel, error or destination that does not fit.
    pub fn send(&self, frame: &Frame) -> Result<(), Error> {
        let beats = self.ports.beats(frame)?;
        let mut state = self.state.borrow_mut();
        state.frames.push_back(frame.clone());
        state.pending += beats;
        state.idle.clear();
        Ok(())
    }

    /// Waits until the design has taken everything queued.
    pub async fn drained(&self) {
        let idle = self.state.borrow().idle.clone();
        idle.wait().await;
    }

    /// Returns an event that is set while nothing is queued.
    pub fn idle(&self) -> Event {
        self.state.borrow().idle.clone()
    }

    /// Returns how many beats the design has accepted.
    pub fn sent(&self) -> u64 {
        self.state.borrow().sent
    }

    /// Returns how many queued beats the design has not accepted yet.
    pub fn pending(&self) -> usize {
        self.state.borrow().pending
    }
}

impl SourceState {
    /// Discards the rest of the first frame, whose receiver has lost the part before it.
    fn drop_first(&mut self, lanes: usize) {
        if let Some(frame) = self.frames.pop_front() {
            self.pending -= (frame.symbols.len() - self.taken).div_ceil(lanes);
        }
        (self.taken, self.gap) = (0, 0);
        if self.pending == 0 {
            self.idle.set();
        }
    }
}

impl<const W: usize> SourceAgent<W> {
    fn new(ports: &Ports, reset: Option<Reset>, state: &Rc<RefCell<SourceState>>) -> SourceAgent<W> {
        SourceAgent { ports: ports.clone(), reset, history: ReadyHistory::default(), state: state.clone() }
    }
}

impl<const W: usize> Agent for SourceAgent<W> {
    fn edge(&mut self, core: &Core) -> Result<(), Error> {
        let mut state = self.state.borrow_mut();
        let state = &mut *state;
        let latency = self.ports.latency();
        if self.reset.as_ref().is_some_and(Reset::is_active) {
            state.presented = false;
            self.history = ReadyHistory::default();
            if self.ports.last.is_some() && state.taken > 0 {
                state.drop_first(self.ports.lanes as usize);
            }
            return Ok(self.ports.valid.set(0)?);
        }
        let ready = self.ports.is_ready();
        self.history.push(ready);
        if state.presented && (latency > 0 || ready) {
            state.sent += 1;
            state.pending -= 1;
            state.presented = false;
            state.taken += self.ports.lanes as usize;
            if state.frames.front().is_some_and(|frame| state.taken >= frame.symbols.len()) {
                state.frames.pop_front();
                (state.taken, state.gap) = (0, 0);
            }
            if state.pending == 0 {
                state.idle.set();
            }
        }
        if state.presented {
            return Ok(());
        }
        let held = state.pause.next_cycle();
        let allowed = latency == 0 || self.history.before(latency);
        if let Some(frame) = state.frames.front() {
            let in_gap = state.taken == 0 && state.gap < frame.sending.gap;
            state.gap += u64::from(in_gap);
            if allowed && !held && !in_gap {
                self.ports.put(core, &self.ports.beat::<W>(frame, state.taken))?;
                state.presented = true;
                return Ok(());
            }
        }
        if let Some(random) = &mut state.noise {
            self.ports.put_random(core, random)?;
        }
        Ok(self.ports.valid.set(0)?)
    }
}
