// A RAM of 1024 words behind AXI4: bursts of increasing addresses, one write and one read at a time. STALL: it waits now and
// then. FAULT breaks one rule of the bus: 1 rlast a beat early, 2 the response before the last beat, 3 another id, 4 data that
// change while valid waits for ready, 5 valid that falls while it waits.
module ram_axi4 #(parameter STALL = 0, parameter FAULT = 0) (
    input  wire        clk,
    input  wire        rst,
    input  wire [3:0]  s_axi_awid,
    input  wire [15:0] s_axi_awaddr,
    input  wire [7:0]  s_axi_awlen,
    input  wire [2:0]  s_axi_awsize,
    input  wire [1:0]  s_axi_awburst,
    input  wire        s_axi_awvalid,
    output wire        s_axi_awready,
    input  wire [31:0] s_axi_wdata,
    input  wire [3:0]  s_axi_wstrb,
    input  wire        s_axi_wlast,
    input  wire        s_axi_wvalid,
    output wire        s_axi_wready,
    output wire [3:0]  s_axi_bid,
    output wire [1:0]  s_axi_bresp,
    output reg         s_axi_bvalid,
    input  wire        s_axi_bready,
    input  wire [3:0]  s_axi_arid,
    input  wire [15:0] s_axi_araddr,
    input  wire [7:0]  s_axi_arlen,
    input  wire [2:0]  s_axi_arsize,
    input  wire [1:0]  s_axi_arburst,
    input  wire        s_axi_arvalid,
    output wire        s_axi_arready,
    output wire [3:0]  s_axi_rid,
    output reg  [31:0] s_axi_rdata,
    output wire [1:0]  s_axi_rresp,
    output reg         s_axi_rlast,
    output reg         s_axi_rvalid,
    input  wire        s_axi_rready
);
    reg [31:0] words [0:1023];
    reg [15:0] lfsr;
    wire pause = STALL != 0 && lfsr[0];
    reg writing, reading, bad_write;
    reg [9:0] write_at, read_at;
    reg [7:0] beats_left;
    reg [3:0] write_id, read_id;
    integer i;

    assign s_axi_awready = !writing && !s_axi_bvalid && !pause;
    assign s_axi_wready = writing && !pause;
    assign s_axi_arready = !reading && !pause;
    assign s_axi_bid = FAULT == 3 ? ~write_id : write_id;
    assign s_axi_rid = read_id;
    // Only whole words at increasing addresses.
    assign s_axi_bresp = bad_write ? 2'b10 : 2'b00;
    assign s_axi_rresp = 2'b00;

    always @(posedge clk)
        if (rst) begin
            lfsr <= 16'hace1;
            writing <= 0;
            reading <= 0;
            s_axi_bvalid <= 0;
            s_axi_rvalid <= 0;
        end else begin
            lfsr <= {lfsr[14:0], lfsr[15] ^ lfsr[13] ^ lfsr[12] ^ lfsr[10]};
            if (s_axi_awvalid && s_axi_awready) begin
                writing <= 1;
                write_at <= s_axi_awaddr[11:2];
                write_id <= s_axi_awid;
                bad_write <= s_axi_awsize != 2 || s_axi_awburst != 1;
                if (FAULT == 2) s_axi_bvalid <= 1;
            end
            if (s_axi_wvalid && s_axi_wready) begin
                for (i = 0; i < 4; i = i + 1)
                    if (s_axi_wstrb[i]) words[write_at][8*i +: 8] <= s_axi_wdata[8*i +: 8];
                write_at <= write_at + 1;
                if (s_axi_wlast) begin
                    writing <= 0;
                    s_axi_bvalid <= 1;
                end
            end
            if (s_axi_bvalid && s_axi_bready) s_axi_bvalid <= 0;
            if (s_axi_arvalid && s_axi_arready) begin
                reading <= 1;
                read_at <= s_axi_araddr[11:2];
                read_id <= s_axi_arid;
                beats_left <= s_axi_arlen;
            end
            if (s_axi_rvalid && !s_axi_rready) begin
                if (FAULT == 4) s_axi_rdata <= s_axi_rdata + 1;
                if (FAULT == 5) s_axi_rvalid <= 0;
            end else begin
                s_axi_rvalid <= reading && !pause && !(s_axi_rvalid && s_axi_rlast && FAULT != 1);
                if (reading && !pause) begin
                    s_axi_rdata <= words[read_at];
                    s_axi_rlast <= beats_left == (FAULT == 1 ? 1 : 0);
                    read_at <= read_at + 1;
                    beats_left <= beats_left - 1;
                    if (beats_left == 0) reading <= 0;
                end
            end
        end
endmodule
