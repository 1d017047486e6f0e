"""``cocotb.triggers``.

>>> await RisingEdge(dut.clk)
>>> await First(Timer(10, units="us"), task.join())
"""

from __future__ import annotations

from typing import Any

from .. import triggers as _triggers
from .._core import Task, start_soon
from ..deprecated import advise
from ..errors import TriggerError
from ..triggers import (
    ClockCycles,
    Combine,
    Edge,
    FallingEdge,
    First,
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
    "TaskComplete",
    "Timer",
    "Trigger",
    "TriggerException",
    "ValueChange",
    "Waitable",
    "gather",
    "select",
    "with_timeout",
]

TriggerException = TriggerError
Waitable = GPITrigger = PythonTrigger = Trigger


class Event(_triggers.Event):
    """`hoverlock.Event` with cocotb's attributes."""

    def __init__(self, name: str | None = None) -> None:
        if name is not None:
            advise("Event(name)")
        super().__init__(name or "event")

    def _set_with_data(self) -> None:
        advise("Event.set(data)")

    @property
    def fired(self) -> bool:
        """The same as ``is_set()``, by cocotb 1's name."""
        return self.is_set()


class _Locked(int):
    """The state of a lock: an attribute in cocotb 1, a method in cocotb 2."""

    def __call__(self) -> bool:
        return bool(self)


class Lock(_triggers.Lock):
    """`hoverlock.Lock` with cocotb's attributes."""

    def __init__(self, name: str | None = None) -> None:
        if name is not None:
            advise("Lock(name)")
        super().__init__(name or "lock")

    @property
    def locked(self) -> Any:
        """Whether a task holds the lock; can be called too."""
        return _Locked(self._raw.locked())


def Join(task: Task[Any]) -> Trigger:
    """Returns a trigger for the end of a task; its result is that of the task."""
    advise("Join")
    return task.complete


def TaskComplete(task: Task[Any]) -> Trigger:
    """Returns a trigger for the end of a task (cocotb 2's name)."""
    return task.complete


async def gather(*awaitables: object, return_exceptions: bool = False) -> tuple[object, ...]:
    """Awaits all, and returns their results in order; the result of a trigger is the trigger.

    >>> a, b = await gather(read(0), read(1))
    """
    async def end_of(item: Any) -> tuple[object, Exception | None]:
        try:
            given = await item
        except Exception as error:
            return None, error
        return item if given is None and isinstance(item, Trigger) else given, None

    ends = [await task for task in [start_soon(end_of(item)) for item in awaitables]]
    for _, error in ends:
        if error is not None and not return_exceptions:
            raise error
    return tuple(given if error is None else error for given, error in ends)


async def select(*awaitables: object) -> tuple[int, Any]:
    """Awaits the first, and returns its index and its result; the others are cancelled.

    >>> which, _ = await select(RisingEdge(dut.done), Timer(1, "us"))
    """
    async def numbered(at: int, item: Any) -> tuple[int, Any]:
        given = await item
        return at, item if given is None and isinstance(item, Trigger) else given

    tasks = [start_soon(numbered(at, item)) for at, item in enumerate(awaitables)]
    came: tuple[int, Any] = await First(*tasks)
    for task in tasks:
        task.cancel()
    return came
