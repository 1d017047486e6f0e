"""``cocotb.log`` and ``cocotb.logging``.

>>> log = SimLog("cocotb.tb")
>>> log.info("begins")
"""

from __future__ import annotations

import logging
import sys
from typing import Any

from .. import _core
from ..log import SimTimeFormatter, default_config, sim_time_text

__all__ = [
    "ANSI",
    "SimColourLogFormatter",
    "SimLog",
    "SimLogFormatter",
    "SimTimeContextFilter",
    "default_config",
    "strip_ansi",
]

# cocotb 2's level below DEBUG.
TRACE = 5
logging.addLevelName(TRACE, "TRACE")
logging.TRACE = TRACE  # type: ignore[attr-defined]


class ANSI:
    """Escape sequences for colours; the log here has none."""

    BLACK_FG, RED_FG, GREEN_FG, YELLOW_FG, BLUE_FG, MAGENTA_FG, CYAN_FG, WHITE_FG = (f"\33[3{n}m" for n in range(8))
    BLACK_BG, RED_BG, GREEN_BG, YELLOW_BG, BLUE_BG, MAGENTA_BG, CYAN_BG, WHITE_BG = (f"\33[4{n}m" for n in range(8))
    (
        BRIGHT_BLACK_FG, BRIGHT_RED_FG, BRIGHT_GREEN_FG, BRIGHT_YELLOW_FG,
        BRIGHT_BLUE_FG, BRIGHT_MAGENTA_FG, BRIGHT_CYAN_FG, BRIGHT_WHITE_FG,
    ) = (f"\33[9{n}m" for n in range(8))  # fmt: skip
    DEFAULT_FG, DEFAULT_BG, DEFAULT = "\33[39m", "\33[49m", "\33[0m"


def strip_ansi(text: str) -> str:
    """Returns the text without escape sequences for colours."""
    import re

    return re.sub(r"\x1b\[[0-9;]*m", "", text)


class SimLogFormatter(SimTimeFormatter):
    """`hoverlock.log.SimTimeFormatter` with cocotb's arguments, which select prefixes and colours there, and have no effect."""

    def __init__(self, *_arguments: Any, **_options: Any) -> None:
        super().__init__()


SimColourLogFormatter = SimLogFormatter


class SimTimeContextFilter(logging.Filter):
    """A filter that keeps all records and gives each the time in steps of 1 ps, as ``created_sim_time``."""

    def filter(self, record: logging.LogRecord) -> bool:
        now = _core.now()
        record.created_sim_time = now // 1000
        record.sim_time = sim_time_text(now)
        return True


def SimLog(name: str, ident: int | None = None) -> logging.Logger:
    """A logger."""
    return logging.getLogger(name if ident is None else f"{name}.0x{ident:x}")


def want_color_output() -> bool:
    """Returns whether the error output is a terminal."""
    return sys.stderr.isatty()
