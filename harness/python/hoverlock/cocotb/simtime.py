"""``cocotb.simtime``, by cocotb 2's name."""

from __future__ import annotations

from typing import Literal

from ..utils import _UNITS
from .utils import _get_log_time_scale, get_sim_steps, get_sim_time, get_time_from_sim_steps

__all__ = ["RoundMode", "TimeUnit", "convert", "get_sim_steps", "get_sim_time", "get_time_from_sim_steps", "time_precision"]

RoundMode = Literal["error", "round", "ceil", "floor"]
TimeUnit = Literal["step", "fs", "ps", "ns", "us", "ms", "sec"]
time_precision = -12
"""The time precision as a power of ten, in seconds: -12, a picosecond."""


def convert(value: float, unit: TimeUnit, *, to: TimeUnit, round_mode: RoundMode = "error") -> float:
    """A span of time in another unit; to ``"step"``, a whole number.

    >>> convert(1500, "ps", to="ns")
    1.5
    """
    if to == "step":
        return get_sim_steps(value, unit, round_mode=round_mode)
    return value * _UNITS[unit] / _UNITS[to]
