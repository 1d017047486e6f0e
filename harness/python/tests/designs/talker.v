// Calls $display, $error and $finish, each while its input is 1.
module talker (
    input wire clk,
    input wire say,
    input wire complain,
    input wire end_it
);
    always @(posedge clk) begin
        if (say) $display("hello at %0t", $time);
        if (complain) $error("complaint number %0d", 7);
        if (end_it) $finish;
    end
endmodule
