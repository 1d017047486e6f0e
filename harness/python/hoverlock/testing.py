"""Tests: the decorators, and the run of one test.

>>> @hoverlock.test(timeout_time=1, timeout_unit="ms")
... async def counts(dut):
...     ...
"""

from __future__ import annotations

import functools
import itertools
import os
import sys
import zlib
from collections.abc import Callable, Coroutine, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NoReturn, TypeVar, overload

from . import _core, clean_up
from .design import Design
from .errors import HoverlockError, TestSuccess
from .outputs import Outputs
from .session import Bench, Session, log_of

__all__ = ["Test", "is_failed_check", "parametrize", "pass_test", "seed_of", "test"]

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
        """Returns this test with other arguments and another name."""
        made = Test(self.function, name=name, arguments={**self.arguments, **arguments}, **self.options)
        made.module = self.module
        return made

    def changed(self, **options: Any) -> Test:
        """Returns this test with other options, named as those of ``test``."""
        made = Test(self.function, name=self.name, arguments=self.arguments, **{**self.options, **options})
        made.module = self.module
        return made

    def variants(self) -> Iterator[Test]:
        """Yields one test for each combination of ``parametrize``."""
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
        log_of("test").info("%s: seed %d", self.name, seed)
        session = Session(outputs.design(design), seed=seed, name=self.name)
        session.label = f"{self.module.rpartition('.')[2]}.{self.name}"
        with clean_up.errors_raised(), session, outputs.of(session), _no_silent_exit(self.name):
            self._expect_ending(
                lambda: session.run(
                    self.function,
                    time_limit=self.time_limit,
                    wall_limit=wall_timeout or self.wall_timeout,
                    **{**self.arguments, **(arguments or {})},
                )
            )

    def _expect_ending(self, run: Callable[[], Any]) -> None:
        """Raises unless the run ends as ``expect_fail`` and ``expect_error`` require."""
        try:
            run()
        except TestSuccess:
            pass
        except self.expect_error as error:
            log_of("test").info("%s: raised as expected: %s", self.name, error)
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
        Ignored; present because cocotb has it. Tests run in the order of the file.

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
        import inspect  # here, because it takes 10 ms and scripts may have no test

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


@contextmanager
def _no_silent_exit(name: str) -> Iterator[None]:
    """Converts `os._exit` of this process into an error: it would end the run, perhaps with status 0, before the results of
    any test are written. Processes that the bench forks may call it."""
    real, process, calls = os._exit, os.getpid(), []

    def refuse(status: int) -> NoReturn:
        if os.getpid() != process:
            real(status)
        calls.append(status)
        raise HoverlockError(f"{name} called os._exit({status})")

    os._exit = refuse
    try:
        yield
    finally:
        os._exit = real
    if calls:  # in a thread, or caught by the bench
        raise HoverlockError(f"{name} called os._exit({calls[0]})")


def is_failed_check(error: BaseException | None) -> bool:
    """Returns whether the error is a failed check: an assertion, ``pytest.fail`` and the like."""
    # Only a bench that has imported pytest can raise its exceptions.
    pytest = sys.modules.get("pytest")
    return isinstance(error, AssertionError) or (pytest is not None and isinstance(error, pytest.fail.Exception))


def _label(value: Any) -> str:
    return getattr(value, "__name__", None) or str(value)


def pass_test(reason: str = "") -> None:
    """Ends the test at once; it passes.

    >>> pass_test("all beats received")
    """
    raise TestSuccess(reason)


def seed_of(session_seed: int, name: str) -> int:
    """Returns the seed of a test, which depends only on the session's seed and the test's name."""
    return zlib.crc32(f"{session_seed}:{name}".encode())
