"""``cocotb.logging``, by cocotb 2's name."""

from .log import SimLog, SimLogFormatter, default_config

__all__ = ["SimLog", "SimLogFormatter", "default_config"]
