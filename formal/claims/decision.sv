// decision: equality with its definition, and the tie rule, by two decisions about two samples in each other's windows.
module decision_properties (input clock);
  (* anyseq *) reg reset, advance, eligible_a, eligible_b;
  // Sample a comes before b; the other samples of their windows.
  (* anyseq *) reg [`D-1:0] a, b, before_a, after_a, before_b, after_b, threshold;
  wire hit_a, hit_b, maximum_a, maximum_b;
  wire [`D-1:0] loose_a = after_a > b ? after_a : b;
  wire [`D-1:0] strict_b = before_b > a ? before_b : a;
  decision first (
    .clock(clock), .reset(reset), .advance(advance), .eligible(eligible_a), .p(a), .strict(before_a), .loose(loose_a),
    .threshold(threshold), .maximum(maximum_a), .hit(hit_a)
  );
  decision second (
    .clock(clock), .reset(reset), .advance(advance), .eligible(eligible_b), .p(b), .strict(strict_b), .loose(after_b),
    .threshold(threshold), .maximum(maximum_b), .hit(hit_b)
  );

  reg begun = 0, largest_a, largest_b, wanted_a, wanted_b, equal;
  always @(posedge clock) begin
    begun <= 1;
    if (reset) begin
      {largest_a, largest_b, wanted_a, wanted_b} <= 0;
    end else if (advance) begin
      largest_a <= eligible_a && a > before_a && a >= after_a && a >= b;
      largest_b <= eligible_b && b > before_b && b > a && b >= after_b;
      wanted_a <= eligible_a && a > before_a && a >= after_a && a >= b && a >= threshold;
      wanted_b <= eligible_b && b > before_b && b > a && b >= after_b && b >= threshold;
      equal <= a == b;
    end
  end

  always @(posedge clock) begin
    if (!begun) assume (reset);
    else begin
      definition: assert (hit_a == wanted_a && hit_b == wanted_b);
      maxima: assert (maximum_a == largest_a && maximum_b == largest_b);
      one: assert (!(maximum_a && maximum_b));
      plateau: cover (hit_a && !hit_b && equal);
      later: cover (hit_b);
    end
  end
endmodule
