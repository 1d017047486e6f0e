"""``cocotb_tools.runner``.

>>> from hoverlock.cocotb_tools.runner import get_runner
"""

from ..cocotb.runner import Verilator, get_results, get_runner

__all__ = ["Verilator", "get_results", "get_runner"]
