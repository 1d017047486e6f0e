// Three registers in a row, and their sum with the input as logic: what each region shows of it is known.
module chain (
    input  wire       clk,
    input  wire       clk_b,
    input  wire [7:0] d,
    output reg  [7:0] q1,
    output reg  [7:0] q2,
    output reg  [7:0] q_fall,
    output reg  [7:0] q_b,
    output wire [7:0] sum
);
    initial begin q1 = 0; q2 = 0; q_fall = 0; q_b = 0; end
    assign sum = d + q1;
    always @(posedge clk) begin
        q1 <= d;
        q2 <= q1;
    end
    always @(negedge clk) q_fall <= d;
    always @(posedge clk_b) q_b <= q1;
endmodule
