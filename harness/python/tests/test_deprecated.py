"""What cocotb 2 calls deprecated warns with its advice under the alias, and only there."""

import subprocess
import sys
import warnings
from pathlib import Path

import pytest

import hoverlock.cocotb as cocotb
from hoverlock import Clock, Design, deprecated, simulate, start_soon
from hoverlock.cocotb import clock, regression, result, triggers, types, utils
from hoverlock.deprecated import ADVICE

odd = Design(Path(__file__).resolve().parents[2] / "tests" / "designs" / "odd.sv", top="odd", internals=["*"])


async def nothing():
    await triggers.Timer(1, "ns")


def start_and_close(coroutine):
    cocotb.start(coroutine).close()
    coroutine.close()


# What each row of the table is about.
USES = {
    "Timer(units)": lambda dut: triggers.Timer(1, units="ns"),
    "Clock(units)": lambda dut: clock.Clock(dut.clk, 10, units="ns"),
    "get_sim_time(units)": lambda dut: utils.get_sim_time(units="ns"),
    "get_sim_steps(units)": lambda dut: utils.get_sim_steps(1, units="ns"),
    "get_time_from_sim_steps(units)": lambda dut: utils.get_time_from_sim_steps(1, units="ns"),
    "Event(name)": lambda dut: triggers.Event("named"),
    "Event.set(data)": lambda dut: triggers.Event().set(3),
    "Lock(name)": lambda dut: triggers.Lock("named"),
    "Join": lambda dut: triggers.Join(start_soon(nothing())),
    "start": lambda dut: start_and_close(nothing()),
    "TestFactory": lambda dut: regression.TestFactory(nothing),
    "result.TestSuccess": lambda dut: result.TestSuccess,
    "result.SimFailure": lambda dut: result.SimFailure,
    "result.SimTimeoutError": lambda dut: result.SimTimeoutError,
    "Task.kill": lambda dut: start_soon(nothing()).kill(),
    "Task.join": lambda dut: start_soon(nothing()).join(),
    "Value.binstr": lambda dut: dut.corner.value.binstr,
    "Value.integer": lambda dut: (dut.corner.value.integer, types.LogicArray("10").integer),
    "Value.signed_integer": lambda dut: dut.corner.value.signed_integer,
    "Value.buff": lambda dut: dut.corner.value.buff,
    "Handle.__int__": lambda dut: int(dut.corner),
    "Element.__int__": lambda dut: int(dut.rows[0][0]),
    "Bits.__int__": lambda dut: int(dut.corner[0]),
    "RealHandle.__float__": lambda dut: float(dut.gain),
    "Handle.setimmediatevalue": lambda dut: dut.beat.setimmediatevalue(3),
    "Element.setimmediatevalue": lambda dut: dut.rows[0][0].setimmediatevalue(3),
    "ArrayHandle.setimmediatevalue": lambda dut: dut.grid.setimmediatevalue([[1, 2, 3], [4, 5, 6]]),
    "RealHandle.setimmediatevalue": lambda dut: dut.gain.setimmediatevalue(1.5),
    "TextHandle.setimmediatevalue": lambda dut: dut.text.setimmediatevalue("text"),
}


def warnings_of(dut, use):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        use(dut)
    return [(str(warning.message), warning.category, Path(warning.filename).name) for warning in caught]


def test_each_row_of_the_table_warns_where_it_is_used_and_only_when_switched_on():
    assert set(USES) == set(ADVICE)

    async def bench(dut):
        Clock(dut.clk, 10, "ns").start()
        for what, use in USES.items():
            assert warnings_of(dut, use) == [], what
        deprecated.switch(True)
        try:
            for what, use in USES.items():
                times = 2 if what == "Value.integer" else 1
                assert warnings_of(dut, use) == [(ADVICE[what], DeprecationWarning, "test_deprecated.py")] * times, what
        finally:
            deprecated.switch(False)
        for what, use in USES.items():
            assert warnings_of(dut, use) == [], what

    simulate(odd, bench)


@pytest.mark.parametrize(("version", "warns"), [("2.1", True), ("1.9", False)])
def test_the_alias_warns_for_the_version_that_it_stands_for(version, warns):
    said = f"import hoverlock; hoverlock.as_cocotb({version!r}); from cocotb.triggers import Event, Timer; Timer(1, units='ns'); Event('a')"
    done = subprocess.run([sys.executable, "-W", "always", "-c", said], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("DeprecationWarning: ") == (2 if warns else 0), done.stderr
    assert ("<string>:1: DeprecationWarning: The 'units' argument has been renamed to 'unit'." in done.stderr) == warns
