"""``cocotb.simulator``: the functions that libraries use.

>>> if simulator.is_running():
...     ...
"""

from __future__ import annotations

from ..errors import SimulationError

__all__ = ["get_precision", "is_running"]


def is_running() -> bool:
    """Whether a test is running."""
    from ..testing import running

    try:
        running()
    except SimulationError:
        return False
    return True


def get_precision() -> int:
    """The time precision as a power of ten, in seconds: -12, a picosecond."""
    return -12
