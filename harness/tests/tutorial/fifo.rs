use hoverlock_harness::build::Build;
use hoverlock_harness::bus::stream::{Dialect, Frame, Ports, Rules, Sink, Source};
use hoverlock_harness::bus::{Pause, Reset};
use hoverlock_harness::sim::Sim;
use hoverlock_harness::wave::Recording;
use hoverlock_harness::{Error, Time};

/// Sends 100 bytes through the FIFO and returns what comes out.
fn pass_bytes(stall: Pause, waves: &str) -> Result<Vec<u64>, Error> {
    let library = Build::new("fifo").source("tests/tutorial/fifo.v").internal("level").compile()?;
    let mut sim = Sim::new(library.instance()?)?;
    let dut = sim.dut();
    dut.clock("clk", Time::ns(10))?;
    let (clk, rst) = (dut.signal("clk")?, dut.signal("rst")?);
    let avalon = Dialect::Avalon { ready_latency: 0 };
    let reset = Some(Reset::high(&rst));
    let source = Source::new(&dut, &clk, Ports::find(&dut, "in_", avalon)?, reset.clone())?;
    let sink = Sink::new(&dut, &clk, Ports::find(&dut, "out_", avalon)?, reset, Rules::Strict)?;
    sink.set_pause(stall);
    dut.start_waves(&Recording::before_failure(waves, Vec::<String>::new(), 40))?;
    sim.run(async {
        rst.set(1)?;
        clk.cycles(2).await;
        rst.set(0)?;
        source.send(&Frame::new(&(0..100u8).collect::<Vec<_>>()))?;
        Ok::<_, Error>(dut.with_timeout(Time::us(100), sink.recv_symbols(100)).await?)
    })
}

#[test]
fn bytes_pass_without_stalls() -> Result<(), Error> {
    assert_eq!(pass_bytes(Pause::Never, "never.vcd")?, (0..100).collect::<Vec<u64>>());
    Ok(())
}

#[test]
fn a_stalled_sink_finds_the_bug() {
    let waves = std::env::temp_dir().join("fifo.vcd");
    let error = pass_bytes(Pause::random(0.7, 1), &waves.to_string_lossy()).unwrap_err();
    assert!(error.to_string().contains("the beat changed while valid waited for ready"));
    assert!(waves.exists()); // the last 20 cycles; fifo.gtkw beside it is a view for GTKWave
}
