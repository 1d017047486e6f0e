// Vectors whose bits are not declared as [width-1:0], and a register that counts.
module ranges (
    input  wire        clk,
    input  wire [0:7]  up,
    input  wire [8:1]  from_one,
    input  wire [-2:3] around,
    input  wire [0:70] long_up,
    output wire [7:0]  up_as_number,
    output wire [7:0]  from_one_as_number,
    output wire [5:0]  around_as_number,
    output wire [70:0] long_as_number,
    output wire [7:0]  counted
);
    assign up_as_number = up;
    assign from_one_as_number = from_one;
    assign around_as_number = around;
    assign long_as_number = long_up;
    reg [7:0] count;
    assign counted = count;
    initial count = 0;
    always @(posedge clk) count <= count + 8'd1;
endmodule
