module fifo #(parameter WIDTH = 8, parameter DEPTH = 4) (
    input  wire             clk,
    input  wire             rst,
    input  wire             in_valid,
    output wire             in_ready,
    input  wire [WIDTH-1:0] in_data,
    output wire             out_valid,
    input  wire             out_ready,
    output wire [WIDTH-1:0] out_data
);
    reg [WIDTH-1:0] memory [0:DEPTH-1];
    reg [7:0] head, tail, level;
    assign in_ready = level <= DEPTH;
    assign out_valid = level != 0;
    assign out_data = memory[head];
    wire push = in_valid && in_ready, pop = out_valid && out_ready;
    always @(posedge clk)
        if (rst) begin
            head <= 0; tail <= 0; level <= 0;
        end else begin
            if (push) begin
                memory[tail] <= in_data;
                tail <= tail == DEPTH - 1 ? 0 : tail + 1;
            end
            if (pop) head <= head == DEPTH - 1 ? 0 : head + 1;
            level <= level + push - pop;
        end
endmodule
