"""Simulation time."""

from __future__ import annotations

from . import _core

__all__ = ["get_sim_time"]

_UNITS = {"fs": 1, "ps": 10**3, "ns": 10**6, "us": 10**9, "ms": 10**12, "s": 10**15, "sec": 10**15, "step": 10**3}


def get_sim_time(unit: str = "step", *, units: str | None = None) -> float:
    """Returns the simulation time.

    Parameters
    ----------
    unit : str
        ``fs``, ``ps``, ``ns``, ``us``, ``ms``, ``s``, ``sec`` or ``step`` (1 ps).
    units : str, optional
        The unit by cocotb 1's name.

    Returns
    -------
    int or float
        An ``int`` if the time is a whole number of units.

    Raises
    ------
    ValueError
        If the unit is unknown.


    >>> get_sim_time("ns")
    120
    """
    scale = _UNITS.get(units or unit)
    if scale is None:
        raise ValueError(f"no unit '{units or unit}': {', '.join(_UNITS)}")
    now = _core.now()
    return now // scale if now % scale == 0 else now / scale
