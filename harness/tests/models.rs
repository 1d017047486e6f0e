//! Signals of every kind, several models and instances in one process, and models driven without the scheduler.

mod common;

use common::{build, run, sim};
use hoverlock_harness::build::Initial;
use hoverlock_harness::model::{Direction, InstanceOptions, Message};
use hoverlock_harness::sim::Sim;
use hoverlock_harness::{Error, ModelError, Time};
use proptest::prelude::*;

#[test]
fn ports_tell_width_direction_and_sign() {
    let sim = sim(build("wide"));
    let signals = sim.dut().signals();
    let of = |name: &str| signals.iter().find(|s| s.name == name).unwrap();
    assert_eq!((of("a").width, of("a").direction, of("a").signed), (100, Direction::Input, false));
    assert_eq!((of("s").width, of("s").signed), (5, true));
    assert_eq!((of("s_extended").direction, of("s_extended").signed), (Direction::Output, true));
    assert_eq!(of("video$data").width, 33);
    assert_eq!(signals.len(), 11);
    assert!(sim.dut().signal("video.data").is_ok(), "a dot finds what is written with a dollar");
}

#[test]
fn a_design_may_have_no_signals() {
    let mut sim = sim(build("empty"));
    assert!(sim.dut().signals().is_empty());
    let dut = sim.dut();
    run(&mut sim, async {
        dut.timer(Time::ns(5)).await;
        assert_eq!(dut.now(), Time::ns(5));
        Ok(())
    });
}

#[test]
fn wide_values_are_read_and_written_whole() {
    let mut sim = sim(build("wide"));
    let dut = sim.dut();
    dut.clock("clk", Time::ns(10)).unwrap();
    let (a, a_next) = (dut.wide("a").unwrap(), dut.wide("a_next").unwrap());
    let (b, swapped) = (dut.wide("b").unwrap(), dut.wide("b_swapped").unwrap());
    run(&mut sim, async {
        a.set(&[u32::MAX, u32::MAX, u32::MAX, 7])?;
        let words: Vec<u32> = (1..=16).collect();
        b.set(&words)?;
        a_next.value_change().await;
        assert_eq!(a_next.get(), [0, 0, 0, 8]);
        assert_eq!(swapped.get(), [&words[8..], &words[..8]].concat());
        assert_eq!(swapped.get_bits(30, 4), 10 << 2 & 0xf);
        Ok(())
    });
    let error = a.set(&[0, 0, 0, 16]).unwrap_err();
    assert!(error.to_string().starts_with("0x10000000000000000000000000"), "{error}");
    assert!(matches!(dut.signal("a"), Err(ModelError::TooWide { width: 100, .. })));
    assert!(matches!(a_next.set(&[0]), Err(ModelError::NotWritable { .. })));
}

#[test]
fn signed_writes_are_encoded_and_out_of_range_ones_refused() {
    let mut sim = sim(build("wide"));
    let dut = sim.dut();
    let (s, extended, c) = (dut.signal("s").unwrap(), dut.signal("s_extended").unwrap(), dut.signal("c").unwrap());
    assert_eq!(s.set(32).unwrap_err().to_string(), "32 does not fit 's', which is 5 bits wide (0 to 31)");
    assert_eq!(s.set_signed(-17).unwrap_err().to_string(), "-17 does not fit 's', which is 5 bits wide (-16 to 31)");
    run(&mut sim, async {
        s.set_signed(-16)?;
        c.set(u64::MAX)?;
        dut.read_write().await;
        assert_eq!((s.get(), s.get_signed(), extended.get_signed()), (16, -16, -16));
        assert_eq!(dut.signal("c_inverted")?.get(), 0);
        Ok(())
    });
}

#[test]
fn internals_memories_and_enumerations_are_found_by_name() {
    let mut sim = sim(build("wide").internal("memory"));
    let dut = sim.dut();
    let memory = dut.memory("memory").unwrap();
    assert_eq!(memory.len(), 8);
    dut.clock("clk", Time::ns(10)).unwrap();
    run(&mut sim, async {
        memory.set(3, 0xff_ffff_ffff)?;
        memory.set(10, 5)?;
        dut.signal("clk")?.cycles(2).await;
        assert_eq!((memory.get(3)?, memory.get(4)?, memory.get(10)?), (0xff_ffff_ffff, 0, 5));
        assert_eq!(memory.to_vec()[7], 5);
        Ok(())
    });
    assert_eq!(memory.get(11).unwrap_err().to_string(), "address 11 is outside of 'memory', which has 3 to 10");
    assert!(memory.set(4, 1 << 40).is_err());
    assert!(matches!(dut.signal("memory"), Err(ModelError::WrongShape { .. })));
    assert!(matches!(dut.memory("a"), Err(ModelError::WrongShape { .. })));
    let hidden = common::sim(build("wide")).dut().memory("memory").err().unwrap().to_string();
    assert!(hidden.contains("memory (not public: add .internal(\"memory\") to the build)"), "{hidden}");
}

#[test]
fn instances_of_one_and_of_several_models_do_not_disturb_each_other() {
    let counters = build("counter").compile().unwrap();
    let talks = build("talks").compile().unwrap();
    let mut models: Vec<_> = (0..5).map(|_| counters.instance().unwrap()).collect();
    let mut talker = talks.instance().unwrap();
    let command = talker.find("command").unwrap();
    let talker_clk = talker.find("clk").unwrap();
    for cycle in 0..100u64 {
        for (number, model) in (1u64..).zip(&mut models) {
            let s = |name: &str| model.find(name).unwrap();
            let (clk, rst, enable, step) = (s("clk"), s("rst"), s("enable"), s("step"));
            model.set(rst, u64::from(cycle == 0)).unwrap();
            model.set(enable, 1).unwrap();
            model.set(step, number).unwrap();
            for level in [0, 1] {
                model.set(clk, level).unwrap();
                model.eval().unwrap();
            }
        }
        // One instance comes and goes in between.
        drop(counters.instance().unwrap());
        talker.set(command, u64::from(cycle == 50)).unwrap();
        for level in [0, 1] {
            talker.set(talker_clk, level).unwrap();
            talker.set_time(Time::ns(cycle));
            talker.eval().unwrap();
        }
    }
    for (number, model) in (1u64..).zip(&models) {
        let count = model.find("count").unwrap();
        assert_eq!(model.get(count), 99 * number % 256);
    }
    assert_eq!(talker.take_messages(), [Message::Text("hello at 50000".into())]);
    models.swap_remove(0);
    assert_eq!(models.len(), 4);
}

#[test]
fn a_model_moves_to_another_thread_and_models_run_in_parallel() {
    let library = build("counter").compile().unwrap();
    let counted: Vec<u64> = std::thread::scope(|scope| {
        let threads: Vec<_> = (1..=4u64)
            .map(|step| {
                let model = library.instance().unwrap();
                scope.spawn(move || {
                    let mut sim = Sim::new(model).unwrap();
                    let dut = sim.dut();
                    dut.clock("clk", Time::ns(2)).unwrap();
                    let s = |name: &str| dut.signal(name).unwrap();
                    let (clk, enable, count) = (s("clk"), s("enable"), s("count"));
                    let by = s("step");
                    run(&mut sim, async {
                        by.set(step)?;
                        enable.set(1)?;
                        clk.cycles(1001).await;
                        Ok(())
                    });
                    count.get()
                })
            })
            .collect();
        threads.into_iter().map(|t| t.join().unwrap()).collect()
    });
    // 1001 edges, the last of them included in the run's last step.
    assert_eq!(counted, [1, 2, 3, 4].map(|step| 1001 * step % 256));
}

#[test]
fn a_signal_of_another_model_is_refused() {
    let library = build("counter").compile().unwrap();
    let (one, two) = (library.instance().unwrap(), library.instance().unwrap());
    let count = one.find("count").unwrap();
    let refused = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| two.get(count)));
    assert!(refused.is_err());
}

#[test]
fn random_initial_values_come_from_the_seed_and_find_a_missing_reset() {
    let zero = build("talks").compile().unwrap();
    let random = build("talks").initial(Initial::Random).compile().unwrap();
    let start = |library: &hoverlock_harness::model::Library, seed| {
        let model = library.instance_with(&InstanceOptions { seed, ..InstanceOptions::default() }).unwrap();
        let unreset = model.find("unreset").unwrap();
        let mut model = model;
        model.eval().unwrap();
        model.get(unreset)
    };
    assert!((0..8).all(|seed| start(&zero, seed) == 0));
    let values: Vec<u64> = (1..40).map(|seed| start(&random, seed)).collect();
    assert!(values.iter().any(|v| *v != values[0]), "{values:?}");
    assert_eq!(values, (1..40).map(|seed| start(&random, seed)).collect::<Vec<_>>(), "replayed");
}

#[test]
fn random_and_plusargs_reach_the_verilog() {
    let library = build("talks").compile().unwrap();
    let ask = |seed, plusargs: Vec<String>, command, answer: &str| {
        let mut model = library.instance_with(&InstanceOptions { seed, plusargs }).unwrap();
        let (clk, line, answer) =
            (model.find("clk").unwrap(), model.find("command").unwrap(), model.find(answer).unwrap());
        model.set(line, command).unwrap();
        for level in [0, 1] {
            model.set(clk, level).unwrap();
            model.eval().unwrap();
        }
        model.get(answer)
    };
    assert_eq!(ask(5, vec![], 7, "random"), ask(5, vec![], 7, "random"));
    assert_ne!(ask(5, vec![], 7, "random"), ask(6, vec![], 7, "random"));
    assert_eq!(ask(0, vec!["+verbose".into()], 8, "seen"), 1);
    assert_eq!(ask(0, vec![], 8, "seen"), 0);
}

#[test]
fn raw_signals_have_the_stored_type() {
    let model = build("wide").compile().unwrap().instance().unwrap();
    assert!(model.raw::<u8>("s").is_ok() && model.raw::<u64>("c").is_ok());
    assert!(matches!(model.raw::<u16>("s"), Err(ModelError::WrongShape { instead: "raw::<u8>", .. })));
    assert!(matches!(model.raw::<u64>("b"), Err(ModelError::WrongShape { .. })));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn every_value_that_fits_is_read_back_and_none_else_is_taken(value in any::<u64>(), width in 1u32..=64) {
        // `c` takes all 64 bits, `s` five, `video$data` 33, `clk` one.
        let sim = sim(build("wide"));
        let dut = sim.dut();
        let name = match width { 1..=16 => "clk", 17..=32 => "s", 33..=48 => "video$data", _ => "c" };
        let signal = dut.signal(name).unwrap();
        let bits = signal.info().width;
        let fits = bits == 64 || value >> bits == 0;
        prop_assert_eq!(signal.set(value).is_ok(), fits);
        let masked = value & signal.info().mask();
        signal.set(masked).unwrap();
        let mut sim = sim;
        let settled: Result<(), Error> = sim.run_for(Time::ns(1));
        settled.unwrap();
        prop_assert_eq!(signal.get(), masked);
    }
}

#[test]
fn names_go_through_generate_loops_and_a_grid_has_an_index_for_each_dimension() {
    let mut sim = sim(build("tree").internal("*.count").internal("*.grid"));
    let dut = sim.dut();
    dut.clock("clk", Time::ns(10)).unwrap();
    let names: Vec<String> = dut.signals().into_iter().map(|s| s.name).collect();
    assert!(names.contains(&"lane[0].u_leaf.count".to_owned()), "{names:?}");
    let (one, two) = (dut.signal("lane[0].u_leaf.count").unwrap(), dut.signal("lane[1].u_leaf.count").unwrap());
    run(&mut sim, async {
        dut.signal("clk")?.cycles(5).await;
        dut.read_only().await;
        assert_eq!((one.get(), two.get(), dut.signal("total")?.get()), (5, 10, 15));
        Ok(())
    });
    let grid = dut.memory("lane[0].u_leaf.grid").unwrap();
    assert_eq!((grid.len(), grid.get(grid.index(&[0, 1]).unwrap()).unwrap()), (6, 4));
    assert_eq!(grid.index(&[1, 2]).unwrap(), 5);
    assert!(grid.index(&[1, 3]).unwrap_err().to_string().contains("address 3 is outside"));
    assert!(grid.index(&[1]).unwrap_err().to_string().contains("number of dimensions"));
}

#[test]
fn fields_of_unpacked_structures_and_arrays_of_reals_are_read_and_written() {
    let internals = ["mixed", "many", "table_of", "levels", "plane"];
    let build = internals.iter().fold(build("odd"), |build, name| build.internal(*name));
    let mut sim = sim(build);
    let dut = sim.dut();
    let signal = |name: &str| dut.signal(name).unwrap();
    let fields: Vec<String> =
        dut.signals().iter().map(|s| s.name.clone()).filter(|name| name.starts_with("mixed.")).collect();
    let expected = ["bytes", "inner.x", "inner.y", "mode", "pair"].map(|name| format!("mixed.{name}"));
    assert_eq!(fields, expected);
    assert_eq!(dut.texts(), ["mixed.note"]);
    let info = signal("mixed.inner.y").info();
    assert_eq!((info.width, info.signed), (32, true));
    let [levels, plane, bytes] = ["levels", "plane", "mixed.bytes"].map(|name| dut.memory(name).unwrap());
    dut.clock("clk", Time::ns(10)).unwrap();
    run(&mut sim, async {
        dut.memory("grid")?.set(5, 6)?;
        levels.set_real(2, 1.5)?;
        plane.set_real(plane.index(&[1, 2])?, -0.25)?;
        bytes.set(2, 42)?;
        dut.text("mixed.note")?.set(b"none")?;
        signal("many[3].x").set(9)?;
        signal("table_of[1][-1].x").set(5)?;
        signal("table_of[1][0].x").set(3)?;
        signal("mixed.pair").set(0x15)?;
        signal("mixed.inner.y").set_signed(-7)?;
        dut.signal("clk")?.cycles(3).await;
        dut.read_only().await;
        assert_eq!((levels.get_real(2)?, levels.get_real(1)?), (1.5, 0.0));
        assert_eq!((bytes.get(2)?, signal("mixed.inner.x").get()), (42, 9 ^ 5));
        assert_eq!((signal("mixed.mode").get(), signal("mixed.inner.y").get_signed()), (2, -10));
        assert_eq!((signal("table_of[1][0].x").get(), signal("many[2].x").get()), (3, 0));
        assert_eq!(dut.text("mixed.note")?.get(), b"none");
        Ok(())
    });
    let said = |result: Result<(), ModelError>| result.unwrap_err().to_string();
    assert!(said(levels.get(1).map(drop)).ends_with("has elements that are `real`: use `get_real and set_real`"));
    assert!(said(bytes.get_real(1).map(drop)).contains("no `real`"));
    assert!(said(levels.set_real(5, 0.0)).contains("address 5 is outside"));
}

#[test]
fn reals_strings_and_arrays_of_any_shape_are_read_and_written() {
    let internals = ["state", "text", "rows", "deep", "loose", "numbers"];
    let build = internals.iter().fold(build("odd"), |build, name| build.internal(*name));
    let mut sim = sim(build);
    let dut = sim.dut();
    for name in ["gain", "scaled", "state"] {
        let said = [dut.signal(name).err(), dut.wide(name).err()].map(|e| e.map(|e| e.to_string()));
        assert!(said.iter().all(|s| s.as_deref() == Some(&format!("'{name}' is a `real`: use `real`"))), "{said:?}");
    }
    for name in ["loose", "numbers"] {
        let said = dut.signal(name).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(said.starts_with(&format!("'{name}' of 'odd' cannot be accessed: only vectors")), "{name}: {said}");
        assert!(said.ends_with(&format!("its fields alone, '{name}.field'")), "{name}: {said}");
    }
    assert!(dut.real("corner").is_err() && dut.text("corner").is_err() && dut.memory("text").is_err());
    assert_eq!(dut.texts(), ["text"]);
    let (grid, rows, deep) = (dut.memory("grid").unwrap(), dut.memory("rows").unwrap(), dut.memory("deep").unwrap());
    let (corner, text) = (dut.signal("corner").unwrap(), dut.text("text").unwrap());
    let (gain, scaled, state) = (dut.real("gain").unwrap(), dut.real("scaled").unwrap(), dut.real("state").unwrap());
    dut.clock("clk", Time::ns(10)).unwrap();
    run(&mut sim, async {
        grid.set(grid.index(&[1, 2])?, 9)?;
        gain.set(1.25)?;
        dut.read_write().await;
        // The clock has risen once: `state` holds the gain.
        assert_eq!((corner.get(), scaled.get()), (9, 3.75));
        scaled.set(1.0).unwrap_err();
        dut.signal("clk")?.cycles(2).await;
        dut.read_only().await;
        assert_eq!((state.get(), scaled.get(), rows.get(rows.index(&[1, 0])?)?), (1.25, 3.75, 3));
        assert_eq!(text.get(), b"tick");
        assert!(text.set(b"x").unwrap_err().to_string().contains("ReadOnly"));
        dut.next_time_step().await;
        // 71 bits: an element of three 32-bit words.
        deep.set_words(-1, &[0xdead_beef, 7, 0x40])?;
        assert!(deep.set_words(-1, &[0, 0, 0x80]).unwrap_err().to_string().contains("71 bits wide"));
        assert!(deep.get(-1).unwrap_err().to_string().contains("use `get_words"));
        text.set(b"written")?;
        rows.set(rows.index(&[1, 0])?, 7)?;
        dut.read_write().await;
        assert_eq!(
            (deep.get_words(-1)?, dut.wide("deepest")?.get()),
            (vec![0xdead_beef, 7, 0x40], vec![0xdead_beef, 7, 0x40])
        );
        assert_eq!(text.get(), b"written");
        Ok(())
    });
}
