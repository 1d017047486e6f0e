// What is no plain vector: real ports, a real, a string, arrays of reals, arrays of two dimensions, a memory wider than
// 64 bits, unpacked structures and arrays of them; and what cannot be reached: a queue.
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
    typedef enum logic [1:0] {IDLE, RUN = 2} mode_t;
    typedef struct packed {logic [3:0] high, low;} pair_t;
    typedef struct {
`ifdef WIDE_FIELDS  // the C++ that Verilator 5.006 writes for these does not compile
        logic [70:0] deep;
        real level;
`endif
        logic [7:0] bytes [1:3];
        loose_t inner;
        mode_t mode;
        pair_t pair;
        string note;
    } mixed_t;
    mixed_t mixed;
    loose_t many [3:2];
    loose_t table_of [2][-1:0];
    real levels [1:4];
    real plane [2][3];
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
`ifdef WIDE_FIELDS
        mixed.deep <= {mixed.deep[66:0], corner};
        mixed.level <= levels[2] + plane[1][2];
`endif
        if (levels[2] + plane[1][2] == 1.25) mixed.inner.y <= mixed.inner.y - 1;
        mixed.inner.x <= many[3].x ^ table_of[1][-1].x;
        mixed.mode <= mixed.pair.low == 4'd5 ? RUN : IDLE;
        rows[1][0] <= 8'd3;
        if (rows[1][0] == 8'd7) $display("%s", text);
    end
endmodule
