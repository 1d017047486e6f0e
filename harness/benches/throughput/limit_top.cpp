// The limit on the Hoverlock top: the plain Verilator loop, one pixel a cycle in, records out, the sink always ready.
// limit_top WIDTH HEIGHT FRAMES FILE: prints CPU seconds and cycles, and writes the records it got as 32-bit words, the lowest first.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <vector>
#include "Vhoverlock_top.h"
#include "verilated.h"

static double cpu() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return t.tv_sec + t.tv_nsec * 1e-9;
}

// Tiles of 8 x 8 pixels with random grey: texture enough for features.
static uint16_t pixel(uint32_t x, uint32_t y) {
    uint32_t h = (x / 8) * 374761393u + (y / 8) * 668265263u;
    h = (h ^ (h >> 13)) * 1274126177u;
    return static_cast<uint16_t>(h ^ (h >> 16));
}

int main(int argc, char** argv) {
    if (argc != 5) return 2;
    const unsigned width = strtoul(argv[1], nullptr, 10), height = strtoul(argv[2], nullptr, 10);
    const size_t frames = strtoull(argv[3], nullptr, 10);
    std::vector<uint16_t> frame(width * height);
    for (size_t i = 0; i < frame.size(); ++i) frame[i] = pixel(i % width, i / width);

    const auto context = std::make_unique<VerilatedContext>();
    context->threads(1);
    const auto top = std::make_unique<Vhoverlock_top>(context.get());
    const auto cycle = [&top] {
        top->clock = 0;
        top->eval();
        top->clock = 1;
        top->eval();
    };
    top->reset = 1;
    for (int i = 0; i < 4; ++i) cycle();
    top->reset = 0;
    cycle();
    top->csr_write = 1;
    top->csr_address = 0x14 >> 2;
    top->csr_writedata = width | height << 16;
    cycle();
    top->csr_address = 0x30 >> 2;
    top->csr_writedata = 1;
    cycle();
    top->csr_address = 0x0c >> 2;
    top->csr_writedata = 1;
    cycle();
    top->csr_write = 0;
    top->feature_ready = 1;

    std::vector<uint32_t> records;
    const size_t count = frames * frame.size();
    size_t sent = 0, place = 0, packets = 0;
    uint64_t cycles = 0;
    const double start = cpu();
    while (packets < frames) {
        top->video_valid = sent < count;
        top->video_data = frame[place];
        top->video_startofpacket = place == 0;
        top->video_endofpacket = place + 1 == frame.size();
        top->clock = 0;
        top->eval();
        if (top->video_valid && top->video_ready) {
            ++sent;
            place = place + 1 == frame.size() ? 0 : place + 1;
        }
        if (top->feature_valid) {
            for (int i = 0; i < 8; ++i) records.push_back(top->feature_data[i]);
            packets += top->feature_endofpacket;
        }
        top->clock = 1;
        top->eval();
        ++cycles;
    }
    printf("%.6f %llu\n", cpu() - start, static_cast<unsigned long long>(cycles));
    FILE* out = fopen(argv[4], "wb");
    if (!out || fwrite(records.data(), 4, records.size(), out) != records.size() || fclose(out)) return 1;
    return 0;
}
