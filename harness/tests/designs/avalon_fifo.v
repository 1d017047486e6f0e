// An Avalon-ST FIFO with packets, empty, channel and error, and a ready latency on both sides.
module avalon_fifo #(parameter WIDTH = 32, parameter EMPTY = 2, parameter LATENCY = 0) (
    input  wire             clk,
    input  wire             rst,
    input  wire             in_valid,
    output wire             in_ready,
    input  wire [WIDTH-1:0] in_data,
    input  wire             in_startofpacket,
    input  wire             in_endofpacket,
    input  wire [EMPTY-1:0] in_empty,
    input  wire [3:0]       in_channel,
    input  wire             in_error,
    output wire             out_valid,
    input  wire             out_ready,
    output wire [WIDTH-1:0] out_data,
    output wire             out_startofpacket,
    output wire             out_endofpacket,
    output wire [EMPTY-1:0] out_empty,
    output wire [3:0]       out_channel,
    output wire             out_error
);
    localparam TOTAL = WIDTH + EMPTY + 7;
    localparam DEPTH = 16;
    reg [TOTAL-1:0] memory [0:DEPTH-1];
    reg [3:0] head, tail;
    reg [4:0] level;
    reg [7:0] ready_before;
    // With a latency, as many words as cycles may still come after ready fell.
    assign in_ready = !rst && level < DEPTH - LATENCY - 1;
    wire push = in_valid && (LATENCY != 0 || in_ready);
    wire allowed = LATENCY == 0 ? 1'b1 : ready_before[LATENCY == 0 ? 0 : LATENCY - 1];
    assign out_valid = level != 0 && allowed && !rst;
    wire pop = out_valid && (LATENCY != 0 || out_ready);
    assign {out_error, out_channel, out_empty, out_endofpacket, out_startofpacket, out_data} = memory[head];
    always @(posedge clk) begin
        ready_before <= {ready_before[6:0], out_ready};
        if (rst) begin
            head <= 0;
            tail <= 0;
            level <= 0;
            ready_before <= 0;
        end else begin
            if (push) begin
                memory[tail] <= {in_error, in_channel, in_empty, in_endofpacket, in_startofpacket, in_data};
                tail <= tail + 1'b1;
            end
            if (pop) head <= head + 1'b1;
            level <= level + {4'd0, push} - {4'd0, pop};
        end
    end
endmodule
