// Signals of every storage: 1 to 512 bits, an array of ports' worth in memory, signed ones, odd names.
module wide (
    input  wire                clk,
    input  wire        [99:0]  a,
    output reg         [99:0]  a_next,
    input  wire        [511:0] b,
    output wire        [511:0] b_swapped,
    input  wire        [63:0]  c,
    output wire        [63:0]  c_inverted,
    input  wire signed [4:0]   s,
    output wire signed [15:0]  s_extended,
    input  wire        [32:0]  video$data,
    output wire        [16:0]  top$bits
);
    assign b_swapped = {b[255:0], b[511:256]};
    assign c_inverted = ~c;
    assign s_extended = s;
    assign top$bits = video$data[32:16];
    reg [39:0] memory [3:10];
    always @(posedge clk) begin
        a_next <= a + 1;
        memory[4] <= memory[3] + 1;
    end
endmodule
