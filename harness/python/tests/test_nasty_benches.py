"""Benches that end in every wrong way, run by a Makefile written for cocotb: the run fails, and says so in `results.xml`."""

import subprocess
import sys
import textwrap
from pathlib import Path
from xml.etree import ElementTree

import pytest

HERE = Path(__file__).parent

HEAD = """
import asyncio, ctypes, os, signal, sys, threading
import cocotb
from cocotb.clock import Clock
from cocotb.triggers import Event, First, RisingEdge, Timer

class Odd(BaseException):
    pass

class Mute(Exception):
    def __str__(self):
        raise RuntimeError("no text")
"""

# The body of one test each.
IN_A_TEST = {
    "assertion": "assert dut.count.value == 77",
    "exception": "1 / 0",
    "base_exception": "raise Odd('odd')",
    "exit_0": "sys.exit(0)",
    "exit_none": "sys.exit()",
    "os_exit_0": "os._exit(0)",
    "os_exit_1": "os._exit(1)",
    "os_exit_caught": "try:\n    os._exit(0)\nexcept BaseException:\n    pass",
    "os_exit_in_a_thread": "thread = threading.Thread(target=os._exit, args=(0,)); thread.start(); thread.join()",
    "exit_of_the_c_library": "ctypes.CDLL(None)._exit(0)",
    "exit_with_handlers": "ctypes.CDLL(None).exit(0)",
    "another_program": "os.execv('/bin/true', ['true'])",
    "killed": "os.kill(os.getpid(), signal.SIGKILL)",
    "terminated": "os.kill(os.getpid(), signal.SIGTERM)",
    "aborted": "os.abort()",
    "null_pointer": "ctypes.string_at(0)",
    "keyboard_interrupt": "raise KeyboardInterrupt",
    "generator_exit": "raise GeneratorExit",
    "stop_iteration": "raise StopIteration",
    "cancelled": "raise asyncio.CancelledError",
    "recursion": "def down():\n    down()\ndown()",
    "memory": "raise MemoryError",
    "mute_error": "raise Mute()",
    "control_characters": "raise ValueError('a\\x00b\\x1b[31mc\\ud800\\uffff')",
    "finally_raises": "try:\n    await Timer(1, 'ns')\nfinally:\n    raise ValueError('at the end')",
    "task_raises": "async def fall():\n    raise ValueError('in a task')\ncocotb.start_soon(fall())\nawait Timer(1, 'us')",
    "task_exits": "async def leave():\n    sys.exit(0)\ncocotb.start_soon(leave())\nawait Timer(1, 'us')",
    "task_os_exits": "async def leave():\n    os._exit(0)\ncocotb.start_soon(leave())\nawait Timer(1, 'us')",
    "never": "await Event().wait()",
    "no_such_signal": "dut.no_such_signal.value = 1",
    "too_large": "dut.enable.value = 5",
    "foreign_awaitable": "await asyncio.sleep(0)",
    "writes_too_much_to_an_output": "dut.count.value = 256",
    "closes_its_files": "os.closerange(3, 64)\nassert False",
    "another_folder": "os.chdir('/')\nassert False",
    "endless": "while True:\n    pass",
    "closes_stdout": "sys.stdout.close()\nassert False",
    "without_stdout": "sys.stdout = None\nassert False",
    "swallows_the_failure_of_a_task": "async def fall():\n    assert False\ncocotb.start_soon(fall())\n"
    "try:\n    await Timer(1, 'us')\nexcept BaseException:\n    pass",
    "alarm": "signal.alarm(1)\nwhile True:\n    pass",
    "group_of_exits": "raise BaseExceptionGroup('several', [SystemExit(0)])",
    "thread_ends_the_process": "threading.Timer(0.2, os._exit, (0,)).start()\nthreading.Event().wait(1)",
    "exits_when_freed": "class Last:\n    def __del__(self):\n        os._exit(0)\nlast = Last()\nassert False",
    "own_exception_hook": "sys.excepthook = lambda *_: os._exit(0)\nraise ValueError",
    "thread_outlives": "threading.Thread(target=threading.Event().wait, args=(600,)).start()\nassert False",
    "exits_in_a_signal_handler": "signal.signal(signal.SIGALRM, lambda *_: sys.exit(0))\nsignal.setitimer(signal.ITIMER_REAL, 0.1)\n"
    "while True:\n    await Timer(1, 'ns')",
    "native_code_waits": "import hashlib\nhashlib.pbkdf2_hmac('sha256', b'', b'', 10**9)",
    "blocks_the_alarm": "signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGALRM})\nwhile True:\n    pass",
    "may_write_no_file": "import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))",
    "message_of_other_scripts": "assert False, '\\U0001F600 \\u202e \\u05d0 \\ufffe'",
    "exit_of_the_interpreter": "ctypes.pythonapi.Py_Exit(0)",
    "task_is_interrupted": "async def stop():\n    raise KeyboardInterrupt\ncocotb.start_soon(stop())\nawait Timer(1, 'us')",
    "fails_while_freed": "class Last:\n    def __del__(self):\n        raise SystemExit(0)\nlast = Last()\nraise ValueError",
    "message_of_ten_megabytes": "assert False, 'x' * 10_000_000",
    "cancelled_task_fails_a_check": "async def wait():\n    try:\n        await Timer(1, 'us')\n    except BaseException:\n        assert False\n"
    "task = cocotb.start_soon(wait())\nawait Timer(1, 'ns')\ntask.cancel()",
    "finally_fails_a_check_at_the_end": "async def wait():\n    try:\n        await Timer(1, 'us')\n    finally:\n        assert False\n"
    "cocotb.start_soon(wait())\nawait Timer(1, 'ns')",
    "finally_never_ends": "async def wait():\n    try:\n        await Timer(1, 'us')\n    finally:\n        while True:\n            pass\n"
    "for _ in range(2):\n    cocotb.start_soon(wait())\nawait Timer(1, 'ns')",
    "catches_all_and_goes_on": "class Deaf:\n    def __await__(self):\n        while True:\n            try:\n                yield None\n"
    "            except BaseException:\n                pass\nawait Deaf()",
    "replaces_json": "import json\njson.dumps = lambda *_, **__: '{}'\nos._exit(0)",
}  # fmt: skip

# Whole modules.
MODULES = {
    "loads_with_an_error": "1 / 0",
    "loads_with_exit": "sys.exit(0)",
    "loads_with_os_exit": "os._exit(0)",
    "loads_and_is_killed": "os.kill(os.getpid(), signal.SIGKILL)",
    "has_an_error_of_syntax": "def (",
    "imports_nothing": "import no_such_module_anywhere",
    "exits_at_exit": "import atexit\natexit.register(os._exit, 0)\n@cocotb.test()\nasync def fails(dut):\n    assert False",
    "expects_a_failure": "@cocotb.test(expect_fail=True)\nasync def passes(dut):\n    pass",
    "expects_an_error": "@cocotb.test(expect_error=ValueError)\nasync def passes(dut):\n    pass",
    "expects_a_failure_and_exits": "@cocotb.test(expect_fail=True)\nasync def leaves(dut):\n    os._exit(0)",
    "expects_anything_and_is_killed": "@cocotb.test(expect_error=BaseException)\nasync def dies(dut):\n    os.kill(os.getpid(), signal.SIGKILL)",
    "is_an_async_generator": "@cocotb.test()\nasync def yields(dut):\n    yield 1\n    assert False",
    "is_no_coroutine": "@cocotb.test()\ndef plain(dut):\n    assert False",
    "replaces_exit": "sys.exit = lambda *_: os._exit(0)\n@cocotb.test()\nasync def fails(dut):\n    assert False",
    "times_out": "@cocotb.test(timeout_time=1, timeout_unit='us')\nasync def waits(dut):\n    await Timer(1, 'ms')",
    "one_of_two": "@cocotb.test()\nasync def passes(dut):\n    pass\n@cocotb.test()\nasync def dies(dut):\n    ctypes.CDLL(None)._exit(0)",
}

MAKEFILE = """
    VERILOG_SOURCES = {sources}
    PYTHON = {python}
    {more}
    include $(shell {python} -m hoverlock --makefile)
    TOPLEVEL = {top}
    MODULE = bench
"""


def run_make(folder: Path, bench: str, *arguments: str, sources: str = "", top: str = "counter", more: str = "") -> tuple[int, str, list]:
    """Runs `make` and returns its status, what it printed, and the tests of the results file as (name, failed)."""
    (folder / "bench.py").write_text(bench)
    sources = sources or str(HERE / "designs/counter.v")
    text = textwrap.dedent(MAKEFILE).format(sources=sources, python=sys.executable, top=top, more=more)
    (folder / "Makefile").write_text(text)
    (folder / "results.xml").write_text("<testsuites><testsuite><testcase name='stale'/></testsuite></testsuites>")
    done = subprocess.run(["make", *arguments], cwd=folder, capture_output=True, text=True, timeout=120, errors="replace")
    results = folder / "results.xml"
    assert results.is_file(), done.stdout + done.stderr
    cases = [(case.get("name"), case.find("failure") is not None) for case in ElementTree.parse(results).iter("testcase")]
    return done.returncode, done.stdout + done.stderr, cases


@pytest.mark.parametrize("name", IN_A_TEST)
def test_a_nasty_test_is_a_failed_run(name: str, tmp_path: Path) -> None:
    body = textwrap.indent(IN_A_TEST[name], "    ")
    bench = f"{HEAD}\n@cocotb.test()\nasync def passes(dut):\n    pass\n\n@cocotb.test()\nasync def nasty(dut):\n{body}\n"
    more = "HOVERLOCK_ARGS = --hoverlock-wall-timeout 2"
    status, text, cases = run_make(tmp_path, bench, more=more)
    assert status != 0, text[-5000:]
    ends = [("run", True)] if name in ("keyboard_interrupt", "task_is_interrupted") else [("nasty", True)]
    if name == "may_write_no_file":
        ends = [("nasty", False), ("run", True)]
    assert cases == [("passes", False), *ends], text[-5000:]


@pytest.mark.parametrize("name", MODULES)
def test_a_nasty_module_is_a_failed_run(name: str, tmp_path: Path) -> None:
    status, text, cases = run_make(tmp_path, f"{HEAD}\n{MODULES[name]}\n")
    assert status != 0 and any(failed for _, failed in cases), text
    if name == "one_of_two":
        assert cases == [("passes", False), ("dies", True)]


@pytest.mark.parametrize(
    "parent", ["time.sleep(0.5); assert False", "time.sleep(0.5); os._exit(0)", "assert False"], ids=["fails", "exits", "fails_first"]
)
def test_the_verdict_of_a_forked_child_does_not_count(parent: str, tmp_path: Path) -> None:
    child = "time.sleep(0.5); return" if parent == "assert False" else "return"
    bench = f"{HEAD}import time\n@cocotb.test()\nasync def forks(dut):\n    if os.fork() == 0:\n        {child}\n    {parent}\n"
    status, text, cases = run_make(tmp_path, bench)
    assert status != 0 and cases == [("forks", True)], text


def test_tests_of_one_name_are_two_tests(tmp_path: Path) -> None:
    bench = f"{HEAD}\n@cocotb.test(name='same')\nasync def first(dut):\n    assert False\n@cocotb.test(name='same')\nasync def other(dut):\n    pass\n"
    status, text, cases = run_make(tmp_path, bench)
    assert status != 0 and cases == [("same", True), ("same", False)], text


def test_a_skipped_test_that_is_asked_for_runs(tmp_path: Path) -> None:
    bench = f"{HEAD}\n@cocotb.test(skip=True)\nasync def aside(dut):\n    assert False\n"
    assert run_make(tmp_path, bench)[::2] == (0, [("aside", False)]), "skipped"
    for choice in ("TESTCASE=aside", "COCOTB_TEST_FILTER=asi.e"):
        status, text, cases = run_make(tmp_path, bench, choice)
        assert status != 0 and cases == [("aside", True)], text


def test_a_bench_does_not_see_the_arguments_of_the_run(tmp_path: Path) -> None:
    bench = f"{HEAD}\n@cocotb.test()\nasync def parses(dut):\n    assert len(sys.argv) == 1, sys.argv\n"
    status, text, cases = run_make(tmp_path, bench)
    assert status == 0 and cases == [("parses", False)], text


def test_results_of_several_runs_are_combined(tmp_path: Path) -> None:
    command = [sys.executable, "-c", "import hoverlock, runpy; hoverlock.as_cocotb(); runpy._run_module_as_main('cocotb_tools.combine_results')"]
    statuses = []
    for name, body in (("good", "pass"), ("bad", "assert False")):
        (tmp_path / name).mkdir()
        run_make(tmp_path / name, f"{HEAD}\n@cocotb.test()\nasync def {name}(dut):\n    {body}\n")
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120)
        statuses.append(done.returncode)
    assert statuses == [0, 1] and "testcase: 'bad'" in done.stdout and "2 TestSuites and 2 TestCases" in done.stdout, done
    combined = ElementTree.parse(tmp_path / "combined_results.xml")
    assert sorted(case.get("name") for case in combined.iter("testcase")) == ["bad", "good"]


def test_results_that_cannot_be_written_are_a_failed_run(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    status, text, cases = run_make(tmp_path, PASSES, "COCOTB_RESULTS_FILE=folder/none/results.xml")
    assert status != 0 and "folder/none" in text and [name for name, _ in cases] == ["stale"]
    status, text, _ = run_make(tmp_path, PASSES, "COCOTB_RESULTS_FILE=folder")
    assert status != 0 and "folder" in text


def test_a_run_without_its_supervisor_is_a_failed_run(tmp_path: Path) -> None:
    bench = f"{HEAD}\n@cocotb.test()\nasync def kills(dut):\n    os.kill(os.getppid(), signal.SIGKILL)\n    await Timer(1, 'ns')\n"
    (tmp_path / "bench.py").write_text(bench)
    command = [sys.executable, "-m", "hoverlock", "--as-cocotb", "bench.py", "--hoverlock-top", "counter", "--hoverlock-source"]
    done = subprocess.run([*command, str(HERE / "designs/counter.v")], cwd=tmp_path, capture_output=True, timeout=120)
    assert done.returncode != 0


def test_a_thread_does_not_hold_a_run_that_has_passed(tmp_path: Path) -> None:
    bench = f"{PASSES}    threading.Thread(target=threading.Event().wait, args=(600,)).start()\n"
    status, text, cases = run_make(tmp_path, bench)
    assert status == 0 and cases == [("passes", False)], text


def test_a_killed_run_is_a_failed_run(tmp_path: Path) -> None:
    bench = f"{HEAD}\n@cocotb.test()\nasync def forks(dut):\n    child = os.fork()\n    if child == 0:\n        os._exit(3)\n"
    bench += "    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 3\n"
    status, text, cases = run_make(tmp_path, bench)
    assert status == 0 and cases == [("forks", False)], text
    bench = f"{HEAD}\n@cocotb.test()\nasync def kills(dut):\n    os.kill(os.getppid(), signal.SIGTERM)\n    await Timer(1, 'ns')\n    while True: pass\n"
    status, text, cases = run_make(tmp_path, bench)
    assert status != 0 and cases == [("kills", True)], text


PASSES = f"{HEAD}\n@cocotb.test()\nasync def passes(dut):\n    Clock(dut.clk, 10, 'ns').start()\n    await RisingEdge(dut.clk)\n"


@pytest.mark.parametrize(
    "flags", ["--trace", "--trace-fst", "--coverage", "--threads 2", "--timing --vpi", "--trace --trace-structs --coverage-line -j 2"]
)
def test_flags_of_verilator_that_cocotb_users_pass(flags: str, tmp_path: Path) -> None:
    status, text, cases = run_make(tmp_path, PASSES, more=f"EXTRA_ARGS += {flags}")
    assert status == 0 and cases == [("passes", False)], text
    waves = [path.suffix for path in (tmp_path / "hoverlock-output").glob("bench.passes.*")]
    assert (".fst" in waves) == ("--trace-fst" in flags) and (".vcd" in waves) == ("--trace " in f"{flags} ")


def test_a_flag_that_cannot_be_heeded_is_refused_in_one_line(tmp_path: Path) -> None:
    status, text, cases = run_make(tmp_path, PASSES, more="EXTRA_ARGS += --sc")
    assert status != 0 and "the flag --sc of Verilator: models are C++, not SystemC" in text and cases == [("run", True)]
    status, text, _ = run_make(tmp_path, PASSES, more="EXTRA_ARGS += --no-such-flag")
    assert status != 0 and "--no-such-flag" in text


def test_sources_that_dump_waves_and_names_of_cpp(tmp_path: Path) -> None:
    words = ("abort", "delete", "template", "class_", "new_", "this_", "public", "private", "operator", "int32_t")
    ports = "".join(f", input {word}, output reg {word}_q" for word in words)
    body = "".join(f"    always @(posedge clk) {word}_q <= {word};\n" for word in words)
    dumps = 'initial begin $dumpfile("own.vcd"); $dumpvars(0, names); end'
    (tmp_path / "names.v").write_text(f"module names(input clk{ports});\n{body}    {dumps}\nendmodule\n")
    lines = "".join(f"    dut._id('{word}', extended=False).value = 1\n" for word in words)
    checks = "".join(f"    assert dut._id('{word}_q', extended=False).value == 1\n" for word in words)
    bench = f"{PASSES}{lines}    await RisingEdge(dut.clk)\n    await Timer(1, 'ns')\n{checks}"
    status, text, cases = run_make(tmp_path, bench, sources="names.v", top="names")
    assert status == 0 and cases == [("passes", False)], text
