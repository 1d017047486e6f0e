"""A test with a cached model starts fast: modules that load slowly are imported only where they are used."""

import subprocess
import sys
from pathlib import Path

BENCH = """
import sys
before = set(sys.modules)
import hoverlock
from hoverlock import Clock, ClockCycles, Design

async def bench(dut):
    Clock(dut.clk, 10, "ns").start()
    await ClockCycles(dut.clk, 3)
    assert "numpy" not in sys.modules and dut._log.name == "hoverlock.counter"

hoverlock.simulate(Design(sys.argv[1], top="counter"), bench)
print(*sorted({name.split(".")[0] for name in set(sys.modules) - before}))
"""


def test_a_run_without_arrays_and_files_loads_no_more_than_it_needs():
    counter = Path(__file__).parent / "designs" / "counter.v"
    command = [sys.executable, "-c", BENCH, str(counter)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    loaded = done.stdout.split()
    assert "hoverlock" in loaded
    # numpy takes more than everything else together; pathlib 4 of 50 ms.
    assert not {"numpy", "pathlib", "pytest", "asyncio", "argparse", "subprocess"} & set(loaded)
