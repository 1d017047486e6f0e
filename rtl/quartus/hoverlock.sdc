# 100 MHz: six times what 1024 x 768 at 15 frames a second needs (11.8 Mpixel/s), and one pixel a clock for faster cameras.
create_clock -name clock -period 10.000 [get_ports clock]
derive_clock_uncertainty

# As a top of its own the core has no board around it: half a period is left to what feeds and reads its pins.
set_input_delay -clock clock 5.000 [remove_from_collection [all_inputs] [get_ports clock]]
set_output_delay -clock clock 5.000 [all_outputs]

# The frame size changes only while the pipeline is empty, and three cycles before the first step of a frame uses it.
set_multicycle_path -setup 2 -from [get_registers *sequencer*width[*]] -to [get_registers *total[*]]
set_multicycle_path -hold 1 -from [get_registers *sequencer*width[*]] -to [get_registers *total[*]]
