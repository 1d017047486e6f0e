"""The differences from cocotb: the table of "Coming from cocotb", with a bench that demonstrates each row.

    python docs/differences.py          writes the table into the page
"""

from __future__ import annotations

import asyncio
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

import hoverlock
import hoverlock.cocotb as cocotb
from hoverlock import Clock, ClockCycles, Design, First, ReadOnly, RisingEdge, Session, Timer, deprecated, simulate, start_soon, writes
from hoverlock.cocotb import types
from hoverlock.cocotb.binary import BinaryRepresentation, BinaryValue
from hoverlock.cocotb.handle import Force, Freeze, Release
from hoverlock.cocotb.types import LogicArray

HERE = Path(__file__).resolve().parent
PAGE = HERE / "coming-from-cocotb.md"
BEGIN, END = "<!-- written by docs/differences.py -->\n", "<!-- end -->\n"

DESIGNS = HERE.parent / "tests" / "designs"
counter = Design(DESIGNS / "counter.v", top="counter")
talker = Design(DESIGNS / "talker.v", top="talker")
adder = Design(HERE.parents[1] / "tests" / "designs" / "overrides.v", top="overrides", internals=["u_adder.*"])
generated = Design(DESIGNS / "generated.sv", top="generated", internals=["*"])
idioms = Design(DESIGNS / "idioms.sv", top="idioms", internals=["*"])


@dataclass
class Difference:
    """A row of the table."""

    what: str
    cocotb: str
    here: str
    why: str
    check: Callable[[], Any]


ROWS: list[Difference] = []


def row(what: str, of_cocotb: str, here: str, why: str = "") -> Callable[[Callable[[], Any]], Callable[[], Any]]:
    """Adds a row. The decorated function demonstrates it, and raises if the row is wrong."""

    def add(check: Callable[[], Any]) -> Callable[[], Any]:
        ROWS.append(Difference(what, of_cocotb, here, why, check))
        return check

    return add


def bench(design: Design = counter) -> Callable[[Any], Callable[[], Any]]:
    """Returns a decorator that makes a bench on a design the check of a row."""
    return lambda coroutine: lambda: simulate(design, coroutine)


@row(
    "states", "0, 1, X, Z",
    "signals have 0 and 1; values that a bench creates, such as `LogicArray(\"1X\")`, have all four. `Design(..., "
    "random_initial=True)` starts registers without a reset with random bits, which finds a missing reset",
    "Verilator has two states",
)  # fmt: skip
def states() -> None:
    async def first(dut: Any) -> int:
        return int(dut.count.value)

    assert simulate(counter, first) == 0
    started = counter.changed(random_initial=True)
    assert len({simulate(started, first, seed=seed) for seed in range(8)}) > 2 and str(LogicArray("1X")) == "1X"


@row(
    "`X` and `Z` written to a signal", "written",
    "an error. Under the alias 0, or what `COCOTB_RESOLVE_X` selects (`zeros`, `ones`, `random`, `weak`, `error`), with "
    "one warning for each signal; without the alias `hoverlock.unknown.set_choice` selects it",
    "two states",
)  # fmt: skip
@bench()
async def unknown_written(dut: Any) -> None:
    with pytest.raises(ValueError, match="Verilator has no X"):
        dut.step.value = LogicArray("XXXXXXXX")
    with hoverlock.unknown.written_as("ones"):
        dut.step.value = "XXXX0000"
    await Timer(1, "ns")
    assert dut.step.value == 0xF0
    with hoverlock.unknown.written_as("weak"):
        dut.step.value = "LLHH0011"
        with pytest.raises(ValueError, match="Verilator has no X"):
            dut.step.value = "LLHH00XX"
    await Timer(1, "ns")
    assert dut.step.value == 0x33


@row(
    "a fresh model", "all tests of a run share one simulation",
    "each test has its own model, at time 0; a write through a handle of a test that has ended is an error",
    "a test has the same result alone and among others; a model costs microseconds",
)  # fmt: skip
def fresh_model() -> None:
    kept: list[Any] = []

    async def bench(dut: Any) -> float:
        kept.append(dut.step)
        await Timer(3, "ns")
        return hoverlock.get_sim_time("ns")

    assert simulate(counter, bench) == simulate(counter, bench) == 3
    with pytest.raises(hoverlock.SimulationError, match="a simulation that has ended"):
        kept[0].value = 1


@row(
    "region of a read after an edge", "depends on the simulator's VPI",
    "registers always show their value before the edge. `Design(..., edges_after_eval=True)` shows the value after it",
    "a race in a bench always has the same outcome",
)  # fmt: skip
def region_of_reads() -> None:
    async def third(dut: Any) -> int:
        Clock(dut.clk, 10, "ns").start()
        dut.enable.value, dut.step.value = 1, 1
        await ClockCycles(dut.clk, 3)
        return int(dut.count.value)

    assert simulate(counter, third) == 2 and simulate(counter.changed(edges_after_eval=True), third) == 3


@row(
    "`Timer` that ends at a clock edge", "a write then races with the edge",
    "the edge samples the new value; a warning is logged once",
    "as in other simulators",
)  # fmt: skip
@bench()
async def timer_at_an_edge(dut: Any) -> None:
    Clock(dut.clk, 10, "ns").start()
    await Timer(20, "ns")
    dut.enable.value, dut.step.value = 1, 5
    await Timer(1, "ns")
    assert dut.count.value == 5


@row(
    "writes to outputs of the top", "the value stays until the design assigns it again",
    "the same under the alias, with one warning for each signal; otherwise an error",
)  # fmt: skip
def writes_to_outputs() -> None:
    writes.set_deposits_on_outputs(True)
    try:
        simulate(counter, _deposits)
    finally:
        writes.set_deposits_on_outputs(False)
    simulate(counter, _is_refused)


async def _deposits(dut: Any) -> None:
    dut.count.value, dut.enable.value, dut.step.value = 5, 1, 3
    await Timer(1, "ns")
    assert dut.count.value == 5
    Clock(dut.clk, 10, "ns").start()
    await Timer(1, "ns")
    assert dut.count.value == 8


async def _is_refused(dut: Any) -> None:
    with pytest.raises(hoverlock.NotWritable):
        dut.count.value = 1


@row("invalid writes", "some are silent", "an error: a write in `ReadOnly`, or of a value that does not fit")
@bench()
async def invalid_writes(dut: Any) -> None:
    with pytest.raises(hoverlock.RangeError):
        dut.step.value = 256
    await ReadOnly()
    with pytest.raises(RuntimeError, match="in ReadOnly"):
        dut.step.value = 1


@row(
    "result of `await RisingEdge(..)`", "the trigger",
    "`None`. The result of `First`, and of cocotb's `with_timeout`, `gather` and `select`, is the trigger that fired, or the result "
    "of the task", "speed",
)  # fmt: skip
@bench()
async def result_of_a_wait(dut: Any) -> None:
    Clock(dut.clk, 10, "ns").start()
    edge = RisingEdge(dut.clk)
    assert await edge is None and await First(Timer(1, "us"), edge) is edge
    assert await cocotb.triggers.with_timeout(edge, 1, "us") is edge and await cocotb.triggers.gather(edge) == (edge,)
    assert await cocotb.triggers.select(Timer(1, "us"), edge) == (1, edge)


@row(
    "a wrong name", "`AttributeError`",
    "the same, with the nearest names; for a hidden internal, with the way to make it accessible",
)  # fmt: skip
@bench()
async def wrong_name(dut: Any) -> None:
    with pytest.raises(AttributeError, match="nearest: count"):
        dut.cuont.value
    with pytest.raises(AttributeError, match=r"Design\(\.\.\., internals=\[\"next\"\]\)"):
        dut.next.value


@row(
    "internals", "all visible, or none",
    "those named in `Design(..., internals=[\"u_core.state\"])`, also in generate blocks; all of a top without "
    "ports. Under the alias, a bench that needs one is run again on a model with all. Not accessible: classes, "
    "queues, events, and an interface by the name of a module's port",
    "a model with everything accessible is a third slower if it is small, and 3.7 times slower if it is large",
)  # fmt: skip
@bench(generated)
async def internals(dut: Any) -> None:
    assert "state" in dut and "q" in dut.lane[2] and not {"numbers", "tick", "i"} & set(dut._children)
    assert dut.link.data.value == 0 and "out" not in dut.u_counts


@row(
    "`dut.x.value[0]`", "cocotb 1: the highest bit; 2: bit 0",
    "bit 0; `value[7:4]` slices as in Verilog; with `--cocotb-version 1.9` as in cocotb 1. Iteration begins with "
    "the highest bit",
    "as in cocotb 2",
)  # fmt: skip
@bench()
async def bits_of_a_value(dut: Any) -> None:
    dut.step.value = 0b1000_0001
    await Timer(1, "ns")
    assert dut.step.value[7:4] == 8 and dut.step.value[0] == 1 and [int(bit) for bit in dut.step.value][1:] == [0, 0, 0, 0, 0, 0, 1]
    hoverlock._core.count_bits_from_left(True)
    try:
        assert dut.step.value[0:3] == 8 and dut.step.value[7] == 1
    finally:
        hoverlock._core.count_bits_from_left(False)


@row(
    "`dut.mem.value[0]`, of `logic [7:0] mem [15:0]`", "cocotb 1: the leftmost element of a list; 2: element 0 of an `Array`",
    "as in cocotb 1; under the alias for 2.1 as in cocotb 2",
)  # fmt: skip
@bench(idioms)
async def elements_of_a_value(dut: Any) -> None:
    dut.mem.value = range(16)
    await Timer(1, "ns")
    assert dut.mem.value[0] == 0 == dut.mem[15].value
    types.index_arrays_as_declared(True)
    try:
        assert dut.mem.value[15] == 0 and dut.mem.value == list(range(16))
    finally:
        types.index_arrays_as_declared(False)


@row(
    "a number for `BinaryValue` that does not fit", "loses digits, with a warning",
    "an error. 0 in two's complement has `n_bits` digits, and none in cocotb",
)  # fmt: skip
def numbers_that_do_not_fit() -> None:
    with pytest.raises(OverflowError, match="does not fit"):
        BinaryValue(8, n_bits=3)
    assert BinaryValue(0, 3, binaryRepresentation=BinaryRepresentation.TWOS_COMPLEMENT).binstr == "000"


@row(
    "bits of a signal, `dut.x[3]`", "handles where the simulator has them",
    "can be read, written and, in signals of at most 64 bits, awaited; writes of several bits in one step are combined",
    "Verilator has no objects for bits",
)  # fmt: skip
@bench()
async def bits_of_a_signal(dut: Any) -> None:
    dut.step[0].value, dut.step[3].value = 1, 1
    await RisingEdge(dut.step[3])
    await Timer(1, "ns")
    assert dut.step.value == 9


@row(
    "packed structs, unpacked structs", "a vector; its own handle",
    "a packed struct is a vector with named fields, `dut.beat.tag`. The fields of an unpacked struct inside the "
    "design are signals, `dut.pair.low`; it has no value as a whole, and is not accessible as a port of the top",
    "an unpacked struct is a class in the model",
)  # fmt: skip
def shapes() -> None:
    odd = Design(HERE.parents[1] / "tests" / "designs" / "odd.sv", top="odd", internals=["*"])
    with Session(odd) as session, pytest.raises(hoverlock.NoSuchSignal, match="no signal 'loose.value'"):
        session.dut.loose.value
    with Session(odd) as session:
        session.dut.beat.tag.value, session.dut.loose.y.value = 9, -3
        session.run_for(1, "ns")
        assert session.dut.beat.value == 0x900 and session.dut.loose.y.value.signed_integer == -3


@row(
    "what cocotb 2 calls deprecated", "a `DeprecationWarning` with its advice",
    "the same under the alias for 2.1, for the names in `hoverlock.deprecated`; no warning for `Edge`, for tasks "
    "given to `First` and `Combine`, or for `str(handle)`",
)  # fmt: skip
def deprecations() -> None:
    deprecated.switch(True)
    try:
        with pytest.warns(DeprecationWarning, match="renamed to 'unit'"):
            Timer(1, units="ns")
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            Timer(1, "ns")
        assert not caught
    finally:
        deprecated.switch(False)


@row(
    "edges of `real` and `string`", "`ValueChange`",
    "none; their values can be read and written",
)  # fmt: skip
def edges_of_reals() -> None:
    odd = Design(HERE.parents[1] / "tests" / "designs" / "odd.sv", top="odd", internals=["*"])
    with Session(odd) as session, pytest.raises(TypeError):
        hoverlock.ValueChange(session.dut.gain)


@row(
    "`Force`, `Freeze`, `Release`", "on every signal",
    "on internal signals, or some of their bits, named in `Design(..., forceable=[\"u_core.state\"])` or "
    "`--hoverlock-forceable`; otherwise an error that says so. With cocotb's runner, a bench that forces another "
    "signal is run again with all. On inputs of the top a `Force` is a plain write. Not on outputs of the top, "
    "arrays and `real`",
    "the model checks at each use of such a signal whether it is forced",
)  # fmt: skip
def forcing() -> None:
    with Session(adder) as session, pytest.raises(hoverlock.NotForceable, match="forceable="):
        session.dut.u_adder.sum.value = Force(1)
    with Session(adder.changed(forceable="u_adder.sum")) as session:
        dut = session.dut
        for change, value in ((Force(0x55), 0x55), (Release(), 1), (Freeze(), 1)):
            dut.u_adder.sum.value = change
            session.run_for(1, "ns")
            assert dut.next.value == dut.u_adder.sum.value == value
        dut.data.value = Force(8)
        session.run_for(1, "ns")
        assert (dut.next.value, dut.odd.value, dut.data.value) == (1, 0, 8)
        with pytest.raises(hoverlock.NotForceable, match="a port of the top"):
            dut.next.value = Force(1)


@row(
    "`Release` of a register", "keeps the forced value until its next assignment",
    "has at once the value that the design assigned last, also during the force",
    "Verilator keeps both values",
)  # fmt: skip
def releasing() -> None:
    simulate(adder.changed(forceable="u_adder.held"), _release_a_register)


async def _release_a_register(dut: Any) -> None:
    Clock(dut.clk, 10, "ns").start()
    dut.u_adder.held.value = Force(9)
    await Timer(22, "ns")
    assert dut.held.value == 9
    dut.u_adder.held.value = Release()
    await Timer(1, "ns")
    assert dut.held.value == 1


@row(
    "`inout`", "Z resolves both drivers; X where they differ",
    "the design's value in the bits that it drives, otherwise the bench's: write a pull-up as 1 and `Z` as 0. "
    "Verilators without `--pins-inout-enables`, such as 5.006: one that the design drives cannot be written, the others are inputs",
    "two states",
)  # fmt: skip
@bench(adder)
async def inouts(dut: Any) -> None:
    try:
        dut.pad.value = 0x5A
    except hoverlock.NotWritable as error:
        assert "cannot drive on this Verilator" in str(error)
        return
    await Timer(1, "ns")
    assert dut.pad_seen.value == 0x5A
    dut.data.value, dut.drive.value = 3, 1
    await Timer(1, "ns")
    assert dut.pad_seen.value == dut.pad.value == 3


@row(
    "`setimmediatevalue`, `Immediate`, `Deposit`", "at once",
    "as `value = `: the last of several writes in a step counts",
    "there are no delta cycles",
)  # fmt: skip
@bench()
async def immediate(dut: Any) -> None:
    dut.step.setimmediatevalue(3)
    assert dut.step.value == 0
    await Timer(1, "ns")
    assert dut.step.value == 3


@row(
    "`Clock(...).start()`", "a coroutine, or a task",
    "starts at once and returns the clock, which `start_soon` accepts; `stop()`, `kill()` and `cancel()` stop it",
    "the engine drives it; no Python runs",
)  # fmt: skip
@bench()
async def clocks(dut: Any) -> None:
    clock = Clock(dut.clk, 10, "ns").start()
    assert start_soon(clock) is clock
    clock.kill()
    await Timer(100, "ns")
    assert clock.done()


@row("`start_high=False`", "begins with a falling edge", "the first rising edge comes after half a period")
@bench()
async def low_first(dut: Any) -> None:
    Clock(dut.clk, 10, "ns").start(start_high=False)
    await RisingEdge(dut.clk)
    assert hoverlock.get_sim_time("ns") == 5


@row(
    "`task.cancel()`, `task.kill()`", "`CancelledError` is raised in the task; `kill` drops it",
    "both end the task at once: `asyncio.CancelledError` is raised in it, its `finally` blocks run, and tasks "
    "that wait for it get `CancelledError`. A task that continues after the exception is closed without an error. Any other "
    "exception of its `finally` blocks fails the test, at the end of the run",
    "resources are freed",
)  # fmt: skip
@bench()
async def cancelling(dut: Any) -> None:
    seen: list[str] = []

    async def waits() -> None:
        try:
            await Timer(1, "us")
        except asyncio.CancelledError:
            seen.append("cancelled")
            raise
        finally:
            seen.append("finally")

    task = start_soon(waits())
    await Timer(1, "ns")
    task.kill()
    assert seen == ["cancelled", "finally"]
    with pytest.raises(hoverlock.CancelledError):
        await task
    with pytest.raises(LookupError, match="in its clean-up"):
        simulate(counter, _cancels_a_task_that_raises)


async def _cancels_a_task_that_raises(dut: Any) -> None:
    async def raises() -> None:
        try:
            await Timer(1, "us")
        finally:
            raise LookupError("in its clean-up")

    task = start_soon(raises())
    await Timer(1, "ns")
    task.cancel()


@row(
    "a task that fails", "fails the test",
    "the same, at once, with the tracebacks of the task and of the tasks that waited for it",
)  # fmt: skip
def failing_tasks() -> None:
    async def fails() -> None:
        await Timer(1, "ns")
        raise LookupError("in a task")

    async def bench(dut: Any) -> None:
        start_soon(fails())
        await Timer(1, "us")

    with pytest.raises(LookupError, match="in a task"):
        simulate(counter, bench)


@row(
    "a trigger that never fires", "hangs",
    "an error as soon as no event can occur any more; it says what each task waits for, and whether a clock runs."
    " Otherwise `timeout_time`, or the wall-clock limit of 600 s",
)  # fmt: skip
def nothing_comes() -> None:
    async def bench(dut: Any) -> None:
        await RisingEdge(dut.clk)

    with pytest.raises(hoverlock.DeadlockError, match="no clock runs"):
        simulate(counter, bench)


@row(
    "`$error`, `$fatal`, `$stop`, failed `assert`", "the process ends",
    "`VerilogError` with file and line; the test fails, and the next one runs",
)  # fmt: skip
def verilog_errors() -> None:
    async def bench(dut: Any) -> None:
        Clock(dut.clk, 10, "ns").start()
        dut.complain.value = 1
        await Timer(1, "us")

    with pytest.raises(hoverlock.VerilogError, match=r"talker\.v:"):
        simulate(talker, bench)


@row("`$finish`", "ends all", "`VerilogFinished`, unless a task awaits `VerilogFinish()`")
def finish() -> None:
    async def bench(dut: Any) -> None:
        Clock(dut.clk, 10, "ns").start()
        dut.end_it.value = 1
        await Timer(1, "us")

    with pytest.raises(hoverlock.VerilogFinished):
        simulate(talker, bench)


@row(
    "delays in the Verilog, `#5`", "simulated",
    "ignored, with a warning",
    "models are built without timing: only the bench advances time",
)  # fmt: skip
def delays() -> None:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "waits.v").write_text("module waits(input wire a, output reg b); always @(a) #5 b = a; endmodule\n")
        warnings = Design("waits.v", top="waits", folder=folder).compile().warnings
    assert any("STMTDLY" in warning for warning in warnings)


@row("`stage=`", "orders tests", "ignored", "tests are independent; they run in the order of the file")
def stages() -> None:
    assert "stage" not in hoverlock.test(stage=3)(_nothing).options


async def _nothing(dut: Any) -> None:
    pass


@row(
    "names", "those of its version",
    "those of versions 1.9 and 2.1; any other raises `AttributeError`. Missing: `Param`, `packages`, "
    "`TaskManager`, `wait`, `current_gpi_trigger`, `regression_manager`, `scheduler`",
)  # fmt: skip
def names() -> None:
    for missing in ("Param", "packages", "regression_manager", "scheduler"):
        with pytest.raises(AttributeError, match="Coming from cocotb"):
            getattr(cocotb, missing)
    for missing in ("TaskManager", "wait", "current_gpi_trigger"):
        assert not hasattr(cocotb.triggers, missing)


@row(
    "`bridge`, `resume`", "threads run side by side",
    "one thread at a time: simulation time does not advance while a thread computes",
)  # fmt: skip
@bench()
async def threads(dut: Any) -> None:
    from hoverlock.cocotb.task import bridge, resume

    @resume
    async def wait() -> float:
        await Timer(7, "ns")
        return hoverlock.get_sim_time("ns")

    assert await bridge(lambda: wait() + wait())() == 7 + 14


@row(
    "triggers written by a bench (`_prime`)", "yes",
    "no: write a coroutine instead",
)  # fmt: skip
def own_triggers() -> None:
    with pytest.raises(TypeError, match="cannot create"):
        type("Own", (hoverlock.Trigger,), {})()


@row(
    "times between two steps", "`round_mode` decides; an error without it",
    "exact without `round_mode`: time is counted in femtoseconds; with it, rounded to 1 ps as in cocotb",
)  # fmt: skip
@bench()
async def fractions(dut: Any) -> None:
    await Timer(1.5, "ps")
    assert hoverlock.get_sim_time("fs") == 1500
    await Timer(17.353715901410474, "ps", round_mode="ceil")
    assert hoverlock.get_sim_time("fs") == 19_500


@row(
    "deprecation warnings", "for old names",
    "none without the alias: old and new names are equivalent",
    "a bench runs under either version",
)  # fmt: skip
def warnings_of_old_names() -> None:
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulate(counter, _old_names)


async def _old_names(dut: Any) -> None:
    await Timer(1, units="ns")
    assert dut.step.value.integer == 0 and cocotb.fork is start_soon


@row(
    "`cocotb_tools.config`, `cocotb-config`", "folders of makefiles and of libraries for simulators",
    "the folder of `Makefile.sim`; libraries are refused with an error",
    "there are no such libraries",
)  # fmt: skip
def no_libraries() -> None:
    from hoverlock.cocotb_tools import config

    assert (config.makefiles_dir() / "Makefile.sim").is_file()
    with pytest.raises(hoverlock.HoverlockError, match="no VPI"):
        config.libs_dir()


@row("GPI, VHDL, other simulators", "yes", "Verilator only, in the same process", "speed")
def one_simulator() -> None:
    from hoverlock.cocotb.runner import get_runner

    with pytest.raises(hoverlock.HoverlockError, match="reads Verilog only"):
        get_runner("verilator").build(vhdl_sources=["a.vhd"], hdl_toplevel="a")


@row("`asyncio` awaitables", "no", "no, and the error says so")
def of_asyncio() -> None:
    async def bench(dut: Any) -> None:
        await asyncio.sleep(0)

    with pytest.raises(TypeError, match="asyncio's own awaitables"):
        simulate(counter, bench)


def table() -> str:
    """Returns the table as Markdown."""
    lines = ["| what | cocotb | here | why |", "|---|---|---|---|"]
    lines += [f"| {r.what} | {r.cocotb} | {r.here} | {r.why} |".replace("|  |", "| |") for r in ROWS]
    return "\n".join(lines) + "\n"


def page() -> str:
    """Returns the page with the present table."""
    before, _, rest = PAGE.read_text().partition(BEGIN)
    _, _, after = rest.partition(END)
    return before + BEGIN + table() + END + after


if __name__ == "__main__":
    PAGE.write_text(page())
    sys.exit(0)
