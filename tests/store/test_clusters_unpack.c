// SPDX-License-Identifier: MIT
// Compares vectorised and scalar unpacking of positions, for every width and count.
#include "tests.h"

#include "base/core/processor.h"
#include "base/math/rng.h"
#include "store/clusters/clusters_layout.h"

#include <stdlib.h>

static bool is_same(uint32_t count, const uint32_t widths[3], uint64_t seed, uint32_t* done)
{
    static float positions[3 * STP_CLUSTER_VERTICES];
    uint8_t* bytes[3] = {NULL, NULL, NULL};
    stp_cluster_run runs[3];
    bool same = true;
    for (uint32_t k = 0; k < 3; ++k) {
        size_t size = (count * widths[k] + 7) / 8 + CLUSTERS_PADDING_BYTES; // exact size
        bytes[k] = malloc(size);
        for (size_t i = 0; bytes[k] != NULL && i < size; ++i) {
            bytes[k][i] = (uint8_t)stp_rng_hash(seed + k, i);
        }
        runs[k] = (stp_cluster_run){.bits = bytes[k],
                                    .own = bytes[k],
                                    .origin = (int32_t)stp_rng_hash(seed, 1000 + k) / 4,
                                    .width = widths[k],
                                    .shift = (uint8_t)(stp_rng_hash(seed, 2000 + k) % 5),
                                    .layout = STP_CLUSTER_PLAIN};
        same = same && bytes[k] != NULL;
    }
    *done = same ? STP_VECTOR(stp_clusters_unpack)(runs, count, 0.125f, positions) : 0;
    same = same && *done <= count;
    for (uint32_t i = 0; same && i < 3 * *done; ++i) {
        float wanted = (float)stp_cluster_value(&runs[i % 3], i / 3) * 0.125f;
        same = memcmp(&wanted, &positions[i], sizeof(wanted)) == 0;
    }
    for (int k = 0; k < 3; ++k) {
        free(bytes[k]);
    }
    return same;
}

void test_clusters_unpack_many_as_one_by_one(test_state* test)
{
    if (stp_processor_detect() < STP_PROCESSOR_VECTOR) {
        SKIP("this processor has no vectors");
    }
    for (uint32_t width = 0; width <= CLUSTERS_UNPACK_WIDTH + 1; ++width) {
        for (uint32_t count = 1; count <= STP_CLUSTER_VERTICES; count += count < 40 ? 1 : 27) {
            const uint32_t widths[3] = {width, (width * 5 + count) % (CLUSTERS_UNPACK_WIDTH + 1),
                                        (width + 3 * count) % (CLUSTERS_UNPACK_WIDTH + 1)};
            uint32_t done;
            CHECK(is_same(count, widths, width * 1000 + count, &done));
            CHECK(width <= CLUSTERS_UNPACK_WIDTH || done == 0);
            bool wide = width >= 8 && widths[1] >= 8 && widths[2] >= 8;
            CHECK(!wide || width > CLUSTERS_UNPACK_WIDTH || done + 8 > count);
        }
    }
}
