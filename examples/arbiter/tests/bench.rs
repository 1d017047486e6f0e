//! Compares the Verilog with the model, and checks that nobody waits for longer than one round.

use arbiter::Arbiter;
use hoverlock_harness::build::Build;
use hoverlock_harness::sim::Sim;
use hoverlock_harness::{Error, Time};

const REQUESTS: u32 = 4;

/// Applies `requests`, one in each clock, and returns the grants.
fn grants(requests: &[u64]) -> Result<Vec<u64>, Error> {
    let design = Build::new("arbiter").source("verilog/arbiter.v").parameter("N", REQUESTS).compile()?;
    let mut sim = Sim::new(design.instance()?)?;
    let dut = sim.dut();
    dut.clock("clk", Time::ns(10))?;
    let (clk, rst) = (dut.signal("clk")?, dut.signal("rst")?);
    let (request, grant) = (dut.signal("request")?, dut.signal("grant")?);
    sim.run(async {
        rst.set(1)?;
        clk.cycles(2).await;
        rst.set(0)?;
        let mut seen = Vec::new();
        for &value in requests {
            request.set(value)?;
            clk.rising_edge().await; // this edge samples the request
            dut.read_only().await;
            seen.push(grant.get());
            clk.falling_edge().await;
        }
        Ok::<_, Error>(seen)
    })
}

#[test]
fn grants_follow_the_model() -> Result<(), Error> {
    // A multiplicative generator: the requests are the same in every run.
    let mut state = 1u64;
    let requests: Vec<u64> = (0..1000)
        .map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            state >> 60
        })
        .collect();
    let mut model = Arbiter::new(REQUESTS);
    let expected: Vec<u64> = requests.iter().map(|&request| model.grant(request)).collect();
    assert_eq!(grants(&requests)?, expected);
    Ok(())
}

#[test]
fn nobody_waits_for_longer_than_a_round() -> Result<(), Error> {
    let seen = grants(&[0b1111; 40])?;
    for round in seen.windows(REQUESTS as usize) {
        assert_eq!(round.iter().fold(0, |all, grant| all | grant), 0b1111, "{round:?}");
    }
    Ok(())
}
