//! Every trigger, tasks and what they share, and how a run ends when it does not end well.

mod common;

use std::cell::RefCell;
use std::rc::Rc;
use std::time::{Duration, Instant};

use common::{build, run, sim};
use hoverlock_harness::sim::{Either, Failure, Level, Limits, Signal, Sim, Trigger, Wait, both, expect_equal, race};
use hoverlock_harness::{Error, ModelError, SimError, Time};

const PERIOD: Time = Time::ns(10);

fn clocked(top: &str) -> Sim {
    let sim = sim(build(top));
    sim.dut().clock("clk", PERIOD).unwrap();
    sim
}

async fn ending(wait: Wait) -> Result<(), Error> {
    wait.await;
    Ok(())
}

/// Waits for an edge that does not come.
fn never(signal: &Signal) -> impl Future<Output = Result<(), Error>> {
    ending(signal.rising_edge())
}

#[test]
fn edges_and_cycles_come_at_their_times() {
    let mut sim = clocked("dff");
    let dut = sim.dut();
    let clk = dut.signal("clk").unwrap();
    run(&mut sim, async {
        clk.rising_edge().await;
        assert_eq!(dut.now(), Time::ZERO);
        clk.falling_edge().await;
        assert_eq!(dut.now(), Time::ns(5));
        clk.value_change().await;
        assert_eq!(dut.now(), Time::ns(10));
        clk.cycles(7).await;
        assert_eq!(dut.now(), Time::ns(80));
        dut.timer(Time::fs(1)).await;
        assert_eq!(dut.now(), Time::fs(80_000_001));
        Ok(())
    });
}

#[test]
fn a_trigger_is_used_again_and_again() {
    let mut sim = clocked("dff");
    let dut = sim.dut();
    let rising = dut.signal("clk").unwrap().rising_edge();
    run(&mut sim, async {
        for at in 0..5 {
            rising.clone().await;
            assert_eq!(dut.now(), PERIOD * at);
        }
        Ok(())
    });
}

#[test]
fn zero_cycles_and_a_timer_of_zero_fail_the_bench() {
    for zero in ["timer", "cycles"] {
        let mut sim = clocked("dff");
        let dut = sim.dut();
        let clk = dut.signal("clk").unwrap();
        let wait = if zero == "timer" { dut.timer(Time::ZERO) } else { clk.cycles(0) };
        let text = sim.run(ending(wait)).unwrap_err().to_string();
        assert!(text.contains("of 0"), "{text}");
    }
}

#[test]
fn first_gives_the_index_and_gives_up_the_others() {
    let mut sim = clocked("dff");
    let dut = sim.dut();
    let clk = dut.signal("clk").unwrap();
    run(&mut sim, async {
        clk.rising_edge().await;
        assert_eq!(dut.first([clk.rising_edge(), clk.falling_edge(), dut.timer(Time::ns(50))]).await, 1);
        assert_eq!(dut.first([clk.falling_edge(), dut.timer(Time::ns(2))]).await, 1);
        assert_eq!(dut.now(), Time::ns(7));
        // Of two at the same time the one that began to wait first.
        assert_eq!(dut.first([dut.timer(Time::ns(1)), dut.timer(Time::ns(1))]).await, 0);
        // Many losers leave nothing behind that would slow the signal down.
        for _ in 0..10_000 {
            dut.first([dut.signal("q")?.value_change(), clk.falling_edge()]).await;
        }
        Ok(())
    });
}

#[test]
fn combine_waits_for_all() {
    let mut sim = clocked("dff");
    let dut = sim.dut();
    let clk = dut.signal("clk").unwrap();
    run(&mut sim, async {
        dut.combine([dut.timer(Time::ns(3)), clk.cycles(2), dut.timer(Time::ns(1))]).await;
        assert_eq!(dut.now(), Time::ns(10));
        Ok(())
    });
}

#[test]
fn futures_race_and_join() {
    let mut sim = clocked("dff");
    let dut = sim.dut();
    run(&mut sim, async {
        let slow = async {
            dut.timer(Time::ns(9)).await;
            "slow"
        };
        let quick = async {
            dut.timer(Time::ns(2)).await;
            "quick"
        };
        assert_eq!(race(slow, quick).await, Either::Right("quick"));
        assert_eq!(dut.now(), Time::ns(2));
        both(dut.timer(Time::ns(4)), dut.timer(Time::ns(6))).await;
        assert_eq!(dut.now(), Time::ns(8));
        Ok(())
    });
}

#[test]
fn with_timeout_gives_the_value_or_the_error() {
    let mut sim = clocked("dff");
    let dut = sim.dut();
    let q = dut.signal("q").unwrap();
    run(&mut sim, async {
        dut.with_timeout(Time::ns(100), dut.timer(Time::ns(99))).await?;
        match dut.with_timeout(Time::us(1), q.rising_edge()).await {
            Err(SimError::Timeout { limit, time }) => assert_eq!((limit, time), (Time::us(1), Time::ns(1099))),
            other => panic!("{other:?}"),
        }
        Ok(())
    });
}

#[test]
fn an_event_wakes_all_that_wait_and_stays_set() {
    let mut sim = clocked("dff");
    let dut = sim.dut();
    let event = dut.event("go");
    let woken = Rc::new(RefCell::new(0));
    for _ in 0..3 {
        let (event, woken) = (event.clone(), woken.clone());
        dut.spawn("waiter", async move {
            event.wait().await;
            *woken.borrow_mut() += 1;
            Ok::<(), Error>(())
        });
    }
    run(&mut sim, async {
        dut.timer(Time::ns(1)).await;
        assert_eq!(*woken.borrow(), 0);
        event.set();
        event.wait().await;
        dut.yield_now().await;
        assert_eq!(*woken.borrow(), 3);
        event.clear();
        assert!(!event.is_set());
        Ok(())
    });
}

#[test]
fn a_lock_is_given_in_order_and_a_cancelled_waiter_is_passed_over() {
    let mut sim = clocked("dff");
    let dut = sim.dut();
    let lock = dut.lock("bus");
    let list = Rc::new(RefCell::new(Vec::new()));
    let mut tasks = Vec::new();
    for number in 0..4 {
        let (lock, list, dut) = (lock.clone(), list.clone(), dut.clone());
        tasks.push(dut.clone().spawn("user", async move {
            let _held = lock.lock().await;
            dut.timer(Time::ns(2)).await;
            list.borrow_mut().push((number, dut.now()));
            Ok::<(), Error>(())
        }));
    }
    run(&mut sim, async {
        dut.timer(Time::ns(1)).await;
        tasks[1].cancel();
        dut.timer(Time::ns(20)).await;
        assert_eq!(*list.borrow(), [(0, Time::ns(2)), (2, Time::ns(4)), (3, Time::ns(6))]);
        assert!(!lock.is_locked());
        Ok(())
    });
}

#[test]
fn a_lock_handed_to_a_task_that_is_cancelled_before_it_runs_goes_on() {
    let mut sim = clocked("dff");
    let dut = sim.dut();
    let lock = dut.lock("bus");
    run(&mut sim, async {
        let held = lock.lock().await;
        let waiter = lock.clone();
        let task = dut.spawn("unlucky", async move {
            waiter.lock().await;
            Ok::<(), Error>(())
        });
        dut.timer(Time::ns(1)).await;
        drop(held);
        // It has the lock now but did not run yet.
        task.cancel();
        let _again = dut.with_timeout(Time::ns(1), lock.lock()).await?;
        Ok(())
    });
}

#[test]
fn a_queue_blocks_when_full_and_when_empty_and_keeps_order() {
    let mut sim = clocked("dff");
    let dut = sim.dut();
    let queue = dut.queue::<u32>("numbers", 2);
    let (put, timed) = (queue.clone(), dut.clone());
    dut.spawn("producer", async move {
        for number in 0..10 {
            put.put(number).await;
            assert!(put.len() <= 2);
        }
        timed.timer(Time::ns(30)).await;
        put.put(10).await;
        Ok::<(), Error>(())
    });
    run(&mut sim, async {
        dut.timer(Time::ns(1)).await;
        assert_eq!(queue.len(), 2, "the producer waits");
        assert_eq!(queue.try_put(99), Err(99));
        for expected in 0..=10 {
            assert_eq!(queue.get().await, expected);
        }
        assert_eq!(dut.now(), Time::ns(31));
        assert!(queue.is_empty() && queue.try_get().is_none());
        Ok(())
    });
}

#[test]
fn a_task_gives_its_value_and_start_runs_it_at_once() {
    let mut sim = clocked("dff");
    let dut = sim.dut();
    let ran = Rc::new(RefCell::new(false));
    run(&mut sim, async {
        let (timed, flag) = (dut.clone(), ran.clone());
        let later = dut.spawn("later", async move {
            *flag.borrow_mut() = true;
            timed.timer(Time::ns(5)).await;
            Ok::<_, Error>(42)
        });
        assert!(!*ran.borrow(), "spawn does not run it yet");
        dut.yield_now().await;
        assert!(*ran.borrow());
        assert_eq!(later.await?, 42);
        assert_eq!(dut.now(), Time::ns(5));
        let (flag, timed) = (ran.clone(), dut.clone());
        *ran.borrow_mut() = false;
        let at_once = dut
            .start("at once", async move {
                *flag.borrow_mut() = true;
                timed.timer(Time::ns(5)).await;
                Ok::<(), Error>(())
            })
            .await;
        assert!(*ran.borrow() && !at_once.is_done());
        // A task that ended long ago is joined at once.
        at_once.ended().await;
        at_once.await?;
        Ok(())
    });
}

#[test]
fn a_failing_task_fails_the_tasks_that_wait_for_it_or_else_the_run() {
    let mut sim = clocked("dff");
    let dut = sim.dut();
    run(&mut sim, async {
        let timed = dut.clone();
        let task = dut.spawn("bad", async move {
            timed.timer(Time::ns(3)).await;
            Err::<(), _>(Failure::with_payload("it broke", 17u8))
        });
        match task.await {
            Err(SimError::TaskFailed { task, time, failure }) => {
                assert_eq!((task.as_str(), time, failure.message()), ("bad", Time::ns(3), "it broke"));
                assert_eq!(failure.payload::<u8>(), Some(&17));
            }
            other => panic!("{other:?}"),
        }
        Ok(())
    });
    let timed = dut.clone();
    dut.spawn("alone", async move {
        timed.timer(Time::ns(3)).await;
        expect_equal("the answer", 41, 42)
    });
    let error = sim.run_for(Time::ns(10)).unwrap_err();
    assert_eq!(error.to_string(), "task 'alone' failed at 6 ns: the answer is 41, expected 42");
}

#[test]
fn a_cancelled_task_stops_and_says_so_and_may_cancel_itself() {
    let mut sim = clocked("dff");
    let dut = sim.dut();
    struct Dropped(Rc<RefCell<bool>>);
    impl Drop for Dropped {
        fn drop(&mut self) {
            *self.0.borrow_mut() = true;
        }
    }
    run(&mut sim, async {
        let flag = Rc::new(RefCell::new(false));
        let (timed, guard) = (dut.clone(), Dropped(flag.clone()));
        let task = dut.spawn("victim", async move {
            let _guard = guard;
            timed.timer(Time::s(1)).await;
            Ok::<(), Error>(())
        });
        dut.timer(Time::ns(1)).await;
        task.cancel();
        assert!(*flag.borrow(), "its values are dropped at once");
        assert!(matches!(task.await, Err(SimError::Cancelled { .. })));
        let own = dut.clone();
        let suicidal = dut.spawn("itself", async move {
            own.cancel(own.current_task().expect("a task runs"));
            own.timer(Time::ns(1)).await;
            Ok::<(), Error>(())
        });
        assert!(matches!(suicidal.await, Err(SimError::Cancelled { .. })));
        Ok(())
    });
}

#[test]
fn the_slots_of_ended_tasks_are_reused() {
    let mut sim = clocked("dff");
    let dut = sim.dut();
    run(&mut sim, async {
        let kept = dut.spawn("kept", async { Ok::<_, Error>(7) });
        let mut slots = std::collections::HashSet::new();
        for _ in 0..1000 {
            let timed = dut.clone();
            let short = dut.spawn("short", async move {
                timed.timer(Time::ps(1)).await;
                Ok::<(), Error>(())
            });
            slots.insert(format!("{:?}", short.id()).split(',').next().map(str::to_owned));
            drop(short);
            dut.timer(Time::ps(2)).await;
        }
        assert!(slots.len() <= 2, "{slots:?}");
        assert_eq!(kept.await?, 7, "a task that is held on to keeps its value");
        Ok(())
    });
}

#[test]
fn foreign_combinators_with_their_own_wakers_work() {
    // A waker that is not the task's own, as `FuturesUnordered` has: it must be called.
    struct Flag(std::sync::atomic::AtomicBool, std::task::Waker);
    impl std::task::Wake for Flag {
        fn wake(self: std::sync::Arc<Self>) {
            self.0.store(true, std::sync::atomic::Ordering::SeqCst);
            self.1.wake_by_ref();
        }
    }
    let mut sim = clocked("dff");
    let dut = sim.dut();
    run(&mut sim, async {
        let mut timer = dut.timer(Time::ns(3));
        let mut flag = None;
        std::future::poll_fn(|context| {
            let flag = flag.get_or_insert_with(|| {
                std::sync::Arc::new(Flag(std::sync::atomic::AtomicBool::new(true), context.waker().clone()))
            });
            if !flag.0.swap(false, std::sync::atomic::Ordering::SeqCst) {
                return std::task::Poll::Pending;
            }
            let waker = std::task::Waker::from(flag.clone());
            std::pin::Pin::new(&mut timer).poll(&mut std::task::Context::from_waker(&waker))
        })
        .await;
        assert_eq!(dut.now(), Time::ns(3));
        Ok(())
    });
}

#[test]
fn tasks_live_on_from_run_to_run() {
    let mut sim = clocked("dff");
    let dut = sim.dut();
    let (clk, d) = (dut.signal("clk").unwrap(), dut.signal("d").unwrap());
    dut.spawn("toggle", async move {
        loop {
            clk.rising_edge().await;
            d.set(1 - d.get())?;
        }
        #[allow(unreachable_code)]
        Ok::<(), Error>(())
    });
    let d = dut.signal("d").unwrap();
    let mut seen = Vec::new();
    for _ in 0..4 {
        sim.run_for(PERIOD).unwrap();
        seen.push(d.get());
    }
    assert_eq!(seen, [0, 1, 0, 1]);
    sim.cancel_all();
    sim.run_for(PERIOD).unwrap();
    assert_eq!(d.get(), 1);
}

// ---- ends that are not good

#[test]
fn a_forgotten_clock_is_explained_with_what_each_task_waits_for() {
    let mut sim = sim(build("dff"));
    let dut = sim.dut();
    let (clk, q, event) = (dut.signal("clk").unwrap(), dut.signal("q").unwrap(), dut.event("done"));
    let lock = dut.lock("bus");
    let held = lock.clone();
    dut.spawn("holder", async move {
        let _held = held.lock().await;
        event.wait().await;
        Ok::<(), Error>(())
    });
    dut.spawn("asker", async move {
        lock.lock().await;
        Ok::<(), Error>(())
    });
    let text = sim
        .run(async {
            dut.first([clk.rising_edge(), q.value_change()]).await;
            Ok::<(), Error>(())
        })
        .unwrap_err()
        .to_string();
    for part in [
        "no event can come any more at 0 ns",
        "'bench' waits for First(RisingEdge(clk), which is 0x0, ValueChange(q), which is 0x0)",
        "'holder' waits for Event(done)",
        "'asker' waits for Lock(bus)",
        "no clock runs: was one forgotten?",
    ] {
        assert!(text.contains(part), "{part} is not in:\n{text}");
    }
}

#[test]
fn limits_of_simulation_time_and_of_the_wall_clock_end_a_run() {
    let mut sim = clocked("dff");
    let dut = sim.dut();
    let q = dut.signal("q").unwrap();
    sim.set_limits(Limits { time: Some(Time::us(1)), ..Limits::default() });
    let error = sim.run(never(&q)).unwrap_err();
    assert!(matches!(error, Error::Sim(SimError::TimeLimit { limit, .. }) if limit == Time::us(1)), "{error}");
    sim.set_limits(Limits { wall_clock: Some(Duration::from_millis(50)), ..Limits::default() });
    let start = Instant::now();
    let error = sim.run(never(&q)).unwrap_err();
    assert!(error.to_string().contains("wall-clock limit of 0.05 s"), "{error}");
    assert!(error.to_string().contains("'bench' waits for RisingEdge(q), which is 0x0"), "{error}");
    assert!(start.elapsed() < Duration::from_secs(5));
}

#[test]
fn a_run_is_interrupted_from_outside() {
    let mut sim = clocked("dff");
    let q = sim.dut().signal("q").unwrap();
    let flag = sim.stop_flag();
    let stopper = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(30));
        flag.stop();
    });
    let error = sim.run(never(&q)).unwrap_err();
    stopper.join().unwrap();
    assert!(matches!(error, Error::Sim(SimError::Interrupted { .. })), "{error}");
    sim.set_interrupt(|| true);
    let error = sim.run(never(&q)).unwrap_err();
    assert!(matches!(error, Error::Sim(SimError::Interrupted { .. })), "{error}");
}

#[test]
fn what_the_verilog_says_is_in_log_and_result() {
    let say = |command: u64| {
        let mut sim = clocked("talks");
        let dut = sim.dut();
        let (clk, line) = (dut.signal("clk").unwrap(), dut.signal("command").unwrap());
        let result = sim.run(async {
            dut.timer(Time::ns(12)).await;
            line.set(command)?;
            clk.rising_edge().await;
            line.set(0)?;
            clk.cycles(3).await;
            Ok::<(), Error>(())
        });
        (result.map_err(|e| e.to_string()), sim)
    };
    let (result, quiet) = say(1);
    assert_eq!(result, Ok(()));
    let log = quiet.log();
    assert_eq!((log[0].text.as_str(), log[0].time), ("hello at 20000", Time::ns(20)));
    let said = quiet.finish();
    assert!(format!("{said:?}").contains("the end"), "final blocks run: {said:?}");
    let (result, _) = say(2);
    let text = result.unwrap_err();
    assert!(text.starts_with("20 ns: ") && text.contains("something is off") && text.contains("talks.v:6"), "{text}");
    let (result, _) = say(3);
    assert!(result.unwrap_err().contains("called $finish at 20 ns"));
    assert!(say(4).0.unwrap_err().contains("beyond repair"));
    assert!(say(5).0.unwrap_err().contains("$stop"));
    let (result, warned) = say(6);
    assert_eq!(result, Ok(()));
    assert!(warned.log().iter().any(|l| l.level == Level::Warning && l.text.contains("take care")));
    assert!(say(9).0.unwrap_err().contains("an assertion"));
}

#[test]
fn finish_is_no_error_where_it_is_waited_for() {
    let mut sim = clocked("talks");
    let dut = sim.dut();
    let line = dut.signal("command").unwrap();
    run(&mut sim, async {
        line.set(3)?;
        dut.verilog_finish().await;
        assert_eq!(dut.now(), Time::ZERO);
        line.set(0)?;
        dut.timer(Time::ns(50)).await;
        Ok(())
    });
}

#[test]
fn a_model_that_does_not_settle_is_an_error_and_stays_one() {
    let mut sim = sim(build("loops"));
    let on = sim.dut().signal("on").unwrap();
    let dut = sim.dut();
    let text = sim
        .run(async {
            on.set(1)?;
            dut.timer(Time::ns(1)).await;
            Ok::<(), Error>(())
        })
        .unwrap_err()
        .to_string();
    assert!(text.contains("converge"), "{text}");
    on.set(0).unwrap();
    let text = sim.run_for(Time::ns(1)).unwrap_err().to_string();
    assert!(text.contains("the model 'loops' stopped"), "{text}");
}

#[test]
fn a_bench_that_fails_is_told_first() {
    let mut sim = clocked("dff");
    let error = sim.run(async { Err::<(), _>(Error::bench("wrong")) }).unwrap_err();
    assert_eq!(error.to_string(), "wrong");
    let dut = sim.dut();
    let text = sim.run(async { dut.signal("dd").map(|_| ()) }).unwrap_err().to_string();
    assert_eq!(text, "no signal 'dd' in 'dff'; nearest: d");
    assert!(matches!(dut.signal("q").unwrap().set(1), Err(ModelError::NotWritable { .. })));
}

#[test]
fn a_failure_that_first_no_longer_waits_for_fails_the_run() {
    let mut sim = clocked("dff");
    let dut = sim.dut();
    let (timed, begun) = (dut.clone(), dut.clone());
    let ended = sim.run(async move {
        let failing = timed.clone();
        let task = timed.spawn("check", async move {
            failing.timer(Time::ns(100)).await;
            Err::<(), _>(Failure::new("wrong"))
        });
        begun.timer(Time::ns(50)).await;
        // Both are due at 100 ns, the task after the timer.
        let either = Trigger::first([Trigger::Timer(Time::ns(50)), Trigger::Join(task.id())]);
        begun.wait(either).await;
        Ok::<(), Error>(())
    });
    assert_eq!(ended.unwrap_err().to_string(), "task 'check' failed at 100 ns: wrong");
}
