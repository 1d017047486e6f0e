// Prints messages on request.
module talks (input wire clk, input wire [7:0] command, output reg [31:0] random, output reg seen, output reg [7:0] unreset);
    always @(posedge clk) begin
        case (command)
            1: $display("hello at %0t", $time);
            2: $error("something is off");
            3: $finish;
            4: $fatal(1, "beyond repair");
            5: $stop;
            6: $warning("take care");
            7: random <= $random;
            8: seen <= $test$plusargs("verbose") != 0;
            9: assert (command == 8) else $error("an assertion");
            10: $write("no newline yet, ");
            default: ;
        endcase
    end
    final $display("the end");
endmodule
