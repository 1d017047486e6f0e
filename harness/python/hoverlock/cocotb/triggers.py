"""``cocotb.triggers``.

>>> await RisingEdge(dut.clk)
>>> await First(Timer(10, units="us"), task.join())
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Sequence
from typing import Any

from .. import triggers as _triggers
from .._core import Task, start_soon
from ..deprecated import advise
from ..errors import TriggerError, is_own_end
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
)
from ._outcomes import Error, Value

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
Outcome = Value | Error
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


async def with_timeout(
    trigger: Any, timeout_time: float, timeout_unit: str = "step", *, timeout_units: str | None = None, round_mode: str | None = None
) -> Any:
    """The same as `hoverlock.with_timeout`; the result of a trigger is the trigger, and of `First` the one that fired.

    >>> await with_timeout(RisingEdge(dut.done), 10, "us")
    """
    return await _triggers.first_within(trigger, timeout_time, timeout_units or timeout_unit, round_mode)


async def gather(*awaitables: Any, return_exceptions: bool = False) -> tuple[Any, ...]:
    """Awaits all, and returns their results in order; the result of a trigger is the trigger. The first error cancels the others
    and is raised, unless ``return_exceptions``.

    >>> a, b = await gather(read(0), read(1))
    """

    def is_raised(outcome: Outcome) -> bool:
        return isinstance(outcome, Error) and not (return_exceptions and isinstance(outcome.error, Exception))

    outcomes = await _outcomes(awaitables, is_raised)
    for outcome in outcomes.values():
        if is_raised(outcome):
            outcome.get()
    ends = [outcomes[at] for at in range(len(awaitables))]
    return tuple(end.error if isinstance(end, Error) else end.value for end in ends)


async def select(*awaitables: Any) -> tuple[int, Any]:
    """Awaits the first, and returns its index and its result, or raises its error; the others are cancelled.

    >>> which, _ = await select(RisingEdge(dut.done), Timer(1, "us"))
    """
    if not awaitables:
        raise ValueError("select of nothing")
    outcomes = await _outcomes(awaitables, lambda _: True)
    at, outcome = next(iter(outcomes.items()))
    return at, outcome.get()


async def _outcomes(awaitables: Sequence[Any], ends_all: Callable[[Outcome], bool]) -> dict[int, Outcome]:
    """Awaits all at the same time, until all have ended or one ends with an outcome that ends all. Returns the outcomes by index,
    in the order in which they came.

    The others are cancelled at once, and all are if the caller is; tasks among them keep running.
    """
    outcomes: dict[int, Outcome] = {}
    started: set[int] = set()
    over = _triggers.Event("the end of gather or select")

    async def watch(at: int, item: Any) -> None:
        started.add(at)
        try:
            outcome: Outcome = Value(await (First(item) if isinstance(item, Trigger) else item))
        except BaseException as error:
            if is_own_end(error):
                raise
            outcome = Error(error)
        outcomes[at] = outcome
        if ends_all(outcome) or len(outcomes) == len(awaitables):
            over.set()
            cancel_others()

    def cancel_others() -> None:
        for at, (task, item) in enumerate(zip(tasks, awaitables)):
            if at not in outcomes:
                task.cancel()
            if at not in started and isinstance(item, Coroutine):
                item.close()  # otherwise Python warns that it was never awaited

    tasks = [start_soon(watch(at, item), getattr(item, "__qualname__", None)) for at, item in enumerate(awaitables)]
    try:
        if awaitables:
            await over.wait()
    finally:
        cancel_others()
    return outcomes
