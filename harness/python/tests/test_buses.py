"""AXI4 with a memory and a checker, APB, Wishbone and UART, through the wires of a small design."""

from pathlib import Path

import numpy as np
import pytest

import hoverlock
from hoverlock import Clock, ClockCycles, Design, Timer, bus, simulate

design = Design(Path(__file__).parents[2] / "tests" / "designs" / "buses.v", top="buses")


def test_an_axi_memory_answers_bursts_and_checks_its_master():
    async def bench(dut):
        Clock(dut.clk, 10, "ns").start()
        memory = bus.AxiMemory(dut, "m_axi_", dut.clk, reset=dut.rst)
        checker = bus.AxiChecker(dut, "s_axi_", dut.clk, reset=dut.rst)
        master = bus.AxiMaster(dut, "s_axi_", dut.clk)
        memory.stall(0.3, seed=1)
        words = np.arange(64) * 3
        await master.write_burst(0x400, words)
        assert (memory.read(0x400, 64) == words).all() and memory[0x404] == 3
        memory.write(0x800, [5, 6, 7])
        assert list(await master.read_burst(0x800, 3)) == [5, 6, 7]
        assert (checker.writes, checker.reads, memory.accesses) == (1, 1, 67)
        # A burst that its master ends too early.
        dut.s_axi_awlen.value, dut.s_axi_awvalid.value, dut.s_axi_wvalid.value, dut.s_axi_wlast.value = 3, 1, 1, 1
        await ClockCycles(dut.clk, 40)

    with pytest.raises(hoverlock.ProtocolError, match=r"axi at .*: wlast is 1 at beat 1 of 4"):
        simulate(design, bench)


@pytest.mark.parametrize(
    ("master", "memory", "step"), [(bus.ApbMaster, bus.ApbMemory, 4), (bus.WishboneMaster, bus.WishboneMemory, 1)]
)
def test_registers_are_read_and_written(master, memory, step):
    async def bench(dut):
        Clock(dut.clk, 10, "ns").start()
        words = memory(dut, "m_", dut.clk)
        words.stall(0.4, seed=2)
        through, slave = master(dut, "s_", dut.clk), master(dut, "r_", dut.clk)
        words.write(0, [0x11223344, 0xFFFFFFFF])
        await ClockCycles(dut.clk, 1)
        await through.write(step, 0xAABBCCDD, bytes=0b0011)
        assert [await through.read(0), await through.read(step)] == [0x11223344, 0xFFFFCCDD] and words.accesses == 3
        await slave.write(step, 9)
        assert await slave.read(step) == 9
        with pytest.raises(hoverlock.SimulationError, match="r_: read at 0x[8f] answered SLVERR"):
            await slave.read(8 if step == 4 else 15)

    simulate(design, bench)


def test_uart_characters_arrive_and_a_wrong_parity_is_told():
    async def bench(dut, parity):
        source = bus.UartSource(dut.rxd, 1e6, parity="even", stop_bits=2)
        sink = bus.UartSink(dut.txd, 1e6, parity=parity)
        await Timer(3, "us")
        sent = hoverlock.start_soon(source.send(b"hover"))
        assert await sink.recv(5) == b"hover" and sink.count == 5
        await sent

    simulate(design, bench, arguments={"parity": "even"})
    with pytest.raises(hoverlock.ProtocolError, match="txd at .*: the parity bit of 0x68 is 1"):
        simulate(design, bench, arguments={"parity": "odd"})
    with pytest.raises(ValueError, match="parity is 'even', 'odd' or None"):
        simulate(design, bench, arguments={"parity": "none"})
