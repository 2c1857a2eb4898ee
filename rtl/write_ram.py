"""Write Ram (Fig. 2): decodes the messages of the host, fills Ram-FPGA, sets the gains and gives the start bit `bst`.

A message is ``0x5A, type, length, payload, CRC-32`` with numbers big-endian; the CRC covers type, length and payload.
Of messages that overlap, the one that ends first counts. So every header that arrives becomes a candidate with its own
running CRC, one CRC unit serves one candidate after the other for each byte, and the first candidate that ends with the
right CRC is obeyed and the others are dropped. The newest `CANDIDATES` headers are kept: a message is understood if
fewer false headers than that begin inside it.

The last 2048 bytes before the newest four are kept in a ring of two M9K blocks. A payload is read from it twice, first
to check every number, then to use them, so a message that is refused changes nothing.
"""

import itertools

from amaranth.hdl import Array, Cat, Const, Module, Mux, Signal, Value, unsigned
from amaranth.lib import data, memory, wiring
from amaranth.lib.wiring import In, Out

from rtl.ram import ABSENT, SAMPLES

SYNC = 0x5A
#: Type bytes of the messages.
GAINS, TRAJECTORY, START, STOP, IDENTIFY, IDENTITY = 0x01, 0x02, 0x03, 0x04, 0x05, 0x85
CANDIDATES = 4
#: Bytes of the checksum.
_CHECKSUM = 4
_RING = 2048

CANDIDATE = data.StructLayout(
    {
        "alive": 1,
        "kind": 8,
        "length": 13,  # of the payload
        "left": 13,  # bytes until the end of the message
        "first": 16,  # the first two bytes of the payload
        "crc": 32,
    }
)


def crc32(crc: Value, byte: Value) -> Value:
    """Advance a CRC-32 (reflected polynomial 0xEDB88320) by one byte, the lowest bit first."""
    for i in range(8):
        feedback = crc[0] ^ byte[i]
        crc = Cat(crc[1:], Const(0, 1)) ^ Mux(feedback, Const(0xEDB88320, 32), Const(0, 32))
    return crc


def possible(kind: Value, length: Value) -> Value:
    """Whether a message of this type can have a payload of this length."""
    return (
        ((kind == GAINS) & (length == 24))
        | ((kind == TRAJECTORY) & (length[:3] == 2) & (length >= 10) & (length <= 2050))
        | ((kind == START) & (length == 2))
        | (((kind == STOP) | (kind == IDENTIFY)) & (length == 0))
        | ((kind == IDENTITY) & (length >= 1) & (length <= 4096))
    )


class WriteRam(wiring.Component):
    """Take bytes, and give the commands in the messages; `busy` while a byte is processed."""

    def __init__(self) -> None:
        super().__init__(
            {
                "data": In(8),
                "valid": In(1),
                "ready": Out(1),
                "running": In(1),
                "finished": In(1),  # a motion came to its end: its trajectory is forgotten, as after a stop
                "write_address": Out(13),
                "write_data": Out(64),
                "write": Out(1),
                "scanning": Out(1),  # the read port of Ram-FPGA is needed here
                "read_address": Out(13),
                "read_data": In(64),
                "ctrlv": Out(192),  # six numbers: K_p, K_v and PWM frequency of both joints, joint 1 of K_p on top
                "bst": Out(1),
                "stop": Out(1),
                "samples": Out(14),
                "identify": Out(1),
                "refused": Out(1),
                "kind": Out(8),  # of the message that was obeyed or refused
                "busy": Out(1),
            }
        )

    def elaborate(self, platform: object) -> Module:
        """Build decoder and interpreter."""
        m = Module()
        m.submodules.ring = ring = memory.Memory(shape=unsigned(8), depth=_RING, init=[])
        ring_write, ring_read = ring.write_port(), ring.read_port()
        window = Signal(32)  # the newest four bytes, the newest lowest
        candidates = [Signal(CANDIDATE, name=f"candidate_{i}") for i in range(CANDIDATES)]
        turn = Signal(range(max(CANDIDATES, 3)))
        place = Signal(range(_RING))  # where the ring is written next
        gains_known, to_erase = Signal(), Signal(init=1)

        # The message that has been accepted.
        accepted = Signal()
        length, first = Signal(13), Signal(16)

        # The number of samples or payload bytes still to read, and what has been read of them.
        address, count = Signal(14), Signal(14)
        using, wrong, absent = Signal(), Signal(), Signal()
        word = Signal(64)
        newest_word = Cat(ring_read.data, word[:56])

        oldest = candidates[0]
        aged = Signal(CANDIDATE)
        fresh_crc = Signal(32)
        crc_in, byte_in, crc_out = Signal(32), Signal(8), Signal(32)
        m.d.comb += crc_out.eq(crc32(crc_in, byte_in))
        header_kind, header_length = window[16:24], window[:16]

        m.d.comb += [
            ring_write.addr.eq(place),
            ring_write.data.eq(window[24:]),
            self.write_address.eq(address),
            self.read_address.eq(address),
            ring_read.addr.eq(address),
            self.samples.eq(first),
            self.busy.eq(1),
        ]
        m.d.sync += [self.bst.eq(0), self.stop.eq(0), self.identify.eq(0), self.refused.eq(0)]
        with m.If(self.finished | self.stop):
            m.d.sync += to_erase.eq(1)

        with m.FSM():
            with m.State("WAIT"):
                m.d.comb += self.busy.eq(self.valid | to_erase)
                m.d.sync += [turn.eq(0), accepted.eq(0), address.eq(0)]
                with m.If(to_erase):
                    m.next = "ERASE"
                with m.Elif(self.valid):
                    m.d.comb += [self.ready.eq(1), ring_write.en.eq(1)]
                    m.d.sync += [window.eq(Cat(self.data, window[:24])), place.eq(place + 1)]
                    m.next = "AGE"
            with m.State("AGE"):  # one candidate a clock, the oldest first
                m.d.comb += [
                    crc_in.eq(oldest.crc),
                    byte_in.eq(window[:8]),
                    aged.eq(oldest),
                    aged.left.eq(oldest.left - 1),
                ]
                with m.If(oldest.left > _CHECKSUM):
                    m.d.comb += aged.crc.eq(crc_out)
                with m.If(oldest.left == oldest.length + (_CHECKSUM - 1)):
                    m.d.comb += aged.first.eq(window[:16])
                with m.If(oldest.left == 1):
                    m.d.comb += aged.alive.eq(0)
                    with m.If(oldest.alive & (window == ~oldest.crc) & ~accepted):
                        m.d.sync += [
                            accepted.eq(1),
                            self.kind.eq(oldest.kind),
                            length.eq(oldest.length),
                            first.eq(oldest.first),
                        ]
                m.d.sync += [a.eq(b) for a, b in zip(candidates, [*candidates[1:], aged], strict=True)]
                m.d.sync += turn.eq(turn + 1)
                with m.If(turn == CANDIDATES - 1):
                    m.d.sync += [turn.eq(0), fresh_crc.eq(2**32 - 1)]
                    m.next = "HEADER"
            with m.State("HEADER"):  # the CRC of type and length, a byte a clock
                m.d.comb += [crc_in.eq(fresh_crc), byte_in.eq(Array([window[16:24], window[8:16], window[:8]])[turn])]
                m.d.sync += [fresh_crc.eq(crc_out), turn.eq(turn + 1)]
                with m.If(accepted):
                    m.d.sync += [candidate.alive.eq(0) for candidate in candidates]
                    m.d.sync += [window.eq(0), wrong.eq(0), using.eq(0)]
                    m.next = "OBEY"
                with m.Elif((window[24:] != SYNC) | ~possible(header_kind, header_length)):
                    m.next = "WAIT"
                with m.Elif(turn == 2):
                    new = candidates[-1]
                    m.d.sync += [a.eq(b) for a, b in itertools.pairwise(candidates)]
                    m.d.sync += [
                        new.alive.eq(1),
                        new.kind.eq(header_kind),
                        new.length.eq(header_length),
                        new.left.eq(header_length + _CHECKSUM),
                        new.crc.eq(crc_out),
                    ]
                    m.next = "WAIT"
            with m.State("OBEY"):
                m.next = "WAIT"
                payload = Mux(self.kind == GAINS, 24, Cat(Const(0, 3), length[3:]))
                with m.If(self.kind == STOP):
                    m.d.sync += self.stop.eq(1)
                with m.Elif(self.running | (self.kind == IDENTITY)):
                    m.d.sync += self.refused.eq(1)
                with m.Elif(self.kind == IDENTIFY):
                    m.d.sync += self.identify.eq(1)
                with m.Elif(self.kind == START):
                    m.d.sync += [address.eq(0), count.eq(first)]
                    with m.If((first == 0) | (first > SAMPLES) | ~gains_known):
                        m.d.sync += self.refused.eq(1)
                    with m.Else():
                        m.next = "SCAN"
                with m.Elif((self.kind == TRAJECTORY) & (first + length[3:] > SAMPLES)):
                    m.d.sync += self.refused.eq(1)
                with m.Else():
                    m.d.sync += [address.eq(place - payload), count.eq(payload)]
                    m.next = "FETCH"
            with m.State("FETCH"):  # the ring gives its first byte in the next clock
                m.d.sync += [address.eq(address + 1), word.eq(0)]
                m.next = "READ"
            with m.State("READ"):  # a byte a clock
                m.d.sync += [address.eq(address + 1), count.eq(count - 1), word.eq(newest_word)]
                with m.If(count[:2] == 0):  # a number is in `word`, zero before the first
                    m.d.sync += wrong.eq(wrong | unusable(word[:32], self.kind == GAINS, count < 8))
                with m.If(using & (self.kind == GAINS)):
                    m.d.sync += self.ctrlv.eq(Cat(ring_read.data, self.ctrlv[:184]))
                with m.If(using & (self.kind == TRAJECTORY) & (count[:3] == 1)):  # the last byte of a sample
                    m.d.comb += [self.write.eq(1), self.write_address.eq(first), self.write_data.eq(newest_word)]
                    m.d.sync += first.eq(first + 1)
                with m.If(count == 1):
                    m.next = "LAST"
            with m.State("LAST"):
                m.d.sync += wrong.eq(wrong | unusable(word[:32], self.kind == GAINS, Const(1)))
                m.next = "DECIDE"
            with m.State("DECIDE"):
                m.d.sync += [using.eq(1), address.eq(place - payload), count.eq(payload)]
                with m.If(wrong):
                    m.d.sync += self.refused.eq(1)
                    m.next = "WAIT"
                with m.Elif(~using):
                    m.next = "FETCH"
                with m.Else():
                    with m.If(self.kind == GAINS):
                        m.d.sync += gains_known.eq(1)
                    m.next = "WAIT"
            with m.State("SCAN"):  # a sample a clock; `absent` is of two addresses before
                m.d.comb += self.scanning.eq(1)
                m.d.sync += [address.eq(address + 1), absent.eq(self.read_data[55:63].all())]
                with m.If((address >= 2) & absent):
                    m.d.sync += self.refused.eq(1)
                    m.next = "WAIT"
                with m.Elif(address == count + 1):
                    m.d.sync += self.bst.eq(1)
                    m.next = "WAIT"
            with m.State("ERASE"):
                m.d.comb += [self.write.eq(1), self.write_data.eq(ABSENT)]
                m.d.sync += address.eq(address + 1)
                with m.If(address == SAMPLES - 1):
                    m.d.sync += to_erase.eq(0)
                    m.next = "WAIT"
        return m


def unusable(number: Value, gain: Value, frequency: Value) -> Value:
    """Whether a number is not finite, a negative gain, or a PWM frequency of zero (the last two of the gains)."""
    zero = ~number[:31].any()
    return number[23:31].all() | (gain & ((number[31] & ~zero) | (frequency & zero)))
