// An Avalon-MM master that reads `count` words in one burst and writes them, one more each, in another, `gap` cycles between them.
// Addresses count bytes. FAULT 1: burstcount 0; 2: a read inside the burst of writes.
module burst_copier #(parameter FAULT = 0) (
    input  wire        clk,
    input  wire        rst,
    input  wire        start,
    input  wire [3:0]  count,
    input  wire [7:0]  gap,
    output reg         done,
    output reg  [31:0] m_address,
    output reg         m_read,
    output reg         m_write,
    output reg  [31:0] m_writedata,
    output reg  [3:0]  m_burstcount,
    input  wire        m_waitrequest,
    input  wire        m_readdatavalid,
    input  wire [31:0] m_readdata
);
    reg [31:0] words [0:15];
    reg [3:0]  got, sent;
    reg [7:0]  paused;
    reg [2:0]  state;
    always @(posedge clk)
        if (rst) begin
            {m_read, m_write, done, state, got, sent, paused} <= 0;
        end else case (state)
            0: if (start) begin
                m_address <= 32'h100;
                m_burstcount <= FAULT == 1 ? 4'd0 : count;
                m_read <= 1;
                state <= 1;
            end
            1: if (!m_waitrequest) begin
                m_read <= 0;
                state <= 2;
            end
            2: if (got == count) begin
                m_address <= 32'h200;
                m_burstcount <= count;
                m_writedata <= words[0] + 1;
                m_write <= 1;
                state <= 3;
            end
            3: if (!m_waitrequest) begin
                sent <= sent + 1'b1;
                m_write <= 0;
                paused <= 0;
                // Only the first word of a burst needs its address.
                m_address <= 32'hdead_beef;
                if (sent + 1'b1 == count) begin
                    done <= 1;
                    state <= 5;
                end else if (gap == 0) begin
                    m_write <= 1;
                    m_writedata <= words[sent + 1] + 1;
                end else begin
                    state <= 4;
                    m_read <= FAULT == 2;
                end
            end
            4: begin
                paused <= paused + 1'b1;
                if (paused + 1'b1 == gap) begin
                    m_read <= 0;
                    m_write <= 1;
                    m_writedata <= words[sent] + 1;
                    state <= 3;
                end
            end
            default: ;
        endcase
    always @(posedge clk)
        if (!rst && m_readdatavalid) begin
            words[got] <= m_readdata;
            got <= got + 1'b1;
        end
endmodule
