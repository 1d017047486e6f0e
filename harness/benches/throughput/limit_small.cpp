// The limit: the plain Verilator loop, drive one and sample one a cycle.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include "Vstream.h"
#include "verilated.h"

static double cpu() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return t.tv_sec + t.tv_nsec * 1e-9;
}

int main(int argc, char** argv) {
    const uint64_t cycles = strtoull(argv[1], nullptr, 10);
    const auto context = std::make_unique<VerilatedContext>();
    context->threads(1);
    const auto top = std::make_unique<Vstream>(context.get());
    top->rst = 1;
    top->out_ready = 1;
    for (int i = 0; i < 4; ++i) {
        top->clk = 0;
        top->eval();
        top->clk = 1;
        top->eval();
    }
    top->rst = 0;
    top->in_valid = 1;
    uint64_t sum = 0;
    const double start = cpu();
    for (uint64_t i = 0; i < cycles; ++i) {
        top->in_data = static_cast<uint8_t>(i * 7);
        top->clk = 0;
        top->eval();
        sum += top->out_data;
        top->clk = 1;
        top->eval();
    }
    const double seconds = cpu() - start;
    printf("%.6f %llu\n", seconds, static_cast<unsigned long long>(sum));
    return 0;
}
