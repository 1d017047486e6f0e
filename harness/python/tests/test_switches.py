"""The switches of pytest and of `python -m hoverlock`: waves, coverage, seeds, fixtures, parallel runs, stubs."""

import os
import re
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

import hoverlock
from hoverlock import Design, Outputs
from hoverlock.stub import stub_of

DESIGNS = Path(__file__).parent / "designs"
BENCH = f"""
    import random
    import pytest
    import hoverlock
    from hoverlock import Clock, ClockCycles, Design, Timer

    design = Design({str(DESIGNS / "counter.v")!r}, top="counter")

    async def begin(dut, step=1):
        Clock(dut.clk, 10, "ns").start()
        dut.rst.value = 1
        await ClockCycles(dut.clk, 2)
        dut.rst.value, dut.enable.value, dut.step.value = 0, 1, step

    @hoverlock.test()
    @hoverlock.parametrize(step=[1, 2])
    async def good(dut, step):
        await begin(dut, step)
        await ClockCycles(dut.clk, 100)

    @hoverlock.test()
    async def bad(dut):
        await begin(dut)
        await ClockCycles(dut.clk, 100)
        wanted = random.randrange(1000, 10**9)
        assert dut.count.value == wanted, f"not {{wanted}}"

    @hoverlock.test(expect_fail=True)
    async def bad_as_expected(dut):
        await begin(dut)
        assert dut.count.value == 1000

    @hoverlock.test()
    async def passes(dut):
        hoverlock.pass_test()
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "test_bench.py").write_text(textwrap.dedent(BENCH))
    return tmp_path


def run(folder, *command, **environment):
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1", **environment}
    return subprocess.run([sys.executable, "-m", *command], cwd=folder, env=environment, capture_output=True, text=True)


def run_pytest(folder, *options, **environment):
    return run(folder, "pytest", "-q", "-p", "no:cacheprovider", *options, **environment)


def files(folder):
    return sorted(p.name for p in folder.glob("*") if p.suffix in (".vcd", ".fst", ".gtkw", ".info"))


EITHER = pytest.mark.parametrize("way", [("pytest", "-q", "-p", "no:cacheprovider"), ("hoverlock", "-q")], ids=lambda way: way[0])


@EITHER
def test_waves_of_every_test(folder, way):
    run(folder, *way, "test_bench.py", "-k", "good", "--hoverlock-waves", "fst", "--hoverlock-output", "out")
    assert files(folder / "out") == [f"test_bench.good[step={n}].{kind}" for n in (1, 2) for kind in ("fst", "gtkw")] or files(
        folder / "out"
    ) == [f"test_bench.good[step={n}].fst" for n in (1, 2)]
    assert all(p.stat().st_size > 200 for p in (folder / "out").glob("*.fst"))


@EITHER
def test_waves_of_tests_that_fail_only(folder, way):
    done = run(folder, *way, "test_bench.py", "--hoverlock-waves-on-failure")
    assert "1 failed" in done.stdout
    written = files(folder / "hoverlock-output")
    assert [n for n in written if n.endswith(".vcd")] == ["test_bench.bad.vcd"] and len(written) <= 2
    text = (folder / "hoverlock-output" / "test_bench.bad.vcd").read_text()
    assert re.search(r"^#0$", text, re.MULTILINE) and "count" in text


@EITHER
def test_the_last_steps_before_a_failure(folder, way):
    run(folder, *way, "test_bench.py", "--hoverlock-waves-last", "20")
    written = files(folder / "hoverlock-output")
    assert written == ["test_bench.bad.gtkw", "test_bench.bad.vcd"]
    text = (folder / "hoverlock-output" / "test_bench.bad.vcd").read_text()
    times = [int(t) for t in re.findall(r"^#(\d+)$", text, re.MULTILINE)]
    # It fails at the 102nd edge, at 1010 ns; 20 steps of 5 ns, in ps.
    assert len(times) <= 20 and times[0] >= 1_010_000 - 20 * 5000 and times[-1] == 1_010_000
    done = run(folder, *way, "test_bench.py", "--hoverlock-waves-last", "0")
    assert done.returncode in (2, 4) and "at least 1 is needed" in done.stdout + done.stderr


@EITHER
@pytest.mark.parametrize("parallel", [(), ("-n", "2")], ids=["alone", "parallel"])
def test_coverage_of_all_tests_is_added_up(folder, way, parallel):
    if way[0] == "hoverlock" and parallel:
        pytest.skip("the runner runs one test after the other")
    done = run(folder, *way, *parallel, "test_bench.py", "-k", "good or passes" if way[0] == "pytest" else "good",
               "--hoverlock-coverage")  # fmt: skip
    said = re.search(r"coverage of (\d) tests: line (\d+) of (\d+).*toggle (\d+) of (\d+).*coverage\.info", done.stdout)
    assert said, done.stdout + done.stderr
    tests, *met = map(int, said.groups())
    assert tests == (3 if way[0] == "pytest" else 2) and 0 < met[0] <= met[1] and 0 < met[2] < met[3]
    lcov = (folder / "hoverlock-output" / "coverage.info").read_text()
    assert f"SF:{DESIGNS / 'counter.v'}" in lcov
    # Of a run of 100 cycles with step 1 and one with step 2 the clocked line is hit about 200 times: both are in.
    assert max(int(n) for n in re.findall(r"^DA:\d+,(\d+)$", lcov, re.MULTILINE)) >= 200
    # A second run counts afresh.
    again = run(folder, *way, "test_bench.py", "-k", "good", "--hoverlock-coverage")
    assert "coverage of 2 tests" in again.stdout


@EITHER
def test_a_failure_says_how_to_replay_it(folder, way):
    done = run(folder, *way, "test_bench.py", "-k", "bad")
    seed = re.search(r"random seed (\d+): replay with --hoverlock-seed \1", done.stdout)
    command = re.search(rf"^(pytest|python -m hoverlock) .*test_bench.* --hoverlock-seed {seed[1]}$", done.stdout, re.MULTILINE)
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    again = subprocess.run(command[0], shell=True, cwd=folder, env=environment, capture_output=True, text=True)
    what = re.compile(r"AssertionError: not (\d+)")
    assert what.search(done.stdout)[1] == what.search(again.stdout)[1]


def test_parallel_tests_build_once(folder):
    """Two processes want one model at a time: one builds it, the other waits for it."""
    (folder / "verilator").write_text(
        f'#!/bin/sh\necho "$@" >> {folder}/called\nexec {shutil.which("verilator")} "$@"\n'
    )
    (folder / "verilator").chmod(0o755)
    environment = {"PATH": f"{folder}:{os.environ['PATH']}", "HOVERLOCK_CACHE": str(folder / "cache")}
    done = run_pytest(folder, "-n", "2", "-k", "good or passes", **environment)
    assert "3 passed" in done.stdout, done.stdout
    called = (folder / "called").read_text().splitlines()
    assert len([line for line in called if "--xml-only" in line]) == 1
    before = len(called)
    assert "3 passed" in run_pytest(folder, "-n", "2", "-k", "good or passes", **environment).stdout
    called = (folder / "called").read_text().splitlines()[before:]
    assert not [line for line in called if "--version" not in line], "the second run builds nothing"


def test_benches_take_fixtures_and_plain_tests_run_benches(folder):
    (folder / "test_fixtures.py").write_text(textwrap.dedent("""
        import random
        import pytest
        import hoverlock
        from test_bench import begin, design
        from hoverlock import ClockCycles

        @pytest.fixture
        def limit(tmp_path):
            (tmp_path / "x").write_text("5")
            yield 5
            print("torn down")

        @hoverlock.test()
        @hoverlock.parametrize(step=[1, 3])
        async def with_fixtures(dut, limit, step, tmp_path, unused=7):
            await begin(dut, step)
            await ClockCycles(dut.clk, limit)
            assert dut.count.value == (limit - 1) * step and (tmp_path / "x").exists() and unused == 7
        with_fixtures.design = design

        async def count(dut, cycles):
            await begin(dut)
            await ClockCycles(dut.clk, cycles)
            return int(dut.count.value), random.random()

        @pytest.mark.parametrize("cycles", [3, 30])
        def test_plain(hoverlock_simulate, hoverlock_seed, cycles):
            found, number = hoverlock_simulate(design, count, cycles=cycles)
            assert found == cycles - 1
            assert number == random.Random(hoverlock_seed).random()

        def test_plain_that_fails(hoverlock_simulate):
            assert hoverlock_simulate(design, count, cycles=3) == "no"

        @hoverlock.test()
        async def no_such_fixture(dut, nothing):
            pass
    """))
    done = run_pytest(folder, "test_fixtures.py", "-s", "--hoverlock-seed", "4", "--hoverlock-coverage")
    assert "1 failed, 4 passed, 1 error" in done.stdout, done.stdout
    assert "fixture 'nothing' not found" in done.stdout and done.stdout.count("torn down") == 2
    assert "test_plain_that_fails --hoverlock-seed 4" in done.stdout and "coverage of 5 tests" in done.stdout


def test_marks_and_names_select(folder):
    (folder / "test_marks.py").write_text(textwrap.dedent("""
        import pytest
        import hoverlock
        from test_bench import design

        @hoverlock.test()
        @pytest.mark.slow
        async def slow(dut):
            pass

        @hoverlock.test()
        async def quick(dut):
            pass

        @hoverlock.test()
        @pytest.mark.parametrize("a, b", [(1, 2), pytest.param(3, 6, id="six")])
        @hoverlock.parametrize(c=[5])
        @pytest.mark.parametrize("d", [7, 8])
        async def many(dut, a, b, c, d):
            assert b == 2 * a and c == 5 and d in (7, 8)
    """))
    assert "4 passed, 2 deselected" in run_pytest(folder, "test_marks.py", "-k", "many").stdout
    assert "many[c=5-7-six]" in run_pytest(folder, "test_marks.py", "--collect-only").stdout
    assert "1 passed, 5 deselected" in run_pytest(folder, "test_marks.py", "-m", "slow").stdout
    assert "1 passed, 5 deselected" in run_pytest(folder, "test_marks.py", "-k", "quick").stdout
    assert "1 passed" in run_pytest(folder, "test_marks.py::quick").stdout


# ---- stubs


def test_a_stub_types_the_design(tmp_path):
    design = Design(DESIGNS / "idioms.sv", top="idioms", internals=["*"])
    text = stub_of(design)
    assert "class Idioms(TypedHierarchy):" in text and "    ui_in: Handle  # input, 8 bits" in text
    assert "    a_i: ArrayHandle  # input, 4 elements" in text and "    WIDTH: Constant  # 8" in text
    assert "    sum: Handle  # internal, 8 bits" in text and "    lane: IdiomsLane" in text
    done = run(tmp_path, "hoverlock", "stub", str(DESIGNS / "idioms.sv"), "--top", "idioms", "--internal", "*", "-o", "idioms_dut.pyi")
    assert done.returncode == 0 and (tmp_path / "idioms_dut.pyi").read_text() == text
    (tmp_path / "bench.py").write_text(textwrap.dedent("""
        from typing import TYPE_CHECKING
        import hoverlock
        if TYPE_CHECKING:
            from idioms_dut import Idioms
        @hoverlock.test()
        async def good(dut: "Idioms") -> None:
            dut.ui_in.value = int(dut.WIDTH) + len(dut.a_i)
            await dut.clk.rising_edge
            assert dut.lane[2].u_adds.y.value == 3
        async def bad(dut: "Idioms") -> None:
            dut.iu_in.value = 3
            dut.lane[0].u_addz.y.value
    """))
    done = run(tmp_path, "mypy", "--strict", "--config-file=", "bench.py")
    wrong = re.findall(r"bench\.py:(\d+): error: (.*)", done.stdout)
    assert {int(line) for line, _ in wrong} == {12, 13}, done.stdout
    assert '"Idioms" has no attribute "iu_in"; maybe "ui_in"?' in wrong[0][1] and "u_addz" in wrong[1][1]


def test_a_stub_of_what_does_not_build_is_an_error(tmp_path):
    for arguments, said in [
        (["nowhere.v", "--top", "x"], "nowhere.v"),
        ([str(DESIGNS / "counter.v"), "--top", "countr"], "no module 'countr'"),
        ([str(DESIGNS / "counter.v"), "--top", "counter", "--parameter", "WIDTH"], "NAME=VALUE"),
        ([str(DESIGNS / "counter.v"), "--top", "counter", "-o", "no/such/folder.pyi"], "no/such"),
    ]:
        done = run(tmp_path, "hoverlock", "stub", *arguments)
        assert done.returncode == 2 and done.stderr.startswith("hoverlock: ") and said in done.stderr
        assert "Traceback" not in done.stderr


# ---- the same from Python


def test_outputs_from_python(tmp_path, folder):
    design = Design(DESIGNS / "counter.v", top="counter")
    outputs = Outputs(tmp_path / "out", coverage=True, waves="vcd", only_failures=True)
    results = hoverlock.runner.run(folder / "test_bench.py", design, seed=1, quiet=True, outputs=outputs)
    assert [r.passed for r in results] == [True, True, False, True, True]
    assert (tmp_path / "out" / "coverage.info").is_file() and (tmp_path / "out" / "test_bench.bad.vcd").is_file()
    missed = hoverlock.Coverage()
    for path in (tmp_path / "out" / "coverage").glob("*.dat"):
        missed.add(path)
    met, points = missed.met()
    assert 0 < met < points and len(missed.missed()) == points - met and missed.missed()[0][0].endswith("counter.v")
    with pytest.raises(hoverlock.HoverlockError, match="coverage"):
        missed.add(folder / "test_bench.py")


LOGGING = """
    import logging
    import hoverlock

    log = logging.getLogger("cocotb.tb")

    @hoverlock.test()
    async def says(dut):
        log.warning("heard in the report")
        assert False

    @hoverlock.test()
    async def reads(dut, caplog):
        log.warning("heard by the fixture")
        assert caplog.messages == ["heard by the fixture"]

    @hoverlock.test()
    async def asks(dut, request):
        log.warning("heard on request")
        assert request.getfixturevalue("caplog").messages == ["heard on request"]
"""


def test_what_a_bench_logs_is_in_report_fixture_and_file(tmp_path):
    (tmp_path / "test_bench.py").write_text(textwrap.dedent(LOGGING))
    options = ("test_bench.py", "--hoverlock-source", str(DESIGNS / "counter.v"), "--hoverlock-top", "counter")
    done = run_pytest(tmp_path, *options)
    assert "1 failed, 2 passed" in done.stdout and "heard in the report" in done.stdout
    run_pytest(tmp_path, *options, "--log-file", "bench.log")
    found = re.findall(r"heard [a-z ]+", (tmp_path / "bench.log").read_text())
    assert found == ["heard in the report", "heard by the fixture", "heard on request"]
