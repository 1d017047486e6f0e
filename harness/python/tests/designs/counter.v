// Counts up by `step` while enabled; `wrapped` is 1 after a step that overflows.
module counter #(parameter WIDTH = 8) (
    input  wire             clk,
    input  wire             rst,
    input  wire             enable,
    input  wire [WIDTH-1:0] step,
    output reg  [WIDTH-1:0] count,
    output reg              wrapped
);
    wire [WIDTH:0] next = {1'b0, count} + {1'b0, step};
    always @(posedge clk)
        if (rst) begin
            count <= 0;
            wrapped <= 0;
        end else if (enable) begin
            count <= next[WIDTH-1:0];
            wrapped <= next[WIDTH];
        end
endmodule
