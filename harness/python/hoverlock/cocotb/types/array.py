"""``cocotb.types.array``, by cocotb 1's name."""

from . import Array, Range

__all__ = ["Array", "Range"]
