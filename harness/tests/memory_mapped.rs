//! Avalon-MM and AXI4-Lite: masters and memories with every stall and latency, and every rule, broken once.

mod common;

use common::buses::{any_pause, start};
use common::{build, run};
use hoverlock_harness::bus::{Pause, avalon_mm, axi_lite};
use hoverlock_harness::{Error, Time};
use proptest::prelude::*;

#[test]
fn an_avalon_master_reads_and_writes_through_every_stall_and_latency() {
    for stall in [0u64, 3] {
        for latency in [1u64, 5] {
            let design = build("registers_mm").parameter("STALL", stall).parameter("LATENCY", latency);
            let (mut sim, dut, clk, _) = start(design, "rst");
            let master = avalon_mm::Master::new(&dut, &clk, "csr_", 1).unwrap();
            run(&mut sim, async {
                clk.cycles(5).await;
                for at in 0..8 {
                    master.write(at, 0x1111_1111 * at).await?;
                }
                for at in (0..8).rev() {
                    assert_eq!(master.read(at).await?, 0x1111_1111 * at);
                }
                master.write_bytes(2, 0xaabb_ccdd, 0b0101).await?;
                assert_eq!(master.read(2).await?, 0x22bb_22dd);
                // Two tasks take turns.
                let other = master.clone();
                let task = dut.spawn("other", async move { other.read(7).await });
                assert_eq!(master.read(1).await?, 0x1111_1111);
                assert_eq!(task.await?, 0x7777_7777);
                Ok(())
            });
        }
    }
}

#[test]
fn an_avalon_memory_serves_a_master_and_checks_it() {
    for (least, most, stall) in [(1, 1, 0.0), (2, 5, 0.5), (1, 9, 0.9)] {
        let (mut sim, dut, clk, reset) = start(build("copier_mm"), "rst");
        let memory = avalon_mm::Memory::new(&dut, &clk, "m_", Some(reset)).unwrap();
        memory.set_latency(least, most, 1);
        memory.set_stall(Pause::random(stall, 2));
        (0..20).for_each(|at| memory.set(at, 1000 + at));
        run(&mut sim, async {
            clk.cycles(5).await;
            dut.signal("count")?.set(20)?;
            dut.signal("start")?.set(1)?;
            dut.with_timeout(Time::ms(1), dut.signal("done")?.rising_edge()).await?;
            Ok(())
        });
        assert!((0..20).all(|at| memory.get(256 + at) == 1001 + at));
        assert_eq!(memory.accesses(), 40);
    }
    let (mut sim, dut, clk, reset) = start(build("copier_mm").parameter("FAULT", 1), "rst");
    let memory = avalon_mm::Memory::new(&dut, &clk, "m_", Some(reset)).unwrap();
    memory.set_stall(Pause::random(0.5, 2));
    let result = sim.run(async {
        clk.cycles(5).await;
        dut.signal("count")?.set(20)?;
        dut.signal("start")?.set(1)?;
        dut.signal("done")?.rising_edge().await;
        Ok::<(), Error>(())
    });
    let text = result.unwrap_err().to_string();
    assert!(text.contains("the command changed while waitrequest was 1"), "{text}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, ..ProptestConfig::default() })]

    #[test]
    fn an_avalon_master_bursts_of_every_length_stall_and_pause(
        stall in prop::sample::select(vec![0u64, 1, 4]),
        bursts in prop::collection::vec((0u64..64, prop::collection::vec(any::<u32>(), 1..16)), 1..8),
        pause in any_pause(),
    ) {
        let (mut sim, dut, clk, _) = start(build("burst_ram").parameter("STALL", stall), "rst");
        let master = avalon_mm::Master::new(&dut, &clk, "mem_", 1).unwrap();
        let mut expected = [0u64; 64];
        run(&mut sim, async {
            clk.cycles(5).await;
            for (address, words) in &bursts {
                let words: Vec<u64> = words.iter().map(|w| u64::from(*w)).collect();
                master.write_burst(*address, &words, pause.clone()).await?;
                for (at, word) in (*address..).zip(&words) {
                    expected[at as usize % 64] = *word;
                }
                assert_eq!(master.read_burst(*address, words.len()).await?, words);
            }
            for (at, word) in (0..).zip(expected) {
                assert_eq!(master.read(at).await?, word);
            }
            Ok(())
        });
    }

    #[test]
    fn an_avalon_memory_serves_bursts_of_every_length_gap_stall_and_latency(
        count in 1u64..16,
        gap in 0u64..4,
        stall in any_pause(),
        (least, more) in (1u64..5, 0u64..5),
        seed in any::<u64>(),
    ) {
        // A model for each length and gap would spend minutes on building: they are inputs.
        let (mut sim, dut, clk, reset) = start(build("burst_copier"), "rst");
        let memory = avalon_mm::Memory::new(&dut, &clk, "m_", Some(reset)).unwrap();
        memory.set_step(4);
        memory.set_stall(stall);
        memory.set_latency(least, least + more, seed);
        (0..count).for_each(|at| memory.set(0x100 + 4 * at, 1000 * at));
        run(&mut sim, async {
            clk.cycles(5).await;
            dut.signal("count")?.set(count)?;
            dut.signal("gap")?.set(gap)?;
            dut.signal("start")?.set(1)?;
            dut.with_timeout(Time::ms(1), dut.signal("done")?.rising_edge()).await?;
            Ok(())
        });
        prop_assert!((0..count).all(|at| memory.get(0x200 + 4 * at) == 1000 * at + 1));
        prop_assert_eq!((memory.get(0x200 + 4 * count), memory.accesses()), (0, 2 * count));
    }
}

#[test]
fn rules_of_bursts_are_checked_and_impossible_ones_refused() {
    for (fault, rule) in [(1i64, "m at 60 ns: burstcount is 0"), (2, "a read inside a burst of writes")] {
        let (mut sim, dut, clk, reset) = start(build("burst_copier").parameter("FAULT", fault), "rst");
        let _memory = avalon_mm::Memory::new(&dut, &clk, "m_", Some(reset)).unwrap();
        let result = sim.run(async {
            clk.cycles(5).await;
            dut.signal("count")?.set(5)?;
            dut.signal("gap")?.set(2)?;
            dut.signal("start")?.set(1)?;
            dut.with_timeout(Time::ms(1), dut.signal("done")?.rising_edge()).await?;
            Ok::<(), Error>(())
        });
        let said = result.unwrap_err().to_string();
        assert!(said.contains(rule), "{said}");
    }
    let (mut sim, dut, clk, _) = start(build("burst_ram"), "rst");
    let master = avalon_mm::Master::new(&dut, &clk, "mem_", 1).unwrap();
    run(&mut sim, async {
        for words in [0, 16] {
            let said = master.read_burst(0, words).await.unwrap_err().to_string();
            assert_eq!(said, format!("'mem' takes bursts of 1 to 15 words, not {words}"));
        }
        Ok(())
    });
    let (mut sim, dut, clk, _) = start(build("registers_mm"), "rst");
    let master = avalon_mm::Master::new(&dut, &clk, "csr_", 1).unwrap();
    run(&mut sim, async {
        let said = master.write_burst(0, &[1, 2], Pause::Never).await.unwrap_err().to_string();
        assert_eq!(said, "'csr' has no burstcount: one word at a time");
        Ok(())
    });
}

#[test]
fn an_axi_lite_master_reads_and_writes_with_pauses() {
    use hoverlock_harness::bus::axi_lite::Response;
    for idle in [0.0, 0.5, 0.8] {
        let (mut sim, dut, clk, _) = start(build("registers_axi"), "rst_n");
        let master = axi_lite::Master::new(&dut, &clk, "s_axi_").unwrap();
        master.set_pause(Pause::random(idle, 3));
        run(&mut sim, async {
            clk.cycles(5).await;
            for at in 0..4 {
                assert_eq!(master.write(4 * at, 0xdead_0000 + at).await?, Response::Okay);
            }
            master.write_bytes(4, 0x1234_5678, 0b1100).await?;
            assert_eq!(master.read(4).await?, (0x1234_0001, Response::Okay));
            assert_eq!(master.read(12).await?, (0xdead_0003, Response::Okay));
            assert_eq!(master.write(0x40, 1).await?, Response::SlaveError);
            assert_eq!(master.read(0x40).await?.1, Response::DecodeError);
            Ok(())
        });
    }
}

/// Drives a master's signals by hand, a list of writes for each cycle, and gives what the memories say of it.
fn caught(cycles: &[&[(&str, u64)]]) -> String {
    let (mut sim, dut, clk, reset) = start(build("wires"), "rst_n");
    let axi = axi_lite::Memory::new(&dut, &clk, "m_axi_", Some(reset.clone())).unwrap();
    let avalon = avalon_mm::Memory::new(&dut, &clk, "m_", Some(reset)).unwrap();
    // Not ready in the first cycles, so that there is something to hold.
    let late: Vec<bool> = [vec![true; 12], vec![false; 100]].concat();
    axi.set_stall(Pause::pattern(late.clone()));
    avalon.set_stall(Pause::pattern(late));
    let ended = sim.run(async {
        clk.cycles(5).await;
        for writes in cycles {
            for (name, value) in *writes {
                dut.signal(name)?.set(*value)?;
            }
            clk.rising_edge().await;
        }
        clk.cycles(2).await;
        Ok::<(), Error>(())
    });
    ended.err().map(|e| e.to_string()).unwrap_or_default()
}

#[test]
fn each_rule_of_axi_lite_and_avalon_mm_is_checked_by_name_and_time() {
    for (channel, valid, payload) in
        [("aw", "awvalid", "awaddr"), ("w", "wvalid", "wdata"), ("ar", "arvalid", "araddr")]
    {
        assert_eq!(caught(&[&[(valid, 1)], &[], &[]]), "", "{channel}: an offer that waits is well");
        // Put after the edge at 40 ns, seen at 50; taken back after 50, seen at 60.
        let fell = caught(&[&[(valid, 1)], &[(valid, 0)], &[]]);
        assert!(fell.contains(&format!("m_axi at 60 ns: {channel}: valid fell before ready came")), "{fell}");
        let changed = caught(&[&[(valid, 1)], &[], &[(payload, 8)], &[]]);
        let rule = format!("m_axi at 70 ns: {channel}: the payload changed while valid waited for ready");
        assert!(changed.contains(&rule), "{changed}");
    }
    let strobe = caught(&[&[("wvalid", 1)], &[("wstrb", 3)], &[]]);
    assert!(strobe.contains("w: the payload changed while valid waited for ready"), "{strobe}");
    assert_eq!(caught(&[&[("read", 1)], &[], &[]]), "");
    let both = caught(&[&[("read", 1), ("write", 1)], &[]]);
    assert!(both.contains("m at 50 ns: read and write together"), "{both}");
    for change in [("read", 0), ("address", 4)] {
        let changed = caught(&[&[("read", 1)], &[change], &[]]);
        assert!(changed.contains("m at 60 ns: the command changed while waitrequest was 1"), "{change:?}: {changed}");
    }
    let changed = caught(&[&[("write", 1)], &[("writedata", 1)], &[]]);
    assert!(changed.contains("the command changed while waitrequest was 1"), "{changed}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn an_axi_lite_master_agrees_with_a_model_whatever_is_paused(
        accesses in prop::collection::vec((any::<bool>(), 0u64..4, any::<u32>(), 0u64..16), 1..30),
        pause in any_pause(),
    ) {
        let (mut sim, dut, clk, _) = start(build("registers_axi"), "rst_n");
        let master = axi_lite::Master::new(&dut, &clk, "s_axi_").unwrap();
        master.set_pause(pause);
        let mut words = [0u64; 4];
        run(&mut sim, async {
            clk.cycles(5).await;
            for (write, register, data, strobe) in &accesses {
                let word = &mut words[*register as usize];
                if *write {
                    master.write_bytes(4 * register, u64::from(*data), *strobe).await?;
                    let mask = (0..4).filter(|b| strobe >> b & 1 == 1).fold(0, |m, b| m | 0xff << (8 * b));
                    *word = *word & !mask | u64::from(*data) & mask;
                }
                assert_eq!(master.read(4 * register).await?.0, *word);
            }
            Ok(())
        });
    }

    #[test]
    fn an_axi_lite_memory_serves_copies_of_every_length_whatever_stalls(count in 1u64..60, stall in any_pause()) {
        let (mut sim, dut, clk, reset) = start(build("copier_axi"), "rst_n");
        let memory = axi_lite::Memory::new(&dut, &clk, "m_axi_", Some(reset)).unwrap();
        memory.set_stall(stall);
        (0..count).for_each(|at| memory.set(4 * at, 7 * at));
        run(&mut sim, async {
            clk.cycles(5).await;
            dut.signal("count")?.set(count)?;
            dut.signal("start")?.set(1)?;
            dut.with_timeout(Time::ms(1), dut.signal("done")?.rising_edge()).await?;
            Ok(())
        });
        prop_assert!((0..count).all(|at| memory.get(1024 + 4 * at) == 7 * at + 1));
        prop_assert_eq!(memory.accesses(), 2 * count);
    }
}
