// SPDX-License-Identifier: MIT
#include "scene/texel_runs.h"

#include "base/core/context.h"

#include <assert.h>

enum { RUN_TEXELS = 1 << 20 }; // a few milliseconds

/// A loop over the runs of a list.
typedef struct texel_loop {
    const stp_scene* scene;
    const stp_texel_runs* runs;
    stp_texel_job job;
    void* user;
} texel_loop;

static size_t size_of(const stp_scene* scene, uint32_t texture)
{
    assert(texture < scene->texture_count);
    return (size_t)scene->textures[texture].width * scene->textures[texture].height;
}

stp_result stp_texel_runs_list(const stp_scene* scene, const uint32_t* textures, size_t count,
                               stp_texel_runs* runs)
{
    size_t needed = 0;
    *runs = (stp_texel_runs){0};
    for (size_t i = 0; i < count; ++i) {
        needed += (size_of(scene, textures[i]) + RUN_TEXELS - 1) / RUN_TEXELS;
    }
    runs->runs = STP_NEW_ARRAY(scene->context, stp_texel_run, needed + 1);
    if (runs->runs == NULL) {
        return stp_fail_memory(scene->context);
    }
    for (size_t i = 0; i < count; ++i) {
        uint32_t texture = textures[i];
        size_t size = size_of(scene, texture);
        for (size_t begin = 0; begin < size; begin += RUN_TEXELS) {
            size_t end = size - begin < RUN_TEXELS ? size : begin + RUN_TEXELS;
            runs->runs[runs->count++] = (stp_texel_run){(uint32_t)i, texture, begin, end};
        }
        runs->texels += size;
    }
    assert(runs->count == needed);
    return STP_OK;
}

void stp_texel_runs_destroy(const stp_scene* scene, stp_texel_runs* runs)
{
    stp_free(scene->context, runs->runs);
    *runs = (stp_texel_runs){0};
}

static void read_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const texel_loop* loop = user;
    for (size_t i = begin; i < end; ++i) {
        const stp_texel_run* run = &loop->runs->runs[i];
        loop->job(&loop->scene->textures[run->texture], run, i, loop->user);
        stp_progress_add(loop->scene->context, run->end - run->begin);
    }
}

stp_result stp_texel_runs_read(const stp_scene* scene, const stp_texel_runs* runs,
                               const char* stage, stp_texel_job job, void* user)
{
    texel_loop loop = {scene, runs, job, user};
    const stp_loop_report report = {.stage = stage, .unit = "texels", .total = runs->texels};
    return runs->count > 0 ? stp_parallel_for_reported(scene->context, runs->count, 1, read_some,
                                                       &loop, &report)
                           : STP_OK;
}
