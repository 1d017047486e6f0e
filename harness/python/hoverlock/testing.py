"""Tests: the decorator, and how one test is run.

>>> @hoverlock.test(timeout_time=1, timeout_unit="ms")
... async def counts(dut):
...     ...
"""

from __future__ import annotations

import functools
import inspect
import itertools
import random
import signal
import threading
import zlib
from collections.abc import Callable, Coroutine, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, TypeVar, overload

from . import _core, hierarchy
from .design import Design
from .errors import SimTimeoutError, TestSuccess
from .log import listener, log
from .outputs import Outputs

__all__ = ["Running", "Session", "Test", "parametrize", "pass_test", "running", "simulate", "test"]

Bench = Callable[..., Coroutine[Any, Any, Any]]
T = TypeVar("T")


class Test:
    """A coroutine function that is a test, with how it is to be run; made by ``test``.

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
        """The same test with arguments of its own."""
        made = Test(self.function, name=name, arguments={**self.arguments, **arguments}, **self.options)
        made.module = self.module
        return made

    def changed(self, **options: Any) -> Test:
        """The same test with other options of ``test``."""
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
        """Runs it on a fresh model; raises what makes it fail."""
        outputs = outputs or Outputs()
        log.getChild("test").info("%s: seed %d", self.name, seed)
        session = Session(outputs.design(design), seed=seed, name=self.name)
        session.label = f"{self.module.rpartition('.')[2]}.{self.name}"
        with session, outputs.of(session):
            self._judge(
                lambda: session.run(
                    self.function,
                    time_limit=self.time_limit,
                    wall_limit=wall_timeout or self.wall_timeout,
                    **{**self.arguments, **(arguments or {})},
                )
            )

    def _judge(self, run: Callable[[], Any]) -> None:
        """Whether it ends as expected."""
        try:
            run()
        except TestSuccess:
            pass
        except AssertionError:
            if not self.expect_fail and AssertionError not in self.expect_error:
                raise
            return
        except self.expect_error as error:
            log.getChild("test").info("%s: raised as expected: %s", self.name, error)
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

    The design is that of ``design=``, or the ``design`` of the module, or the one given to the runner. ``timeout_time`` is
    simulation time, ``wall_timeout`` seconds on the wall. ``expect_fail`` wants an ``AssertionError``, ``expect_error``
    the exceptions named. ``skip`` may be the reason. ``stage`` is taken for cocotb's sake; tests run in the order of
    the file.

    >>> @hoverlock.test(timeout_time=10, timeout_unit="us")
    ... async def counts(dut):
    ...     Clock(dut.clk, 10, "ns").start()
    ...     await ClockCycles(dut.clk, 3)
    ...     assert dut.count.value == 3
    """

    def decorate(of: Bench) -> Test:
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
    """Runs a test once for each value, or for each combination where several are named.

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


def _label(value: Any) -> str:
    return getattr(value, "__name__", None) or str(value)


@dataclass
class Running:
    """The test that runs."""

    name: str
    seed: int
    design: Design
    dut: hierarchy.Hierarchy
    simulation: _core.Simulation
    plusargs: list[str] = field(default_factory=list)


_running: list[Running] = []


def running() -> Running:
    """The test that runs on this thread: its name, seed, design and ``dut``.

    >>> generator = numpy.random.default_rng(running().seed)
    """
    if not _running:
        from .errors import SimulationError

        raise SimulationError("no test is running")
    return _running[-1]


def pass_test(reason: str = "") -> None:
    """Ends the test well at once.

    >>> pass_test("all words came")
    """
    raise TestSuccess(reason)


class Session:
    """A fresh model of a design, used from plain Python: benches run on it one after the other, and whole frames pass through
    it as numpy arrays.

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
        self.simulation.set_log_listener(listener)
        self._running = Running(name, seed, design, self.dut, self.simulation, list(design.plusargs))
        self._random = random.Random(seed).getstate()

    def run(
        self,
        bench: Bench,
        *,
        time_limit: int | None = None,
        wall_limit: float | None = None,
        **arguments: Any,
    ) -> Any:
        """Runs ``bench(dut, **arguments)`` to its end and gives its result. Tasks it started live on until the next."""
        before = random.getstate()
        random.setstate(self._random)
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
        """Lets time go on, with whatever clocks and tasks run."""
        self.simulation.run_for(_core.femtoseconds(time, unit))

    def transfer(
        self,
        words: Any,
        input: str = "in_",
        output: str = "out_",
        *,
        clock: str = "clk",
        period: tuple[float, str] = (10, "ns"),
        bus: str = "avalon",
        ready_latency: int = 0,
        idle: Any = None,
        stall: Any = None,
        seed: int = 0,
        packet: int = 0,
        expect: int | None = None,
        packets: int = 0,
        most_cycles: int = 0,
    ) -> Any:
        """Sends an array of words through the design, without the scheduler, and gives what came out as an array.

        The signals of the streams begin with ``input`` and ``output``; the element type of the array is the one Verilator
        stores ``data`` in (``uint8`` up to 8 bits, ``uint16`` up to 16 ...); wider than 64 bits, each word is a row of ``uint32``, the
        lowest first. ``idle`` and ``stall`` hold the source and the
        sink back: a probability, or a pattern. ``packet`` words make a packet (0: all). It ends when ``expect`` words came
        (as many as were sent, unless told), or, where ``packets`` says how many, when so many packets came. Tasks sleep meanwhile.
        """
        import numpy as np

        words = np.ascontiguousarray(words).reshape(-1)
        received, self.report = self.simulation.transfer(
            words,
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
        return received

    def close(self) -> None:
        """Ends all tasks, runs the Verilog's ``final`` blocks and frees the model."""
        left = self.simulation.living_tasks()
        if left:
            text = ", ".join(left)
            log.getChild("test").info("%d tasks still ran at the end and are cancelled: %s", len(left), text)
        for line in self.simulation.close():
            log.getChild("verilog").info("%s", line)

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


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
    """Runs a bench on a fresh model of a design, and gives its result; for scripts that are no tests.

    >>> frames = simulate(design, capture, arguments={"count": 3})
    """
    label = name or str(getattr(bench, "__name__", "bench"))
    with Session(design, seed=seed, name=label) as session:
        return session.run(bench, time_limit=time_limit, wall_limit=wall_limit, **(arguments or {}))


@contextmanager
def _alarm(seconds: float | None) -> Iterator[None]:
    """Ends a bench that never comes back to the scheduler. One that does is ended by that, with a better message, so
    this waits a little longer."""
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
    """A test's seed from that of the session: its own, whatever else runs."""
    return zlib.crc32(f"{session_seed}:{name}".encode())
