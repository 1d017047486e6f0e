"""Bus models written in Rust: they run at the edges of a clock, without a Python task, and check the protocol.

>>> source = AvalonSource(dut, "in_", dut.clk, reset=dut.rst)
>>> sink = AvalonSink(dut, "out_", dut.clk, reset=dut.rst)
>>> sink.pause(0.25, seed=3)
>>> source.send(np.arange(100, dtype=np.uint8))
>>> frame = await sink.recv()
"""

from __future__ import annotations

from .memory_mapped import AvalonMaster, AvalonMemory, AxiChecker, AxiLiteMaster, AxiLiteMemory, AxiMaster, AxiMemory
from .stream import AvalonMonitor, AvalonSink, AvalonSource, AxiMonitor, AxiSink, AxiSource, Frame

__all__ = [
    "AvalonMaster",
    "AvalonMemory",
    "AvalonMonitor",
    "AvalonSink",
    "AvalonSource",
    "AxiChecker",
    "AxiLiteMaster",
    "AxiLiteMemory",
    "AxiMaster",
    "AxiMemory",
    "AxiMonitor",
    "AxiSink",
    "AxiSource",
    "Frame",
]
