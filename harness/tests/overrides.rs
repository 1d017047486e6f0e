//! Values that a bench overrides: force, freeze and release of internal signals, and `inout`s that both sides drive.

mod common;

use common::{build, run, sim};
use hoverlock_harness::build::{Build, Initial};
use hoverlock_harness::sim::Sim;
use hoverlock_harness::{BuildError, Error, ModelError, Time};

fn forceable() -> Build {
    let names = ["u_adder.sum", "u_adder.low", "u_adder.held", "long", "sum"];
    names.into_iter().fold(build("overrides"), Build::forceable)
}

#[test]
fn a_forced_net_has_the_forced_value_for_design_and_bench() {
    let mut sim = sim(forceable());
    let dut = sim.dut();
    dut.clock("clk", Time::ns(10)).unwrap();
    let signal = |name: &str| dut.signal(name).unwrap();
    let (data, next, held, sum) = (signal("data"), signal("next"), signal("held"), signal("u_adder.sum"));
    let force = dut.forcing("u_adder.sum").unwrap();
    run(&mut sim, async {
        data.set(4)?;
        dut.read_write().await;
        assert_eq!((next.get(), sum.get()), (5, 5));
        force.force(&[0x40], &force.all_bits())?;
        assert_eq!(sum.get(), 5, "put like a write");
        dut.read_only().await;
        assert_eq!((next.get(), sum.get()), (0x40, 0x40));
        dut.timer(Time::ns(20)).await;
        assert_eq!(held.get(), 0x40, "registers sample it");
        data.set(9)?;
        dut.read_write().await;
        assert_eq!((next.get(), sum.get()), (0x40, 0x40), "while the design assigns 10");
        // The lowest bit alone.
        force.release(&force.all_bits())?;
        force.force(&[1], &[1])?;
        dut.read_write().await;
        assert_eq!((next.get(), sum.get()), (11, 11));
        force.force(&[0], &[0x80])?;
        data.set(0x8f)?;
        dut.read_write().await;
        assert_eq!(next.get(), 0x11, "two bits, each forced on its own");
        force.release(&force.all_bits())?;
        dut.read_write().await;
        assert_eq!((next.get(), sum.get()), (0x90, 0x90));
        Ok(())
    });
    assert!(force.force(&[0x100], &force.all_bits()).is_err(), "9 bits");
}

#[test]
fn bits_registers_and_wide_nets_are_forced() {
    let mut sim = sim(forceable());
    let dut = sim.dut();
    dut.clock("clk", Time::ns(10)).unwrap();
    let signal = |name: &str| dut.signal(name).unwrap();
    let (data, held, odd, long_sum) = (signal("data"), signal("held"), signal("odd"), signal("long_sum"));
    let turned = dut.wide("turned").unwrap();
    let forcing = |name: &str| dut.forcing(name).unwrap();
    let (low, register, long, sum) = (forcing("u_adder.low"), forcing("u_adder.held"), forcing("long"), forcing("sum"));
    run(&mut sim, async {
        low.force(&[1], &[1])?;
        register.force(&[7], &[0xff])?;
        long.force(&[1, 2, 3, 4], &long.all_bits())?;
        dut.timer(Time::ns(25)).await;
        assert_eq!((odd.get(), held.get()), (1, 7));
        assert_eq!(turned.get(), [!1, !2, !3, !4 & 0xf]);
        assert_eq!(long_sum.get(), 2 << 32 | 1, "what is computed from it");
        sum.force(&[5, 6], &sum.all_bits())?;
        dut.read_write().await;
        assert_eq!(long_sum.get(), 6 << 32 | 5);
        // A freeze keeps what is there, whatever the design assigns.
        low.release(&[1])?;
        register.release(&[0xff])?;
        long.release(&long.all_bits())?;
        sum.release(&sum.all_bits())?;
        data.set(3)?;
        dut.timer(Time::ns(20)).await;
        assert_eq!((odd.get(), held.get(), long_sum.get()), (1, 4, 6));
        register.freeze(&[0xff])?;
        long.freeze(&long.all_bits())?;
        data.set(8)?;
        dut.timer(Time::ns(20)).await;
        assert_eq!((odd.get(), held.get(), long_sum.get()), (0, 4, 3 + 8));
        assert_eq!(dut.wide("long").unwrap().get(), [3, 0, 3 << 28, 0]);
        Ok(())
    });
}

#[test]
fn a_force_wakes_tasks_and_a_deposit_waits_for_its_end() {
    let mut sim = sim(forceable().initial(Initial::Random));
    let dut = sim.dut();
    let (low, held) = (dut.signal("u_adder.low").unwrap(), dut.signal("u_adder.held").unwrap());
    let (force, register) = (dut.forcing("u_adder.low").unwrap(), dut.forcing("u_adder.held").unwrap());
    run(&mut sim, async {
        dut.signal("data")?.set(0)?;
        dut.read_write().await;
        assert_eq!((low.get(), held.get()), (0, 0), "nothing is forced at the beginning");
        let woken = dut.spawn("watch", {
            let (low, dut) = (low.clone(), dut.clone());
            async move {
                low.rising_edge().await;
                Ok::<_, Error>(dut.now())
            }
        });
        dut.timer(Time::ns(3)).await;
        force.force(&[1], &[1])?;
        assert_eq!(woken.await?, Time::ns(3));
        register.force(&[9], &[0xff])?;
        dut.timer(Time::ns(1)).await;
        held.set(5)?;
        dut.timer(Time::ns(1)).await;
        assert_eq!(held.get(), 9);
        register.release(&[0xff])?;
        dut.timer(Time::ns(1)).await;
        assert_eq!(held.get(), 5);
        Ok(())
    });
}

#[test]
fn what_cannot_be_forced_is_refused_with_the_way_to_it() {
    let sim = sim(build("overrides").internal("u_adder.sum"));
    let message = |name: &str| sim.dut().forcing(name).err().map(|e| e.to_string()).unwrap_or_default();
    assert_eq!(message("u_adder.sum"), "'u_adder.sum' cannot be forced: add .forceable(\"u_adder.sum\") to the build");
    assert!(
        message("next").ends_with("a port of the top; force the signal inside that drives it"),
        "{}",
        message("next")
    );
    let refused = |name: &str| build("overrides").forceable(name).compile().unwrap_err();
    for name in ["next", "u_adder.cells", "u_adder.gain"] {
        assert!(matches!(refused(name), BuildError::BadOption { what: "forceable", .. }), "{name}");
    }
    let error = refused("u_adder.sun");
    assert!(matches!(&error, BuildError::NoSuchInternal { nearest, .. } if nearest[0] == "u_adder.sum"), "{error}");
    let all = common::sim(build("overrides").forceable("*"));
    assert!(all.dut().forcing("u_adder.value").is_ok() && all.dut().signals().iter().all(|s| !s.name.contains(' ')));
}

/// Whether this Verilator lets a bench drive an `inout`; else it must refuse with its reason.
fn can_drive(sim: &Sim) -> bool {
    match sim.dut().signal("pad").unwrap().set(0) {
        Ok(()) => true,
        Err(error) => {
            assert!(matches!(&error, ModelError::InoutNotDrivable { signal } if signal == "pad"), "{error}");
            let version = std::process::Command::new("verilator").arg("--version").output().unwrap();
            let asked = std::env::var_os("VERILATOR");
            assert!(asked.is_some() || String::from_utf8_lossy(&version.stdout).contains("5.006"), "a newer one can");
            eprintln!("SKIPPED: this Verilator does not let a bench drive an inout");
            false
        }
    }
}

#[test]
fn an_inout_is_driven_by_either_side() {
    let mut sim = sim(build("overrides"));
    if !can_drive(&sim) {
        return;
    }
    let dut = sim.dut();
    dut.clock("clk", Time::ns(10)).unwrap();
    let signal = |name: &str| dut.signal(name).unwrap();
    let (data, drive, pad, seen, kept) =
        (signal("data"), signal("drive"), signal("pad"), signal("pad_seen"), signal("pad_kept"));
    let (wide, wide_seen) = (dut.wide("wide_pad").unwrap(), dut.wide("wide_seen").unwrap());
    run(&mut sim, async {
        pad.set(0x5a)?;
        wide.set(&[1, 2, 3, 4])?;
        data.set(0xc3)?;
        dut.timer(Time::ns(25)).await;
        assert_eq!((pad.get(), seen.get(), kept.get()), (0x5a, 0x5a, 0x5a));
        assert_eq!((wide.get(), wide_seen.get()), (vec![1, 2, 3, 4], vec![1, 2, 3, 4]));
        drive.set(1)?;
        dut.read_write().await;
        assert_eq!((pad.get(), seen.get(), kept.get()), (0xc3, 0xc3, 0x5a), "where the design drives, it counts");
        assert_eq!(wide_seen.get(), [1, 0, 0x3000_0000, 0xc]);
        // The same value as is there: what the bench drives must be that when the design lets go.
        pad.set(0xc3)?;
        dut.timer(Time::ns(20)).await;
        assert_eq!(kept.get(), 0xc3);
        data.set(0x11)?;
        dut.read_write().await;
        assert_eq!(pad.get(), 0x11);
        drive.set(0)?;
        dut.read_write().await;
        assert_eq!((pad.get(), seen.get()), (0xc3, 0xc3));
        Ok(())
    });
    assert!(dut.signals().iter().all(|s| !s.name.contains("__")), "the halves are no ports");
}

#[test]
fn an_open_drain_is_low_if_either_side_pulls() {
    let mut sim = sim(build("overrides"));
    if !can_drive(&sim) {
        return;
    }
    let dut = sim.dut();
    let signal = |name: &str| dut.signal(name).unwrap();
    let (line, pull, falls) = (signal("open_drain"), signal("pull_low"), signal("falls"));
    run(&mut sim, async {
        line.set(1)?;
        dut.timer(Time::ns(1)).await;
        let fallen = dut.spawn("watch", {
            let (line, dut) = (line.clone(), dut.clone());
            async move {
                line.falling_edge().await;
                Ok::<_, Error>(dut.now())
            }
        });
        let before = falls.get();
        dut.timer(Time::ns(4)).await;
        pull.set(1)?;
        assert_eq!(fallen.await?, Time::ns(5), "the design pulls");
        dut.timer(Time::ns(1)).await;
        assert_eq!((line.get(), falls.get()), (0, before + 1), "the design sees its own edge");
        pull.set(0)?;
        dut.timer(Time::ns(1)).await;
        assert_eq!(line.get(), 1);
        line.set(0)?;
        dut.timer(Time::ns(1)).await;
        assert_eq!((line.get(), falls.get()), (0, before + 2), "the bench pulls");
        Ok(())
    });
}
