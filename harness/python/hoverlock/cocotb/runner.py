"""``cocotb.runner`` and ``cocotb_tools.runner``: the runner, for Verilator.

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
from ..runner import new_seed, run, run_widening, write_junit

log = logging.getLogger("hoverlock.runner")

__all__ = ["Verilator", "get_results", "get_runner"]

_OTHERS = ("icarus", "questa", "ghdl", "riviera", "activehdl", "vcs", "xcelium", "nvc", "dsim", "modelsim", "ius")


class Verilator:
    """A runner that builds a design and runs its tests. The build folder has only the results; models are in the cache."""

    def __init__(self, arguments_are_verilators: bool = True) -> None:
        self.arguments_are_verilators = arguments_are_verilators
        self.design: Design | None = None
        self.internals_are_chosen = False
        self.build_dir = Path("sim_build")

    def build(
        self,
        *,
        sources: Sequence[str | Path] = (),
        verilog_sources: Sequence[str | Path] = (),
        vhdl_sources: Sequence[str | Path] = (),
        hdl_toplevel: str | None = None,
        includes: Sequence[str | Path] = (),
        defines: Mapping[str, object] | None = None,
        parameters: Mapping[str, int | str] | None = None,
        build_args: Sequence[str] = (),
        build_dir: str | Path = "sim_build",
        waves: bool = False,
        timescale: tuple[str, str] | str | None = None,
        internals: Sequence[str] | None = None,
        forceable: Sequence[str] = (),
        **ignored: Any,
    ) -> None:
        """Builds the model. cocotb's other arguments (``always``, ``clean``, ``log_file`` ...) are ignored.

        ``internals`` names the internal signals to make accessible. If it is not given, and a bench uses an internal
        signal, all tests run again on a slower model with all internal signals. ``forceable``, of the signals that `Force`
        may override, likewise.
        """
        if hdl_toplevel is None:
            raise HoverlockError("build needs hdl_toplevel")
        if vhdl_sources:
            raise HoverlockError("vhdl_sources: Verilator reads Verilog only")
        self.build_dir = Path(build_dir)
        self.design = Design(
            [*sources, *verilog_sources],
            top=hdl_toplevel,
            parameters=parameters or {},
            defines=defines or {},
            includes=includes,
            flags=[str(flag) for flag in build_args] if self.arguments_are_verilators else (),
            internals=internals or (),
            forceable=forceable,
            waves="vcd" if waves else None,
            timescale="/".join(timescale) if isinstance(timescale, tuple) else timescale,
            folder=Path.cwd(),
        )
        self.design.compile()
        self.internals_are_chosen = internals is not None

    def test(
        self,
        *,
        test_module: str | Sequence[str],
        hdl_toplevel: str | None = None,
        seed: int | str | None = None,
        testcase: str | Sequence[str] | None = None,
        plusargs: Sequence[str] = (),
        results_xml: str | None = None,
        extra_env: Mapping[str, str] | None = None,
        **ignored: Any,
    ) -> Path:
        """Runs the tests of modules and returns the path of the results; ``SystemExit`` if a test failed."""
        if self.design is None:
            raise HoverlockError("build comes before test")
        before = dict(os.environ)
        os.environ.update(extra_env or {})
        try:
            design = self.design.changed(plusargs=tuple(plusargs))
            names = testcase.split(",") if isinstance(testcase, str) else testcase
            modules = [test_module] if isinstance(test_module, str) else test_module
            modules = [name for text in modules for name in text.split(",") if name.strip()]
            chosen = seed if seed is not None else os.environ.get("RANDOM_SEED")
            session_seed = new_seed() if chosen is None else int(chosen)
            if self.internals_are_chosen:
                results = run(modules, design, seed=session_seed, names=names, fresh=True)
            else:
                results, enough = run_widening(modules, design, seed=session_seed, names=names, fresh=True)
                if enough is not None:
                    self.design = self.design.changed(internals=enough.internals, forceable=enough.forceable)
        finally:
            os.environ.clear()
            os.environ.update(before)
        path = self.build_dir / (results_xml or "results.xml")
        path.parent.mkdir(parents=True, exist_ok=True)
        write_junit(results, path, errors_are_failures=True)
        failed = [r.name for r in results if not r.passed and r.skipped is None]
        if failed or not results:
            raise SystemExit(f"failed: {', '.join(failed)}" if failed else f"no tests in {test_module}")
        return path


def get_runner(simulator_name: str = "verilator") -> Verilator:
    """Returns the runner. It always uses Verilator, and ignores the ``build_args`` if another simulator is named.

    >>> runner = get_runner(os.getenv("SIM", "icarus"))
    """
    if simulator_name not in ("verilator", *_OTHERS):
        raise ValueError(f"no simulator '{simulator_name}': hoverlock runs on verilator")
    if simulator_name != "verilator":
        text = "runs on Verilator instead of %s, whose build_args are left out"
        log.warning(text, simulator_name)
    return Verilator(simulator_name == "verilator")


def get_results(results_xml: str | Path) -> tuple[int, int]:
    """Returns the numbers of tests and of failures in a results file.

    >>> assert get_results(path) == (3, 0)
    """
    from xml.etree import ElementTree

    suites = list(ElementTree.parse(results_xml).getroot().iter("testsuite"))
    tests, failures, errors = (sum(int(suite.get(n, 0)) for suite in suites) for n in ("tests", "failures", "errors"))
    return tests, failures + errors
