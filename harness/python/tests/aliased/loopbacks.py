"""Packages written for cocotb, used as their documentation says; nothing here or in them names hoverlock."""

import itertools
import logging
import random

import cocotb
from cocotb.clock import Clock
from cocotb.regression import TestFactory
from cocotb.triggers import ClockCycles, Event, First, RisingEdge, Timer
from cocotb_bus.drivers.amba import AXI4LiteMaster
from cocotb_coverage.coverage import CoverCross, CoverPoint, coverage_db
from cocotb_coverage.crv import Randomized
from cocotbext.axi import AxiBus, AxiLiteBus, AxiLiteRam, AxiMaster, AxiRam, AxiStreamBus, AxiStreamFrame, AxiStreamSink, AxiStreamSource
from cocotbext.eth import GmiiFrame, GmiiSink, GmiiSource
from cocotbext.i2c import I2cMaster, I2cMemory
from cocotbext.spi import SpiBus, SpiConfig, SpiMaster, SpiSlaveBase
from cocotbext.uart import UartSink, UartSource


async def begin(dut):
    cocotb.start_soon(Clock(dut.clk, 10, units="ns").start())
    dut.rst.setimmediatevalue(0)
    dut.rst.value = 1
    await ClockCycles(dut.clk, 2)
    dut.rst.value = 0
    await RisingEdge(dut.clk)


def pauses():
    return itertools.cycle([1, 1, 0, 0, 0])


async def axis_frames(dut, idle=None, stall=None):
    source = AxiStreamSource(AxiStreamBus.from_prefix(dut, "s_axis"), dut.clk, dut.rst)
    sink = AxiStreamSink(AxiStreamBus.from_prefix(dut, "m_axis"), dut.clk, dut.rst)
    await begin(dut)
    if idle:
        source.set_pause_generator(idle())
    if stall:
        sink.set_pause_generator(stall())
    frames = [AxiStreamFrame(bytes(random.randrange(256) for _ in range(length)), tuser=length % 2) for length in (1, 2, 7, 64)]
    for frame in frames:
        await source.send(frame)
    for frame in frames:
        got = await sink.recv()
        assert got.tdata == frame.tdata and got.tuser == frame.tuser
    assert sink.empty()


# As the packages' own benches do it: the tests are made while the module is loaded, by what the design is.
if cocotb.SIM_NAME:
    assert len(cocotb.top.s_axis_tdata) == 16
    factory = TestFactory(axis_frames)
    factory.add_option("idle", [None, pauses])
    factory.add_option("stall", [None, pauses])
    factory.generate_tests()


@cocotb.test()
async def axi_memory(dut):
    master = AxiMaster(AxiBus.from_prefix(dut, "s_axi"), dut.clk, dut.rst)
    ram = AxiRam(AxiBus.from_prefix(dut, "m_axi"), dut.clk, dut.rst, size=2**16)
    await begin(dut)
    ram.write_if.b_channel.set_pause_generator(pauses())
    for length in (1, 4, 33, 300):
        data = bytes(random.randrange(256) for _ in range(length))
        await master.write(0x100 + length, data)
        assert ram.read(0x100 + length, length) == data
        assert (await master.read(0x100 + length, length)).data == data


@cocotb.test()
async def axi_lite_of_cocotb_bus(dut):
    ram = AxiLiteRam(AxiLiteBus.from_prefix(dut, "m_axil"), dut.clk, dut.rst, size=2**16)
    master = AXI4LiteMaster(dut, "BUS", dut.clk)
    await begin(dut)
    for address in (0, 4, 0x1000):
        await master.write(address, 0xC0C0_0000 + address)
        assert ram.read_dword(address) == 0xC0C0_0000 + address
        assert int(await master.read(address)) == 0xC0C0_0000 + address


@cocotb.test()
async def ethernet_frames(dut):
    source = GmiiSource(dut.gmii_rxd, dut.gmii_rx_er, dut.gmii_rx_dv, dut.clk, dut.rst)
    sink = GmiiSink(dut.gmii_txd, dut.gmii_tx_er, dut.gmii_tx_en, dut.clk, dut.rst)
    await begin(dut)
    for length in (60, 200):
        payload = bytes(random.randrange(256) for _ in range(length))
        await source.send(GmiiFrame.from_payload(payload))
        got = await sink.recv()
        assert got.get_payload() == payload and got.check_fcs() and got.error is None


@cocotb.test()
async def uart_bytes(dut):
    source, sink = UartSource(dut.uart_rxd, baud=1_000_000), UartSink(dut.uart_txd, baud=1_000_000)
    await Timer(2, "us")  # the line is idle
    await source.write(b"drift")
    await source.wait()
    received = bytearray()
    while len(received) < 5:
        received.extend(await sink.read())
    assert received == b"drift"


@cocotb.test()
async def i2c_memory(dut):
    memory = I2cMemory(sda=dut.sda_i, sda_o=dut.sda_1_o, scl=dut.scl_i, scl_o=dut.scl_1_o, addr=0x50, size=256)
    master = I2cMaster(sda=dut.sda_i, sda_o=dut.sda_2_o, scl=dut.scl_i, scl_o=dut.scl_2_o, speed=400e3)
    await Timer(2, "us")  # the bus is idle
    await master.write(0x50, b"\x10\xaa\xbb\xcc")
    await master.send_stop()
    await Timer(1, "us")
    assert memory.read_mem(0x10, 3) == b"\xaa\xbb\xcc"
    await master.write(0x50, b"\x11")
    assert await master.read(0x50, 2) == b"\xbb\xcc"
    await master.send_stop()


class Echo(SpiSlaveBase):
    """Answers with the word it got before."""

    _config = SpiConfig(word_width=8, cpol=False, cpha=True, cs_active_low=True)

    def __init__(self, bus):
        self.word = 0xA5
        super().__init__(bus)

    async def _transaction(self, frame_start, frame_end):
        await frame_start
        self.idle.clear()
        self.word = int(await self._shift(8, tx_word=self.word))
        await frame_end


@cocotb.test()
async def spi_words(dut):
    slave = Echo(SpiBus(dut, sclk_name="slave_sclk", mosi_name="slave_mosi", miso_name="slave_miso", cs_name="slave_cs"))
    bus = SpiBus(dut, sclk_name="master_sclk", mosi_name="master_mosi", miso_name="master_miso", cs_name="master_cs")
    master = SpiMaster(bus, SpiConfig(word_width=8, sclk_freq=5e6, cpol=False, cpha=True, cs_active_low=True))
    await Timer(2, "us")  # no slave is selected
    for sent, answer in ((0x12, 0xA5), (0x34, 0x12), (0x56, 0x34)):
        await master.write([sent])
        await slave.idle.wait()
        got = await master.read(1)
        assert got == bytes([answer]), (got, hex(answer))


class Setting(Randomized):
    def __init__(self):
        super().__init__()
        self.width = self.height = 0
        self.add_rand("width", list(range(1, 9)))
        self.add_rand("height", list(range(1, 9)))
        self.add_constraint(lambda height, width: width + height == 9)


@cocotb.test()
async def coverage_is_counted(dut):
    @CoverPoint("top.width", xf=lambda setting: setting.width, bins=list(range(1, 9)))
    @CoverPoint("top.tall", xf=lambda setting: setting.height > setting.width, bins=[True, False])
    @CoverCross("top.both", items=["top.width", "top.tall"])
    def sample(setting):
        assert setting.width + setting.height == 9

    setting = Setting()
    for _ in range(60):
        setting.randomize()
        sample(setting)
    assert coverage_db["top.tall"].coverage == 2 and coverage_db["top.width"].coverage >= 6


@cocotb.test()
async def the_log_is_cocotbs(dut):
    logging.getLogger("cocotb.loopbacks").info("a line of INFO")
    done = Event()
    assert not done.fired and cocotb.top is dut
    assert await First(Timer(1, "ns"), done.wait()) is not None
