"""Tests: the decorator, and how one test is run.

>>> @hoverlock.test(timeout_time=1, timeout_unit="ms")
... async def counts(dut):
...     ...
"""

from __future__ import annotations

import functools
import itertools
import random
import signal
import sys
import threading
import zlib
from collections.abc import Callable, Coroutine, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Literal, TypeVar, overload

from . import _core, hierarchy, unknown
from .design import Design
from .errors import SimTimeoutError, TestSuccess
from .outputs import Outputs
from .transfer import Pause, TransferOptions, TransferReport

if TYPE_CHECKING:
    import logging

    import numpy as np
    from numpy.typing import NDArray

__all__ = ["Running", "Session", "Test", "parametrize", "pass_test", "running", "simulate", "test"]

Bench = Callable[..., Coroutine[Any, Any, Any]]
T = TypeVar("T")


class Test:
    """A coroutine function that is a test, with its options; made by ``test``.

    >>> counts.run(design, seed=1)
    """

    __test__ = False

    def __init__(
        self,
        function: Bench,
        *,
        design: Design | None = None,
        timeout_time: float | None = None,
        timeout_unit: str = "step",
        wall_timeout: float | None = 600.0,
        skip: bool | str = False,
        expect_fail: bool = False,
        expect_error: type[BaseException] | tuple[type[BaseException], ...] = (),
        name: str | None = None,
        arguments: dict[str, Any] | None = None,
    ) -> None:
        self.function = function
        self.design = design
        self.time_limit = None if timeout_time is None else _core.femtoseconds(timeout_time, timeout_unit)
        self.timeout_text = f"{timeout_time} {timeout_unit}"
        self.wall_timeout = wall_timeout
        self.skip = skip
        self.expect_fail = expect_fail
        self.expect_error = expect_error if isinstance(expect_error, tuple) else (expect_error,)
        self.name = name or function.__name__
        self.module: str = getattr(function, "__module__", "")
        self.arguments = arguments or {}
        self.options: dict[str, Any] = {
            "design": design,
            "timeout_time": timeout_time,
            "timeout_unit": timeout_unit,
            "wall_timeout": wall_timeout,
            "skip": skip,
            "expect_fail": expect_fail,
            "expect_error": expect_error,
        }
        functools.update_wrapper(self, function)

    def with_arguments(self, name: str, arguments: dict[str, Any]) -> Test:
        """This test with other arguments and another name."""
        made = Test(self.function, name=name, arguments={**self.arguments, **arguments}, **self.options)
        made.module = self.module
        return made

    def changed(self, **options: Any) -> Test:
        """This test with other options, named as those of ``test``."""
        made = Test(self.function, name=self.name, arguments=self.arguments, **{**self.options, **options})
        made.module = self.module
        return made

    def variants(self) -> Iterator[Test]:
        """One test for each combination that ``parametrize`` asks for."""
        sets: list[list[tuple[str, dict[str, Any]]]] = getattr(self.function, "_hoverlock_parameters", [])
        for choice in itertools.product(*sets):
            if not choice:
                yield self
                continue
            arguments = {key: value for _, chosen in choice for key, value in chosen.items()}
            label = "-".join(text for text, _ in choice)
            yield self.with_arguments(f"{self.name}[{label}]", arguments)

    def __call__(self, *args: Any, **kwargs: Any) -> Coroutine[Any, Any, Any]:
        return self.function(*args, **kwargs)

    def run(
        self,
        design: Design,
        *,
        seed: int,
        wall_timeout: float | None = None,
        outputs: Outputs | None = None,
        arguments: dict[str, Any] | None = None,
    ) -> None:
        """Runs the test on a fresh model; raises the exception that makes it fail.

        Parameters
        ----------
        design : Design
            The design under test.
        seed : int
            Seed of ``random``, of random initial values and of ``$random``.
        wall_timeout : float, optional
            Wall-clock limit in seconds; default: the test's own.
        outputs : Outputs, optional
            The waves and coverage to write.
        arguments : dict, optional
            Arguments of the test by name.
        """
        outputs = outputs or Outputs()
        _log("test").info("%s: seed %d", self.name, seed)
        session = Session(outputs.design(design), seed=seed, name=self.name)
        session.label = f"{self.module.rpartition('.')[2]}.{self.name}"
        with session, outputs.of(session):
            self._expect_ending(
                lambda: session.run(
                    self.function,
                    time_limit=self.time_limit,
                    wall_limit=wall_timeout or self.wall_timeout,
                    **{**self.arguments, **(arguments or {})},
                )
            )

    def _expect_ending(self, run: Callable[[], Any]) -> None:
        """Raises unless the run ends as ``expect_fail`` and ``expect_error`` say."""
        try:
            run()
        except TestSuccess:
            pass
        except self.expect_error as error:
            _log("test").info("%s: raised as expected: %s", self.name, error)
            return
        except BaseException as error:
            if not self.expect_fail or not is_failed_check(error):
                raise
            return
        if self.expect_fail:
            raise AssertionError(f"{self.name} passed, but was expected to fail")
        if self.expect_error:
            names = " or ".join(kind.__name__ for kind in self.expect_error)
            raise AssertionError(f"{self.name} passed, but was expected to raise {names}")


@overload
def test(function: Bench, /) -> Test: ...


@overload
def test(
    *,
    design: Design | None = ...,
    timeout_time: float | None = ...,
    timeout_unit: str = ...,
    wall_timeout: float | None = ...,
    skip: bool | str = ...,
    expect_fail: bool = ...,
    expect_error: type[BaseException] | tuple[type[BaseException], ...] = ...,
    name: str | None = ...,
    stage: int | None = ...,
) -> Callable[[Bench], Test]: ...


def test(
    function: Bench | None = None,
    *,
    design: Design | None = None,
    timeout_time: float | None = None,
    timeout_unit: str = "step",
    wall_timeout: float | None = 600.0,
    skip: bool | str = False,
    expect_fail: bool = False,
    expect_error: type[BaseException] | tuple[type[BaseException], ...] = (),
    name: str | None = None,
    stage: int | None = None,
) -> Any:
    """Makes a coroutine function a test.

    Parameters
    ----------
    design : Design, optional
        The design under test. Default: ``design`` of the module, or the one given to the runner.
    timeout_time : float, optional
        Limit of simulation time, in ``timeout_unit`` (``fs``, ``ps``, ``ns``, ``us``, ``ms``, ``sec`` or ``step``, 1 ps).
    wall_timeout : float, optional
        Wall-clock limit in seconds; None: no limit.
    skip : bool or str
        Whether the test is skipped; a text is the reason.
    expect_fail : bool
        The test passes if it raises ``AssertionError``.
    expect_error : exception class or tuple of them
        The test passes if it raises one of these.
    name : str, optional
        The name of the test. Default: that of the function.
    stage : int, optional
        Ignored; accepted because cocotb has it. Tests run in the order of the file.

    Raises
    ------
    TypeError
        If the function is not a coroutine function.

    >>> @hoverlock.test(timeout_time=10, timeout_unit="us")
    ... async def counts(dut):
    ...     Clock(dut.clk, 10, "ns").start()
    ...     await ClockCycles(dut.clk, 3)
    ...     assert dut.count.value == 3
    """

    def decorate(of: Bench) -> Test:
        import inspect  # here, as it takes 10 ms and scripts may have no test

        if not inspect.iscoroutinefunction(of):
            raise TypeError(f"{of.__name__} must be a coroutine function: async def {of.__name__}(dut)")
        return Test(
            of,
            design=design,
            timeout_time=timeout_time,
            timeout_unit=timeout_unit,
            wall_timeout=wall_timeout,
            skip=skip,
            expect_fail=expect_fail,
            expect_error=expect_error,
            name=name,
        )

    return decorate if function is None else decorate(function)


def parametrize(*options: tuple[str | Sequence[str], Iterable[Any]], **named: Iterable[Any]) -> Callable[[T], T]:
    """Runs a test once for each value, or for each combination of values of several parameters.

    >>> @hoverlock.test()
    ... @hoverlock.parametrize(width=[1, 8], gap=[0, 3])
    ... async def passes(dut, width, gap):
    ...     ...
    >>> both = hoverlock.parametrize((("a", "b"), [(1, 2), (3, 4)]))
    """
    sets: list[list[tuple[str, dict[str, Any]]]] = []
    for names, values in [*options, *named.items()]:
        if isinstance(names, str):
            sets.append([(f"{names}={_label(value)}", {names: value}) for value in values])
        else:
            sets.append([
                (",".join(f"{n}={_label(v)}" for n, v in zip(names, value, strict=True)), dict(zip(names, value)))
                for value in values
            ])

    def decorate(target: T) -> T:
        function: Any = target.function if isinstance(target, Test) else target
        function._hoverlock_parameters = sets + getattr(function, "_hoverlock_parameters", [])
        return target

    return decorate


def is_failed_check(error: BaseException | None) -> bool:
    """Whether it is a check that failed: an assertion, or ``pytest.fail`` and the like."""
    # Only a bench that has imported pytest can raise what it raises.
    pytest = sys.modules.get("pytest")
    return isinstance(error, AssertionError) or (pytest is not None and isinstance(error, pytest.fail.Exception))


def _label(value: Any) -> str:
    return getattr(value, "__name__", None) or str(value)


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
# While modules are loaded that may look at the design: the design, and its model once something looked.
_loading: tuple[Design, list[Session]] | None = None


def set_loading(design: Design | None) -> None:
    """The design whose modules are being loaded, or none any more. Benches written for cocotb may look at `cocotb.top`
    while they are loaded; a model is made only then."""
    global _loading
    if _loading is not None:
        for session in _loading[1]:
            session.close()
    _loading = None if design is None else (design, [])


def running_or_loading() -> Running | None:
    """The test that is running; while modules are loaded, a model to look at; otherwise None."""
    if _running:
        return _running[-1]
    if _loading is None:
        return None
    design, sessions = _loading
    if not sessions:
        sessions.append(Session(design, name="loading"))
    return sessions[0]._running


def running() -> Running:
    """The test that is running on this thread: its name, seed, design and ``dut``.

    Raises
    ------
    SimulationError
        If no test is running.

    >>> generator = numpy.random.default_rng(running().seed)
    """
    if not _running:
        from .errors import SimulationError

        raise SimulationError("no test is running")
    return _running[-1]


def pass_test(reason: str = "") -> None:
    """Ends the test at once; it passes.

    >>> pass_test("all beats received")
    """
    raise TestSuccess(reason)


class Session:
    """A fresh model of a design, used from plain Python: benches run on it one after the other, and whole frames pass
    through it as numpy arrays.

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
            # A module without ports, a testbench in Verilog: what it declares is what there is to drive.
            design = design.changed(internals=("*",))
            self.simulation, self.dut = _instance(design, seed)
        self.simulation.set_log_listener(_listener)
        self._running = Running(name, seed, design, self.dut, self.simulation)
        self._random = random.Random(seed).getstate()
        self.report: TransferReport | None = None
        """How the last transfer went."""

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
            If a limit is reached, no event can come any more, the Verilog reports an error, or a bus rule is broken;
            and whatever the bench raises.
        """
        before = random.getstate()
        random.setstate(self._random)
        unknown.begin()
        _running.append(self._running)
        coroutine = bench(self.dut, **arguments)
        try:
            with _alarm(wall_limit):
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

        Tasks do not run meanwhile. How the transfer went is in ``report``.

        Parameters
        ----------
        samples : ndarray of uint8, uint16, uint32 or uint64
            One element for each beat, in C order whatever the shape. The dtype is the smallest that holds the input's
            ``data``. For ``data`` wider than 64 bits: ``uint32``, several elements for each beat, the lowest first.
        input, output : str
            What the names of the streams' signals begin with.
        clock : str
            The clock's signal; no other clock may run.
        period : tuple of float and str
            Period of the clock, with its unit.
        bus : "avalon" or "axi"
            Avalon-ST or AXI4-Stream.
        ready_latency : int
            Cycles from ``ready`` to the beat it allows, from 0 to 64; Avalon-ST only.
        idle, stall : float or iterable of bool, optional
            In which cycles the source offers no new beat, and in which the sink is not ready: a probability from 0 to
            less than 1, or a pattern (true: pause) that is repeated.
        seed : int
            Seed of both probabilities.
        packet : int
            Beats in each packet sent; 0: all beats are one packet.
        expect : int, optional
            Beats to receive before the transfer ends. Default: as many as are sent, or 0 where ``packets`` is given.
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
        """Cancels all tasks, runs the Verilog's ``final`` blocks and frees the model."""
        left = self.simulation.living_tasks()
        if left:
            text = ", ".join(left)
            _log("test").info("%d tasks still ran at the end and are cancelled: %s", len(left), text)
        for line in self.simulation.close():
            _log("verilog").info("%s", line)

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _log(source: str) -> logging.Logger:
    """A part of the log, which is loaded by whoever says something first: it takes 8 ms."""
    from .log import log

    return log.getChild(source)


def _listener(time: int, level: int, source: str, text: str) -> None:
    """Logs a line of the engine."""
    from .log import listener

    listener(time, level, source, text)


def _instance(design: Design, seed: int) -> tuple[_core.Simulation, hierarchy.Hierarchy]:
    library = design.compile()
    simulation = _core.Simulation(
        library, seed=seed, plusargs=list(design.plusargs), edges_after_eval=design.edges_after_eval
    )
    return simulation, hierarchy.build(library.top, simulation, library.constants)


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
    """Ends a bench that does not return to the scheduler. The scheduler ends other benches with a better message, so this
    waits a little longer."""
    if not seconds or threading.current_thread() is not threading.main_thread():
        yield
        return

    def ring(_number: int, _frame: Any) -> None:
        raise SimTimeoutError(f"wall-clock limit of {seconds} s reached inside the bench: it does not await anything")

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds * 1.1 + 0.2)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def seed_of(session_seed: int, name: str) -> int:
    """The seed of a test, which depends on that of the session and on the test's name alone."""
    return zlib.crc32(f"{session_seed}:{name}".encode())
