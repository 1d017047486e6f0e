"""The command line: runs tests without pytest.

    python -m hoverlock test_counter.py
    python -m hoverlock test_adder.py --hoverlock-source adder.v --hoverlock-top adder --junit results.xml
    python -m hoverlock stub counter.v --top counter -o counter_dut.pyi
"""

from __future__ import annotations

import argparse
import contextlib
import io
import logging
import os
import re
import sys
import traceback

from . import as_cocotb, stub
from .errors import HoverlockError
from .log import default_config
from .makefile import arguments_of, without_unknown_parameters
from .options import add_design_options, design_from, outputs_from
from .runner import Result, failed_run, run, run_widening, write_junit
from .supervisor import Reporter, supervise


def main(arguments: list[str] | None = None, reporter: Reporter | None = None) -> int:
    """Runs the tests of modules. Exit status: 0 if all passed, 1 if a test failed, 2 on wrong usage. With ``stub`` as the
    first argument, writes a typed stub of a design; with ``--makefile`` alone, prints the path of the file that a Makefile
    written for cocotb includes; with ``make``, runs what such a Makefile describes."""
    arguments = sys.argv[1:] if arguments is None else arguments
    reporter = reporter or Reporter(None)
    if arguments[:1] == ["make"]:
        try:
            arguments = arguments_of(arguments[1:])
        except HoverlockError as error:
            print(f"hoverlock: {error}", file=sys.stderr)
            return 2
    if arguments[:1] == ["stub"]:
        return stub.main(arguments[1:])
    if arguments == ["--makefile"]:
        print(os.path.join(os.path.dirname(os.path.abspath(__file__)), "hoverlock.mk"))
        return 0
    parser = argparse.ArgumentParser(prog="python -m hoverlock", description=main.__doc__)
    parser.add_argument("modules", nargs="+", metavar="MODULE", help="a Python file or module with tests")
    parser.add_argument("-k", dest="match", default="", metavar="TEXT", help="only tests whose name contains TEXT")
    parser.add_argument("--test", metavar="NAMES", help="only the tests of these names, separated by commas")
    parser.add_argument("--filter", metavar="REGEX", help="only tests in whose MODULE.NAME the regular expression is found")
    parser.add_argument("--junit", metavar="FILE", help="writes the results as JUnit XML")
    parser.add_argument("--build-only", action="store_true", help="builds the design and runs no test")
    parser.add_argument(
        "--ignore-unknown-parameters", action="store_true", help="leaves out flags -GNAME=VALUE for parameters that the top does not have"
    )
    parser.add_argument("-q", "--quiet", action="store_true", help="no log, results only")
    add_design_options(parser.add_argument)
    parser.add_argument("--as-cocotb", action="store_true", help="makes 'import cocotb' import this module's names")
    parser.add_argument("--cocotb-version", choices=tuple(as_cocotb.VERSIONS), default=None, help=as_cocotb.VERSION_HELP)
    chosen = parser.parse_args(arguments)
    if chosen.cocotb_version is not None and not chosen.as_cocotb:
        parser.error("--cocotb-version needs --as-cocotb")
    default_config(logging.WARNING if chosen.quiet else logging.INFO)
    if chosen.as_cocotb:
        as_cocotb.install(chosen.cocotb_version)  # after the log's levels, which COCOTB_LOG_LEVEL overrides
    if chosen.junit:
        chosen.junit = os.path.abspath(chosen.junit)  # a bench may change the folder
        # The results of an earlier run are not those of a run that ends early.
        with contextlib.suppress(FileNotFoundError, IsADirectoryError):
            os.remove(chosen.junit)
        reporter.results_go_to(chosen.junit, chosen.as_cocotb)
    results: list[Result] = []

    def keep(module: str, name: str, result: Result | None) -> None:
        if not module:
            results.clear()
        elif result is not None:
            results.append(result)
        reporter.test(module, name, result)

    status = 0
    failure: BaseException | None = None
    try:
        design = design_from(lambda name: getattr(chosen, name))
        if design is not None and chosen.ignore_unknown_parameters:
            design = without_unknown_parameters(design)
        if chosen.build_only:
            if design is None:
                raise HoverlockError("--build-only needs --hoverlock-source and --hoverlock-top")
            design.compile()
            return 0
        options = {
            "seed": chosen.hoverlock_seed,
            "match": chosen.match,
            "names": chosen.test.split(",") if chosen.test else None,
            "filter": chosen.filter,
            "wall_timeout": chosen.hoverlock_wall_timeout,
            "outputs": outputs_from(lambda name: getattr(chosen, name)),
            "listener": keep,
        }
        if chosen.as_cocotb:
            results, _ = run_widening(chosen.modules, design, keep_going=len(chosen.modules) > 1, **options)
        else:
            results = run(chosen.modules, design, **options)
    except (HoverlockError, ImportError, OSError, re.error) as error:
        print(f"hoverlock: {error}", file=sys.stderr)
        status, failure = 2, error
    except KeyboardInterrupt as error:
        print("hoverlock: interrupted", file=sys.stderr)
        status, failure = 130, error
    except Exception as error:  # of a module that was loaded
        traceback.print_exception(error)
        status, failure = 1, error
    if failure is not None:
        results.append(failed_run(failure))
    if chosen.junit and results:
        try:
            write_junit(results, chosen.junit, errors_are_failures=chosen.as_cocotb)
        except OSError as error:
            sys.exit(f"hoverlock: the results cannot be written: {error}")  # the supervisor writes what it knows, if it can
    if not results:
        print("hoverlock: no tests were found", file=sys.stderr)
        return 2
    return status or int(not all(r.passed or r.skipped is not None for r in results))


if __name__ == "__main__":
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a message may have any character
    # A bench that parses arguments, or calls `pytest.main()`, must not take those of the run for its own.
    given = sys.argv[1:]
    del sys.argv[1:]
    sys.exit(supervise(lambda reporter: main(given, reporter)))
