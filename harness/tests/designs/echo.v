// A register stage of a stream, with nothing that a reset leaves: what a bench sees does not depend on the benches before.
module echo (
    input  wire       clk,
    input  wire       rst,
    input  wire       in_valid,
    output wire       in_ready,
    input  wire [7:0] in_data,
    output reg        out_valid,
    input  wire       out_ready,
    output reg  [7:0] out_data,
    output reg  [7:0] sum
);
    assign in_ready = !out_valid || out_ready;
    always @(posedge clk)
        if (rst) begin
            out_valid <= 0;
            out_data <= 0;
            sum <= 0;
        end else if (in_ready) begin
            out_valid <= in_valid;
            if (in_valid) begin
                out_data <= in_data;
                sum <= sum + in_data;
            end
        end
endmodule
