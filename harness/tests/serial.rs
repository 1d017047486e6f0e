//! SPI and I2C: against small designs, against each other through wires, and with faults put into the designs.

mod common;

use common::{build, run, sim};
use hoverlock_harness::bus::i2c::Line;
use hoverlock_harness::bus::{i2c, spi};
use hoverlock_harness::sim::{Dut, Sim};
use hoverlock_harness::{Error, Time};

fn design(parameters: &[(&str, i64)]) -> Sim {
    sim(parameters.iter().fold(build("serial"), |build, (name, value)| build.parameter(*name, *value)))
}

/// A clock, and a reset that is over.
async fn begin(dut: &Dut) -> Result<(), Error> {
    dut.clock("clk", Time::ns(10))?;
    dut.signal("rst")?.set(1)?;
    dut.signal("clk")?.cycles(3).await;
    dut.signal("rst")?.set(0)?;
    dut.signal("clk")?.cycles(3).await;
    Ok(())
}

fn text(result: Result<impl Sized, impl ToString>) -> String {
    result.err().map(|e| e.to_string()).unwrap_or_default()
}

#[test]
fn spi_words_go_both_ways_in_all_modes() {
    for mode in 0..4 {
        for (bits, order, select_high) in [
            (1, spi::Order::HighestFirst, false),
            (12, spi::Order::LowestFirst, true),
            (64, spi::Order::HighestFirst, false),
        ] {
            let mut sim = design(&[]);
            let dut = sim.dut();
            let format = spi::Format { bits, order, select_high, ..spi::Format::mode(mode).unwrap() };
            let lines = |prefix| spi::Lines::find(&dut, prefix).unwrap();
            let half = spi::Half::Time(Time::ns(20));
            let master = spi::Master::new(&dut, &lines("s_"), format, half).unwrap();
            let peripheral = spi::Peripheral::new(&dut, &lines("m_"), format).unwrap();
            let ones = u64::MAX >> (64 - bits);
            let (sent, answers) = ([0x9e37_79b9_7f4a_7c15 & ones, 0, ones], [0xa5c3_0f96 & ones, ones]);
            peripheral.answer(&answers).unwrap();
            run(&mut sim, async {
                dut.timer(Time::ns(100)).await;
                assert_eq!(master.transfer(&sent[..1]).await?, answers[..1], "mode {mode}, {bits} bits");
                assert_eq!(master.transfer(&sent[1..]).await?, [answers[1], ones], "mode {mode}, {bits} bits");
                Ok(())
            });
            let got: Vec<u64> = std::iter::from_fn(|| peripheral.try_recv()).collect();
            assert_eq!((got, peripheral.count()), (sent.to_vec(), 3), "mode {mode}, {bits} bits");
        }
    }
}

/// What a master reads from the peripheral of the design: what was sent before, inverted.
fn read_design(mode: u32, of_design: u32, cycles: bool, fault: i64) -> Vec<u64> {
    let mut sim = design(&[("CPHA", i64::from(of_design & 1)), ("FAULT", fault)]);
    let dut = sim.dut();
    let clk = dut.signal("clk").unwrap();
    let half = if cycles { spi::Half::Cycles(clk, 4) } else { spi::Half::Time(Time::ns(37)) };
    let lines = spi::Lines::find(&dut, "r_").unwrap();
    let master = spi::Master::new(&dut, &lines, spi::Format::mode(mode).unwrap(), half).unwrap();
    let mut got = Vec::new();
    run(&mut sim, async {
        begin(&dut).await?;
        got = master.transfer(&[0x12, 0x34]).await?;
        got.extend(master.transfer(&[0x56]).await?);
        Ok(())
    });
    got
}

#[test]
fn an_spi_master_reads_and_writes_a_peripheral_in_the_design() {
    let expected = [0xa5, 0xed, 0xcb];
    for mode in 0..4 {
        for cycles in [false, true] {
            assert_eq!(read_design(mode, mode, cycles, 0), expected, "mode {mode}, cycles {cycles}");
        }
        assert_eq!(read_design(mode, mode, true, 1), [0xa4, 0xec, 0xca], "the bit that the fault loses is seen");
        assert_ne!(read_design(mode, mode ^ 1, true, 0), expected, "another CPHA is seen");
    }
}

#[test]
fn an_spi_peripheral_answers_a_master_in_the_design_and_checks_it() {
    let meet = |mode: u32, fault: i64| {
        let mut sim = design(&[("FAULT", fault)]);
        let dut = sim.dut();
        let lines = spi::Lines::find(&dut, "c_").unwrap();
        let peripheral = spi::Peripheral::new(&dut, &lines, spi::Format::mode(mode).unwrap()).unwrap();
        peripheral.answer(&[0x3c, 0x81]).unwrap();
        let signal = |name: &str| dut.signal(name).unwrap();
        let mut heard = Vec::new();
        let end = sim.run(async {
            begin(&dut).await?;
            for word in [0xe7, 0x18] {
                signal("send").set(word)?;
                signal("go").set(1)?;
                signal("clk").cycles(1).await;
                signal("go").set(0)?;
                signal("busy").falling_edge().await;
                let word = dut.with_timeout(Time::us(10), peripheral.recv()).await?;
                heard.push((word, signal("got").get()));
            }
            Ok::<(), Error>(())
        });
        (heard, text(end))
    };
    assert_eq!(meet(0, 0), (vec![(0xe7, 0x3c), (0x18, 0x81)], String::new()));
    let (_, told) = meet(0, 2);
    assert!(told.contains("c_cs at ") && told.contains("cs ends after 7 of the 8 bits of a word"), "{told}");
    let (_, told) = meet(2, 0);
    assert!(told.contains("sclk is 0 when cs becomes active: CPOL is not 1"), "{told}");
}

#[test]
fn what_spi_cannot_do_is_refused() {
    let mut sim = design(&[]);
    let dut = sim.dut();
    let mode = spi::Format::mode(0).unwrap();
    let lines = spi::Lines::find(&dut, "s_").unwrap();
    let half = || spi::Half::Time(Time::ns(20));
    let master = |lines: &spi::Lines, format, half| text(spi::Master::new(&dut, lines, format, half));
    let wide = spi::Lines { mosi: dut.signal("send").unwrap(), ..lines.clone() };
    assert!(master(&wide, mode, half()).contains("'send' has 8 bits and a line of a serial bus has one"));
    let driven = spi::Lines::find(&dut, "m_").unwrap();
    assert!(master(&driven, mode, half()).contains("m_sclk"), "{}", master(&driven, mode, half()));
    let long = spi::Format { bits: 65, ..mode };
    assert!(master(&lines, long, half()).contains("an SPI word of 1 to 64 bits, not 65"));
    let none = spi::Half::Time(Time::ZERO);
    assert!(master(&lines, mode, none).contains("half a period of sclk of 0"));
    assert!(text(spi::Format::mode(4)).contains("an SPI mode from 0 to 3, not 4"));
    assert!(text(spi::Lines::find(&dut, "none_")).contains("none_sclk"));
    let peripheral = spi::Peripheral::new(&dut, &driven, mode).unwrap();
    assert!(text(peripheral.answer(&[0x100])).contains("0x100 does not fit an SPI word of 8 bits"));
    let master = spi::Master::new(&dut, &lines, mode, half()).unwrap();
    assert!(text(sim.run(master.transfer(&[1, 0x1ff]))).contains("0x1ff does not fit an SPI word of 8 bits"));
}

/// The line of a model at the wired AND of the design.
fn line(dut: &Dut, name: &str, side: u32) -> Line {
    let drive = dut.signal(&format!("{name}_{side}_o")).unwrap();
    Line::new(&dut.signal(name).unwrap(), &drive).unwrap()
}

fn master(dut: &Dut) -> i2c::Master {
    i2c::Master::new(dut, line(dut, "scl", 1), line(dut, "sda", 1), 400_000).unwrap()
}

fn memory(dut: &Dut, size: usize) -> i2c::Memory {
    i2c::Memory::new(dut, line(dut, "scl", 2), line(dut, "sda", 2), 0x50, size).unwrap()
}

#[test]
fn an_i2c_memory_is_written_and_read() {
    for (size, pointer) in [(256, vec![0x10]), (4096, vec![0x00, 0x10]), (1, vec![])] {
        let mut sim = design(&[]);
        let dut = sim.dut();
        let (master, memory) = (master(&dut), memory(&dut, size));
        let pointer = if pointer.is_empty() { vec![0] } else { pointer };
        run(&mut sim, async {
            begin(&dut).await?;
            master.write(0x50, &[pointer.as_slice(), &[0xaa, 0x55, 0xff]].concat()).await?;
            master.stop().await?;
            assert_eq!(memory.get(0x12), 0xff);
            memory.set(0x13, 0x81);
            // The pointer, a repeated start, and bytes from it on.
            master.write(0x50, &pointer).await?;
            let bytes = master.read(0x50, 4).await?;
            master.stop().await?;
            let expected = if size == 1 { [0x81; 4] } else { [0xaa, 0x55, 0xff, 0x81] };
            assert_eq!((bytes, memory.accesses()), (expected.to_vec(), 7), "size {size}");
            Ok(())
        });
        assert_eq!(master.stretched(), Time::ZERO);
    }
}

#[test]
fn i2c_devices_may_hold_the_clock_and_may_refuse() {
    let mut sim = design(&[]);
    let dut = sim.dut();
    let (master, memory) = (master(&dut), memory(&dut, 256));
    memory.set_stretch(Time::us(5));
    run(&mut sim, async {
        begin(&dut).await?;
        master.write(0x50, &[0, 7]).await?;
        master.stop().await?;
        // Half a bit of 2.5 us is low in any case.
        assert_eq!(master.stretched(), Time::ns(3 * (5000 - 1250)));
        let told = text(master.write(0x51, &[1]).await);
        assert!(told.contains("no I2C device acknowledged the address 0x51: compare"), "{told}");
        let told = text(master.read(0xa0, 1).await);
        assert!(told.contains("an I2C address of 7 bits, not 0xa0: leave out the bit for read or write"), "{told}");
        let told = text(master.send(1).await);
        assert!(told.contains("a byte on I2C without a start before it"), "{told}");
        master.start().await?;
        assert_eq!((master.send(0xa1).await?, master.recv(false).await?), (true, 0));
        master.start().await?;
        assert!(!master.send(0xb0).await?);
        master.stop().await?;
        assert_eq!(memory.get(0), 7);
        Ok(())
    });
}

/// A master at the pads of the device in the design.
fn write_design(stretch: i64, fault: i64) -> (Vec<u8>, u64, Time, String) {
    let mut sim = design(&[("STRETCH", stretch), ("FAULT", fault)]);
    let dut = sim.dut();
    let signal = |name: &str| dut.signal(name).unwrap();
    let pad = |name: &str| {
        let pins = ["_o", "_t", "_i"].map(|end| signal(&format!("{name}{end}")));
        Line::pad(&dut, &pins[0], &pins[1], &pins[2]).unwrap()
    };
    let master = i2c::Master::new(&dut, pad("scl"), pad("sda"), 1_000_000).unwrap();
    let mut read = Vec::new();
    let end = sim.run(async {
        begin(&dut).await?;
        master.write(0x2a, &[0xc5]).await?;
        read = master.read(0x2a, 2).await?;
        master.stop().await
    });
    (read, signal("stored").get(), master.stretched(), text(end))
}

#[test]
fn an_i2c_master_reads_and_writes_a_device_in_the_design_and_sees_its_faults() {
    assert_eq!(write_design(0, 0), (vec![0xc5, 0xc5], 0xc5, Time::ZERO, String::new()));
    let (read, stored, stretched, told) = write_design(200, 0);
    assert_eq!((read, stored, told), (vec![0xc5, 0xc5], 0xc5, String::new()));
    assert!(stretched > Time::us(4), "{stretched}");
    let (_, _, _, told) = write_design(0, 4);
    assert!(told.contains("no I2C device acknowledged the address 0x2a"), "{told}");
    let (_, _, _, told) = write_design(0, 5);
    assert!(told.contains("sda_o at ") && told.contains("sda is held at 0 where the master sends 1"), "{told}");
}

#[test]
fn an_i2c_memory_checks_its_master() {
    let mut sim = design(&[("FAULT", 3)]);
    let dut = sim.dut();
    let (master, _memory) = (master(&dut), memory(&dut, 256));
    let told = text(sim.run(async {
        begin(&dut).await?;
        // Bits of 1 up to the sixth, whose high phase the design disturbs.
        master.start().await?;
        master.send(0xff).await
    }));
    assert!(told.contains("sda at ") && told.contains("a start after 5 bits of a byte"), "{told}");
}

#[test]
fn what_i2c_cannot_do_is_refused() {
    let sim = design(&[]);
    let dut = sim.dut();
    let signal = |name: &str| dut.signal(name).unwrap();
    assert!(text(Line::new(&signal("stored"), &signal("sda_1_o"))).contains("'stored' has 8 bits"));
    assert!(text(Line::new(&signal("sda"), &signal("sda"))).contains("sda"));
    let lines = || (line(&dut, "scl", 1), line(&dut, "sda", 1));
    let (scl, sda) = lines();
    assert!(text(i2c::Master::new(&dut, scl, sda, 0)).contains("0 bits a second on I2C"));
    for (address, size) in [(0x80, 256), (0x50, 0)] {
        let (scl, sda) = lines();
        let told = text(i2c::Memory::new(&dut, scl, sda, address, size));
        assert!(told.contains("1 byte at least at an address of 7 bits"), "{told}");
    }
}
