"""Errors are reported clearly, end the run at once, and leave nothing behind."""

import os
import random
import signal
import subprocess
import sys
import textwrap
import threading
import time
from pathlib import Path

import pytest

import hoverlock
from hoverlock import Clock, Design, RisingEdge, Timer, simulate, start_soon

HERE = Path(__file__).parent
counter = Design("designs/counter.v", top="counter")
talker = Design("designs/talker.v", top="talker")


def test_a_bench_that_raises_keeps_its_traceback():
    async def inner():
        await Timer(1, "ns")
        raise LookupError("the bench's own")

    async def bench(dut):
        await start_soon(inner())

    with pytest.raises(LookupError, match="the bench's own") as caught:
        simulate(counter, bench)
    names = [entry.name for entry in caught.traceback]
    assert names.index("bench") < names.index("inner")


def test_a_task_nobody_waits_for_fails_the_test():
    async def fail():
        await Timer(5, "ns")
        raise ValueError("in the background")

    async def bench(dut):
        start_soon(fail())
        await Timer(1, "us")

    with pytest.raises(ValueError, match="in the background"):
        simulate(counter, bench)


def test_a_forgotten_clock_is_told():
    async def bench(dut):
        await RisingEdge(dut.clk)

    with pytest.raises(hoverlock.DeadlockError, match=r"(?s)'bench' waits for RisingEdge\(clk.*no clock runs"):
        simulate(counter, bench)


def test_a_bench_that_hangs_is_ended_by_simulation_time():
    async def bench(dut):
        Clock(dut.clk, 10, "ns").start()
        await RisingEdge(dut.wrapped)

    with pytest.raises(hoverlock.SimTimeoutError, match=r"(?s)limit of 1000 ns.*'bench' waits for RisingEdge\(wrapped"):
        simulate(counter, bench, time_limit=10**9)


def test_a_bench_that_hangs_is_ended_by_the_wall_clock():
    async def bench(dut):
        Clock(dut.clk, 10, "ns").start()
        await RisingEdge(dut.wrapped)

    started = time.monotonic()
    with pytest.raises(hoverlock.SimTimeoutError, match=r"wall-clock limit of 0\.3 s"):
        simulate(counter, bench, wall_limit=0.3)
    assert time.monotonic() - started < 5


def test_a_bench_that_never_awaits_is_ended_by_the_wall_clock():
    async def bench(dut):
        while True:
            pass

    with pytest.raises(hoverlock.SimTimeoutError, match="does not await anything"):
        simulate(counter, bench, wall_limit=0.2)


def test_a_bench_that_never_lets_time_go_on_is_ended():
    async def bench(dut):
        for value in range(10**9):
            dut.step.value = value & 1
            await hoverlock.ReadWrite()

    with pytest.raises(hoverlock.DeadlockError, match="rounds in one time step"):
        simulate(counter, bench)


def test_leaked_tasks_are_ended_and_told(caplog):
    ended = []

    async def leak():
        try:
            await Timer(1, "sec")
        finally:
            ended.append(True)

    async def bench(dut):
        start_soon(leak())
        await Timer(1, "ns")

    with caplog.at_level("INFO", logger="hoverlock"):
        simulate(counter, bench)
    assert ended == [True] and "1 tasks still ran at the end and are cancelled" in caplog.text


class ScoreboardError(Exception):
    pass


async def monitor(error, seen=None):
    """Raises an error when it is cancelled."""
    try:
        await Timer(1, "sec")
    finally:
        if seen is not None:
            seen.append("cleaned up")
        raise error


async def leaves_a_monitor(dut, error):
    start_soon(monitor(error))
    await Timer(1, "ns")


async def cancels_a_monitor(dut, error):
    task = start_soon(monitor(error))
    await Timer(1, "ns")
    task.cancel()
    await Timer(1, "ns")


ERRORS = [ScoreboardError("3 beats are left"), KeyError("lost"), AssertionError("differ"), SystemExit(3), KeyboardInterrupt()]


@pytest.mark.parametrize("bench", [leaves_a_monitor, cancels_a_monitor])
@pytest.mark.parametrize("error", ERRORS, ids=repr)
def test_an_error_of_clean_up_is_raised(bench, error):
    hook = sys.unraisablehook
    with pytest.raises(type(error)) as caught:
        simulate(counter, bench, arguments={"error": error})
    assert caught.value is error and "monitor" in [entry.name for entry in caught.traceback]
    with pytest.raises(type(error)):
        hoverlock.test(bench).with_arguments("with", {"error": error}).run(counter, seed=1)
    assert sys.unraisablehook is hook


def test_an_error_of_clean_up_is_raised_by_the_session_that_cancels():
    async def starts(dut, error):
        start_soon(cancels_a_monitor(dut, error))

    with hoverlock.Session(counter) as session:
        session.run(starts, error=KeyError("later"))
        with pytest.raises(KeyError, match="later"):
            session.run_for(5, "ns")
        session.run(leaves_a_monitor, error=ScoreboardError("at the end"))
        with pytest.raises(ScoreboardError, match="at the end"):
            session.close()
        session.close()


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_an_error_of_the_bench_comes_before_those_of_clean_up():
    async def fails(dut, error):
        await cancels_a_monitor(dut, error)
        start_soon(monitor(error, cleaned_up))
        await Timer(1, "ns")
        raise LookupError("first")

    async def passes(dut, error):
        await cancels_a_monitor(dut, error)
        hoverlock.pass_test("enough")

    cleaned_up = []
    with pytest.raises(LookupError, match="first") as caught:
        simulate(counter, fails, arguments={"error": KeyError("clean-up")})
    assert caught.value.__context__ is None and cleaned_up == ["cleaned up"]
    # An expected end does not hide them.
    for bench, options in ((passes, {}), (fails, {"expect_error": LookupError})):
        with pytest.raises(KeyError, match="clean-up"):
            hoverlock.test(**options)(bench).with_arguments("with", {"error": KeyError("clean-up")}).run(counter, seed=1)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_clean_up_may_end_by_its_cancellation():
    import asyncio

    seen = []

    async def raises(error):
        try:
            await Timer(1, "sec")
        finally:
            seen.append(error)
            raise error

    async def awaits():
        try:
            await Timer(1, "sec")
        finally:
            seen.append("awaits")
            await Timer(1, "ns")

    async def bench(dut):
        for error in (asyncio.CancelledError(), GeneratorExit(), hoverlock.CancelledError("of another"), hoverlock.errors.TestSuccess("enough")):
            start_soon(raises(error))
        start_soon(awaits())
        await Timer(1, "ns")

    simulate(counter, bench)
    hoverlock.test(bench).run(counter, seed=1)
    assert len(seen) == 10


def test_errors_of_clean_up_stay_in_their_thread_and_simulation():
    async def outer(dut, error):
        with pytest.raises(KeyError, match="inner"):
            simulate(counter, leaves_a_monitor, arguments={"error": KeyError("inner")})
        await leaves_a_monitor(dut, error)

    def run(number):
        try:
            simulate(counter, outer, arguments={"error": ScoreboardError(number)})
        except ScoreboardError as error:
            raised.append((number, *error.args))

    raised, hook = [], sys.unraisablehook
    threads = [threading.Thread(target=run, args=(number,)) for number in range(8)]
    [t.start() for t in threads]
    [t.join() for t in threads]
    assert sorted(raised) == [(number, number) for number in range(8)] and sys.unraisablehook is hook


def test_a_forgotten_await_or_another_librarys_is_told():
    import asyncio

    async def bench(dut):
        await asyncio.sleep(1)

    with pytest.raises((TypeError, RuntimeError)):
        simulate(counter, bench)

    class Foreign:
        def __await__(self):
            yield 3

    async def foreign(dut):
        await Foreign()

    with pytest.raises(TypeError, match=r"\(int\) that is not a hoverlock trigger"):
        simulate(counter, foreign)


def test_verilog_complaints_fail_and_its_words_are_logged(caplog):
    async def bench(dut):
        Clock(dut.clk, 10, "ns").start()
        dut.say.value = 1
        await Timer(25, "ns")
        dut.say.value = 0
        dut.complain.value = 1
        await Timer(1, "us")

    with caplog.at_level("INFO", logger="hoverlock"), pytest.raises(hoverlock.VerilogError, match=r"complaint number 7.*talker\.v:10"):
        simulate(talker, bench)
    assert "hello at" in caplog.text


def test_finish_ends_the_test_unless_awaited():
    async def bench(dut):
        Clock(dut.clk, 10, "ns").start()
        dut.end_it.value = 1
        await Timer(1, "us")

    with pytest.raises(hoverlock.VerilogFinished, match=r"\$finish.*talker\.v:11"):
        simulate(talker, bench)

    async def waits(dut):
        Clock(dut.clk, 10, "ns").start()
        dut.end_it.value = 1
        await hoverlock.VerilogFinish()
        return "finished"

    assert simulate(talker, waits) == "finished"


def test_verilog_that_does_not_compile_names_file_and_line(tmp_path):
    (tmp_path / "bad.v").write_text("module bad(input wire a);\n  assign b = ;\nendmodule\n")
    with pytest.raises(hoverlock.BuildError, match=r"bad\.v:2"):
        Design("bad.v", top="bad", folder=tmp_path).compile()


def test_no_such_top_names_the_nearest():
    with pytest.raises(hoverlock.BuildError, match="no module 'countr'.*counter"):
        Design("designs/counter.v", top="countr").compile()


def test_missing_files_and_tools_are_told(tmp_path):
    with pytest.raises(hoverlock.BuildError, match=r"nowhere\.v"):
        Design("nowhere.v", top="nowhere").compile()
    with pytest.raises(hoverlock.BuildError, match="no-verilator"):
        Design("designs/counter.v", top="counter", verilator=tmp_path / "no-verilator", cache=tmp_path / "c").compile()
    with pytest.raises(hoverlock.BuildError, match=r"(?s)cache folder.*HOVERLOCK_CACHE"):
        Design("designs/counter.v", top="counter", cache="/proc/nothing").compile()


def test_nothing_runs_outside_of_a_test():
    coroutine = hoverlock.with_timeout(Timer(1, "ns"), 1, "ns")
    with pytest.raises(hoverlock.SimulationError, match="no simulation is running"):
        start_soon(coroutine)
    coroutine.close()


def test_two_simulations_do_not_disturb_each_other():
    async def count(dut, cycles):
        Clock(dut.clk, 10, "ns").start()
        dut.enable.value = 1
        dut.step.value = 1
        for _ in range(cycles):
            await RisingEdge(dut.clk)
        if cycles == 50:
            assert simulate(counter, count, arguments={"cycles": 20}) == 19
        return int(dut.count.value)

    assert simulate(counter, count, arguments={"cycles": 50}) == 49


def test_threads_have_simulations_of_their_own_and_handles_stay_there():
    results, kept = [], []

    async def bench(dut):
        Clock(dut.clk, 10, "ns").start()
        dut.enable.value, dut.step.value = 1, 1
        for _ in range(2000):
            await RisingEdge(dut.clk)
        kept.append(dut.count)
        return int(dut.count.value)

    threads = [threading.Thread(target=lambda: results.append(simulate(counter, bench))) for _ in range(4)]
    [t.start() for t in threads]
    [t.join() for t in threads]
    assert results == [1999 % 256] * 4
    with pytest.raises(hoverlock.SimulationError, match="another thread"):
        kept[0].value


def test_another_thread_is_refused_without_a_panic(capfd):
    refused = []

    def try_all(things):
        for thing in things:
            with pytest.raises(hoverlock.SimulationError, match="another thread") as caught:
                thing()
            refused.append(str(caught.value))

    async def bench(dut):
        event, lock, task = hoverlock.Event(), hoverlock.Lock(), start_soon(Clock(dut.clk, 10, "ns").cycles(3))
        clock, edge = Clock(dut.clk, 10, "ns").start(), RisingEdge(dut.clk)
        event.clear(), lock.locked()
        things = [
            lambda: dut.count.value, lambda: setattr(dut.step, "value", 1), lambda: dut.step[0].value,
            lambda: repr(task), task.cancel, task.done, event.set, event.is_set, lock.release, lock.locked,
            clock.stop, lambda: hoverlock.First(edge), lambda: RisingEdge(dut.clk), lambda: iter(edge),
        ]  # fmt: skip
        thread = threading.Thread(target=try_all, args=(things,))
        thread.start()
        thread.join()
        assert len(refused) == len(things)

    with hoverlock.Session(counter) as session:
        session.run(bench)
        calls = [lambda: session.run(bench), lambda: session.run_for(1, "ns"), session.close]
        thread = threading.Thread(target=try_all, args=(calls,))
        thread.start()
        thread.join()
        assert len(refused) == 17
    assert "panicked" not in capfd.readouterr().err


def test_handles_of_an_ended_test_are_told():
    old = {}

    async def first(dut):
        old.update(dut=dut, edge=RisingEdge(dut.clk), task=start_soon(Clock(dut.clk, 10, "ns").cycles(9)), clock=Clock(dut.clk, 10, "ns").start())
        await old["edge"]

    async def second(dut):
        with pytest.raises(hoverlock.SimulationError, match="'step' belongs to a simulation that has ended"):
            old["dut"].step.value = 3
        with pytest.raises(hoverlock.SimulationError, match="'clk' belongs to another simulation"):
            Clock(old["dut"].clk, 10, "ns").start()
        with pytest.raises(hoverlock.SimulationError, match="another simulation"):
            await old["edge"]
        with pytest.raises(hoverlock.SimulationError, match="another simulation"):
            await old["task"]
        await Timer(100, "ns")
        assert dut.clk.value == 0 and dut.step.value == 0

    simulate(counter, first)
    simulate(counter, second)
    with pytest.raises(hoverlock.SimulationError, match="'rst' belongs to a simulation that has ended"):
        old["dut"].rst.value = 1


def test_events_locks_and_queues_of_a_module_serve_test_after_test():
    event, lock, queue = hoverlock.Event("shared"), hoverlock.Lock("shared"), hoverlock.Queue()

    async def bench(dut):
        async def later():
            await Timer(5, "ns")
            event.set()
            queue.put_nowait("item")

        async with lock:
            start_soon(later())
            await event.wait()
            assert await queue.get() == "item"
        event.clear()
        await lock.acquire()  # and never released: the next test finds it free
        return hoverlock.get_sim_time("ns")

    assert [simulate(counter, bench) for _ in range(3)] == [5, 5, 5]


def test_an_fst_that_does_not_fit_is_an_error_and_no_abort(tmp_path):
    # The build comes first: the limit is of all files that the process writes.
    recorded = counter.changed(waves="fst")
    try:
        recorded.compile()
    except hoverlock.BuildError as error:
        pytest.skip(f"SKIPPED: no FST waves here: {error}")
    (tmp_path / "bench.py").write_text(textwrap.dedent(f"""
        import resource, sys
        import hoverlock
        from hoverlock import Clock, Design, Session, Timer

        async def bench(dut):
            Clock(dut.clk, 10, "ns").start()
            dut.enable.value = dut.step.value = 1
            await Timer(300, "us")

        design = Design({str(counter.sources[0])!r}, top="counter", folder={str(counter.folder)!r}, waves="fst")
        resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]),) * 2)
        with Session(design) as session:
            session.simulation.start_waves("all.fst")
            session.run(bench)
    """))
    outcome = {}
    for limit in (2000, 1 << 20):
        done = subprocess.run([sys.executable, "bench.py", str(limit)], cwd=tmp_path, capture_output=True, text=True)
        outcome[limit] = (done.returncode, done.stderr)
    assert outcome[1 << 20] == (0, "")
    assert outcome[2000][0] == 1 and "the waves are not whole" in outcome[2000][1], outcome[2000]


def test_a_full_disk_ends_the_test_with_its_reason(tmp_path):
    async def bench(dut):
        Clock(dut.clk, 10, "ns").start()
        dut.enable.value, dut.step.value = 1, 1
        await Timer(1, "ms")

    (tmp_path / "all.vcd").symlink_to("/dev/full")
    with hoverlock.Session(counter.changed(waves="vcd")) as session:
        session.simulation.start_waves(tmp_path / "all.vcd")
        with pytest.raises(hoverlock.HoverlockError, match=r"all\.vcd: No space left on device"):
            session.run(bench)
        # The session is still there.
        session.run_for(10, "ns")
    (tmp_path / "some.vcd").symlink_to("/dev/full")
    with hoverlock.Session(counter) as session:
        session.simulation.start_waves(tmp_path / "some.vcd", ["clk", "count"])
        with pytest.raises(hoverlock.HoverlockError, match=r"some\.vcd.*No space left on device"):
            session.run(bench)


def test_other_threads_run_while_no_python_does():
    beats = []
    stop = threading.Event()

    def beat():
        while not stop.is_set():
            beats.append(time.monotonic())
            time.sleep(0.005)

    async def bench(dut):
        Clock(dut.clk, 10, "ns").start()
        await Timer(20, "ms")  # two million cycles without Python

    thread = threading.Thread(target=beat)
    thread.start()
    try:
        started = time.monotonic()
        simulate(counter, bench)
        seconds = time.monotonic() - started
    finally:
        stop.set()
        thread.join()
    # Were the lock kept, no beat would fall into the run but at its ends.
    assert len([b for b in beats if started < b < started + seconds]) > seconds / 0.1


def test_random_numbers_come_from_the_seed():
    async def bench(dut):
        return random.random()

    assert simulate(counter, bench, seed=5) == simulate(counter, bench, seed=5) != simulate(counter, bench, seed=6)


def run_pytest(folder, *options):
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *options], cwd=folder, env=environment, capture_output=True, text=True
    )


@pytest.fixture
def benches(tmp_path):
    (tmp_path / "test_bench.py").write_text(textwrap.dedent(f"""
        import random
        import hoverlock
        from hoverlock import Clock, ClockCycles, Design, Timer
        design = Design({str(HERE / 'designs/counter.v')!r}, top="counter")

        @hoverlock.test()
        async def good(dut):
            Clock(dut.clk, 10, "ns").start()
            await ClockCycles(dut.clk, 3)

        @hoverlock.test()
        async def bad(dut):
            await Timer(1, "ns")
            assert int(dut.count.value) == random.randrange(1, 10**9), "not the count"

        @hoverlock.test(skip=True)
        async def left_out(dut):
            pass
    """))
    return tmp_path


def test_pytest_reports_in_parallel_with_junit_and_seed(benches):
    done = run_pytest(benches, "-n", "2", "--junitxml", "r.xml", "--hoverlock-seed", "77")
    assert "1 failed, 1 passed, 1 skipped" in done.stdout
    assert "--hoverlock-seed 77" in done.stdout and "not the count" in done.stdout
    xml = (benches / "r.xml").read_text()
    assert 'tests="3"' in xml and 'failures="1"' in xml and "random_seed" in xml
    shown = [line for line in done.stdout.splitlines() if "random.randrange" in line and "assert" in line]
    again = run_pytest(benches, "-k", "bad", "--hoverlock-seed", "77")
    compared = [line for line in done.stdout.splitlines() if "assert 0 ==" in line]
    assert shown and compared and [line for line in again.stdout.splitlines() if "assert 0 ==" in line] == compared
    other = run_pytest(benches, "-k", "bad", "--hoverlock-seed", "78")
    assert [line for line in other.stdout.splitlines() if "assert 0 ==" in line] != compared


def test_the_traceback_begins_in_the_bench(benches):
    done = run_pytest(benches, "-k", "bad")
    assert "testing.py" not in done.stdout and "session.py" not in done.stdout and "test_bench.py:15" in done.stdout


def test_the_command_line(benches):
    def command(*options):
        return subprocess.run([sys.executable, "-m", "hoverlock", *options], cwd=benches, capture_output=True, text=True)

    done = command("test_bench.py", "--hoverlock-seed", "5", "--junit", "r.xml")
    assert done.returncode == 1 and "1 passed, 1 failed, 1 skipped (seed 5)" in done.stdout
    assert "replay with --hoverlock-seed 5" in done.stdout and 'failures="1"' in (benches / "r.xml").read_text()
    assert command("test_bench.py", "-k", "good").returncode == 0
    for wrong in (["nowhere.py"], ["test_bench.py", "-k", "nothing"], ["test_bench.py", "--hoverlock-top", "x"]):
        done = command(*wrong)
        assert done.returncode == 2 and done.stderr.startswith("hoverlock:") and "Traceback" not in done.stderr


@pytest.mark.parametrize("body", ["await Timer(1000, 'sec')", "await forever(dut)"])
def test_ctrl_c_ends_at_once(tmp_path, body):
    (tmp_path / "bench.py").write_text(textwrap.dedent(f"""
        from hoverlock import *
        async def forever(dut):
            while True:
                await RisingEdge(dut.clk)
        async def bench(dut):
            Clock(dut.clk, 10, "ns").start()
            print("runs", flush=True)
            {body}
        simulate(Design({str(HERE / 'designs/counter.v')!r}, top="counter"), bench)
    """))
    # A shell starts what runs in its background with Ctrl-C ignored, and children inherit that: the bench gets it back.
    heed = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)
    with subprocess.Popen([sys.executable, "bench.py"], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          preexec_fn=heed) as process:
        try:
            assert process.stdout.readline() == "runs\n"
            time.sleep(0.2)
            started = time.monotonic()
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=20)
        finally:
            process.kill()
    assert time.monotonic() - started < 3
    assert "KeyboardInterrupt" in said and process.returncode != 0
