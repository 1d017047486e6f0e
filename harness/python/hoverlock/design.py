"""A design under test: Verilog sources, top module, parameters.

>>> design = Design("counter.v", top="counter", parameters={"WIDTH": 8})
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from ._core import Library, compile

if TYPE_CHECKING:
    # Loading pathlib would take 4 ms of the 50 that a test from the cache takes in all.
    from pathlib import Path
    from types import FrameType

__all__ = ["Design"]


@dataclass(frozen=True)
class Design:
    """What is needed to build a model. Relative paths begin at the folder of the file that makes the design.

    A model is built once and found again as long as nothing it depends on changes; ``internals`` names internal signals
    and memories to be reached (``"u_core.state"``, ``"u_core.*"``); ``waves`` is ``"vcd"`` or ``"fst"``;
    ``random_initial`` starts registers that have no reset with random bits of the test's seed.

    >>> design = Design("counter.v", top="counter", parameters={"WIDTH": 8}, internals=["u_core.*"])
    """

    sources: str | Path | Iterable[str | Path]
    top: str
    parameters: Mapping[str, int | str] = field(default_factory=dict)
    defines: Mapping[str, object] = field(default_factory=dict)
    includes: Iterable[str | Path] = ()
    internals: Iterable[str] = ()
    flags: Iterable[str] = ()
    plusargs: Iterable[str] = ()
    waves: str | None = None
    coverage: bool = False
    random_initial: bool = False
    assertions: bool = True
    warnings_are_errors: bool = False
    timescale: str | None = None
    edges_after_eval: bool = False
    verilator: str | Path | None = None
    cache: str | Path | None = None
    folder: str | Path | None = None

    def __post_init__(self) -> None:
        one = isinstance(self.sources, (str, os.PathLike))
        sources = (self.sources,) if one else tuple(self.sources)  # type: ignore[arg-type]
        object.__setattr__(self, "sources", sources)
        for name in ("includes", "internals", "flags", "plusargs"):
            value = getattr(self, name)
            object.__setattr__(self, name, (value,) if isinstance(value, str) else tuple(value))
        if self.folder is None:
            object.__setattr__(self, "folder", _folder_of_caller())

    def changed(self, **options: Any) -> Design:
        """The same with other options.

        >>> wide = design.changed(parameters={"WIDTH": 16})
        """
        return replace(self, **options)

    def compile(self) -> Library:
        """Builds the model, or finds it in the cache; ``BuildError`` has Verilator's messages.

        >>> design.compile().warnings
        """
        folder = self.folder or "."
        return compile(
            self.top,
            [os.path.join(folder, source) for source in self.sources],  # type: ignore[union-attr]
            includes=[os.path.join(folder, include) for include in self.includes],
            parameters=dict(self.parameters),
            defines=dict(self.defines),
            flags=list(self.flags),
            internals=list(self.internals),
            waves=self.waves,
            coverage=self.coverage,
            random_initial=self.random_initial,
            assertions=self.assertions,
            warnings_are_errors=self.warnings_are_errors,
            timescale=self.timescale,
            verilator=self.verilator,
            cache=self.cache,
        )


def _folder_of_caller() -> str:
    """The folder of the file that says ``Design(...)``."""
    own = os.path.dirname(os.path.realpath(__file__))
    frame: FrameType | None = sys._getframe()
    while frame is not None:
        name = frame.f_code.co_filename
        if name != __file__ and not name.startswith("<"):
            folder = os.path.dirname(os.path.realpath(name))
            if folder != own and "dataclasses" not in name:
                return folder
        frame = frame.f_back
    return os.getcwd()
