"""``cocotb_tools.check_results``.

>>> tests, failures = get_results(path)
"""

from ..cocotb.runner import get_results

__all__ = ["get_results"]
