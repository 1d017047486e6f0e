"""Clocks, driven by the engine without a Python task."""

from __future__ import annotations

from . import _core
from ._core import Handle
from .triggers import FallingEdge, RisingEdge

__all__ = ["Clock"]


class Clock:
    """A clock on an input of the design.

    Parameters
    ----------
    signal : Handle
        The input.
    period : float
        The period, in ``unit`` (``fs``, ``ps``, ``ns``, ``us``, ``ms``, ``sec`` or ``step``, 1 ps).
    units : str, optional
        The unit by cocotb 1's name.
    high : float, optional
        Time in each period for which the clock is high, in ``unit``. Default: half of the period.

    Raises
    ------
    ValueError
        If the clock is high or low for less than 1 fs.

    >>> Clock(dut.clk, 10, "ns").start()
    >>> Clock(dut.slow, 25, "ns").start(phase=(5, "ns"))
    """

    # `start_soon` returns a clock unchanged: benches for cocotb 1 start clocks in this way.
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
        """The frequency in MHz."""
        return 1e9 / (self._high + self._low)

    def start(self, start_high: bool = True, *, phase: tuple[float, str] | None = None) -> Clock:
        """Starts the clock and returns it. ``start_soon(Clock(...).start())``, as in cocotb 1, works too.

        Parameters
        ----------
        start_high : bool
            Whether the clock starts with the rising edge, now; otherwise the rising edge comes after the low half.
        phase : tuple of float and str, optional
            Time from now to the first rising edge, with its unit.
        """
        delay = 0 if start_high else self._low
        if phase is not None:
            delay = _core.femtoseconds(*phase)
        self.stop()
        self._running = _core.start_clock(self.signal, self._high, self._low, delay)
        return self

    def stop(self) -> None:
        """Stops the clock at its level."""
        if self._running is not None:
            self._running.stop()
            self._running = None

    # In cocotb a running clock is a task, so it has the methods of a task.
    kill = cancel = stop

    def done(self) -> bool:
        """Returns whether the clock is stopped."""
        return self._running is None

    async def cycles(self, num_cycles: int, rising: bool = True) -> None:
        """Waits for ``num_cycles`` rising (or falling) edges."""
        edge = RisingEdge(self.signal) if rising else FallingEdge(self.signal)
        for _ in range(num_cycles):
            await edge

    def __repr__(self) -> str:
        return f"<Clock {self.signal._name} {self.period} {self.unit}>"
