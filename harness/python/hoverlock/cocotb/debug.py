"""``cocotb.debug``: a switch that has no effect here."""

debug = False
