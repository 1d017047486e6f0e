// C = A B of small matrices, flattened row by row with element 0 lowest; one register deep.
module matrix_multiplier #(parameter WIDTH = 8, ROWS = 2, INNER = 3, COLUMNS = 2) (
    input  wire                               clk_i,
    input  wire                               reset_i,
    input  wire                               valid_i,
    output reg                                valid_o,
    input  wire [ROWS*INNER*WIDTH-1:0]        a_i,
    input  wire [INNER*COLUMNS*WIDTH-1:0]     b_i,
    output reg  [ROWS*COLUMNS*(2*WIDTH+2)-1:0] c_o
);
    localparam OUT = 2 * WIDTH + 2;
    integer r, c, k;
    reg [OUT-1:0] sum;
    always @(posedge clk_i) begin
        valid_o <= valid_i && !reset_i;
        for (r = 0; r < ROWS; r = r + 1)
            for (c = 0; c < COLUMNS; c = c + 1) begin
                sum = 0;
                for (k = 0; k < INNER; k = k + 1)
                    sum = sum + a_i[(r*INNER+k)*WIDTH +: WIDTH] * b_i[(k*COLUMNS+c)*WIDTH +: WIDTH];
                c_o[(r*COLUMNS+c)*OUT +: OUT] <= sum;
            end
    end
endmodule
