// A small stream: first-order recursion over 8-bit samples, mixed with the sample one line earlier.
module stream #(parameter LINE = 1024) (
    input  wire        clk,
    input  wire        rst,
    input  wire        in_valid,
    output wire        in_ready,
    input  wire [7:0]  in_data,
    input  wire        in_startofpacket,
    input  wire        in_endofpacket,
    output reg         out_valid,
    input  wire        out_ready,
    output reg  [15:0] out_data,
    output reg         out_startofpacket,
    output reg         out_endofpacket
);
    localparam ADDRESS = $clog2(LINE);
    reg [15:0] state;
    reg [7:0]  line [0:LINE-1];
    reg [ADDRESS-1:0] at;
    integer i;
    initial for (i = 0; i < LINE; i = i + 1) line[i] = 0;

    assign in_ready = !out_valid || out_ready;
    wire [15:0] fed = {in_data, 8'd0};
    wire [15:0] next = in_startofpacket ? fed : state - (state >> 2) + (fed >> 2);

    always @(posedge clk)
        if (rst) begin
            out_valid <= 0;
            state <= 0;
            at <= 0;
        end else if (in_ready) begin
            out_valid <= in_valid;
            if (in_valid) begin
                state <= next;
                line[at] <= in_data;
                at <= (at == LINE - 1) ? {ADDRESS{1'b0}} : at + 1'b1;
                out_data <= next ^ {8'd0, line[at]};
                out_startofpacket <= in_startofpacket;
                out_endofpacket <= in_endofpacket;
            end
        end
endmodule
