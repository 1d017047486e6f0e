//! Waves and coverage: what is in the files, from when to when, and what stays after a failure.

mod common;

use std::path::Path;

use common::{build, run, sim};
use hoverlock_harness::build::{Coverage, Trace};
use hoverlock_harness::coverage::Coverage as Counted;
use hoverlock_harness::sim::{Dut, Sim};
use hoverlock_harness::wave::Recording;
use hoverlock_harness::{Error, ModelError, Time};

const PERIOD: Time = Time::ns(10);

fn counting(mut sim: Sim, cycles: u64, before: impl FnOnce(&Dut)) -> Sim {
    let dut = sim.dut();
    before(&dut);
    dut.clock("clk", PERIOD).unwrap();
    let (clk, enable, step) = (dut.signal("clk").unwrap(), dut.signal("enable").unwrap(), dut.signal("step").unwrap());
    run(&mut sim, async {
        enable.set(1)?;
        step.set(3)?;
        clk.cycles(cycles).await;
        Ok(())
    });
    sim
}

/// The times at which a dump says something, and the values of one signal by its name.
fn dump(path: &Path, signal: &str) -> (Vec<u64>, Vec<(u64, u64)>) {
    let text = std::fs::read_to_string(path).unwrap();
    let declared = text.lines().filter(|l| l.trim_start().starts_with("$var"));
    let code = declared
        .map(|l| l.split_whitespace().collect::<Vec<_>>())
        .find(|fields| fields[4] == signal)
        .map(|fields| fields[3].to_owned())
        .unwrap_or_else(|| panic!("{signal} is not in {text}"));
    let (mut times, mut values, mut now) = (Vec::new(), Vec::new(), 0);
    for line in text.lines().skip_while(|l| !l.contains("$enddefinitions")) {
        if let Some(time) = line.strip_prefix('#') {
            now = time.parse().unwrap();
            times.push(now);
        } else if let Some((bits, of)) = line.strip_prefix('b').and_then(|l| l.split_once(' ')) {
            if of == code {
                values.push((now, u64::from_str_radix(bits, 2).unwrap()));
            }
        } else if line.len() > 1 && line[1..] == code {
            values.push((now, u64::from(line.starts_with('1'))));
        }
    }
    (times, values)
}

#[test]
fn chosen_signals_are_dumped_without_a_traced_build() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("chosen.vcd");
    let waves = path.clone();
    drop(counting(sim(build("counter")), 5, |dut| {
        dut.start_waves(&Recording::signals(waves, ["clk", "count"])).unwrap();
    }));
    let (times, counts) = dump(&path, "count");
    // In picoseconds, each half period of 5 ns; the count after each rising edge.
    assert_eq!(times, (0..=8).map(|half| half * 5000).collect::<Vec<_>>());
    assert_eq!(counts, [(0, 3), (10_000, 6), (20_000, 9), (30_000, 12), (40_000, 15)]);
    assert!(!std::fs::read_to_string(&path).unwrap().contains("wrapped"));
    let view = std::fs::read_to_string(folder.path().join("chosen.gtkw")).unwrap();
    assert!(
        view.contains("[dumpfile] \"chosen.vcd\"") && view.contains("@28\ncounter.clk\n@22\ncounter.count[7:0]"),
        "{view}"
    );
}

#[test]
fn a_window_begins_and_ends_in_time_and_waves_stop_when_told() {
    let folder = tempfile::tempdir().unwrap();
    let (window, stopped) = (folder.path().join("window.vcd"), folder.path().join("stopped.vcd"));
    let recording = Recording::signals(&window, Vec::<String>::new()).window(Time::ns(20), Time::ns(40));
    let mut sim = counting(sim(build("counter")), 3, |dut| {
        dut.start_waves(&recording).unwrap();
    });
    let dut = sim.dut();
    let id = dut.start_waves(&Recording::signals(&stopped, ["count"])).unwrap();
    sim.run_for(PERIOD * 2).unwrap();
    dut.stop_waves(id).unwrap();
    sim.run_for(PERIOD * 20).unwrap();
    drop(sim);
    assert_eq!(dump(&window, "clk").0, [20_000, 25_000, 30_000, 35_000, 40_000]);
    assert_eq!(dump(&stopped, "count").0, [20_000, 30_000, 40_000]);
}

#[test]
fn waves_begin_in_the_step_in_which_a_task_starts_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("begun.vcd");
    let mut sim = sim(build("counter"));
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    let clk = dut.signal("clk").unwrap();
    run(&mut sim, async {
        clk.cycles(3).await;
        dut.start_waves(&Recording::signals(&path, ["clk"]))?;
        clk.cycles(2).await;
        Ok(())
    });
    drop(sim);
    assert_eq!(dump(&path, "clk").0, [20_000, 25_000, 30_000, 35_000, 40_000]);
}

#[test]
fn everything_is_dumped_by_a_traced_build_as_vcd_and_fst() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("all.vcd");
    let waves = path.clone();
    drop(counting(sim(build("counter").trace(Trace::Vcd)), 4, |dut| {
        dut.start_waves(&Recording::everything(waves)).unwrap();
    }));
    let (_, counts) = dump(&path, "count");
    assert_eq!(counts.last(), Some(&(30_000, 12)));
    assert!(!dump(&path, "next").1.is_empty(), "an internal wire");
    assert!(folder.path().join("all.gtkw").exists());
    let fst = folder.path().join("all.fst");
    let waves = fst.clone();
    drop(counting(sim(build("counter").trace(Trace::Fst)), 1000, |dut| {
        dut.start_waves(&Recording::everything(waves)).unwrap();
    }));
    // The first block of an FST file is its header, kind 0, 329 bytes long.
    let bytes = std::fs::read(&fst).unwrap();
    assert_eq!((bytes[0], &bytes[1..9]), (0, &329u64.to_be_bytes()[..]));
    assert!(bytes.len() > 500);
}

#[test]
fn a_compressed_recording_that_is_whole_ends_without_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let mut sim = sim(build("counter").trace(Trace::Fst));
    let dut = sim.dut();
    let id = dut.start_waves(&Recording::everything(folder.path().join("whole.fst"))).unwrap();
    dut.clock("clk", Time::ns(10)).unwrap();
    sim.run_for(Time::us(10)).unwrap();
    dut.stop_waves(id).unwrap();
}

#[test]
fn a_model_without_waves_says_how_to_build_them_in() {
    let sim = sim(build("counter"));
    let error = sim.dut().start_waves(&Recording::everything("/tmp/never.vcd")).unwrap_err();
    assert!(matches!(error, Error::Model(ModelError::NotBuiltIn { .. })), "{error}");
    assert!(error.to_string().contains(".trace(Trace::Vcd)"));
    assert!(sim.dut().start_waves(&Recording::signals("/nowhere/at/all.vcd", ["clk"])).is_err());
}

#[test]
fn the_last_steps_before_a_failure_are_kept_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("failure.vcd");
    let recording = Recording::before_failure(&path, ["clk", "count"], 8);
    let mut sim = counting(sim(build("counter")), 3, |dut| {
        dut.start_waves(&recording).unwrap();
    });
    assert!(!path.exists(), "nothing failed");
    let dut = sim.dut();
    let clk = dut.signal("clk").unwrap();
    let failed = sim.run(async {
        clk.cycles(1000).await;
        Err::<(), _>(Error::bench("found"))
    });
    assert!(failed.is_err());
    let (times, counts) = dump(&path, "count");
    // 8 steps of 5 ns end with the step of the failure at (3 + 1000 - 1) * 10 ns.
    assert_eq!((times.len(), times.last()), (8, Some(&10_020_000)));
    assert_eq!(counts.last(), Some(&(10_020_000, 3 * 1003 % 256)));
    assert!(folder.path().join("failure.gtkw").exists());
}

#[test]
fn coverage_is_counted_merged_and_written_as_lcov() {
    let folder = tempfile::tempdir().unwrap();
    let library = build("counter").coverage(Coverage::ALL).compile().unwrap();
    let mut total = Counted::default();
    for (number, cycles) in [4, 200].into_iter().enumerate() {
        let path = folder.path().join(format!("{number}.dat"));
        let sim = counting(Sim::new(library.instance().unwrap()).unwrap(), cycles, |_| {});
        sim.dut().write_coverage(&path).unwrap();
        total.merge(&Counted::read(&path).unwrap());
        let wraps = total.counts.iter().any(|(p, c)| p.kind == "toggle" && p.what.contains("wrapped") && *c > 0);
        // 4 steps of 3 do not wrap 8 bits, 200 do.
        assert_eq!(wraps, number == 1, "{total:?}");
    }
    assert!(total.missed().any(|p| p.what.contains("rst")), "the reset was never given");
    let lcov = total.to_lcov();
    assert!(lcov.contains("counter.v\nDA:") && lcov.ends_with("end_of_record\n"), "{lcov}");
    let error = sim(build("counter")).dut().write_coverage(folder.path().join("x")).unwrap_err();
    assert!(error.to_string().contains(".coverage("), "{error}");
    assert!(Counted::read(Path::new("/nowhere")).is_err());
}
