"""The exceptions of the harness."""

from __future__ import annotations


class HoverlockError(Exception):
    """Any error of the harness."""


class BuildError(HoverlockError):
    """The design does not build; the message has Verilator's messages with file and line."""


class NoSuchSignal(HoverlockError, AttributeError):
    """The design has no accessible signal of that name; the message has the nearest names."""


class RangeError(HoverlockError, OverflowError, ValueError):
    """A value does not fit its signal."""


class NotWritable(HoverlockError):
    """A write to an output of the design."""


class ReadOnlyError(HoverlockError):
    """A write in ``ReadOnly``, where values do not change any more."""


class TriggerError(HoverlockError):
    """A trigger was awaited where it cannot come."""


class SimulationError(HoverlockError):
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


class TestSuccess(Exception):
    """Raised by ``pass_test``: ends the test; it passes."""

    __test__ = False
