"""``cocotb.log`` and ``cocotb.logging``.

>>> log = SimLog("cocotb.tb")
>>> log.info("begins")
"""

from __future__ import annotations

import logging

from ..log import SimTimeFormatter, default_config

__all__ = ["SimLog", "SimLogFormatter", "default_config"]

SimLogFormatter = SimTimeFormatter


def SimLog(name: str, ident: int | None = None) -> logging.Logger:
    """A logger."""
    return logging.getLogger(name if ident is None else f"{name}.0x{ident:x}")
