// Runs the floating-point unit over arrays of operands.
#include <cstdint>
#include "design.h"

extern "C" uint64_t run(uint32_t op, uint64_t n, const uint32_t *a, const uint32_t *b, uint32_t *result) {
    cxxrtl_design::p_top top;
    uint64_t clocks = 0;
    auto tick = [&] {
        top.p_clk.set(false);
        top.step();
        top.p_clk.set(true);
        top.step();
        ++clocks;
    };
    top.p_op.set(op);
    for (uint64_t k = 0; k < n; ++k) {
        top.p_a.set(a[k]);
        top.p_b.set(b[k]);
        top.p_start.set(true);
        tick();
        top.p_start.set(false);
        while (!top.p_done.get<bool>()) tick();
        result[k] = top.p_result.get<uint32_t>();
    }
    return clocks;
}
