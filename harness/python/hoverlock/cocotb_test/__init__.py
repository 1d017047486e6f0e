"""``cocotb_test``: the package that runs benches from plain tests of pytest, here on the harness.

>>> from cocotb_test.simulator import run
"""

from __future__ import annotations

__all__ = ["__version__"]

__version__ = "0.2.6"
"""The version of cocotb-test whose arguments these are."""
