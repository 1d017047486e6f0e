"""Waves and coverage of a run, selected by the options of pytest and of the command line.

>>> outputs = Outputs(folder="out", waves="fst", only_failures=True, coverage=True)
>>> results = run("test_counter.py", outputs=outputs)
>>> print(outputs.merge_coverage())
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from ._core import Coverage
from .design import Design

if TYPE_CHECKING:
    from pathlib import Path

    from .session import Session

__all__ = ["Outputs"]


class Outputs:
    """The files that a run writes: waves as ``<module>.<test>.fst``, coverage of all tests as ``coverage.info``.

    Parameters
    ----------
    folder : path
        Folder of the files.
    waves : "vcd" or "fst", optional
        Writes all signals of every test.
    only_failures : bool
        Keeps only the waves of failing tests.
    last : int, optional
        Writes the last time steps of failing tests instead, as VCD; a clock cycle has two time steps.
    coverage : bool
        Counts lines, branches, toggles and ``cover`` statements of every test.

    >>> outputs = Outputs("out", waves="fst", only_failures=True, coverage=True)
    >>> results = run("test_counter.py", outputs=outputs)
    """

    # Not a dataclass: importing that module takes 10 ms.
    def __init__(
        self,
        folder: str | Path = "hoverlock-output",
        waves: str | None = None,
        only_failures: bool = False,
        last: int | None = None,
        coverage: bool = False,
    ) -> None:
        self.folder = folder
        self.waves = waves
        self.only_failures = only_failures
        self.last = last
        self.coverage = coverage

    def design(self, design: Design) -> Design:
        """Returns the design with the selected waves and coverage built in."""
        changes: dict[str, Any] = {}
        if self.waves is not None and self.last is None:
            changes["waves"] = self.waves
        if self.coverage:
            changes["coverage"] = True
        return design.changed(**changes) if changes else design

    @contextmanager
    def of(self, session: Session) -> Iterator[None]:
        """Writes the files of a test while it runs, and closes its session."""
        name = re.sub(r"[^\w.,=\[\]-]", "_", session.label)
        path = None
        if self.last is not None:
            path = self._path(f"{name}.vcd")
            session.simulation.start_waves(path, before_failure=self.last)
        elif self.waves is not None:
            path = self._path(f"{name}.{self.waves}")
            session.simulation.start_waves(path)
        failed = True
        try:
            yield
            failed = False
        finally:
            if self.coverage:
                session.simulation.write_coverage(self._coverage_folder() / f"{name}.{os.getpid()}.dat")
            session.close()
            if path is not None and not failed and (self.only_failures or self.last is not None):
                for left in (path, path.with_suffix(".gtkw")):
                    left.unlink(missing_ok=True)

    def begin(self) -> None:
        """Removes the coverage files of an earlier run."""
        if self.coverage:
            for old in self._coverage_folder().glob("*.dat"):
                old.unlink()

    def merge_coverage(self) -> str:
        """Merges the coverage of all tests, writes it as LCOV, and returns a line with the totals."""
        total = Coverage()
        counted = sorted(self._coverage_folder().glob("*.dat"))
        for path in counted:
            total.add(path)
        path = self._path("coverage.info")
        aside = path.with_name(f".{path.name}.{os.getpid()}")
        aside.write_text(total.lcov())
        aside.replace(path)
        kinds = []
        for kind in ("line", "branch", "toggle", "user"):
            met, of = total.met(kind)
            if of:
                kinds.append(f"{kind} {met} of {of}")
        return f"coverage of {len(counted)} tests: {', '.join(kinds) or 'nothing to count'}; {path}"

    def _path(self, name: str) -> Path:
        return self._folder() / name

    def _coverage_folder(self) -> Path:
        return self._folder("coverage")

    def _folder(self, below: str = "") -> Path:
        from pathlib import Path  # here, so that a test that writes no files starts faster

        folder = Path(self.folder, below)
        folder.mkdir(parents=True, exist_ok=True)
        return folder
