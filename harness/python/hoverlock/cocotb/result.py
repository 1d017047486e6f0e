"""``cocotb.result``.

>>> raise TestFailure("the sum is wrong")
"""

from typing import Any, NoReturn

from ..errors import SimTimeoutError, SimulationError, TestSuccess

__all__ = ["ReturnValue", "SimFailure", "SimTimeoutError", "TestComplete", "TestError", "TestFailure", "TestSuccess"]

TestComplete = TestSuccess
SimFailure = SimulationError


class TestFailure(AssertionError):
    """A failed check, by cocotb 1's name."""

    __test__ = False


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
