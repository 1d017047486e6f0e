// Four registers behind AXI4-Lite; an address beyond them is answered with an error.
module registers_axi (
    input  wire        clk,
    input  wire        rst_n,
    input  wire [7:0]  s_axi_awaddr,
    input  wire        s_axi_awvalid,
    output wire        s_axi_awready,
    input  wire [31:0] s_axi_wdata,
    input  wire [3:0]  s_axi_wstrb,
    input  wire        s_axi_wvalid,
    output wire        s_axi_wready,
    output reg  [1:0]  s_axi_bresp,
    output reg         s_axi_bvalid,
    input  wire        s_axi_bready,
    input  wire [7:0]  s_axi_araddr,
    input  wire        s_axi_arvalid,
    output wire        s_axi_arready,
    output reg  [31:0] s_axi_rdata,
    output reg  [1:0]  s_axi_rresp,
    output reg         s_axi_rvalid,
    input  wire        s_axi_rready
);
    reg [31:0] word [0:3];
    reg have_address, have_data;
    reg [7:0] address;
    reg [31:0] data;
    reg [3:0] strobe;
    integer i;
    assign s_axi_awready = rst_n && !have_address;
    assign s_axi_wready = rst_n && !have_data;
    assign s_axi_arready = rst_n && !s_axi_rvalid;
    always @(posedge clk)
        if (!rst_n) begin
            {have_address, have_data, s_axi_bvalid, s_axi_rvalid} <= 0;
            for (i = 0; i < 4; i = i + 1) word[i] <= 0;
        end else begin
            if (s_axi_awvalid && s_axi_awready) begin have_address <= 1; address <= s_axi_awaddr; end
            if (s_axi_wvalid && s_axi_wready) begin have_data <= 1; data <= s_axi_wdata; strobe <= s_axi_wstrb; end
            if (s_axi_bvalid && s_axi_bready) s_axi_bvalid <= 0;
            if (have_address && have_data && !s_axi_bvalid) begin
                s_axi_bvalid <= 1;
                s_axi_bresp <= address[7:4] != 0 ? 2'd2 : 2'd0;
                have_address <= 0;
                have_data <= 0;
                if (address[7:4] == 0)
                    for (i = 0; i < 4; i = i + 1)
                        if (strobe[i]) word[address[3:2]][8*i +: 8] <= data[8*i +: 8];
            end
            if (s_axi_rvalid && s_axi_rready) s_axi_rvalid <= 0;
            if (s_axi_arvalid && s_axi_arready) begin
                s_axi_rvalid <= 1;
                s_axi_rdata <= word[s_axi_araddr[3:2]];
                s_axi_rresp <= s_axi_araddr[7:4] != 0 ? 2'd3 : 2'd0;
            end
        end
endmodule
