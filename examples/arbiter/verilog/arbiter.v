// Grants one of N requests in each clock; the request after the last one granted has the highest priority.
module arbiter #(parameter N = 4) (
    input  wire         clk,
    input  wire         rst,
    input  wire [N-1:0] request,
    output reg  [N-1:0] grant
);
    // Requests above the last grant, and all of them: the lowest bit of the first is granted, or of the second if there is none.
    reg  [N-1:0] above;
    wire [N-1:0] first = request & above;
    wire [N-1:0] chosen = |first ? first : request;
    wire [N-1:0] lowest = chosen & (~chosen + 1'b1);

    always @(posedge clk)
        if (rst) begin
            grant <= 0;
            above <= {N{1'b1}};
        end else begin
            grant <= lowest;
            if (|lowest) above <= ~(lowest | (lowest - 1'b1));
        end
endmodule
