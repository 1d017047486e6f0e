//! The folder `quartus/`: the component for Platform Designer, its timing exceptions, and the examples.
//!
//! `hoverlock_component.v` is the top of the component. It gives the streams of `hoverlock_top` the form of Intel's DMA
//! masters: symbols of 8 bits, the first in the highest bits. The master puts the symbols of a beat into memory in
//! their order, so symbol `k` is byte `k`.
//!
//! | stream | bytes of a beat | order |
//! |---|---|---|
//! | video | 1 for pixels of 8 bits, else 2 | the low byte of a pixel first |
//! | feature | 8 | 32-bit words of a record from the first, the low byte of each first |
//!
//! A record of 32 or 40 bytes takes 4 or 5 beats, because Intel's adapters and masters have no beats of 40 bytes.

use hoverlock_design::DesignPoint;
use hoverlock_registers::record::record_words;

use super::{File, banner, verilog_file};
use crate::design::MAX_HEIGHT;

/// Bytes of a beat of the feature stream.
const FEATURE_BYTES: u32 = 8;

/// What is the same for all designs.
const FIXED: [(&str, &str); 4] = [
    ("hoverlock.sdc", include_str!("../../quartus/hoverlock.sdc")),
    ("example.qpf", include_str!("../../quartus/example.qpf")),
    ("example.qsf", include_str!("../../quartus/example.qsf")),
    ("example.sdc", include_str!("../../quartus/example.sdc")),
];

/// The files of the folder `quartus/` of a design.
pub fn files(design: &DesignPoint) -> Vec<File> {
    let streams = Streams::of(design);
    let mut files = vec![
        ("hoverlock_component.v", streams.verilog()),
        ("hoverlock_hw.tcl", streams.component()),
        ("example_system.tcl", streams.system(design)),
    ];
    files.extend(FIXED.map(|(name, text)| (name, text.to_owned())));
    files.into_iter().map(|(name, text)| File { path: format!("quartus/{name}"), text }).collect()
}

/// The widths of the streams.
struct Streams {
    /// Bits of a pixel.
    pixel: u32,
    /// Bytes of a pixel.
    pixel_bytes: u32,
    /// Beats of a record.
    beats: u32,
}

impl Streams {
    fn of(design: &DesignPoint) -> Self {
        let pixel = design.pixel.bits();
        Self { pixel, pixel_bytes: pixel.div_ceil(8), beats: 4 * record_words(design.pairs()) as u32 / FEATURE_BYTES }
    }

    fn verilog(&self) -> String {
        let Self { pixel, pixel_bytes, beats } = *self;
        let (video_top, record_top) = (8 * pixel_bytes - 1, 64 * beats - 1);
        let beat_bits = beats.next_power_of_two().trailing_zeros();
        let beat_top = beat_bits - 1;
        let last_beat = beats - 1;
        let (empty_port, video) = match pixel {
            8 => ("", String::new()),
            _ => ("  input  wire video_empty,\n", self.video()),
        };
        let (video_data, video_end, pixel_text) = match pixel {
            8 => ("video_data", "video_endofpacket", "a byte a pixel"),
            _ => ("pixel", "pixel_end", "two bytes a pixel, the low one first"),
        };
        let bytes: Vec<String> = (0..8).map(|byte| format!("word[{}:{}]", 8 * byte + 7, 8 * byte)).collect();
        let (low, high) = (bytes[..4].join(", "), bytes[4..].join(", "));
        let order = format!("{{{low},\n                       {high}}}");
        verilog_file(&format!(
            "\
// The top of the Platform Designer component: hoverlock_top with streams of 8-bit symbols, the first in the highest
// bits, as a DMA master has them. It puts the symbols of a beat into memory in their order.
//   video     {pixel_text}
//   feature   8 bytes a beat, {beats} beats a record, the low byte of a word first; no beat is partly empty
// Latency: none.
module hoverlock_component (
  input  wire clock,
  input  wire reset,
  output wire video_ready,
  input  wire video_valid,
  input  wire [{video_top}:0] video_data,
{empty_port}  input  wire video_startofpacket,
  input  wire video_endofpacket,
  input  wire feature_ready,
  output wire feature_valid,
  output wire [63:0] feature_data,
  output wire [2:0] feature_empty,
  output wire feature_startofpacket,
  output wire feature_endofpacket,
  input  wire [5:0] csr_address,
  input  wire csr_read,
  output wire [31:0] csr_readdata,
  input  wire csr_write,
  input  wire [31:0] csr_writedata,
  output wire irq
);
{video}
wire record_valid;
wire [{record_top}:0] record;
wire record_start;
wire record_end;

// The beat of the record that is offered. A reset of the pipeline withdraws a record: the next one begins with beat 0.
reg [{beat_top}:0] beat;
wire last = beat == {beat_bits}'d{last_beat};

always @(posedge clock)
  if (reset | ~record_valid)
    beat <= {beat_bits}'d0;
  else if (feature_ready)
    beat <= last ? {beat_bits}'d0 : beat + {beat_bits}'d1;

wire [63:0] word = record[{{beat, 6'd0}} +: 64];

assign feature_valid = record_valid;
assign feature_data = {order};
assign feature_empty = 3'd0;
assign feature_startofpacket = record_start & (beat == {beat_bits}'d0);
assign feature_endofpacket = record_end & last;

hoverlock_top top (
  .clock(clock),
  .reset(reset),
  .video_ready(video_ready),
  .video_valid(video_valid),
  .video_data({video_data}),
  .video_startofpacket(video_startofpacket),
  .video_endofpacket({video_end}),
  .feature_ready(feature_ready & last),
  .feature_valid(record_valid),
  .feature_data(record),
  .feature_startofpacket(record_start),
  .feature_endofpacket(record_end),
  .csr_address(csr_address),
  .csr_read(csr_read),
  .csr_readdata(csr_readdata),
  .csr_write(csr_write),
  .csr_writedata(csr_writedata),
  .irq(irq)
);

endmodule
"
        ))
    }

    /// A pixel from its two bytes.
    fn video(&self) -> String {
        let (pixel, top) = (self.pixel, self.pixel - 1);
        let (high, unused) = match pixel {
            16 => (7, String::new()),
            _ => (
                pixel - 9,
                format!(
                    "// Bits above the pixel are not looked at.\nwire unused = |video_data[7:{low}];\n",
                    low = pixel - 8
                ),
            ),
        };
        format!(
            "
wire [{top}:0] pixel = {{video_data[{high}:0], video_data[15:8]}};
{unused}// Half a pixel at the end is no end: the frame is long, or goes on until the next one interrupts it.
wire pixel_end = video_endofpacket & ~video_empty;
"
        )
    }

    fn component(&self) -> String {
        let (symbols, bits) = (self.pixel_bytes, 8 * self.pixel_bytes);
        let empty = if symbols > 1 { "add_interface_port video video_empty empty Input 1\n" } else { "" };
        banner("#")
            + &format!(
                "# Platform Designer component: copy or link this folder and ../verilog into the IP search path.
package require -exact qsys 16.0

set_module_property NAME hoverlock
set_module_property DISPLAY_NAME \"Hoverlock feature extractor\"
set_module_property DESCRIPTION \"Avalon-ST video in, feature records out, one pixel per clock\"
set_module_property VERSION 1.0
set_module_property GROUP \"Video\"
set_module_property EDITABLE false

# The sources come from the file list.
add_fileset synthesis QUARTUS_SYNTH add_sources
add_fileset simulation SIM_VERILOG add_verilog
set_fileset_property synthesis TOP_LEVEL hoverlock_component
set_fileset_property simulation TOP_LEVEL hoverlock_component
proc add_sources {{entity}} {{
    set here [get_module_property MODULE_DIRECTORY]
    add_fileset_file hoverlock.sdc SDC PATH [file join $here hoverlock.sdc]
    add_verilog $entity
}}
proc add_verilog {{entity}} {{
    set here [get_module_property MODULE_DIRECTORY]
    add_fileset_file hoverlock_component.v VERILOG PATH [file join $here hoverlock_component.v]
    set folder [file join $here .. verilog]
    set list [open [file join $folder hoverlock.f]]
    while {{[gets $list line] >= 0}} {{
        if {{[string match *.v $line]}} {{ add_fileset_file $line VERILOG PATH [file join $folder $line] }}
    }}
    close $list
}}

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

# A beat is a pixel, its low byte first.
add_interface video avalon_streaming end
set_interface_property video associatedClock clock
set_interface_property video associatedReset reset
set_interface_property video dataBitsPerSymbol 8
set_interface_property video symbolsPerBeat {symbols}
set_interface_property video firstSymbolInHighOrderBits true
set_interface_property video readyLatency 0
add_interface_port video video_ready ready Output 1
add_interface_port video video_valid valid Input 1
add_interface_port video video_data data Input {bits}
{empty}add_interface_port video video_startofpacket startofpacket Input 1
add_interface_port video video_endofpacket endofpacket Input 1

# A record is {beats} beats, its bytes in the order in which they lie in memory.
add_interface feature avalon_streaming start
set_interface_property feature associatedClock clock
set_interface_property feature associatedReset reset
set_interface_property feature dataBitsPerSymbol 8
set_interface_property feature symbolsPerBeat 8
set_interface_property feature firstSymbolInHighOrderBits true
set_interface_property feature readyLatency 0
add_interface_port feature feature_ready ready Input 1
add_interface_port feature feature_valid valid Output 1
add_interface_port feature feature_data data Output 64
add_interface_port feature feature_empty empty Output 3
add_interface_port feature feature_startofpacket startofpacket Output 1
add_interface_port feature feature_endofpacket endofpacket Output 1
",
                beats = self.beats
            )
    }

    fn system(&self, design: &DesignPoint) -> String {
        let bits = 8 * self.pixel_bytes;
        // The DMA's lengths are powers of two.
        let frame = (design.width * self.pixel_bytes * MAX_HEIGHT as u32).next_power_of_two();
        banner("#")
            + &format!(
                "\
# A system around the component, with two Modular Scatter-Gather DMAs: frames in memory become features in memory.
#   qsys-script --script=example_system.tcl --search-path=\".,\\$\"
package require -exact qsys 16.0

create_system example_system
set_project_property DEVICE_FAMILY {{Arria V}}
set_project_property DEVICE 5AGXMA1D4F27C5

add_instance clk clock_source
set_instance_parameter_value clk clockFrequency 100000000.0
set_instance_parameter_value clk clockFrequencyKnown 1
set_instance_parameter_value clk resetSynchronousEdges DEASSERT

add_instance hoverlock hoverlock

# Memory to stream; a packet is a frame.
add_instance frames altera_msgdma
set_instance_parameter_value frames MODE 1
set_instance_parameter_value frames DATA_WIDTH {bits}
set_instance_parameter_value frames MAX_BYTE {frame}
set_instance_parameter_value frames PACKET_ENABLE 1
set_instance_parameter_value frames TRANSFER_TYPE {{Full Word Accesses Only}}

# Stream to memory; the response says how many bytes a packet has.
add_instance features altera_msgdma
set_instance_parameter_value features MODE 2
set_instance_parameter_value features DATA_WIDTH 64
set_instance_parameter_value features MAX_BYTE 65536
set_instance_parameter_value features PACKET_ENABLE 1
set_instance_parameter_value features TRANSFER_TYPE {{Full Word Accesses Only}}
set_instance_parameter_value features RESPONSE_PORT 0

add_connection clk.clk hoverlock.clock
add_connection clk.clk frames.clock
add_connection clk.clk features.clock
add_connection clk.clk_reset hoverlock.reset
add_connection clk.clk_reset frames.reset_n
add_connection clk.clk_reset features.reset_n
add_connection frames.st_source hoverlock.video
add_connection hoverlock.feature features.st_sink

# Memory, CPU and interrupts are those of the system around.
foreach {{name type direction}} {{
    clk.clk_in                clock     sink
    clk.clk_in_reset          reset     sink
    hoverlock.csr             avalon    slave
    hoverlock.interrupt       interrupt sender
    frames.csr                avalon    slave
    frames.csr_irq            interrupt sender
    frames.descriptor_slave   avalon    slave
    frames.mm_read            avalon    master
    features.csr              avalon    slave
    features.csr_irq          interrupt sender
    features.descriptor_slave avalon    slave
    features.response         avalon    slave
    features.mm_write         avalon    master
}} {{
    set exported [string map {{. _}} $name]
    add_interface $exported $type $direction
    set_interface_property $exported EXPORT_OF $name
}}

save_system example_system.qsys
"
            )
    }
}
