"""Logging with simulation time, for benches and for the lines that the Verilog prints.

>>> dut._log.info("frame %d sent", n)
"""

from __future__ import annotations

import logging
import sys
from collections.abc import Mapping
from typing import Any

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


class _Handler(logging.StreamHandler):  # type: ignore[type-arg]  # not generic when it runs
    """The handler of the run's log."""

    def write_line(self, level: int, name: str, message: object, arguments: Any) -> None:
        """Writes what the handler writes of a record with this content."""
        text = str(message)
        if arguments:
            # As in `LogRecord`: one dictionary has the values of `%(name)s`.
            single = len(arguments) == 1 and arguments[0] and isinstance(arguments[0], Mapping)
            text %= arguments[0] if single else arguments
        line = f"{sim_time_text(_core.now()):>14} {logging.getLevelName(level):<8} {name:<20} {text}\n"
        self.acquire()
        try:
            self.stream.write(line)
            self.flush()
        finally:
            self.release()


class _Logger(logging.Logger):
    """A logger that writes a line without making a record, if the run's log alone reads it. A record also has the caller, the
    thread and the process, which that log does not show and which take most of the time."""

    def _only_reader(self) -> _Handler | None:
        """Returns the handler of the run's log, unless a filter or another handler, formatter or kind of record is in use."""
        reader: logging.Handler | None = None
        logger: logging.Logger | None = self
        while logger is not None:
            if logger.handlers:
                if reader is not None or len(logger.handlers) > 1:
                    return None
                reader = logger.handlers[0]
            logger = logger.parent if logger.propagate else None
        if not isinstance(reader, _Handler) or reader.filters or self.filters or self.disabled:
            return None
        formatter = reader.formatter
        plain = isinstance(formatter, SimTimeFormatter) and type(formatter).format is SimTimeFormatter.format
        return reader if plain and logging.getLogRecordFactory() is logging.LogRecord else None

    def _log(
        self, level: int, msg: object, args: Any, exc_info: Any = None, extra: Mapping[str, object] | None = None,
        stack_info: bool = False, stacklevel: int = 1,
    ) -> None:  # fmt: skip
        reader = None if exc_info or extra or stack_info else self._only_reader()
        if reader is not None:
            if level < reader.level:
                return
            try:
                return reader.write_line(level, self.name, msg, args)
            except Exception:  # reported as for any other handler
                pass
        # One level more: the caller is not this function.
        super()._log(level, msg, args, exc_info, extra, stack_info, stacklevel + 1)


def sim_time_text(femtoseconds: int) -> str:
    """Returns a time in nanoseconds, as text: ``12.5ns``."""
    return f"{femtoseconds / 1e6:.15g}ns"


def default_config(level: int = logging.INFO) -> None:
    """Sends the log to stderr, for the runner and scripts; pytest captures the log itself.

    >>> default_config(logging.DEBUG)
    """
    logging.setLoggerClass(_Logger)
    # Packages written for cocotb use loggers below the name `cocotb`.
    for logger in (log, logging.getLogger("cocotb")):
        if not logger.handlers:
            handler = _Handler(sys.stderr)
            handler.setFormatter(SimTimeFormatter())
            logger.addHandler(handler)
            logger.propagate = False
        logger.setLevel(level)


def listener(time: int, level: int, source: str, text: str) -> None:
    """Logs a line of the engine."""
    logger = log.getChild(source)
    if logger.isEnabledFor(level):
        logger.log(level, "%s", text, extra={"sim_time": sim_time_text(time)})
