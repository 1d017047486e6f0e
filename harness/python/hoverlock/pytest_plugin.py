"""The pytest plug-in: tests made with ``@hoverlock.test()`` are collected, selected, run in parallel and reported as any.

    pytest -n 2 --junitxml results.xml test_counter.py
    pytest --hoverlock-seed 1234 test_counter.py
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

_SEED = "hoverlock_seed"


def pytest_addoption(parser: pytest.Parser) -> None:
    from .__main__ import add_design_options

    add_design_options(parser.getgroup("hoverlock", "benches for Verilog").addoption)


def pytest_configure(config: pytest.Config) -> None:
    from .runner import new_seed

    given = config.getoption("--hoverlock-seed")
    worker = getattr(config, "workerinput", {})  # of pytest-xdist: all workers have the seed of the session
    seed = worker.get(_SEED, given)
    config.stash[_seed_key] = new_seed() if seed is None else seed


_seed_key = pytest.StashKey[int]()


def pytest_report_header(config: pytest.Config) -> str:
    return f"hoverlock: seed {config.stash[_seed_key]}"


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Gives a worker of pytest-xdist the seed of the session."""
    node.workerinput[_SEED] = node.config.stash[_seed_key]


def pytest_pycollect_makeitem(collector: Any, name: str, obj: object) -> Any:
    import sys

    # Files without hoverlock's tests do not pay for it.
    if "hoverlock.testing" not in sys.modules:
        return None
    from .testing import Test

    if not isinstance(obj, Test):
        return None
    if getattr(obj.function, "__module__", None) != collector.obj.__name__:
        return []  # imported from another bench, where it is a test already
    return [BenchItem.from_parent(collector, name=variant.name, bench=variant) for variant in obj.variants()]


class BenchItem(pytest.Item):
    """One test."""

    def __init__(self, *, bench: Any, **others: Any) -> None:
        super().__init__(**others)
        self.bench = bench
        self.obj = bench.function
        for mark in getattr(bench.function, "pytestmark", []):
            self.add_marker(mark)
        if bench.skip:
            self.add_marker(pytest.mark.skip(reason=bench.skip if isinstance(bench.skip, str) else "skip=True"))

    def runtest(self) -> None:
        from .__main__ import design_from
        from .runner import design_of
        from .testing import seed_of

        option = self.config.getoption
        given = design_from(option("--hoverlock-source"), option("--hoverlock-top"), option("--hoverlock-parameter"))
        design = design_of(self.bench, self.parent.obj, given)  # type: ignore[union-attr]
        seed = seed_of(self.config.stash[_seed_key], self.name)
        self.user_properties.append(("random_seed", seed))
        self.bench.run(design, seed=seed, wall_timeout=option("--hoverlock-wall-timeout"))

    def _traceback_filter(self, excinfo: pytest.ExceptionInfo[BaseException]) -> Any:
        # What is between pytest and the bench tells its author nothing.
        ours = Path(__file__).resolve().parent
        kept = [entry for entry in excinfo.traceback if ours not in Path(str(entry.path)).resolve().parents]
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
        return super().repr_failure(excinfo, style=style)

    def reportinfo(self) -> tuple[Path, int, str]:
        return self.path, self.obj.__code__.co_firstlineno - 1, self.name


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Iterator[None]:
    outcome = yield
    report = outcome.get_result()  # type: ignore[attr-defined]
    if isinstance(item, BenchItem) and report.when == "call" and report.failed:
        from .runner import replay_text

        report.sections.append(("hoverlock", replay_text(item.config.stash[_seed_key])))
