"""A fresh venv: the wheel of this module and the packages written for cocotb, each as `pip install` gives it. They bring
cocotb along; the alias must still give this module.

It takes two minutes, and PyPI: `make test-long` runs it. HOVERLOCK_LONG_TESTS=1 asks for it.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
BENCH = HERE / "aliased" / "loopbacks.py"
DESIGN = ["--hoverlock-source", str(HERE / "designs" / "joined.v"), "--hoverlock-top", "joined"]
REQUIREMENTS = HERE.parents[2] / "setup" / "requirements-cocotb.txt"

pytestmark = pytest.mark.skipif(
    os.environ.get("HOVERLOCK_LONG_TESTS") != "1", reason="SKIPPED: a fresh venv: HOVERLOCK_LONG_TESTS=1 asks for it"
)


def call(*command, **options):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **options)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return done.stdout


@pytest.fixture(scope="module")
def python(tmp_path_factory):
    """The interpreter of a venv with the wheel and the packages, installed with all that they require."""
    folder = tmp_path_factory.mktemp("clean")
    maturin = shutil.which("maturin") or Path(sys.executable).with_name("maturin")
    call(maturin, "build", "--quiet", "--locked", "--out", folder, cwd=HERE.parent)
    (wheel,) = folder.glob("*.whl")
    call(sys.executable, "-m", "venv", folder / "venv")
    python = folder / "venv" / "bin" / "python"
    done = subprocess.run(
        [python, "-m", "pip", "install", "-q", wheel, "pytest", "-r", REQUIREMENTS], capture_output=True, text=True
    )
    if done.returncode and "Could not find a version" in done.stderr:
        pytest.skip(f"SKIPPED: the packages are not available: {done.stderr.strip().splitlines()[-1]}")
    assert done.returncode == 0, done.stderr[-3000:]
    return python


def environment(python, which):
    """The environment without anything of the venv that the tests run in; with the older or the newer Verilator."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV", "VERILATOR"))}
    if which == "newer":
        (verilator,) = python.parents[1].glob("lib/python3*/site-packages/verilator/bin/verilator")
        kept["VERILATOR"] = str(verilator)
    return {**kept, "PYTHONDONTWRITEBYTECODE": "1"}


def test_cocotb_itself_is_there_and_the_alias_still_gives_this_module(python, tmp_path):
    said = "import cocotb; print(cocotb.__file__)"
    options = {"cwd": tmp_path, "env": environment(python, "older")}
    assert "/site-packages/cocotb/" in call(python, "-c", said, **options)
    aliased = call(python, "-c", f"import hoverlock; hoverlock.as_cocotb(); {said}; import cocotb_tools.runner as r; print(r.__name__)", **options)
    assert aliased.split()[0].endswith("/site-packages/hoverlock/cocotb/__init__.py") and "hoverlock" in aliased.split()[1]


@pytest.mark.parametrize("version", ["1.9", "2.1"])
@pytest.mark.parametrize("which", ["older", "newer"])
def test_the_packages_run(python, tmp_path, which, version):
    command = [python, "-m", "hoverlock", "--as-cocotb", "--cocotb-version", version, BENCH, *DESIGN, "--hoverlock-seed", "1"]
    assert "12 passed, 0 failed, 0 skipped" in call(*command, cwd=tmp_path, env=environment(python, which))


@pytest.mark.parametrize("which", ["older", "newer"])
def test_the_packages_run_in_pytest(python, tmp_path, which):
    shutil.copy(BENCH, tmp_path / "test_loopbacks.py")
    command = [python, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "hoverlock.as_cocotb", *DESIGN]
    assert "12 passed" in call(*command, cwd=tmp_path, env=environment(python, which))
