"""Benches as cocotb's users write them, version 1's habits and version 2's, with only the imports changed."""

import io
import logging
import random
import subprocess
import sys
from pathlib import Path

import pytest

import hoverlock.cocotb as cocotb
from hoverlock import Design
from hoverlock.cocotb.binary import BinaryValue
from hoverlock.cocotb.clock import Clock
from hoverlock.cocotb.handle import SimHandleBase
from hoverlock.cocotb.queue import Queue
from hoverlock.cocotb.regression import TestFactory
from hoverlock.cocotb.runner import get_results, get_runner
from hoverlock.cocotb.triggers import ClockCycles, Combine, FallingEdge, First, Join, ReadOnly, RisingEdge, Timer, with_timeout
from hoverlock.cocotb.types import LogicArray
from hoverlock.cocotb.utils import get_sim_time

adder = Design("designs/adder.v", top="adder")
dff = Design("designs/dff.v", top="dff")
matrix = Design("designs/matrix_multiplier.v", top="matrix_multiplier")
counter = Design("designs/counter.v", top="counter")


@cocotb.test(design=adder)
async def adder_basic_test(dut):
    """Test for 5 + 10"""
    dut.A.value = 5
    dut.B.value = 10
    await Timer(2, units="ns")
    assert dut.X.value == 15, f"Adder result is incorrect: {dut.X.value} != 15"


@cocotb.test(design=adder)
async def adder_randomised_test(dut):
    for _ in range(10):
        a, b = random.randint(0, 15), random.randint(0, 15)
        dut.A.value = a
        dut.B.value = b
        await Timer(2, unit="ns")
        assert dut.X.value == a + b, "Randomised test failed with: {A} + {B} = {X}".format(
            A=dut.A.value, B=dut.B.value, X=dut.X.value
        )


@cocotb.test(design=dff)
async def dff_simple_test(dut):
    """d propagates to q"""
    dut.d.value = 0
    clock = Clock(dut.clk, 10, units="us")
    cocotb.start_soon(clock.start(start_high=False))
    await RisingEdge(dut.clk)
    expected = 0
    for i in range(10):
        val = random.randint(0, 1)
        dut.d.value = val
        await RisingEdge(dut.clk)
        assert dut.q.value == expected, f"output q was incorrect on the {i}th cycle"
        expected = val
    await RisingEdge(dut.clk)
    assert dut.q.value == expected
    assert get_sim_time("us") == 115  # the first edge after half a period, then 11 more


class DataValidMonitor:
    """Puts what passes into a queue, as the matrix multiplier's bench does."""

    def __init__(self, clk: SimHandleBase, valid: SimHandleBase, datas: dict):
        self.values = Queue()
        self._clk, self._valid, self._datas, self._coro = clk, valid, datas, None

    def start(self):
        if self._coro is not None:
            raise RuntimeError("Monitor already started")
        self._coro = cocotb.start_soon(self._run())

    def stop(self):
        self._coro.kill()
        self._coro = None

    async def _run(self):
        while True:
            await RisingEdge(self._clk)
            if self._valid.value.binstr != "1":
                await RisingEdge(self._valid)
                continue
            self.values.put_nowait({name: handle.value for name, handle in self._datas.items()})


@cocotb.test(design=matrix, expect_error=IndexError if cocotb.SIM_NAME.lower().startswith("ghdl") else ())
async def multiply_test(dut):
    cocotb.start_soon(Clock(dut.clk_i, 10, units="ns").start())
    outputs = DataValidMonitor(dut.clk_i, dut.valid_o, {"C": dut.c_o})
    dut.reset_i.value = 1
    dut.valid_i.value = 0
    for _ in range(3):
        await RisingEdge(dut.clk_i)
    dut.reset_i.value = 0
    outputs.start()
    dut._log.info("Test multiplication operations")

    def pack(values, bits):
        return sum(v << (bits * i) for i, v in enumerate(values))

    for _ in range(20):
        a = [random.getrandbits(8) for _ in range(6)]
        b = [random.getrandbits(8) for _ in range(6)]
        await RisingEdge(dut.clk_i)
        dut.a_i.value = pack(a, 8)
        dut.b_i.value = pack(b, 8)
        dut.valid_i.value = 1
        await RisingEdge(dut.clk_i)
        dut.valid_i.value = 0
        await RisingEdge(dut.valid_o)
        await ReadOnly()
        expected = [sum(a[r * 3 + k] * b[k * 2 + c] for k in range(3)) for r in range(2) for c in range(2)]
        assert dut.c_o.value.integer == pack(expected, 18)
        await FallingEdge(dut.valid_o)
    outputs.stop()


@cocotb.test(design=counter)
async def counter_test(dut):
    """cocotb 2's habits: start() of a clock gives the task, `start_soon` of a task is allowed."""
    assert cocotb.top is dut and isinstance(cocotb.RANDOM_SEED, int)
    Clock(dut.clk, 10, unit="ns").start()
    dut.enable.value, dut.step.value = 1, LogicArray("00000001")
    task = cocotb.start_soon(ClockCyclesThen(dut.clk, 3))
    done = await First(task, Timer(1, unit="us"))
    assert done == "done" and task.done()
    assert await Join(task) == "done" and await task.join() == "done"
    assert dut.count.value.to_unsigned() == 2 and dut.count.value.is_resolvable
    dut.step.value = BinaryValue("00000111")
    await with_timeout(Combine(RisingEdge(dut.clk), cocotb.start_soon(ClockCyclesThen(dut.clk, 2))), 1, "us")
    assert dut.count.value == 3 + 7  # one step of 1 at the first edge, then one of 7
    with pytest.raises(AttributeError, match="Coming from cocotb"):
        cocotb.does_not_exist


async def ClockCyclesThen(clk, count):
    await ClockCycles(clk, count)
    return "done"


async def add(dut, a, b):
    dut.A.value, dut.B.value = a, b
    await Timer(1, "ns")
    assert int(dut.X.value) == a + b


def test_factories_make_one_test_for_each_combination(monkeypatch):
    factory = TestFactory(add)
    factory.add_option("a", [1, 2])
    factory.add_option("b", [3, 4, 5])
    factory.generate_tests(prefix="made_")
    made = {name: value for name, value in globals().items() if name.startswith("made_add")}
    try:
        assert sorted(made) == [f"made_add_{n:03d}" for n in range(1, 7)]
        for test in made.values():
            test.run(adder, seed=1)
    finally:
        for name in made:
            del globals()[name]


def test_the_runner_builds_and_tests(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "test_it.py").write_text(
        "import hoverlock.cocotb as cocotb\n"
        "from hoverlock.cocotb.triggers import Timer\n"
        "@cocotb.test()\n"
        "async def sums(dut):\n"
        "    dut.A.value, dut.B.value = 200, 100\n"
        "    await Timer(1, units='ns')\n"
        "    assert dut.X.value == 300\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    runner = get_runner("verilator")
    source = Path(__file__).parent / "designs" / "adder.v"
    runner.build(verilog_sources=[source], hdl_toplevel="adder", parameters={"DATA_WIDTH": 8}, always=True)
    results = runner.test(hdl_toplevel="adder", test_module="test_it")
    assert 'failures="0"' in results.read_text() and 'tests="1"' in results.read_text()
    assert get_results(results) == (1, 0)
    with pytest.raises(ValueError, match="no simulator 'none'"):
        get_runner("none")


def test_the_runner_reaches_internals_when_a_bench_asks_for_them(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "test_inner.py").write_text(
        "import hoverlock.cocotb as cocotb\n"
        "@cocotb.test()\n"
        "async def looks_inside(dut):\n"
        "    assert dut.sum.value == 0 and dut.lane[1].u_adds.BY.value == 1\n"
        "@cocotb.test()\n"
        "async def mistypes(dut):\n"
        "    dut.summ.value\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    runner = get_runner("verilator")
    runner.build(sources=[Path(__file__).parent / "designs" / "idioms.sv"], hdl_toplevel="idioms")
    runner.test(hdl_toplevel="idioms", test_module="test_inner", testcase="looks_inside")
    assert "all tests run again" in capsys.readouterr().out
    with pytest.raises(SystemExit, match="failed: test_inner.mistypes"):
        runner.test(hdl_toplevel="idioms", test_module="test_inner")
    # Outside of pytest the caller looks at the results, as with cocotb.
    monkeypatch.delenv("PYTEST_CURRENT_TEST")
    assert get_results(runner.test(hdl_toplevel="idioms", test_module="test_inner")) == (2, 1)


def test_the_runner_runs_each_bench_in_a_process_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "chosen.py").write_text("import os\nVALUE = os.environ['VALUE']\n")
    (tmp_path / "test_env.py").write_text(
        "import ctypes, os, chosen\nimport hoverlock.cocotb as cocotb\n"
        "@cocotb.test()\nasync def sees_its_environment(dut):\n    assert chosen.VALUE == os.environ['VALUE']\n"
        "@cocotb.test()\nasync def ends_the_process(dut):\n    ctypes.CDLL(None)._exit(0)\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    runner = get_runner("icarus")
    source = Path(__file__).parent / "designs" / "adder.v"
    runner.build(sources=[source], hdl_toplevel="adder", build_args=["-g2012", "-Padder.DATA_WIDTH=3"])
    for value in ("1", "2"):
        runner.test(test_module="test_env", testcase="sees_its_environment", extra_env={"VALUE": value})
    with pytest.raises(SystemExit, match="failed: test_env.ends_the_process"):
        runner.test(test_module="test_env", extra_env={"VALUE": "3"})


@pytest.mark.parametrize("how", ["from cocotb.log import SimLog", "import cocotb.log", "import cocotb.logging"])
def test_the_logger_of_the_package_stays_when_its_module_is_imported(how):
    code = f"import hoverlock; hoverlock.as_cocotb(); {how}; import cocotb; cocotb.log.warning('seen')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0 and "seen" in done.stderr, done.stderr


def test_log_lines_carry_simulation_time(caplog):
    from hoverlock.log import SimTimeFormatter

    record = logging.LogRecord("hoverlock.x", logging.INFO, "f", 1, "text", None, None)
    assert SimTimeFormatter().format(record).startswith("           0ns INFO")


def test_lines_written_without_a_record_are_those_of_a_record(monkeypatch, capsys):
    from hoverlock import log

    logger = log._Logger("cocotb.tb")
    logger.propagate = False
    handler = log._Handler(io.StringIO())
    handler.setFormatter(log.SimTimeFormatter())
    logger.addHandler(handler)

    def lines() -> str:
        handler.stream = io.StringIO()
        logger.info("plain 100 %")
        logger.warning("%s and %d", "text", 3)
        logger.error("%(name)s", {"name": "by name"})
        logger.log(37, {"a": 1})
        return handler.stream.getvalue()

    with monkeypatch.context() as without:
        without.setattr(logging.Logger, "makeRecord", lambda *_: pytest.fail("a record was made"))
        written = lines()
    handler.addFilter(lambda record: bool(record.created))  # a filter reads the record
    assert written == lines() and written.count("\n") == 4
    handler.filters.clear()
    handler.stream = io.StringIO()
    handler.setLevel(logging.ERROR)
    logger.warning("below the level of the handler")
    assert handler.stream.getvalue() == ""
    handler.setLevel(logging.NOTSET)
    logger.info("%d", "no number")
    assert "Logging error" in capsys.readouterr().err
    try:
        raise ValueError("seen")
    except ValueError:
        logger.exception("with its traceback")
    assert "ValueError: seen" in handler.stream.getvalue()


def test_another_handler_gets_records_with_their_caller():
    from hoverlock import log

    parent, logger = logging.Logger("parent"), log._Logger("child")
    logger.parent = parent
    logger.addHandler(log._Handler(io.StringIO()))
    logger.handlers[0].setFormatter(log.SimTimeFormatter())
    other = logging.StreamHandler(io.StringIO())
    other.setFormatter(logging.Formatter("%(filename)s %(funcName)s %(message)s"))
    parent.addHandler(other)
    logger.info("text")
    assert other.stream.getvalue() == "test_cocotb_compatibility.py test_another_handler_gets_records_with_their_caller text\n"
    assert logger.handlers[0].stream.getvalue().endswith("text\n")
