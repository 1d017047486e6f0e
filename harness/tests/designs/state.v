// Registers of every kind among variables that are none: an output of the top, a memory, a register written by a task,
// a register that "=" assigns, and a wide one; and a name for an expression, loop variables, a latch.
module state (
    input clk,
    input rst,
    input [7:0] in,
    output reg [7:0] out,
    output [7:0] inverted,
    output [7:0] word,
    output [99:0] chain,
    output [1:0] lanes
);
    reg [7:0] memory[4:11];
    reg [2:0] at;
    reg [99:0] shift;
    reg [7:0] total;
    reg [7:0] sum;
    reg [3:0] by_task;
    reg latch;
    integer i;

    assign inverted = ~out;
    assign word = memory[{29'd0, at} + 4];
    assign chain = shift;

    task count(input enable);
        if (enable) by_task <= by_task + 4'd1;
    endtask

    // "sum" is a name for an expression; "total" is a register.
    always @(posedge clk) begin
        sum = in + {4'd0, by_task};
        total = total + sum;
        if (rst) begin
            total = 0;
            at <= 0;
            by_task <= 0;
            shift <= 0;
            {out[7:4], out[3:0]} <= 8'd0;
            for (i = 4; i < 12; i = i + 1) memory[i] <= 8'd0;
        end else begin
            count(1'b1);
            at <= at + 3'd1;
            shift <= {shift[98:0], in[0]};
            out <= total ^ {7'd0, latch};
            memory[{29'd0, at} + 4] <= in;
        end
    end

    always @* if (in[7]) latch = in[6];

    generate
        genvar g;
        for (g = 0; g < 2; g = g + 1) begin : lane
            state_bit kept (.clk(clk), .d(in[g]), .q(lanes[g]));
        end
    endgenerate
endmodule

module state_bit (
    input clk,
    input d,
    output q
);
    reg kept;
    assign q = kept;
    always @(posedge clk) kept <= d;
endmodule
