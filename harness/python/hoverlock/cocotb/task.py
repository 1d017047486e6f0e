"""``cocotb.task``, by cocotb 2's name."""

from .._core import Task, current_task
from ..errors import CancelledError
from ._bridge import bridge, resume
from .triggers import Join, TaskComplete

__all__ = ["CancelledError", "Join", "Task", "TaskComplete", "bridge", "current_task", "resume"]
