//! Transfers of whole slices: the same values as through the scheduler, for every width, latency, idle and stall.

mod common;

use common::buses::{AVALON, PERIOD, any_pause, pauses, start};
use common::{build, run, sim};
use hoverlock_harness::bus::Random;
use hoverlock_harness::bus::bulk::{Bulk, Element, Options, run_cycles};
use hoverlock_harness::bus::stream::{Dialect, Frame, Ports, Rules, Sink, Source};
use hoverlock_harness::{Error, Time};
use proptest::prelude::*;

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
        let options = Options { expect: 1, max_cycles: 100, ..Options::default() };
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
    let options = Options { expect: 11, max_cycles: 500, ..Options::default() };
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
fn buffered_writes_are_put_before_a_transfer_and_time_never_goes_back() {
    let mut sim = sim(build("counter"));
    let dut = sim.dut();
    let clock = dut.clock("clk", PERIOD).unwrap();
    let count = dut.signal("count").unwrap();
    sim.run_for(PERIOD).unwrap();
    dut.signal("enable").unwrap().set(1).unwrap();
    dut.signal("step").unwrap().set(3).unwrap();
    let timer = dut.timer(Time::ns(50));
    let waiting = dut.spawn("waiting", async move {
        timer.await;
        Ok::<(), Error>(())
    });
    sim.run_for(Time::ns(1)).unwrap();
    let before = count.get();
    dut.signal("step").unwrap().set(2).unwrap();
    run_cycles(&mut sim, &clock, 20).unwrap();
    assert_eq!(count.get(), before + 2 * 20, "each of the 20 edges saw the new step");
    let reached = dut.now();
    sim.run_for(Time::ns(1)).unwrap();
    assert!(dut.now() >= reached, "{} after {reached}", dut.now());
    assert!(dut.ending(waiting.id()).is_some(), "its time came during the transfer");
    let second = dut.clock("rst", PERIOD).unwrap();
    let refused = run_cycles(&mut sim, &clock, 1).unwrap_err().to_string();
    assert!(refused.contains("one clock is driven without the scheduler"), "{refused}");
    second.stop();
}
