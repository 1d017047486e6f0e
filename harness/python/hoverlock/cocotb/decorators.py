"""``cocotb.decorators``: coroutines made of ``yield``, as cocotb 1 had them before ``async``.

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
from .result import ReturnValue

__all__ = ["RunningTask", "coroutine", "test"]

RunningTask = RunningCoroutine = Task


def coroutine(function: Any) -> Any:
    """Makes a coroutine of a generator function; an ``async def`` stays as it is."""
    if not inspect.isgeneratorfunction(function):
        return function

    @functools.wraps(function)
    async def run(*args: Any, **kwargs: Any) -> Any:
        generator = function(*args, **kwargs)
        given: Any = None
        try:
            while True:
                wanted = generator.send(given)
                # A list is the first of its parts, a generator a coroutine whose decorator was forgotten.
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
    """``hoverlock.test``, also of functions that ``yield``."""
    if len(args) == 1 and callable(args[0]) and not kwargs:
        return testing.test(coroutine(args[0]))
    if args:
        # cocotb 1 took the timeout by place.
        kwargs.update(zip(("timeout_time", "timeout_unit", "expect_fail", "expect_error", "skip"), args))
    if kwargs.get("expect_error") is False:
        del kwargs["expect_error"]
    elif isinstance(kwargs.get("expect_error"), (list, set)):
        kwargs["expect_error"] = tuple(kwargs["expect_error"])
    if kwargs.get("expect_error") is True:
        kwargs["expect_error"] = Exception
    decorate = testing.test(**kwargs)
    return lambda function: decorate(coroutine(function))
