// SPDX-License-Identifier: MIT
// Shared by tests of large files: imports with and without a spill file, and compares the results.
#pragma once

#include "formats_test.h"

#include <signal.h>
#include <sys/resource.h>

typedef struct spilled_import {
    stp_result result;
    stp_hash digest; ///< digest of the scene
    uint64_t peak_bytes, left_bytes;
    bool spilled; ///< whether the points of the first set are in the spill file
} spilled_import;

/// Reads the bytes into an empty scene; on success the scene can be hashed.
typedef stp_result spilled_reader(stp_context* context, stp_scene* scene, const void* bytes,
                                  size_t size);

/// Imports with a limit of 1 MiB, above which data goes to a spill file, or without a spill file.
static inline spilled_import import_spilled(stp_context* context, spilled_reader* read,
                                            const void* bytes, size_t size, bool spills)
{
    spilled_import out = {.result = STP_OK};
    uint64_t before = stp_context_live_bytes(context);
    stp_scene* scene = NULL;
    stp_spill* spill = NULL;
    out.result = spills ? stp_spill_create(context, ".", &spill) : STP_OK;
    out.result = out.result == STP_OK ? stp_scene_create(context, &scene) : out.result;
    if (out.result == STP_OK && spills) {
        stp_scene_use_spill(scene, spill, 1 << 20);
    }
    if (out.result == STP_OK) {
        out.result = read(context, scene, bytes, size);
    }
    if (out.result == STP_OK) {
        out.digest = digest_scene(scene);
        out.spilled = scene->point_set_count > 0 && scene->point_sets[0].spilled;
    }
    stp_scene_destroy(scene);
    stp_spill_destroy(spill);
    out.left_bytes = stp_context_live_bytes(context) - before;
    out.peak_bytes = stp_context_peak_bytes(context);
    return out;
}

/// A file size limit, which simulates a full disk.
typedef struct file_limit {
    struct rlimit before;
    void (*handler)(int);
} file_limit;

/// @return false if the limit cannot be set
static inline bool file_limit_begin(file_limit* limit, size_t bytes)
{
    if (getrlimit(RLIMIT_FSIZE, &limit->before) != 0) {
        return false;
    }
    limit->handler = signal(SIGXFSZ, SIG_IGN);
    struct rlimit now = {.rlim_cur = bytes, .rlim_max = limit->before.rlim_max};
    return setrlimit(RLIMIT_FSIZE, &now) == 0;
}

static inline void file_limit_end(const file_limit* limit)
{
    (void)setrlimit(RLIMIT_FSIZE, &limit->before);
    (void)signal(SIGXFSZ, limit->handler);
}
