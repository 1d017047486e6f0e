"""The types are right: mypy finds nothing in the module, and finds what is wrong in a bench."""

import subprocess
import sys
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]


def mypy(*arguments, cwd=PACKAGE):
    done = subprocess.run([sys.executable, "-m", "mypy", *arguments], cwd=cwd, capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


def test_mypy_finds_no_error_in_the_module():
    status, said = mypy()
    assert status == 0, said


def test_mypy_finds_the_wrong_lines_of_a_bench(tmp_path):
    (tmp_path / "bench.py").write_text(
        "from hoverlock import Hierarchy, RisingEdge, Timer, test\n"
        "@test()\n"
        "async def good(dut: Hierarchy) -> None:\n"
        "    await RisingEdge(dut.clk)\n"
        "    await Timer(3, 'ns')\n"
        "async def bad(dut: Hierarchy) -> None:\n"
        "    await RisingEdge(3)\n"
        "    await Timer('ns', 3)\n"
    )
    status, said = mypy("--strict", "--config-file=", "bench.py", cwd=tmp_path)
    assert status == 1 and "bench.py:7" in said and "bench.py:8" in said and "bench.py:4" not in said
