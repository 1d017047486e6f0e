//! The order of a time step, rule by rule: the races that make benches flaky, each with its known answer.

mod common;

use std::cell::RefCell;
use std::rc::Rc;

use common::{build, run, sim};
use hoverlock_harness::sim::{EdgeOrder, Region, Trigger};
use hoverlock_harness::{Error, ModelError, SimError, Time};

const PERIOD: Time = Time::ns(10);

#[test]
fn a_register_sampled_at_its_edge_shows_the_value_before_it() {
    let mut sim = sim(build("dff"));
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    let (clk, d, q) = (dut.signal("clk").unwrap(), dut.signal("d").unwrap(), dut.signal("q").unwrap());
    run(&mut sim, async {
        d.set(1)?;
        clk.rising_edge().await;
        assert_eq!(q.get(), 0, "still the old value at the edge");
        dut.read_only().await;
        assert_eq!(q.get(), 1, "the new one once settled");
        Ok(())
    });
}

#[test]
fn what_is_written_at_an_edge_is_sampled_by_the_next_one() {
    let mut sim = sim(build("dff"));
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    let (clk, d, q) = (dut.signal("clk").unwrap(), dut.signal("d").unwrap(), dut.signal("q").unwrap());
    run(&mut sim, async {
        clk.rising_edge().await;
        d.set(1)?;
        dut.read_only().await;
        assert_eq!((d.get(), q.get()), (1, 0), "put after this edge");
        clk.rising_edge().await;
        dut.read_only().await;
        assert_eq!(q.get(), 1);
        Ok(())
    });
}

#[test]
fn the_other_edge_order_shows_the_value_after_the_edge() {
    let mut sim = sim(build("dff"));
    sim.set_edge_order(EdgeOrder::AfterEval);
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    let (clk, d, q) = (dut.signal("clk").unwrap(), dut.signal("d").unwrap(), dut.signal("q").unwrap());
    run(&mut sim, async {
        d.set(1)?;
        clk.rising_edge().await;
        assert_eq!(q.get(), 1);
        Ok(())
    });
}

#[test]
fn a_write_is_read_back_only_after_it_was_put_and_the_last_one_counts() {
    let mut sim = sim(build("dff"));
    let dut = sim.dut();
    let (d, not_d) = (dut.signal("d").unwrap(), dut.signal("not_d").unwrap());
    run(&mut sim, async {
        assert_eq!(not_d.get(), 1, "settled before the bench begins");
        d.set(1)?;
        d.set(0)?;
        d.set(1)?;
        assert_eq!((d.get(), not_d.get()), (0, 1), "buffered");
        dut.read_write().await;
        assert_eq!((d.get(), not_d.get()), (1, 0), "put and settled");
        d.set(0)?;
        dut.read_only().await;
        assert_eq!((d.get(), not_d.get()), (0, 1), "ReadWrite may write");
        Ok(())
    });
}

#[test]
fn a_pulse_within_one_round_is_no_edge() {
    let mut sim = sim(build("dff"));
    let dut = sim.dut();
    let d = dut.signal("d").unwrap();
    let seen = Rc::new(RefCell::new(0));
    let (count, watched) = (seen.clone(), d.clone());
    dut.spawn("watch", async move {
        loop {
            watched.value_change().await;
            *count.borrow_mut() += 1;
        }
        #[allow(unreachable_code)]
        Ok::<(), Error>(())
    });
    run(&mut sim, async {
        dut.timer(Time::ns(1)).await;
        d.set(1)?;
        d.set(0)?;
        dut.timer(Time::ns(1)).await;
        assert_eq!(*seen.borrow(), 0);
        d.set(1)?;
        dut.timer(Time::ns(1)).await;
        assert_eq!(*seen.borrow(), 1);
        Ok(())
    });
}

#[test]
fn a_write_in_read_only_is_an_error_that_names_signal_and_time() {
    let mut sim = sim(build("dff"));
    let dut = sim.dut();
    let d = dut.signal("d").unwrap();
    let result = sim.run(async {
        dut.timer(Time::ns(7)).await;
        dut.read_only().await;
        assert_eq!(dut.region(), Region::ReadOnly);
        d.set(1)?;
        Ok::<(), Error>(())
    });
    match result {
        Err(Error::Model(ModelError::WriteInReadOnly { signal, time })) => {
            assert_eq!((signal.as_str(), time), ("d", Time::ns(7)));
        }
        other => panic!("{other:?}"),
    }
    // The next step takes writes again.
    run(&mut sim, async {
        dut.timer(Time::ns(1)).await;
        d.set(1)?;
        Ok(())
    });
    assert_eq!(d.get(), 1);
}

#[test]
fn read_only_and_read_write_are_refused_where_they_cannot_come() {
    for (again, name) in [(Trigger::ReadOnly, "ReadOnly"), (Trigger::ReadWrite, "ReadWrite")] {
        let mut sim = sim(build("dff"));
        let dut = sim.dut();
        let result = sim.run(async {
            dut.timer(Time::ns(1)).await;
            dut.read_only().await;
            dut.wait(again.clone()).await;
            Ok::<(), Error>(())
        });
        let text = result.unwrap_err().to_string();
        assert!(text.contains(&format!("{name} awaited in ReadOnly at 1 ns")), "{text}");
    }
}

#[test]
fn next_time_step_is_the_beginning_of_the_next_one() {
    let mut sim = sim(build("dff"));
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    let clk = dut.signal("clk").unwrap();
    run(&mut sim, async {
        clk.rising_edge().await;
        dut.read_only().await;
        dut.next_time_step().await;
        assert_eq!((dut.now(), dut.region()), (Time::ns(5), Region::Active));
        assert_eq!(clk.get(), 1, "the falling edge is not put yet");
        Ok(())
    });
}

#[test]
fn logic_settles_through_every_round_before_read_write() {
    let mut sim = sim(build("chain"));
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    let s = |name: &str| dut.signal(name).unwrap();
    let (clk, d, q1, q2, sum) = (s("clk"), s("d"), s("q1"), s("q2"), s("sum"));
    run(&mut sim, async {
        d.set(5)?;
        clk.rising_edge().await;
        clk.rising_edge().await;
        // Before the second edge: q1 holds 5, q2 holds what q1 held.
        assert_eq!((q1.get(), q2.get(), sum.get()), (5, 0, 10));
        d.set(7)?;
        dut.read_write().await;
        assert_eq!((q1.get(), q2.get(), sum.get()), (5, 5, 12));
        d.set(1)?;
        dut.read_write().await;
        assert_eq!((q1.get(), q2.get(), sum.get()), (5, 5, 6));
        Ok(())
    });
}

#[test]
fn an_edge_of_an_output_is_seen_after_the_evaluation_of_the_same_step() {
    let mut sim = sim(build("dff"));
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    let (clk, d, q) = (dut.signal("clk").unwrap(), dut.signal("d").unwrap(), dut.signal("q").unwrap());
    run(&mut sim, async {
        clk.falling_edge().await;
        d.set(1)?;
        q.rising_edge().await;
        assert_eq!((dut.now(), q.get()), (Time::ns(10), 1));
        d.set(0)?;
        q.falling_edge().await;
        assert_eq!(dut.now(), Time::ns(20));
        Ok(())
    });
}

#[test]
fn a_write_after_a_timer_in_a_clock_step_is_sampled_and_warned_of() {
    let mut sim = sim(build("dff"));
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    let (d, q) = (dut.signal("d").unwrap(), dut.signal("q").unwrap());
    run(&mut sim, async {
        dut.timer(Time::ns(10)).await;
        d.set(1)?;
        dut.read_only().await;
        assert_eq!(q.get(), 1, "put together with the clock");
        Ok(())
    });
    let log = sim.log();
    assert!(log.iter().any(|line| line.text.contains("'d' was written after a Timer")), "{log:?}");
}

#[test]
fn a_write_after_a_timer_between_edges_is_not_warned_of() {
    let mut sim = sim(build("dff"));
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    let d = dut.signal("d").unwrap();
    run(&mut sim, async {
        dut.timer(Time::ns(8)).await;
        d.set(1)?;
        dut.timer(Time::ns(8)).await;
        Ok(())
    });
    assert!(sim.log().is_empty());
}

#[test]
fn a_driver_and_a_monitor_never_race_however_they_are_ordered() {
    for driver_first in [true, false] {
        let mut sim = sim(build("chain"));
        let dut = sim.dut();
        dut.clock("clk", PERIOD).unwrap();
        let driver = || {
            let (clk, d) = (dut.signal("clk").unwrap(), dut.signal("d").unwrap());
            dut.spawn("driver", async move {
                for value in 1..100 {
                    clk.rising_edge().await;
                    d.set(value)?;
                }
                Ok::<(), Error>(())
            })
        };
        if driver_first {
            driver();
        }
        let seen = Rc::new(RefCell::new(Vec::new()));
        let (clk, q1, list) = (dut.signal("clk").unwrap(), dut.signal("q1").unwrap(), seen.clone());
        dut.spawn("monitor", async move {
            loop {
                clk.rising_edge().await;
                list.borrow_mut().push(q1.get());
            }
            #[allow(unreachable_code)]
            Ok::<(), Error>(())
        });
        if !driver_first {
            driver();
        }
        sim.run_for(PERIOD * 50).unwrap();
        // Edge 0 puts 1, edge 1 samples it, edge 2 sees it: after two zeros the count.
        let expected: Vec<u64> = [0, 0].into_iter().chain(1..).take(seen.borrow().len()).collect();
        assert_eq!(*seen.borrow(), expected);
        assert!(expected.len() >= 50);
    }
}

#[test]
fn tasks_run_in_the_order_in_which_they_began_to_wait() {
    let order = || {
        let mut sim = sim(build("dff"));
        let dut = sim.dut();
        dut.clock("clk", PERIOD).unwrap();
        let list = Rc::new(RefCell::new(Vec::new()));
        for number in 0..20 {
            let (clk, list, dut) = (dut.signal("clk").unwrap(), list.clone(), dut.clone());
            let task = dut.clone().spawn("one of many", async move {
                for round in 0..3 {
                    if number % 3 == round {
                        dut.yield_now().await;
                    }
                    clk.rising_edge().await;
                    list.borrow_mut().push(number);
                }
                Ok::<(), Error>(())
            });
            drop(task);
        }
        sim.run_for(PERIOD * 5).unwrap();
        list.take()
    };
    let first = order();
    assert_eq!(first.len(), 60);
    // In the first round those that yielded wait last, each group in its own order.
    let yielded: Vec<u32> = (0..20).filter(|n| n % 3 == 0).collect();
    let others: Vec<u32> = (0..20).filter(|n| n % 3 != 0).collect();
    assert_eq!(first[..20], [others, yielded].concat());
    assert_eq!(first, order(), "the same in every run");
}

#[test]
fn tasks_that_answer_each_other_for_ever_are_stopped() {
    let mut sim = sim(build("dff"));
    let dut = sim.dut();
    let (d, not_d) = (dut.signal("d").unwrap(), dut.signal("not_d").unwrap());
    let result = sim.run(async {
        loop {
            d.set(not_d.get())?;
            not_d.value_change().await;
        }
        #[allow(unreachable_code)]
        Ok::<(), Error>(())
    });
    assert!(matches!(result, Err(Error::Sim(SimError::NoProgress { rounds: 10_001, .. }))), "{result:?}");
}

// Between edges of the only clock the scheduler looks for nothing else, until something else begins.

#[test]
fn large_writes_at_an_edge_of_the_only_clock_are_put_in_that_step() {
    let mut sim = sim(build("wide").internal("memory"));
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    let clk = dut.signal("clk").unwrap();
    let (b, swapped, memory) = (dut.wide("b").unwrap(), dut.wide("b_swapped").unwrap(), dut.memory("memory").unwrap());
    run(&mut sim, async {
        for round in 1..4 {
            clk.rising_edge().await;
            b.set(&[round])?;
            clk.falling_edge().await;
            assert_eq!(swapped.get()[8], round);
            memory.set(3, u64::from(round))?;
            clk.rising_edge().await;
            memory.set_words(5, &[round])?;
            clk.falling_edge().await;
            assert_eq!((memory.get(4)?, memory.get(5)?), (u64::from(round) + 1, u64::from(round)));
        }
        Ok(())
    });
}

#[test]
fn a_write_after_an_edge_counts_though_the_design_changes_the_signal_at_the_edge() {
    let mut sim = sim(build("counter"));
    sim.deposit_on_outputs(true);
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    let (clk, count) = (dut.signal("clk").unwrap(), dut.signal("count").unwrap());
    let wide = dut.wide("count").unwrap();
    run(&mut sim, async {
        dut.signal("enable")?.set(1)?;
        dut.signal("step")?.set(1)?;
        for _ in 0..6 {
            clk.rising_edge().await;
            count.set(5)?;
            dut.read_only().await;
            assert_eq!(count.get(), 5, "written after the evaluation of the edge, which made it 6");
        }
        clk.rising_edge().await;
        count.set_bits(0x80, 0x80)?;
        count.set_bits(0x40, 0)?;
        dut.read_only().await;
        assert_eq!(count.get(), 0x86, "the other bits have what the edge made them");
        clk.rising_edge().await;
        wide.set_bits(&[0xc0], &[0x40])?;
        dut.read_only().await;
        assert_eq!(wide.get(), [0x47]);
        clk.rising_edge().await;
        count.set_bits(0x01, 0x01)?;
        count.set(9)?;
        count.set_bits(0x06, 0x06)?;
        dut.read_only().await;
        assert_eq!(count.get(), 15, "the last write of each bit counts");
        Ok(())
    });
    let outside = count.set_bits(1, 3).unwrap_err();
    assert!(matches!(outside, ModelError::OutsideOfMask { .. }), "{outside}");
    assert!(matches!(wide.set_bits(&[1], &[3]), Err(ModelError::OutsideOfMask { .. })));
    assert!(matches!(count.set_bits(0x100, 0), Err(ModelError::OutOfRange { .. })));
}
