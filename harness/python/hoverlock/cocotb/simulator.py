"""``cocotb.simulator``: what libraries ask of it.

>>> if simulator.is_running():
...     ...
"""

from __future__ import annotations

from ..errors import SimulationError

__all__ = ["get_precision", "is_running"]


def is_running() -> bool:
    """Whether a test runs."""
    from ..testing import running

    try:
        running()
    except SimulationError:
        return False
    return True


def get_precision() -> int:
    """The step of time as a power of ten: a picosecond."""
    return -12
