"""SPI and I2C, through the wires of a small design, to devices in it, and with faults put into it."""

from pathlib import Path

import pytest
from test_overrides import verilators

import hoverlock
from hoverlock import Clock, ClockCycles, Design, FallingEdge, Timer, bus, simulate

SOURCE = Path(__file__).parents[2] / "tests" / "designs" / "serial.v"


def design(**parameters):
    return Design(SOURCE, top="serial", parameters=parameters)


def spi(dut, prefix):
    return [dut[f"{prefix}_{name}"] for name in ("sclk", "mosi", "miso", "cs")]


async def begin(dut):
    Clock(dut.clk, 10, "ns").start()
    dut.rst.value = 1
    await ClockCycles(dut.clk, 3)
    dut.rst.value = 0
    await ClockCycles(dut.clk, 3)


@pytest.mark.parametrize(("cpol", "cpha"), [(False, False), (False, True), (True, False), (True, True)])
def test_spi_words_go_both_ways(cpol, cpha):
    async def through(dut, word_width, msb_first):
        form = {"word_width": word_width, "msb_first": msb_first, "cpol": cpol, "cpha": cpha}
        master = bus.SpiMaster(*spi(dut, "s"), 25e6, **form)
        peripheral = bus.SpiPeripheral(*spi(dut, "m"), **form)
        words = bytes if word_width <= 8 else list
        peripheral.answer([0x15, 0x0A])
        await Timer(100, "ns")
        assert await master.transfer([1, 0, 3]) == words([0x15, 0x0A, 2**word_width - 1])
        assert await peripheral.recv(3) == words([1, 0, 3]) and peripheral.count == 3

    async def device(dut):
        await begin(dut)
        master = bus.SpiMaster(*spi(dut, "r"), clock=dut.clk, half_period=4, cpol=cpol, cpha=cpha)
        await ClockCycles(dut.clk, 4)
        assert await master.transfer(b"\x12\x34") == b"\xa5\xed"

    simulate(design(), through, arguments={"word_width": 5, "msb_first": True})
    simulate(design(), through, arguments={"word_width": 32, "msb_first": False})
    simulate(design(CPHA=int(cpha)), device)
    with pytest.raises(AssertionError, match="xa4"):
        simulate(design(CPHA=int(cpha), FAULT=1), device)


def test_an_spi_master_in_the_design_is_checked():
    async def bench(dut):
        await begin(dut)
        peripheral = bus.SpiPeripheral(*spi(dut, "c"))
        peripheral.answer(b"\x3c")
        await ClockCycles(dut.clk, 4)
        dut.send.value, dut.go.value = 0xE7, 1
        await ClockCycles(dut.clk, 1)
        dut.go.value = 0
        await FallingEdge(dut.busy)
        assert await peripheral.recv() == b"\xe7" and dut.got.value == 0x3C

    simulate(design(), bench)
    with pytest.raises(hoverlock.ProtocolError, match="c_cs at .*: cs ends after 7 of the 8 bits of a word"):
        simulate(design(FAULT=2), bench)


def test_what_spi_cannot_do_says_why():
    async def bench(dut):
        sclk, mosi, miso, cs = spi(dut, "s")
        for arguments in ({}, {"sclk_freq": 1e6, "clock": dut.clk, "half_period": 2}, {"clock": dut.clk}):
            with pytest.raises(TypeError, match="SpiMaster takes sclk_freq, or clock and half_period"):
                bus.SpiMaster(sclk, mosi, miso, cs, **arguments)
        with pytest.raises(hoverlock.HoverlockError, match="'send' has 8 bits and a line of a serial bus has one"):
            bus.SpiMaster(sclk, dut.send, miso, cs, 1e6)
        with pytest.raises(hoverlock.HoverlockError, match="an SPI word of 1 to 64 bits, not 65"):
            bus.SpiMaster(sclk, mosi, miso, cs, 1e6, word_width=65)
        with pytest.raises(hoverlock.NotWritable, match="m_sclk"):
            bus.SpiMaster(*spi(dut, "m"), 1e6)
        with pytest.raises(hoverlock.HoverlockError, match="0x100 does not fit an SPI word of 8 bits"):
            await bus.SpiMaster(sclk, mosi, miso, cs, 1e6).transfer([0x100])

    simulate(design(), bench)


def lines(dut, side):
    return {"sda": dut.sda, "sda_o": dut[f"sda_{side}_o"], "scl": dut.scl, "scl_o": dut[f"scl_{side}_o"]}


def test_an_i2c_memory_is_written_and_read():
    async def bench(dut):
        await begin(dut)
        memory = bus.I2cMemory(**lines(dut, 2), addr=0x51, size=512)
        master = bus.I2cMaster(**lines(dut, 1), speed=1e6)
        await master.write(0x51, b"\x01\x08hover")
        await master.stop()
        assert memory.read(0x108, 5) == b"hover" and memory[0x109] == ord("o")
        memory.write(0x1FF, b"!")
        memory[0] = 0x2A
        memory.stretch(3, "us")
        await master.write(0x51, b"\x01\xff")
        assert await master.read(0x51, 2) == b"!*" and memory.accesses == 7
        await master.stop()
        # Three bytes and an acknowledged one of the read, less the half bit that is low in any case.
        assert master.stretched == 5 * 2500
        with pytest.raises(hoverlock.HoverlockError, match="no I2C device acknowledged the address 0x50: compare"):
            await master.write(0x50, b"\x00")
        await master.start()
        assert not await master.send(0xA0)
        await master.start()
        assert await master.send(0xA3) and await master.recv(acknowledge=False) == 0
        await master.stop()
        with pytest.raises(ValueError, match="an I2C address of 7 bits, not 0xa2: leave out"):
            await master.read(0xA2, 1)
        with pytest.raises(ValueError, match="2 bytes from 0x1ff on in a memory of 512 bytes"):
            memory.read(0x1FF, 2)

    simulate(design(), bench)
    with pytest.raises(hoverlock.ProtocolError, match="sda at .*: a start after 5 bits of a byte"):

        async def disturbed(dut):
            memory = bus.I2cMemory(**lines(dut, 2))
            master = bus.I2cMaster(**lines(dut, 1))
            await begin(dut)
            await master.start()
            await master.send(0xFF)
            assert memory.accesses == 0

        simulate(design(FAULT=3), disturbed)


def test_an_i2c_device_in_the_design_is_written_and_read_at_its_pads():
    async def bench(dut):
        await begin(dut)
        pads = {"sda": dut.sda_o, "sda_t": dut.sda_t, "sda_o": dut.sda_i, "scl": dut.scl_o, "scl_t": dut.scl_t, "scl_o": dut.scl_i}
        master = bus.I2cMaster(**pads, speed=1e6)
        await master.write(0x2A, b"\xc5")
        assert await master.read(0x2A, 1) == b"\xc5" and dut.stored.value == 0xC5
        await master.stop()
        assert (master.stretched > 0) == bool(dut.STRETCH.value)

    simulate(design(), bench)
    simulate(design(STRETCH=200), bench)
    with pytest.raises(hoverlock.HoverlockError, match="no I2C device acknowledged the address 0x2a"):
        simulate(design(FAULT=4), bench)
    with pytest.raises(hoverlock.ProtocolError, match="sda_o at .*: sda is held at 0 where the master sends 1"):
        simulate(design(FAULT=5), bench)


PINS = """
module pins (inout wire scl, inout wire sda, input wire clk, output reg [7:0] ones);
    reg was, pull = 0;
    reg [7:0] falls = 0;
    assign sda = pull ? 1'b0 : 1'bz;
    always @(posedge clk) begin  // it acknowledges the first byte
        was <= scl;
        if (~scl & was) begin
            falls <= falls + 1;
            pull <= falls == 8;
        end
    end
    always @* ones = {7'd0, sda};
endmodule
"""


@pytest.mark.parametrize("verilator", verilators()[1:])
def test_i2c_at_inouts(tmp_path, verilator):
    (tmp_path / "pins.v").write_text(PINS)

    async def bench(dut):
        Clock(dut.clk, 10, "ns").start()
        master = bus.I2cMaster(sda=dut.sda, scl=dut.scl)
        await master.start()
        assert await master.send(0x5A) and not await master.send(0xFF)
        await master.stop()
        assert dut.falls.value == 19

    simulate(Design(tmp_path / "pins.v", top="pins", internals=["falls"], verilator=verilator), bench)


def test_what_i2c_cannot_do_says_why():
    async def bench(dut):
        with pytest.raises(hoverlock.HoverlockError, match="'stored' has 8 bits and a line of a serial bus has one"):
            bus.I2cMaster(**{**lines(dut, 1), "sda": dut.stored})
        with pytest.raises(hoverlock.NotWritable, match="'scl' is an output"):
            bus.I2cMaster(sda=dut.sda, scl=dut.scl)
        with pytest.raises(TypeError, match="a tristate control without the design's input"):
            bus.I2cMaster(sda=dut.sda_o, sda_t=dut.sda_t, scl=dut.scl_o, scl_t=dut.scl_t)
        with pytest.raises(ValueError, match="a speed of 0 bits"):
            bus.I2cMaster(**lines(dut, 1), speed=0)
        with pytest.raises(ValueError, match="an I2C address of 7 bits, not 0x80"):
            bus.I2cMemory(**lines(dut, 2), addr=0x80)

    simulate(design(), bench)
