"""Single-event upsets in a bench: bits of registers and memories flip while it runs, one in each run.

>>> from hoverlock.fault import campaign
>>>
>>> found = campaign(design, bench, ["u_core.state", "u_core.memory"], upsets=200, seed=1)
>>> found.counts
{'masked': 151, 'detected': 12, 'silent': 34, 'hang': 3}

The command ``hoverlock fault`` does the same for any Verilog without a bench, with random inputs or those of a table.
"""

from __future__ import annotations

import random
from collections.abc import Iterable
from fnmatch import fnmatchcase
from typing import Any, NamedTuple

from ._core import ArrayHandle, Handle, start_soon
from .design import Design
from .errors import DeadlockError, SimTimeoutError, VerilogError, VerilogFinished
from .session import Bench, Session
from .triggers import FallingEdge
from .utils import get_sim_time

__all__ = ["CLASSES", "Campaign", "Register", "Upset", "campaign"]

CLASSES = ("masked", "detected", "silent", "hang")
"""What comes of an upset, see `campaign`."""

# 97.5 % quantile of the normal distribution.
_Z_95 = 1.959964


class Register(NamedTuple):
    """A register, or a memory of more than one word.

    >>> found.registers[0].bits
    32
    """

    name: str
    words: int
    width: int

    @property
    def bits(self) -> int:
        """The number of its bits."""
        return self.words * self.width


class Upset(NamedTuple):
    """A flipped bit and what came of it. ``word`` counts from the first index as declared, ``bit`` from the lowest bit;
    ``cycle`` is the falling edge of the clock at which the bit flips, from 1.

    >>> [upset for upset in found.upsets if upset.outcome == "silent"]
    """

    register: str
    word: int
    bit: int
    cycle: int
    outcome: str


class Campaign(NamedTuple):
    """The upsets of a campaign.

    >>> found.share("silent")
    (0.17, 0.124, 0.228)
    """

    registers: list[Register]
    cycles: int
    upsets: list[Upset]

    @property
    def counts(self) -> dict[str, int]:
        """The number of upsets in each class."""
        return {name: sum(upset.outcome == name for upset in self.upsets) for name in CLASSES}

    def of(self, pattern: str) -> Campaign:
        """Returns the upsets in registers whose name matches; ``*`` stands for any text."""
        return self._replace(upsets=[upset for upset in self.upsets if fnmatchcase(upset.register, pattern)])

    def share(self, outcome: str) -> tuple[float, float, float]:
        """Returns the share of a class and its 95 % confidence interval by Wilson's score."""
        if outcome not in CLASSES:
            raise ValueError(f"{outcome!r} is no class; they are {', '.join(CLASSES)}")
        hits, n = self.counts[outcome], len(self.upsets)
        if n == 0:
            return (0.0, 0.0, 1.0)
        p, z2 = hits / n, _Z_95**2
        middle = (p + z2 / (2 * n)) / (1 + z2 / n)
        half = _Z_95 / (1 + z2 / n) * (p * (1 - p) / n + z2 / (4 * n * n)) ** 0.5
        return (p, max(middle - half, 0.0) if hits else 0.0, min(middle + half, 1.0) if hits < n else 1.0)


def campaign(
    design: Design,
    bench: Bench,
    registers: Iterable[str],
    *,
    clock: str = "clk",
    upsets: int = 100,
    seed: int = 0,
    arguments: dict[str, Any] | None = None,
) -> Campaign:
    """Runs a bench once for each upset and compares what it returns with the run without one.

    ============ ==================================================================
    masked       the bench returns the same
    detected     the bench raises: a failed ``assert``, or ``$error`` in the Verilog
    silent       the bench returns something else
    hang         no end within twice the time, a deadlock, or ``$finish``
    ============ ==================================================================

    Parameters
    ----------
    design : Design
        The design.
    bench : coroutine function
        Its first argument is the design. It starts the clock, and returns what was observed: any value that can be compared.
    registers : iterable of str
        Registers and memories inside the design: ``"u_core.state"``, ``"u_core.*"``. Every bit is equally likely. A wire that
        matches is drawn too: its bit stays flipped until its inputs change.
    clock : str
        The input at whose falling edges bits flip.
    upsets : int
        Number of runs.
    seed : int
        Seed of bits and cycles, and of each run.
    arguments : dict, optional
        Further arguments of the bench, by name.

    Raises
    ------
    ValueError
        If nothing matches ``registers``, the clock does not run, or the bench returns different values without an upset.

    >>> campaign(design, bench, ["state"], upsets=1000).share("silent")
    """
    patterns = list(registers)
    design = design.changed(internals=(*design.internals, *patterns))
    runs = _Runs(design, bench, clock, seed, arguments or {})
    found, cycles, duration, wanted = runs.reference(patterns)
    if runs.reference(patterns)[3] != wanted:
        raise ValueError("the bench returns different values in two runs without an upset: outcomes would mean nothing")
    draw = random.Random(seed)
    outcomes = []
    for _ in range(upsets):
        at = draw.randrange(sum(register.bits for register in found))
        cycle = draw.randint(1, cycles)
        for register in found:
            if at < register.bits:
                break
            at -= register.bits
        word, bit = divmod(at, register.width)
        outcomes.append(Upset(register.name, word, bit, cycle, runs.upset(register, word, bit, cycle, 2 * duration, wanted)))
    return Campaign(found, cycles, outcomes)


class _Runs:
    """Runs of a bench with and without an upset."""

    def __init__(self, design: Design, bench: Bench, clock: str, seed: int, arguments: dict[str, Any]) -> None:
        self.design, self.bench, self.clock, self.seed, self.arguments = design, bench, clock, seed, arguments

    def reference(self, patterns: list[str]) -> tuple[list[Register], int, int, Any]:
        """Returns registers, falling edges, duration in femtoseconds, and the result of a run without an upset."""
        edges = 0

        async def count(clock: Handle) -> None:
            nonlocal edges
            while True:
                await FallingEdge(clock)
                edges += 1

        async def run(dut: Any, **arguments: Any) -> tuple[list[Register], int, Any]:
            found = _registers(dut, patterns)
            start_soon(count(getattr(dut, self.clock)))
            result = await self.bench(dut, **arguments)
            return found, int(get_sim_time("fs")), result

        with Session(self.design, seed=self.seed, name="campaign") as session:
            found, duration, result = session.run(run, **self.arguments)
        if not found:
            raise ValueError(f"no register or memory inside the design matches {', '.join(patterns)}")
        if edges == 0:
            raise ValueError(f"no falling edge of {self.clock!r} in the bench: bits flip there")
        return found, edges, duration, result

    def upset(self, register: Register, word: int, bit: int, cycle: int, limit: int, wanted: Any) -> str:
        """Returns the class of an upset."""
        async def flip(dut: Any) -> None:
            for _ in range(cycle):
                await FallingEdge(getattr(dut, self.clock))
            target = dict(dut._simulation.handles())[register.name]
            if isinstance(target, ArrayHandle):
                target = list(target)[word]
            target.setimmediatevalue(int(target.value) ^ (1 << bit))

        async def run(dut: Any, **arguments: Any) -> Any:
            start_soon(flip(dut))
            return await self.bench(dut, **arguments)

        try:
            with Session(self.design, seed=self.seed, name="upset") as session:
                return "masked" if session.run(run, time_limit=limit, **self.arguments) == wanted else "silent"
        except (SimTimeoutError, DeadlockError, VerilogFinished):
            return "hang"
        except (AssertionError, VerilogError):
            return "detected"


def _registers(dut: Any, patterns: list[str]) -> list[Register]:
    """Returns the internal signals whose names match."""
    found = []
    for name, handle in dut._simulation.handles():
        if isinstance(handle, (Handle, ArrayHandle)) and handle.direction == "internal":
            if any(fnmatchcase(name, pattern) for pattern in patterns):
                words = len(handle) if isinstance(handle, ArrayHandle) else 1
                width = len(next(iter(handle))) if isinstance(handle, ArrayHandle) else len(handle)
                found.append(Register(name, words, width))
    return found
