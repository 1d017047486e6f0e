"""The command line for those without pytest.

    python -m hoverlock test_counter.py
    python -m hoverlock test_adder.py --hoverlock-source adder.v --hoverlock-top adder -P WIDTH=8 --junit results.xml
"""

from __future__ import annotations

import argparse
import logging
import sys

from .design import Design
from .errors import HoverlockError
from .log import default_config
from .runner import run, write_junit


def add_design_options(add: object) -> None:
    """The options that name a design; the same for pytest and here."""
    option = add  # argparse and pytest take the same arguments
    option("--hoverlock-source", action="append", default=[], metavar="FILE",  # type: ignore[operator]
           help="Verilog source, for modules that name no design (may be repeated)")
    option("--hoverlock-top", default=None, metavar="MODULE", help="top module")  # type: ignore[operator]
    option("--hoverlock-parameter", action="append", default=[],  # type: ignore[operator]
           metavar="NAME=VALUE", help="parameter of the top module (may be repeated)")
    option("--hoverlock-seed", type=int, default=None, metavar="N",  # type: ignore[operator]
           help="seed of the session; printed when a test fails")
    option("--hoverlock-wall-timeout", type=float, default=None, metavar="SECONDS",  # type: ignore[operator]
           help="gives a test up after so long on the wall (600 s)")


def design_from(sources: list[str], top: str | None, parameters: list[str]) -> Design | None:
    """The design the options name, or none."""
    if not sources and top is None:
        return None
    if not sources or top is None:
        raise HoverlockError("--hoverlock-source and --hoverlock-top are wanted together")
    chosen: dict[str, int | str] = {}
    for text in parameters:
        name, equals, value = text.partition("=")
        if not equals:
            raise HoverlockError(f"--hoverlock-parameter {text}: NAME=VALUE is wanted")
        try:
            chosen[name] = int(value, 0)
        except ValueError:
            chosen[name] = value
    return Design(sources, top=top, parameters=chosen, folder=".")


def main(arguments: list[str] | None = None) -> int:
    """Runs modules' tests; 0 if all passed, 1 if one failed, 2 on bad usage."""
    parser = argparse.ArgumentParser(prog="python -m hoverlock", description=main.__doc__)
    parser.add_argument("modules", nargs="+", metavar="MODULE", help="a Python file or module with tests")
    parser.add_argument("-k", dest="match", default="", metavar="TEXT", help="only tests whose name holds this")
    parser.add_argument("--junit", metavar="FILE", help="writes the results as JUnit XML")
    parser.add_argument("-q", "--quiet", action="store_true", help="no log, results only")
    add_design_options(parser.add_argument)
    chosen = parser.parse_args(arguments)
    default_config(logging.WARNING if chosen.quiet else logging.INFO)
    try:
        design = design_from(chosen.hoverlock_source, chosen.hoverlock_top, chosen.hoverlock_parameter)
        results = run(
            chosen.modules,
            design,
            seed=chosen.hoverlock_seed,
            match=chosen.match,
            wall_timeout=chosen.hoverlock_wall_timeout,
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
