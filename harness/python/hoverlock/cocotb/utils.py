"""``cocotb.utils``."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cached_property

from ..deprecated import advise
from ..utils import _UNITS
from ..utils import get_sim_time as _get_sim_time
from .log import want_color_output

__all__ = [
    "get_sim_steps",
    "get_sim_time",
    "get_time_from_sim_steps",
    "hexdiffs",
    "hexdump",
    "lazy_property",
    "want_color_output",
]


class lazy_property(cached_property):  # type: ignore[type-arg]
    """A property that is computed on its first read and kept: ``functools.cached_property``.

    >>> class Frame:
    ...     @lazy_property
    ...     def pixels(self):
    ...         return 640 * 480
    >>> Frame().pixels
    307200
    """


def get_sim_time(unit: str = "step", *, units: str | None = None) -> float:
    """Returns the simulation time, as `hoverlock.utils.get_sim_time` does.

    >>> get_sim_time("ns")
    """
    if units is not None:
        advise("get_sim_time(units)")
    return _get_sim_time(units or unit)


def get_sim_steps(time: float, unit: str = "step", *, units: str | None = None, round_mode: str | None = None) -> int:
    """Converts a span of time into steps of 1 ps.

    >>> get_sim_steps(2, "ns")
    2000
    """
    if units is not None:
        advise("get_sim_steps(units)")
    # By its decimal digits: 0.1 ns is exactly 100 steps, although 0.1 has no exact binary fraction.
    scaled = Fraction(str(time)) * _UNITS[units or unit] / _UNITS["step"]
    if round_mode in (None, "error"):
        if scaled.denominator != 1:
            raise ValueError(f"{time} {units or unit} is not a whole number of steps (1 ps): give a round_mode")
        return int(scaled)
    if round_mode == "round":
        return round(scaled)
    if round_mode in ("ceil", "floor"):
        return math.ceil(scaled) if round_mode == "ceil" else math.floor(scaled)
    raise ValueError(f"no round_mode '{round_mode}': error, round, ceil or floor")


def get_time_from_sim_steps(steps: int, unit: str | None = None, *, units: str | None = None) -> float:
    """Converts steps of 1 ps into a unit.

    >>> get_time_from_sim_steps(2500, "ns")
    2.5
    """
    if units is not None:
        advise("get_time_from_sim_steps(units)")
    return steps * _UNITS["step"] / _UNITS[units or unit or "step"]


def hexdump(x: bytes | str) -> str:
    """Returns bytes as lines of 16: the offset, the bytes, and their printable characters.

    >>> print(hexdump(b"hello"))
    0000   68 65 6C 6C 6F                                     hello
    """
    data = x.encode("latin-1") if isinstance(x, str) else bytes(x)
    lines = []
    for at in range(0, len(data), 16):
        part = data[at : at + 16]
        printable = "".join(chr(byte) if 32 <= byte < 127 else "." for byte in part)
        lines.append(f"{at:04x}   {' '.join(f'{byte:02X}' for byte in part):<48}   {printable}\n")
    return "".join(lines)


def hexdiffs(x: bytes | str, y: bytes | str) -> str:
    """Returns the lines of two dumps that differ, those of ``x`` before those of ``y``.

    >>> print(hexdiffs(b"hello", b"hallo"))
    """
    lines = []
    dumps = [hexdump(side).splitlines() for side in (x, y)]
    for at in range(max(map(len, dumps))):
        pair = [dump[at] if at < len(dump) else "" for dump in dumps]
        if pair[0] != pair[1]:
            lines += [f"{mark} {line}\n" for mark, line in zip("-+", pair) if line]
    return "".join(lines)


def _get_simulator_precision() -> int:
    """Returns the time precision as a power of ten, in seconds: -12, a picosecond."""
    return -12


def _get_log_time_scale(unit: str) -> int:
    """Returns a unit of time as a power of ten, in seconds: -9 for ``"ns"``."""
    return _get_simulator_precision() if unit == "step" else round(math.log10(_UNITS[unit] / _UNITS["sec"]))
