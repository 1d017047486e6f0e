"""Test benches for Verilog as coroutines, as in cocotb, on Verilator in the same process.

>>> import hoverlock
>>> from hoverlock import Clock, ClockCycles, Design
>>>
>>> design = Design("counter.v", top="counter")
>>>
>>> @hoverlock.test()
... async def counts(dut):
...     Clock(dut.clk, 10, "ns").start()
...     dut.enable.value = 1
...     await ClockCycles(dut.clk, 10)
...     assert dut.count.value == 9

Run it with ``pytest``, or with ``python -m hoverlock test_counter.py``.
"""

from __future__ import annotations

from . import as_cocotb
from ._core import ArrayHandle, Bits, Coverage, Element, Handle, Library, RealHandle, Task, TextHandle, Value, start_soon
from .clock import Clock
from .design import Design
from .errors import (
    BuildError,
    CancelledError,
    DeadlockError,
    HoverlockError,
    NoSuchSignal,
    NotForceable,
    NotWritable,
    ProtocolError,
    RangeError,
    ReadOnlyError,
    SimTimeoutError,
    SimulationError,
    TriggerError,
    VerilogError,
    VerilogFinished,
)
from .hierarchy import Constant, Hierarchy, TypedHierarchy
from .outputs import Outputs
from .queue import LifoQueue, PriorityQueue, Queue, QueueEmpty, QueueFull
from .session import Session, running, simulate
from .tasks import start
from .testing import Test, parametrize, pass_test, test
from .transfer import TransferReport
from .triggers import (
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
    Timer,
    Trigger,
    ValueChange,
    VerilogFinish,
    with_timeout,
)
from .utils import get_sim_time
from .writes import Force, Freeze, Release

__all__ = [
    "ArrayHandle",
    "Bits",
    "BuildError",
    "CancelledError",
    "Clock",
    "ClockCycles",
    "Combine",
    "Constant",
    "Coverage",
    "DeadlockError",
    "Design",
    "Edge",
    "Element",
    "Event",
    "FallingEdge",
    "First",
    "Force",
    "Freeze",
    "Handle",
    "Hierarchy",
    "HoverlockError",
    "Library",
    "LifoQueue",
    "Lock",
    "NextTimeStep",
    "NoSuchSignal",
    "NotForceable",
    "NotWritable",
    "NullTrigger",
    "Outputs",
    "PriorityQueue",
    "ProtocolError",
    "Queue",
    "QueueEmpty",
    "QueueFull",
    "RangeError",
    "RealHandle",
    "ReadOnly",
    "ReadOnlyError",
    "ReadWrite",
    "Release",
    "RisingEdge",
    "Session",
    "SimTimeoutError",
    "SimulationError",
    "Task",
    "Test",
    "TextHandle",
    "Timer",
    "TransferReport",
    "Trigger",
    "TriggerError",
    "TypedHierarchy",
    "Value",
    "ValueChange",
    "VerilogError",
    "VerilogFinish",
    "VerilogFinished",
    "get_sim_time",
    "parametrize",
    "pass_test",
    "running",
    "simulate",
    "start",
    "start_soon",
    "test",
    "with_timeout",
]
