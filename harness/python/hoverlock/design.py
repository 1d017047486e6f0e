"""The description of a design under test: Verilog sources, top module, parameters.

>>> design = Design("counter.v", top="counter", parameters={"WIDTH": 8})
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from ._core import Library, compile
from .flags import harness_flags

if TYPE_CHECKING:
    # Loading pathlib takes 4 ms; a test from the cache takes 50 ms in all.
    from pathlib import Path
    from types import FrameType

__all__ = ["Design"]


class Design:
    """The description of a design, from which its model is built. A model is built again only if one of its inputs has
    changed.

    Parameters
    ----------
    sources : path or iterable of paths
        Verilog files. Relative paths refer to ``folder``.
    top : str
        The top module.
    parameters : mapping of str to int or str
        Parameters of the top module.
    defines : mapping of str to object
        Macros; None for a macro without a value.
    includes : iterable of paths
        Folders for ``include`` and for modules that are named like their files.
    internals : iterable of str
        Internal signals and memories to make accessible: ``"u_core.state"``, ``"u_core.*"``.
    forceable : iterable of str
        Internal signals that ``Force`` may override, and that are accessible too: ``"u_core.enable"``.
    flags : iterable of str
        Further arguments of Verilator. Those for waves and coverage have the effect of ``waves`` and ``coverage``; those that
        say how Verilator is run, such as ``--threads``, have none.
    plusargs : iterable of str
        Arguments that ``$test$plusargs`` and ``$value$plusargs`` see, such as ``"+verbose"``.
    waves : "vcd" or "fst", optional
        Builds in waves of all signals.
    coverage : bool
        Builds in coverage counters.
    random_initial : bool
        Registers without a reset start with random bits of the test's seed instead of 0.
    assertions : bool
        Whether ``assert`` in the Verilog is checked.
    warnings_are_errors : bool
        Whether Verilator's warnings fail the build.
    timescale : str, optional
        Time unit and precision of modules without a ``timescale``. Default: ``"1ns/1ps"``.
    edges_after_eval : bool
        Tasks that wait for an edge of an input run after the evaluation, and read the values of registers after the edge.
    verilator, cache : path, optional
        The Verilator program and the folder of built models. Default: ``verilator`` of PATH, and the user's cache folder.
    folder : path, optional
        Folder to which relative paths refer. Default: that of the file that creates the design.

    >>> design = Design("counter.v", top="counter", parameters={"WIDTH": 8}, internals=["u_core.*"])
    """

    # Not a dataclass: importing that module takes 10 ms.
    def __init__(
        self,
        sources: str | Path | Iterable[str | Path],
        top: str,
        parameters: Mapping[str, int | str] | None = None,
        defines: Mapping[str, object] | None = None,
        includes: Iterable[str | Path] = (),
        internals: Iterable[str] = (),
        forceable: Iterable[str] = (),
        flags: Iterable[str] = (),
        plusargs: Iterable[str] = (),
        waves: str | None = None,
        coverage: bool = False,
        random_initial: bool = False,
        assertions: bool = True,
        warnings_are_errors: bool = False,
        timescale: str | None = None,
        edges_after_eval: bool = False,
        verilator: str | Path | None = None,
        cache: str | Path | None = None,
        folder: str | Path | None = None,
    ) -> None:
        self.sources: tuple[str | Path, ...] = _tuple_of(sources)
        self.top = top
        self.parameters = {} if parameters is None else parameters
        self.defines = {} if defines is None else defines
        self.includes: tuple[str | Path, ...] = _tuple_of(includes)
        self.internals: tuple[str, ...] = _tuple_of(internals)
        self.forceable: tuple[str, ...] = _tuple_of(forceable)
        self.flags, waves_by_flag, coverage_by_flag = harness_flags(_tuple_of(flags))
        self.plusargs: tuple[str, ...] = _tuple_of(plusargs)
        self.waves = waves or waves_by_flag
        self.coverage = coverage or coverage_by_flag
        self.random_initial = random_initial
        self.assertions = assertions
        self.warnings_are_errors = warnings_are_errors
        self.timescale = timescale
        self.edges_after_eval = edges_after_eval
        self.verilator = verilator
        self.cache = cache
        self.folder = _folder_of_caller() if folder is None else folder

    def __setattr__(self, name: str, value: Any) -> None:
        if "folder" in vars(self):
            raise AttributeError(f"a design cannot be modified: changed({name}=...) returns a new one")
        super().__setattr__(name, value)

    def __eq__(self, other: object) -> bool:
        return vars(self) == vars(other) if isinstance(other, Design) else NotImplemented

    def __repr__(self) -> str:
        return f"Design({', '.join(f'{name}={value!r}' for name, value in vars(self).items())})"

    def changed(self, **options: Any) -> Design:
        """Returns this design with other options.

        >>> wide = design.changed(parameters={"WIDTH": 16})
        """
        return Design(**{**vars(self), **options})

    def compile(self) -> Library:
        """Builds the model, or loads it from the cache.

        Raises
        ------
        BuildError
            If the design does not build; the message has Verilator's messages.

        >>> design.compile().warnings
        """
        folder = self.folder or "."
        return compile(
            self.top,
            [os.path.join(folder, source) for source in self.sources],
            includes=[os.path.join(folder, include) for include in self.includes],
            parameters=dict(self.parameters),
            defines=dict(self.defines),
            flags=list(self.flags),
            internals=list(self.internals),
            forceable=list(self.forceable),
            waves=self.waves,
            coverage=self.coverage,
            random_initial=self.random_initial,
            assertions=self.assertions,
            warnings_are_errors=self.warnings_are_errors,
            timescale=self.timescale,
            verilator=self.verilator,
            cache=self.cache,
        )


def _tuple_of(values: Any) -> tuple[Any, ...]:
    """Returns one path or text, or several, as a tuple."""
    return (values,) if isinstance(values, (str, os.PathLike)) else tuple(values)


def _folder_of_caller() -> str:
    """Returns the folder of the file that calls ``Design(...)``."""
    own = os.path.dirname(os.path.realpath(__file__))
    frame: FrameType | None = sys._getframe()
    while frame is not None:
        name = frame.f_code.co_filename
        if name != __file__ and not name.startswith("<"):
            folder = os.path.dirname(os.path.realpath(name))
            if folder != own:
                return folder
        frame = frame.f_back
    return os.getcwd()
