// A count in three copies, of which the majority counts; `state` has one copy, and a wrong one stops the counting.
module voter (
    input  wire       clk,
    input  wire       rst,
    output wire [7:0] count,
    output wire       wrong
);
    reg [7:0] first, second, third, plain;
    reg       state;
    reg [7:0] unused;
    wire [7:0] vote = (first & second) | (first & third) | (second & third);
    assign count = vote ^ plain;
    assign wrong = !state;
    always @(posedge clk)
        if (rst) begin
            first <= 0;
            second <= 0;
            third <= 0;
            plain <= 0;
            state <= 1;
            unused <= 0;
        end else begin
            first <= vote + 1;
            second <= vote + 1;
            third <= vote + 1;
            plain <= plain;
            if (state === 1'b0) $finish;
        end
endmodule
