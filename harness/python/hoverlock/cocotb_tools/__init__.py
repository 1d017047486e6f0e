"""``cocotb_tools``, cocotb 2's package of the runner."""
