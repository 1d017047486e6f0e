// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// A candidate as one word: neighbours, centres, hits, place.
// Latency: none.
module candidate_word (
  input  wire [20:0] place,
  input  wire hit_0,
  input  wire hit_1,
  input  wire [15:0] centre_0,
  input  wire [15:0] centre_1,
  input  wire [59:0] neighbours_0,
  input  wire [59:0] neighbours_1,
  output reg  [174:0] word
);

always @(*)
  word = {neighbours_1, neighbours_0, centre_1, centre_0, hit_1, hit_0, place};

endmodule
