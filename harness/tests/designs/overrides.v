// What a bench overrides: nets and registers that are forced, and pins that the design and the bench drive in turn.
module overrides (
    input  wire         clk,
    input  wire [7:0]   data,
    output wire [7:0]   next,
    output wire [7:0]   held,
    output wire         odd,
    output wire [99:0]  turned,
    output wire [63:0]  long_sum,
    input  wire         drive,
    inout  wire [7:0]   pad,
    output wire [7:0]   pad_seen,
    output reg  [7:0]   pad_kept,
    inout  wire [99:0]  wide_pad,
    output wire [99:0]  wide_seen,
    input  wire         pull_low,
    inout  wire         open_drain,
    output reg  [7:0]   falls
);
    wire [99:0] long = {data, 84'd0, data};
    wire [63:0] sum = long[63:0] + {56'd0, data};
    adder u_adder (.clk(clk), .value(data), .next(next), .held(held), .odd(odd));
    assign turned = ~long;
    assign long_sum = sum;

    assign pad = drive ? data : 8'hzz;
    assign pad_seen = pad;
    always @(posedge clk) pad_kept <= pad;
    assign wide_pad = drive ? {data, 92'd1} : {100{1'bz}};
    assign wide_seen = wide_pad;

    assign open_drain = pull_low ? 1'b0 : 1'bz;
    initial falls = 0;
    always @(negedge open_drain) falls <= falls + 1;
endmodule

module adder (input wire clk, input wire [7:0] value, output wire [7:0] next, output reg [7:0] held, output wire odd);
    wire [7:0] sum = value + 8'd1;
    wire       low = value[0];
    reg  [7:0] cells [0:1];
    real       gain;
    initial held = 0;
    assign next = sum;
    assign odd = low;
    always @(posedge clk) begin
        held <= sum;
        cells[0] <= sum;
    end
endmodule
