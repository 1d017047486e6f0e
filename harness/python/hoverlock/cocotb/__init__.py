"""The names of cocotb, for benches that were written for it: import from here instead.

>>> import hoverlock.cocotb as cocotb
>>> from hoverlock.cocotb.clock import Clock
>>> from hoverlock.cocotb.triggers import RisingEdge

"Coming from cocotb" lists what differs, and why.
"""

from __future__ import annotations

import random
from typing import Any

from .. import log as _log
from .._core import start_soon
from ..deprecated import advise as _advise
from ..session import running, running_or_loading
from ..tasks import start as _start
from ..testing import parametrize, pass_test
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
from .._core import create_task
from ._bridge import bridge as external
from ._bridge import resume as function
from .decorators import coroutine, skipif, test, xfail

__all__ = [
    "LANGUAGE",
    "binary",
    "clock",
    "coroutine",
    "create_task",
    "decorators",
    "end_test",
    "external",
    "fork",
    "function",
    "handle",
    "is_simulation",
    "log",
    "parameterize",
    "parametrize",
    "pass_test",
    "queue",
    "random",
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

__version__ = "2.1.0"
"""The version of cocotb whose names these are."""

# Whether `import cocotb` imports this module: then the names of a run exist only while there is a run.
_alias = False

log = _log.log
fork = start_soon
parameterize = parametrize
end_test = pass_test
is_simulation = True
LANGUAGE = "verilog"


def start(coro: Any) -> Any:
    """Starts a coroutine as a task and lets it run to its first wait before the caller continues.

    >>> task = await cocotb.start(drive(dut))
    """
    _advise("start")
    return _start(coro)


def __getattr__(name: str) -> Any:
    # Properties of the run.
    if name in ("SIM_NAME", "SIM_VERSION", "top"):
        now = running_or_loading()
        if name == "top" and (now is not None or _alias):
            return now and now.dut
        if name != "top":
            return {"SIM_NAME": "Verilator", "SIM_VERSION": "5"}[name] if now is not None or not _alias else None
    # Properties of the running test.
    if name in ("top", "RANDOM_SEED", "random_seed", "plusargs", "argv"):
        now = running_or_loading()
        if name == "top":
            return running().dut
        if name in ("RANDOM_SEED", "random_seed"):
            return None if now is None else now.seed
        if now is None:
            return [] if name == "argv" else {}
        if name == "argv":
            return list(now.plusargs)
        pairs = (text.lstrip("+").partition("=") for text in now.plusargs)
        return {key: value if equals else True for key, equals, value in pairs}
    raise AttributeError(f"hoverlock.cocotb has no '{name}'; see 'Coming from cocotb'")
