//! Every bus model: length x data x idle x back-pressure x width, and every rule the checkers know, broken once.

mod common;

use common::{build, run, sim};
use hoverlock_harness::build::Build;
use hoverlock_harness::bus::bulk::{Bulk, Element, Options, run_cycles};
use hoverlock_harness::bus::stream::{Dialect, Frame, Monitor, Ports, Rules, Sink, Source};
use hoverlock_harness::bus::{Pause, Random, Reset, avalon_mm, axi_lite, axi4};
use hoverlock_harness::sim::{Dut, Signal, Sim, both};
use hoverlock_harness::{Error, Time};
use proptest::prelude::*;

const PERIOD: Time = Time::ns(10);
const AVALON: Dialect = Dialect::Avalon { ready_latency: 0 };

/// Clock running, reset given for two cycles by a task of its own.
fn start(build: Build, reset_name: &str) -> (Sim, Dut, Signal, Reset) {
    let sim = sim(build);
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    let clk = dut.signal("clk").unwrap();
    let reset = dut.signal(reset_name).unwrap();
    let high = reset_name == "rst";
    reset.set(u64::from(high)).unwrap();
    let kept = if high { Reset::high(&reset) } else { Reset::low(&reset) };
    let clock = clk.clone();
    dut.spawn("reset", async move {
        clock.cycles(3).await;
        reset.set(u64::from(!high))?;
        Ok::<(), Error>(())
    });
    (sim, dut, clk, kept)
}

fn pauses(seed: u64) -> Vec<(&'static str, Pause)> {
    vec![
        ("never", Pause::Never),
        ("every other", Pause::pattern([true, false])),
        ("bursts", Pause::pattern([false, false, false, true, true, true, true, true])),
        ("random", Pause::random(0.5, seed)),
    ]
}

/// Frames of all short lengths and some long ones, with data of several kinds.
fn frames(symbol_bits: u32, lengths: &[usize], seed: u64) -> Vec<Frame> {
    let mut random = Random::new(seed);
    let largest = u64::MAX >> (64 - symbol_bits);
    lengths
        .iter()
        .enumerate()
        .map(|(number, length)| {
            let symbols = (0..*length as u64).map(|at| match number % 4 {
                0 => at & largest,
                1 => largest,
                2 => 0,
                _ => random.bits() & largest,
            });
            Frame { symbols: symbols.collect(), ..Frame::default() }
        })
        .collect()
}

#[test]
fn avalon_streams_of_every_length_idle_stall_latency_and_width() {
    // Width, bits of `empty`, lengths that fill beats or not.
    for (width, empty, latency) in [(8, 1, 0), (32, 2, 0), (128, 4, 0), (32, 2, 1), (128, 4, 3)] {
        let design =
            build("avalon_fifo").parameter("WIDTH", width).parameter("EMPTY", empty).parameter("LATENCY", latency);
        let lengths: Vec<usize> = (1..=9).chain([16, 31, 64, 100]).collect();
        let mut sent = frames(8, &lengths, u64::from(width as u32));
        for (number, frame) in sent.iter_mut().enumerate() {
            frame.channel = number as u64 % 16;
            frame.error = u64::from(number % 3 == 0);
        }
        for (idle_name, idle) in pauses(1) {
            for (stall_name, stall) in pauses(2) {
                let (mut sim, dut, clk, reset) = start(design.clone(), "rst");
                let dialect = Dialect::Avalon { ready_latency: latency as u32 };
                let input = Ports::find(&dut, "in_", dialect).unwrap();
                let output = Ports::find(&dut, "out_", dialect).unwrap();
                let source = Source::new(&dut, &clk, input.clone(), Some(reset.clone())).unwrap();
                let monitor = Monitor::new(&dut, &clk, input, Some(reset.clone()), Rules::Strict).unwrap();
                let sink = Sink::new(&dut, &clk, output, Some(reset), Rules::Strict).unwrap();
                source.set_pause(idle.clone());
                sink.set_pause(stall);
                run(&mut sim, async {
                    for frame in &sent {
                        source.send(frame)?;
                    }
                    let received = async {
                        for expected in &sent {
                            let frame = sink.recv().await;
                            assert_eq!(&frame, expected, "{width} bits, idle {idle_name}, stall {stall_name}");
                        }
                    };
                    dut.with_timeout(Time::ms(1), received).await?;
                    Ok(())
                });
                assert_eq!((monitor.len(), monitor.beats()), (sent.len(), source.sent()));
                assert_eq!(source.pending(), 0);
            }
        }
    }
}

#[test]
fn axi_streams_through_a_width_adapter_of_every_ratio() {
    for (s, m) in [(1, 1), (4, 2), (3, 5), (1, 8), (64, 8)] {
        let design = build("axis_adapter").parameter("S", s).parameter("M", m);
        let lengths: Vec<usize> = (1..=10).chain([63, 64, 65, 128]).collect();
        let mut sent = frames(8, &lengths, s as u64);
        for (number, frame) in sent.iter_mut().enumerate() {
            frame.error = number as u64 % 2;
        }
        for (idle_name, idle) in pauses(3) {
            for (stall_name, stall) in pauses(4) {
                let (mut sim, dut, clk, reset) = start(design.clone(), "rst_n");
                let input = Ports::find(&dut, "s_axis_", Dialect::Axi).unwrap();
                assert_eq!(input.lanes(), s as u32);
                let source = Source::new(&dut, &clk, input, Some(reset.clone())).unwrap();
                let output = Ports::find(&dut, "m_axis_", Dialect::Axi).unwrap();
                let sink = Sink::new(&dut, &clk, output, Some(reset), Rules::Strict).unwrap();
                source.set_pause(idle.clone());
                sink.set_pause(stall);
                run(&mut sim, async {
                    sent.iter().try_for_each(|frame| source.send(frame))?;
                    for expected in &sent {
                        let frame = dut.with_timeout(Time::ms(1), sink.recv()).await?;
                        assert_eq!(&frame, expected, "{s} to {m} bytes, idle {idle_name}, stall {stall_name}");
                    }
                    source.drained().await;
                    Ok(())
                });
            }
        }
    }
}

#[test]
fn a_stream_without_packets_gives_symbols() {
    let (mut sim, dut, clk, reset) = start(build("fifo").parameter("WIDTH", 12), "rst");
    let source = Source::new(&dut, &clk, Ports::find(&dut, "in_", AVALON).unwrap(), Some(reset.clone())).unwrap();
    let sink = Sink::new(&dut, &clk, Ports::find(&dut, "out_", AVALON).unwrap(), Some(reset), Rules::Strict).unwrap();
    sink.set_pause(Pause::random(0.3, 9));
    let symbols: Vec<u16> = (0..500).map(|n| n * 7 % 4096).collect();
    run(&mut sim, async {
        source.send(&Frame::new(&symbols))?;
        let mut got = sink.recv_symbols(300).await;
        got.extend(sink.recv_symbols(200).await);
        assert!(got.iter().zip(&symbols).all(|(a, b)| *a == u64::from(*b)));
        Ok(())
    });
}

#[test]
fn a_frame_that_cannot_be_sent_is_refused() {
    let (_sim, dut, clk, _) = start(build("avalon_fifo"), "rst");
    let ports = Ports::find(&dut, "in_", AVALON).unwrap();
    let source = Source::new(&dut, &clk, ports.clone(), None).unwrap();
    assert!(source.send(&Frame::default()).unwrap_err().to_string().contains("without symbols"));
    assert!(source.send(&Frame::new(&[256u16])).unwrap_err().to_string().contains("symbol 256 does not fit 8 bits"));
    assert!(source.send(&Frame::new(&[1u8]).on_channel(16)).unwrap_err().to_string().contains("channel 16"));
    assert!(ports.clone().symbols_of(7).is_err());
    assert_eq!(ports.symbols_of(16).unwrap().lanes(), 2);
    assert!(Source::new(&dut, &clk, Ports::find(&dut, "out_", AVALON).unwrap(), None).is_err(), "an output");
    assert!(Ports::find(&dut, "inn_", AVALON).is_err());
}

/// Drives the inputs of the FIFO by hand for some cycles under a monitor, and gives the first rule broken.
fn broken(latency: u32, cycles: &[&[(&str, u64)]]) -> Option<String> {
    let (mut sim, dut, clk, reset) = start(build("avalon_fifo").parameter("LATENCY", latency), "rst");
    let ports = Ports::find(&dut, "in_", Dialect::Avalon { ready_latency: latency }).unwrap();
    let monitor = Monitor::new(&dut, &clk, ports, Some(reset), Rules::Recorded).unwrap();
    run(&mut sim, async {
        clk.cycles(6).await;
        for writes in cycles {
            for (name, value) in *writes {
                dut.signal(name)?.set(*value)?;
            }
            clk.rising_edge().await;
        }
        clk.cycles(2).await;
        Ok(())
    });
    monitor.violations().first().map(|v| v.to_string())
}

#[test]
fn each_rule_of_avalon_st_is_checked_by_name_and_time() {
    let sop = ("in_startofpacket", 1);
    let eop = ("in_endofpacket", 1);
    let (on, off) = (("in_valid", 1), ("in_valid", 0));
    assert_eq!(broken(0, &[&[on, sop, eop], &[off]]), None);
    assert_eq!(broken(0, &[&[on, eop], &[off]]).unwrap(), "in at 60 ns: a beat outside of a packet: no startofpacket");
    let twice = broken(0, &[&[on, sop], &[], &[off]]).unwrap();
    assert!(twice.ends_with("startofpacket inside a packet"), "{twice}");
    let early = broken(0, &[&[on, sop, ("in_empty", 1)], &[off]]).unwrap();
    assert!(early.ends_with("empty is 1 before endofpacket"), "{early}");
    let hop = broken(0, &[&[on, sop], &[("in_startofpacket", 0), ("in_channel", 3)], &[off]]).unwrap();
    assert!(hop.ends_with("channel changed inside a packet"), "{hop}");
    // The FIFO fills up (nobody takes from it): then the beat waits.
    let fill: &[(&str, u64)] = &[on, sop, eop];
    let give_up = [off];
    let mut wait = vec![fill; 17];
    wait.push(&give_up);
    assert!(broken(0, &wait).unwrap().ends_with("valid fell before ready came"));
    wait.pop();
    wait.push(&[("in_data", 77)]);
    assert!(broken(0, &wait).unwrap().ends_with("the beat changed while valid waited for ready"));
    let late = vec![fill; 20];
    assert!(broken(2, &late).unwrap().ends_with("valid without ready 2 cycles before"));
}

#[test]
fn a_strict_rule_ends_the_run() {
    let (mut sim, dut, clk, reset) = start(build("avalon_fifo"), "rst");
    let _monitor =
        Monitor::new(&dut, &clk, Ports::find(&dut, "in_", AVALON).unwrap(), Some(reset), Rules::Strict).unwrap();
    let result = sim.run(async {
        clk.cycles(5).await;
        dut.signal("in_valid")?.set(1)?;
        clk.cycles(5).await;
        Ok::<(), Error>(())
    });
    match result {
        Err(Error::Protocol(violation)) => assert_eq!((violation.bus.as_str(), violation.time), ("in", Time::ns(50))),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_fault_in_a_fifo_is_found() {
    // With FAULT it says ready while it is full: the word written over is the one that waits at the output.
    let lost = |fault: u64| {
        let (mut sim, dut, clk, reset) = start(build("fifo").parameter("FAULT", fault), "rst");
        let source = Source::new(&dut, &clk, Ports::find(&dut, "in_", AVALON).unwrap(), Some(reset.clone())).unwrap();
        let sink =
            Sink::new(&dut, &clk, Ports::find(&dut, "out_", AVALON).unwrap(), Some(reset), Rules::Strict).unwrap();
        sink.set_pause(Pause::random(0.7, 1));
        let sent: Vec<u64> = (0..100).collect();
        sim.run(async {
            source.send(&Frame::new(&sent))?;
            Ok::<_, Error>(sink.recv_symbols(100).await)
        })
        .map(|got| got == sent)
    };
    assert!(lost(0).unwrap());
    let text = lost(1).unwrap_err().to_string();
    assert!(text.contains("out at") && text.contains("the beat changed while valid waited for ready"), "{text}");
}

#[test]
fn bulk_gives_what_the_scheduler_gives_whatever_idles_and_stalls() {
    let words: Vec<u8> = (0..3000u32).map(|n| (n * 31 % 251) as u8).collect();
    for (idle_name, idle) in pauses(5) {
        for (stall_name, stall) in pauses(6) {
            let (mut sim, dut, clk, reset) = start(build("stream"), "rst");
            let source =
                Source::new(&dut, &clk, Ports::find(&dut, "in_", AVALON).unwrap(), Some(reset.clone())).unwrap();
            let output = Ports::find(&dut, "out_", AVALON).unwrap().symbols_of(16).unwrap();
            let sink = Sink::new(&dut, &clk, output, Some(reset), Rules::Strict).unwrap();
            source.set_pause(idle.clone());
            sink.set_pause(stall.clone());
            let mut expected: Vec<u16> = Vec::new();
            run(&mut sim, async {
                for packet in words.chunks(1000) {
                    source.send(&Frame::new(packet))?;
                }
                for _ in 0..3 {
                    expected.extend(sink.recv().await.symbols.iter().map(|s| *s as u16));
                }
                Ok(())
            });

            let mut sim = common::sim(build("stream"));
            let dut = sim.dut();
            let clock = dut.clock("clk", PERIOD).unwrap();
            dut.signal("rst").unwrap().set(1).unwrap();
            sim.run_for(PERIOD * 2).unwrap();
            dut.signal("rst").unwrap().set(0).unwrap();
            sim.run_for(PERIOD).unwrap();
            let mut bulk = Bulk::<u8, u16>::new(&dut, &clock, "in_", "out_", AVALON).unwrap();
            let options =
                Options { idle: idle.clone(), stall, packet: 1000, expect: words.len(), ..Options::default() };
            let mut received = Vec::new();
            let report = bulk.transfer(&mut sim, &words, &mut received, &options).unwrap();
            assert_eq!(received, expected, "idle {idle_name}, stall {stall_name}");
            assert_eq!((report.sent, report.received, report.packets), (3000, 3000, 3));
            // Time went on, and the clock runs on from there.
            assert!(dut.now() >= PERIOD * report.cycles);
            let before = dut.now();
            run(&mut sim, async {
                dut.signal("clk")?.rising_edge().await;
                assert_eq!(dut.now() - before, Time::ns(5));
                Ok(())
            });
        }
    }
}

fn any_pause() -> impl Strategy<Value = Pause> {
    prop_oneof![
        Just(Pause::Never),
        (0.05f64..0.95, any::<u64>()).prop_map(|(p, seed)| Pause::random(p, seed)),
        prop::collection::vec(any::<bool>(), 1..12).prop_map(Pause::pattern),
    ]
}

/// Words of a slice through a FIFO of some width and ready latency: what comes out is what went in.
fn through_in_bulk<T: Element>(
    width: u64,
    latency: u64,
    parts: usize,
    words: &[T],
    options: &Options,
) -> (Vec<T>, usize) {
    let design = build("avalon_fifo").parameter("WIDTH", width).parameter("EMPTY", 5).parameter("LATENCY", latency);
    let mut sim = sim(design);
    let dut = sim.dut();
    let clock = dut.clock("clk", PERIOD).unwrap();
    dut.signal("rst").unwrap().set(1).unwrap();
    sim.run_for(PERIOD * 2).unwrap();
    dut.signal("rst").unwrap().set(0).unwrap();
    sim.run_for(PERIOD).unwrap();
    let dialect = Dialect::Avalon { ready_latency: latency as u32 };
    let mut bulk = Bulk::<T, T>::new(&dut, &clock, "in_", "out_", dialect).unwrap();
    assert_eq!(bulk.parts(), (parts, parts));
    let mut received = Vec::new();
    let report = bulk.transfer(&mut sim, words, &mut received, options).unwrap();
    assert_eq!((report.sent, report.received), (words.len() / parts, words.len() / parts));
    (received, report.packets)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn bulk_moves_words_of_every_width_and_latency(
        wide in 0usize..4,
        latency in prop::sample::select(vec![0u64, 1, 3]),
        words in 1usize..300,
        packet in 1usize..40,
        (idle, stall) in (any_pause(), any_pause()),
        seed in any::<u64>(),
    ) {
        let mut random = Random::new(seed);
        let packets = words.div_ceil(packet);
        let options = Options { idle, stall, packet, packets, ..Options::default() };
        macro_rules! check {
            ($type:ty, $width:expr, $parts:expr) => {{
                let sent: Vec<$type> = (0..words * $parts).map(|_| random.bits() as $type).collect();
                let (received, ended) = through_in_bulk($width, latency, $parts, &sent, &options);
                prop_assert_eq!(received, sent);
                prop_assert_eq!(ended, packets);
            }};
        }
        match wide {
            0 => check!(u8, 8, 1),
            1 => check!(u64, 64, 1),
            2 => check!(u32, 128, 4),
            _ => check!(u32, 256, 8),
        }
    }
}

#[test]
fn wide_words_that_do_not_fit_are_refused_in_bulk() {
    let mut sim = sim(build("avalon_fifo").parameter("WIDTH", 72).parameter("EMPTY", 4));
    let dut = sim.dut();
    let clock = dut.clock("clk", PERIOD).unwrap();
    sim.run_for(PERIOD).unwrap();
    let mut bulk = Bulk::<u32, u32>::new(&dut, &clock, "in_", "out_", AVALON).unwrap();
    let mut send = |words: &[u32]| {
        let options = Options { expect: 1, most_cycles: 100, ..Options::default() };
        let mut received = Vec::new();
        bulk.transfer(&mut sim, words, &mut received, &options).map(|_| received).map_err(|e| e.to_string())
    };
    assert_eq!(send(&[1, 2, 0xff]), Ok(vec![1, 2, 0xff]));
    assert!(send(&[1, 2, 0x100]).unwrap_err().contains("the element 256 does not fit `data`"));
    assert!(send(&[1, 2]).unwrap_err().contains("2 elements make no whole beats of 3 elements"));
    let far = Dialect::Avalon { ready_latency: 65 };
    let error = Bulk::<u32, u32>::new(&dut, &clock, "in_", "out_", far).err().unwrap().to_string();
    assert!(error.contains("at most 64 cycles"), "{error}");
}

#[test]
fn bulk_that_cannot_end_says_so_and_wrong_types_are_refused() {
    let mut sim = sim(build("stream"));
    let dut = sim.dut();
    let clock = dut.clock("clk", PERIOD).unwrap();
    sim.run_for(PERIOD).unwrap();
    let mut bulk = Bulk::<u8, u16>::new(&dut, &clock, "in_", "out_", AVALON).unwrap();
    let options = Options { expect: 11, most_cycles: 500, ..Options::default() };
    let error = bulk.transfer(&mut sim, &[1; 10], &mut Vec::new(), &options).unwrap_err().to_string();
    assert!(error.contains("did not end within 500 cycles: 10 of 10 beats taken, 10 of 11 given"), "{error}");
    let error = Bulk::<u16, u16>::new(&dut, &clock, "in_", "out_", AVALON).err().unwrap().to_string();
    assert!(error.contains("its elements are of 8 bits, not of 16 bits"), "{error}");
    let before = dut.now();
    run_cycles(&mut sim, &clock, 1000).unwrap();
    assert_eq!(dut.now() - before, PERIOD * 1000);
}

#[test]
fn what_the_verilog_says_in_bulk_is_heard_and_only_errors_end_it() {
    for (command, ends) in [(1u64, None), (2, Some("something is off")), (3, Some("called $finish at"))] {
        let mut sim = sim(build("talks"));
        let dut = sim.dut();
        let clock = dut.clock("clk", PERIOD).unwrap();
        let line = dut.signal("command").unwrap();
        sim.run_for(PERIOD).unwrap();
        run(&mut sim, async {
            dut.signal("clk")?.falling_edge().await;
            line.set(command)?;
            Ok(())
        });
        let before = dut.now();
        let result = run_cycles(&mut sim, &clock, 10).map_err(|e| e.to_string());
        match ends {
            None => {
                assert_eq!((result, dut.now() - before), (Ok(()), PERIOD * 10));
                let heard: Vec<Time> =
                    sim.log().iter().filter(|l| l.text.starts_with("hello")).map(|l| l.time).collect();
                assert_eq!(heard.len(), 10);
                assert_eq!(heard[9] - heard[0], PERIOD * 9);
            }
            Some(text) => assert!(result.unwrap_err().contains(text)),
        }
    }
}

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
                assert_eq!(answer, axi_lite::Response::Okay, "{name}");
                assert_eq!(master.read_burst(address, length).await?, (words, axi_lite::Response::Okay), "{name}");
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
