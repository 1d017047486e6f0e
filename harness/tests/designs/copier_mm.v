// An Avalon-MM master that copies `count` words from address 0 on to address 256 on, adding 1. With FAULT 1 it moves
// its address on while it is stalled.
module copier_mm #(parameter FAULT = 0) (
    input  wire        clk,
    input  wire        rst,
    input  wire        start,
    input  wire [7:0]  count,
    output reg         done,
    output reg  [15:0] m_address,
    output reg         m_read,
    output reg         m_write,
    output reg  [31:0] m_writedata,
    input  wire [31:0] m_readdata,
    input  wire        m_readdatavalid,
    input  wire        m_waitrequest
);
    reg [7:0] at;
    reg busy;
    always @(posedge clk)
        if (rst) begin
            {done, m_read, m_write, busy} <= 0;
            at <= 0;
            m_address <= 0;
        end else if (!busy) begin
            done <= 0;
            if (start) begin
                busy <= 1;
                at <= 0;
                m_read <= 1;
                m_address <= 0;
            end
        end else if (m_read) begin
            if (!m_waitrequest) m_read <= 0;
            else if (FAULT != 0) m_address <= m_address + 1'b1;
        end else if (m_readdatavalid) begin
            m_write <= 1;
            m_writedata <= m_readdata + 1;
            m_address <= {8'd1, at};
        end else if (m_write && !m_waitrequest) begin
            m_write <= 0;
            if (at + 1'b1 == count) begin
                busy <= 0;
                done <= 1;
            end else begin
                at <= at + 1'b1;
                m_read <= 1;
                m_address <= {8'd0, at + 8'd1};
            end
        end
endmodule
