// SPDX-License-Identifier: MIT
// Unpacks a cluster's positions, eight vertices at a time. Eight values of w bits are w bytes; a
// shuffle brings to each lane the three bytes that hold its value.
#include "base/math/f32x8.h"
#include "store/clusters/clusters_layout.h"

#include <assert.h>

enum { GROUP = 8, GROUP_BYTES = 16 };

/// Byte positions of the values of a group.
typedef struct unpacking {
    i32x8 bytes, shift, mask, origin;
    int left;
} unpacking;

static unpacking make_unpacking(const stp_cluster_run* run)
{
    assert(run->width <= CLUSTERS_UNPACK_WIDTH && run->shift < 32);
    i32x8 bit = i32x8_mul(i32x8_index(), i32x8_set((int)run->width));
    // each lane gets four bytes from its first one on; bytes past the end wrap around and are
    // masked off
    i32x8 first = i32x8_mul(i32x8_right(bit, 3), i32x8_set(0x01010101));
    i32x8 bytes = i32x8_add(first, i32x8_set(0x03020100));
    return (unpacking){
        .bytes = i32x8_and(bytes, i32x8_set(0x0F0F0F0F)),
        .shift = i32x8_and(bit, i32x8_set(7)),
        .mask = i32x8_set((int)((1u << run->width) - 1)),
        .origin = i32x8_set(run->origin),
        .left = run->shift,
    };
}

static inline f32x8 unpack(const unpacking* u, const uint8_t* group, f32x8 step)
{
    i32x8 words = i32x8_pick_bytes(group, u->bytes);
    i32x8 value = i32x8_and(i32x8_right_by(words, u->shift), u->mask);
    value = i32x8_add(i32x8_left(value, u->left), u->origin);
    return f32x8_mul(i32x8_to_float(value), step);
}

uint32_t stp_clusters_unpack_vector(const stp_cluster_run runs[3], uint32_t count, float step,
                                    float* positions)
{
    static const uint8_t nothing[GROUP_BYTES];
    const uint8_t* bits[3];
    uint32_t end = count;
    for (int k = 0; k < 3; ++k) {
        uint32_t width = runs[k].width;
        if (runs[k].layout != STP_CLUSTER_PLAIN || width > CLUSTERS_UNPACK_WIDTH) {
            return 0;
        }
        bits[k] = width == 0 ? nothing : runs[k].bits;
        // a load reads all 16 bytes of a group: padding follows the run
        uint32_t bytes = (count * width + 7) / 8 + CLUSTERS_PADDING_BYTES;
        if (width != 0) {
            uint32_t groups = bytes < GROUP_BYTES ? 0 : (bytes - GROUP_BYTES) / width + 1;
            end = groups * GROUP < end ? groups * GROUP : end;
        }
    }
    const unpacking axes[3] = {make_unpacking(&runs[0]), make_unpacking(&runs[1]),
                               make_unpacking(&runs[2])};
    const f32x8 steps = f32x8_set(step);
    uint32_t done = 0;
    for (uint32_t group = 0; done + GROUP <= end; ++group, done += GROUP) {
        f32x8 axis[3];
        for (int k = 0; k < 3; ++k) {
            axis[k] = unpack(&axes[k], bits[k] + group * runs[k].width, steps);
        }
        f32x8_store_triples(positions + 3 * (size_t)done, axis[0], axis[1], axis[2]);
    }
    assert(done <= count && done % GROUP == 0);
    return done;
}
