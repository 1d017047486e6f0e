"""Triggers: what a coroutine can await.

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


class Event(RawEvent):
    """A flag that tasks can wait for. It stays set until it is cleared.

    >>> done = Event()
    >>> done.set()          # in one task
    >>> await done.wait()   # in another
    """

    def __init__(self, name: str = "event") -> None:
        self.name = name

    def _set_with_data(self) -> None:
        """Is called before the event is set with data."""

    def __repr__(self) -> str:
        return f"<Event '{self.name}' {'set' if self.is_set() else 'not set'}>"


class Lock:
    """A lock that one task holds at a time. Waiting tasks get it in the order of their calls.

    >>> async with lock:
    ...     await write(dut, 1, 2)
    """

    def __init__(self, name: str = "lock") -> None:
        self.name = name
        self._raw = RawLock(name)

    def acquire(self) -> Trigger:
        """Returns a trigger that fires when the task holds the lock. ``release`` must follow."""
        return self._raw.acquire()

    def release(self) -> None:
        """Releases the lock: the task that has waited longest gets it.

        Raises
        ------
        TriggerError
            If no task has the lock.
        """
        self._raw.release()

    def locked(self) -> bool:
        """Returns whether a task holds the lock."""
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
    trigger: Any, timeout_time: float, timeout_unit: str = "step", *, timeout_units: str | None = None, round_mode: str | None = None
) -> Any:
    """Awaits a trigger, task or coroutine for a limited time, and returns what ``await`` gives for it.

    Parameters
    ----------
    trigger : Trigger, Task or coroutine
        What to await.
    timeout_time : float
        The limit of simulation time, in ``timeout_unit`` (``fs``, ``ps``, ``ns``, ``us``, ``ms``, ``sec`` or ``step``, 1 ps).
    timeout_units : str, optional
        The unit by cocotb 1's name.
    round_mode : str, optional
        How a limit between two steps of 1 ps is rounded, as by ``Timer``.

    Raises
    ------
    SimTimeoutError
        If the time is over first. A coroutine is cancelled then, and if the caller is; a task keeps running.

    >>> await with_timeout(receive(dut), 10, "us")
    """
    fired = await first_within(trigger, timeout_time, timeout_units or timeout_unit, round_mode)
    return None if fired is trigger else fired


async def first_within(trigger: Any, time: float, unit: str, round_mode: str | None) -> Any:
    """Awaits the same as ``with_timeout``, and returns what ``First`` gives for it: of a trigger without a result, the trigger."""
    timer = Timer(time, unit, round_mode=round_mode)
    is_coroutine = not isinstance(trigger, (Trigger, Task))
    waited = start_soon(trigger) if is_coroutine else trigger
    try:
        fired = await First(waited, timer)
    finally:
        if is_coroutine:
            waited.cancel()
    if fired is timer:
        raise SimTimeoutError(f"{trigger!r} did not come within {time} {unit}")
    return fired
