// Masters' signals as the bench drives them: what a design may do wrong, to be caught by a memory.
module wires (
    input  wire        clk,
    input  wire        rst_n,
    input  wire [15:0] awaddr, araddr,
    input  wire        awvalid, wvalid, arvalid, bready, rready,
    input  wire [31:0] wdata,
    input  wire [3:0]  wstrb,
    output wire [15:0] m_axi_awaddr, m_axi_araddr,
    output wire        m_axi_awvalid, m_axi_wvalid, m_axi_arvalid, m_axi_bready, m_axi_rready,
    output wire [31:0] m_axi_wdata,
    output wire [3:0]  m_axi_wstrb,
    input  wire        m_axi_awready, m_axi_wready, m_axi_arready, m_axi_bvalid, m_axi_rvalid,
    input  wire [1:0]  m_axi_bresp, m_axi_rresp,
    input  wire [31:0] m_axi_rdata,
    input  wire [7:0]  address,
    input  wire        read, write,
    input  wire [31:0] writedata,
    output wire [7:0]  m_address,
    output wire        m_read, m_write,
    output wire [31:0] m_writedata,
    input  wire        m_waitrequest, m_readdatavalid,
    input  wire [31:0] m_readdata
);
    assign {m_axi_awaddr, m_axi_araddr} = {awaddr, araddr};
    assign {m_axi_awvalid, m_axi_wvalid, m_axi_arvalid, m_axi_bready, m_axi_rready} = {awvalid, wvalid, arvalid, bready, rready};
    assign {m_axi_wdata, m_axi_wstrb} = {wdata, wstrb};
    assign {m_address, m_read, m_write, m_writedata} = {address, read, write, writedata};
endmodule
