"""The pytest plug-in: tests made with ``@hoverlock.test()`` are collected, selected and reported as other tests.

    pytest -n 2 --junitxml results.xml test_counter.py
    pytest --hoverlock-seed 1234 --hoverlock-waves fst --hoverlock-waves-on-failure test_counter.py
    pytest -n 2 --hoverlock-coverage

A bench may take fixtures after ``dut``, and plain tests may take ``hoverlock_seed`` and ``hoverlock_simulate``.
"""

from __future__ import annotations

import inspect
import os
import shlex
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

_SEED = "hoverlock_seed"
_seed_key = pytest.StashKey[int]()
_outputs_key = pytest.StashKey[Any]()


def pytest_addoption(parser: pytest.Parser) -> None:
    from .options import add_design_options

    add_design_options(parser.getgroup("hoverlock", "benches for Verilog").addoption)


def pytest_configure(config: pytest.Config) -> None:
    from .options import outputs_from
    from .errors import HoverlockError
    from .runner import new_seed

    given = config.getoption("--hoverlock-seed")
    worker = getattr(config, "workerinput", {})  # of pytest-xdist: all workers have the seed of the session
    seed = worker.get(_SEED, given)
    config.stash[_seed_key] = new_seed() if seed is None else seed
    try:
        outputs = config.stash[_outputs_key] = outputs_from(config.getoption)
    except HoverlockError as error:
        raise pytest.UsageError(str(error)) from None
    outputs.folder = config.invocation_params.dir / outputs.folder
    if not worker:
        outputs.begin()


def pytest_report_header(config: pytest.Config) -> str:
    return f"hoverlock: seed {config.stash[_seed_key]}"


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    # All workers have written their counts by now; only the session that started them runs this hook.
    outputs = config.stash[_outputs_key]
    if outputs.coverage:
        terminalreporter.write_line(outputs.merge_coverage())


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Passes the seed of the session to a worker of pytest-xdist."""
    node.workerinput[_SEED] = node.config.stash[_seed_key]


@pytest.fixture
def hoverlock_seed(request: pytest.FixtureRequest) -> int:
    """The seed of this test. It depends on the seed of the session (``--hoverlock-seed``) and on the test's name."""
    from .testing import seed_of

    return seed_of(request.config.stash[_seed_key], request.node.name)


@pytest.fixture
def hoverlock_simulate(request: pytest.FixtureRequest, hoverlock_seed: int) -> Callable[..., Any]:
    """Runs a bench from a plain test, with the seed, the waves and the coverage of the session.

    >>> @pytest.mark.parametrize("width", [1, 8, 33])
    ... def test_any_width(hoverlock_simulate, width):
    ...     hoverlock_simulate(design.changed(parameters={"WIDTH": width}), bench, gap=3)
    """
    outputs = request.config.stash[_outputs_key]
    module = request.node.parent.name.removesuffix(".py")

    def simulate(design: Any, bench: Any, *, wall_limit: float | None = 600.0, **arguments: Any) -> Any:
        from .session import Session

        session = Session(outputs.design(design), seed=hoverlock_seed, name=request.node.name)
        session.label = f"{module}.{request.node.name}"
        with session, outputs.of(session):
            return session.run(bench, wall_limit=wall_limit, **arguments)

    return simulate


def pytest_pycollect_makeitem(collector: Any, name: str, obj: object) -> Any:
    # Files without hoverlock tests do not load it.
    if "hoverlock.testing" not in sys.modules:
        return None
    from . import testing

    # The decorator is a function named `test`: pytest would call it as a test, which would pass.
    if obj is testing.test or getattr(obj, "_makes_tests", False) is True:
        return []
    if not isinstance(obj, testing.Test):
        return None
    if obj.module != collector.obj.__name__ or _is_for_the_runner(collector, obj):
        return []
    return [
        BenchItem.from_parent(collector, name=variant.name, callobj=_plain(variant), bench=variant)
        for made in obj.variants()
        for variant in _marked(made)
    ]


def _marked(test: Any) -> list[Any]:
    """One test for each combination of ``pytest.mark.parametrize``."""
    tests = [test]
    for mark in getattr(test.function, "pytestmark", []):
        if mark.name != "parametrize":
            continue
        names, choices = mark.args[:2]
        names = [name.strip() for name in names.split(",")] if isinstance(names, str) else list(names)
        expanded = []
        for made in tests:
            for choice in choices:
                values, label = getattr(choice, "values", None), getattr(choice, "id", None)  # of pytest.param
                values = values if values is not None else (choice,) if len(names) == 1 else tuple(choice)
                label = label or "-".join(str(value) for value in values)
                inner = f"{made.name[:-1]}-{label}]" if made.name.endswith("]") else f"{made.name}[{label}]"
                expanded.append(made.with_arguments(inner, dict(zip(names, values, strict=True))))
        tests = expanded
    return tests


def _is_for_the_runner(collector: Any, test: Any) -> bool:
    """Returns whether the module's benches are not tests of pytest: a plain test runs them, with cocotb's runner or with
    cocotb-test, in this module or in another one. Under the alias these are all benches without a design."""
    if test.design is not None or getattr(collector.obj, "design", None) is not None:
        return False
    if collector.config.getoption("--hoverlock-top") is not None:
        return False
    from . import cocotb

    if cocotb._alias:
        return True
    from .cocotb.runner import Verilator, get_runner

    starter = sys.modules.get("hoverlock.cocotb_test.simulator")
    starters = [get_runner, Verilator, *(() if starter is None else (starter, starter.run, sys.modules.get("cocotb_test")))]
    return any(value is one for value in vars(collector.obj).values() for one in starters)


def _plain(bench: Any) -> Callable[..., None]:
    """Returns a function whose arguments are the fixtures of the bench, for pytest to inspect."""

    def call(**fixtures: Any) -> None: ...

    wanted = list(inspect.signature(bench.function).parameters.values())[1:]
    kinds = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    chosen = [p for p in wanted if p.name not in bench.arguments and p.default is p.empty and p.kind in kinds]
    call.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in chosen]
    )
    call.__name__, call.__doc__, call.__module__ = bench.function.__name__, bench.function.__doc__, bench.module
    marks = [mark for mark in getattr(bench.function, "pytestmark", []) if mark.name != "parametrize"]
    call.pytestmark = marks  # type: ignore[attr-defined]
    return call


class BenchItem(pytest.Function):
    """A bench as an item of pytest."""

    def __init__(self, *, bench: Any, **others: Any) -> None:
        super().__init__(**others)
        self.bench = bench
        if bench.skip:
            self.add_marker(pytest.mark.skip(reason=bench.skip if isinstance(bench.skip, str) else "skip=True"))

    def runtest(self) -> None:
        from .options import design_from
        from .runner import design_of
        from .testing import seed_of

        option = self.config.getoption
        given = design_from(option)
        design = design_of(self.bench, self.parent.obj, given)  # type: ignore[union-attr]
        seed = seed_of(self.config.stash[_seed_key], self.name)
        self.user_properties.append(("random_seed", seed))
        wanted = inspect.signature(self.obj).parameters
        with _without_unread_logs(self):
            self.bench.run(
                design,
                seed=seed,
                wall_timeout=option("--hoverlock-wall-timeout"),
                outputs=self.config.stash[_outputs_key],
                arguments={name: self.funcargs[name] for name in wanted},
            )

    def _traceback_filter(self, excinfo: pytest.ExceptionInfo[BaseException]) -> Any:
        # Frames between pytest and the bench are of no use to the author of the bench.
        package = Path(__file__).resolve().parent
        kept = [entry for entry in excinfo.traceback if package not in Path(str(entry.path)).resolve().parents]
        bench = Path(str(self.path)).resolve()
        first = next((i for i, entry in enumerate(kept) if Path(str(entry.path)).resolve() == bench), None)
        if first is None:
            return excinfo.traceback
        return type(excinfo.traceback)(kept[first:])

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        from .errors import HoverlockError

        in_bench = any(Path(str(e.path)).resolve() == Path(str(self.path)).resolve() for e in excinfo.traceback)
        if isinstance(excinfo.value, HoverlockError) and not in_bench:
            return f"{type(excinfo.value).__name__}: {excinfo.value}"
        return super().repr_failure(excinfo)

    def reportinfo(self) -> tuple[Path, int, str]:
        return self.path, self.bench.function.__code__.co_firstlineno - 1, self.name


@contextmanager
def _without_unread_logs(item: pytest.Function) -> Iterator[None]:
    """Turns off the log handlers of pytest that nobody reads. pytest formats each record three times: for the report, for
    the fixture ``caplog``, and for a log file, which is the null device by default. For benches that log each beat of a
    bus this costs more than the simulation."""
    plugin = item.config.pluginmanager.get_plugin("logging-plugin")
    unread = []
    file = getattr(plugin, "log_file_handler", None)
    if getattr(getattr(file, "stream", None), "name", None) == os.devnull:
        unread.append(file)
    # A test with `request` can get `caplog` from it.
    if not {"caplog", "request"} & set(item.fixturenames):
        unread.append(getattr(plugin, "caplog_handler", None))
    levels = [(handler, handler.level) for handler in unread if handler is not None]
    for handler, _ in levels:
        handler.setLevel(sys.maxsize)
    try:
        yield
    finally:
        for handler, level in levels:
            handler.setLevel(level)


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Iterator[None]:
    outcome = yield
    report = outcome.get_result()  # type: ignore[attr-defined]
    is_bench = isinstance(item, BenchItem) or "hoverlock_seed" in getattr(item, "fixturenames", ())
    if is_bench and report.when == "call" and report.failed:
        from .runner import replay_text

        place = os.path.relpath(item.path, item.config.invocation_params.dir)
        command = shlex.join(["pytest", f"{place}::{item.name}"])
        report.sections.append(("hoverlock", replay_text(item.config.stash[_seed_key], command)))
