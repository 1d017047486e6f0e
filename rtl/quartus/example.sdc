# SPDX-License-Identifier: MIT OR Apache-2.0
# The extractor alone, as in example.qsf. In a system, its own constraints define the clock and the pins.

# 100 MHz: eight times what 1024 x 768 at 15 frames a second needs (11.8 Mpixel/s), and one pixel a clock for faster cameras.
create_clock -name clock -period 10.000 [get_ports clock]
derive_clock_uncertainty

# There is no board: half a period is reserved for logic outside the pins.
set_input_delay -clock clock 5.000 [remove_from_collection [all_inputs] [get_ports clock]]
set_output_delay -clock clock 5.000 [all_outputs]
