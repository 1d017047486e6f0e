// An AXI4-Lite master that copies `count` words from address 0 on to address 1024 on, adding 1.
module copier_axi (
    input  wire        clk,
    input  wire        rst_n,
    input  wire        start,
    input  wire [7:0]  count,
    output reg         done,
    output wire [15:0] m_axi_awaddr,
    output reg         m_axi_awvalid,
    input  wire        m_axi_awready,
    output reg  [31:0] m_axi_wdata,
    output wire [3:0]  m_axi_wstrb,
    output reg         m_axi_wvalid,
    input  wire        m_axi_wready,
    input  wire [1:0]  m_axi_bresp,
    input  wire        m_axi_bvalid,
    output wire        m_axi_bready,
    output wire [15:0] m_axi_araddr,
    output reg         m_axi_arvalid,
    input  wire        m_axi_arready,
    input  wire [31:0] m_axi_rdata,
    input  wire [1:0]  m_axi_rresp,
    input  wire        m_axi_rvalid,
    output wire        m_axi_rready
);
    reg [7:0] at;
    reg busy;
    assign m_axi_araddr = {6'd0, at, 2'd0};
    assign m_axi_awaddr = {6'd1, at, 2'd0};
    assign m_axi_wstrb = 4'hf;
    assign m_axi_bready = busy;
    assign m_axi_rready = busy;
    always @(posedge clk)
        if (!rst_n) begin
            {done, busy, m_axi_arvalid, m_axi_awvalid, m_axi_wvalid} <= 0;
            at <= 0;
        end else begin
            done <= 0;
            if (!busy && start) begin
                busy <= 1;
                at <= 0;
                m_axi_arvalid <= 1;
            end
            if (m_axi_arvalid && m_axi_arready) m_axi_arvalid <= 0;
            if (m_axi_rvalid && m_axi_rready) begin
                m_axi_wdata <= m_axi_rdata + 1;
                m_axi_awvalid <= 1;
                m_axi_wvalid <= 1;
            end
            if (m_axi_awvalid && m_axi_awready) m_axi_awvalid <= 0;
            if (m_axi_wvalid && m_axi_wready) m_axi_wvalid <= 0;
            if (m_axi_bvalid && m_axi_bready) begin
                if (at + 1'b1 == count) begin
                    busy <= 0;
                    done <= 1;
                end else begin
                    at <= at + 1'b1;
                    m_axi_arvalid <= 1;
                end
            end
        end
endmodule
