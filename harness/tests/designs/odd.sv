// What is no plain vector: real ports, a real, a string, arrays of two dimensions, a memory wider than 64 bits; and what
// cannot be reached: an unpacked structure and a queue.
module odd (
    input  wire        clk,
    input  real        gain,
    output real        scaled,
    input  wire  [3:0] grid [0:1][0:2],
    output logic [3:0] corner,
    output logic [70:0] deepest
);
    real state;
    string text;
    logic [7:0] rows [0:3][0:1];
    logic [70:0] deep [-2:1];
    typedef struct {logic [3:0] x; int y;} loose_t;
    loose_t loose;
    int numbers [$];
    typedef struct packed {logic [3:0] tag; struct packed {logic signed [3:0] low; logic [3:0] rest;} body;} beat_t;
    beat_t beat;
    assign deepest = deep[-1];
    assign scaled = gain * 2.0 + state;
    assign corner = grid[1][2];
    always @(posedge clk) begin
        state <= gain;
        if (text == "") text = "tick";
        loose.x <= corner;
        numbers.push_back(1);
        rows[1][0] <= 8'd3;
        if (rows[1][0] == 8'd7) $display("%s", text);
    end
endmodule
