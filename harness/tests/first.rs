use hoverlock_harness::build::Build;
use hoverlock_harness::sim::Sim;
use hoverlock_harness::{Error, Time};
#[test]
fn counter_counts() -> Result<(), Error> {
    let library = Build::new("counter").source("tests/designs/counter.v").parameter("WIDTH", 8).compile()?;
    let t = std::time::Instant::now();
    let mut sim = Sim::new(library.instance()?)?;
    let dut = sim.dut();
    dut.clock("clk", Time::ns(10))?;
    let (clk, count) = (dut.signal("clk")?, dut.signal("count")?);
    let (rst, enable, step) = (dut.signal("rst")?, dut.signal("enable")?, dut.signal("step")?);
    sim.run(async {
        rst.set(1)?;
        clk.cycles(2).await;
        rst.set(0)?;
        enable.set(1)?;
        step.set(3)?;
        clk.rising_edge().await;
        for i in 0..1000u64 {
            clk.rising_edge().await;
            assert_eq!(count.get(), (i + 1) * 3 % 256);
        }
        Ok::<(), Error>(())
    })?;
    println!("{:?}", t.elapsed());
    let n = 2_000_000u64;
    let t = std::time::Instant::now();
    sim.run(async {
        let mut x = 0;
        for _ in 0..n {
            clk.rising_edge().await;
            step.set(count.get())?;
            x ^= count.get();
        }
        println!("{x}");
        Ok::<(), Error>(())
    })?;
    println!("{} Mcycles/s", n as f64 / t.elapsed().as_secs_f64() / 1e6);
    Ok(())
}
