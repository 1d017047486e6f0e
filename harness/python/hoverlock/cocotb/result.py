"""``cocotb.result``.

>>> raise TestFailure("the sum is wrong")
"""

from typing import Any, NoReturn

from .. import errors
from ..deprecated import advise

__all__ = ["ReturnValue", "SimFailure", "SimTimeoutError", "TestComplete", "TestError", "TestFailure", "TestSuccess"]

TestComplete = errors.TestSuccess
_MOVED = {"SimFailure": errors.SimulationError, "SimTimeoutError": errors.SimTimeoutError, "TestSuccess": errors.TestSuccess}


def __getattr__(name: str) -> Any:
    if name not in _MOVED:
        raise AttributeError(f"hoverlock.cocotb.result has no '{name}'")
    advise(f"result.{name}")
    return _MOVED[name]


class TestFailure(AssertionError):
    """A failed check, by cocotb 1's name."""

    __test__ = False


class ExternalException(Exception):
    """An error in a thread of ``external``, by cocotb 1's name."""

    def __init__(self, exception: BaseException) -> None:
        super().__init__(exception)
        self.exception = exception


class TestError(Exception):
    """An error of the bench rather than of the design."""

    __test__ = False


class ReturnValue(Exception):
    """Raised by a coroutine with ``yield`` to return a value."""

    def __init__(self, retval: Any = None) -> None:
        super().__init__(retval)
        self.retval = retval


def raise_error(_of: object, message: str) -> NoReturn:
    """Fails the test."""
    raise TestError(message)
