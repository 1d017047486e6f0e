// What a Verilator that the harness does not know is tried on: every way in which a value is stored.
module trial #(parameter SHIFT = 3) (
    input  logic         clk,
    input  logic [3:0]   address,
    input  logic [11:0]  data,
    input  logic signed [19:0] offset,
    input  logic [39:0]  key,
    input  logic [99:0]  wide,
    input  logic [7:0]   taps [0:2],
    input  real          gain,
    output logic [11:0]  read,
    output logic [99:0]  turned,
    output logic [7:0]   tap_sum,
    output real          scaled
);
    typedef enum logic [1:0] {IDLE, RUN = 2} state_t;
    typedef struct packed {logic [3:0] tag; logic [7:0] body;} beat_t;
    state_t state;
    beat_t beat;
    logic [11:0] memory [9:4];
    logic [70:0] deep [2:3];
    logic [4:0] grid [0:1][5:3];
    logic signed [19:0] sum;
    for (genvar lane = 0; lane < 2; lane++) begin : lanes
        logic [5:0] held;
        always_ff @(posedge clk) held <= data[5:0] + lane;
    end
    trial_part u_part (.clk(clk), .key(key));
    assign turned = {wide[49:0], wide[99:50]};
    assign tap_sum = taps[0] + 2 * taps[1] + 4 * taps[2];
    assign scaled = gain * 2.0;
    assign read = memory[address];
    always_ff @(posedge clk) begin
        state <= RUN;
        beat <= data;
        memory[address] <= data;
        deep[3] <= wide[70:0];
        grid[1][4] <= data[4:0];
        sum <= offset >>> SHIFT;
        if (address == 9) $display("address %0d", address);
    end
endmodule

module trial_part (input logic clk, input logic [39:0] key);
    logic [39:0] kept;
    always_ff @(posedge clk) kept <= ~key;
endmodule
