//! AXI4: the memory and the checker, against small designs and against each other through wires.

mod common;

use common::buses::{pauses, start};
use common::{build, run, sim};
use hoverlock_harness::bus::axi_lite::Response;
use hoverlock_harness::bus::{Pause, Random, Reset, axi4};
use hoverlock_harness::sim::{Dut, Sim, both};
use hoverlock_harness::{Error, Time};

fn begin(sim: &Sim) -> Dut {
    let dut = sim.dut();
    dut.clock("clk", Time::ns(10)).unwrap();
    dut
}

/// After an edge, sets signals by name, waits for an edge, and so on.
async fn drive(dut: &Dut, steps: &[&[(&str, u64)]]) {
    let clk = dut.signal("clk").unwrap();
    clk.rising_edge().await;
    for step in steps {
        for (name, value) in *step {
            dut.signal(name).unwrap().set(*value).unwrap();
        }
        clk.rising_edge().await;
    }
    clk.cycles(4).await;
}

/// The rule that a run of `drive` ends with.
fn broken(watch: impl Fn(&Dut), steps: &[&[(&str, u64)]]) -> String {
    let mut sim = sim(build("axi4_wires"));
    let dut = begin(&sim);
    watch(&dut);
    let end = sim.run(async {
        drive(&dut, steps).await;
        Ok::<(), Error>(())
    });
    end.err().map(|e| e.to_string()).unwrap_or_default()
}

#[test]
fn an_axi4_memory_answers_bursts_of_any_length() {
    for stall in [Pause::Never, Pause::random(0.4, 3)] {
        let mut sim = sim(build("axi4_wires"));
        let dut = begin(&sim);
        let clk = dut.signal("clk").unwrap();
        let reset = Some(Reset::high(&dut.signal("rst").unwrap()));
        let memory = axi4::Memory::new(&dut, &clk, "m_axi_", reset.clone()).unwrap();
        let checker = axi4::Checker::new(&dut, &clk, "s_axi_", reset).unwrap();
        let master = axi4::Master::new(&dut, &clk, "s_axi_").unwrap();
        memory.set_stall(stall.clone());
        master.set_pause(stall);
        run(&mut sim, async {
            let mut at = 0;
            for count in [1, 2, 16, 256] {
                let words: Vec<u64> = (0..count).map(|n| 0xa000_0000 + at + n).collect();
                let base = 0x1000 + 4 * at / 0x1000 * 0x1000 + 0x400 * (count % 7);
                assert_eq!(master.write_burst(base, &words).await?, Response::Okay);
                assert_eq!((memory.get(base), memory.get(base + 4 * (count - 1))), (words[0], words[words.len() - 1]));
                assert_eq!(master.read_burst(base, words.len()).await?, (words, Response::Okay));
                at += count;
            }
            Ok(())
        });
        assert_eq!((memory.accesses(), checker.bursts()), (2 * 275, (4, 4)));
    }
}

/// A burst of two beats on the write channels.
const ADDRESS: &[(&str, u64)] = &[
    ("s_axi_awvalid", 1),
    ("s_axi_awlen", 1),
    ("s_axi_awsize", 2),
    ("s_axi_awburst", 1),
    ("s_axi_arsize", 2),
    ("s_axi_wstrb", 15),
];

#[test]
fn an_axi4_memory_takes_wrapping_fixed_and_narrow_bursts() {
    let mut sim = sim(build("axi4_wires"));
    let dut = begin(&sim);
    let memory = axi4::Memory::new(&dut, &dut.signal("clk").unwrap(), "m_axi_", None).unwrap();
    run(&mut sim, async {
        let name = |name: &'static str, value| (name, value);
        let stop: &[(&str, u64)] = &[("s_axi_awvalid", 0), ("s_axi_wvalid", 0), ("s_axi_wlast", 0)];
        let beat = |data, strobe, last| {
            [
                name("s_axi_awvalid", 0),
                name("s_axi_wvalid", 1),
                name("s_axi_wdata", data),
                name("s_axi_wstrb", strobe),
                name("s_axi_wlast", last),
            ]
        };
        drive(&dut, &[&[("s_axi_bready", 1)]]).await;
        // Wrapping: from the second word of two on.
        let wrap = [ADDRESS, &[("s_axi_awburst", 2), ("s_axi_awaddr", 0x104)]].concat();
        drive(&dut, &[&wrap, &beat(1, 15, 0), &beat(2, 15, 1), stop]).await;
        assert_eq!((memory.get(0x104), memory.get(0x100)), (1, 2));
        // Fixed: both to one word.
        let fixed = [ADDRESS, &[("s_axi_awburst", 0), ("s_axi_awaddr", 0x200)]].concat();
        drive(&dut, &[&fixed, &beat(0x11, 1, 0), &beat(0x2200, 2, 1), stop]).await;
        assert_eq!((memory.get(0x200), memory.get(0x204)), (0x2211, 0));
        // Narrow: two bytes of one word, at 0x301.
        let narrow = [ADDRESS, &[("s_axi_awsize", 0), ("s_axi_awaddr", 0x301)]].concat();
        drive(&dut, &[&narrow, &beat(0x4400, 2, 0), &beat(0x55_0000, 4, 1), stop]).await;
        assert_eq!(memory.get(0x300), 0x55_4400);
        Ok(())
    });
}

#[test]
fn an_axi4_memory_checks_its_master() {
    let stalled = |dut: &Dut, pattern: &[bool]| {
        let memory = axi4::Memory::new(dut, &dut.signal("clk").unwrap(), "m_axi_", None).unwrap();
        memory.set_stall(Pause::pattern(pattern));
    };
    let memory = |dut: &Dut| stalled(dut, &[false]);
    let with = |more: &[(&'static str, u64)]| [ADDRESS, more].concat();
    let beat: &[(&str, u64)] = &[("s_axi_awvalid", 0), ("s_axi_wvalid", 1)];
    let early: &[(&str, u64)] = &[("s_axi_wvalid", 1), ("s_axi_wlast", 1)];
    let crossing = with(&[("s_axi_awaddr", 0xffc)]);
    let three = with(&[("s_axi_awburst", 2), ("s_axi_awlen", 2)]);
    let reserved = with(&[("s_axi_awburst", 3)]);
    type Steps<'a> = Vec<&'a [(&'a str, u64)]>;
    let cases: [(Steps, &str); 7] = [
        (vec![&[], ADDRESS, beat, &[("s_axi_wlast", 0)], &[]], "wlast is 0 at beat 2 of 2"),
        (vec![&[], ADDRESS, early, &[("s_axi_awvalid", 0), ("s_axi_wvalid", 0)]], "wlast is 1 at beat 1 of 2"),
        (vec![&crossing], "aw: 2 beats from 0xffc on cross a multiple of 4 KiB"),
        (vec![&three], "aw: a wrapping burst of 3 beats"),
        (vec![&reserved], "aw: burst is 3, which is reserved"),
        (vec![ADDRESS, &[("s_axi_awvalid", 0)]], "aw: valid fell before ready came"),
        (vec![ADDRESS, &[("s_axi_awaddr", 4)]], "aw: the payload changed while valid waited for ready"),
    ];
    for (steps, rule) in cases {
        // An offer must stay while it is not taken.
        let waits = rule.contains("ready");
        let message = broken(|dut| stalled(dut, &[waits, waits, waits, waits, false]), &steps);
        assert!(message.contains("m_axi at ") && message.ends_with(rule), "{rule}: '{message}'");
    }
    let narrow = with(&[("s_axi_awsize", 0), ("s_axi_wvalid", 1), ("s_axi_wstrb", 3)]);
    assert!(broken(memory, &[&narrow, &[], &[]]).contains("wstrb is 0b11 in a beat at 0x0 whose bytes are 0b1"));
}

#[test]
fn an_axi4_checker_finds_the_faults_of_a_slave() {
    for (fault, rule) in
        [(0, ""), (1, "rlast is 1 at beat"), (3, "of id"), (4, "the payload changed"), (5, "r: valid fell")]
    {
        let mut sim = sim(build("ram_axi4").parameter("FAULT", fault).parameter("STALL", 0));
        let dut = begin(&sim);
        let clk = dut.signal("clk").unwrap();
        drop(axi4::Checker::new(&dut, &clk, "s_axi_", Some(Reset::high(&dut.signal("rst").unwrap()))).unwrap());
        let master = axi4::Master::new(&dut, &clk, "s_axi_").unwrap();
        master.set_pause(Pause::pattern([true, true, false]));
        let end = sim.run(async {
            dut.signal("rst")?.set(1)?;
            clk.cycles(2).await;
            dut.signal("rst")?.set(0)?;
            clk.cycles(1).await;
            master.write_burst(0x40, &[1, 2, 3, 4]).await?;
            master.read_burst(0x40, 4).await.map(|_| ())
        });
        let message = end.err().map(|e| e.to_string()).unwrap_or_default();
        assert!(message.contains(rule) && message.is_empty() == rule.is_empty(), "fault {fault}: '{message}'");
    }
}

#[test]
fn an_axi4_master_bursts_of_every_length_stall_and_pause() {
    for (stall, (name, pause)) in [0i64, 1].into_iter().flat_map(|s| pauses(5).into_iter().map(move |p| (s, p))) {
        let (mut sim, dut, clk, _) = start(build("ram_axi4").parameter("STALL", stall), "rst");
        let mut random = Random::new(3);
        run(&mut sim, async {
            clk.cycles(5).await;
            let master = axi4::Master::new(&dut, &clk, "s_axi_")?;
            master.set_pause(pause);
            for (address, length) in [(0x0u64, 1usize), (0x10, 2), (0x40, 16), (0x100, 256), (0xffc, 1)] {
                let words: Vec<u64> = (0..length).map(|_| random.bits() & 0xffff_ffff).collect();
                let answer = master.write_burst(address, &words).await?;
                assert_eq!(answer, Response::Okay, "{name}");
                assert_eq!(master.read_burst(address, length).await?, (words, Response::Okay), "{name}");
            }
            // A write and a read at the same time.
            let (written, read) = both(master.write_burst(0x800, &[1, 2, 3]), master.read_burst(0x40, 4)).await;
            written?;
            assert_eq!(read?.0.len(), 4);
            assert_eq!(master.read_burst(0x800, 3).await?.0, [1, 2, 3]);
            for (address, beats, said) in [
                (0, 0, "'s_axi' takes bursts of 1 to 256 beats, not 0"),
                (0, 257, "'s_axi' takes bursts of 1 to 256 beats, not 257"),
                (2, 1, "'s_axi': a burst begins at a multiple of 4, not at 0x2"),
                (0xff8, 3, "'s_axi': 3 beats from 0xff8 on cross a multiple of 4 KiB"),
            ] {
                assert_eq!(master.read_burst(address, beats).await.unwrap_err().to_string(), said);
            }
            Ok(())
        });
    }
}

#[test]
fn rules_of_an_axi4_slave_are_checked() {
    for (fault, rule) in [
        (1i64, "rlast is 1 at beat 3 of 4"),
        (2, "bvalid before the last beat was taken"),
        (3, "bid is 15, not 0"),
        (4, "r: the payload changed while valid waited for ready"),
        (5, "r: valid fell before ready came"),
    ] {
        let (mut sim, dut, clk, _) = start(build("ram_axi4").parameter("FAULT", fault), "rst");
        let ended = sim.run(async {
            clk.cycles(5).await;
            let master = axi4::Master::new(&dut, &clk, "s_axi_")?;
            master.set_pause(Pause::pattern([false, true, true]));
            master.write_burst(0, &[1, 2, 3, 4]).await?;
            master.read_burst(0, 4).await?;
            Ok::<(), Error>(())
        });
        let said = ended.unwrap_err().to_string();
        assert!(said.starts_with("s_axi at ") && said.ends_with(rule), "fault {fault}: {said}");
    }
}
