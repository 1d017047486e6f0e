// Loops for ever within one evaluation while `go`.
module endless (input wire clk, input wire go, output reg [31:0] x);
    always @(posedge clk) begin
        x = 1;
        while (go) x = {x[30:0], x[31] ^ x[21] ^ x[1] ^ x[0]};
    end
endmodule
