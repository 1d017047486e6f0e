//! How a bench steers streams: pauses, gaps, missing marks, resets in the middle, random idle values, watched edges.

mod common;

use std::cell::RefCell;
use std::rc::Rc;

use common::{build, run, sim};
use hoverlock_harness::bus::stream::{Dialect, Frame, Monitor, Ports, Rules, Sink, Source};
use hoverlock_harness::bus::{Pause, Reset, Switch};
use hoverlock_harness::sim::{Dut, Edge, Signal, Sim};
use hoverlock_harness::{Error, Time};

const AVALON: Dialect = Dialect::Avalon { ready_latency: 0 };

/// A FIFO of 16 beats of four bytes, out of reset, with its clock.
fn fifo() -> (Sim, Dut, Signal) {
    let sim = sim(build("avalon_fifo"));
    let dut = sim.dut();
    dut.clock("clk", Time::ns(10)).unwrap();
    let (clk, rst) = (dut.signal("clk").unwrap(), dut.signal("rst").unwrap());
    rst.set(1).unwrap();
    let clock = clk.clone();
    dut.spawn("reset", async move {
        clock.cycles(2).await;
        rst.set(0)?;
        Ok::<(), Error>(())
    });
    (sim, dut, clk)
}

fn ports(dut: &Dut, prefix: &str) -> Ports {
    Ports::find(dut, prefix, AVALON).unwrap().symbols_of(32).unwrap()
}

/// Samples taken at every rising edge.
type Samples<T> = Rc<RefCell<Vec<T>>>;

/// Records what `read` returns at every rising edge.
fn record<T: 'static>(dut: &Dut, clk: &Signal, read: impl Fn() -> T + 'static) -> Samples<T> {
    let samples = Samples::default();
    let list = samples.clone();
    dut.on_edge(clk, Edge::Rising, move || {
        list.borrow_mut().push(read());
        Ok::<(), Error>(())
    });
    samples
}

#[test]
fn a_sink_that_always_pauses_takes_nothing_until_it_opens() {
    let (mut sim, dut, clk) = fifo();
    let source = Source::new(&dut, &clk, ports(&dut, "in_"), None).unwrap();
    let sink = Sink::new(&dut, &clk, ports(&dut, "out_"), None, Rules::Strict).unwrap();
    sink.set_pause(Pause::Always);
    run(&mut sim, async {
        clk.cycles(3).await;
        source.send(&Frame::new(&[0u32; 40]))?;
        clk.cycles(100).await;
        assert_eq!((sink.beats(), source.pending()), (0, 25), "the FIFO has taken 15 beats");
        sink.set_pause(Pause::Never);
        assert_eq!(sink.recv().await.symbols.len(), 40);
        Ok(())
    });
}

#[test]
fn a_switch_holds_source_and_sink_from_the_next_edge_on() {
    let (mut sim, dut, clk) = fifo();
    let source = Source::new(&dut, &clk, ports(&dut, "in_"), None).unwrap();
    let sink = Sink::new(&dut, &clk, ports(&dut, "out_"), None, Rules::Strict).unwrap();
    let hold = Switch::default();
    source.set_pause(Pause::while_on(&hold));
    sink.set_pause(Pause::while_on(&hold));
    let ready = dut.signal("out_ready").unwrap();
    run(&mut sim, async {
        clk.cycles(5).await;
        assert!(ready.is_high());
        hold.set(true);
        clk.cycles(2).await;
        assert!(!ready.is_high());
        source.send(&Frame::new(&[1u32, 2, 3]))?;
        clk.cycles(20).await;
        assert_eq!((source.sent(), source.pending()), (0, 3));
        hold.set(false);
        assert_eq!(sink.recv().await.symbols, [1, 2, 3]);
        Ok(())
    });
}

#[test]
fn gaps_are_cycles_without_a_beat_before_a_frame() {
    let (mut sim, dut, clk) = fifo();
    let source = Source::new(&dut, &clk, ports(&dut, "in_"), None).unwrap();
    let valid = dut.signal("in_valid").unwrap();
    run(&mut sim, async {
        clk.cycles(3).await;
        let samples = record(&dut, &clk, move || valid.get());
        source.send(&Frame::new(&[1u32, 2]))?;
        source.send(&Frame::new(&[3u32, 4]).after_gap(3))?;
        source.send(&Frame::new(&[5u32]).after_gap(1))?;
        source.drained().await;
        let samples = samples.borrow();
        let begin = samples.iter().position(|valid| *valid == 1).unwrap();
        assert_eq!(samples[begin..], [1, 1, 0, 0, 0, 1, 1, 0, 1]);
        Ok(())
    });
}

#[test]
fn marks_may_be_missing_so_that_packets_are_broken_on_purpose() {
    let (mut sim, dut, clk) = fifo();
    let source = Source::new(&dut, &clk, ports(&dut, "in_"), None).unwrap();
    let sink = Sink::new(&dut, &clk, ports(&dut, "out_"), None, Rules::Recorded).unwrap();
    run(&mut sim, async {
        clk.cycles(3).await;
        // A packet in three pieces keeps the rules.
        source.send(&Frame::new(&[1u32, 2]).without_end())?;
        source.send(&Frame::new(&[3u32]).without_start().without_end())?;
        source.send(&Frame::new(&[4u32]).without_start())?;
        assert_eq!(sink.recv().await.symbols, [1, 2, 3, 4]);
        assert_eq!(sink.violations(), []);
        source.send(&Frame::new(&[5u32]).without_start())?;
        source.send(&Frame::new(&[6u32]).without_end())?;
        source.send(&Frame::new(&[7u32]))?;
        source.drained().await;
        clk.cycles(5).await;
        let rules: Vec<String> = sink.violations().into_iter().map(|violation| violation.rule).collect();
        assert_eq!(rules, ["a beat outside of a packet: no startofpacket", "startofpacket inside a packet"]);
        Ok(())
    });
}

#[test]
fn a_reset_in_the_middle_leaves_nothing_behind() {
    let (mut sim, dut, clk) = fifo();
    let rst = dut.signal("rst").unwrap();
    // The bench resets its own side through a switch, as for a design that is reset through a register.
    let resetting = Switch::default();
    let reset = Some(Reset::while_on(&resetting));
    let source = Source::new(&dut, &clk, ports(&dut, "in_"), reset.clone()).unwrap();
    let sink = Sink::new(&dut, &clk, ports(&dut, "out_"), reset, Rules::Strict).unwrap();
    let monitor = Monitor::new(&dut, &clk, ports(&dut, "out_"), None, Rules::Recorded).unwrap();
    sink.set_pause(Pause::random(0.5, 7));
    run(&mut sim, async {
        clk.cycles(3).await;
        for beats in 1..30 {
            let frame: Vec<u32> = (0..40).collect();
            source.send(&Frame::new(&frame))?;
            clk.cycles(beats).await;
            resetting.set(true);
            rst.set(1)?;
            source.clear();
            clk.cycles(2).await;
            rst.set(0)?;
            resetting.set(false);
            sink.clear();
            monitor.clear();
            assert_eq!(source.pending(), 0);
            source.drained().await;
            source.send(&Frame::new(&[100 + beats, 200]))?;
            assert_eq!(sink.recv().await.symbols, [100 + beats, 200], "after {beats} cycles");
            assert_eq!(monitor.recv().await.symbols, [100 + beats, 200]);
            assert!(sink.is_empty() && monitor.is_empty());
        }
        Ok(())
    });
}

#[test]
fn idle_values_are_random_and_are_not_taken() {
    let (mut sim, dut, clk) = fifo();
    let source = Source::new(&dut, &clk, ports(&dut, "in_"), None).unwrap();
    let sink = Sink::new(&dut, &clk, ports(&dut, "out_"), None, Rules::Strict).unwrap();
    source.randomize_idle(3);
    source.set_pause(Pause::random(0.6, 4));
    let (valid, data, last) =
        (dut.signal("in_valid").unwrap(), dut.signal("in_data").unwrap(), dut.signal("in_endofpacket").unwrap());
    let samples = record(&dut, &clk, move || (valid.get(), data.get(), last.get()));
    run(&mut sim, async {
        clk.cycles(3).await;
        for number in 0..20u64 {
            source.send(&Frame::new(&[number, number + 1, number + 2]))?;
            assert_eq!(sink.recv().await.symbols, [number, number + 1, number + 2]);
        }
        Ok(())
    });
    let idle: Vec<(u64, u64)> = samples.borrow().iter().filter(|s| s.0 == 0).map(|s| (s.1, s.2)).collect();
    assert!(idle.windows(2).filter(|pair| pair[0].0 != pair[1].0).count() > idle.len() / 2);
    assert!(idle.iter().any(|(_, last)| *last == 1) && idle.iter().any(|(_, last)| *last == 0));
}

#[test]
fn a_condition_is_waited_for_by_cycles_and_not_for_ever() {
    let mut sim = sim(build("counter").parameter("WIDTH", 8));
    let dut = sim.dut();
    dut.clock("clk", Time::ns(10)).unwrap();
    let (clk, count) = (dut.signal("clk").unwrap(), dut.signal("count").unwrap());
    let end = sim.run(async {
        dut.signal("enable")?.set(1)?;
        dut.signal("step")?.set(2)?;
        let cycles = clk.cycles_until(100, || count.get() == 10).await?;
        assert_eq!((cycles, count.get()), (6, 10), "five edges count, and the sixth shows it");
        assert_eq!(clk.cycles_until(1, || true).await?, 1);
        clk.cycles_until(20, || count.get() % 2 == 1).await?;
        Ok::<(), Error>(())
    });
    let text = end.unwrap_err().to_string();
    assert_eq!(text, "a condition did not hold within 20 cycles of 'clk', until 260 ns");
}

#[test]
fn a_watched_edge_comes_before_the_tasks_and_its_error_ends_the_run() {
    let mut sim = sim(build("counter").parameter("WIDTH", 8));
    let dut = sim.dut();
    dut.clock("clk", Time::ns(10)).unwrap();
    let (clk, count, step) = (dut.signal("clk").unwrap(), dut.signal("count").unwrap(), dut.signal("step").unwrap());
    dut.signal("enable").unwrap().set(1).unwrap();
    let watched = count.clone();
    dut.on_edge(&clk, Edge::Rising, move || {
        step.set(9)?;
        if watched.get() < 12 { Ok(()) } else { Err(Error::bench("it counts too far")) }
    });
    let end = sim.run(async {
        loop {
            clk.rising_edge().await;
            // Of two writes at one edge the later one counts, and tasks come after the function.
            dut.signal("step")?.set(3)?;
            assert!(count.get().is_multiple_of(3));
        }
        #[allow(unreachable_code, reason = "names the type of the error")]
        Ok::<(), Error>(())
    });
    assert_eq!(end.unwrap_err().to_string(), "it counts too far");
}

#[test]
fn deferred_writes_give_the_same_values_with_fewer_evaluations() {
    let play = |defer: bool| {
        let (mut sim, dut, clk) = fifo();
        sim.defer_writes(defer);
        let source = Source::new(&dut, &clk, ports(&dut, "in_"), None).unwrap();
        let sink = Sink::new(&dut, &clk, ports(&dut, "out_"), None, Rules::Strict).unwrap();
        source.set_pause(Pause::random(0.3, 1));
        sink.set_pause(Pause::random(0.4, 2));
        let (valid, data) = (dut.signal("out_valid").unwrap(), dut.signal("out_data").unwrap());
        let samples = record(&dut, &clk, move || (valid.get(), data.get()));
        run(&mut sim, async {
            source.send(&Frame::new(&(0..200u32).collect::<Vec<_>>()))?;
            assert_eq!(sink.recv().await.symbols, (0..200).collect::<Vec<u64>>());
            Ok(())
        });
        let samples = samples.borrow().clone();
        (samples, sim.evaluations())
    };
    let ((put_at_once, evaluations), (deferred, fewer)) = (play(false), play(true));
    assert_eq!(put_at_once, deferred);
    assert!(5 * fewer < 4 * evaluations, "{fewer} evaluations, {evaluations} without");
}
