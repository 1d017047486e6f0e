"""The options that pytest and the command line share, and the design and outputs that they name."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from .design import Design
from .errors import HoverlockError
from .outputs import Outputs


def add_design_options(add: object) -> None:
    """Adds the options that pytest and this command line share."""
    option = add  # the functions of argparse and pytest have the same arguments
    option("--hoverlock-source", action="append", default=[], metavar="FILE",  # type: ignore[operator]
           help="Verilog source, for test modules that name no design (may be repeated)")
    option("--hoverlock-top", default=None, metavar="MODULE", help="top module")  # type: ignore[operator]
    option("--hoverlock-parameter", action="append", default=[],  # type: ignore[operator]
           metavar="NAME=VALUE", help="parameter of the top module (may be repeated)")
    option("--hoverlock-seed", type=int, default=None, metavar="N",  # type: ignore[operator]
           help="seed of the session; printed when a test fails")
    option("--hoverlock-wall-timeout", type=float, default=None, metavar="SECONDS",  # type: ignore[operator]
           help="wall-clock limit of each test (default: 600 s)")
    option("--hoverlock-internal", action="append", default=[],  # type: ignore[operator]
           metavar="PATTERN", help="internal signals to make accessible, such as 'u_core.*' (may be repeated)")
    option("--hoverlock-forceable", action="append", default=[],  # type: ignore[operator]
           metavar="PATTERN", help="internal signals that Force may override (may be repeated)")
    option("--hoverlock-flag", action="append", default=[],  # type: ignore[operator]
           metavar="FLAG", help="a further argument of Verilator, such as --hoverlock-flag=-DFAST (may be repeated)")
    option("--hoverlock-plusarg", action="append", default=[],  # type: ignore[operator]
           metavar="ARG", help="an argument that the Verilog's $test$plusargs sees, such as +verbose (may be repeated)")
    option("--hoverlock-waves", choices=("vcd", "fst"), default=None,  # type: ignore[operator]
           help="records all signals of every test")
    option("--hoverlock-waves-on-failure", action="store_true",  # type: ignore[operator]
           help="keeps only the waves of failing tests (as VCD, unless --hoverlock-waves is given)")
    option("--hoverlock-waves-last", type=int, default=None, metavar="N",  # type: ignore[operator]
           help="writes the last N time steps of failing tests as VCD; a clock cycle has two time steps")
    option("--hoverlock-coverage", action="store_true",  # type: ignore[operator]
           help="counts coverage of the Verilog over all tests and writes coverage.info (LCOV)")
    option("--hoverlock-output", default="hoverlock-output", metavar="FOLDER",  # type: ignore[operator]
           help="folder of waves and coverage (default: hoverlock-output)")


def outputs_from(option: Callable[[str], Any]) -> Outputs:
    """Returns the waves and coverage that the options select."""
    last = option("hoverlock_waves_last")
    if last is not None and last < 1:
        raise HoverlockError(f"--hoverlock-waves-last {last}: at least 1 is needed")
    only = option("hoverlock_waves_on_failure")
    waves = option("hoverlock_waves") or ("vcd" if only else None)
    return Outputs(option("hoverlock_output"), waves, only, last, option("hoverlock_coverage"))


def design_from(option: Callable[[str], Any]) -> Design | None:
    """Returns the design that the options name, or None."""
    sources, top = option("hoverlock_source"), option("hoverlock_top")
    if not sources and top is None:
        return None
    if not sources or top is None:
        raise HoverlockError("--hoverlock-source and --hoverlock-top are needed together")
    chosen: dict[str, int | str] = {}
    for text in option("hoverlock_parameter"):
        name, equals, value = text.partition("=")
        if not equals:
            raise HoverlockError(f"--hoverlock-parameter {text}: write NAME=VALUE")
        try:
            chosen[name] = int(value, 0)
        except ValueError:
            chosen[name] = value
    return Design(
        sources,
        top=top,
        parameters=chosen,
        internals=option("hoverlock_internal"),
        forceable=option("hoverlock_forceable"),
        flags=[_from_here(flag) for flag in option("hoverlock_flag")],
        plusargs=option("hoverlock_plusarg"),
        folder=".",
    )


def _from_here(flag: str) -> str:
    """Returns a flag of Verilator with an include folder as an absolute path, because Verilator runs in another folder."""
    for head in ("-I", "+incdir+", "-y"):
        if flag.startswith(head) and len(flag) > len(head):
            return head + os.path.abspath(flag[len(head) :])
    return flag
