// A small accumulator machine: 16-bit instructions {opcode 4, operand 12}, 16-bit words.
module cpu (input wire clk, input wire rst, output reg [15:0] out, output reg out_valid, output wire halted);
    typedef enum logic [1:0] {FETCH, EXECUTE, HALT} state_t;
    state_t state;
    core u_core (.clk(clk), .rst(rst), .state(state), .out(out), .out_valid(out_valid));
    assign halted = state == HALT;
    always_ff @(posedge clk)
        if (rst) state <= FETCH;
        else case (state)
            FETCH: state <= EXECUTE;
            EXECUTE: state <= u_core.stop ? HALT : FETCH;
            default: state <= HALT;
        endcase
endmodule

module core (input wire clk, input wire rst, input wire [1:0] state, output reg [15:0] out, output reg out_valid);
    logic [15:0] program_memory [0:255];
    logic [15:0] data_memory [0:15];
    logic [7:0] pc;
    logic [15:0] ir;
    logic signed [15:0] acc;
    wire [3:0] op = ir[15:12];
    wire [3:0] at = ir[3:0];
    wire stop = op == 4'hf;
    always_ff @(posedge clk) begin
        out_valid <= 0;
        if (rst) begin
            pc <= 0;
            acc <= 0;
        end else if (state == 0) begin
            ir <= program_memory[pc];
            pc <= pc + 1;
        end else if (state == 1)
            case (op)
                4'h0: acc <= {{4{ir[11]}}, ir[11:0]};
                4'h1: acc <= data_memory[at];
                4'h2: data_memory[at] <= acc;
                4'h3: acc <= acc + data_memory[at];
                4'h4: acc <= acc - data_memory[at];
                4'h5: if (acc != 0) pc <= ir[7:0];
                4'h6: begin out <= acc; out_valid <= 1; end
                default: ;
            endcase
    end
endmodule
