"""``cocotb.binary``."""

from .types import BinaryValue

__all__ = ["BinaryValue"]
