"""The names of cocotb, for benches that were written for it: import from here instead.

>>> import hoverlock.cocotb as cocotb
>>> from hoverlock.cocotb.clock import Clock
>>> from hoverlock.cocotb.triggers import RisingEdge

"Coming from cocotb" lists what differs, and why.
"""

from __future__ import annotations

from typing import Any

from .. import parametrize, pass_test, running, start, start_soon
from .. import log as _log
from . import (
    binary,
    clock,
    decorators,
    handle,
    queue,
    regression,
    result,
    simtime,
    simulator,
    task,
    triggers,
    types,
    utils,
)
from . import log as _log_module  # noqa: F401  (so that the name below stays the logger)
from .decorators import coroutine, skipif, test, xfail

__all__ = [
    "LANGUAGE",
    "SIM_NAME",
    "SIM_VERSION",
    "binary",
    "clock",
    "coroutine",
    "create_task",
    "decorators",
    "fork",
    "handle",
    "is_simulation",
    "log",
    "parameterize",
    "parametrize",
    "pass_test",
    "queue",
    "regression",
    "result",
    "simtime",
    "simulator",
    "skipif",
    "start",
    "start_soon",
    "task",
    "test",
    "triggers",
    "types",
    "utils",
    "xfail",
]

__version__ = "2.0.0"
"""The version of cocotb whose names these are."""

log = _log.log
create_task = start_soon
fork = start_soon
parameterize = parametrize
is_simulation = True
LANGUAGE = "verilog"
SIM_NAME = "Verilator"
SIM_VERSION = "5"


def __getattr__(name: str) -> Any:
    # Properties of the running test.
    if name in ("top", "RANDOM_SEED", "random_seed", "plusargs", "argv"):
        now = running()
        if name == "top":
            return now.dut
        if name in ("RANDOM_SEED", "random_seed"):
            return now.seed
        if name == "argv":
            return list(now.plusargs)
        pairs = (text.lstrip("+").partition("=") for text in now.plusargs)
        return {key: value if equals else True for key, equals, value in pairs}
    raise AttributeError(f"hoverlock.cocotb has no '{name}'; see 'Coming from cocotb'")
