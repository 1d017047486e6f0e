// SPI and I2C: wires from one model to another, and a small master or device of each in the design, with faults to choose.
module serial #(parameter CPHA = 0, STRETCH = 0, FAULT = 0) (
    input  wire       clk, rst,
    // SPI, through.
    input  wire       s_sclk, s_mosi, s_cs, output wire s_miso,
    output wire       m_sclk, m_mosi, m_cs, input wire m_miso,
    // An SPI peripheral of 8 bits that gives back the word before, inverted; 0xa5 first. FAULT 1: it loses a bit.
    input  wire       r_sclk, r_mosi, r_cs, output reg r_miso,
    // An SPI master, mode 0, half a period of 4 cycles. FAULT 2: it ends a bit too early.
    input  wire       go, input wire [7:0] send, output reg [7:0] got, output reg busy,
    output reg        c_sclk, c_mosi, c_cs, input wire c_miso,
    // I2C: the wired AND of two models. FAULT 3: sda falls in the high phase of the sixth bit.
    input  wire       scl_1_o, scl_2_o, sda_1_o, sda_2_o, output wire scl, sda,
    // An I2C device at 0x2a with one register, at the signals of a pad; it holds scl for STRETCH cycles after a byte.
    // FAULT 4: it does not acknowledge. FAULT 5: it does not release sda after its address.
    input  wire       scl_i, sda_i, output wire scl_o, scl_t, sda_o, sda_t, output reg [7:0] stored
);
    assign {m_sclk, m_mosi, m_cs, s_miso} = {s_sclk, s_mosi, s_cs, m_miso};

    // The peripheral: `edges` counts the edges of sclk in a frame, at which it takes and changes data by turns.
    reg [7:0] shift_in, answer;
    reg [7:0] edges;
    reg sclk_before, mosi_before, cs_before;
    wire [7:0] reply = FAULT == 1 ? answer & 8'hfe : answer;
    wire takes = edges[0] == (CPHA != 0);
    wire [2:0] place = 3'd7 - edges[3:1];
    always @(posedge clk) begin
        sclk_before <= r_sclk;
        mosi_before <= r_mosi;
        cs_before <= r_cs;
        if (rst) begin
            answer <= 8'ha5;
            edges <= 0;
        end else if (r_cs) edges <= 0;
        else if (cs_before) r_miso <= reply[7];
        else if (r_sclk != sclk_before) begin
            edges <= edges == 15 ? 0 : edges + 1;
            if (takes) begin
                shift_in[place] <= mosi_before;
                if (place == 0) answer <= ~{shift_in[7:1], mosi_before};
            end else r_miso <= CPHA != 0 ? reply[place] : reply[place - 3'd1];
        end
    end

    // The master: `left` counts halves of a bit.
    reg [4:0] left;
    reg [1:0] pace;
    reg [7:0] shift_out;
    always @(posedge clk) begin
        pace <= pace + 1;
        if (rst) begin
            {c_cs, c_sclk, busy} <= 3'b100;
            left <= 0;
        end else if (!busy) begin
            if (go) begin
                {busy, c_cs, c_mosi} <= {2'b10, send[7]};
                shift_out <= {send[6:0], 1'b0};
                left <= FAULT == 2 ? 14 : 16;
                pace <= 0;
            end
        end else if (pace == 3) begin
            if (left == 0) {busy, c_cs} <= 2'b01;
            else begin
                left <= left - 1;
                c_sclk <= ~c_sclk;
                if (!c_sclk) got <= {got[6:0], c_miso};
                else {c_mosi, shift_out} <= {shift_out, 1'b0};
            end
        end
    end

    // The wires of I2C.
    reg [7:0] pulses;
    reg scl_before, glitch;
    assign scl = scl_1_o & scl_2_o;
    assign sda = sda_1_o & sda_2_o & ~glitch;
    always @(posedge clk) begin
        scl_before <= scl;
        if (rst) pulses <= 0;
        else if (scl & ~scl_before) pulses <= pulses + 1;
        glitch <= FAULT == 3 && pulses == 6 && scl;
    end

    // The device.
    localparam IDLE = 0, ADDRESS = 1, WRITE = 2, READ = 3;
    reg [1:0] state;
    reg [3:0] bits;
    reg [7:0] shift, hold;
    reg pull, was_scl, was_sda, reading;
    assign {scl_o, sda_o, scl_t, sda_t} = {2'b00, hold == 0, ~pull};
    always @(posedge clk) begin
        was_scl <= scl_i;
        was_sda <= sda_i;
        if (hold != 0) hold <= hold - 1;
        if (rst) begin
            state <= IDLE;
            {pull, hold, stored} <= 0;
        end else if (scl_i & was_scl & (sda_i != was_sda)) begin
            state <= sda_i ? IDLE : ADDRESS;
            {bits, pull} <= 0;
        end else if (scl_i & ~was_scl & (state != IDLE)) begin
            bits <= bits + 1;
            shift <= {shift[6:0], sda_i};
        end else if (~scl_i & was_scl & (state != IDLE)) case (bits)
            8: case (state)
                ADDRESS: begin
                    reading <= shift[0];
                    if (shift[7:1] == 7'h2a && FAULT != 4) pull <= 1; else state <= IDLE;
                end
                WRITE: {pull, stored} <= {1'b1, shift};
                default: pull <= 0;
            endcase
            9: begin
                bits <= 0;
                hold <= STRETCH;
                if (state == READ && shift[0]) {state, pull} <= 0;
                else begin
                    if (state == ADDRESS) state <= reading ? READ : WRITE;
                    pull <= state != WRITE && (reading ? ~stored[7] : FAULT == 5);
                end
            end
            default: if (state == READ && bits != 0) pull <= ~stored[3'd7 - bits[2:0]];
        endcase
    end
endmodule
