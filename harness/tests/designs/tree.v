// Instances in generate loops, and parameters that make modules of their own: names as users write them.
module tree (input wire clk, output wire [7:0] total);
    wire [7:0] value [0:1];
    genvar g;
    generate for (g = 0; g < 2; g = g + 1) begin : lane
        leaf #(.STEP(g + 1)) u_leaf (.clk(clk), .value(value[g]));
    end endgenerate
    assign total = value[0] + value[1];
endmodule

module leaf #(parameter STEP = 1) (input wire clk, output wire [7:0] value);
    reg [7:0] count;
    reg [3:0] grid [0:1][0:2];
    initial count = 0;
    assign value = count;
    always @(posedge clk) begin
        count <= count + STEP;
        grid[0][1] <= count[3:0];
    end
endmodule
