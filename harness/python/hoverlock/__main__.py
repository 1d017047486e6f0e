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

from . import as_cocotb, stub
from .errors import HoverlockError
from .log import default_config
from .options import add_design_options, design_from, outputs_from
from .runner import run, write_junit


def main(arguments: list[str] | None = None) -> int:
    """Runs the tests of modules. Exit status: 0 if all passed, 1 if a test failed, 2 on wrong usage. With ``stub`` as the
    first argument, writes a typed stub of a design; with ``--makefile`` alone, prints the path of the file that a Makefile
    written for cocotb includes."""
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
    parser.add_argument("--as-cocotb", action="store_true", help="makes 'import cocotb' import this module's names")
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
