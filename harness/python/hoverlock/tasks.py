"""Tasks of a bench."""

from __future__ import annotations

from typing import Any

from ._core import Task, start_soon
from .triggers import NullTrigger

__all__ = ["start"]


async def start(coro: Any) -> Task[Any]:
    """Starts a coroutine as a task and lets it run to its first wait before the caller continues.

    >>> task = await hoverlock.start(drive(dut))
    """
    task: Task[Any] = start_soon(coro)
    await NullTrigger()
    return task
