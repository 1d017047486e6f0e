"""``cocotb.types.logic``, by cocotb 1's name."""

from . import Bit, Logic

__all__ = ["Bit", "Logic"]
