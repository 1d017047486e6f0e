"""``cocotb.runner`` and ``cocotb_tools.runner``: the runner, on the one simulator there is.

>>> runner = get_runner("verilator")
>>> runner.build(sources=["adder.sv"], hdl_toplevel="adder")
>>> runner.test(hdl_toplevel="adder", test_module="test_adder")
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..design import Design
from ..errors import HoverlockError
from ..runner import run, write_junit

__all__ = ["Verilator", "get_runner"]


class Verilator:
    """Builds once, tests many times. Build folders are not used: models lie in hoverlock's cache."""

    def __init__(self) -> None:
        self.design: Design | None = None
        self.build_dir = Path("sim_build")

    def build(
        self,
        *,
        sources: Sequence[str | Path] = (),
        verilog_sources: Sequence[str | Path] = (),
        hdl_toplevel: str | None = None,
        includes: Sequence[str | Path] = (),
        defines: Mapping[str, object] | None = None,
        parameters: Mapping[str, int | str] | None = None,
        build_args: Sequence[str] = (),
        build_dir: str | Path = "sim_build",
        waves: bool = False,
        timescale: tuple[str, str] | str | None = None,
        **ignored: Any,
    ) -> None:
        """Builds the model; what cocotb takes beyond this (``always``, ``clean``, ``log_file`` ...) has no meaning here."""
        if hdl_toplevel is None:
            raise HoverlockError("hdl_toplevel is wanted")
        self.build_dir = Path(build_dir)
        self.design = Design(
            [*sources, *verilog_sources],
            top=hdl_toplevel,
            parameters=parameters or {},
            defines=defines or {},
            includes=includes,
            flags=build_args,
            waves="vcd" if waves else None,
            timescale="/".join(timescale) if isinstance(timescale, tuple) else timescale,
            folder=Path.cwd(),
        )
        self.design.compile()

    def test(
        self,
        *,
        test_module: str | Sequence[str],
        hdl_toplevel: str | None = None,
        seed: int | str | None = None,
        testcase: str | None = None,
        plusargs: Sequence[str] = (),
        results_xml: str | None = None,
        extra_env: Mapping[str, str] | None = None,
        **ignored: Any,
    ) -> Path:
        """Runs the tests of a module; gives the path of the results, raises if one failed."""
        if self.design is None:
            raise HoverlockError("build comes before test")
        before = dict(os.environ)
        os.environ.update(extra_env or {})
        try:
            design = self.design.changed(plusargs=tuple(plusargs))
            names = testcase.split(",") if testcase else None
            results = run(test_module, design, seed=None if seed is None else int(seed), names=names)
        finally:
            os.environ.clear()
            os.environ.update(before)
        path = self.build_dir / (results_xml or "results.xml")
        path.parent.mkdir(parents=True, exist_ok=True)
        write_junit(results, path)
        failed = [r.name for r in results if not r.passed and r.skipped is None]
        if failed or not results:
            raise SystemExit(f"failed: {', '.join(failed)}" if failed else f"no tests in {test_module}")
        return path


def get_runner(simulator_name: str = "verilator") -> Verilator:
    """The runner; Verilator is the only simulator."""
    if simulator_name != "verilator":
        raise ValueError(f"hoverlock runs on verilator only, not on {simulator_name}")
    return Verilator()
