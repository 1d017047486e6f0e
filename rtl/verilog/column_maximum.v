// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// Maxima over the rows of one column, v0 the newest: later = max(v0 .. v2), middle = v3, earlier = max(v4 .. v6), five = max(v0 .. v4).
//   step 1  pairs   step 2  threes   step 3  outputs
// Latency: 3 steps.
module column_maximum (
  input  wire clock,
  input  wire advance,
  input  wire [14:0] newest,
  input  wire [95:0] older,
  output reg  [14:0] later,
  output reg  [14:0] middle,
  output reg  [14:0] earlier,
  output reg  [14:0] five
);

wire [14:0] v1 = older[14:0];
wire [14:0] v2 = older[30:16];
wire [14:0] v3 = older[46:32];
wire [14:0] v4 = older[62:48];
wire [14:0] v5 = older[78:64];
wire [14:0] v6 = older[94:80];

reg [14:0] m01, v2_1, v3_1, v4_1, m56, m34;
reg [14:0] m012, v3_2, m456, m34_2;

always @(posedge clock)
  if (advance) begin
    m01  <= newest > v1 ? newest : v1;
    v2_1 <= v2;
    v3_1 <= v3;
    v4_1 <= v4;
    m56  <= v5 > v6 ? v5 : v6;
    m34  <= v3 > v4 ? v3 : v4;

    m012  <= m01 > v2_1 ? m01 : v2_1;
    v3_2  <= v3_1;
    m456  <= m56 > v4_1 ? m56 : v4_1;
    m34_2 <= m34;

    later   <= m012;
    middle  <= v3_2;
    earlier <= m456;
    five    <= m012 > m34_2 ? m012 : m34_2;
  end

wire unused = ^{older[15], older[31], older[47], older[63], older[79], older[95]};

endmodule
