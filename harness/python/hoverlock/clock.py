"""Clocks, driven by the engine: no task of Python runs for them."""

from __future__ import annotations

from . import _core
from ._core import Handle
from .triggers import FallingEdge, RisingEdge

__all__ = ["Clock"]


class Clock:
    """A clock on an input of the design.

    >>> Clock(dut.clk, 10, "ns").start()
    >>> Clock(dut.slow, 25, "ns").start(phase=(5, "ns"))
    """

    # `start_soon` gives it back as it is: cocotb 1 starts clocks so.
    _runs_already = True

    def __init__(
        self,
        signal: Handle,
        period: float,
        unit: str = "step",
        *,
        units: str | None = None,
        high: float | None = None,
    ) -> None:
        self.signal = signal
        self.period = period
        self.unit = units or unit
        whole = _core.femtoseconds(period, self.unit)
        self._high = whole // 2 if high is None else _core.femtoseconds(high, self.unit)
        self._low = whole - self._high
        if self._high <= 0 or self._low <= 0:
            raise ValueError(f"a clock of {period} {self.unit}: each half must last 1 fs at least")
        self._running: _core.RunningClock | None = None

    @property
    def frequency(self) -> float:
        """In MHz."""
        return 1e9 / (self._high + self._low)

    def start(self, start_high: bool = True, *, phase: tuple[float, str] | None = None) -> Clock:
        """Starts it now, with its rising edge first, or after a phase; gives the clock, which ``stop`` stops.

        What cocotb 1 writes, ``start_soon(Clock(...).start())``, works as well.
        """
        delay = 0 if start_high else self._low
        if phase is not None:
            delay = _core.femtoseconds(*phase)
        self.stop()
        self._running = _core.start_clock(self.signal, self._high, self._low, delay)
        return self

    def stop(self) -> None:
        """Stops it at its level."""
        if self._running is not None:
            self._running.stop()
            self._running = None

    # A running clock may be handled as the task it is in cocotb.
    kill = cancel = stop

    def done(self) -> bool:
        """Whether it stands."""
        return self._running is None

    async def cycles(self, num_cycles: int, rising: bool = True) -> None:
        """Waits for so many cycles."""
        edge = RisingEdge(self.signal) if rising else FallingEdge(self.signal)
        for _ in range(num_cycles):
            await edge

    def __repr__(self) -> str:
        return f"<Clock {self.signal._name} {self.period} {self.unit}>"
