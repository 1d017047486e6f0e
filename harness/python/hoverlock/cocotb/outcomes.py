"""``cocotb.outcomes``: a result or an error, by cocotb 1's name."""

from ._outcomes import Error, Value

__all__ = ["Error", "Value"]
