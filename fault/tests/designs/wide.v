// A register with its parity. Bit 40 of `alarm` is 1 if they do not fit, and bit 39 of `counts` is always 1.
module wide (
  input wire clk, input wire rst, input wire [7:0] in, output reg [7:0] out, output wire [63:0] alarm,
  output wire [39:0] counts
);

reg parity;

always @(posedge clk)
  if (rst) begin
    out <= 8'd0;
    parity <= 1'b0;
  end else begin
    out <= in;
    parity <= ^in;
  end

assign alarm = {23'd0, parity ^ (^out), 40'd0};
assign counts = {1'b1, 39'd0};

endmodule
