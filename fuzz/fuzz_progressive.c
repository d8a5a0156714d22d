// SPDX-License-Identifier: MIT
// Operators of progressive sets: sets built from the input survive a round trip through their
// coding, and arbitrary bytes are decoded.
//
//   cmake --preset fuzz && cmake --build --preset fuzz --target fuzz_progressive
//   mkdir -p corpus && build/fuzz/fuzz/fuzz_progressive -max_total_time=60 -max_len=4000 corpus
// No seeds: the first six bytes are counts, and any input makes a set.
#include "base/splats/splat_codes.h"
#include "store/bytes/operators.h"

#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

enum { MOST = 600 };

typedef struct columns {
    uint16_t positions[3 * MOST];
    int8_t normals[2 * MOST];
    uint8_t materials[MOST], colors[3 * MOST], coverages[MOST];
    uint32_t shapes[MOST], ranges[MOST];
} columns;

static stp_splats point_to(columns* c, uint32_t count)
{
    return (stp_splats){.count = count,
                        .step = 0.25f,
                        .columns = STP_OPERATOR_COLUMNS,
                        .positions = c->positions,
                        .normals = c->normals,
                        .materials = c->materials,
                        .colors = c->colors,
                        .coverages = c->coverages,
                        .shapes = c->shapes,
                        .ranges = c->ranges};
}

static void require(bool condition)
{
    if (!condition) {
        abort();
    }
}

// Arbitrary levels: a cut and an order of a possibly invalid set stay within their arrays.
static void use_ranges(const uint32_t* ranges, uint32_t count, bool valid)
{
    static uint32_t order[MOST], scratch[MOST];
    uint32_t parents = stp_progressive_order(ranges, count, order, scratch);
    stp_progressive_counts c = stp_progressive_count(ranges, count);
    require(parents == c.parents && c.base + 2 * c.splits <= count);
    bool right = stp_progressive_is_valid(ranges, count, order);
    require(right || !valid);
    for (uint32_t wanted = 0; wanted <= count; wanted += 1 + wanted / 4) {
        stp_progressive_cut cut = stp_progressive_find_cut(ranges, count, wanted);
        uint32_t drawn = 0;
        for (uint32_t i = 0; i < cut.end; ++i) {
            uint32_t low = ranges[i] & 0xFFFFu;
            uint32_t bits = stp_bits_of_float(i < cut.divide ? cut.below : cut.level);
            drawn += bits >= low << 15 && bits <= ranges[i] >> 16 << 15 ? 1 : 0;
        }
        require(!right || drawn == cut.splats);
    }
}

// Columns and levels from the input: adds splats until the input ends or nothing can be split.
// @return the number of splats
static uint32_t make_set(const uint8_t* data, size_t size, columns* made, uint32_t* room)
{
    stp_progressive_queue queue = {.ranges = made->ranges, .heap = room};
    uint32_t count = 0, base = 0, parent = 0;
    for (; count < MOST && size >= 8; ++count, data += 8, size -= 8) {
        uint32_t i = count, low = data[0] | (uint32_t)data[1] << 8, top = 0x7F00;
        bool in_base = base == i && (i == 0 || (data[2] & 3) == 0);
        base += in_base ? 1 : 0;
        if (!in_base && (i - base) % 2 == 0) {
            parent = stp_progressive_queue_take(&queue);
            if (parent == UINT32_MAX) {
                break;
            }
        }
        top = in_base ? top : made->ranges[parent] & 0xFFFFu;
        low = (data[2] & 4) != 0 ? 0 : low < top ? top - low / 16 : top;
        made->ranges[i] = low | (in_base ? (uint32_t)STP_RANGE_INFINITE : top + data[3] % 16) << 16;
        made->shapes[i] =
            (data[4] * 15u) | (data[4] * 15u * (data[5] & 1u)) << 12 | (uint32_t)data[5] << 24;
        memcpy(made->positions + 3 * i, data, 6);
        memcpy(made->colors + 3 * i, data + 5, 3);
        memcpy(made->normals + 2 * i, data + 6, 2);
        made->materials[i] = data[2] & 1;
        made->coverages[i] = data[7];
        stp_progressive_queue_add(&queue, i);
    }
    return count;
}

// The set survives a round trip from any position, and a flipped bit does no harm.
static void use_set(const columns* made, uint32_t count, uint32_t begin, uint32_t flip)
{
    static columns again;
    static uint32_t room[MOST], order[MOST], scratch[MOST];
    static unsigned char coded[1 << 16];
    stp_splats set = point_to((columns*)(uintptr_t)made, count), other = point_to(&again, count);
    stp_progressive_order(made->ranges, count, order, scratch);
    use_ranges(made->ranges, count, count > 0);
    uint32_t base = stp_progressive_count(made->ranges, begin).base;
    stp_operator_run run = {.set = &set, .begin = begin, .end = count, .base = base};
    size_t length = stp_operators_encode(&run, order + (begin - base) / 2, coded, sizeof(coded));
    require(length > 0);
    for (int changed = 0; changed < 2; ++changed) {
        stp_operator_reader reader;
        again = *made;
        memset(again.ranges + begin, 0, (count - begin) * sizeof(uint32_t));
        stp_operators_begin(&reader, again.ranges, begin, room);
        run.set = &other;
        coded[flip / 8 % length] ^= (unsigned char)(changed << flip % 8);
        bool right = stp_operators_decode(&run, &reader, coded, length);
        require(changed != 0 || (right && memcmp(made, &again, sizeof(again)) == 0));
    }
}

// Arbitrary bytes after some splats with arbitrary levels.
static void use_bytes(const uint8_t* data, size_t size, columns* made, uint32_t known,
                      uint32_t count)
{
    static uint32_t room[MOST];
    stp_splats set = point_to(made, count);
    stp_operator_reader reader;
    for (uint32_t i = 0; i < known && size >= 4; ++i, data += 4, size -= 4) {
        memcpy(&made->ranges[i], data, 4);
        made->shapes[i] = made->ranges[i] >> 3;
    }
    use_ranges(made->ranges, known, false);
    stp_operators_begin(&reader, made->ranges, known, room);
    stp_operator_run run = {.set = &set, .begin = known, .end = count};
    (void)stp_operators_decode(&run, &reader, data, size);
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    static columns made;
    static uint32_t room[MOST];
    uint8_t head[6] = {0};
    size_t taken = size < sizeof(head) ? size : sizeof(head);
    if (taken > 0) { // an empty input may be NULL
        memcpy(head, data, taken);
        data += taken;
        size -= taken;
    }
    uint32_t many = head[0] | (uint32_t)head[1] << 8, some = head[2] | (uint32_t)head[3] << 8;
    uint32_t flip = head[4] | (uint32_t)head[5] << 8;
    memset(&made, 0, sizeof(made));
    uint32_t count = make_set(data, size, &made, room);
    if (count > 0) {
        use_set(&made, count, some % count, flip);
    }
    memset(&made, 0, sizeof(made));
    count = many % MOST + 1;
    use_bytes(data, size, &made, some % count, count);
    return 0;
}
