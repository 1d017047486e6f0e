"""``cocotb.utils``."""

from __future__ import annotations

import math
from fractions import Fraction

from ..deprecated import advise
from ..utils import _UNITS
from ..utils import get_sim_time as _get_sim_time
from .log import want_color_output

__all__ = ["get_sim_steps", "get_sim_time", "get_time_from_sim_steps", "want_color_output"]


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
