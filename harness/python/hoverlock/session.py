"""Sessions: a fresh model of a design, the benches that run on it, and what runs at the moment.

>>> with Session(design, seed=1) as session:
...     session.run(reset)
"""

from __future__ import annotations

import random
import signal
import threading
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Literal

from . import _core, clean_up, hierarchy, unknown, writes
from .design import Design
from .errors import SimTimeoutError, SimulationError
from .transfer import Pause, TransferOptions, TransferReport

if TYPE_CHECKING:
    import logging

    import numpy as np
    from numpy.typing import NDArray

__all__ = ["Bench", "Running", "Session", "log_of", "running", "running_or_loading", "set_loading", "simulate"]

Bench = Callable[..., Coroutine[Any, Any, Any]]
"""A coroutine function whose first argument is the design."""


class Running:
    """The test that is running."""

    def __init__(
        self, name: str, seed: int, design: Design, dut: hierarchy.Hierarchy, simulation: _core.Simulation
    ) -> None:
        self.name = name
        self.seed = seed
        self.design = design
        self.dut = dut
        self.simulation = simulation
        self.plusargs = list(design.plusargs)


_running: list[Running] = []
# While modules are loaded: the design, and its model once a module has used `cocotb.top`.
_loading: tuple[Design, list[Session]] | None = None


def set_loading(design: Design | None) -> None:
    """Sets the design whose modules are being loaded; None after they are loaded. Benches written for cocotb may use
    `cocotb.top` while they are loaded; a model is created only then."""
    global _loading
    if _loading is not None:
        for session in _loading[1]:
            session.close()
    _loading = None if design is None else (design, [])


def running_or_loading() -> Running | None:
    """Returns the test that is running; while modules are loaded, a model that they can inspect; otherwise None."""
    if _running:
        return _running[-1]
    if _loading is None:
        return None
    design, sessions = _loading
    if not sessions:
        sessions.append(Session(design, name="loading"))
    return sessions[0]._running


def running() -> Running:
    """Returns the test that is running on this thread: its name, seed, design and ``dut``.

    Raises
    ------
    SimulationError
        If no test is running.

    >>> generator = numpy.random.default_rng(running().seed)
    """
    if not _running:
        raise SimulationError("no test is running")
    return _running[-1]


class Session:
    """A fresh model of a design for plain Python: benches run on it one after the other, and whole frames pass through it
    as numpy arrays.

    Parameters
    ----------
    design : Design
        The design. Of a module without ports, such as a testbench in Verilog, all internal signals are accessible.
    seed : int
        Seed of ``random``, of random initial values and of ``$random``.
    name : str
        Name of the benches in messages.

    Raises
    ------
    BuildError
        If the design does not build.

    >>> with Session(design, seed=1) as session:
    ...     session.run(reset)
    ...     out = session.transfer(frame.ravel(), "in_", "out_", clock="clk", stall=0.25)
    """

    def __init__(self, design: Design, *, seed: int = 0, name: str = "bench") -> None:
        self.name = self.label = name
        self.simulation, self.dut = _instance(design, seed)
        if not design.internals and not any(isinstance(child, (_core.Handle, _core.ArrayHandle)) for child in self.dut):
            # A module without ports is a testbench in Verilog: the bench drives its internal signals.
            design = design.changed(internals=("*",))
            self.simulation, self.dut = _instance(design, seed)
        self.simulation.set_log_listener(_listener)
        self._running = Running(name, seed, design, self.dut, self.simulation)
        self._random = random.Random(seed).getstate()
        self._wall_limit: float | None = None  # of the last run
        self.report: TransferReport | None = None
        """Counts of the last transfer; None before the first."""

    def run(
        self,
        bench: Bench,
        *,
        time_limit: int | None = None,
        wall_limit: float | None = None,
        **arguments: Any,
    ) -> Any:
        """Runs ``bench(dut, **arguments)`` and returns its result. Tasks that it started continue in the next run.

        Parameters
        ----------
        bench : coroutine function
            Its first argument is the design.
        time_limit : int, optional
            Limit of simulation time, in femtoseconds.
        wall_limit : float, optional
            Wall-clock limit, in seconds.

        Raises
        ------
        SimTimeoutError, DeadlockError, VerilogError, ProtocolError
            If a limit is reached, no event can occur any more, the Verilog reports an error, or a bus rule is broken.
            Exceptions of the bench are raised unchanged, also those of the clean-up code of a task that it cancels.
        """
        self._wall_limit = wall_limit
        before = random.getstate()
        random.setstate(self._random)
        unknown.begin()
        _running.append(self._running)
        coroutine = bench(self.dut, **arguments)
        try:
            with clean_up.errors_raised(), _alarm(wall_limit):
                return self.simulation.run(coroutine, self.name, time_limit_fs=time_limit, wall_limit=wall_limit)
        finally:
            coroutine.close()
            _running.pop()
            self._random = random.getstate()
            random.setstate(before)

    def run_for(self, time: float, unit: str = "step") -> None:
        """Advances simulation time; clocks and tasks run meanwhile.

        Parameters
        ----------
        time : float
            The span, in ``unit`` (``fs``, ``ps``, ``ns``, ``us``, ``ms``, ``sec`` or ``step``, 1 ps).
        """
        with clean_up.errors_raised():
            self.simulation.run_for(_core.femtoseconds(time, unit))

    def transfer(
        self,
        samples: NDArray[np.unsignedinteger[Any]],
        input: str = "in_",
        output: str = "out_",
        *,
        clock: str = "clk",
        period: tuple[float, str] = (10, "ns"),
        bus: Literal["avalon", "axi"] = "avalon",
        ready_latency: int = 0,
        idle: Pause = None,
        stall: Pause = None,
        seed: int = 0,
        packet: int = 0,
        expect: int | None = None,
        packets: int = 0,
        most_cycles: int = 0,
    ) -> NDArray[np.unsignedinteger[Any]]:
        """Sends an array through a stream of the design, without the scheduler, and returns what comes out.

        Tasks do not run meanwhile. ``report`` has the counts of the transfer.

        Parameters
        ----------
        samples : ndarray of uint8, uint16, uint32 or uint64
            One element for each beat, in C order whatever the shape. The dtype is the smallest that holds the input's
            ``data``. For ``data`` wider than 64 bits: ``uint32``, several elements for each beat, the lowest first.
        input, output : str
            Prefixes of the names of the streams' signals.
        clock : str
            The clock's signal; no other clock may run.
        period : tuple of float and str
            Period of the clock, with its unit.
        bus : "avalon" or "axi"
            Avalon-ST or AXI4-Stream.
        ready_latency : int
            Cycles from ``ready`` to the beat it allows, from 0 to 64; Avalon-ST only.
        idle, stall : float or iterable of bool, optional
            The cycles in which the source offers no new beat, and those in which the sink is not ready: a probability
            from 0 to less than 1, or a pattern (true: pause) that is repeated.
        seed : int
            Seed of both probabilities.
        packet : int
            Beats in each packet sent; 0: all beats are one packet.
        expect : int, optional
            Beats to receive before the transfer ends. Default: as many as are sent, or 0 if ``packets`` is given.
        packets : int
            Packets to receive before the transfer ends, for designs whose packets have no known length.
        most_cycles : int
            Clock cycles after which a transfer that has not ended is an error; 0: 100 000 plus 16 for each beat.

        Returns
        -------
        ndarray, shape (beats,) or (beats, n)
            The smallest unsigned dtype that holds the output's ``data``. For ``data`` wider than 64 bits: ``uint32``, a
            row of n elements for each beat, the lowest first.

        Raises
        ------
        TypeError
            If ``samples`` has another dtype.
        ValueError
            If a pause lets nothing through, or ``bus`` is unknown.
        NoSuchSignal
            If a signal is missing.
        HoverlockError
            If the samples do not fit ``data``, or another clock runs.
        ProtocolError
            If the transfer does not end within ``most_cycles``.
        """
        import numpy as np

        samples = np.ascontiguousarray(samples).reshape(-1)
        options = TransferOptions(
            input=input,
            output=output,
            bus=bus,
            ready_latency=ready_latency,
            clock=clock,
            period=_core.femtoseconds(*period),
            idle=idle,
            stall=stall,
            seed=seed,
            packet=packet,
            expect=expect,
            packets=packets,
            most_cycles=most_cycles,
        )
        received, counts = self.simulation.transfer(samples, options)
        self.report = TransferReport(*counts)
        return received

    def close(self) -> None:
        """Cancels all tasks, runs the Verilog's ``final`` blocks and frees the model. A task that does not end within the
        wall-clock limit of the last run gets an exception. Raises the first exception of the tasks' clean-up code."""
        with clean_up.errors_raised():
            self._close()

    def _close(self) -> None:
        left = self.simulation.living_tasks()
        if left:
            text = ", ".join(left)
            log_of("test").info("%d tasks still ran at the end and are cancelled: %s", len(left), text)
        with _alarm(self._wall_limit):
            lines = self.simulation.close()
        for line in lines:
            log_of("verilog").info("%s", line)

    def __enter__(self) -> Session:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        # An exception of the block comes before those of clean-up code.
        (self.close if kind is None else self._close)()


def log_of(source: str) -> logging.Logger:
    """Returns the logger of a source. Loads `logging`, which takes 8 ms, at the first call only."""
    from .log import log

    return log.getChild(source)


def _listener(time: int, level: int, source: str, text: str) -> None:
    """Logs a line of the engine."""
    from .log import listener

    listener(time, level, source, text)


def _instance(design: Design, seed: int) -> tuple[_core.Simulation, hierarchy.Hierarchy]:
    library = design.compile()
    simulation = _core.Simulation(
        library,
        seed=seed,
        plusargs=list(design.plusargs),
        edges_after_eval=design.edges_after_eval,
        deposits_on_outputs=writes.deposits_on_outputs(),
    )
    names = library.names if hierarchy.lists_hidden else ()
    return simulation, hierarchy.build(library.top, simulation, library.constants, names)


def simulate(
    design: Design,
    bench: Bench,
    *,
    seed: int = 0,
    name: str | None = None,
    time_limit: int | None = None,
    wall_limit: float | None = None,
    arguments: dict[str, Any] | None = None,
) -> Any:
    """Runs a bench on a fresh model of a design and returns its result; for scripts that are not tests.

    Parameters
    ----------
    design : Design
        The design.
    bench : coroutine function
        Its first argument is the design.
    seed : int
        Seed of ``random``, of random initial values and of ``$random``.
    time_limit : int, optional
        Limit of simulation time, in femtoseconds.
    wall_limit : float, optional
        Wall-clock limit, in seconds.
    arguments : dict, optional
        Further arguments of the bench, by name.

    Raises
    ------
    BuildError
        If the design does not build; and what `Session.run` raises.

    >>> frames = simulate(design, capture, arguments={"count": 3})
    """
    label = name or str(getattr(bench, "__name__", "bench"))
    with Session(design, seed=seed, name=label) as session:
        return session.run(bench, time_limit=time_limit, wall_limit=wall_limit, **(arguments or {}))


@contextmanager
def _alarm(seconds: float | None) -> Iterator[None]:
    """Ends a bench that never returns to the scheduler. Waits a little longer than the scheduler, which ends all other
    benches with a better message."""
    if not seconds or threading.current_thread() is not threading.main_thread():
        yield
        return

    def ring(_number: int, _frame: Any) -> None:
        raise SimTimeoutError(f"wall-clock limit of {seconds} s reached inside the bench: it does not await anything")

    before = signal.signal(signal.SIGALRM, ring)
    # Again and again: each of several tasks may loop, or catch the exception.
    signal.setitimer(signal.ITIMER_REAL, seconds * 1.1 + 0.2, seconds * 1.1 + 0.2)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
