"""Runs the tests of modules without pytest.

>>> results = run("test_counter.py", Design("counter.v", top="counter"), seed=1)
>>> assert all(r.passed for r in results)
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import re
import shlex
import sys
import time
import traceback
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from .design import Design
from .errors import HoverlockError, NotForceable
from .log import log
from .outputs import Outputs
from .session import set_loading
from .testing import Test, is_failed_check, seed_of

__all__ = ["Result", "collect", "design_of", "failed_run", "new_seed", "replay_text", "run", "run_widening", "say", "write_junit"]


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
    filter: str | None = None,
    listener: Callable[[str, str, Result | None], None] | None = None,
    until: Callable[[Result], bool] | None = None,
    keep_going: bool = False,
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
        Runs only these tests, also those with ``skip``.
    wall_timeout : float, optional
        Wall-clock limit of each test, in seconds. Default: the test's own.
    quiet : bool
        Prints nothing.
    outputs : Outputs, optional
        The waves and coverage to write.
    fresh : bool
        Loads modules again that are loaded already, because their top-level code may depend on the design.
    filter : str, optional
        Runs only tests for whose ``module.name`` this regular expression matches some part, also those with ``skip``.
    listener : callable, optional
        Called with module, test and None before a test, and with its result after it. While a module is loaded, the test
        is an empty text.
    until : callable, optional
        Ends the run after a result for which it returns true.
    keep_going : bool
        An error while a module is loaded is a failed test of the module's name, and does not keep the others from running.

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
            if listener is not None:
                listener(Path(name).stem, "", None)
            module = load(name, fresh=fresh)
        except BaseException as error:
            reason = _skipped(error)
            if reason is None and not (keep_going and isinstance(error, Exception)):
                raise
            stem = Path(name).stem
            results.append(Result(stem, stem, session_seed, 0.0, False, skipped=reason))
            if reason is None:
                results[-1].error, results[-1].text = error, _traceback(error)
                if until is not None and until(results[-1]):
                    return results
            if listener is not None:
                listener(stem, stem, results[-1])
            if not quiet:
                _say(results[-1], session_seed, name)
            continue
        finally:
            set_loading(None)
        for test in collect(module):
            chosen = match in test.name and (wanted is None or test.name in wanted)
            if chosen and (filter is None or re.search(filter, f"{module.__name__}.{test.name}")):
                if listener is not None:
                    listener(module.__name__, test.name, None)
                if wanted is not None or filter is not None:
                    test = test.changed(skip=False)  # as in cocotb: it is asked for
                results.append(_run_one(test, module, design, session_seed, wall_timeout, outputs))
                if until is not None and until(results[-1]):
                    return results
                if listener is not None:
                    listener(module.__name__, test.name, results[-1])
                if not quiet:
                    _say(results[-1], session_seed, name)
    if not quiet:
        _sum_up(results, session_seed)
    if outputs.coverage:
        summary = outputs.merge_coverage()
        if not quiet:
            print(summary)
    return results


_AGAIN = "a bench %s: all tests run again on a slower model%s; faster is %s=['u_core.state']"
# What a bench may need of the model beyond its ports, and the message.
_MORE = {
    "internals": _AGAIN % ("uses a signal that is not a port", " with all internal signals accessible", "internals"),
    "forceable": _AGAIN % ("forces a signal", " in which all can be forced", "forceable"),
}


def run_widening(modules: str | Path | Iterable[str | Path], design: Design | None, **options: Any) -> tuple[list[Result], Design | None]:
    """Runs the tests of modules as `run` does. If a bench uses an internal signal, or forces a signal, of which the model
    does not allow it, the model is built again with all of them and all tests begin again.

    Returns
    -------
    results : list of Result
    design : Design or None
        The one that was enough.

    >>> results, design = run_widening("test_counter.py", Design("counter.v", top="counter"), seed=1)
    """
    from . import hierarchy

    modules = [modules] if isinstance(modules, (str, Path)) else list(modules)
    listener = options.get("listener")
    while True:
        hierarchy.hidden_asked_for.clear()

        def missing(error: BaseException | None, design: Design | None = design) -> str | None:
            if design is None:
                return None
            if hierarchy.hidden_asked_for and not design.internals:
                return "internals"
            return "forceable" if _caused_by(error, NotForceable) and not design.forceable else None

        results: list[Result] = []
        try:
            results = run(modules, design, until=lambda result: missing(result.error) is not None, **options)
            option = missing(results[-1].error if results else None)
        except AttributeError as error:  # of a module that is loaded
            option = missing(error)
            if option is None:
                raise
        if option is None or design is None:
            return results, design
        log.warning(_MORE[option])
        if listener is not None:
            listener("", "", None)
        design = design.changed(**{option: ("*",)})
        options["fresh"] = True


def _caused_by(error: BaseException | None, kind: type[BaseException]) -> bool:
    """Returns whether an error is of a kind, or an error of a kind led to it."""
    while error is not None:
        if isinstance(error, kind):
            return True
        error = error.__cause__ or error.__context__
    return False


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
    streams = {name: getattr(sys, name) for name in ("stdout", "stderr")}
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
        text = "" if error is None else _traceback(error)
    _restore_streams(streams)
    seconds = time.monotonic() - started
    passed = error is None and skipped is None
    return Result(test.name, module.__name__, seed, seconds, passed, skipped=skipped, error=error, text=text)


def _restore_streams(streams: dict[str, Any]) -> None:
    """Restores the streams that a bench may have replaced, and opens those again that it closed: the run prints its results."""
    for descriptor, (name, stream) in enumerate(streams.items(), start=1):
        if getattr(stream, "closed", False):
            stream = open(descriptor, "w", errors="backslashreplace", closefd=False)
        setattr(sys, name, stream)


def _text(error: BaseException) -> str:
    """Returns the message of an error, also of one whose ``__str__`` fails."""
    try:
        return str(error)
    except Exception as other:
        return f"{type(error).__name__}, whose message cannot be made: {type(other).__name__}"


def _traceback(error: BaseException) -> str:
    try:
        return "".join(traceback.format_exception(error))
    except Exception:
        return _text(error)


def _skipped(error: BaseException) -> str | None:
    """Returns the reason if the error is that of `pytest.skip` or `pytest.xfail`, otherwise None."""
    pytest = sys.modules.get("pytest")
    if pytest is not None and isinstance(error, (pytest.skip.Exception, pytest.xfail.Exception)):
        return str(error.msg) or "skipped"
    return None


def failed_run(error: BaseException) -> Result:
    """Returns the result that stands for a run that an error has ended outside of the tests.

    >>> results.append(failed_run(error))
    """
    return Result("run", "hoverlock", 0, 0.0, False, error=error, text=_traceback(error))


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


# The characters that XML 1.0 does not allow.
_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def _xml(text: str) -> str:
    """Returns the text with each character that XML does not allow as an escape."""
    return _NOT_XML.sub(lambda found: f"\\x{ord(found[0]):02x}", text)


def write_junit(results: Iterable[Result], path: str | Path, *, errors_are_failures: bool = False) -> None:
    """Writes the results as JUnit XML. With ``errors_are_failures``, a test with an error has a ``failure`` element, as in
    cocotb: many a script counts only these.

    >>> write_junit(run("test_counter.py"), "results.xml")
    """
    from xml.etree import ElementTree

    results = list(results)
    is_failure = [r.error is not None and (errors_are_failures or is_failed_check(r.error)) for r in results]
    suite = ElementTree.Element(
        "testsuite",
        name="hoverlock",
        tests=str(len(results)),
        failures=str(sum(is_failure)),
        errors=str(sum(r.error is not None for r in results) - sum(is_failure)),
        skipped=str(sum(r.skipped is not None for r in results)),
        time=f"{sum(r.seconds for r in results):.3f}",
    )
    for result, failed in zip(results, is_failure):
        case: Any = ElementTree.SubElement(
            suite, "testcase", classname=_xml(result.module), name=_xml(result.name), time=f"{result.seconds:.3f}"
        )
        properties = ElementTree.SubElement(case, "properties")
        ElementTree.SubElement(properties, "property", name="random_seed", value=str(result.seed))
        if result.skipped is not None:
            ElementTree.SubElement(case, "skipped", message=_xml(result.skipped))
        elif result.error is not None:
            kind = "failure" if failed else "error"
            node = ElementTree.SubElement(case, kind, message=_xml(_text(result.error)), type=type(result.error).__name__)
            node.text = _xml(result.text)
    suites = ElementTree.Element("testsuites")
    suites.append(suite)
    path = Path(path)
    aside = path.with_name(f".{path.name}.{os.getpid()}")
    ElementTree.ElementTree(suites).write(aside, encoding="utf-8", xml_declaration=True)
    aside.replace(path)
