//! Clocks of the scheduler: phases, unequal halves, stops and starts.

mod common;

use common::{build, run, sim};
use hoverlock_harness::{Error, SimError, Time};

const PERIOD: Time = Time::ns(10);

#[test]
fn clocks_that_rise_together_sample_each_others_old_values() {
    let mut sim = sim(build("chain"));
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    dut.clock("clk_b", PERIOD).unwrap();
    let s = |name: &str| dut.signal(name).unwrap();
    let (clk, d, q1, q_b) = (s("clk"), s("d"), s("q1"), s("q_b"));
    run(&mut sim, async {
        d.set(1)?;
        for expected in [0, 1, 1] {
            clk.rising_edge().await;
            dut.read_only().await;
            assert_eq!((q1.get(), q_b.get()), (1, expected));
            dut.next_time_step().await;
        }
        Ok(())
    });
}

#[test]
fn clocks_with_phases_and_unequal_halves_tick_when_they_should() {
    let mut sim = sim(build("chain"));
    let dut = sim.dut();
    dut.clock_with("clk", Time::ns(3), Time::ns(7), Time::ns(2)).unwrap();
    dut.clock_with("clk_b", Time::ps(500), Time::fs(1), Time::ZERO).unwrap();
    let (clk, clk_b) = (dut.signal("clk").unwrap(), dut.signal("clk_b").unwrap());
    run(&mut sim, async {
        let mut times = Vec::new();
        for _ in 0..2 {
            clk.rising_edge().await;
            times.push(dut.now());
            clk.falling_edge().await;
            times.push(dut.now());
        }
        assert_eq!(times, [2, 5, 12, 15].map(Time::ns));
        clk_b.rising_edge().await;
        let first = dut.now();
        clk_b.rising_edge().await;
        assert_eq!(dut.now() - first, Time::fs(500_001));
        Ok(())
    });
}

#[test]
fn a_stopped_clock_stays_and_starts_again() {
    let mut sim = sim(build("dff"));
    let dut = sim.dut();
    let clock = dut.clock("clk", PERIOD).unwrap();
    let clk = dut.signal("clk").unwrap();
    run(&mut sim, async {
        clk.cycles(3).await;
        clock.stop();
        dut.timer(Time::ns(95)).await;
        assert_eq!((dut.now(), clk.get()), (Time::ns(115), 1));
        clock.start(Time::ns(4))?;
        clk.rising_edge().await;
        assert_eq!(dut.now(), Time::ns(119));
        Ok(())
    });
}

#[test]
fn a_clock_that_starts_or_stops_at_an_edge_of_the_only_one_does_so_at_once() {
    let mut sim = sim(build("chain"));
    let dut = sim.dut();
    let clock = dut.clock("clk", PERIOD).unwrap();
    let (clk, clk_b) = (dut.signal("clk").unwrap(), dut.signal("clk_b").unwrap());
    run(&mut sim, async {
        clk.cycles(2).await;
        let other = dut.clock_with("clk_b", Time::ns(1), Time::ns(1), Time::ns(1))?;
        clk_b.cycles(3).await;
        assert_eq!(dut.now(), Time::ns(15));
        other.stop();
        clk.cycles(3).await;
        assert_eq!(dut.now(), Time::ns(40));
        clock.stop();
        Ok(())
    });
    let ended = sim.run(async {
        clock.start(Time::ns(2))?;
        clk.cycles(2).await;
        clock.stop();
        clk.rising_edge().await;
        Ok::<(), Error>(())
    });
    assert!(matches!(ended, Err(Error::Sim(SimError::Deadlock { .. }))), "{ended:?}");
    assert_eq!(dut.now(), Time::ns(52));
}

#[test]
fn an_interrupted_run_leaves_the_clock_at_the_level_of_its_time() {
    let mut sim = sim(build("dff"));
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    let clk = dut.signal("clk").unwrap();
    let mut asked = 0;
    sim.set_interrupt(move || {
        asked += 1;
        asked % 2 == 0
    });
    for _ in 0..8 {
        let ended = sim.run(async {
            for _ in 0..u64::MAX {
                clk.rising_edge().await;
            }
            Ok::<(), Error>(())
        });
        assert!(matches!(ended, Err(Error::Sim(SimError::Interrupted { .. }))), "{ended:?}");
        let phase = dut.now().as_fs() % PERIOD.as_fs();
        assert_eq!(clk.get(), u64::from(phase == 0), "at {}", dut.now());
    }
}
