// Small slaves and masters of several buses, and wires from one side of a bus to the other.
module buses (
    input  wire        clk, rst,
    // AXI4, through.
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
    input  wire [3:0]  m_axi_bid, m_axi_rid, input wire [1:0] m_axi_bresp, m_axi_rresp, input wire [31:0] m_axi_rdata,
    // APB: through, and two registers with a wait cycle; address 8 answers with an error.
    input  wire        s_psel, s_penable, s_pwrite, input wire [7:0] s_paddr, input wire [31:0] s_pwdata, input wire [3:0] s_pstrb,
    output wire        s_pready, s_pslverr, output wire [31:0] s_prdata,
    output wire        m_psel, m_penable, m_pwrite, output wire [7:0] m_paddr, output wire [31:0] m_pwdata, output wire [3:0] m_pstrb,
    input  wire        m_pready, m_pslverr, input wire [31:0] m_prdata,
    input  wire        r_psel, r_penable, r_pwrite, input wire [7:0] r_paddr, input wire [31:0] r_pwdata,
    output wire        r_pready, r_pslverr, output wire [31:0] r_prdata,
    // Wishbone: through, and a memory that answers at once; address 15 answers with an error.
    input  wire        s_cyc, s_stb, s_we, input wire [3:0] s_adr, s_sel, input wire [31:0] s_dat_i,
    output wire        s_ack, output wire [31:0] s_dat_o,
    output wire        m_cyc, m_stb, m_we, output wire [3:0] m_adr, m_sel, output wire [31:0] m_dat_o,
    input  wire        m_ack, input wire [31:0] m_dat_i,
    input  wire        r_cyc_i, r_stb_i, r_we_i, input wire [3:0] r_adr_i, r_sel_i, input wire [31:0] r_dat_w,
    output wire        r_ack_o, r_err_o, output wire [31:0] r_dat_r,
    // UART: a line through.
    input  wire        rxd, output wire txd
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

    assign {m_psel, m_penable, m_pwrite, m_paddr, m_pwdata, m_pstrb} = {s_psel, s_penable, s_pwrite, s_paddr, s_pwdata, s_pstrb};
    assign {s_pready, s_pslverr, s_prdata} = {m_pready, m_pslverr, m_prdata};
    reg [31:0] registers [0:1];
    reg waited;
    assign r_pready = waited;
    assign r_pslverr = r_penable & waited & r_paddr[3];
    assign r_prdata = registers[r_paddr[2]];
    always @(posedge clk) begin
        waited <= r_psel & r_penable & ~waited;
        if (r_psel & r_penable & waited & r_pwrite & ~r_paddr[3]) registers[r_paddr[2]] <= r_pwdata;
    end

    assign {m_cyc, m_stb, m_we, m_adr, m_sel, m_dat_o} = {s_cyc, s_stb, s_we, s_adr, s_sel, s_dat_i};
    assign {s_ack, s_dat_o} = {m_ack, m_dat_i};
    reg [31:0] words [0:15];
    assign r_err_o = r_cyc_i & r_stb_i & (&r_adr_i);
    assign r_ack_o = r_cyc_i & r_stb_i & ~(&r_adr_i);
    assign r_dat_r = words[r_adr_i];
    integer lane;
    always @(posedge clk) if (r_ack_o & r_we_i)
        for (lane = 0; lane < 4; lane = lane + 1) if (r_sel_i[lane]) words[r_adr_i][8*lane +: 8] <= r_dat_w[8*lane +: 8];

    assign txd = rxd;
endmodule
