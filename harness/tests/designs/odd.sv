// What is no vector: a real port, a real, a string and an array of two dimensions inside. And a port of two dimensions.
module odd (
    input  wire        clk,
    input  real        gain,
    output real        scaled,
    input  wire  [3:0] grid [0:1][0:2],
    output logic [3:0] corner
);
    real state;
    string text;
    logic [7:0] rows [0:3][0:1];
    assign scaled = gain * 2.0 + state;
    assign corner = grid[1][2];
    always @(posedge clk) begin
        state <= gain;
        text = "tick";
        rows[1][0] <= 8'd3;
        if (rows[1][0] == 8'd7) $display("%s", text);
    end
endmodule
