// A D flip-flop.
module dff (
    input  wire clk,
    input  wire d,
    output reg  q
);
    initial q = 0;
    always @(posedge clk) q <= d;
endmodule
