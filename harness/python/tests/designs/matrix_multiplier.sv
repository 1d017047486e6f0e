// C = A B, element by element in unpacked arrays, a cycle after valid_i; written from the description of cocotb's example.
module matrix_multiplier #(
    parameter int DATA_WIDTH = 8,
    parameter int A_ROWS = 8,
    parameter int B_COLUMNS = 5,
    parameter int A_COLUMNS_B_ROWS = 4,
    parameter int C_DATA_WIDTH = 2 * DATA_WIDTH + $clog2(A_COLUMNS_B_ROWS)
) (
    input  logic                    clk_i,
    input  logic                    reset_i,
    input  logic                    valid_i,
    output logic                    valid_o,
    input  logic [DATA_WIDTH-1:0]   a_i [A_ROWS * A_COLUMNS_B_ROWS],
    input  logic [DATA_WIDTH-1:0]   b_i [A_COLUMNS_B_ROWS * B_COLUMNS],
    output logic [C_DATA_WIDTH-1:0] c_o [A_ROWS * B_COLUMNS]
);
    logic [C_DATA_WIDTH-1:0] c [A_ROWS * B_COLUMNS];
    always_comb
        for (int i = 0; i < A_ROWS; i++)
            for (int j = 0; j < B_COLUMNS; j++) begin
                c[i * B_COLUMNS + j] = 0;
                for (int k = 0; k < A_COLUMNS_B_ROWS; k++)
                    c[i * B_COLUMNS + j] += C_DATA_WIDTH'(a_i[i * A_COLUMNS_B_ROWS + k]) * C_DATA_WIDTH'(b_i[k * B_COLUMNS + j]);
            end
    always_ff @(posedge clk_i) begin
        valid_o <= reset_i ? 1'b0 : valid_i;
        if (valid_i) c_o <= c;
    end
endmodule
