// What a public module may declare that is no number: loop variables, references to interfaces, events, queues, classes.
interface beats(input logic clk);
    logic [7:0] data;
    modport source(input clk, output data);
endinterface

package kinds;
    typedef enum logic [1:0] { IDLE, BUSY } state_t;
endpackage

module counts(beats.source out, input logic clk);
    always_ff @(posedge clk) out.data <= out.data + 1;
endmodule

module generated #(
    parameter int WIDTH = 4, parameter real GAIN = 1.5, parameter [99:0] KEY = 100'h1, parameter string NAME = "none"
) (
    input  logic             clk,
    input  logic [7:0]       lines,
    output logic [WIDTH-1:0] out
);
    import kinds::*;
    genvar i;
    integer k;
    event tick;
    int numbers[$];
    beats link(clk);
    counts u_counts(.out(link.source), .clk(clk));
    state_t state;
    for (i = 0; i < WIDTH; i = i + 1) begin : lane
        logic q;
        always_ff @(posedge clk) q <= ~q;
        assign out[i] = q;
    end
    for (genvar j = 0; j < 2; j++) begin : pair
        logic [3:0] level;
        always_ff @(posedge clk) level <= level + j[3:0] + 1;
    end
    always_ff @(posedge clk) begin
        for (k = 0; k < 2; k = k + 1) numbers.push_back(k);
        state <= BUSY;
        -> tick;
    end
endmodule
