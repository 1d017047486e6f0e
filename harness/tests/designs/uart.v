// A UART: 8 data bits, no parity, one stop bit; DIVISOR clocks a bit.
module uart #(parameter DIVISOR = 8) (
    input  wire       clk,
    input  wire       rst,
    input  wire       send,
    input  wire [7:0] tx_data,
    output wire       tx_busy,
    output reg        tx,
    input  wire       rx,
    output reg        rx_valid,
    output reg  [7:0] rx_data,
    output reg        framing_error
);
    reg [9:0] tx_shift;
    reg [3:0] tx_left, rx_left;
    reg [15:0] tx_wait, rx_wait;
    reg [7:0] rx_shift;
    assign tx_busy = tx_left != 0 || tx_wait != 0;
    always @(posedge clk) begin
        rx_valid <= 0;
        if (rst) begin
            tx <= 1;
            tx_left <= 0;
            tx_wait <= 0;
            rx_left <= 0;
            framing_error <= 0;
        end else begin
            if (!tx_busy) begin
                if (send) begin
                    tx_shift <= {1'b1, tx_data, 1'b0};
                    tx_left <= 10;
                    tx_wait <= 0;
                end
            end else if (tx_wait != 0) tx_wait <= tx_wait - 1;
            else begin
                tx <= tx_shift[0];
                tx_shift <= {1'b1, tx_shift[9:1]};
                tx_left <= tx_left - 1;
                tx_wait <= DIVISOR - 1;
            end
            if (rx_left == 0) begin
                if (!rx) begin
                    rx_left <= 10;
                    rx_wait <= DIVISOR / 2 - 1;
                end
            end else if (rx_wait != 0) rx_wait <= rx_wait - 1;
            else begin
                rx_wait <= DIVISOR - 1;
                rx_left <= rx_left - 1;
                if (rx_left == 1) begin
                    rx_valid <= rx;
                    framing_error <= !rx;
                    rx_data <= rx_shift;
                end else if (rx_left != 10) rx_shift <= {rx, rx_shift[7:1]};
            end
        end
    end
endmodule
