"""``cocotb.clock``."""

from ..clock import Clock

__all__ = ["Clock"]
