// SPDX-License-Identifier: MIT
#include "lod/psp/rounds.h"

#include <assert.h>
#include <string.h>

enum {
    PIECE_SIZE = 8192, ///< default maximum splats per piece
    SAMPLES = 1024,    ///< number of sampled errors for choosing the limit of a round
    RELEASED = 64,     ///< pages are released after this many pieces
};

/// Maximum share of splats whose best merge is allowed in one round.
#define PART_MAX 0.9
/// Merges per splat whose best merge is within the limit; measured, used only for an estimate.
#define MERGES_EACH 0.6

/// A round in progress.
typedef struct pass {
    stp_psp_rounds* rounds;
    const stp_psp_range* ranges;
    uint32_t range_count;
    float limit;
    stp_psp_piece* pieces; ///< one per thread
    stp_psp_block* blocks; ///< one per range
    stp_psp_history* histories;
    uint32_t* survivors;
    uint8_t* failed; ///< one per range
} pass;

static bool run_piece(pass* t, uint32_t number, stp_psp_piece* piece)
{
    stp_psp_rounds* r = t->rounds;
    stp_psp_range of = t->ranges[number];
    uint64_t count = of.end - of.begin;
    // all pieces together never leave fewer splats than the target
    uint64_t minimum = (count * r->target + r->live - 1) / r->live;
    stp_psp_rounds_release(r, number);
    if (!stp_psp_load(r, piece, of.begin, of.end) ||
        !stp_psp_piece_run(piece, t->limit, (uint32_t)minimum) ||
        !stp_psp_unload(piece, &r->rooms[STP_PSP_ROOM_NEXT], &t->blocks[number],
                        t->survivors + of.begin)) {
        return false;
    }
    stp_psp_history* h = &t->histories[number];
    h->count = piece->record_count;
    if (h->count > 0) {
        h->records = STP_NEW_ARRAY(r->shared.context, stp_psp_record, h->count);
        if (h->records == NULL) {
            return false;
        }
        memcpy(h->records, piece->records, h->count * sizeof(*h->records));
    }
    return true;
}

static void run_pieces(size_t begin, size_t end, uint32_t worker, void* user)
{
    pass* t = user;
    for (size_t i = begin; i < end; ++i) {
        t->failed[i] = run_piece(t, (uint32_t)i, &t->pieces[worker]) ? 0 : 1;
    }
}

static uint32_t final_id(const stp_psp_rounds* r, const stp_psp_history* h, uint32_t id)
{
    assert((id & STP_PSP_RECORDED) == 0 || (id & ~STP_PSP_RECORDED) < h->count);
    return (id & STP_PSP_RECORDED) == 0
               ? id
               : r->shared.points->count + h->first + (id & ~STP_PSP_RECORDED);
}

/// Numbers the remaining splats and the merges, after all pieces are done.
static void number_pieces(size_t begin, size_t end, uint32_t worker, void* user)
{
    const pass* t = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        const stp_psp_block* b = &t->blocks[i];
        const stp_psp_history* h = &t->histories[i];
        stp_psp_rounds_release(t->rounds, i);
        for (uint32_t slot = t->ranges[i].begin; slot < t->ranges[i].end; ++slot) {
            t->survivors[slot] += b->first;
        }
        for (uint32_t s = 0; t->rounds->keep_history && s < b->count; ++s) {
            b->splats[s].id = final_id(t->rounds, h, b->splats[s].id);
        }
        for (uint32_t m = 0; m < h->count; ++m) {
            h->records[m].left = final_id(t->rounds, h, h->records[m].left);
            h->records[m].right = final_id(t->rounds, h, h->records[m].right);
        }
    }
}

static void free_blocks(const stp_psp_room* room, stp_context* context, stp_psp_block* blocks,
                        uint32_t count)
{
    for (uint32_t i = 0; blocks != NULL && i < count; ++i) {
        stp_psp_room_free(room, blocks[i].memory);
    }
    stp_free(context, blocks);
}

/// Frees the results of the previous round.
static void free_left(stp_psp_rounds* r)
{
    stp_psp_room* room = &r->rooms[STP_PSP_ROOM_LEFT];
    free_blocks(room, r->shared.context, r->blocks, r->block_count);
    stp_psp_room_free(room, r->survivors);
    stp_psp_room_close(room);
}

/// Frees the tree and the order of the round.
static void free_orders(stp_psp_rounds* r)
{
    stp_psp_room* room = &r->rooms[STP_PSP_ROOM_WORK];
    stp_kd_tree_destroy(r->shared.context, &r->tree);
    stp_psp_room_close(&r->rooms[STP_PSP_ROOM_TREE]);
    stp_psp_room_free(room, r->order);
    stp_psp_room_free(room, r->reverse);
    stp_psp_room_close(room);
    r->order = NULL;
    r->reverse = NULL;
    r->reverse_count = 0;
}

/// Keeps the histories of pieces with merges. @return false if out of memory
static bool keep_histories(pass* t)
{
    stp_psp_rounds* r = t->rounds;
    if (!r->keep_history) {
        return true;
    }
    size_t needed = (size_t)r->history_count + t->range_count;
    if (r->history_room < needed) {
        if (!STP_MAKE_ROOM(r->shared.context, r->histories, r->history_room, needed)) {
            return false;
        }
    }
    for (uint32_t i = 0; i < t->range_count; ++i) {
        if (t->histories[i].count > 0) {
            r->histories[r->history_count++] = t->histories[i];
            t->histories[i] = (stp_psp_history){0};
        }
    }
    return true;
}

/// Replaces the previous round's results by those of this round.
static bool take_over(pass* t)
{
    stp_psp_rounds* r = t->rounds;
    stp_context* context = r->shared.context;
    uint32_t slots = r->live, first = 0, merges = r->merge_count;
    for (uint32_t i = 0; i < t->range_count; ++i) {
        if (t->failed[i] != 0) {
            return false;
        }
        t->blocks[i].first = first;
        first += t->blocks[i].count;
        t->histories[i].first = merges;
        merges += t->histories[i].count;
    }
    assert(first <= slots && first >= (r->target < slots ? r->target : slots));
    assert((!r->keep_history || merges - r->merge_count == slots - first) &&
           "each merge removes one splat");
    stp_parallel_for(context, t->range_count, 1, number_pieces, t);
    free_left(r);
    r->rooms[STP_PSP_ROOM_LEFT] = r->rooms[STP_PSP_ROOM_NEXT];
    r->rooms[STP_PSP_ROOM_NEXT] = (stp_psp_room){0};
    r->blocks = t->blocks;
    r->block_count = t->range_count;
    r->survivors = t->survivors;
    r->slot_count = slots;
    r->live = first;
    r->merge_count = merges;
    t->blocks = NULL;
    t->survivors = NULL;
    free_orders(r);
    r->round += 1;
    return keep_histories(t);
}

/// Merges each piece up to the limit.
static stp_result run_pass(stp_psp_rounds* r, float limit, const stp_psp_range* ranges,
                           uint32_t count)
{
    stp_context* context = r->shared.context;
    uint32_t threads = stp_context_thread_count(context);
    pass t = {.rounds = r, .limit = limit, .ranges = ranges, .range_count = count};
    t.pieces = STP_NEW_ZEROED(context, stp_psp_piece, threads);
    t.blocks = STP_NEW_ZEROED(context, stp_psp_block, t.range_count);
    t.histories = STP_NEW_ZEROED(context, stp_psp_history, t.range_count);
    stp_psp_room* room = &r->rooms[STP_PSP_ROOM_NEXT];
    stp_result result = stp_psp_room_open(&r->storage, room);
    t.survivors = result == STP_OK ? STP_PSP_NEW(room, uint32_t, (size_t)r->live + 1) : NULL;
    t.failed = STP_NEW_ZEROED(context, uint8_t, t.range_count);
    bool made = t.pieces != NULL && t.blocks != NULL && t.histories != NULL &&
                t.survivors != NULL && t.failed != NULL;
    for (uint32_t i = 0; made && i < threads; ++i) {
        t.pieces[i] =
            (stp_psp_piece){.shared = &r->shared, .metric = r->metric, .history = r->keep_history};
    }
    if (made) {
        stp_parallel_for(context, t.range_count, 1, run_pieces, &t);
        made = take_over(&t);
    }
    for (uint32_t i = 0; t.pieces != NULL && i < threads; ++i) {
        if (t.pieces[i].shared != NULL) {
            stp_psp_piece_destroy(&t.pieces[i]);
        }
    }
    for (uint32_t i = 0; t.histories != NULL && i < t.range_count; ++i) {
        stp_free(context, t.histories[i].records);
    }
    free_blocks(room, context, t.blocks, t.range_count);
    stp_psp_room_free(room, t.survivors);
    stp_psp_room_close(room);
    stp_free(context, t.pieces);
    stp_free(context, t.histories);
    stp_free(context, t.failed);
    result = result == STP_OK && !made ? stp_psp_storage_fail(&r->storage) : result;
    return result;
}

static void read_centers(size_t begin, size_t end, uint32_t worker, void* user)
{
    stp_psp_rounds* r = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        const stp_psp_block* b = &r->blocks[i];
        stp_psp_rounds_release(r, i);
        assert(b->first <= r->live && b->count <= r->live - b->first);
        for (uint32_t s = 0; s < b->count; ++s) {
            stp_vec3 c = b->splats[s].ellipse.center;
            r->order[b->first + s] = (stp_kd_point){{c.x, c.y, c.z}, b->first + s};
        }
    }
}

/// Limit of a round: chosen so that about half of the splats are merged, but not below the target.
static stp_result choose_limit(stp_psp_rounds* r, float* limit)
{
    float* errors = STP_NEW_ARRAY(r->shared.context, float, SAMPLES);
    if (errors == NULL) {
        return stp_fail_memory(r->shared.context);
    }
    uint32_t count = stp_psp_sample_errors(r, errors, SAMPLES);
    assert(r->live > r->target);
    double part = (double)(r->live - r->target) / (MERGES_EACH * (double)r->live);
    part = part < PART_MAX ? part : PART_MAX;
    *limit = count > 0 ? errors[(uint32_t)(part * (count - 1))] : FLT_MAX;
    stp_free(r->shared.context, errors);
    return STP_OK;
}

/// Lists the centres of the previous round's results; splitting sorts them.
static stp_result make_order(stp_psp_rounds* r)
{
    stp_context* context = r->shared.context;
    stp_psp_room* room = &r->rooms[STP_PSP_ROOM_WORK];
    stp_result result = stp_psp_room_open(&r->storage, room);
    if (result != STP_OK) {
        return result;
    }
    r->order = STP_PSP_NEW(room, stp_kd_point, (size_t)r->live + 1);
    if (r->order == NULL) {
        return stp_psp_storage_fail(&r->storage);
    }
    stp_parallel_for(context, r->block_count, 1, read_centers, r);
    return STP_OK;
}

/// Runs one round with the given piece size.
static stp_result run_round(stp_psp_rounds* r, uint32_t piece_size)
{
    stp_psp_range* ranges = NULL;
    uint32_t count = 0;
    float limit = FLT_MAX;
    stp_result result = r->round > 0 ? make_order(r) : STP_OK;
    if (result == STP_OK) {
        result = stp_psp_split_slots(r, piece_size, &ranges, &count);
    }
    if (result == STP_OK && r->round > 0) {
        result = stp_psp_renumber(r);
    }
    if (result == STP_OK && count > 1) {
        result = choose_limit(r, &limit);
    }
    if (result == STP_OK) {
        result = run_pass(r, limit, ranges, count);
    }
    stp_free(r->shared.context, ranges);
    return result;
}

void stp_psp_rounds_begin(stp_psp_rounds* r, stp_context* context, const stp_psp_points* points,
                          const stp_psp_desc* desc, uint32_t target)
{
    assert(desc->neighbours > 0 && desc->neighbours <= STP_NEIGHBOURS_MAX);
    *r = (stp_psp_rounds){.shared = {.context = context, .points = points, .desc = *desc},
                          .metric = stp_psp_metric_find(desc->metric),
                          .target = target};
    stp_psp_storage_begin(&r->storage, context, desc->spill);
    r->shared.room = &r->rooms[STP_PSP_ROOM_POINTS];
}

void stp_psp_rounds_release(const stp_psp_rounds* r, size_t number)
{
    if (r->storage.beside == NULL || number % RELEASED != 0) {
        return;
    }
    stp_spill_release_pages(r->storage.beside);
    for (int i = 0; i < STP_PSP_ROOMS; ++i) {
        if (r->rooms[i].file != NULL) {
            stp_spill_release_pages(r->rooms[i].file);
        }
    }
}

stp_result stp_psp_rounds_run(stp_psp_rounds* r)
{
    assert(r->round == 0 && r->shared.scale > 0.0f && r->alone > 0.0f);
    uint32_t size = r->shared.desc.piece_size != 0 ? r->shared.desc.piece_size : PIECE_SIZE;
    size = size > STP_KD_LEAF ? size : STP_KD_LEAF;
    bool stalled = false, linked = false, more = r->tree.count > 0;
    r->live = r->tree.count;
    while (more) {
        uint32_t before = r->live, over = before > r->target ? before - r->target : 0;
        bool one = before <= size || stalled || over <= before / 8;
        stp_result result = run_round(r, one ? before : size);
        if (result != STP_OK) {
            return result;
        }
        more = r->live > r->target;
        stalled = before - r->live < over / 16;
        if (more && one) {
            more = r->shared.desc.connect_components && (!linked || r->live < before);
            if (more && !r->shared.desc.keep_angle) {
                r->shared.desc.min_cosine = -2.0f;
            }
            result = more ? stp_psp_relink(r) : STP_OK;
            if (result != STP_OK) {
                return result;
            }
            linked = true;
            stalled = false;
        }
    }
    return STP_OK;
}

void stp_psp_rounds_destroy(stp_psp_rounds* r)
{
    stp_context* context = r->shared.context;
    free_left(r);
    free_orders(r);
    for (uint32_t i = 0; i < r->history_count; ++i) {
        stp_free(context, r->histories[i].records);
    }
    stp_free(context, r->histories);
    if (r->metric->close != NULL) {
        r->metric->close(&r->shared);
    }
    stp_psp_room_close(&r->rooms[STP_PSP_ROOM_POINTS]);
    stp_psp_storage_end(&r->storage);
}
