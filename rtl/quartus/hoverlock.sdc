# SPDX-License-Identifier: MIT OR Apache-2.0
# Timing exceptions of the extractor; part of the Platform Designer component. The system defines the clock.

# The frame size changes only while the pipeline is empty. Then the sequencer waits four cycles before the first step of a frame. Registers of
# the datapath that read the size load at a step, which comes later, or in every cycle and are read after the size is stable (multiples of the
# width, the last column). The address counter alone changes without a step: above the last column it returns to 0. While the size settles it
# may return too early, which changes nothing, as a frame may begin at any address; afterwards it compares with the stable size. So paths from
# the size into the datapath have two cycles. The sequencer itself compares the size in the next cycle, so it has no exception.
set_multicycle_path -setup 2 -from [get_registers {*sequencer:sequencer|width[*] *sequencer:sequencer|height[*]}] -to [get_registers {*extractor:extractor|*}]
set_multicycle_path -hold 1 -from [get_registers {*sequencer:sequencer|width[*] *sequencer:sequencer|height[*]}] -to [get_registers {*extractor:extractor|*}]

# No other exception is needed: there is one clock, a synchronous reset and no clock crossing.
