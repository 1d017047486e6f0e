// Ports joined in pairs, so that what one model drives another one takes: AXI4, AXI4-Lite, AXI4-Stream, GMII, UART, SPI; and an
// I2C bus with the wired AND of two devices.
module joined (
    input  wire clk, rst,
    input  wire [7:0] s_axi_awid, output wire [7:0] m_axi_awid,
    input  wire [15:0] s_axi_awaddr, output wire [15:0] m_axi_awaddr,
    input  wire [7:0] s_axi_awlen, output wire [7:0] m_axi_awlen,
    input  wire [2:0] s_axi_awsize, output wire [2:0] m_axi_awsize,
    input  wire [1:0] s_axi_awburst, output wire [1:0] m_axi_awburst,
    input  wire s_axi_awlock, output wire m_axi_awlock,
    input  wire [3:0] s_axi_awcache, output wire [3:0] m_axi_awcache,
    input  wire [2:0] s_axi_awprot, output wire [2:0] m_axi_awprot,
    input  wire s_axi_awvalid, output wire m_axi_awvalid,
    input  wire [31:0] s_axi_wdata, output wire [31:0] m_axi_wdata,
    input  wire [3:0] s_axi_wstrb, output wire [3:0] m_axi_wstrb,
    input  wire s_axi_wlast, output wire m_axi_wlast,
    input  wire s_axi_wvalid, output wire m_axi_wvalid,
    input  wire s_axi_bready, output wire m_axi_bready,
    input  wire [7:0] s_axi_arid, output wire [7:0] m_axi_arid,
    input  wire [15:0] s_axi_araddr, output wire [15:0] m_axi_araddr,
    input  wire [7:0] s_axi_arlen, output wire [7:0] m_axi_arlen,
    input  wire [2:0] s_axi_arsize, output wire [2:0] m_axi_arsize,
    input  wire [1:0] s_axi_arburst, output wire [1:0] m_axi_arburst,
    input  wire s_axi_arlock, output wire m_axi_arlock,
    input  wire [3:0] s_axi_arcache, output wire [3:0] m_axi_arcache,
    input  wire [2:0] s_axi_arprot, output wire [2:0] m_axi_arprot,
    input  wire s_axi_arvalid, output wire m_axi_arvalid,
    input  wire s_axi_rready, output wire m_axi_rready,
    input  wire m_axi_awready, output wire s_axi_awready,
    input  wire m_axi_wready, output wire s_axi_wready,
    input  wire [7:0] m_axi_bid, output wire [7:0] s_axi_bid,
    input  wire [1:0] m_axi_bresp, output wire [1:0] s_axi_bresp,
    input  wire m_axi_bvalid, output wire s_axi_bvalid,
    input  wire m_axi_arready, output wire s_axi_arready,
    input  wire [7:0] m_axi_rid, output wire [7:0] s_axi_rid,
    input  wire [31:0] m_axi_rdata, output wire [31:0] s_axi_rdata,
    input  wire [1:0] m_axi_rresp, output wire [1:0] s_axi_rresp,
    input  wire m_axi_rlast, output wire s_axi_rlast,
    input  wire m_axi_rvalid, output wire s_axi_rvalid,
    input  wire [15:0] BUS_AWADDR, output wire [15:0] m_axil_awaddr,
    input  wire [2:0] BUS_AWPROT, output wire [2:0] m_axil_awprot,
    input  wire BUS_AWVALID, output wire m_axil_awvalid,
    input  wire [31:0] BUS_WDATA, output wire [31:0] m_axil_wdata,
    input  wire [3:0] BUS_WSTRB, output wire [3:0] m_axil_wstrb,
    input  wire BUS_WVALID, output wire m_axil_wvalid,
    input  wire BUS_BREADY, output wire m_axil_bready,
    input  wire [15:0] BUS_ARADDR, output wire [15:0] m_axil_araddr,
    input  wire [2:0] BUS_ARPROT, output wire [2:0] m_axil_arprot,
    input  wire BUS_ARVALID, output wire m_axil_arvalid,
    input  wire BUS_RREADY, output wire m_axil_rready,
    input  wire m_axil_awready, output wire BUS_AWREADY,
    input  wire m_axil_wready, output wire BUS_WREADY,
    input  wire [1:0] m_axil_bresp, output wire [1:0] BUS_BRESP,
    input  wire m_axil_bvalid, output wire BUS_BVALID,
    input  wire m_axil_arready, output wire BUS_ARREADY,
    input  wire [31:0] m_axil_rdata, output wire [31:0] BUS_RDATA,
    input  wire [1:0] m_axil_rresp, output wire [1:0] BUS_RRESP,
    input  wire m_axil_rvalid, output wire BUS_RVALID,
    input  wire [15:0] s_axis_tdata, output wire [15:0] m_axis_tdata,
    input  wire [1:0] s_axis_tkeep, output wire [1:0] m_axis_tkeep,
    input  wire s_axis_tvalid, output wire m_axis_tvalid,
    input  wire s_axis_tlast, output wire m_axis_tlast,
    input  wire s_axis_tuser, output wire m_axis_tuser,
    input  wire m_axis_tready, output wire s_axis_tready,
    input  wire [7:0] gmii_rxd, output wire [7:0] gmii_txd,
    input  wire gmii_rx_er, output wire gmii_tx_er,
    input  wire gmii_rx_dv, output wire gmii_tx_en,
    input  wire uart_rxd, output wire uart_txd,
    input  wire master_sclk, output wire slave_sclk,
    input  wire master_mosi, output wire slave_mosi,
    input  wire master_cs, output wire slave_cs,
    input  wire slave_miso, output wire master_miso,
    input  wire sda_1_o, sda_2_o, scl_1_o, scl_2_o,
    output wire sda_i, scl_i
);
    assign m_axi_awid = s_axi_awid;
    assign m_axi_awaddr = s_axi_awaddr;
    assign m_axi_awlen = s_axi_awlen;
    assign m_axi_awsize = s_axi_awsize;
    assign m_axi_awburst = s_axi_awburst;
    assign m_axi_awlock = s_axi_awlock;
    assign m_axi_awcache = s_axi_awcache;
    assign m_axi_awprot = s_axi_awprot;
    assign m_axi_awvalid = s_axi_awvalid;
    assign m_axi_wdata = s_axi_wdata;
    assign m_axi_wstrb = s_axi_wstrb;
    assign m_axi_wlast = s_axi_wlast;
    assign m_axi_wvalid = s_axi_wvalid;
    assign m_axi_bready = s_axi_bready;
    assign m_axi_arid = s_axi_arid;
    assign m_axi_araddr = s_axi_araddr;
    assign m_axi_arlen = s_axi_arlen;
    assign m_axi_arsize = s_axi_arsize;
    assign m_axi_arburst = s_axi_arburst;
    assign m_axi_arlock = s_axi_arlock;
    assign m_axi_arcache = s_axi_arcache;
    assign m_axi_arprot = s_axi_arprot;
    assign m_axi_arvalid = s_axi_arvalid;
    assign m_axi_rready = s_axi_rready;
    assign s_axi_awready = m_axi_awready;
    assign s_axi_wready = m_axi_wready;
    assign s_axi_bid = m_axi_bid;
    assign s_axi_bresp = m_axi_bresp;
    assign s_axi_bvalid = m_axi_bvalid;
    assign s_axi_arready = m_axi_arready;
    assign s_axi_rid = m_axi_rid;
    assign s_axi_rdata = m_axi_rdata;
    assign s_axi_rresp = m_axi_rresp;
    assign s_axi_rlast = m_axi_rlast;
    assign s_axi_rvalid = m_axi_rvalid;
    assign m_axil_awaddr = BUS_AWADDR;
    assign m_axil_awprot = BUS_AWPROT;
    assign m_axil_awvalid = BUS_AWVALID;
    assign m_axil_wdata = BUS_WDATA;
    assign m_axil_wstrb = BUS_WSTRB;
    assign m_axil_wvalid = BUS_WVALID;
    assign m_axil_bready = BUS_BREADY;
    assign m_axil_araddr = BUS_ARADDR;
    assign m_axil_arprot = BUS_ARPROT;
    assign m_axil_arvalid = BUS_ARVALID;
    assign m_axil_rready = BUS_RREADY;
    assign BUS_AWREADY = m_axil_awready;
    assign BUS_WREADY = m_axil_wready;
    assign BUS_BRESP = m_axil_bresp;
    assign BUS_BVALID = m_axil_bvalid;
    assign BUS_ARREADY = m_axil_arready;
    assign BUS_RDATA = m_axil_rdata;
    assign BUS_RRESP = m_axil_rresp;
    assign BUS_RVALID = m_axil_rvalid;
    assign m_axis_tdata = s_axis_tdata;
    assign m_axis_tkeep = s_axis_tkeep;
    assign m_axis_tvalid = s_axis_tvalid;
    assign m_axis_tlast = s_axis_tlast;
    assign m_axis_tuser = s_axis_tuser;
    assign s_axis_tready = m_axis_tready;
    assign gmii_txd = gmii_rxd;
    assign gmii_tx_er = gmii_rx_er;
    assign gmii_tx_en = gmii_rx_dv;
    assign uart_txd = uart_rxd;
    assign slave_sclk = master_sclk;
    assign slave_mosi = master_mosi;
    assign slave_cs = master_cs;
    assign master_miso = slave_miso;
    assign sda_i = sda_1_o & sda_2_o;
    assign scl_i = scl_1_o & scl_2_o;
endmodule
