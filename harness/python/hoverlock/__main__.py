"""The command line: runs tests without pytest.

    python -m hoverlock test_counter.py
    python -m hoverlock test_adder.py --hoverlock-source adder.v --hoverlock-top adder --junit results.xml
    python -m hoverlock stub counter.v --top counter -o counter_dut.pyi
"""

from __future__ import annotations

import argparse
import logging
import os
import sys
from collections.abc import Callable
from typing import Any

from . import as_cocotb, stub
from .design import Design
from .errors import HoverlockError
from .log import default_config
from .outputs import Outputs
from .runner import run, write_junit


def add_design_options(add: object) -> None:
    """Adds the options that pytest and this command line share."""
    option = add  # argparse and pytest take the same arguments
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
    """The waves and coverage that the options ask for."""
    last = option("hoverlock_waves_last")
    if last is not None and last < 1:
        raise HoverlockError(f"--hoverlock-waves-last {last}: at least 1 is needed")
    only = option("hoverlock_waves_on_failure")
    waves = option("hoverlock_waves") or ("vcd" if only else None)
    return Outputs(option("hoverlock_output"), waves, only, last, option("hoverlock_coverage"))


def design_from(option: Callable[[str], Any]) -> Design | None:
    """The design the options name, or none."""
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
    """A flag of Verilator, which runs elsewhere, with the folder of an include as an absolute path."""
    for head in ("-I", "+incdir+", "-y"):
        if flag.startswith(head) and len(flag) > len(head):
            return head + os.path.abspath(flag[len(head) :])
    return flag


def main(arguments: list[str] | None = None) -> int:
    """Runs the tests of modules. Exit status: 0 if all passed, 1 if a test failed, 2 on wrong usage. With ``stub`` as the
    first argument, writes a typed stub of a design; with ``--makefile`` alone, names the file that a Makefile written for
    cocotb includes."""
    arguments = sys.argv[1:] if arguments is None else arguments
    if arguments[:1] == ["stub"]:
        return stub.main(arguments[1:])
    if arguments == ["--makefile"]:
        print(os.path.join(os.path.dirname(os.path.abspath(__file__)), "hoverlock.mk"))
        return 0
    parser = argparse.ArgumentParser(prog="python -m hoverlock", description=main.__doc__)
    parser.add_argument("modules", nargs="+", metavar="MODULE", help="a Python file or module with tests")
    parser.add_argument("-k", dest="match", default="", metavar="TEXT", help="only tests whose name contains TEXT")
    parser.add_argument("--test", metavar="NAMES", help="only the tests of these names, separated by commas")
    parser.add_argument("--junit", metavar="FILE", help="writes the results as JUnit XML")
    parser.add_argument("-q", "--quiet", action="store_true", help="no log, results only")
    add_design_options(parser.add_argument)
    parser.add_argument("--as-cocotb", action="store_true", help="gives 'import cocotb' this module's names")
    parser.add_argument("--cocotb-version", choices=tuple(as_cocotb.VERSIONS), default=None, help=as_cocotb.VERSION_HELP)
    chosen = parser.parse_args(arguments)
    if chosen.cocotb_version is not None and not chosen.as_cocotb:
        parser.error("--cocotb-version needs --as-cocotb")
    if chosen.as_cocotb:
        as_cocotb.install(chosen.cocotb_version)
    default_config(logging.WARNING if chosen.quiet else logging.INFO)
    try:
        design = design_from(lambda name: getattr(chosen, name))
        results = run(
            chosen.modules,
            design,
            seed=chosen.hoverlock_seed,
            match=chosen.match,
            names=chosen.test.split(",") if chosen.test else None,
            wall_timeout=chosen.hoverlock_wall_timeout,
            outputs=outputs_from(lambda name: getattr(chosen, name)),
        )
        if chosen.junit:
            write_junit(results, chosen.junit)
    except (HoverlockError, ImportError, OSError) as error:
        print(f"hoverlock: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("hoverlock: interrupted", file=sys.stderr)
        return 130
    if not results:
        print("hoverlock: no tests were found", file=sys.stderr)
        return 2
    return 0 if all(r.passed or r.skipped is not None for r in results) else 1


if __name__ == "__main__":
    sys.exit(main())
