"""``cocotb._typing``: names for annotations, which packages import although they are not public."""

from typing import Literal

from .simtime import RoundMode, TimeUnit

__all__ = ["ResolverLiteral", "RoundMode", "TimeUnit"]

ResolverLiteral = Literal["error", "weak", "zeros", "ones", "random"]
