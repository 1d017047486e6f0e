# What the timing analyser cannot know of the extractor; part of the Platform Designer component. The clock comes from the system.

# The frame size changes only while the pipeline is empty. Then the sequencer lets four cycles pass before the first step of a frame, and no
# register of the datapath that has a clock enable takes anything before that step; those without one, which hold multiples of the
# width, are read after it. So two cycles are there for whatever the datapath derives from the size. The sequencer itself compares the
# size in the next cycle, and is not excepted.
set_multicycle_path -setup 2 -from [get_registers {*sequencer:sequencer|width[*] *sequencer:sequencer|height[*]}] -to [get_registers {*extractor:extractor|*}]
set_multicycle_path -hold 1 -from [get_registers {*sequencer:sequencer|width[*] *sequencer:sequencer|height[*]}] -to [get_registers {*extractor:extractor|*}]

# Nothing else needs an exception: one clock, a synchronous reset, no path between clocks.
