"""``cocotb.types.logic_array``, by cocotb 1's name."""

from . import Logic, LogicArray, Range

__all__ = ["Logic", "LogicArray", "Range"]
