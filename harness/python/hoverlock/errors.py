"""The exceptions of the harness."""

from __future__ import annotations

import sys


class HoverlockError(Exception):
    """Any error of the harness."""


class BuildError(HoverlockError):
    """The design does not build; the message has Verilator's messages with file and line."""


class NoSuchSignal(HoverlockError, AttributeError):
    """The design has no accessible signal of that name; the message has the nearest names."""


class RangeError(HoverlockError, OverflowError, ValueError):
    """A value does not fit its signal."""


class NotWritable(HoverlockError):
    """A write to an output of the design, or to an ``inout`` that this Verilator does not let a bench drive."""


class NotForceable(HoverlockError):
    """A ``Force`` of a signal that was not made forceable; the message says how to ask for it."""


class ReadOnlyError(HoverlockError, RuntimeError):
    """A write in ``ReadOnly``, where values no longer change."""


class TriggerError(HoverlockError, RuntimeError):
    """A trigger was awaited in a region in which it cannot fire."""


class SimulationError(HoverlockError, RuntimeError):
    """The simulation ended before the bench did."""


class DeadlockError(SimulationError):
    """No event can occur any more; the message says what each task waits for."""


class SimTimeoutError(SimulationError, TimeoutError):
    """A limit was reached: simulation time, ``with_timeout``, or wall-clock time."""


class VerilogError(SimulationError):
    """``$error``, ``$fatal``, ``$stop`` or a failed assertion in the Verilog."""


class VerilogFinished(SimulationError):
    """``$finish`` in the Verilog before the bench was done."""


class ProtocolError(SimulationError):
    """A bus rule was broken; the message names rule and simulation time."""


class CancelledError(HoverlockError):
    """A task that was waited for was cancelled."""


def cancelled(text: str) -> CancelledError:
    """Returns the error of a wait for a cancelled task. If the bench has imported ``asyncio``, it is also an
    ``asyncio.CancelledError``."""
    own = _asyncio_class()
    if own is None:
        return CancelledError(text)
    both: type[CancelledError] = type("CancelledError", (CancelledError, own), {"__doc__": CancelledError.__doc__})
    return both(text)


def asyncio_cancelled() -> BaseException | None:
    """Returns the exception to raise in a cancelled task, an ``asyncio.CancelledError``; None if asyncio was not imported."""
    own = _asyncio_class()
    return None if own is None else own()


def is_own_end(error: BaseException) -> bool:
    """Returns whether the exception ends the task in which it is raised because that task is cancelled, rather than one that it
    waited for."""
    own = _asyncio_class()
    cancelled_here = own is not None and isinstance(error, own) and not isinstance(error, CancelledError)
    return cancelled_here or isinstance(error, GeneratorExit)


def _asyncio_class() -> type[BaseException] | None:
    module = sys.modules.get("asyncio")
    return getattr(module, "CancelledError", None)


class TestSuccess(Exception):
    """Raised by ``pass_test``: ends the test; it passes."""

    __test__ = False
