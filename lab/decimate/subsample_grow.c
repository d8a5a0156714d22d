// SPDX-License-Identifier: MIT
#include "lab/decimate/subsample_grow.h"

#include "base/core/jobs.h"
#include "lab/decimate/subsample_attempt.h"

#include <assert.h>
#include <string.h>

enum { BLOCK = 64 }; ///< seeds per work item

/// Members of the candidates of one block.
typedef struct block {
    uint32_t* members;
    size_t count, capacity;
    bool failed;
} block;

typedef struct growth {
    stp_context* context;
    const stp_subsample_field* field;
    double tolerance;
    uint32_t maximum;
    const uint32_t* seeds;
    uint32_t seed_count;
    stp_subsample_candidate* shapes; ///< one per seed
    uint32_t* counts;                ///< number of members per seed
    block* blocks;
    stp_subsample_scratch* scratch; ///< per worker
} growth;

static bool append(stp_context* context, block* b, const uint32_t* members, uint32_t count)
{
    if (b->count + count > b->capacity) {
        if (!STP_MAKE_ROOM(context, b->members, b->capacity, b->count + count)) {
            return false;
        }
    }
    memcpy(b->members + b->count, members, count * sizeof(*members));
    b->count += count;
    return true;
}

static void grow_blocks(size_t begin, size_t end, uint32_t worker, void* user)
{
    const growth* g = user;
    for (size_t at = begin; at < end; ++at) {
        block* b = &g->blocks[at];
        for (size_t i = at * BLOCK; i < (at + 1) * BLOCK && i < g->seed_count; ++i) {
            const uint32_t* members;
            uint32_t count =
                stp_subsample_find_region(g->field, &g->scratch[worker], g->seeds[i], g->tolerance,
                                          g->maximum, &g->shapes[i], &members);
            g->counts[i] = count;
            if (count == 0 || !append(g->context, b, members, count)) {
                b->failed = true;
                return;
            }
            assert(count <= g->maximum && members[0] == g->seeds[i] && "the seed comes first");
        }
    }
}

/// Appends the members found by the blocks to the candidates, whose shapes already exist.
static stp_result take_blocks(growth* g, uint32_t block_count, uint32_t before,
                              stp_subsample_candidates* c)
{
    size_t total = c->starts[before];
    for (uint32_t b = 0; b < block_count; ++b) {
        if (g->blocks[b].failed) {
            return stp_fail_memory(g->context);
        }
        total += g->blocks[b].count;
    }
    uint32_t* members = STP_NEW_ARRAY(g->context, uint32_t, total + 1);
    if (members == NULL) {
        return stp_fail_memory(g->context);
    }
    size_t at = c->starts[before];
    if (at > 0) {
        memcpy(members, c->members, at * sizeof(*members));
    }
    for (uint32_t b = 0; b < block_count; ++b) {
        if (g->blocks[b].count > 0) {
            memcpy(members + at, g->blocks[b].members, g->blocks[b].count * sizeof(*members));
        }
        at += g->blocks[b].count;
    }
    for (uint32_t i = 0; i < g->seed_count; ++i) {
        c->starts[before + i + 1] = c->starts[before + i] + g->counts[i];
    }
    assert(at == total && c->starts[before + g->seed_count] == total);
    stp_free(g->context, c->members);
    c->members = members;
    return STP_OK;
}

/// Grows a candidate from each seed, and appends them.
static stp_result grow_from(growth* g, const stp_team* team, uint32_t seed_count,
                            stp_subsample_candidates* c)
{
    uint32_t before = c->count, after = before + seed_count;
    uint32_t block_count = (seed_count + BLOCK - 1) / BLOCK;
    bool room = STP_MAKE_ROOM(g->context, c->shapes, c->shape_capacity, (size_t)after + 1) &&
                STP_MAKE_ROOM(g->context, c->starts, c->start_capacity, (size_t)after + 1);
    g->counts = STP_NEW_ARRAY(g->context, uint32_t, (size_t)seed_count + 1);
    g->blocks = STP_NEW_ZEROED(g->context, block, (size_t)block_count + 1);
    stp_result result = STP_OK;
    if (!room || g->counts == NULL || g->blocks == NULL) {
        result = stp_fail_memory(g->context);
    } else {
        g->seed_count = seed_count;
        g->shapes = c->shapes + before;
        stp_team_run(team, block_count, 1, grow_blocks, g);
        result = take_blocks(g, block_count, before, c);
    }
    for (uint32_t b = 0; g->blocks != NULL && b < block_count; ++b) {
        stp_free(g->context, g->blocks[b].members);
    }
    stp_free(g->context, g->blocks);
    stp_free(g->context, g->counts);
    c->count = result == STP_OK ? after : before;
    return result;
}

/// Lists the points that no candidate covers, in the order of the field.
static uint32_t list_uncovered(const stp_subsample_field* field, const stp_subsample_candidates* c,
                               uint8_t* covered, uint32_t* points)
{
    uint32_t count = 0;
    for (size_t i = 0; i < c->starts[c->count]; ++i) {
        covered[c->members[i]] = 1;
    }
    for (uint32_t i = 0; i < field->count; ++i) {
        if (covered[field->order[i]] == 0) {
            points[count++] = field->order[i];
        }
    }
    return count;
}

static stp_result make_scratch(growth* g, const stp_team* team)
{
    g->scratch = STP_NEW_ZEROED(g->context, stp_subsample_scratch, team->threads);
    for (uint32_t w = 0; g->scratch != NULL && w < team->threads; ++w) {
        g->scratch[w].context = g->context;
        g->scratch[w].visited = STP_NEW_ZEROED(g->context, uint32_t, (size_t)g->field->count + 1);
        if (g->scratch[w].visited == NULL) {
            return stp_fail_memory(g->context);
        }
    }
    return g->scratch != NULL ? STP_OK : stp_fail_memory(g->context);
}

static void free_scratch(growth* g, const stp_team* team)
{
    for (uint32_t w = 0; g->scratch != NULL && w < team->threads; ++w) {
        stp_free(g->context, g->scratch[w].visited);
        stp_free(g->context, g->scratch[w].heap);
        stp_free(g->context, g->scratch[w].members[0]);
        stp_free(g->context, g->scratch[w].members[1]);
    }
    stp_free(g->context, g->scratch);
}

stp_result stp_subsample_grow(stp_context* context, const stp_subsample_field* field,
                              double tolerance, uint32_t wanted, uint32_t maximum,
                              stp_subsample_candidates* candidates)
{
    assert(maximum > 0 && tolerance >= 0.0);
    uint32_t count = field->count, seed_count = wanted < count ? wanted : count;
    stp_team team = stp_team_create_useful(context);
    uint32_t* seeds = STP_NEW_ARRAY(context, uint32_t, (size_t)count + 1);
    uint8_t* covered = STP_NEW_ZEROED(context, uint8_t, (size_t)count + 1);
    growth g = {.context = context,
                .field = field,
                .tolerance = tolerance,
                .maximum = maximum,
                .seeds = seeds};
    *candidates = (stp_subsample_candidates){.starts = STP_NEW_ZEROED(context, size_t, 1),
                                             .start_capacity = 1};
    stp_result result = STP_OK;
    if (seeds == NULL || covered == NULL || candidates->starts == NULL) {
        result = stp_fail_memory(context);
    }
    if (result == STP_OK) {
        result = make_scratch(&g, &team);
    }
    for (uint32_t i = 0; result == STP_OK && i < seed_count; ++i) {
        seeds[i] = field->order[(uint64_t)i * count / seed_count];
    }
    if (result == STP_OK) {
        result = grow_from(&g, &team, seed_count, candidates);
    }
    if (result == STP_OK) {
        uint32_t left = list_uncovered(field, candidates, covered, seeds);
        if (left > 0) {
            result = grow_from(&g, &team, left, candidates);
        }
    }
    free_scratch(&g, &team);
    stp_free(context, seeds);
    stp_free(context, covered);
    return result;
}

void stp_subsample_candidates_destroy(stp_context* context, stp_subsample_candidates* candidates)
{
    stp_free(context, candidates->shapes);
    stp_free(context, candidates->starts);
    stp_free(context, candidates->members);
    *candidates = (stp_subsample_candidates){0};
}
