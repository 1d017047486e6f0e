//! Takes a stream from the design, or only listens to one.

use std::cell::RefCell;
use std::rc::Rc;

use super::Frame;
use super::checker::{Collector, Listener, Rules, new_collector};
use super::ports::{Ports, WORDS};
use crate::bench::bus::{Pause, Reset, Violation};
use crate::bench::error::Error;
use crate::bench::sim::{Agent, Core, Dut, Edge, Event, Signal};

macro_rules! listening {
    ($name:ident) => {
        impl $name {
            /// Waits for the next frame.
            pub async fn recv(&self) -> Frame {
                loop {
                    if let Some(frame) = self.try_recv() {
                        return frame;
                    }
                    let arrived = self.collector.borrow().arrived.clone();
                    arrived.wait().await;
                }
            }

            /// Returns the next frame that was received and not fetched, or `None`.
            pub fn try_recv(&self) -> Option<Frame> {
                let mut collector = self.collector.borrow_mut();
                let frame = collector.frames.pop_front();
                if collector.frames.is_empty() {
                    collector.arrived.clear();
                }
                frame
            }

            /// Waits for the next `count` symbols of a stream without packets.
            pub async fn recv_symbols(&self, count: usize) -> Vec<u64> {
                loop {
                    {
                        let mut collector = self.collector.borrow_mut();
                        if let Some(open) = collector.open.as_mut().filter(|open| open.symbols.len() >= count) {
                            let rest = open.symbols.split_off(count);
                            return std::mem::replace(&mut open.symbols, rest);
                        }
                        collector.arrived.clear();
                    }
                    let arrived = self.collector.borrow().arrived.clone();
                    arrived.wait().await;
                }
            }

            /// Discards what was received and not fetched, the packet in progress included, as a reset of the receiver
            /// does.
            pub fn clear(&self) {
                let mut collector = self.collector.borrow_mut();
                collector.frames.clear();
                collector.open = None;
                collector.arrived.clear();
            }

            /// Returns an event that is set while a received frame has not been fetched.
            pub fn arrived(&self) -> Event {
                self.collector.borrow().arrived.clone()
            }

            /// Returns how many received frames have not been fetched.
            pub fn len(&self) -> usize {
                self.collector.borrow().frames.len()
            }

            /// Returns `true` if all received frames have been fetched.
            pub fn is_empty(&self) -> bool {
                self.len() == 0
            }

            /// Returns how many beats have been transferred since the start.
            pub fn beats(&self) -> u64 {
                self.collector.borrow().beats
            }

            /// Returns the broken rules so far; with [`Rules::Strict`] the first one ends the run.
            pub fn violations(&self) -> Vec<Violation> {
                self.collector.borrow().violations.clone()
            }
        }
    };
}

/// A sink: drives `ready` and receives a stream from the design.
#[derive(Clone)]
pub struct Sink {
    pause: Rc<RefCell<Pause>>,
    collector: Rc<RefCell<Collector>>,
}

struct SinkAgent<const W: usize> {
    listener: Listener<W>,
    pause: Rc<RefCell<Pause>>,
}

impl Sink {
    /// Creates a sink at a clock, ready from the next edge on.
    ///
    /// # Errors
    /// If `ready` is driven by the design.
    pub fn new(dut: &Dut, clock: &Signal, ports: Ports, reset: Option<Reset>, rules: Rules) -> Result<Sink, Error> {
        if let Some(ready) = &ports.ready {
            ports.require_input(ready)?;
            ready.set(0)?;
        }
        let collector = new_collector(dut, &ports);
        let pause = Rc::new(RefCell::new(Pause::Never));
        let agent: Box<dyn Agent> = if ports.is_narrow() {
            let listener = Listener::<1>::new(ports, reset, rules, &collector);
            Box::new(SinkAgent { listener, pause: pause.clone() })
        } else {
            let listener = Listener::<WORDS>::new(ports, reset, rules, &collector);
            Box::new(SinkAgent { listener, pause: pause.clone() })
        };
        dut.core().add_agent(agent, clock.id(), Edge::Rising);
        Ok(Sink { pause, collector })
    }

    /// Sets in which cycles it is not ready.
    pub fn set_pause(&self, pause: Pause) {
        *self.pause.borrow_mut() = pause;
    }
}

listening!(Sink);

impl<const W: usize> Agent for SinkAgent<W> {
    fn edge(&mut self, core: &Core) -> Result<(), Error> {
        let in_reset = self.listener.in_reset();
        if !in_reset {
            self.listener.cycle(core.now())?;
        }
        if let Some(ready) = &self.listener.ports.ready {
            let stall = in_reset || self.pause.borrow_mut().next_cycle();
            ready.set(u64::from(!stall))?;
        }
        Ok(())
    }
}

/// A monitor: receives a stream without driving a signal of it.
#[derive(Clone)]
pub struct Monitor {
    collector: Rc<RefCell<Collector>>,
}

struct MonitorAgent<const W: usize>(Listener<W>);

impl Monitor {
    /// Creates a monitor at a clock.
    ///
    /// # Errors
    /// None today; the type is that of [`Sink::new`].
    pub fn new(dut: &Dut, clock: &Signal, ports: Ports, reset: Option<Reset>, rules: Rules) -> Result<Monitor, Error> {
        let collector = new_collector(dut, &ports);
        let agent: Box<dyn Agent> = if ports.is_narrow() {
            Box::new(MonitorAgent(Listener::<1>::new(ports, reset, rules, &collector)))
        } else {
            Box::new(MonitorAgent(Listener::<WORDS>::new(ports, reset, rules, &collector)))
        };
        dut.core().add_agent(agent, clock.id(), Edge::Rising);
        Ok(Monitor { collector })
    }
}

listening!(Monitor);

impl<const W: usize> Agent for MonitorAgent<W> {
    fn edge(&mut self, core: &Core) -> Result<(), Error> {
        if self.0.in_reset() { Ok(()) } else { self.0.cycle(core.now()) }
    }
}
