// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y = p + round(g (q - p) / 2^16) on sign and magnitude, rounding half away from p; y lies between p and q.
//   step 1  distance = |q - p|   step 2  product = distance * g   step 3  y
// One 18 x 18 multiplier, registered at its inputs and its output. `g` is taken with step 2.
// Latency: 3 steps.
module lerp (
  input  wire clock,
  input  wire advance,
  input  wire [17:0] p,
  input  wire [17:0] q,
  input  wire [15:0] g,
  output reg  [17:0] y
);

wire [18:0] up = {1'b0, q} - {1'b0, p};
wire [17:0] down = p - q;

reg [17:0] distance;
reg        minus_1;
reg [17:0] p_1;
reg [33:0] product;
reg        minus_2;
reg [17:0] p_2;

always @(posedge clock)
  if (advance) begin
    distance <= up[18] ? down : up[17:0];
    minus_1  <= up[18];
    p_1      <= p;

    product <= {16'd0, distance} * {18'd0, g};
    minus_2 <= minus_1;
    p_2     <= p_1;

    y <= p_2 + (product[33:16] ^ {18{minus_2}}) + {17'd0, product[15] ^ minus_2};
  end

endmodule
