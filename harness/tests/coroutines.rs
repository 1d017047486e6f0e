//! Coroutines of another language: which outcome each wait gives them, and what they read when they run.

mod common;

use std::cell::RefCell;
use std::rc::Rc;

use common::{build, sim};
use hoverlock_harness::Time;
use hoverlock_harness::sim::{Coroutine, EdgeOrder, Outcome, Step, Trigger};

const PERIOD: Time = Time::ns(10);

/// A coroutine as another language would bring it: waits for each trigger of a list and notes how it ended.
struct Script {
    waits: std::vec::IntoIter<Trigger>,
    seen: Rc<RefCell<Vec<String>>>,
}

impl Coroutine for Script {
    fn resume(&mut self, outcome: Outcome) -> Step {
        self.seen.borrow_mut().push(format!("{outcome:?}"));
        self.waits.next().map_or(Step::Done, Step::Wait)
    }

    fn cancel(&mut self) {
        self.seen.borrow_mut().push("cancelled".into());
    }
}

/// A coroutine that takes a list of steps and records when it was woken.
struct Repeats {
    steps: std::vec::IntoIter<Step>,
    dut: hoverlock_harness::sim::Dut,
    seen: Rc<RefCell<Vec<(Time, String)>>>,
}

impl Coroutine for Repeats {
    fn resume(&mut self, outcome: Outcome) -> Step {
        let what = match outcome {
            Outcome::Refused(why) => why.to_string(),
            other => format!("{other:?}"),
        };
        self.seen.borrow_mut().push((self.dut.now(), what));
        self.steps.next().unwrap_or(Step::Done)
    }
}

#[test]
fn a_coroutine_waits_again_for_its_last_edge() {
    let mut sim = sim(build("dff"));
    let dut = sim.dut();
    dut.clock("clk", Time::ns(10)).unwrap();
    let clk = dut.signal("clk").unwrap();
    let seen = Rc::new(RefCell::new(Vec::new()));
    let steps = vec![
        Step::Again,
        Step::Wait(clk.falling_edge().trigger()),
        Step::Again,
        Step::Wait(Trigger::Timer(Time::ns(1))),
        Step::Again,
        Step::Wait(clk.cycles(2).trigger()),
        Step::Again,
    ];
    let script = Repeats { steps: steps.into_iter(), dut: dut.clone(), seen: seen.clone() };
    sim.run_coroutine("script", Box::new(script)).unwrap();
    let seen = seen.take();
    let times: Vec<Time> = seen.iter().map(|(time, _)| *time).collect();
    assert_eq!(times, [0, 0, 5, 15, 16, 25, 40, 60].map(Time::ns));
    assert!(seen[1].1.contains("has waited for no edge before"), "{}", seen[1].1);
    assert!(seen[2..].iter().all(|(_, what)| what == "Fired"), "{seen:?}");
}

/// A coroutine that is a function.
struct Calls<F>(F);

impl<F: FnMut() -> Step> Coroutine for Calls<F> {
    fn resume(&mut self, _: Outcome) -> Step {
        (self.0)()
    }
}

#[test]
fn a_coroutine_that_waits_alone_reads_what_the_edge_order_says() {
    for (order, wanted) in [(EdgeOrder::BeforeEval, [0, 0, 1]), (EdgeOrder::AfterEval, [0, 1, 0])] {
        let mut sim = sim(build("dff"));
        sim.set_edge_order(order);
        let dut = sim.dut();
        dut.clock_with("clk", Time::ns(5), Time::ns(5), Time::ns(5)).unwrap();
        let (clk, d, q) = (dut.signal("clk").unwrap(), dut.signal("d").unwrap(), dut.signal("q").unwrap());
        let (seen, mut resumed) = (Rc::new(RefCell::new(Vec::new())), 0);
        let bench = {
            let seen = seen.clone();
            move || {
                seen.borrow_mut().push(q.get());
                d.set(1 - resumed % 2).unwrap();
                resumed += 1;
                if resumed == 3 { Step::Done } else { Step::Wait(clk.rising_edge().trigger()) }
            }
        };
        sim.run_coroutine("bench", Box::new(Calls(bench))).unwrap();
        assert_eq!(seen.take(), wanted, "{order:?}");
    }
}

#[test]
fn a_coroutine_of_another_language_gets_each_outcome() {
    let mut sim = sim(build("dff"));
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    let clk = dut.signal("clk").unwrap();
    let seen = Rc::new(RefCell::new(Vec::new()));
    let set = dut.event("set already");
    set.set();
    let nanosecond = dut.timer(Time::ns(1));
    let failing = dut.spawn("fails", async move {
        nanosecond.await;
        Err::<(), _>(hoverlock_harness::sim::Failure::new("on purpose"))
    });
    let waits = vec![
        Trigger::Join(failing.id()),
        clk.rising_edge().trigger(),
        Trigger::first([clk.falling_edge().trigger(), Trigger::Timer(Time::ns(100))]),
        Trigger::first([clk.cycles(50).trigger(), Trigger::Timer(Time::ns(3))]),
        Trigger::combine([Trigger::Timer(Time::ns(1)), Trigger::Timer(Time::ns(2))]),
        set.trigger(),
        Trigger::Yield,
        Trigger::Timer(Time::ZERO),
        Trigger::ReadOnly,
        Trigger::ReadWrite,
        Trigger::NextTimeStep,
    ];
    let script = Script { waits: waits.into_iter(), seen: seen.clone() };
    sim.run_coroutine("script", Box::new(script)).unwrap();
    let seen = seen.take();
    assert_eq!(seen[0], "Start");
    assert_eq!(seen[1], "Failed(Failure(\"on purpose\"))");
    assert_eq!(seen[2..8], ["Fired", "First(0, Fired)", "First(1, Fired)", "Fired", "Fired", "Fired"]);
    assert!(seen[8].starts_with("Refused") && seen[8].contains("Timer of 0"), "{}", seen[8]);
    assert_eq!(seen[9], "Fired");
    assert!(seen[10].starts_with("Refused") && seen[10].contains("ReadWrite awaited in ReadOnly"), "{}", seen[10]);
    assert_eq!(seen[11..], ["Fired"]);
    let endless = Script { waits: vec![Trigger::Timer(Time::s(1))].into_iter(), seen: Rc::default() };
    let list = endless.seen.clone();
    let id = dut.spawn_coroutine("endless", Box::new(endless));
    sim.run_for(PERIOD).unwrap();
    dut.cancel(id);
    assert_eq!(*list.borrow(), ["Start", "cancelled"]);
}

/// A coroutine that cancels itself and goes on to a wait.
struct CancelsItself(hoverlock_harness::sim::Dut, Rc<RefCell<Vec<&'static str>>>);

impl Coroutine for CancelsItself {
    fn resume(&mut self, _: Outcome) -> Step {
        self.1.borrow_mut().push("resumed");
        self.0.cancel(self.0.current_task().expect("a task runs"));
        Step::Wait(Trigger::Timer(Time::ns(1)))
    }

    fn cancel(&mut self) {
        self.1.borrow_mut().push("cancelled");
    }
}

#[test]
fn a_coroutine_that_cancels_itself_learns_of_it_at_its_next_wait() {
    let mut sim = sim(build("dff"));
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    let seen = Rc::new(RefCell::new(Vec::new()));
    dut.spawn_coroutine("itself", Box::new(CancelsItself(dut.clone(), seen.clone())));
    sim.run_for(PERIOD).unwrap();
    assert_eq!(*seen.borrow(), ["resumed", "cancelled"]);
}
