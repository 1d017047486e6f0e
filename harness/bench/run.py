#!/usr/bin/env python3
"""Hoverlock against cocotb 1.9 on Verilator, cocotb 2 on Icarus, and the plain Verilator loop in C++.

    python harness/bench/run.py [--runs 3] [--json FILE]

Run it with the Python that has `hoverlock` installed. The rivals are installed into venvs in a cache folder, once. All
benches are one source (`benches.py`), and what they saw must be equal. Times are CPU times; each number is the median of the
runs, and the rivals take turns, so that a busy machine meets all alike.
"""

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
DESIGN = HERE.parent / "tests" / "designs" / "stream.v"
CACHE = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "hoverlock" / "bench"
RIVALS = {"cocotb 1.9 Verilator": "cocotb==1.9.2", "cocotb 2 Icarus": "cocotb==2.1.0"}
NAMES = ["per_cycle", "per_cycle_by_name", "driver_and_monitor", "source_and_sink", "clock_only"]

ONE = """
import os, sys
sys.path.insert(0, {here!r})
if os.environ["BENCH_WITH"] == "hoverlock":
    from hoverlock.cocotb.runner import get_runner
elif os.environ["BENCH_SIM"] == "verilator":
    from cocotb.runner import get_runner
else:
    from cocotb_tools.runner import get_runner
runner = get_runner(os.environ["BENCH_SIM"])
flags = ["-O3", "-CFLAGS", "-O3", "-Wno-fatal"] if os.environ["BENCH_SIM"] == "verilator" and "cocotb" in os.environ["BENCH_WITH"] else []
runner.build(sources=[{design!r}], hdl_toplevel="stream", build_args=flags, build_dir={build!r}, always=False, timescale=("1ns", "1ps"))
runner.test(hdl_toplevel="stream", test_module="benches", testcase=os.environ["BENCH_CASE"], build_dir={build!r}, test_dir={build!r}, results_xml="results.xml")
"""


def run(name: str, with_: str, python: str, simulator: str, cycles: int, build: Path) -> dict:
    """One bench in a process of its own: cocotb keeps one model for all tests of a run."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        script = ONE.format(here=str(HERE), design=str(DESIGN), build=str(build))
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
            "PATH": f"{Path(python).parent}:{os.environ['PATH']}",
        }
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

with Session(Design({design!r}, top="stream", folder=".")) as session:
    session.run(reset)
    session.transfer(words[:1000], stall=0.25)
    started = time.process_time()
    received = session.transfer(words, stall=0.25, seed=7)
    seconds = time.process_time() - started
    assert len(received) == len(words)
    print(json.dumps({{"cycles": session.report[0], "seconds": seconds, "check": int(received[:4000].sum())}}))
"""


def arrays(words: int) -> dict:
    """Whole frames as numpy arrays, the sink not ready in one cycle of four, at random."""
    script = ARRAYS.format(words=words, design=str(DESIGN))
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"arrays: {done.stderr[-3000:]}")
    return json.loads(done.stdout)


def rival(requirement: str) -> str:
    """A venv with a rival; gives its Python."""
    venv = CACHE / requirement.replace("==", "-")
    python = venv / "bin" / "python"
    if not (venv / "complete").exists():
        print(f"installing {requirement} into {venv}", file=sys.stderr)
        shutil.rmtree(venv, ignore_errors=True)
        subprocess.run([sys.executable, "-m", "venv", str(venv)], check=True)
        subprocess.run([str(python), "-m", "pip", "install", "-q", requirement], check=True)
        (venv / "complete").touch()
    return str(python)


def limit() -> Path:
    """The plain loop, built with full optimisation."""
    folder = CACHE / "limit"
    program = folder / "limit"
    source = HERE.parent / "benches" / "limit.cpp"
    if not program.exists() or program.stat().st_mtime < max(source.stat().st_mtime, DESIGN.stat().st_mtime):
        folder.mkdir(parents=True, exist_ok=True)
        subprocess.run(
            ["verilator", "--cc", "--exe", "--build", "-O3", "-CFLAGS", "-O3", "-MAKEFLAGS", "OPT_FAST=-O3",
             "--assert", "--x-assign", "0", "--x-initial", "0", "-Wno-fatal", "--no-timing", "--top-module", "stream", "--Mdir",
             str(folder), "-o", "limit", str(DESIGN), str(source)],
            check=True, capture_output=True,
        )
    return program


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--json", metavar="FILE", help="writes all measurements")
    chosen = parser.parse_args()
    if not shutil.which("iverilog"):
        sys.exit("iverilog is missing: apt-get install iverilog")

    contestants = {
        "hoverlock": ("hoverlock", sys.executable, "verilator", 1_000_000),
        "cocotb 1.9 Verilator": ("cocotb 1.9", rival(RIVALS["cocotb 1.9 Verilator"]), "verilator", 20_000),
        "cocotb 2 Icarus": ("cocotb 2", rival(RIVALS["cocotb 2 Icarus"]), "icarus", 20_000),
    }
    program = limit()
    speed: dict[str, dict[str, list[float]]] = {c: {n: [] for n in NAMES} for c in contestants}
    checks: dict[str, set[int]] = {n: set() for n in NAMES}
    loops, whole = [], []
    for _ in range(chosen.runs):
        done = subprocess.run([str(program), "20000000"], check=True, capture_output=True, text=True)
        loops.append(20e6 / float(done.stdout.split()[0]))
        line = arrays(5_000_000)
        whole.append(line["cycles"] / line["seconds"])
        for label, (with_, python, simulator, cycles) in contestants.items():
            for name in NAMES:
                line = run(name, with_, python, simulator, cycles, CACHE / f"build-{label.replace(' ', '-')}")
                speed[label][name].append(line["cycles"] / line["seconds"])
                checks[name].add(line["check"])
    for name, seen in checks.items():
        if len(seen) != 1:
            sys.exit(f"{name}: the benches saw different things: {sorted(seen)}")

    def median(label: str, name: str) -> float:
        return statistics.median(speed[label][name])

    loop = statistics.median(loops)
    print(f"cycles per second of CPU time, median of {chosen.runs} runs; plain C++ loop {loop / 1e6:.1f} M")
    print("| bench | hoverlock | cocotb 1.9 Verilator | ratio | cocotb 2 Icarus | ratio | of the C++ loop |")
    print("|---|---|---|---|---|---|---|")
    for name in NAMES:
        ours, first, second = (median(label, name) for label in contestants)
        print(f"| {name.replace('_', ' ')} | {ours / 1e6:.2f} M | {first / 1e3:.1f} k | {ours / first:.0f} | "
              f"{second / 1e3:.1f} k | {ours / second:.0f} | {ours / loop:.3f} |")
    frames = statistics.median(whole)
    print(f"| numpy arrays, random back-pressure | {frames / 1e6:.2f} M | | | | | {frames / loop:.3f} |")
    if chosen.json:
        Path(chosen.json).write_text(json.dumps({"loop": loops, "arrays": whole, "speed": speed}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
