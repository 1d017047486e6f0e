"""cocotb's own examples, run as their folders are: a runner in the test file, `SIM` as it happens to be set."""

import os
import re
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

EXAMPLES = {
    "adder": ("adder.v", """
        @cocotb.test()
        async def adder_basic_test(dut):
            A, B = 5, 10
            dut.A.value = A
            dut.B.value = B
            await Timer(2, units="ns")
            assert dut.X.value == A + B, f"Adder result is incorrect: {dut.X.value} != 15"
    """),
    "dff": ("dff.v", """
        @cocotb.test()
        async def dff_simple_test(dut):
            initial = LogicArray(0, 1)
            dut.d.value = initial
            clock = Clock(dut.clk, 10, unit="us")
            clock.start(start_high=False)
            await RisingEdge(dut.clk)
            expected_val = initial
            for i in range(10):
                val = random.randint(0, 1)
                dut.d.value = val
                await RisingEdge(dut.clk)
                assert dut.q.value == expected_val, f"output q was incorrect on the {i}th cycle"
                expected_val = val
            await RisingEdge(dut.clk)
            assert dut.q.value == expected_val
    """),
    "counter": ("counter.v", """
        @cocotb.test()
        async def simple_counter_test(dut):
            cocotb.start_soon(Clock(dut.clk, 1, units="ns").start())
            dut.rst.value = 1
            await ClockCycles(dut.clk, 5)
            dut.rst.value, dut.enable.value, dut.step.value = 0, 1, 1
            await RisingEdge(dut.clk)
            for count in range(50):
                await RisingEdge(dut.clk)
                v_count = dut.count.value
                mod_cnt = (count + 1) % 256  # one step was made at the edge before
                assert v_count.integer == mod_cnt, "counter result is incorrect: %s != %s" % (str(v_count), mod_cnt)
    """),
    "matrix_multiplier": ("matrix_multiplier.sv", """
        NUM_SAMPLES = int(os.environ.get("NUM_SAMPLES", 50))

        class MatrixMultiplierTester:
            def __init__(self, entity):
                self.dut = entity
                self.input_mon = DataValidMonitor(entity.clk_i, entity.valid_i, dict(A=entity.a_i, B=entity.b_i))
                self.output_mon = DataValidMonitor(entity.clk_i, entity.valid_o, dict(C=entity.c_o))
                self._checker = None

            def start(self):
                self.input_mon.start()
                self.output_mon.start()
                self._checker = cocotb.start_soon(self._check())

            def model(self, a, b):
                rows, inner, columns = (self.dut.A_ROWS.value, self.dut.A_COLUMNS_B_ROWS.value, self.dut.B_COLUMNS.value)
                return [
                    sum(int(a[i * inner + n]) * int(b[n * columns + j]) for n in range(inner))
                    for i in range(rows) for j in range(columns)
                ]

            async def _check(self):
                while True:
                    actual = await self.output_mon.values.get()
                    inputs = await self.input_mon.values.get()
                    assert actual["C"] == self.model(inputs["A"], inputs["B"])

        class DataValidMonitor:
            def __init__(self, clk, valid, datas):
                self.values = Queue()
                self._clk, self._valid, self._datas, self._coro = clk, valid, datas, None

            def start(self):
                self._coro = cocotb.start_soon(self._run())

            async def _run(self):
                while True:
                    await RisingEdge(self._clk)
                    if self._valid.value.binstr != "1":
                        await RisingEdge(self._valid)
                        continue
                    self.values.put_nowait({name: handle.value for name, handle in self._datas.items()})

        @cocotb.test(expect_error=IndexError if cocotb.SIM_NAME.lower().startswith("ghdl") else ())
        async def multiply_test(dut):
            cocotb.start_soon(Clock(dut.clk_i, 10, units="ns").start())
            tester = MatrixMultiplierTester(dut)
            dut.reset_i.value = 1
            dut.valid_i.value = 0
            dut.a_i.value = [0 for _ in range(int(dut.A_ROWS) * int(dut.A_COLUMNS_B_ROWS))]
            dut.b_i.value = [0 for _ in range(int(dut.A_COLUMNS_B_ROWS) * int(dut.B_COLUMNS))]
            for _ in range(3):
                await RisingEdge(dut.clk_i)
            dut.reset_i.value = 0
            tester.start()
            for i in range(NUM_SAMPLES):
                await RisingEdge(dut.clk_i)
                dut.a_i.value = [random.getrandbits(int(dut.DATA_WIDTH)) for _ in range(len(dut.a_i))]
                dut.b_i.value = [random.getrandbits(int(dut.DATA_WIDTH)) for _ in range(len(dut.b_i))]
                dut.valid_i.value = 1
                await RisingEdge(dut.clk_i)
                dut.valid_i.value = 0
            await RisingEdge(dut.clk_i)
            await RisingEdge(dut.clk_i)
            assert tester.output_mon.values.empty()
    """),
}


@pytest.mark.parametrize("name", EXAMPLES)
def test_cocotbs_examples_run_from_their_runner(tmp_path, name):
    source, bench = EXAMPLES[name]
    (tmp_path / source).write_text((Path(__file__).parent / "designs" / source).read_text())
    (tmp_path / f"test_{name}.py").write_text(
        "import os\nimport random\nfrom pathlib import Path\n\nimport hoverlock.cocotb as cocotb\n"
        "from hoverlock.cocotb.clock import Clock\nfrom hoverlock.cocotb.queue import Queue\n"
        "from hoverlock.cocotb.triggers import ClockCycles, FallingEdge, RisingEdge, Timer\n"
        "from hoverlock.cocotb.types import LogicArray\nfrom hoverlock.cocotb_tools.runner import get_runner\n\n"
        + textwrap.dedent(bench)
        + textwrap.dedent(f"""
            def test_{name}_runner():
                sim = os.getenv("SIM", "icarus")
                here = Path(__file__).resolve().parent
                runner = get_runner(sim)
                runner.build(sources=[here / "{source}"], hdl_toplevel="{name}", always=True, build_args=["-g2012"])
                runner.test(hdl_toplevel="{name}", test_module="test_{name},")
        """)
    )
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-s", "-p", "no:cacheprovider", "."],
        cwd=tmp_path, env=environment, capture_output=True, text=True,
    )  # fmt: skip
    ran = "1 passed, 0 failed, 0 skipped (seed" in done.stdout and re.search(r"^1 passed in", done.stdout, re.MULTILINE)
    assert ran and done.returncode == 0, done.stdout + done.stderr
