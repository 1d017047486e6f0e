"""The smallest bench, and the options of a test."""

import hoverlock
from hoverlock import Clock, ClockCycles, Design, FallingEdge, RisingEdge

design = Design("designs/counter.v", top="counter", parameters={"WIDTH": 8})


async def reset(dut):
    Clock(dut.clk, 10, "ns").start()
    dut.rst.value = 1
    await ClockCycles(dut.clk, 2)
    dut.rst.value = 0
    dut.enable.value = 1
    dut.step.value = 1
    await RisingEdge(dut.clk)


@hoverlock.test(timeout_time=10, timeout_unit="us")
async def counts(dut):
    await reset(dut)
    for expected in range(1, 300):
        await FallingEdge(dut.clk)
        assert dut.count.value == expected % 256
        assert int(dut.wrapped.value) == (expected == 256)


@hoverlock.test()
@hoverlock.parametrize(step=[1, 3, 255])
async def steps(dut, step):
    await reset(dut)
    dut.step.value = step
    await FallingEdge(dut.clk)
    before = int(dut.count.value)
    await FallingEdge(dut.clk)
    assert dut.count.value == (before + step) % 256
