"""A bench as cocotb 2's documentation writes them."""

import asyncio
import copy
import logging

import cocotb
from cocotb.clock import Clock
from cocotb.handle import Immediate, LogicArrayObject, LogicObject, ValueObjectBase
from cocotb.queue import Queue
from cocotb.simtime import convert, get_sim_time
from cocotb.task import bridge, resume
from cocotb.triggers import ClockCycles, Combine, Event, FallingEdge, First, Lock, ReadOnly, RisingEdge, Timer, ValueChange
from cocotb.triggers import gather, select, with_timeout
from cocotb.types import Logic, LogicArray, Range

assert cocotb.__version__.startswith("2") and cocotb.SIM_NAME == "Verilator"


async def shift(dut: ValueObjectBase, bits: list[int]) -> list[int]:
    seen = []
    for bit in bits:
        dut.d.value = bit
        await FallingEdge(dut.clk)
        seen.append(int(dut.q.value))
    return seen


@cocotb.test()
@cocotb.parametrize(period=[2, 10], bits=[[1, 0, 1], [0, 0, 1, 1]])
async def follows(dut, period, bits):
    Clock(dut.clk, period, unit="ns").start()
    await FallingEdge(dut.clk)
    assert await shift(dut, bits) == bits


@cocotb.test()
async def unknown_values_are_set_at_once(dut):
    for digits in ("X", "Z", "1"):
        dut.d.set(Immediate(LogicArray(digits)))
        await Timer(1, "ns")
        assert dut.d.value == (digits == "1") and copy.deepcopy({"d": dut.d.value}) == {"d": copy.copy(dut.d.value)}


@cocotb.test(timeout_time=1, timeout_unit="us")
async def blocking_code_drives(dut):
    Clock(dut.clk, 10, "ns").start()

    @resume
    async def write(bit):
        dut.d.value = bit
        await RisingEdge(dut.clk)
        await FallingEdge(dut.clk)
        return int(dut.q.value)

    def blocking(bits):
        return [write(bit) for bit in bits]

    def fails():
        raise LookupError("in the thread")

    assert await bridge(blocking)([1, 0, 0, 1]) == [1, 0, 0, 1]
    with_error = cocotb.start_soon(bridge(fails)())
    try:
        await with_error
    except LookupError as error:
        assert str(error) == "in the thread"
    else:
        raise AssertionError("no error came")
    try:
        write(1)
    except RuntimeError as error:
        assert "bridge" in str(error)


@cocotb.test()
async def unknown_digits_stay_in_python(dut):
    value = LogicArray("1X0Z")
    assert not value.is_resolvable and value[3] == Logic("1") and str(value) == "1X0Z" and value.range == Range(3, "downto", 0)
    assert (value & LogicArray("1010")) == LogicArray("1000")
    dut.d.value = Logic("X")
    await Timer(1, "ns")
    assert dut.d.value == 0
    dut.d.value = Immediate(1)
    assert isinstance(dut.d, LogicObject) and not isinstance(dut.d, LogicArrayObject)
    assert dut._path == "dff" and dut.d._path == "dff.d" and dut.d._name == "d"


@cocotb.test()
async def tasks_are_made_and_cancelled(dut):
    seen = []

    async def waits():
        try:
            await Timer(1, "ms")
        except asyncio.CancelledError:
            seen.append("cancelled")
            raise

    made = cocotb.create_task(waits())
    await Timer(1, "ns")
    assert seen == [] and not made.done()
    cocotb.start_soon(made)
    await Timer(1, "ns")
    made.cancel()
    await Timer(1, "ns")
    assert seen == ["cancelled"] and made.cancelled()
    try:
        made.result()
    except asyncio.CancelledError:
        seen.append("so it says")
    assert seen[1:] == ["so it says"]

    async def gives(value):
        await Timer(value, "ns")
        return value

    # Awaiting a task that was made starts it.
    assert await cocotb.create_task(gives(3)) == 3
    assert await gather(gives(2), gives(1)) == (2, 1)
    which, value = await select(gives(5), gives(4))
    assert (which, value) == (1, 4)
    await ClockCycles(dut.clk, 0)


@cocotb.test()
async def events_locks_and_queues(dut):
    lock, event, queue = Lock("bus"), Event(), Queue(maxsize=1)
    assert not lock.locked() and not event.is_set()
    async with lock:
        assert lock.locked()

    async def produce():
        for item in range(3):
            await queue.put(item)
        event.set()

    cocotb.start_soon(produce())
    assert [await queue.get() for _ in range(3)] == [0, 1, 2]
    await with_timeout(event.wait(), 1, "us")
    task = cocotb.start_soon(shift_by_hand(dut))
    await Combine(ValueChange(dut.q), task)
    await ReadOnly()
    assert dut.q.value == 1 and convert(get_sim_time("ps"), "ps", to="ns") == get_sim_time("ns")
    try:
        dut.d.value = 0
    except RuntimeError:
        pass
    else:
        raise AssertionError("a write in ReadOnly was taken")
    first = Timer(1, "ns")
    assert await First(first, Timer(1, "us")) is first
    logging.getLogger("cocotb.bench").info("done")


async def shift_by_hand(dut):
    dut.d.value = 1
    await Timer(1, "ns")
    dut.clk.value = 1
    await Timer(1, "ns")


@cocotb.test(expect_error=LookupError)
async def a_part_that_fails(dut):
    async def fails():
        await Timer(1, "ns")
        raise LookupError

    await Combine(cocotb.start_soon(fails()), Timer(1, "ms"))


@cocotb.test
@cocotb.xfail(raises=AssertionError)
async def ends_as_expected(dut):
    assert dut.q.value == 3


@cocotb.test
async def passes_early(dut):
    cocotb.pass_test("enough")
