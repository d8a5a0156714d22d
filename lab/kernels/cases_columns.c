// SPDX-License-Identifier: MIT
// Checksums and columns of files.
#include "base/io/hash.h"
#include "base/splats/octahedral.h"
#include "lab/kernels/kernel_cases.h"
#include "store/clusters/clusters.h"

enum { BYTES = 1 << 20, NORMALS = 1 << 14, CLUSTER_REPEATS = 256, CLUSTER_WIDTH = 11 };

bool kernel_make_bytes(kernel_case* c)
{
    uint64_t* words = STP_ARENA_ARRAY(c->arena, uint64_t, BYTES / sizeof(uint64_t));
    for (uint64_t i = 0; words != NULL && i < BYTES / sizeof(uint64_t); ++i) {
        words[i] = stp_rng_hash(1, i);
    }
    c->input = words;
    return words != NULL && kernel_set_output(c, sizeof(uint32_t), BYTES);
}

void kernel_run_crc32c(kernel_case* c)
{
    *(uint32_t*)c->output = stp_crc32c(c->input, BYTES);
}

bool kernel_make_normals(kernel_case* c)
{
    c->input = kernel_random_floats(c, 2, 3 * NORMALS, -1.0f, 1.0f);
    return c->input != NULL && kernel_set_output(c, 2 * NORMALS, NORMALS);
}

void kernel_run_octahedral(kernel_case* c)
{
    stp_octahedral_encode_many(c->input, NORMALS, c->output);
}

typedef struct cluster_input {
    stp_clusters clusters;
    stp_cluster cluster;
} cluster_input;

bool kernel_make_cluster(kernel_case* c)
{
    cluster_input* in = stp_arena_alloc(c->arena, sizeof(*in));
    uint32_t* bits =
        STP_ARENA_ARRAY(c->arena, uint32_t, (size_t)STP_CLUSTER_VERTICES * CLUSTER_WIDTH / 32 + 4);
    if (in == NULL || bits == NULL) {
        return false;
    }
    for (uint32_t i = 0; i < STP_CLUSTER_VERTICES * CLUSTER_WIDTH / 32 + 4; ++i) {
        bits[i] = (uint32_t)stp_rng_hash(3, i);
    }
    *in = (cluster_input){.clusters = {.step = 0.125f},
                          .cluster = {.vertex_count = STP_CLUSTER_VERTICES}};
    for (int k = 0; k < 3; ++k) {
        in->cluster.runs[k] = (stp_cluster_run){.bits = (const unsigned char*)bits,
                                                .own = (const unsigned char*)bits,
                                                .origin = 1000 * k,
                                                .width = CLUSTER_WIDTH,
                                                .shift = (uint8_t)k,
                                                .layout = STP_CLUSTER_PLAIN};
    }
    c->input = in;
    return kernel_set_output(c, 3 * STP_CLUSTER_VERTICES * sizeof(float),
                             (uint64_t)CLUSTER_REPEATS * STP_CLUSTER_VERTICES);
}

/// Selects the variant, as stp_clusters_open does.
void kernel_reset_cluster(kernel_case* c)
{
    cluster_input* in = c->input;
    in->clusters.processor = stp_processor_detect();
}

void kernel_run_cluster(kernel_case* c)
{
    const cluster_input* in = c->input;
    for (int i = 0; i < CLUSTER_REPEATS; ++i) {
        stp_cluster_positions(&in->clusters, &in->cluster, c->output);
    }
}
