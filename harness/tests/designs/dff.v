// A flip-flop with its input seen through logic as well.
module dff (input wire clk, input wire d, output reg q, output wire not_d);
    initial q = 0;
    assign not_d = !d;
    always @(posedge clk) q <= d;
endmodule
