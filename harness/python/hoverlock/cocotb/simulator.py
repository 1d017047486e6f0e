"""``cocotb.simulator``: the functions that libraries use.

>>> if simulator.is_running():
...     ...
"""

from __future__ import annotations

__all__ = ["get_precision", "is_running"]


def is_running() -> bool:
    """Returns whether a test is running or modules are being loaded."""
    from ..session import running_or_loading

    return running_or_loading() is not None


def get_precision() -> int:
    """Returns the time precision as a power of ten, in seconds: -12, a picosecond."""
    return -12
