"""Logging with simulation time, for benches and for the lines that the Verilog prints.

>>> dut._log.info("frame %d sent", n)
"""

from __future__ import annotations

import logging
import sys

from . import _core

__all__ = ["SimTimeFormatter", "default_config", "log"]

log = logging.getLogger("hoverlock")


class SimTimeFormatter(logging.Formatter):
    """A formatter that puts simulation time, level and source before each line.

    >>> handler.setFormatter(SimTimeFormatter())
    """

    def __init__(self) -> None:
        super().__init__("%(sim_time)14s %(levelname)-8s %(name)-20s %(message)s")

    def format(self, record: logging.LogRecord) -> str:
        if not hasattr(record, "sim_time"):
            record.sim_time = sim_time_text(_core.now())
        return super().format(record)


def sim_time_text(femtoseconds: int) -> str:
    """Returns a time in nanoseconds, as text: ``12.5ns``."""
    return f"{femtoseconds / 1e6:.15g}ns"


def default_config(level: int = logging.INFO) -> None:
    """Sends the log to stderr, for the runner and scripts; pytest captures the log itself.

    >>> default_config(logging.DEBUG)
    """
    # Packages written for cocotb use loggers below the name `cocotb`.
    for logger in (log, logging.getLogger("cocotb")):
        if not logger.handlers:
            handler = logging.StreamHandler(sys.stderr)
            handler.setFormatter(SimTimeFormatter())
            logger.addHandler(handler)
            logger.propagate = False
        logger.setLevel(level)


def listener(time: int, level: int, source: str, text: str) -> None:
    """Logs a line of the engine."""
    logger = log.getChild(source)
    if logger.isEnabledFor(level):
        logger.log(level, "%s", text, extra={"sim_time": sim_time_text(time)})
