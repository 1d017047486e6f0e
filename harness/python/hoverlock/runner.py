"""Runs the tests of modules without pytest.

>>> results = run("test_counter.py", Design("counter.v", top="counter"), seed=1)
>>> assert all(r.passed for r in results)
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import shlex
import sys
import time
import traceback
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from .design import Design
from .errors import HoverlockError
from .outputs import Outputs
from .session import set_loading
from .testing import Test, is_failed_check, seed_of

__all__ = ["Result", "collect", "design_of", "new_seed", "replay_text", "run", "say", "write_junit"]


@dataclass
class Result:
    """The result of a test.

    >>> slowest = max(results, key=lambda result: result.seconds)
    """

    name: str
    module: str
    seed: int
    seconds: float
    passed: bool  # and not skipped
    skipped: str | None = None
    error: BaseException | None = None
    text: str = ""


def new_seed() -> int:
    """Returns a random seed for a session.

    >>> seed = new_seed()
    """
    return int.from_bytes(os.urandom(4), "little")


def replay_text(session_seed: int, command: str) -> str:
    """Returns the text that says how to run a test again with the same random numbers.

    >>> print(replay_text(7, "pytest test_counter.py::counts"))
    random seed 7: replay with --hoverlock-seed 7
    pytest test_counter.py::counts --hoverlock-seed 7
    """
    option = f"--hoverlock-seed {session_seed}"
    return f"random seed {session_seed}: replay with {option}\n{command} {option}"


def load(module: str | Path, *, fresh: bool = False) -> ModuleType:
    """Imports a module, by file or by name; with ``fresh``, loads it again if it is loaded."""
    path = Path(module)
    if path.suffix == ".py":
        if not path.is_file():
            raise HoverlockError(f"{path}: no such file")
        folder = str(path.resolve().parent)
        if folder not in sys.path:
            sys.path.insert(0, folder)
        spec = importlib.util.spec_from_file_location(path.stem, path)
        if spec is None or spec.loader is None:
            raise HoverlockError(f"{path}: not a Python file")
        loaded = importlib.util.module_from_spec(spec)
        sys.modules[path.stem] = loaded
        with _exit_is_an_error(module):
            spec.loader.exec_module(loaded)
        return loaded
    name = str(module)
    with _exit_is_an_error(module):
        if not fresh or name not in sys.modules:
            return importlib.import_module(name)
        before = sys.modules.pop(name)
        try:
            return importlib.import_module(name)
        finally:
            sys.modules[name] = before


@contextmanager
def _exit_is_an_error(module: str | Path) -> Iterator[None]:
    """Converts `sys.exit` into an error. Otherwise the run would end, perhaps with status 0, before any test had run."""
    try:
        yield
    except SystemExit as error:
        raise HoverlockError(f"{module}: called sys.exit({error.code!r}) while it was loaded: no test was run") from error


def collect(module: ModuleType) -> list[Test]:
    """Returns the tests of a module in the order of the file, one for each combination of parameters.

    >>> [test.name for test in collect(test_counter)]
    """
    found = [value for value in vars(module).values() if isinstance(value, Test)]
    found = [t for t in found if t.module == module.__name__]
    return [variant for t in found for variant in t.variants()]


def design_of(test: Test, module: ModuleType, given: Design | None) -> Design:
    """Returns the design of a test: its own, that of its module, or ``given``.

    Raises
    ------
    HoverlockError
        If there is none.

    >>> library = design_of(test, module, None).compile()
    """
    design = test.design or getattr(module, "design", None) or given
    if not isinstance(design, Design):
        raise HoverlockError(
            f"{test.name}: no design. Write design = hoverlock.Design('file.v', top='module') in {module.__name__}, "
            "pass design= to the test, or name --hoverlock-source and --hoverlock-top"
        )
    return design


def run(
    modules: str | Path | Iterable[str | Path],
    design: Design | None = None,
    *,
    seed: int | None = None,
    match: str = "",
    names: Iterable[str] | None = None,
    wall_timeout: float | None = None,
    quiet: bool = False,
    outputs: Outputs | None = None,
    fresh: bool = False,
) -> list[Result]:
    """Runs the tests of modules.

    Parameters
    ----------
    modules : path, name or iterable of them
        The modules.
    design : Design, optional
        For tests and modules that name none.
    seed : int, optional
        Seed of the session. Default: a random one.
    match : str
        Runs only tests whose name contains this.
    names : iterable of str, optional
        Runs only these tests.
    wall_timeout : float, optional
        Wall-clock limit of each test, in seconds. Default: the test's own.
    quiet : bool
        Prints nothing.
    outputs : Outputs, optional
        The waves and coverage to write.
    fresh : bool
        Loads modules again that are loaded already, because their top-level code may depend on the design.

    Returns
    -------
    list of Result

    Raises
    ------
    HoverlockError
        If a module does not exist.

    >>> results = run("test_counter.py", seed=1, match="counts")
    """
    session_seed = new_seed() if seed is None else seed
    outputs = outputs or Outputs()
    outputs.begin()
    results = []
    wanted = None if names is None else set(names)
    for name in [modules] if isinstance(modules, (str, Path)) else modules:
        try:
            set_loading(design)
            module = load(name, fresh=fresh)
        except BaseException as error:
            reason = _skipped(error)
            if reason is None:
                raise
            stem = Path(name).stem
            results.append(Result(stem, stem, session_seed, 0.0, False, skipped=reason))
            if not quiet:
                _say(results[-1], session_seed, name)
            continue
        finally:
            set_loading(None)
        for test in collect(module):
            if match in test.name and (wanted is None or test.name in wanted):
                results.append(_run_one(test, module, design, session_seed, wall_timeout, outputs))
                if not quiet:
                    _say(results[-1], session_seed, name)
    if not quiet:
        _sum_up(results, session_seed)
    if outputs.coverage:
        summary = outputs.merge_coverage()
        if not quiet:
            print(summary)
    return results


def _run_one(
    test: Test, module: ModuleType, design: Design | None, session_seed: int, wall_timeout: float | None, outputs: Outputs
) -> Result:
    seed = seed_of(session_seed, test.name)
    if test.skip:
        reason = test.skip if isinstance(test.skip, str) else "skipped"
        return Result(test.name, module.__name__, seed, 0.0, False, skipped=reason)
    started = time.monotonic()
    error: BaseException | None = None
    text = ""
    skipped = None
    try:
        test.run(design_of(test, module, design), seed=seed, wall_timeout=wall_timeout, outputs=outputs)
    except KeyboardInterrupt:
        raise
    # Any other exception ends the bench and not the run: `sys.exit(0)` must not hide the tests after it.
    except BaseException as raised:
        skipped = _skipped(raised)
        error = raised if skipped is None else None
        if isinstance(raised, SystemExit):
            error = HoverlockError(f"the bench called sys.exit({raised.code!r})")
            error.__cause__ = raised
        text = "" if error is None else "".join(traceback.format_exception(error))
    seconds = time.monotonic() - started
    passed = error is None and skipped is None
    return Result(test.name, module.__name__, seed, seconds, passed, skipped=skipped, error=error, text=text)


def _skipped(error: BaseException) -> str | None:
    """Returns the reason if the error is that of `pytest.skip` or `pytest.xfail`, otherwise None."""
    pytest = sys.modules.get("pytest")
    if pytest is not None and isinstance(error, (pytest.skip.Exception, pytest.xfail.Exception)):
        return str(error.msg) or "skipped"
    return None


def say(results: Iterable[Result], session_seed: int) -> None:
    """Prints the results of a quiet run.

    >>> say(run("test_counter.py", seed=1, quiet=True), 1)
    """
    results = list(results)
    for result in results:
        _say(result, session_seed, result.module)
    _sum_up(results, session_seed)


def _sum_up(results: list[Result], session_seed: int) -> None:
    failed = sum(not r.passed and r.skipped is None for r in results)
    skipped = sum(r.skipped is not None for r in results)
    print(f"{len(results) - failed - skipped} passed, {failed} failed, {skipped} skipped (seed {session_seed})")


def _say(result: Result, session_seed: int, module: str | Path) -> None:
    word = "SKIP" if result.skipped is not None else "PASS" if result.passed else "FAIL"
    print(f"{word} {result.module}.{result.name} ({result.seconds:.2f} s)", flush=True)
    if word == "FAIL":
        print(result.text.rstrip())
        command = shlex.join(["python", "-m", "hoverlock", str(module), "-k", result.name])
        print(replay_text(session_seed, command), flush=True)


def write_junit(results: Iterable[Result], path: str | Path) -> None:
    """Writes the results as JUnit XML.

    >>> write_junit(run("test_counter.py"), "results.xml")
    """
    from xml.etree import ElementTree

    results = list(results)
    suite = ElementTree.Element(
        "testsuite",
        name="hoverlock",
        tests=str(len(results)),
        failures=str(sum(is_failed_check(r.error) for r in results)),
        errors=str(sum(r.error is not None and not is_failed_check(r.error) for r in results)),
        skipped=str(sum(r.skipped is not None for r in results)),
        time=f"{sum(r.seconds for r in results):.3f}",
    )
    for result in results:
        case: Any = ElementTree.SubElement(
            suite, "testcase", classname=result.module, name=result.name, time=f"{result.seconds:.3f}"
        )
        properties = ElementTree.SubElement(case, "properties")
        ElementTree.SubElement(properties, "property", name="random_seed", value=str(result.seed))
        if result.skipped is not None:
            ElementTree.SubElement(case, "skipped", message=result.skipped)
        elif result.error is not None:
            kind = "failure" if is_failed_check(result.error) else "error"
            node = ElementTree.SubElement(case, kind, message=str(result.error), type=type(result.error).__name__)
            node.text = result.text
    suites = ElementTree.Element("testsuites")
    suites.append(suite)
    path = Path(path)
    aside = path.with_name(f".{path.name}.{os.getpid()}")
    ElementTree.ElementTree(suites).write(aside, encoding="utf-8", xml_declaration=True)
    aside.replace(path)
