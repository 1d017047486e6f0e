"""`import cocotb`: packages written for cocotb run without an edit, and cocotb is not touched where nobody asks."""

import importlib.util
import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

HERE = Path(__file__).parent
PACKAGES = ["cocotb_bus", "cocotb_coverage", "cocotbext.axi", "cocotbext.eth", "cocotbext.uart", "cocotbext.i2c", "cocotbext.spi"]
JOINED = ["--hoverlock-source", str(HERE / "designs" / "joined.v"), "--hoverlock-top", "joined"]
DFF = ["--hoverlock-source", str(HERE / "designs" / "dff.v"), "--hoverlock-top", "dff"]


def missing():
    """The packages that are not installed. They import cocotb as they are loaded, so they are only looked for."""
    def is_there(name):
        folder, _, below = name.partition(".")
        spec = importlib.util.find_spec(folder)
        places = [] if spec is None else list(spec.submodule_search_locations or [])
        return any((Path(place) / below).is_dir() for place in places)

    return [name for name in PACKAGES if not is_there(name)]


needs_packages = pytest.mark.skipif(
    bool(missing()), reason=f"SKIPPED: not installed: {', '.join(missing())} (setup/requirements-cocotb.txt, without dependencies)"
)


def run(folder, *command, **environment):
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1", **environment}
    return subprocess.run([sys.executable, "-m", *command], cwd=folder, env=environment, capture_output=True, text=True)


@needs_packages
@pytest.mark.parametrize("version", ["1.9", "2.1"])
def test_packages_run_unchanged(tmp_path, version):
    bench = str(HERE / "aliased" / "loopbacks.py")
    done = run(tmp_path, "hoverlock", "--as-cocotb", "--cocotb-version", version, bench, *JOINED, "--hoverlock-seed", "1")
    assert done.returncode == 0 and "12 passed, 0 failed, 0 skipped" in done.stdout, done.stdout + done.stderr[-3000:]
    assert "a line of INFO" in done.stderr


@needs_packages
def test_packages_run_unchanged_in_pytest(tmp_path):
    bench = (HERE / "aliased" / "loopbacks.py").read_text()
    (tmp_path / "test_loopbacks.py").write_text(bench)
    done = run(tmp_path, "pytest", "-q", "-p", "no:cacheprovider", "-p", "hoverlock.as_cocotb", *JOINED, "-k", "axis or uart")
    assert done.returncode == 0 and "5 passed" in done.stdout, done.stdout + done.stderr


@needs_packages
def test_a_bus_of_internal_signals_is_found(tmp_path):
    (tmp_path / "inner.v").write_text(textwrap.dedent("""
        module inner (input wire [7:0] in, output wire out);
            wire [7:0] status_length = in + 1;
            wire status_VALID = in[0];
            assign out = status_VALID;
        endmodule
    """))
    (tmp_path / "bench.py").write_text(textwrap.dedent("""
        import cocotb
        from cocotb.triggers import Timer
        from cocotb_bus.bus import Bus

        @cocotb.test()
        async def looks_inside(dut):
            bus = Bus(dut, "status", ["valid"], ["length", "error"])
            dut._id("in", extended=False).value = 5
            await Timer(1, "ns")
            assert bus.valid.value == 1 and bus.length.value == 6 and not hasattr(bus, "error")

        @cocotb.test()
        async def looks_at_ports(dut):
            assert not hasattr(dut, "error") and {"in", "out"} <= set(dir(dut))
    """))
    options = ("--hoverlock-source", "inner.v", "--hoverlock-top", "inner")
    done = run(tmp_path, "hoverlock", "--as-cocotb", "bench.py", *options)
    assert done.returncode == 0 and "2 passed" in done.stdout and "all tests run again" in done.stderr, done.stdout + done.stderr
    done = run(tmp_path, "hoverlock", "--as-cocotb", "bench.py", *options, "--test", "looks_at_ports")
    assert "1 passed" in done.stdout and "run again" not in done.stderr, done.stdout + done.stderr


def test_without_the_alias_cocotb_is_what_is_installed(tmp_path):
    (tmp_path / "cocotb.py").write_text("__version__ = 'the real one'\n")
    said = "import hoverlock, cocotb; print(cocotb.__version__, cocotb.__file__ == %r)" % str(tmp_path / "cocotb.py")
    done = subprocess.run([sys.executable, "-c", said], cwd=tmp_path, capture_output=True, text=True)
    assert done.stdout == "the real one True\n", done.stderr
    late = "import cocotb, hoverlock; hoverlock.as_cocotb()"
    done = subprocess.run([sys.executable, "-c", late], cwd=tmp_path, capture_output=True, text=True)
    assert "cocotb was imported before hoverlock.as_cocotb(): call it first" in done.stderr


def test_the_alias_gives_one_module_by_two_names():
    said = textwrap.dedent("""
        import hoverlock
        hoverlock.as_cocotb("1.9")
        import cocotb, cocotb.triggers, cocotb_tools.runner
        from cocotb.handle import SimHandleBase, ValueObjectBase
        import hoverlock.cocotb.triggers as own
        assert cocotb is hoverlock.cocotb and cocotb.triggers is own and cocotb.triggers.RisingEdge is hoverlock.RisingEdge
        assert own.__spec__.name == "hoverlock.cocotb.triggers" and cocotb.__version__ == "1.9.2"
        assert cocotb.top is None and cocotb.SIM_NAME is None and not cocotb.simulator.is_running()
        def typed(handle: ValueObjectBase[int, int], other: SimHandleBase) -> None: ...
        try:
            import cocotb.nothing
        except ModuleNotFoundError as error:
            print(error)
    """)
    done = subprocess.run([sys.executable, "-W", "error", "-c", said], capture_output=True, text=True)
    assert done.returncode == 0 and "No module named 'cocotb.nothing' in hoverlock" in done.stdout, done.stderr
    for wrong in ("hoverlock.as_cocotb('3')", "__import__('os').environ.update(COCOTB_RESOLVE_X='Q'); hoverlock.as_cocotb()"):
        done = subprocess.run([sys.executable, "-c", f"import hoverlock; {wrong}"], capture_output=True, text=True)
        assert "ValueError: " in done.stderr


def test_a_bench_of_cocotb_2_runs_unchanged(tmp_path):
    done = run(tmp_path, "hoverlock", "--as-cocotb", str(HERE / "aliased" / "version_2.py"), *DFF, "--hoverlock-seed", "1")
    assert done.returncode == 0 and " 0 failed, 0 skipped" in done.stdout, done.stdout + done.stderr[-3000:]


@pytest.mark.parametrize("version", ["1.9", "2.1"])
def test_values_of_arrays_have_the_indices_of_the_version(tmp_path, version):
    (tmp_path / "rows.sv").write_text(textwrap.dedent("""
        module rows (input wire [7:0] down [2:0], input wire [7:0] up [4:6], input wire [7:0] both [1:0][5:7], input real gains [2:1]);
        endmodule
    """))
    (tmp_path / "bench.py").write_text(textwrap.dedent("""
        import cocotb
        from cocotb.triggers import Timer
        from cocotb.types import Array, Range

        @cocotb.test()
        async def reads(dut):
            dut.down.value, dut.up.value, dut.gains.value = [10, 20, 30], [1, 2, 3], [0.5, 0.25]
            dut.both.value = [[1, 2, 3], [4, 5, 6]]
            await Timer(1, "ns")
            down, up, both, gains = dut.down.value, dut.up.value, dut.both.value, dut.gains.value
            assert down == [10, 20, 30] and list(up) == [1, 2, 3] and both == [[1, 2, 3], [4, 5, 6]] and gains == [0.5, 0.25]
            if cocotb.__version__ == "1.9.2":
                assert type(down) is type(both[0]) is list and (down[0], up[0], both[0][2], gains[0]) == (10, 1, 3, 0.5)
                return
            assert isinstance(both, Array) and isinstance(both[1], Array) and both.range == Range(1, 0) and both[0].range == Range(5, 7)
            assert (down[2], down[0], up[4], up[6], both[1][7], both[0][5], gains[2]) == (10, 30, 1, 3, 3, 4, 0.5)
            assert down[2:1] == [10, 20] and all(down[at] == dut.down[at].value for at in range(3))
            dut.down.value, dut.both.value = Array([7, 8, 9], Range(0, 2)), both
            await Timer(1, "ns")
            assert dut.down.value == [7, 8, 9] and dut.both.value == both
    """))
    options = ("--cocotb-version", version, "--hoverlock-source", "rows.sv", "--hoverlock-top", "rows")
    done = run(tmp_path, "hoverlock", "--as-cocotb", "bench.py", *options)
    assert done.returncode == 0 and "1 passed" in done.stdout, done.stdout + done.stderr


def run_on_dff(folder, *body, **environment):
    """Runs one test with these lines under the alias, and returns the finished process."""
    lines = "".join(f"    {line}\n" for line in body)
    imports = "import logging\nimport cocotb\nfrom cocotb.triggers import Timer\nfrom cocotb.types import LogicArray\n"
    (folder / "bench.py").write_text(f"{imports}@cocotb.test()\nasync def bench(dut):\n{lines}")
    return run(folder, "hoverlock", "--as-cocotb", "bench.py", *DFF, **environment)


def test_weak_digits_may_be_resolved_alone(tmp_path):
    body = []
    for digit, bit in (("L", 0), ("H", 1), ("h", 1)):
        body += [f"dut.d.value = '{digit}'", "await Timer(1, 'ns')", f"assert dut.d.value == {bit}"]
    for digit in "XZUW-":
        body += ["try:", f"    dut.d.value = '{digit}'", "except ValueError as error:", "    assert 'not a value' in str(error)"]
        body += ["else:", "    assert False"]
    done = run_on_dff(tmp_path, *body, COCOTB_RESOLVE_X="weak")
    assert done.returncode == 0 and "1 passed" in done.stdout, done.stdout + done.stderr
    assert "'d' was given 'L'" in done.stderr
    done = run_on_dff(tmp_path, "dut.d.value = 'X'", "await Timer(1, 'ns')", "assert dut.d.value == 0", COCOTB_RESOLVE_X="")
    assert done.returncode == 0 and "1 passed" in done.stdout, done.stdout + done.stderr


@pytest.mark.parametrize("level", ["TRACE", "debug", "", "ERROR"])
def test_the_level_of_the_log_is_that_of_the_environment(tmp_path, level):
    body = ("log = logging.getLogger('cocotb.bench')", "log.log(5, 'of a trace')", "log.debug('fine')", "log.info('coarse')")
    done = run_on_dff(tmp_path, *body, "assert logging.TRACE == 5", COCOTB_LOG_LEVEL=level)
    assert done.returncode == 0 and "1 passed" in done.stdout, done.stdout + done.stderr
    expected = {"of a trace": level == "TRACE", "fine": level in ("TRACE", "debug"), "coarse": level != "ERROR"}
    assert {text: text in done.stderr for text in expected} == expected
    assert ("TRACE    cocotb.bench" in done.stderr) == (level == "TRACE")


def test_a_bench_of_cocotb_test_may_name_its_simulator(tmp_path):
    (tmp_path / "wide.v").write_text("module wide #(parameter W = 1) (input wire [W-1:0] in); endmodule\n")
    (tmp_path / "test_wide.py").write_text(textwrap.dedent("""
        import cocotb, pytest
        from cocotb_test import simulator

        @cocotb.test()
        async def has_nine_bits(dut):
            assert len(dut._id("in", extended=False)) == 9

        @pytest.mark.parametrize("named", [("verilator", "-GW=9"), ("icarus", "-Pwide.W=9"), (None, "-Pwide.W=9"), (simulator.Verilator, "-GW=9")])
        def test_wide(named):
            name, flag = named
            simulator.run(simulator=name, verilog_sources=["wide.v"], toplevel="wide", module="test_wide", extra_args=[flag])
    """))
    environment = {name: value for name, value in os.environ.items() if name != "SIM"}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "hoverlock.as_cocotb"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0 and "4 passed" in done.stdout, done.stdout + done.stderr
    # The environment overrides a name, not a class.
    done = subprocess.run(command, cwd=tmp_path, env={**environment, "SIM": "icarus"}, capture_output=True, text=True)
    assert "1 failed, 3 passed" in done.stdout and "test_wide[named0]" in done.stdout, done.stdout + done.stderr


def test_a_runner_in_the_bench_runs_unchanged(tmp_path):
    (tmp_path / "test_runs.py").write_text(textwrap.dedent(f"""
        import cocotb
        from cocotb.triggers import Timer
        from cocotb_tools.check_results import get_results
        from cocotb_tools.runner import get_runner

        # Only where there is a design to look at.
        WIDTH = len(cocotb.top.d) if cocotb.SIM_NAME else None

        @cocotb.test()
        async def looks(dut):
            await Timer(1, "ns")
            assert WIDTH == 1

        def test_dff():
            runner = get_runner("verilator")
            runner.build(sources=[{str(HERE / "designs" / "dff.v")!r}], hdl_toplevel="dff")
            assert get_results(runner.test(hdl_toplevel="dff", test_module="test_runs")) == (1, 0)
            assert WIDTH is None
    """))
    done = run(tmp_path, "pytest", "-q", "-p", "no:cacheprovider", "-p", "hoverlock.as_cocotb", "test_runs.py")
    assert done.returncode == 0 and "1 passed" in done.stdout, done.stdout + done.stderr


def test_versions_of_verilator_are_compared():
    script = textwrap.dedent("""
        import hoverlock
        hoverlock.as_cocotb()
        from cocotb_tools.sim_versions import VerilatorVersion as of
        assert of("5.006 2023-01-22 rev (Debian 5.006-3)") == of("Verilator 5.006") < of("5.048 devel") and of("5.10") > of("5.9")
        assert of("5.0") == of("5") != of("5.1") and hash(of("5.0")) == hash(of("5"))
        try:
            of("5") < "5.1"
        except TypeError as error:
            print("refused:", error)
    """)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0 and "refused: '<' not supported" in done.stdout, done.stdout + done.stderr


def test_a_makefile_of_cocotb_needs_one_line(tmp_path):
    (tmp_path / "include").mkdir()
    (tmp_path / "include" / "start.vh").write_text("`define START 8'd7\n")
    (tmp_path / "starts.v").write_text(textwrap.dedent("""
        `include "start.vh"
        module starts #(parameter WIDTH = 8) (input wire [WIDTH-1:0] in, output wire [WIDTH-1:0] out, output reg verbose);
            assign out = in + `START;
            initial verbose = $test$plusargs("verbose") != 0;
        endmodule
    """))
    (tmp_path / "bench_starts.py").write_text(textwrap.dedent("""
        import cocotb
        from cocotb.triggers import Timer

        @cocotb.test()
        async def adds(dut):
            dut._id("in").value = 3
            await Timer(1, "ns")
            assert dut.out.value == 10 and len(dut.out) == 12 and dut.verbose.value == 1 and cocotb.plusargs == {"verbose": True}

        @cocotb.test()
        async def is_left_out(dut):
            assert False
    """))
    (tmp_path / "Makefile").write_text(textwrap.dedent(f"""
        TOPLEVEL_LANG = verilog
        VERILOG_SOURCES = $(CURDIR)/starts.v
        TOPLEVEL = starts
        MODULE = bench_starts
        EXTRA_ARGS = -GWIDTH=12 -Iinclude
        PLUSARGS = +verbose
        PYTHON = {sys.executable}
        include $(shell {sys.executable} -m hoverlock --makefile)
    """))
    make = lambda *more: subprocess.run(["make", *more], cwd=tmp_path, capture_output=True, text=True)
    done = make("TESTCASE=adds", "RANDOM_SEED=5", "COCOTB_RESULTS_FILE=r.xml")
    assert done.returncode == 0 and "1 passed, 0 failed, 0 skipped (seed 5)" in done.stdout, done.stdout + done.stderr
    assert 'tests="1"' in (tmp_path / "r.xml").read_text()
    assert make().returncode != 0 and "AssertionError" in make().stdout
    assert "Verilator reads Verilog only" in make("TOPLEVEL_LANG=vhdl").stderr and "MODULE is not set" in make("MODULE=").stderr
