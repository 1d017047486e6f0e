"""Exceptions of the clean-up code of cancelled tasks. No task waits for them, so that Python would only print them.

>>> with errors_raised():
...     simulation.run(coroutine, name)
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Coroutine, Iterator
from contextlib import contextmanager
from typing import Any

from .errors import CancelledError, TestSuccess, is_own_end

__all__ = ["errors_raised"]

# Of each thread: the exceptions that its innermost `errors_raised` has kept.
_here = threading.local()
# The hook of Python is one for all threads: the first `errors_raised` replaces it, and the last restores it.
_hook_lock = threading.Lock()
_hook_users = 0
_usual_hook: Any = None


@contextmanager
def errors_raised() -> Iterator[None]:
    """Raises the first exception that clean-up code raises inside the ``with`` block, at the end of the block. If the block itself
    raises, that exception comes first; the others are left to the enclosing block, if there is one, or printed.

    >>> with errors_raised():
    ...     task.cancel()
    """
    _begin()
    enclosing = getattr(_here, "kept", None)
    kept: list[Any] = []
    _here.kept = kept
    first = None
    try:
        yield
        first = kept.pop(0).exc_value if kept else None
    finally:
        _here.kept = enclosing
        for raised in kept:
            sys.unraisablehook(raised)
        _end()
    if first is not None:
        raise first


def _begin() -> None:
    global _hook_users, _usual_hook
    with _hook_lock:
        if _hook_users == 0:
            _usual_hook, sys.unraisablehook = sys.unraisablehook, _keep
        _hook_users += 1


def _end() -> None:
    global _hook_users
    with _hook_lock:
        _hook_users -= 1
        if _hook_users == 0:
            sys.unraisablehook = _usual_hook


def _keep(raised: Any) -> None:
    kept = getattr(_here, "kept", None)
    if kept is not None and isinstance(raised.object, Coroutine) and _is_error(raised.exc_value):
        kept.append(raised)
    else:
        _usual_hook(raised)


def _is_error(error: BaseException) -> bool:
    """Returns whether it is an error of the clean-up code, rather than its end by the cancellation."""
    # Raised for clean-up code that awaits, which the cancellation ends at that wait.
    awaits = isinstance(error, RuntimeError) and str(error) == "coroutine ignored GeneratorExit"
    return not (awaits or is_own_end(error) or isinstance(error, (CancelledError, TestSuccess)))
