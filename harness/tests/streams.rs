//! Avalon-ST and AXI4-Stream: length x data x idle x back-pressure x width, and every rule of the checker, broken once.

mod common;

use common::buses::{AVALON, frames, pauses, start};
use common::{build, run};
use hoverlock_harness::bus::Pause;
use hoverlock_harness::bus::stream::{Dialect, Frame, Monitor, Ports, Rules, Sink, Source};
use hoverlock_harness::{Error, Time};

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
fn a_reset_inside_a_packet_drops_it_on_both_sides() {
    for strict in [Rules::Strict, Rules::Recorded] {
        let (mut sim, dut, clk, reset) = start(build("avalon_fifo").parameter("WIDTH", 8).parameter("EMPTY", 1), "rst");
        let source = Source::new(&dut, &clk, Ports::find(&dut, "in_", AVALON).unwrap(), Some(reset.clone())).unwrap();
        let sink = Sink::new(&dut, &clk, Ports::find(&dut, "out_", AVALON).unwrap(), Some(reset), strict).unwrap();
        let rst = dut.signal("rst").unwrap();
        let second = Frame::new(&[100u8, 101, 102, 103]);
        run(&mut sim, async {
            clk.cycles(5).await;
            source.send(&Frame::new(&(0u8..16).collect::<Vec<_>>()))?;
            source.send(&second)?;
            clk.cycles(8).await;
            assert!(source.sent() > 2 && source.pending() > 4, "the reset comes inside the first packet");
            rst.set(1)?;
            clk.cycles(3).await;
            rst.set(0)?;
            assert_eq!(source.pending(), 4, "the second packet alone");
            assert_eq!(dut.with_timeout(Time::us(1), sink.recv()).await?, second);
            dut.with_timeout(Time::us(1), source.drained()).await?;
            Ok(())
        });
        assert!(sink.violations().is_empty(), "{:?}", sink.violations());
    }
}

#[test]
fn a_ready_latency_of_more_cycles_than_are_kept_is_refused() {
    let sim = common::sim(build("avalon_fifo"));
    let found = Ports::find(&sim.dut(), "in_", Dialect::Avalon { ready_latency: 65 });
    assert!(found.err().unwrap().to_string().contains("at most 64 cycles"));
    assert!(Ports::find(&sim.dut(), "in_", Dialect::Avalon { ready_latency: 64 }).is_ok());
}
