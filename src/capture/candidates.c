// SPDX-License-Identifier: MIT
// The columns of candidates: their memory, and appending covered pixels.
#include "capture/capture_internal.h"

#include <assert.h>
#include <string.h>

// Moves a column to a larger allocation.
static bool move_column(stp_context* context, void** column, size_t count, size_t room, size_t size)
{
    assert(count <= room);
    void* moved = stp_alloc_array(context, room, size);
    if (moved == NULL) {
        return false;
    }
    if (count != 0) {
        memcpy(moved, *column, count * size);
    }
    stp_free(context, *column);
    *column = moved;
    return true;
}

static stp_result move_columns(const stp_capture_job* job, stp_candidates* c, size_t room)
{
    stp_context* context = job->scene->context;
    void *positions = c->positions, *normals = c->normals, *colors = c->colors;
    void *materials = c->materials, *lights = c->light_normals;
    bool moved =
        move_column(context, &positions, c->count, room, 3 * sizeof(float)) &&
        move_column(context, &normals, c->count, room, 3 * sizeof(float)) &&
        move_column(context, &colors, c->count, room, 4) &&
        move_column(context, &materials, c->count, room, sizeof(uint32_t)) &&
        (!job->has_lights || move_column(context, &lights, c->count, room, 3 * sizeof(float)));
    c->positions = positions;
    c->normals = normals;
    c->light_normals = lights;
    c->colors = colors;
    c->materials = materials;
    return moved ? STP_OK : stp_fail_memory(context);
}

stp_result stp_capture_make_room(stp_capture_job* job, uint64_t more, uint64_t spare,
                                 stp_candidates* candidates)
{
    stp_context* context = job->scene->context;
    assert(candidates->count <= job->room && "the columns have room for what is there");
    uint64_t count = candidates->count + more;
    if (count >= UINT32_MAX) {
        return stp_fail(context, STP_ERROR_LIMIT,
                        "capture: %llu candidates exceed the limit; lower the resolution",
                        (unsigned long long)count);
    }
    if (count <= job->room) {
        return STP_OK;
    }
    job->room = count + spare;
    return move_columns(job, candidates, (size_t)job->room);
}

stp_result stp_capture_append(stp_capture_job* job, uint64_t spare, stp_candidates* candidates)
{
    stp_result result = stp_capture_make_room(job, job->covered_pixels, spare, candidates);
    if (result == STP_OK) {
        stp_capture_resolve(job, candidates, candidates->count);
        candidates->count += (uint32_t)job->covered_pixels;
        assert(candidates->count <= job->room);
        stp_capture_drop_bands(job);
    }
    return result;
}

void stp_candidates_destroy(stp_context* context, stp_candidates* candidates)
{
    stp_free(context, candidates->positions);
    stp_free(context, candidates->normals);
    stp_free(context, candidates->light_normals);
    stp_free(context, candidates->colors);
    stp_free(context, candidates->materials);
    for (int i = 0; i < STP_ATTRIBUTES; ++i) {
        stp_free(context, candidates->attributes[i]);
    }
    stp_free(context, candidates->view_starts);
    stp_free(context, candidates->set_areas);
    for (uint32_t i = 0; i < candidates->silhouette_count; ++i) {
        stp_free(context, candidates->silhouettes[i].words);
    }
    *candidates = (stp_candidates){0};
}
