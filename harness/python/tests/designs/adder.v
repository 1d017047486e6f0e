// The sum of two numbers, one bit wider than they are.
module adder #(parameter DATA_WIDTH = 4) (
    input  wire [DATA_WIDTH-1:0] A,
    input  wire [DATA_WIDTH-1:0] B,
    output wire [DATA_WIDTH:0]   X
);
    assign X = {1'b0, A} + {1'b0, B};
endmodule
