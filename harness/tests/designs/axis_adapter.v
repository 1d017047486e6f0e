// An AXI4-Stream width adapter: S bytes a beat in, M bytes a beat out, tkeep and tlast, one frame after the other.
module axis_adapter #(parameter S = 4, parameter M = 2, parameter USER = 1) (
    input  wire           clk,
    input  wire           rst_n,
    input  wire           s_axis_tvalid,
    output wire           s_axis_tready,
    input  wire [8*S-1:0] s_axis_tdata,
    input  wire [S-1:0]   s_axis_tkeep,
    input  wire           s_axis_tlast,
    input  wire [USER-1:0] s_axis_tuser,
    output wire           m_axis_tvalid,
    input  wire           m_axis_tready,
    output wire [8*M-1:0] m_axis_tdata,
    output wire [M-1:0]   m_axis_tkeep,
    output wire           m_axis_tlast,
    output wire [USER-1:0] m_axis_tuser
);
    localparam ROOM = 2 * (S + M);
    reg [8*ROOM-1:0] bytes;
    reg [15:0] count;
    reg last;
    reg [USER-1:0] user;
    integer i;
    reg [15:0] arriving;
    always @* begin
        arriving = 0;
        for (i = 0; i < S; i = i + 1) arriving = arriving + {15'd0, s_axis_tkeep[i]};
    end
    assign s_axis_tready = rst_n && !last && count + S <= ROOM - M;
    wire [15:0] leaving = count > M ? M : count;
    assign m_axis_tvalid = rst_n && (count >= M && (count > M || last) || last);
    assign m_axis_tdata = bytes[8*M-1:0];
    genvar g;
    generate for (g = 0; g < M; g = g + 1) begin : keep
        assign m_axis_tkeep[g] = g < leaving;
    end endgenerate
    assign m_axis_tlast = last && count <= M;
    assign m_axis_tuser = m_axis_tlast ? user : {USER{1'b0}};
    wire push = s_axis_tvalid && s_axis_tready;
    wire pop = m_axis_tvalid && m_axis_tready;
    wire [8*ROOM-1:0] after_pop = pop ? bytes >> (8 * leaving) : bytes;
    wire [15:0] count_after_pop = pop ? count - leaving : count;
    always @(posedge clk)
        if (!rst_n) begin
            bytes <= 0;
            count <= 0;
            last <= 0;
        end else begin
            bytes <= after_pop;
            count <= count_after_pop;
            if (pop && m_axis_tlast) last <= 0;
            if (push) begin
                bytes <= after_pop | ({{8*(ROOM-S){1'b0}}, s_axis_tdata} << (8 * count_after_pop));
                count <= count_after_pop + arriving;
                last <= s_axis_tlast;
                user <= s_axis_tuser;
            end
        end
endmodule
