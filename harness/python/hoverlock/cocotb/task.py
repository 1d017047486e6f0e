"""``cocotb.task``, by cocotb 2's name."""

from .._core import Task
from ..errors import CancelledError
from .triggers import Join

__all__ = ["CancelledError", "Join", "Task"]
