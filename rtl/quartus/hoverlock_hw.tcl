# SPDX-License-Identifier: MIT OR Apache-2.0
# Platform Designer component: copy or link this folder and ../verilog into the IP search path.
package require -exact qsys 16.0

set_module_property NAME hoverlock
set_module_property DISPLAY_NAME "Hoverlock feature extractor"
set_module_property DESCRIPTION "Avalon-ST video in, feature records out, one pixel per clock"
set_module_property VERSION 1.0
set_module_property GROUP "Video"
set_module_property EDITABLE false

# The sources come from the file list.
add_fileset synthesis QUARTUS_SYNTH add_sources
add_fileset simulation SIM_VERILOG add_verilog
set_fileset_property synthesis TOP_LEVEL hoverlock_top
set_fileset_property simulation TOP_LEVEL hoverlock_top
proc add_sources {entity} {
    set here [get_module_property MODULE_DIRECTORY]
    add_fileset_file hoverlock.sdc SDC PATH [file join $here hoverlock.sdc]
    add_verilog $entity
}
proc add_verilog {entity} {
    set folder [file join [get_module_property MODULE_DIRECTORY] .. verilog]
    set list [open [file join $folder hoverlock.f]]
    while {[gets $list line] >= 0} {
        if {[string match *.v $line]} { add_fileset_file $line VERILOG PATH [file join $folder $line] }
    }
    close $list
}

add_interface clock clock end
add_interface_port clock clock clk Input 1

add_interface reset reset end
set_interface_property reset associatedClock clock
set_interface_property reset synchronousEdges BOTH
add_interface_port reset reset reset Input 1

add_interface csr avalon end
set_interface_property csr associatedClock clock
set_interface_property csr associatedReset reset
set_interface_property csr addressUnits WORDS
set_interface_property csr readLatency 1
set_interface_property csr readWaitTime 0
set_interface_property csr writeWaitTime 0
add_interface_port csr csr_address address Input 6
add_interface_port csr csr_read read Input 1
add_interface_port csr csr_readdata readdata Output 32
add_interface_port csr csr_write write Input 1
add_interface_port csr csr_writedata writedata Input 32

add_interface interrupt interrupt end
set_interface_property interrupt associatedAddressablePoint csr
set_interface_property interrupt associatedClock clock
set_interface_property interrupt associatedReset reset
add_interface_port interrupt irq irq Output 1

add_interface video avalon_streaming end
set_interface_property video associatedClock clock
set_interface_property video associatedReset reset
set_interface_property video dataBitsPerSymbol 16
set_interface_property video readyLatency 0
add_interface_port video video_ready ready Output 1
add_interface_port video video_valid valid Input 1
add_interface_port video video_data data Input 16
add_interface_port video video_startofpacket startofpacket Input 1
add_interface_port video video_endofpacket endofpacket Input 1

# One symbol of 256 bits: a record is one beat, word 0 in the lowest bits.
add_interface feature avalon_streaming start
set_interface_property feature associatedClock clock
set_interface_property feature associatedReset reset
set_interface_property feature dataBitsPerSymbol 256
set_interface_property feature readyLatency 0
add_interface_port feature feature_ready ready Input 1
add_interface_port feature feature_valid valid Output 1
add_interface_port feature feature_data data Output 256
add_interface_port feature feature_startofpacket startofpacket Output 1
add_interface_port feature feature_endofpacket endofpacket Output 1
