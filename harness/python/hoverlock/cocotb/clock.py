"""``cocotb.clock``.

>>> cocotb.start_soon(Clock(dut.clk, 10, units="ns").start(start_high=False))
"""

from __future__ import annotations

import logging
from typing import Any

from .. import clock as _clock
from .._core import Handle, start_soon
from ..deprecated import advise
from ..triggers import Timer

__all__ = ["BaseClock", "Clock", "Timer"]


class BaseClock:
    """The base of clocks written by a bench."""

    def __init__(self, signal: Handle) -> None:
        self.signal = signal

    @property
    def log(self) -> logging.Logger:
        """A logger with the names of class and signal."""
        return logging.getLogger(f"cocotb.{type(self).__qualname__}.{self.signal._name}")


class Clock(_clock.Clock, BaseClock):
    """`hoverlock.Clock` with cocotb's arguments; ``impl`` and ``set_action`` are ignored."""

    def __init__(
        self,
        signal: Handle,
        period: Any,
        unit: str = "step",
        impl: str | None = None,
        *,
        units: str | None = None,
        period_high: float | None = None,
        set_action: Any = None,
    ) -> None:
        if units is not None:
            advise("Clock(units)")
        super().__init__(signal, float(period) if not isinstance(period, int) else period, unit, units=units, high=period_high)

    def start(  # type: ignore[override]
        self, cycles: int | None = None, start_high: bool = True, *, phase: tuple[float, str] | None = None
    ) -> Clock:
        """Starts the clock, for ``cycles`` cycles if given, and returns it; ``start_soon`` and ``cocotb.start`` accept it."""
        if isinstance(cycles, bool):  # the first argument of hoverlock's own
            return self.start(start_high=cycles, phase=phase)
        super().start(start_high, phase=phase)
        if cycles is not None:
            start_soon(self._stop_after(cycles))
        return self

    async def _stop_after(self, cycles: int) -> None:
        await self.cycles(cycles, rising=False)
        self.stop()
