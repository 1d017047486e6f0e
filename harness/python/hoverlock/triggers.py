"""What a coroutine can await.

>>> await RisingEdge(dut.clk)
>>> await ClockCycles(dut.clk, 10)
>>> await Timer(5, "us")
>>> first = await First(RisingEdge(dut.done), Timer(1, "ms"))
"""

from __future__ import annotations

from types import TracebackType
from typing import Any

from ._core import (
    ClockCycles,
    Combine,
    FallingEdge,
    First,
    NextTimeStep,
    NullTrigger,
    RawEvent,
    RawLock,
    ReadOnly,
    ReadWrite,
    RisingEdge,
    Task,
    Timer,
    Trigger,
    ValueChange,
    VerilogFinish,
    start_soon,
)
from .errors import SimTimeoutError

__all__ = [
    "ClockCycles",
    "Combine",
    "Edge",
    "Event",
    "FallingEdge",
    "First",
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
    "VerilogFinish",
    "with_timeout",
]

Edge = ValueChange


class Event:
    """A flag that tasks wait for; it stays set until cleared.

    >>> done = Event()
    >>> done.set()          # in one task
    >>> await done.wait()   # in another
    """

    def __init__(self, name: str = "event") -> None:
        self.name = name
        self.data: Any = None
        self._raw = RawEvent(name)

    def set(self, data: Any = None) -> None:
        """Sets it: all that wait go on."""
        self.data = data
        self._raw.set()

    def clear(self) -> None:
        """Clears it."""
        self._raw.clear()

    def is_set(self) -> bool:
        """Whether it is set."""
        return self._raw.is_set()

    def wait(self) -> Trigger:
        """Until it is set; at once if it is."""
        return self._raw.wait()

    def __repr__(self) -> str:
        return f"<Event '{self.name}' {'set' if self.is_set() else 'not set'}>"


class Lock:
    """What one task has at a time, given in the order of asking.

    >>> async with lock:
    ...     await write(dut, 1, 2)
    """

    def __init__(self, name: str = "lock") -> None:
        self.name = name
        self._raw = RawLock(name)

    def acquire(self) -> Trigger:
        """Until the task has the lock; ``release`` must follow."""
        return self._raw.acquire()

    def release(self) -> None:
        """Gives it to the task that has waited longest."""
        self._raw.release()

    def locked(self) -> bool:
        """Whether a task has it."""
        return self._raw.locked()

    async def __aenter__(self) -> Lock:
        await self.acquire()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        self.release()

    def __repr__(self) -> str:
        return f"<Lock '{self.name}' {'taken' if self.locked() else 'free'}>"


async def with_timeout(
    trigger: Any, timeout_time: float, timeout_unit: str = "step", *, timeout_units: str | None = None
) -> Any:
    """Awaits a trigger, task or coroutine for so long at most, then raises ``SimTimeoutError``.

    A coroutine is cancelled then, a task runs on.

    >>> await with_timeout(receive(dut), 10, "us")
    """
    unit = timeout_units or timeout_unit
    timer = Timer(timeout_time, unit)
    ours = not isinstance(trigger, (Trigger, Task))
    waited = start_soon(trigger) if ours else trigger
    if await First(waited, timer) is timer:
        if ours:
            waited.cancel()
        raise SimTimeoutError(f"{trigger!r} did not come within {timeout_time} {unit}")
    return waited.result() if isinstance(waited, Task) else None
