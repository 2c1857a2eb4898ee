// The pins of the board in a simulation: the host's end of the serial line and two encoders.
#include <cstdint>
#include <deque>
#include <memory>
#include "design.h"

namespace {

struct Encoder {
    int64_t count = 0, target = 0;
    // Channels A and B in the order 00, 10, 11, 01 of a rising position.
    bool a() const { return (count & 3) == 1 || (count & 3) == 2; }
    bool b() const { return (count & 3) >= 2; }
};

struct Simulation {
    cxxrtl_design::p_top top;
    uint64_t clocks = 0, edge_at = 0, quiet = 0;
    Encoder encoders[2];
    std::deque<uint8_t> to_board, from_board;
    // Bits of the byte on each line: how many are left, and clocks until the next.
    int sending = 0, send_left = 0, receiving = 0, receive_left = 0;
    uint32_t send_bits = 0, receive_bits = 0;
    // Types of the messages that were refused, and requests for the board's identity.
    std::deque<uint8_t> refused;
    uint64_t identified = 0;

    Simulation() {
        top.p_rx.set(true);
        tick();
    }

    void tick() {
        // A rising edge without the falling one before it, on which nothing happens.
        top.prev_p_clk.set(false);
        top.p_clk.set(true);
        top.step();
        ++clocks;
    }

    void drive_line() {
        if (sending) {
            if (--send_left) return;
            send_bits >>= 1;
            send_left = DIVISOR;
            if (--sending) top.p_rx.set<bool>(send_bits & 1);
            else top.p_rx.set(true);
        }
        // The host of a board at full speed never finds it busy; one with few clocks a bit has to wait.
        if (!sending && !to_board.empty() && !top.p_busy.get<bool>()) {
            send_bits = to_board.front() << 1 | 0x200;
            to_board.pop_front();
            sending = 10;
            send_left = DIVISOR;
            top.p_rx.set(false);
        }
    }

    void read_line() {
        bool tx = top.p_tx.get<bool>();
        if (!receiving) {
            if (tx) return;
            receiving = 10;
            receive_left = DIVISOR / 2;
        } else if (--receive_left == 0) {
            receive_left = DIVISOR;
            receive_bits = receive_bits >> 1 | tx << 9;
            if (--receiving == 0) from_board.push_back(receive_bits >> 1 & 0xff);
        }
    }

    void move_encoders() {
        if (clocks < edge_at) return;
        for (int joint = 0; joint < 2; ++joint) {
            Encoder &e = encoders[joint];
            if (e.count == e.target) continue;
            e.count += e.count < e.target ? 1 : -1;
            edge_at = clocks + EDGE;
            if (joint == 0) {
                top.p_a____0.set(e.a());
                top.p_b____0.set(e.b());
            } else {
                top.p_a____1.set(e.a());
                top.p_b____1.set(e.b());
            }
        }
    }

    // A byte is in the board some clocks after its last bit, and a stop bit is between two bytes of a frame.
    bool resting() const { return quiet > 2 * DIVISOR; }

    void watch() {
        bool still = to_board.empty() && !sending && !receiving && !top.p_busy.get<bool>() &&
                     encoders[0].count == encoders[0].target && encoders[1].count == encoders[1].target;
        quiet = still ? quiet + 1 : 0;
    }

    void clock() {
        drive_line();
        move_encoders();
        tick();
        read_line();
        watch();
        if (top.p_refused.get<bool>()) refused.push_back(top.p_kind.get<uint8_t>());
        identified += top.p_identify.get<bool>();
    }
};

}  // namespace

extern "C" {

Simulation *board_new() { return new Simulation; }
void board_free(Simulation *s) { delete s; }

void board_send(Simulation *s, const uint8_t *data, uint64_t n) {
    s->to_board.insert(s->to_board.end(), data, data + n);
    s->quiet = 0;
}

// Position of both joints in counts, reached an edge of each at a time.
void board_move(Simulation *s, int64_t first, int64_t second) {
    s->encoders[0].target = first;
    s->encoders[1].target = second;
    s->quiet = 0;
}

// Runs until one of the conditions asked for: the board has sent `bytes` bytes; the lines are idle and the encoders
// rest; no motion is under way. Or for `most` clocks.
void board_run(Simulation *s, uint64_t bytes, int idle, int over, uint64_t most) {
    for (uint64_t end = s->clocks + most; s->clocks < end; s->clock()) {
        if (bytes && s->from_board.size() >= bytes) break;
        if (over && !s->top.p_running.get<bool>()) break;
        if (idle && s->resting()) break;
    }
}

uint64_t board_read(Simulation *s, uint8_t *data, uint64_t most) {
    uint64_t n = 0;
    for (; n < most && !s->from_board.empty(); ++n) {
        data[n] = s->from_board.front();
        s->from_board.pop_front();
    }
    return n;
}

// Bits of the status: running, last sample read.
int board_status(Simulation *s) { return s->top.p_running.get<bool>() | s->top.p_last.get<bool>() << 1; }
// Type of the oldest refused message that has not been reported, 0 for none.
int board_refused(Simulation *s) {
    if (s->refused.empty()) return 0;
    int kind = s->refused.front();
    s->refused.pop_front();
    return kind;
}
uint64_t board_identified(Simulation *s) { return s->identified; }
uint64_t board_clocks(Simulation *s) { return s->clocks; }
}
