"""What public benches do with cocotb, in their ways of writing, from `yield` to cocotb 2, with only the imports changed."""

import itertools
import logging
import random
import sys
import warnings
from decimal import Decimal
from pathlib import Path
from random import getrandbits
from typing import Any

import numpy as np
import pytest

import hoverlock.cocotb as cocotb
import hoverlock.cocotb.regression
from hoverlock import CancelledError, Design
from hoverlock.cocotb import simulator
from hoverlock.cocotb.binary import BinaryRepresentation, BinaryValue
from hoverlock.cocotb.clock import Clock
from hoverlock.cocotb.handle import Deposit, Force, Immediate, ModifiableObject, SimHandleBase
from hoverlock.cocotb.log import SimLog
from hoverlock.cocotb.queue import Queue
from hoverlock.cocotb.regression import TestFactory
from hoverlock.cocotb.result import ReturnValue, TestError, TestFailure, TestSuccess
from hoverlock.cocotb.task import Task
from hoverlock.cocotb.triggers import *  # noqa: F403
from hoverlock.cocotb.triggers import (
    ClockCycles, Combine, Edge, Event, FallingEdge, First, Join, Lock, ReadOnly, ReadWrite, RisingEdge, Timer,
    gather, select, with_timeout,
)  # fmt: skip
from hoverlock.cocotb.types import Array, Bit, Logic, LogicArray, Range, concat
from hoverlock.cocotb.utils import get_sim_steps, get_sim_time

sys.path.insert(0, str(Path(__file__).parent / "aliased"))
import binary_values  # noqa: E402

design = Design("designs/idioms.sv", top="idioms", internals=["*"])


# ---- short benches of the kind that students and TinyTapeout write


@cocotb.test()
async def test_project(dut):
    dut._log.info("Start")
    clock = Clock(dut.clk, 71.428, units="ns")
    cocotb.start_soon(clock.start())
    dut._log.info("Reset")
    dut.ena.value = 1
    dut.ui_in.value = 0
    dut.rst_n.value = 0
    await ClockCycles(dut.clk, 10)
    dut.rst_n.value = 1
    dut.ui_in.value = 20
    await ClockCycles(dut.clk, 3)
    assert dut.uo_out.value == 40
    assert dut.uo_out.value.integer == 40 and int(dut.uo_out) == 40 and dut.uo_out == 40 and dut.uo_out != 41
    assert hex(dut.uo_out.value) == "0x28" and f"{dut.uo_out.value}" == "00101000" and str(dut.uo_out.value) == "00101000"


async def generate_clock(dut):
    """A clock made by hand."""
    for cycle in range(10):
        dut.clk.value = 0
        await Timer(1, units="ns")
        dut.clk.value = 1
        await Timer(1, units="ns")


@cocotb.test()
async def my_second_test(dut):
    await cocotb.start(generate_clock(dut))
    await Timer(5, units="ns")
    await FallingEdge(dut.clk)
    dut._log.info("tick is %s", dut.tick.value)
    assert dut.tick.value[0] == 0, "tick[0] is not 0!"


@cocotb.test()
async def several_clocks_and_a_bounded_one(dut):
    await cocotb.start(Clock(dut.clk, 10, "ns").start(cycles=4, start_high=False))
    for edge in range(4):
        await RisingEdge(dut.clk)
        assert get_sim_time(units="ns") == 5 + 10 * edge
    with pytest.raises(cocotb.result.SimTimeoutError):
        await with_timeout(RisingEdge(dut.clk), 100, "ns")


def reset_active_low(dut):
    async def run():
        dut.rst_n.setimmediatevalue(1)
        await RisingEdge(dut.clk)
        dut.rst_n.value = 0
        for _ in range(2):
            await RisingEdge(dut.clk)
        dut.rst_n.value = 1
        dut.rst_n._log.debug("Reset complete")

    return run()


class TB:
    """A bench as a class, with a log of its own."""

    __test__ = False

    def __init__(self, dut, ena=1):
        self.dut = dut
        self.log = SimLog("cocotb.tb")
        self.log.setLevel(logging.DEBUG)
        self.seen: Queue[int] = Queue()
        self.event = Event("first")
        cocotb.start_soon(Clock(dut.clk, 8, units="ns").start())
        dut.ena.setimmediatevalue(ena)
        self._monitor = cocotb.start_soon(self._run())

    async def _run(self):
        while True:
            await Edge(self.dut.uo_out)
            self.seen.put_nowait(self.dut.uo_out.value.integer)
            self.event.set(data=get_sim_time("ns"))

    async def cycle_reset(self):
        await reset_active_low(self.dut)

    def stop(self):
        self._monitor.kill()


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def a_bench_as_a_class(dut):
    tb = TB(dut)
    await tb.cycle_reset()
    tb.dut.ui_in.value = 3
    await tb.event.wait()
    assert tb.event.is_set() and tb.event.data > 0
    await ClockCycles(dut.clk, 3)
    tb.stop()
    assert [await tb.seen.get() for _ in range(3)] == [3, 6, 9] and tb._monitor.done()
    tb.log.info("seen %d", tb.seen.qsize())


def idle_set():
    return itertools.cycle([1, 1, 1, 0])


async def run_test(dut, payload=None, idle_inserter=None, backpressure_inserter=None):
    tb = TB(dut)
    await tb.cycle_reset()
    total = 0
    gaps = idle_inserter() if idle_inserter else itertools.repeat(0)
    for word in payload():
        dut.ena.value = 1
        dut.ui_in.value = word
        await RisingEdge(dut.clk)
        total = (total + word) & 0xFF
        if next(gaps):
            dut.ena.value = 0
            await RisingEdge(dut.clk)
    dut.ui_in.value = 0
    await RisingEdge(dut.clk)
    await ReadOnly()
    assert dut.uo_out.value.integer == total


def incrementing():
    return list(range(20))


def random_words():
    return [getrandbits(8) for _ in range(20)]


if cocotb.SIM_NAME:
    for test in [run_test]:
        factory = TestFactory(test)
        factory.add_option("payload", [incrementing, random_words])
        factory.add_option(("idle_inserter", "backpressure_inserter"), [(None, None), (idle_set, idle_set)])
        factory.generate_tests()
    del test


def test_the_factory_made_four_tests():
    made = [name for name in globals() if name.startswith("run_test_")]
    assert made == ["run_test_001", "run_test_002", "run_test_003", "run_test_004"]


# ---- coroutines that yield


@cocotb.coroutine
def wait_clock_cycles(clock, number):
    for _ in range(number):
        yield RisingEdge(clock)


@cocotb.coroutine
def old_reset(dut):
    dut.rst_n <= 0
    yield wait_clock_cycles(dut.clk, 3)
    dut.rst_n <= 1
    raise ReturnValue("out of reset")


@cocotb.test()
def a_test_that_yields(dut):
    cocotb.fork(Clock(dut.clk, 10000).start())
    said = yield old_reset(dut)
    assert said == "out of reset"
    dut.ena <= 1
    dut.ui_in <= BinaryValue(7, n_bits=8, bigEndian=False)
    came = yield [RisingEdge(dut.tick), Timer(1, "us")]
    assert isinstance(came, RisingEdge)
    task = cocotb.fork(wait_clock_cycles(dut.clk, 2))
    yield task.join()
    yield Timer(1, "ns")
    if dut.uo_out.value != 21:
        raise TestFailure(f"{dut.uo_out.value.integer}")
    raise TestSuccess("as it should be")


@cocotb.test(expect_fail=True)
def a_failure_of_old_is_a_failure(dut):
    yield Timer(1)
    raise TestFailure("on purpose")


@cocotb.test(expect_error=TestError)
async def an_error_of_old_is_an_error(dut):
    raise TestError("on purpose")


# ---- parameters, hierarchy, internals


@cocotb.test()
async def parameters_are_read(dut):
    assert dut.WIDTH.value == 8 and int(dut.N.value) == 4 and int(cocotb.top.DOUBLE) == 16 and dut.NAME.value == "idioms"
    assert dut.lane[2].u_adds.BY.value == 2 and 1 << dut.N.value == 16 and dut.N == 4
    with pytest.raises(AttributeError, match="WITH"):
        dut.WITH.value


@cocotb.test()
async def the_hierarchy_is_walked(dut):
    names = {child._name for child in dut}
    assert {"clk", "ui_in", "sum", "lane[0]" if "lane[0]" in names else "lane"} <= names
    assert dut._name == "idioms" and dut.ui_in._name == "ui_in" and hasattr(dut, "clk") and not hasattr(dut, "clock")
    assert dut._id("clk", extended=False) is dut.clk and getattr(dut, "ui_" + "in") is dut.ui_in
    dut._discover_all()
    for lane in range(4):
        dut.a_i[lane].value = 10 * lane
    await Timer(1, "ns")
    for lane in range(4):
        assert dut.lane[lane].u_adds.y.value == 11 * lane
    assert dut.lane[2].u_adds._path == "idioms.lane[2].u_adds" and dut._path == "idioms"
    with pytest.raises(AttributeError, match=r"no signal 'lane\[2\].u_adds.z'"):
        dut.lane[2].u_adds.z
    assert isinstance(dut.clk, ModifiableObject) and isinstance(dut, SimHandleBase)


@cocotb.test()
async def internals_and_states_are_watched(dut):
    cocotb.start_soon(Clock(dut.clk, 10, "ns").start())
    await reset_active_low(dut)
    dut.ena.value = 1
    states = []
    for _ in range(4):
        await RisingEdge(dut.clk)
        await ReadOnly()
        states.append(int(dut.state.value))
    assert states == [1, 2, 0, 1]
    await FallingEdge(dut.clk)
    dut.sum.value = 100  # a deposit into a register
    await ReadWrite()
    assert dut.uo_out.value == 100


# ---- arrays and bits


@cocotb.test()
async def arrays_go_from_left_to_right(dut):
    dut.a_i.value = [1, 2, 3, 4]
    dut.down_i.value = [3, 2, 1]  # [2:0]: element 2 first
    await Timer(1, "ns")
    assert dut.b_o.value == [1, 3, 5, 7] and [int(v) for v in dut.b_o.value] == [1, 3, 5, 7]
    assert [element.value.integer for element in dut.b_o] == [1, 3, 5, 7]
    assert dut.down_i[2].value == 3 and dut.down_i[0].value == 1 and dut.down_o.value == 0b11_10_01
    assert np.array_equal(np.asarray(dut.down_i), [3, 2, 1]) and dut.b_o.value[1].binstr == "00000011"
    dut.a_i.value = [LogicArray("11110000"), "00001111", Logic(1), np.uint8(9)]
    await Timer(1, "ns")
    assert list(dut.a_i.value) == [0xF0, 0x0F, 1, 9]
    dut.mem.value = range(16)
    await Timer(1, "ns")
    assert dut.mem[15].value == 0 and dut.mem[0].value == 15


@cocotb.test()
async def bits_are_read_and_written(dut):
    dut.ui_in.value = 0b1010_0101
    await Timer(1, "ns")
    value = dut.ui_in.value
    assert "".join(str(bit) for bit in value) == "10100101" and [int(b) for b in reversed(value)] == [1, 0, 1, 0, 0, 1, 0, 1]
    assert value[0] == 1 and value[1] == 0 and value[7:4] == 0b1010 and value[7:4].binstr == "1010" and value[3].is_resolvable
    dut.ui_in[1].value = 1
    dut.ui_in[7].value = 0
    dut.ui_in[3:2].value = "10"
    await Timer(1, "ns")
    assert dut.ui_in.value == 0b0010_1011 and dut.ui_in[1].value == 1 and dut.ui_in[3:2].value == 2
    for bit in range(len(dut.ui_in)):
        dut.ui_in[bit].value = bit % 2
    await Timer(1, "ns")
    assert dut.ui_in.value == 0b1010_1010
    with pytest.raises(OverflowError):
        dut.ui_in[3].value = 2
    with pytest.raises(IndexError):
        dut.ui_in[8]
    with pytest.raises(TypeError):
        RisingEdge(dut.ui_in[3:2])


@cocotb.test()
async def values_of_all_kinds_are_written(dut):
    for value, number in [
        (True, 1), (np.int64(5), 5), (-1, 255), ("00000110", 6), (LogicArray(7, 8), 7), (LogicArray("1000"), 8),
        (LogicArray.from_signed(-2, Range(7, "downto", 0)), 254), (BinaryValue(9, n_bits=8, bigEndian=False), 9), (Bit(1), 1), (Logic("0"), 0),
        (Deposit(11), 11), (Immediate(12), 12), (concat(LogicArray("1"), "101"), 13),
    ]:  # fmt: skip
        dut.ui_in.value = value
        await Timer(1, "ns")
        assert dut.ui_in.value == number, value
    dut.ui_in.value = dut.ui_in.value + 1
    await Timer(1, "ns")
    assert dut.ui_in.value == 14 and dut.ui_in.value.to_bytes() == b"\x0e" and -dut.ui_in.value == -14
    for unknown in (LogicArray("XXXXZZZZ"), BinaryValue("zzzzzzzz"), "xxxxxxxx"):
        with pytest.raises((ValueError, TypeError), match="neither 0 nor 1|takes an integer|digits 0 and 1"):
            dut.ui_in.value = unknown
    dut.ui_in.value = Force(1)
    await Timer(1, "ns")
    assert dut.ui_in.value == 1
    with pytest.raises(TypeError, match=r"ui_in.value = 3"):
        dut.ui_in = 3


# ---- tasks and triggers


@cocotb.test()
async def tasks_are_joined_in_every_way(dut):
    async def give(what, after):
        await Timer(after, "ns")
        return what

    task: Task[Any] = cocotb.start_soon(give("a", 2))
    assert await task == "a" and await task.join() == "a" and await Join(task) == "a" and await task.complete == "a"
    assert await First(cocotb.start_soon(give("b", 3)), Timer(1, "us")) == "b"
    await Combine(cocotb.start_soon(give(1, 1)), cocotb.start_soon(give(2, 2)), Timer(3, "ns"))
    assert await gather(give(1, 2), give(2, 1)) == (1, 2)
    assert await select(give(1, 20), give(2, 10)) == (1, 2)
    which, trigger = await select(Timer(5, "us"), timer := Timer(1, "ns"))
    assert which == 1 and trigger is timer
    created = cocotb.create_task(give("c", 1))
    assert await with_timeout(created, 1, "us") == "c" and await with_timeout(give("d", 1), 1, "us") == "d"

    async def fail():
        await Timer(1, "ns")
        raise KeyError("k")

    results = await gather(give(1, 5), fail(), return_exceptions=True)
    assert results[0] == 1 and isinstance(results[1], KeyError)
    with pytest.raises(KeyError):
        await gather(give(1, 5), fail())


async def ends(after, how, seen):
    """Returns ``how``, or raises it if it is an exception; lists what was cancelled."""
    try:
        await Timer(after, "ns")
    except BaseException:
        seen.append((how, get_sim_time("ns")))
        raise
    if isinstance(how, Exception):
        raise how
    return how


@cocotb.test()
@cocotb.parametrize(together=[gather, select])
async def the_first_error_ends_all(dut, together):
    seen = []
    errors = [ends(1, KeyError(text), seen) for text in ("first", "second")]
    with pytest.raises(KeyError, match="first"):
        await together(*errors, ends(1, "of the same step", seen), ends(5, "late", seen))
    assert [str(how) for how, _ in seen] == ["'second'", "of the same step", "late"] and {when for _, when in seen} == {1}
    await Timer(10, "ns")

    async def fails_at_once():
        raise KeyError("at once")

    with pytest.raises(KeyError, match="at once"):
        await together(fails_at_once(), never_started := ends(1, "late", []))
    assert never_started.cr_frame is None


@cocotb.test()
@cocotb.parametrize(together=[gather, select])
async def all_end_with_their_caller(dut, together):
    start, seen = get_sim_time("ns"), []
    inner = cocotb.start_soon(ends(20, "a task of the bench", seen))
    with pytest.raises(cocotb.triggers.SimTimeoutError):
        await with_timeout(together(ends(10, "a", seen), ends(20, "b", seen), inner), 4, "ns")
    assert seen == [("a", start + 4), ("b", start + 4)] and not inner.done()
    caller = cocotb.start_soon(together(ends(10, "c", seen), Timer(1, "us")))
    await Timer(1, "ns")
    caller.cancel()
    assert seen[2:] == [("c", start + 5)] and await inner == "a task of the bench"
    outer = cocotb.start_soon(with_timeout(ends(10, "d", seen), 1, "us"))
    await Timer(1, "ns")
    outer.cancel()
    assert seen[3:] == [("d", start + 21)]


@cocotb.test()
async def cancelled_tasks_end_what_awaits_them(dut):
    seen = []
    task = cocotb.start_soon(ends(5, "cancelled", []))
    waiting = cocotb.start_soon(gather(task, ends(5, "other", seen)))
    await Timer(1, "ns")
    task.cancel()
    with pytest.raises(CancelledError):
        await waiting
    assert seen == [("other", 1)] and await gather() == ()
    with pytest.raises(ValueError, match="select of nothing"):
        await select()


@cocotb.test()
async def a_time_limit_gives_what_came(dut):
    soon, late = Timer(1, "ns"), Timer(1, "us")
    assert await with_timeout(soon, 1, "ms") is soon and await with_timeout(First(late, soon), 1, "ms") is soon
    both = Combine(soon, Timer(2, "ns"))
    assert await with_timeout(both, 1, "ms") is both
    for wait in (lambda task: task, lambda task: task.join(), lambda task: task.complete, Join):
        task = cocotb.start_soon(ends(1, "result", []))
        assert await with_timeout(wait(task), 1, "ms") == "result"
    assert await with_timeout(First(late, cocotb.start_soon(ends(1, None, []))), 1, "ms") is None


@cocotb.test()
async def edges_are_named_in_every_way(dut):
    Clock(dut.clk, Decimal(10), "ns").start(start_high=False)
    await ClockCycles(dut.clk, 2, FallingEdge)
    assert get_sim_time("ns") == 20 and dut.clk.value == 0
    await ClockCycles(dut.clk, 2, rising=True)
    await ClockCycles(dut.clk, num_cycles=1, rising=False)
    assert get_sim_time("ns") == 40
    await Timer(Decimal("2.5"), "ns", round_mode="round")
    await Timer(1500, "step")
    await Timer(get_sim_steps(1, "ns"))
    assert get_sim_time("ns") == 45 and isinstance(get_sim_time("ns"), (int, float))
    lock = Lock()
    async with lock:
        assert lock.locked()


@cocotb.test()
async def random_times_are_rounded(dut):
    await Timer(17.353715901410474, "ns", round_mode="ceil")
    assert get_sim_time("step") == 17_354
    await Timer(2.0006, "ns", round_mode="round")
    assert get_sim_time("step") == 19_355
    await with_timeout(Timer(1, "ns"), 1.23456789, "ns", round_mode="floor")
    for mode, text in (("error", "not a whole number of steps"), ("up", "no round_mode 'up'")):
        with pytest.raises(ValueError, match=text):
            Timer(0.0001, "ns", round_mode=mode)


@cocotb.test()
async def all_of_no_triggers_comes_at_once(dut):
    await Combine(*[])
    assert get_sim_time("step") == 0
    with pytest.raises(ValueError, match="First of nothing"):
        First(*[])


@cocotb.test()
async def values_are_made_by_the_class_of_others(dut):
    kind = type(dut.uo_out.value)
    value = kind("0110")
    assert value == 6 and len(value) == 4 and value.binstr == "0110" and kind("") == 0
    assert kind(5, 8).binstr == "00000101" and kind(-1, 3) == 7 and kind(2, Range(3, "downto", 0)).n_bits == 4
    for digits in ("1" + "0" * 31, "10" * 20, "1" + "0" * 63, "101" * 40):
        assert kind(digits) == int(digits, 2) and kind(digits).binstr == digits
    assert kind(LogicArray("0011")) == 3 and kind(kind("0011")).binstr == "0011"
    for wrong in ("01X", "Z"):
        with pytest.raises(ValueError, match="0 and 1 only"):
            kind(wrong)
    with pytest.raises(OverflowError, match="300 does not fit 8"):
        kind(300, 8)


@cocotb.test()
async def what_a_simulation_is_asked_for(dut):
    assert cocotb.is_simulation and simulator.is_running() and cocotb.LANGUAGE == "verilog" and cocotb.plusargs == {}
    assert cocotb.RANDOM_SEED == cocotb.random_seed and cocotb.__version__.split(".")[0] == "2"
    assert isinstance(cocotb.log, logging.Logger) and cocotb.log.isEnabledFor(logging.CRITICAL)


@cocotb.test()
async def a_queue_is_joined(dut):
    queue: Queue[int] = Queue()
    done = []

    async def work():
        while True:
            item = await queue.get()
            await Timer(1, "ns")
            done.append(item)
            queue.task_done()

    await queue.join()
    worker = cocotb.start_soon(work())
    for item in range(3):
        queue.put_nowait(item)
    await queue.join()
    assert done == [0, 1, 2] and worker.cancel("enough")
    with pytest.raises(ValueError, match="more often"):
        queue.task_done()


@cocotb.skipif(True, reason="on purpose")
@cocotb.test
async def left_out(dut):
    raise AssertionError


@cocotb.test
@cocotb.xfail(raises=KeyError)
async def raises_as_expected(dut):
    raise KeyError


@cocotb.xfail()
@cocotb.test()
@cocotb.parametrize(number=[1, 2])
async def fails_as_expected(dut, number):
    assert number == 3


# ---- a testbench in Verilog, without ports, as TinyTapeout has it


@cocotb.test(design=Design("designs/portless.v", top="tb"))
async def a_testbench_without_ports(dut):
    dut._log.info("Start")
    clock = Clock(dut.clk, 10, unit="us")
    cocotb.start_soon(clock.start())
    dut.ena.value = 1
    dut.ui_in.value = 0
    dut.rst_n.value = 0
    await ClockCycles(dut.clk, 10)
    assert dut.uo_out.value == 0
    dut.rst_n.value = 1
    dut.ui_in.value = 20
    await ClockCycles(dut.clk, 3)
    assert dut.uo_out.value == 40
    await ReadOnly()
    assert dut.uo_out.value == 60 and dut.user_project.count.value == 60


# ---- values of benches


def test_values_of_benches():
    value = BinaryValue(n_bits=8, bigEndian=False, binaryRepresentation=BinaryRepresentation.TWOS_COMPLEMENT)
    assert value.binstr == "" and value.n_bits == 8
    value.integer = -56
    assert (value.binstr, value.integer, value.signed_integer, value.value, value[0] == 0, value[7] == 1) == (
        "11001000", -56, -56, -56, True, True,
    )  # fmt: skip
    value.binstr = "00000001"
    assert value == 1 and value[0] == 1 and value.n_bits == len(value) == 8 and value.buff == b"\x01"
    value.assign("1010")
    assert value.binstr == "00001010"
    big = BinaryValue("10000000")
    assert big[0] == 1 and big[0:3].binstr == "1000" and BinaryValue(value=b"\x12\x34", n_bits=16).integer == 0x1234

    array = LogicArray("1X0Z")
    assert array[3] == "1" and array[2] == Logic("X") and array[3:2] == "1X" and not array.is_resolvable and array != 8
    assert str(array & "1100") == "1X00" and str(array | "0011") == "1X11" and str(~array) == "0X1X"
    with pytest.raises(ValueError, match="neither 0 nor 1"):
        array.to_unsigned()
    array[2] = 0
    array[1:0] = "11"
    assert array == LogicArray("1011") == 11 and array.to_signed() == -5 and int(array) == 11 and array in {11, 12}
    assert LogicArray("X") != LogicArray("0") and LogicArray(5, Range(0, "to", 3))[0] == 0 and list(LogicArray("01")) == [0, 1]
    assert LogicArray.from_unsigned(5, 4) == "0101" and LogicArray.from_bytes(b"\x80").to_signed() == -128
    for wrong in (lambda: LogicArray.from_unsigned(-1, 4), lambda: LogicArray(16, 4), lambda: LogicArray.from_signed(8, 4)):
        with pytest.raises(OverflowError):
            wrong()
    assert Logic("Z") == "Z" and bool(Logic(1)) and not Logic("0") and (Logic("X") & 0) == 0 and Logic(1) ^ 1 == 0
    assert list(Range(3, "downto", 1)) == [3, 2, 1] and len(Range(0, 7)) == 8 and Array([1, 2]).range == Range(0, "to", 1)
    with pytest.raises(ValueError, match="no digit"):
        Logic("2")


def test_binary_values_are_those_of_cocotb_1_9():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # digits that are cut off
        found = [binary_values.row(BinaryValue, case) for case in binary_values.cases()]
    expected = binary_values.TABLE.read_text().splitlines()
    assert len(expected) == binary_values.COUNT
    assert [pair for pair in zip(found, expected) if pair[0] != pair[1]] == []


def test_binary_values_that_do_not_fit():
    with pytest.warns(RuntimeWarning, match="'110' has more than 2 digits: '10' is left"):
        assert BinaryValue("110", n_bits=2).binstr == "10"
    for number, representation in ((8, BinaryRepresentation.UNSIGNED), (4, BinaryRepresentation.TWOS_COMPLEMENT), (-5, BinaryRepresentation.TWOS_COMPLEMENT)):
        with pytest.raises(OverflowError, match=f"{number} does not fit 3 digits"):
            BinaryValue(number, 3, binaryRepresentation=representation)
    with pytest.raises(OverflowError, match="-1 does not fit 8 digits"):
        BinaryValue(-1, 8)
    assert BinaryValue(0, 8, binaryRepresentation=BinaryRepresentation.TWOS_COMPLEMENT).binstr == "00000000"


def test_slices_go_in_the_direction_of_the_range():
    digits = LogicArray("1010")
    assert digits[3:2] == "10" and digits[2:2] == "0" and digits[:] == "1010" and digits[1:].range == Range(1, "downto", 0)
    for array in (digits, LogicArray("1010", Range(0, "to", 3)), Array([1, 0, 1, 0], Range(3, "downto", 0))):
        first, last = array.right, array.left
        with pytest.raises(IndexError, match="direction"):
            array[first:last]
        with pytest.raises(IndexError, match="direction"):
            array[first:last] = "0000"
        for part in (slice(None, None, 1), slice(array.left, array.right, 2)):
            with pytest.raises(IndexError, match="step"):
                array[part]
            with pytest.raises(IndexError, match="step"):
                array[part] = "0000"
        with pytest.raises(IndexError, match="index 4"):
            array[4]
        assert list(array) == [1, 0, 1, 0]


def test_arrays_have_the_indices_of_their_range():
    array = Array([1, 2, 3], Range(2, "downto", 0))
    assert array[2] == 1 and array[0] == 3 and list(array) == [1, 2, 3] and list(reversed(array)) == [3, 2, 1] and len(array) == 3
    assert array[2:1] == Array([1, 2]) == [1, 2] and array[1:].range == Range(1, "downto", 0) and 2 in array and 4 not in array
    assert (array.left, array.direction, array.right) == (2, "downto", 0) and array.index(3) == 0 and array.count(3) == 1
    assert array == [1, 2, 3] == array and array == (1, 2, 3) and array != [3, 2, 1] and array == Array([1, 2, 3], Range(-1, 1)) and array != 6
    assert np.array_equal(np.asarray(array), [1, 2, 3]) and repr(array) == "Array([1, 2, 3], Range(2, 'downto', 0))"
    array[0], array[2:1] = 9, [7, 8]
    assert array == [7, 8, 9]
    array.range = Range(-1, "downto", -3)
    assert array[-3] == 9 and array[-1:-2] == [7, 8]
    assert Array("abc").range == Range(0, "to", 2) and Array("abc", 3)[2] == "c" and len(Array([], Range(1, "to", 0))) == 0
    with pytest.raises(ValueError, match="3"):
        Array([1, 2, 3], Range(3, "downto", 0))
    with pytest.raises(ValueError, match="4"):
        array.range = Range(3, "downto", 0)
    with pytest.raises(ValueError, match="not in"):
        array.index(1)
    for wrong in ([1], [1, 2, 3]):
        with pytest.raises(ValueError, match="2"):
            array[-1:-2] = wrong
    with pytest.raises(TypeError, match="no range"):
        Array([1], "0:0")
