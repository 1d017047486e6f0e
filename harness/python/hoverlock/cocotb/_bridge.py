"""Blocking functions and coroutines that call each other: ``bridge`` and ``resume``, ``external`` and ``function`` by
cocotb 1's names.

A blocking function runs in its own thread. The simulation stands still while it computes, and runs on while it
waits for a coroutine of ``resume``: at any time one of the two runs.
"""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable, Coroutine
from queue import SimpleQueue
from typing import Any

from ..errors import is_own_end

__all__ = ["bridge", "resume"]

# The two queues between a thread of `bridge` and its task.
_here = threading.local()


def bridge(function: Callable[..., Any]) -> Callable[..., Coroutine[Any, Any, Any]]:
    """Converts a blocking function into a coroutine function; it may call functions made by ``resume``.

    >>> result = await bridge(driver_without_async)(dut)
    """

    @functools.wraps(function)
    async def run(*args: Any, **kwargs: Any) -> Any:
        to_task: SimpleQueue[tuple[str, Any]] = SimpleQueue()
        to_thread: SimpleQueue[tuple[Any, BaseException | None]] = SimpleQueue()

        def body() -> None:
            _here.queues = (to_task, to_thread)
            try:
                to_task.put(("returned", function(*args, **kwargs)))
            except BaseException as error:
                to_task.put(("raised", error))

        threading.Thread(target=body, name=f"bridge {function.__name__}", daemon=True).start()
        while True:
            said, what = to_task.get()
            if said == "returned":
                return what
            if said == "raised":
                raise what
            result, failure = None, None
            try:
                result = await what
            except BaseException as error:
                if is_own_end(error):
                    # The thread's wait ends with an error, so that the thread ends.
                    to_thread.put((None, RuntimeError("the task of this bridge was cancelled")))
                    raise
                failure = error
            to_thread.put((result, failure))

    return run


def resume(function: Callable[..., Coroutine[Any, Any, Any]]) -> Callable[..., Any]:
    """Converts a coroutine function into a blocking function, which code below ``bridge`` can call.

    >>> write = resume(bus.write)
    """

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        queues = getattr(_here, "queues", None)
        if queues is None:
            raise RuntimeError(f"{function.__name__} was made by resume: it is called in a thread that bridge has started")
        to_task, to_thread = queues
        to_task.put(("awaits", function(*args, **kwargs)))
        result, failure = to_thread.get()
        if failure is not None:
            raise failure
        return result

    return call
