"""AXI4 with a memory and a checker, through the wires of a small design."""

from pathlib import Path

import numpy as np
import pytest

import hoverlock
from hoverlock import Clock, ClockCycles, Design, bus, simulate

design = Design(Path(__file__).parents[2] / "tests" / "designs" / "axi4_wires.v", top="axi4_wires")


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
