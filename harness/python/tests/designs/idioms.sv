// What the benches of test_cocotb_idioms.py are about: ports, arrays, instances, parameters, internals.
module idioms #(parameter int WIDTH = 8, parameter int N = 4, parameter string NAME = "idioms") (
    input  logic             clk,
    input  logic             rst_n,
    input  logic             ena,
    input  logic [WIDTH-1:0] ui_in,
    output logic [WIDTH-1:0] uo_out,
    output logic             tick,
    input  logic [WIDTH-1:0] a_i [N],
    output logic [WIDTH-1:0] b_o [N],
    input  logic [1:0]       down_i [2:0],
    output logic [5:0]       down_o
);
    localparam int DOUBLE = 2 * WIDTH;
    logic [WIDTH-1:0] sum;
    logic [7:0] mem [15:0];
    typedef enum logic [1:0] {IDLE, BUSY, DONE} state_t;
    state_t state;
    for (genvar g = 0; g < N; g++) begin : lane
        adds #(.BY(g)) u_adds (.x(a_i[g]), .y(b_o[g]));
    end
    assign down_o = {down_i[2], down_i[1], down_i[0]};
    assign uo_out = sum;
    always_ff @(posedge clk)
        if (!rst_n) begin
            sum <= 0;
            tick <= 0;
            state <= IDLE;
        end else if (ena) begin
            sum <= sum + ui_in;
            tick <= !tick;
            mem[sum[3:0]] <= ui_in;
            state <= state == DONE ? IDLE : state_t'(state + 1);
        end
endmodule

module adds #(parameter int BY = 0, parameter int WIDTH = 8) (input logic [WIDTH-1:0] x, output logic [WIDTH-1:0] y);
    assign y = x + WIDTH'(BY);
endmodule
