"""A bench as cocotb 2's documentation writes them, for real cocotb and for the alias: what it saw goes to a file.

    python both.py            builds and runs it with the runner that `cocotb_tools` gives
"""

import json
import os
from pathlib import Path

import cocotb
from cocotb.clock import Clock
from cocotb.queue import Queue
from cocotb.simtime import get_sim_time
from cocotb.task import bridge, resume
from cocotb.triggers import (
    ClockCycles,
    Combine,
    Event,
    FallingEdge,
    First,
    Lock,
    ReadOnly,
    ReadWrite,
    RisingEdge,
    Timer,
    ValueChange,
    gather,
    with_timeout,
)
from cocotb.types import Logic, LogicArray, Range

saw = {}


def note(test, *what):
    saw.setdefault(test, []).append([str(item) for item in what])
    Path(os.environ["BOTH_OUT"]).write_text(json.dumps(saw, indent=1))


def now():
    return int(get_sim_time("ns"))


async def reset(dut):
    Clock(dut.clk, 10, unit="ns").start()
    dut.rst.value = 1
    dut.in_valid.value = 0
    dut.in_data.value = 0
    dut.out_ready.value = 1
    await ClockCycles(dut.clk, 2)
    dut.rst.value = 0
    await FallingEdge(dut.clk)


async def send(dut, values):
    for value in values:
        dut.in_valid.value = 1
        dut.in_data.value = value
        await RisingEdge(dut.clk)
        while not dut.in_ready.value:
            await RisingEdge(dut.clk)
        await FallingEdge(dut.clk)
    dut.in_valid.value = 0


async def receive(dut, count, start):
    found = []
    while len(found) < count:
        await FallingEdge(dut.clk)
        await ReadOnly()
        if dut.out_valid.value and dut.out_ready.value:
            found.append((now() - start, dut.out_data.value.to_unsigned()))
    return found


@cocotb.test()
@cocotb.parametrize(values=[[1, 2, 3], [255, 0, 127, 128]], gap=[0, 3])
async def stream(dut, values, gap):
    await reset(dut)
    start = now()
    receiver = cocotb.start_soon(receive(dut, len(values), start))
    for value in values:
        await send(dut, [value])
        if gap:
            await ClockCycles(dut.clk, gap, FallingEdge)
    found = await with_timeout(receiver, 10, "us")
    note("stream", values, gap, found)


@cocotb.test()
async def values(dut):
    await reset(dut)
    array = LogicArray("1X0Z01-1")
    note("values", array, array.range, array.is_resolvable, array[7], array[3:0], ~array, array & LogicArray("11111111"))
    note("values", LogicArray(0xA5, 8), LogicArray.from_signed(-3, 8), LogicArray("0101").to_unsigned(), Logic("Z"), Logic(1) ^ Logic("X"))
    note("values", LogicArray("10101010", Range(0, "to", 7))[2], LogicArray(5, Range(3, "downto", 0)))
    dut.in_data.value = LogicArray("10100101")
    await ReadWrite()
    value = dut.in_data.value
    note("values", value, value.range, value.to_signed(), value.to_unsigned(), value[7], value[3:0], len(dut.in_data), value == 0xA5)
    dut.in_data.value = -1
    await Timer(1, "ns")
    note("values", dut.in_data.value, dut.in_data._name, dut._name)
    for bad in (256, -129):
        try:
            dut.in_data.value = bad
        except ValueError as error:
            note("values", bad, isinstance(error, ValueError))


@cocotb.test()
async def triggers(dut):
    await reset(dut)
    start = now()
    timer, other = Timer(7, "ns"), Timer(70, "ns")
    note("triggers", (await First(timer, other)) is timer, now() - start)
    event, lock, queue = Event(), Lock(), Queue(maxsize=1)

    async def holds(name, span):
        async with lock:
            await Timer(span, "ns")
            await queue.put((name, now() - start))

    async def collects():
        found = [await queue.get() for _ in range(3)]
        event.set()
        return found

    collector = cocotb.start_soon(collects())
    await Combine(*(cocotb.start_soon(holds(name, span)) for name, span in (("a", 5), ("b", 3), ("c", 9))))
    await event.wait()
    note("triggers", await collector, event.is_set(), lock.locked(), now() - start)

    async def gives(value):
        await Timer(value, "ns")
        return value

    note("triggers", await gather(gives(4), gives(2)), now() - start)
    cocotb.start_soon(send(dut, [9]))
    await ValueChange(dut.in_valid)
    note("triggers", now() - start, dut.in_valid.value)
    task = cocotb.start_soon(gives(1000))
    await Timer(1, "ns")
    task.cancel()
    await Timer(1, "ns")
    note("triggers", task.done(), task.cancelled())
    try:
        await with_timeout(Timer(1, "ms"), 10, "ns")
    except cocotb.triggers.SimTimeoutError:
        note("triggers", "timeout", now() - start)
    await ReadOnly()
    try:
        dut.in_data.value = 1
    except RuntimeError:
        note("triggers", "no write in ReadOnly")


@cocotb.test()
async def threads(dut):
    await reset(dut)
    start = now()

    @resume
    async def write(value):
        await send(dut, [value])
        return now() - start

    def blocking():
        return [write(value) for value in (1, 2, 3)]

    note("threads", await bridge(blocking)())


@cocotb.test(expect_error=LookupError)
async def fails_as_expected(dut):
    await Timer(1, "ns")
    note("fails_as_expected", "raised")
    raise LookupError


@cocotb.test()
async def fails(dut):
    await Timer(1, "ns")
    assert dut.in_data.value == 256


@cocotb.test(skip=True)
async def skipped(dut):
    note("skipped", "ran")


def main():
    from cocotb_tools.runner import get_runner

    source = Path(os.environ["BOTH_SOURCE"])
    runner = get_runner(os.getenv("SIM", "verilator"))
    runner.build(sources=[source], hdl_toplevel="echo", build_args=["-Wno-fatal"], timescale=("1ns", "1ps"), always=True)
    try:
        runner.test(hdl_toplevel="echo", test_module="both", results_xml=str(Path.cwd() / "results.xml"))
    except SystemExit:
        pass  # one test fails on purpose


if __name__ == "__main__":
    main()
