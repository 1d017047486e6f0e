// Designs that connect inputs to outputs, wire by wire, so that a bench can break every rule of a bus.
module wires_st (
    input  wire        clk,
    input  wire        valid,
    input  wire [15:0] data,
    input  wire        first,
    input  wire        last,
    input  wire        empty,
    input  wire [1:0]  channel,
    output wire        out_valid,
    input  wire        out_ready,
    output wire [15:0] out_data,
    output wire        out_startofpacket,
    output wire        out_endofpacket,
    output wire        out_empty,
    output wire [1:0]  out_channel
);
    assign out_valid = valid;
    assign out_data = data;
    assign out_startofpacket = first;
    assign out_endofpacket = last;
    assign out_empty = empty;
    assign out_channel = channel;
endmodule

module wires_axis (
    input  wire        clk,
    input  wire        valid,
    input  wire [15:0] data,
    input  wire        last,
    input  wire [1:0]  id,
    output wire        out_tvalid,
    input  wire        out_tready,
    output wire [15:0] out_tdata,
    output wire        out_tlast,
    output wire [1:0]  out_tid
);
    assign out_tvalid = valid;
    assign out_tdata = data;
    assign out_tlast = last;
    assign out_tid = id;
endmodule

module wires_mm (
    input  wire        clk,
    input  wire        read,
    input  wire        write,
    input  wire [7:0]  address,
    input  wire [31:0] data,
    output wire        m_read,
    output wire        m_write,
    output wire [7:0]  m_address,
    output wire [31:0] m_writedata,
    input  wire [31:0] m_readdata,
    input  wire        m_readdatavalid,
    input  wire        m_waitrequest
);
    assign m_read = read;
    assign m_write = write;
    assign m_address = address;
    assign m_writedata = data;
endmodule

module wires_axi (
    input  wire        clk,
    input  wire        aw,
    input  wire        w,
    input  wire        ar,
    input  wire [7:0]  address,
    input  wire [31:0] data,
    output wire        m_awvalid,
    input  wire        m_awready,
    output wire [7:0]  m_awaddr,
    output wire        m_wvalid,
    input  wire        m_wready,
    output wire [31:0] m_wdata,
    output wire [3:0]  m_wstrb,
    input  wire        m_bvalid,
    output wire        m_bready,
    input  wire [1:0]  m_bresp,
    output wire        m_arvalid,
    input  wire        m_arready,
    output wire [7:0]  m_araddr,
    input  wire        m_rvalid,
    output wire        m_rready,
    input  wire [31:0] m_rdata,
    input  wire [1:0]  m_rresp
);
    assign m_awvalid = aw;
    assign m_awaddr = address;
    assign m_wvalid = w;
    assign m_wdata = data;
    assign m_wstrb = 4'hf;
    assign m_arvalid = ar;
    assign m_araddr = address;
    assign m_bready = 1'b1;
    assign m_rready = 1'b1;
endmodule

// Two such streams inside, one an inverted copy of the other.
module wires_inside (input wire clk, input wire valid, input wire [15:0] data, input wire last);
    wire [1:0] ready = 2'b11;
    genvar g;
    generate for (g = 0; g < 2; g = g + 1) begin : lane
        wire tvalid, tlast;
        wire [15:0] tdata;
        wire [1:0] tid;
        wires_axis u_wires (.clk(clk), .valid(valid), .data(g == 0 ? data : ~data), .last(last), .id(2'd0),
            .out_tvalid(tvalid), .out_tready(ready[g]), .out_tdata(tdata), .out_tlast(tlast), .out_tid(tid));
    end endgenerate
endmodule
