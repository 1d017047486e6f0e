"""``cocotb.logging``, by cocotb 2's name."""

from .log import ANSI, SimColourLogFormatter, SimLog, SimLogFormatter, SimTimeContextFilter, default_config, strip_ansi

__all__ = [
    "ANSI",
    "SimColourLogFormatter",
    "SimLog",
    "SimLogFormatter",
    "SimTimeContextFilter",
    "default_config",
    "strip_ansi",
]
