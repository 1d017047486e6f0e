//! Designs as others would bring them, driven in the ways their users would.

mod common;

use common::{build, run, sim};
use hoverlock_harness::sim::{Dut, Signal};
use hoverlock_harness::{Error, Time};

const PERIOD: Time = Time::ns(10);

async fn reset(dut: &Dut) -> Result<Signal, Error> {
    let (clk, rst) = (dut.signal("clk")?, dut.signal("rst")?);
    rst.set(1)?;
    clk.cycles(3).await;
    rst.set(0)?;
    clk.rising_edge().await;
    Ok(clk)
}

/// Reads a byte off a serial line as a receiver of the bench, by time alone.
async fn receive(dut: &Dut, line: &Signal, bit: Time) -> Result<u8, Error> {
    line.falling_edge().await;
    dut.timer(bit + Time::fs(bit.as_fs() / 2)).await;
    let mut byte = 0;
    for at in 0..8 {
        byte |= (line.get() as u8) << at;
        dut.timer(bit).await;
    }
    if line.is_high() { Ok(byte) } else { Err(Error::bench("no stop bit")) }
}

#[test]
fn a_uart_sends_and_receives_at_several_speeds() {
    for divisor in [4u64, 8, 13] {
        let mut sim = sim(build("uart").parameter("DIVISOR", divisor));
        let dut = sim.dut();
        dut.clock("clk", PERIOD).unwrap();
        let bit = PERIOD * divisor;
        let bytes = [0x00u8, 0xff, 0x55, 0xa7, 0x01, 0x80];
        run(&mut sim, async {
            let s = |name: &str| dut.signal(name);
            let (rx, tx, send, data, busy) = (s("rx")?, s("tx")?, s("send")?, s("tx_data")?, s("tx_busy")?);
            rx.set(1)?;
            let clk = reset(&dut).await?;
            // Out: a task listens while this one sends.
            let (ear, line) = (dut.clone(), tx.clone());
            let listener = dut.spawn("listener", async move {
                let mut heard = Vec::new();
                for _ in 0..bytes.len() {
                    heard.push(receive(&ear, &line, bit).await?);
                }
                Ok::<_, Error>(heard)
            });
            for byte in bytes {
                data.set(u64::from(byte))?;
                send.set(1)?;
                clk.rising_edge().await;
                send.set(0)?;
                clk.rising_edge().await;
                while busy.is_high() {
                    clk.rising_edge().await;
                }
            }
            assert_eq!(dut.with_timeout(bit * 100, listener.join()).await??, bytes);
            // In: bits at times that know nothing of the clock, 2 % too slow.
            let (valid, received) = (s("rx_valid")?, s("rx_data")?);
            let slow = Time::fs(bit.as_fs() / 50 * 51);
            for byte in bytes {
                let (out, line) = (dut.clone(), rx.clone());
                dut.spawn("sender", async move {
                    for level in [0].into_iter().chain((0..8).map(|at| u64::from(byte >> at & 1))).chain([1]) {
                        line.set(level)?;
                        out.timer(slow).await;
                    }
                    Ok::<(), Error>(())
                });
                dut.with_timeout(bit * 20, valid.rising_edge()).await?;
                assert_eq!((received.get(), s("framing_error")?.get()), (u64::from(byte), 0));
                dut.timer(bit * 2).await;
            }
            Ok(())
        });
    }
}

#[test]
fn a_small_cpu_runs_a_program_put_into_its_memory() {
    let mut sim = sim(build("cpu").internal("u_core.*").internal("state"));
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    // data[0] = 10, data[1] = 0; while data[0]: data[1] += data[0]; data[0] -= 1; then out data[1] and an answer of -3.
    let (load, get, put, add, sub, jump, out, stop) = (0x0000, 0x1000, 0x2000, 0x3000, 0x4000, 0x5000, 0x6000, 0xf000);
    let program = [
        load | 10,
        put,
        load,
        put | 1,
        load | 1,
        put | 2, // set up, 1 in data[2]
        get | 1,
        add,
        put | 1,
        get,
        sub | 2,
        put,
        jump | 6, // the loop
        get | 1,
        out,
        load | 0xffd,
        out,
        stop,
    ];
    run(&mut sim, async {
        dut.memory("u_core.program_memory")?.fill(program)?;
        let (state, acc) = (dut.signal("state")?, dut.signal("u_core.acc")?);
        assert!(acc.info().signed);
        let clk = reset(&dut).await?;
        assert_eq!(state.get_named().as_deref(), Some("FETCH"), "as it was before the first edge out of reset");
        let (valid, value, halted) = (dut.signal("out_valid")?, dut.signal("out")?, dut.signal("halted")?);
        valid.rising_edge().await;
        assert_eq!(value.get(), 55);
        clk.rising_edge().await;
        valid.rising_edge().await;
        assert_eq!((value.get_signed(), acc.get_signed()), (-3, -3));
        dut.with_timeout(PERIOD * 20, halted.rising_edge()).await?;
        assert_eq!(state.get_named().as_deref(), Some("HALT"));
        assert_eq!(dut.memory("u_core.data_memory")?.to_vec()[..3], [0, 55, 1]);
        // A deposit into a register: the machine goes on.
        state.set_named("FETCH")?;
        dut.signal("u_core.pc")?.set(13)?;
        clk.cycles(4).await;
        valid.rising_edge().await;
        assert_eq!(value.get(), 55);
        let error = state.set_named("RUN").unwrap_err().to_string();
        assert!(
            error.contains("'state' has no value named 'RUN'") && error.contains("FETCH, EXECUTE, HALT"),
            "{error}"
        );
        Ok(())
    });
}

#[test]
fn the_counter_of_the_tutorial_counts() {
    let mut sim = sim(build("counter").parameter("WIDTH", 4));
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    run(&mut sim, async {
        let (enable, step, count, wrapped) =
            (dut.signal("enable")?, dut.signal("step")?, dut.signal("count")?, dut.signal("wrapped")?);
        let clk = reset(&dut).await?;
        enable.set(1)?;
        step.set(3)?;
        clk.rising_edge().await;
        for number in 1..40 {
            clk.rising_edge().await;
            assert_eq!(count.get(), 3 * number % 16);
            assert_eq!(wrapped.is_high(), 3 * number % 16 < 3);
        }
        Ok(())
    });
}
