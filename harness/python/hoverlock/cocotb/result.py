"""``cocotb.result``."""

from ..errors import SimTimeoutError, TestSuccess

__all__ = ["SimTimeoutError", "TestFailure", "TestSuccess"]

TestFailure = AssertionError
