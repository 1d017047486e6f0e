"""``cocotb.decorators``: coroutines written with ``yield``, as in cocotb 1 before ``async``.

>>> @cocotb.coroutine
... def reset(dut):
...     dut.rst <= 1
...     yield Timer(10, "ns")
"""

from __future__ import annotations

import functools
import inspect
from typing import Any

from .. import testing
from .._core import Task, start_soon
from ..triggers import First
from ._bridge import bridge as external
from ._bridge import resume as function
from .result import ReturnValue

__all__ = ["RunningTask", "coroutine", "external", "function", "public", "skipif", "test", "xfail"]

RunningTask = RunningCoroutine = RunningTest = Task


def public(function: Any) -> Any:
    """Returns the function itself; cocotb 1 listed it in its documents."""
    return function


def coroutine(function: Any) -> Any:
    """Converts a generator function, or a class whose objects can be awaited, into a coroutine function; an ``async def`` is
    returned unchanged."""
    if inspect.isclass(function):

        async def awaits(*args: Any, **kwargs: Any) -> Any:
            made: Any = function(*args, **kwargs)
            return await made

        # Not `functools.wraps`: the attributes of the class are those of its objects.
        awaits.__name__, awaits.__qualname__ = function.__name__, function.__qualname__
        awaits.__module__, awaits.__doc__ = function.__module__, function.__doc__
        return awaits
    if not inspect.isgeneratorfunction(function):
        return function

    @functools.wraps(function)
    async def run(*args: Any, **kwargs: Any) -> Any:
        generator = function(*args, **kwargs)
        given: Any = None
        try:
            while True:
                wanted = generator.send(given)
                # A list means the first of its parts; a generator, a coroutine without its decorator.
                if isinstance(wanted, (list, tuple)):
                    wanted = First(*wanted)
                elif inspect.isgenerator(wanted):
                    wanted = start_soon(wanted)
                given = await wanted
                if given is None:
                    given = wanted
        except StopIteration as end:
            return end.value
        except ReturnValue as end:
            return end.retval
        finally:
            generator.close()

    return run


def test(*args: Any, **kwargs: Any) -> Any:
    """``hoverlock.test``, also for functions with ``yield``."""
    if len(args) == 1 and callable(args[0]) and not kwargs:
        return test()(args[0])
    if args:
        # cocotb 1 took the timeout as a positional argument.
        kwargs.update(zip(("timeout_time", "timeout_unit", "expect_fail", "expect_error", "skip"), args))
    if kwargs.get("expect_error") is False:
        del kwargs["expect_error"]
    elif isinstance(kwargs.get("expect_error"), (list, set)):
        kwargs["expect_error"] = tuple(kwargs["expect_error"])
    if kwargs.get("expect_error") is True:
        kwargs["expect_error"] = Exception
    return lambda function: testing.test(**{**getattr(function, "_hoverlock_options", {}), **kwargs})(coroutine(function))


test._makes_tests = True  # type: ignore[attr-defined]  # it is not a test itself: see the pytest plug-in


def skipif(condition: bool, *, reason: str = "") -> Any:
    """Skips a test if a condition is true; written above or below ``test``.

    >>> @cocotb.skipif(sys.platform == "win32", reason="has no such clock")
    ... @cocotb.test
    ... async def ticks(dut): ...
    """
    return _with({"skip": reason or True} if condition else {})


def xfail(condition: bool = True, *, reason: str = "", raises: type[BaseException] | tuple[type[BaseException], ...] = ()) -> Any:
    """Expects a test to fail, or to raise, if a condition is true; written above or below ``test``.

    >>> @cocotb.test
    ... @cocotb.xfail(raises=KeyError)
    ... async def is_mended_one_day(dut): ...
    """
    return _with(({"expect_error": raises} if raises else {"expect_fail": True}) if condition else {})


def _with(options: dict[str, Any]) -> Any:
    def decorate(target: Any) -> Any:
        if isinstance(target, testing.Test):
            return target.changed(**options)
        target._hoverlock_options = {**getattr(target, "_hoverlock_options", {}), **options}
        return target

    return decorate
