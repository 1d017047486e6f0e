"""``cocotb.triggers``."""

from __future__ import annotations

from typing import Any

from .._core import Task
from ..triggers import (
    ClockCycles,
    Combine,
    Edge,
    Event,
    FallingEdge,
    First,
    Lock,
    NextTimeStep,
    NullTrigger,
    ReadOnly,
    ReadWrite,
    RisingEdge,
    SimTimeoutError,
    Timer,
    Trigger,
    ValueChange,
    with_timeout,
)

__all__ = [
    "ClockCycles",
    "Combine",
    "Edge",
    "Event",
    "FallingEdge",
    "First",
    "Join",
    "Lock",
    "NextTimeStep",
    "NullTrigger",
    "ReadOnly",
    "ReadWrite",
    "RisingEdge",
    "SimTimeoutError",
    "Timer",
    "Trigger",
    "ValueChange",
    "gather",
    "with_timeout",
]


def Join(task: Task[Any]) -> Trigger:
    """The end of a task; gives its result."""
    return task.join()


async def gather(*awaitables: object) -> list[object]:
    """Awaits all, and gives their results in order."""
    from .. import start_soon

    tasks = [item if isinstance(item, (Task, Trigger)) else start_soon(item) for item in awaitables]
    await Combine(*tasks)
    return [item.result() if isinstance(item, Task) else item for item in tasks]
