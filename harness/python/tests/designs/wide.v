// Wide ports, a signed port, a memory inside, and two levels of hierarchy: what handles must be able to reach.
module wide (
    input  wire               clk,
    input  wire        [99:0] a,
    input  wire signed [7:0]  s,
    output wire        [99:0] a_inverted,
    output wire signed [8:0]  s_twice,
    input  wire        [3:0]  write_at,
    input  wire        [15:0] write_data,
    input  wire               write,
    output wire        [15:0] read_data
);
    assign a_inverted = ~a;
    assign s_twice = {s[7], s} + {s[7], s};
    store u_store (.clk(clk), .at(write_at), .data(write_data), .write(write), .read(read_data));
endmodule

module store (
    input  wire        clk,
    input  wire [3:0]  at,
    input  wire [15:0] data,
    input  wire        write,
    output wire [15:0] read
);
    reg [15:0] cells [0:15];
    integer i;
    initial for (i = 0; i < 16; i = i + 1) cells[i] = 0;
    always @(posedge clk) if (write) cells[at] <= data;
    assign read = cells[at];
endmodule
