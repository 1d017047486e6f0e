"""Everything that can go wrong, as exceptions."""

from __future__ import annotations


class HoverlockError(Exception):
    """Any error of the harness."""


class BuildError(HoverlockError):
    """Verilog did not become a model; the text has Verilator's messages with file and line."""


class NoSuchSignal(HoverlockError, AttributeError):
    """The design has no signal of that name; the text has the nearest names."""


class RangeError(HoverlockError, OverflowError, ValueError):
    """A value does not fit its signal."""


class NotWritable(HoverlockError):
    """A write to an output of the design."""


class ReadOnlyError(HoverlockError):
    """A write in ``ReadOnly``, where values are settled for good."""


class TriggerError(HoverlockError):
    """A trigger that cannot come where it is awaited."""


class SimulationError(HoverlockError):
    """The simulation ended before the bench did."""


class DeadlockError(SimulationError):
    """Nothing can happen any more; the text tells what each task waits for."""


class SimTimeoutError(SimulationError, TimeoutError):
    """Time ran out: of the test, of ``with_timeout``, or on the wall."""


class VerilogError(SimulationError):
    """``$error``, ``$fatal``, ``$stop`` or a failed assertion in the Verilog."""


class VerilogFinished(SimulationError):
    """``$finish`` in the Verilog before the bench was done."""


class ProtocolError(SimulationError):
    """A bus did not keep its rules."""


class CancelledError(HoverlockError):
    """A task that was waited for had been cancelled."""


class TestSuccess(Exception):
    """Raised by ``pass_test``: ends the test well."""

    __test__ = False
