"""A bench ends well, fails, is skipped or is interrupted, and says so, whatever it raises."""

import os
import subprocess
import sys
import textwrap
import time
from pathlib import Path
from xml.etree import ElementTree

import pytest

import hoverlock
from hoverlock import Combine, Design, Event, First, Timer, simulate, start_soon

HERE = Path(__file__).parent
counter = Design("designs/counter.v", top="counter")

BENCH = f"""
    import sys
    import pytest
    import hoverlock
    from hoverlock import Design, Timer, start_soon
    design = Design({str(HERE / 'designs/counter.v')!r}, top="counter")

    @hoverlock.test()
    async def exits(dut):
        await Timer(1, "ns")
        sys.exit(0)

    @hoverlock.test()
    async def exits_in_a_task(dut):
        async def leave():
            sys.exit(0)
        await start_soon(leave())

    @hoverlock.test()
    async def fails(dut):
        pytest.fail("as it should")

    @hoverlock.test()
    async def raises_nothing(dut):
        with pytest.raises(ValueError):
            await Timer(1, "ns")

    @hoverlock.test()
    async def skips(dut):
        pytest.skip("no data")

    @hoverlock.test(expect_fail=True)
    async def fails_as_expected(dut):
        pytest.fail("as it should")

    class Odd(BaseException):
        pass

    @hoverlock.test()
    async def raises_what_is_no_exception(dut):
        raise Odd("odd")

    @hoverlock.test()
    async def good(dut):
        await Timer(1, "ns")
"""
FAILED = {"exits", "exits_in_a_task", "fails", "raises_nothing", "raises_what_is_no_exception"}
PASSED = {"fails_as_expected", "good"}


def run(folder, *command):
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run([sys.executable, "-m", *command], cwd=folder, env=environment, capture_output=True, text=True)


def verdicts(path):
    """Of each test of a JUnit file: passed, skipped, failure or error."""
    cases = ElementTree.parse(path).getroot().iter("testcase")
    kinds = ("skipped", "failure", "error")
    return {case.get("name"): next((kind for kind in kinds if case.find(kind) is not None), "passed") for case in cases}


@pytest.mark.parametrize("way", [("hoverlock", "-q", "--junit"), ("pytest", "-q", "-p", "no:cacheprovider", "--junitxml")], ids=lambda w: w[0])
def test_every_ending_is_told_and_the_rest_runs(tmp_path, way):
    (tmp_path / "test_bench.py").write_text(textwrap.dedent(BENCH))
    done = run(tmp_path, *way, "r.xml", "test_bench.py")
    assert done.returncode == 1, done.stdout + done.stderr
    found = verdicts(tmp_path / "r.xml")
    assert {name for name, kind in found.items() if kind in ("failure", "error")} == FAILED
    assert {name for name, kind in found.items() if kind == "passed"} == PASSED
    assert {name for name, kind in found.items() if kind == "skipped"} == {"skips"}


def test_what_pytest_raises_is_a_failure_and_an_exit_an_error(tmp_path):
    (tmp_path / "test_bench.py").write_text(textwrap.dedent(BENCH))
    done = run(tmp_path, "hoverlock", "-q", "test_bench.py", "--junit", "r.xml")
    found = verdicts(tmp_path / "r.xml")
    assert found["fails"] == found["raises_nothing"] == "failure" and found["exits"] == "error"
    assert "2 passed, 5 failed, 1 skipped" in done.stdout and "SKIP test_bench.skips" in done.stdout
    assert "the bench called sys.exit(0)" in done.stdout


@pytest.mark.parametrize(("body", "status", "said"), [
    ("import sys\nsys.exit(0)\n", 2, "called sys.exit(0)"),
    ("import pytest\npytest.skip('not today', allow_module_level=True)\n", 0, "SKIP test_left.test_left (0.00 s)\n0 passed, 0 failed, 1 skipped"),
])  # fmt: skip
def test_a_module_that_ends_while_it_is_loaded(tmp_path, body, status, said):
    (tmp_path / "test_left.py").write_text(body)
    done = run(tmp_path, "hoverlock", "test_left.py")
    assert done.returncode == status and said in done.stdout + done.stderr and "Traceback" not in done.stderr


def test_the_decorator_is_no_test(tmp_path):
    (tmp_path / "test_bench.py").write_text("from hoverlock import test\nfrom hoverlock.cocotb import *\ntest_it = test\n")
    done = run(tmp_path, "pytest", "-q", "-p", "no:cacheprovider", "test_bench.py")
    assert done.returncode == 5 and "no tests ran" in done.stdout, done.stdout


async def fail_after(span):
    await Timer(span, "ns")
    raise LookupError(f"after {span} ns")


async def never():
    await Event("never").wait()


def test_combine_raises_the_error_of_a_part_at_once():
    async def bench(dut):
        with pytest.raises(LookupError, match="after 3 ns"):
            await Combine(start_soon(fail_after(3)), start_soon(never()), Timer(1, "us"))
        return hoverlock.get_sim_time("ns")

    assert simulate(counter, bench) == 3


def test_combine_raises_the_error_of_a_part_of_a_part():
    async def bench(dut):
        with pytest.raises(LookupError, match="after 4 ns"):
            await Combine(Timer(1, "us"), First(Timer(2, "us"), Combine(start_soon(fail_after(4)), start_soon(never()))))
        assert hoverlock.get_sim_time("ns") == 4
        task = start_soon(fail_after(1))
        with pytest.raises(LookupError, match="after 1 ns"):
            await task
        # One that had failed before.
        with pytest.raises(LookupError, match="after 1 ns"):
            await Combine(start_soon(never()), task)
        return hoverlock.get_sim_time("ns")

    assert simulate(counter, bench) == 5


def memory():
    """Bytes of memory that this process has now."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_waits_that_are_given_up_leave_nothing():
    waits = 200_000

    async def bench(dut):
        event, long = Event("never"), start_soon(never())
        for kept in (lambda: event.wait(), lambda: long.join(), lambda: Timer(1, "sec")):
            soon = Timer(1, "ns")
            for _ in range(2000):
                await First(soon, kept())
            before = memory()
            for _ in range(waits):
                await First(soon, kept())
            assert memory() - before < 4 * waits, "8 bytes at least for each wait"

    simulate(counter, bench)


def test_a_lock_is_released_at_once_however_many_gave_up():
    async def bench(dut):
        lock, soon = hoverlock.Lock(), Timer(1, "ns")
        await lock.acquire()
        for _ in range(100_000):
            assert await First(lock.acquire(), soon) is soon
        started = time.monotonic()
        lock.release()
        assert time.monotonic() - started < 0.1 and not lock.locked()
        # Those that did not give up get it in their order.
        order = []

        async def use(name):
            async with lock:
                order.append(name)
                await Timer(1, "ns")

        tasks = [start_soon(use(name)) for name in "abc"]
        async with lock:
            assert await First(lock.acquire(), soon) is soon
        await Combine(*tasks)
        assert order == ["a", "b", "c"]

    simulate(counter, bench)
