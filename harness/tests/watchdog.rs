//! What never comes back to the scheduler: the process ends, and says why. Each case runs in a process of its own.

mod common;

use std::os::unix::process::ExitStatusExt;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::{build, sim};
use hoverlock_harness::sim::Limits;
use hoverlock_harness::{Error, Time};

const SIGABRT: i32 = 6;

/// Runs this test program again with one case, and gives what it said before it ended.
fn ended(case: &str) -> String {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["helper_never_comes_back", "--exact", "--ignored", "--nocapture"])
        .env("HOVERLOCK_TEST_CASE", case)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let started = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if started.elapsed() > Duration::from_secs(30) {
            child.kill().unwrap();
            panic!("{case}: the process still runs after 30 s");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.signal(), Some(SIGABRT), "{case}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_loop_without_end_in_the_verilog_ends_the_process_with_a_reason() {
    // Built here, so that the other process does not spend its time on it.
    build("endless").compile().unwrap();
    let said = ended("verilog");
    assert!(said.contains("hoverlock: the run of 'endless' exceeded its wall-clock limit of 0.2 s"), "{said}");
    assert!(said.contains("simulation time was"), "{said}");
}

#[test]
fn a_task_that_loops_without_awaiting_ends_the_process_with_a_reason() {
    build("endless").compile().unwrap();
    let said = ended("task");
    assert!(said.contains("a task loops without awaiting anything"), "{said}");
}

#[test]
fn a_run_that_ends_in_time_is_left_alone() {
    let mut sim = sim(build("endless"));
    let dut = sim.dut();
    sim.set_limits(Limits { wall_clock: Some(Duration::from_millis(20)), ..Limits::default() });
    let clock = dut.clock("clk", Time::ns(10)).unwrap();
    let error = sim.run_for(Time::s(100)).unwrap_err().to_string();
    assert!(error.contains("wall"), "{error}");
    clock.stop();
    // Longer than the watchdog's patience: it went with the run.
    let started = Instant::now();
    while started.elapsed() < Duration::from_millis(2300) {
        std::thread::sleep(Duration::from_millis(100));
    }
}

#[test]
#[ignore = "no test: other tests run it in a process of its own"]
fn helper_never_comes_back() {
    let Ok(case) = std::env::var("HOVERLOCK_TEST_CASE") else { return };
    let mut sim = sim(build("endless"));
    let dut = sim.dut();
    sim.set_limits(Limits { wall_clock: Some(Duration::from_millis(200)), ..Limits::default() });
    dut.clock("clk", Time::ns(10)).unwrap();
    let ended = sim.run(async {
        dut.timer(Time::ns(25)).await;
        if case == "task" {
            while std::hint::black_box(true) {}
        }
        dut.signal("go")?.set(1)?;
        dut.timer(Time::ns(25)).await;
        Ok::<(), Error>(())
    });
    panic!("it came back: {ended:?}");
}
