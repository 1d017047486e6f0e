// AXI4: wires from one side of the bus to the other.
module axi4_wires (
    input  wire        clk, rst,
    input  wire [15:0] s_axi_awaddr, s_axi_araddr, input wire [7:0] s_axi_awlen, s_axi_arlen,
    input  wire [2:0]  s_axi_awsize, s_axi_arsize, input wire [1:0] s_axi_awburst, s_axi_arburst,
    input  wire [3:0]  s_axi_awid, s_axi_arid, s_axi_wstrb, input wire [31:0] s_axi_wdata,
    input  wire        s_axi_awvalid, s_axi_wvalid, s_axi_wlast, s_axi_arvalid, s_axi_bready, s_axi_rready,
    output wire        s_axi_awready, s_axi_wready, s_axi_arready, s_axi_bvalid, s_axi_rvalid, s_axi_rlast,
    output wire [3:0]  s_axi_bid, s_axi_rid, output wire [1:0] s_axi_bresp, s_axi_rresp, output wire [31:0] s_axi_rdata,
    output wire [15:0] m_axi_awaddr, m_axi_araddr, output wire [7:0] m_axi_awlen, m_axi_arlen,
    output wire [2:0]  m_axi_awsize, m_axi_arsize, output wire [1:0] m_axi_awburst, m_axi_arburst,
    output wire [3:0]  m_axi_awid, m_axi_arid, m_axi_wstrb, output wire [31:0] m_axi_wdata,
    output wire        m_axi_awvalid, m_axi_wvalid, m_axi_wlast, m_axi_arvalid, m_axi_bready, m_axi_rready,
    input  wire        m_axi_awready, m_axi_wready, m_axi_arready, m_axi_bvalid, m_axi_rvalid, m_axi_rlast,
    input  wire [3:0]  m_axi_bid, m_axi_rid, input wire [1:0] m_axi_bresp, m_axi_rresp, input wire [31:0] m_axi_rdata
);
    assign {m_axi_awaddr, m_axi_awlen, m_axi_awsize, m_axi_awburst, m_axi_awid, m_axi_awvalid}
         = {s_axi_awaddr, s_axi_awlen, s_axi_awsize, s_axi_awburst, s_axi_awid, s_axi_awvalid};
    assign {m_axi_araddr, m_axi_arlen, m_axi_arsize, m_axi_arburst, m_axi_arid, m_axi_arvalid}
         = {s_axi_araddr, s_axi_arlen, s_axi_arsize, s_axi_arburst, s_axi_arid, s_axi_arvalid};
    assign {m_axi_wdata, m_axi_wstrb, m_axi_wlast, m_axi_wvalid} = {s_axi_wdata, s_axi_wstrb, s_axi_wlast, s_axi_wvalid};
    assign {m_axi_bready, m_axi_rready} = {s_axi_bready, s_axi_rready};
    assign {s_axi_awready, s_axi_wready, s_axi_arready} = {m_axi_awready, m_axi_wready, m_axi_arready};
    assign {s_axi_bvalid, s_axi_bid, s_axi_bresp} = {m_axi_bvalid, m_axi_bid, m_axi_bresp};
    assign {s_axi_rvalid, s_axi_rid, s_axi_rresp, s_axi_rlast, s_axi_rdata} = {m_axi_rvalid, m_axi_rid, m_axi_rresp, m_axi_rlast, m_axi_rdata};
endmodule
