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
    """A write in ``ReadOnly``, where values do not change any more."""


class TriggerError(HoverlockError, RuntimeError):
    """A trigger was awaited where it cannot come."""


class SimulationError(HoverlockError, RuntimeError):
    """The simulation ended before the bench did."""


class DeadlockError(SimulationError):
    """No event can come any more; the message says what each task waits for."""


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
    """The error of a wait for a cancelled task. A bench that has imported ``asyncio`` may catch it by that name too."""
    own = _asyncio_class()
    if own is None:
        return CancelledError(text)
    both: type[CancelledError] = type("CancelledError", (CancelledError, own), {"__doc__": CancelledError.__doc__})
    return both(text)


def asyncio_cancelled() -> BaseException | None:
    """What is raised in a task that is cancelled, for ``except asyncio.CancelledError``; None if nobody imported it."""
    own = _asyncio_class()
    return None if own is None else own()


def _asyncio_class() -> type[BaseException] | None:
    module = sys.modules.get("asyncio")
    return getattr(module, "CancelledError", None)


class TestSuccess(Exception):
    """Raised by ``pass_test``: ends the test; it passes."""

    __test__ = False
