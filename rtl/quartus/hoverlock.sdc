# SPDX-License-Identifier: MIT OR Apache-2.0
# Timing exceptions of the extractor; part of the Platform Designer component. The system defines the clock.

# The frame size changes only while the pipeline is empty. Then the sequencer waits four cycles before the first step of a frame. Registers of
# the datapath with a clock enable do not load before that step; those without one, which hold multiples of the width, are read after it. So
# paths from the size into the datapath have two cycles. The sequencer itself compares the size in the next cycle, so it has no exception.
set_multicycle_path -setup 2 -from [get_registers {*sequencer:sequencer|width[*] *sequencer:sequencer|height[*]}] -to [get_registers {*extractor:extractor|*}]
set_multicycle_path -hold 1 -from [get_registers {*sequencer:sequencer|width[*] *sequencer:sequencer|height[*]}] -to [get_registers {*extractor:extractor|*}]

# No other exception is needed: there is one clock, a synchronous reset and no clock crossing.
