"""``cocotb.types.range``, by cocotb 1's name."""

from . import Range

__all__ = ["Range"]
