"""``cocotb.clock``.

>>> cocotb.start_soon(Clock(dut.clk, 10, units="ns").start(start_high=False))
"""

from __future__ import annotations

from typing import Any

from .. import clock as _clock
from .._core import Handle
from ..triggers import Timer

__all__ = ["Clock", "Timer"]


class Clock(_clock.Clock):
    """The engine's clock with cocotb's arguments."""

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
        super().__init__(signal, float(period) if not isinstance(period, int) else period, unit, units=units, high=period_high)

    def start(  # type: ignore[override]
        self, cycles: int | None = None, start_high: bool = True, *, phase: tuple[float, str] | None = None
    ) -> Clock:
        """Starts it, for so many cycles if told; ``start_soon`` and ``await cocotb.start`` take what it gives."""
        if isinstance(cycles, bool):  # the first argument of hoverlock's own
            return self.start(start_high=cycles, phase=phase)
        super().start(start_high, phase=phase)
        if cycles is not None:
            from .. import start_soon

            start_soon(self._stop_after(cycles))
        return self

    async def _stop_after(self, cycles: int) -> None:
        await self.cycles(cycles, rising=False)
        self.stop()
