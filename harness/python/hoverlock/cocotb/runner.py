"""``cocotb.runner`` and ``cocotb_tools.runner``: the runners. All of them run benches on Verilator.

>>> runner = get_runner("verilator")
>>> runner.build(sources=["adder.sv"], hdl_toplevel="adder")
>>> runner.test(hdl_toplevel="adder", test_module="test_adder")
"""

from __future__ import annotations

import logging
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..design import Design
from ..errors import HoverlockError
from ..makefile import icarus_flags, verilator_flags
from ..process import failures_in, run_command

log = logging.getLogger("hoverlock.runner")

__all__ = [
    "VHDL", "ActiveHDL", "Dsim", "Ghdl", "Icarus", "Ius", "Nvc", "Questa", "QuestaQIS", "Riviera", "Runner", "Simulator", "Vcs",
    "Verilator", "VerilatorControlFile", "Verilog", "Xcelium", "check_results_file", "get_abs_path", "get_results", "get_runner",
]  # fmt: skip


class Runner:
    """A runner that builds a design and runs its tests, each call in a process of its own. Models are in the cache; the
    build folder has the results."""

    def __init__(self) -> None:
        self.design: Design | None = None
        self.build_dir = Path("sim_build")
        self.env: dict[str, str] = {}
        self.log = log

    def build(
        self,
        hdl_library: str = "top",
        verilog_sources: Sequence[str | Path] = (),
        vhdl_sources: Sequence[str | Path] = (),
        sources: Sequence[str | Path] = (),
        includes: Sequence[str | Path] = (),
        defines: Mapping[str, object] | None = None,
        parameters: Mapping[str, object] | None = None,
        build_args: Sequence[str] = (),
        hdl_toplevel: str | None = None,
        *,
        build_dir: str | Path = "sim_build",
        waves: bool = False,
        timescale: tuple[str, str] | str | None = None,
        internals: Sequence[str] = (),
        forceable: Sequence[str] = (),
        **ignored: Any,
    ) -> None:
        """Builds the model. cocotb's other arguments (``always``, ``clean``, ``log_file`` ...) are ignored, and those of
        ``build_args`` that Verilator has no equivalent of.

        ``internals`` names the internal signals to make accessible. If it is not given, and a bench uses an internal
        signal, all tests run again on a slower model with all internal signals. ``forceable``, of the signals that `Force`
        may override, likewise.
        """
        if vhdl_sources or any(_is_vhdl(source) for source in sources):
            raise HoverlockError("vhdl_sources: Verilator reads Verilog only")
        given = [str(argument) for argument in build_args]
        self.build_dir = get_abs_path(build_dir)
        self.waves = waves
        self.design = Design(
            [*sources, *verilog_sources],
            top=_top_of(hdl_toplevel, [*sources, *verilog_sources]),
            parameters=_parameters(parameters),
            defines=defines or {},
            includes=includes,
            flags=verilator_flags(given) if isinstance(self, Verilator) else icarus_flags(given),
            internals=internals,
            forceable=forceable,
            timescale="/".join(timescale) if isinstance(timescale, tuple) else timescale,
            folder=Path.cwd(),
        )
        self.design.compile()

    def test(
        self,
        test_module: str | Sequence[str],
        hdl_toplevel: str | None = None,
        *,
        seed: int | str | None = None,
        testcase: str | Sequence[str] | None = None,
        test_filter: str | None = None,
        parameters: Mapping[str, object] | None = None,
        plusargs: Sequence[str] = (),
        test_args: Sequence[str] = (),
        results_xml: str | None = None,
        extra_env: Mapping[str, str] | None = None,
        build_dir: str | Path | None = None,
        test_dir: str | Path | None = None,
        waves: bool | None = None,
        timescale: tuple[str, str] | str | None = None,
        **ignored: Any,
    ) -> Path:
        """Runs the tests of modules and returns the path of the results.

        Raises
        ------
        SystemExit
            If the run ended without results; in a test of pytest also if a test failed.
        """
        __tracebackhide__ = True
        if self.design is None:
            raise HoverlockError("build comes before test")
        design = self.design
        if hdl_toplevel is not None and hdl_toplevel != design.top:
            design = design.changed(top=hdl_toplevel)
        if parameters is not None:
            design = design.changed(parameters={**design.parameters, **_parameters(parameters)})
        if timescale is not None:
            design = design.changed(timescale="/".join(timescale) if isinstance(timescale, tuple) else timescale)
        self.build_dir = self.build_dir if build_dir is None else get_abs_path(build_dir)
        folder = self.build_dir if test_dir is None else get_abs_path(test_dir)
        folder.mkdir(parents=True, exist_ok=True)
        self.env = dict(extra_env or {})
        of_pytest = os.environ.get("PYTEST_CURRENT_TEST", "").rpartition(":")[2].split(" ")[0].replace("/", "_")
        results = folder / (results_xml or (f"{of_pytest}.result.xml" if of_pytest else "results.xml"))
        results.unlink(missing_ok=True)
        arguments = ["--as-cocotb", "--junit", str(results), *_arguments_of(design)]
        arguments += [f"--hoverlock-plusarg={word}" for word in [*plusargs, *test_args] if str(word).startswith("+")]
        # The variables with which a user repeats a run count before the arguments of the bench.
        chosen = _chosen(self.env, "COCOTB_RANDOM_SEED", "RANDOM_SEED") or seed
        if chosen is not None:
            arguments += ["--hoverlock-seed", str(chosen)]
        names = ",".join(testcase) if testcase is not None and not isinstance(testcase, str) else testcase
        names = names or _chosen(self.env, "COCOTB_TESTCASE", "TESTCASE")
        if names:
            arguments += ["--test", names]
        matching = test_filter or _chosen(self.env, "COCOTB_TEST_FILTER")
        if matching:
            arguments += ["--filter", matching]
        if self.waves if waves is None else waves:
            arguments += ["--hoverlock-waves", "vcd"]
        modules = [test_module] if isinstance(test_module, str) else test_module
        arguments += [name.strip() for text in modules for name in text.split(",") if name.strip()]
        environment = {**self.env, "COCOTB_RESULTS_FILE": str(results), "TOPLEVEL_LANG": "verilog"}
        status = run_command(arguments, folder=folder, environment=environment)
        if not results.is_file():
            raise SystemExit(f"the run ended with status {status} and without results")
        failed = failures_in(results)
        if failed:
            log.error("failed: %s", ", ".join(failed))
        if (failed and of_pytest) or (status and not failed):
            raise SystemExit(f"failed: {', '.join(failed)}" if failed else f"the run ended with status {status}")
        return results


class Verilator(Runner):
    """cocotb's class of this name."""


# The classes for other simulators. They run on Verilator too, with the arguments that it has equivalents of.
class Icarus(Runner):
    """cocotb's class of this name."""


ActiveHDL = Dsim = Ghdl = Ius = Nvc = Questa = QuestaQIS = Riviera = Vcs = Xcelium = Icarus
Simulator = Runner
_OTHERS = (
    "icarus", "questa", "ghdl", "riviera", "activehdl", "vcs", "xcelium", "nvc", "dsim", "modelsim", "ius", "qrun", "cvc",
)  # fmt: skip


def get_runner(simulator_name: str = "verilator") -> Runner:
    """Returns a runner. All runners use Verilator; those for other simulators translate the ``build_args``.

    >>> runner = get_runner(os.getenv("SIM", "icarus"))
    """
    if simulator_name not in ("verilator", *_OTHERS):
        raise ValueError(f"no simulator '{simulator_name}': hoverlock runs on verilator")
    if simulator_name != "verilator":
        log.warning("runs on Verilator instead of %s; of the build_args those that it has equivalents of count", simulator_name)
    return Verilator() if simulator_name == "verilator" else Icarus()


class _Tagged(str):
    """A path or an argument for one language."""

    def __new__(cls, value: str | Path) -> _Tagged:
        return super().__new__(cls, os.fspath(value))

    @property
    def value(self) -> str:
        """The path or the argument."""
        return str(self)


class VHDL(_Tagged):
    """A source or argument for VHDL, which is refused."""


class Verilog(_Tagged):
    """A source or argument for Verilog."""


class VerilatorControlFile(_Tagged):
    """A configuration file of Verilator."""


def _is_vhdl(source: str | Path) -> bool:
    return isinstance(source, VHDL) or (not isinstance(source, _Tagged) and Path(source).suffix in (".vhd", ".vhdl"))


def _top_of(top: str | None, sources: Sequence[str | Path]) -> str:
    """Returns the top module: cocotb lets a simulator find it if there is none; here it is named like the last source."""
    if top is None and not sources:
        raise HoverlockError("build needs sources")
    return top.rpartition(".")[2] if top is not None else Path(sources[-1]).stem


def _parameters(given: Mapping[str, object] | None) -> dict[str, int | str]:
    """Returns parameters as numbers and as Verilog's text."""
    known = (given or {}).items()
    return {name: value if isinstance(value, (int, str)) else str(value) for name, value in known}


def _arguments_of(design: Design) -> list[str]:
    """Returns the options of the command line that describe a design; all paths are absolute."""
    folder = design.folder or "."
    words = ["--hoverlock-top", design.top]
    for source in design.sources:
        words += ["--hoverlock-source", os.path.join(folder, source)]
    words += [f"--hoverlock-flag={flag}" for flag in design.flags]
    words += [f"--hoverlock-flag=-I{os.path.join(folder, include)}" for include in design.includes]
    words += [f"--hoverlock-flag=-D{name}" + ("" if value is None else f"={value}") for name, value in design.defines.items()]
    words += [f"--hoverlock-parameter={name}={int(value) if isinstance(value, bool) else value}" for name, value in design.parameters.items()]
    words += [f"--hoverlock-internal={pattern}" for pattern in design.internals]
    words += [f"--hoverlock-forceable={pattern}" for pattern in design.forceable]
    if design.timescale is not None:
        words += ["--hoverlock-flag=--timescale", f"--hoverlock-flag={design.timescale}"]
    if design.coverage:
        words.append("--hoverlock-coverage")
    return words


def _chosen(environment: Mapping[str, str], *names: str) -> str | None:
    """Returns the first of the variables that is set, by the bench or by the user."""
    found = (environment.get(name) or os.environ.get(name) for name in names)
    return next((value for value in found if value), None)


def get_abs_path(path: str | Path) -> Path:
    """Returns a path in absolute form.

    >>> get_abs_path("sim_build")
    """
    return Path(path).resolve()


def get_results(results_xml: str | Path) -> tuple[int, int]:
    """Returns the numbers of tests and of failures in a results file.

    Raises
    ------
    RuntimeError
        If there is no such file.

    >>> assert get_results(path) == (3, 0)
    """
    from xml.etree import ElementTree

    if not Path(results_xml).is_file():
        raise RuntimeError(f"the run ended without results: {results_xml} does not exist")
    suites = list(ElementTree.parse(results_xml).getroot().iter("testsuite"))
    tests, failures, errors = (sum(int(suite.get(n, 0)) for suite in suites) for n in ("tests", "failures", "errors"))
    return tests, failures + errors


def check_results_file(results_xml: str | Path) -> None:
    """Raises `SystemExit` if a test failed; cocotb 1's name.

    >>> check_results_file(path)
    """
    tests, failures = get_results(results_xml)
    if failures:
        raise SystemExit(f"failed {failures} of {tests} tests")
