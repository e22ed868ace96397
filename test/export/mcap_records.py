# SPDX-FileCopyrightText: The PRISM-VO developers
# SPDX-License-Identifier: BSD-3-Clause
"""The structure of an MCAP file, by the specification (https://mcap.dev/spec)."""

import struct

MAGIC = b"\x89MCAP0\r\n"
SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = 3, 4, 5, 6, 7, 8
STATISTICS, DATA_END, FOOTER = 0x0b, 0x0f, 2


def records(data, start, end):
    while start < end:
        opcode, length = struct.unpack_from("<BQ", data, start)
        yield opcode, start, data[start + 9:start + 9 + length]
        start += 9 + length
    assert start == end, f"a record ends at {start}, not at {end}"


def text(data, at):
    length, = struct.unpack_from("<I", data, at)
    return data[at + 4:at + 4 + length].decode(), at + 4 + length


def check_file(data):
    """Number of messages of each topic; every index and count is compared with what is there."""
    assert data[:8] == data[-8:] == MAGIC, "no magic"
    topics, counts, chunks, indexes = {}, {}, {}, {}
    for opcode, start, body in records(data, 8, len(data) - 8):
        if opcode == CHANNEL:
            topics[struct.unpack_from("<H", body)[0]] = text(body, 4)[0]
        elif opcode == CHUNK:
            first, last, size, _ = struct.unpack_from("<QQQI", body)
            compression, at = text(body, 28)
            assert compression == "" and struct.unpack_from("<Q", body, at)[0] == size
            inside = {}
            for kind, offset, record in records(body[at + 8:], 0, size):
                if kind == MESSAGE:
                    channel, _, time, _ = struct.unpack_from("<HIQQ", record)
                    assert first <= time <= last
                    inside.setdefault(channel, []).append((time, offset))
                    counts[channel] = counts.get(channel, 0) + 1
            chunks[start] = (first, last, 9 + len(body), inside)
        elif opcode == MESSAGE_INDEX:
            channel, length = struct.unpack_from("<HI", body)
            entries = list(struct.iter_unpack("<QQ", body[6:6 + length]))
            inside = list(chunks.values())[-1][3]
            assert sorted(inside[channel]) == entries, "an index that is wrong"
            indexes[start] = channel
        elif opcode == CHUNK_INDEX:
            first, last, offset, length, size = struct.unpack_from("<QQQQI", body)
            assert chunks[offset][:3] == (first, last, length)
            for channel, at in struct.iter_unpack("<HQ", body[36:36 + size]):
                assert indexes[at] == channel
        elif opcode == STATISTICS:
            total, schemas, channels = struct.unpack_from("<QHI", body)
            assert (total, channels) == (sum(counts.values()), len(topics))
        elif opcode == FOOTER:
            summary, offsets, _ = struct.unpack_from("<QQI", body)
            assert data[summary] == SCHEMA, "the summary does not begin with schemas"
    return {topics[channel]: count for channel, count in counts.items()}
