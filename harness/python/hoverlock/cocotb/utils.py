"""``cocotb.utils``."""

from __future__ import annotations

from ..utils import _UNITS, get_sim_time

__all__ = ["get_sim_steps", "get_sim_time", "get_time_from_sim_steps"]


def get_sim_steps(time: float, unit: str = "step", *, units: str | None = None, round_mode: str | None = None) -> int:
    """A span of time in steps of 1 ps.

    >>> get_sim_steps(2, "ns")
    2000
    """
    return round(time * _UNITS[units or unit] / _UNITS["step"])


def get_time_from_sim_steps(steps: int, unit: str | None = None, *, units: str | None = None) -> float:
    """Steps of 1 ps, converted to a unit.

    >>> get_time_from_sim_steps(2500, "ns")
    2.5
    """
    return steps * _UNITS["step"] / _UNITS[units or unit or "step"]
