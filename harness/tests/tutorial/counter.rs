use hoverlock_harness::build::Build;
use hoverlock_harness::sim::Sim;
use hoverlock_harness::{Error, Time};

#[test]
fn it_counts_and_wraps() -> Result<(), Error> {
    let library = Build::new("counter").source("tests/tutorial/counter.v").parameter("WIDTH", 4).compile()?;
    let mut sim = Sim::new(library.instance()?)?;
    let dut = sim.dut();
    dut.clock("clk", Time::ns(10))?;

    sim.run(async {
        let (clk, rst) = (dut.signal("clk")?, dut.signal("rst")?);
        let (enable, count) = (dut.signal("enable")?, dut.signal("count")?);
        rst.set(1)?;
        clk.cycles(2).await;
        rst.set(0)?;
        enable.set(1)?;
        clk.rising_edge().await; // this edge is the first that counts
        for expected in 1..40 {
            clk.rising_edge().await;
            assert_eq!(count.get(), expected % 16);
        }
        Ok::<(), Error>(())
    })
}
