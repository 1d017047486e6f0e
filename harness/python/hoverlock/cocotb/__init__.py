"""cocotb's names, for benches written for it: change the imports and run them.

>>> import hoverlock.cocotb as cocotb
>>> from hoverlock.cocotb.clock import Clock
>>> from hoverlock.cocotb.triggers import RisingEdge

What differs, and why, stands in "Coming from cocotb".
"""

from __future__ import annotations

from typing import Any

from .. import parametrize, pass_test, running, start, start_soon, test
from ..log import log
from . import clock, handle, queue, regression, result, triggers, types, utils

__all__ = [
    "clock",
    "coroutine",
    "create_task",
    "fork",
    "handle",
    "log",
    "parametrize",
    "pass_test",
    "queue",
    "regression",
    "result",
    "start",
    "start_soon",
    "test",
    "triggers",
    "types",
    "utils",
]

create_task = start_soon
fork = start_soon
SIM_NAME = "Verilator"


def coroutine(function: Any) -> Any:
    """cocotb 1's decorator, which does nothing to an ``async def``."""
    return function


def __getattr__(name: str) -> Any:
    # What belongs to the test that runs.
    if name in ("top", "RANDOM_SEED", "plusargs"):
        now = running()
        if name == "top":
            return now.dut
        if name == "RANDOM_SEED":
            return now.seed
        pairs = (text.lstrip("+").partition("=") for text in now.plusargs)
        return {key: value if equals else True for key, equals, value in pairs}
    raise AttributeError(f"hoverlock.cocotb has no '{name}'; see 'Coming from cocotb'")
