"""``cocotb._outcomes``: a result or an error, to be had later.

>>> Value(3).get()
3
"""

from __future__ import annotations

from typing import Any, NoReturn

__all__ = ["Error", "Value"]


class Value:
    """A result."""

    def __init__(self, value: Any) -> None:
        self.value = value

    def get(self) -> Any:
        """Returns the result."""
        return self.value


class Error:
    """An error."""

    def __init__(self, error: BaseException) -> None:
        self.error = error

    def get(self) -> NoReturn:
        """Raises the error."""
        raise self.error
