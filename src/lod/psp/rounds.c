// SPDX-License-Identifier: MIT
#include "lod/psp/rounds.h"

#include "base/parallel_sort.h"
#include "base/rng.h"
#include "lod/psp/load.h"
#include "lod/psp/nearest_points.h"

#include <string.h>

enum {
    PIECE_SIZE = 8192, ///< the default
    SAMPLES = 1024,    ///< of errors, from which the limit of a round is chosen
};

/// The part of the splats whose best merge may be made in a round, at most.
#define PART_MOST 0.9
/// Merges for each splat whose best merge is within the limit; found by measuring, and only used to aim.
#define MERGES_EACH 0.6

typedef struct range {
    uint32_t begin, end; ///< slots
} range;

/// A round that runs.
typedef struct pass {
    stp_psp_rounds* rounds;
    const range* ranges;
    uint32_t range_count;
    float limit;
    stp_psp_piece* pieces; ///< of each thread
    stp_psp_block* blocks; ///< of each range
    stp_psp_history* histories;
    uint32_t* survivors;
    uint8_t* failed; ///< of each range
} pass;

/// Cuts the splats into pieces. In the first round these are parts of the tree; later ones are cut at other places each round.
typedef struct cutter {
    stp_psp_rounds* rounds;
    range *ranges, *next;
    uint32_t count, piece_size, depth;
} cutter;

static uint32_t cut_of(const cutter* c, range of)
{
    uint32_t count = of.end - of.begin;
    if (c->rounds->round == 0) { // where the tree is cut
        uint32_t begin = of.begin / STP_KD_LEAF;
        uint32_t end = of.end / STP_KD_LEAF + (of.end % STP_KD_LEAF != 0 ? 1 : 0);
        return (begin + (end - begin) / 2) * STP_KD_LEAF;
    }
    // three to five eighths
    uint64_t part = 384 + (stp_rng_hash(c->rounds->round, c->depth) & 255);
    return of.begin + (uint32_t)(count * part / 1024);
}

static bool is_small(const cutter* c, range of)
{
    uint32_t least = c->piece_size > STP_KD_LEAF ? c->piece_size : STP_KD_LEAF;
    return of.end - of.begin <= least;
}

static void cut_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    const cutter* c = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        range of = c->ranges[i];
        bool small = is_small(c, of);
        uint32_t middle = small ? of.end : cut_of(c, of);
        if (!small && c->rounds->order != NULL) {
            stp_kd_point* points = c->rounds->order + of.begin;
            size_t count = of.end - of.begin;
            stp_kd_select(points, count, middle - of.begin, stp_kd_widest(points, count));
        }
        c->next[2 * i] = (range){of.begin, middle};
        c->next[2 * i + 1] = (range){middle, of.end};
    }
}

/// @param ranges receives the pieces; to be freed
static stp_result cut_pieces(stp_psp_rounds* r, uint32_t piece_size, range** ranges,
                             uint32_t* count)
{
    // pieces hold more than a third of the size each
    size_t most = 4 + 2 * (3 * (size_t)r->live / piece_size + 1);
    stp_context* context = r->shared.context;
    cutter c = {.rounds = r, .piece_size = piece_size, .count = 1};
    c.ranges = STP_NEW_ARRAY(context, range, most);
    c.next = STP_NEW_ARRAY(context, range, most);
    if (c.ranges == NULL || c.next == NULL) {
        stp_free(context, c.ranges);
        stp_free(context, c.next);
        return stp_fail_memory(context);
    }
    c.ranges[0] = (range){0, r->live};
    for (bool all = false; !all; ++c.depth) {
        stp_parallel_for(context, c.count, 1, cut_some, &c);
        uint32_t kept = 0;
        all = true;
        for (uint32_t i = 0; i < 2 * c.count; ++i) {
            range of = c.next[i];
            if (of.end > of.begin) {
                all = all && is_small(&c, of);
                c.ranges[kept++] = of;
            }
        }
        c.count = kept;
    }
    stp_free(context, c.next);
    *ranges = c.ranges;
    *count = c.count;
    return STP_OK;
}

static bool run_piece(pass* t, uint32_t number, stp_psp_piece* piece)
{
    stp_psp_rounds* r = t->rounds;
    range of = t->ranges[number];
    uint64_t count = of.end - of.begin;
    // pieces together never leave fewer than the target
    uint64_t least = (count * r->target + r->live - 1) / r->live;
    if (!stp_psp_load(r, piece, of.begin, of.end) ||
        !stp_psp_piece_run(piece, t->limit, (uint32_t)least) ||
        !stp_psp_unload(piece, &t->blocks[number], t->survivors + of.begin)) {
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
    return (id & STP_PSP_RECORDED) == 0
               ? id
               : r->shared.points->count + h->first + (id & ~STP_PSP_RECORDED);
}

/// Numbers what is left and what was merged, now that all pieces are known.
static void number_pieces(size_t begin, size_t end, uint32_t worker, void* user)
{
    const pass* t = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        const stp_psp_block* b = &t->blocks[i];
        const stp_psp_history* h = &t->histories[i];
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

static void free_blocks(stp_context* context, stp_psp_block* blocks, uint32_t count)
{
    for (uint32_t i = 0; blocks != NULL && i < count; ++i) {
        stp_free(context, blocks[i].memory);
    }
    stp_free(context, blocks);
}

/// Keeps histories of pieces that made merges. @return false where memory runs out
static bool keep_histories(pass* t)
{
    stp_psp_rounds* r = t->rounds;
    if (!r->keep_history) {
        return true;
    }
    size_t needed = (size_t)r->history_count + t->range_count;
    if (r->history_room < needed) {
        stp_psp_history* grown = stp_grow_array(r->shared.context, r->histories, &r->history_room,
                                                needed, sizeof(*grown));
        if (grown == NULL) {
            return false;
        }
        r->histories = grown;
    }
    for (uint32_t i = 0; i < t->range_count; ++i) {
        if (t->histories[i].count > 0) {
            r->histories[r->history_count++] = t->histories[i];
            t->histories[i] = (stp_psp_history){0};
        }
    }
    return true;
}

/// What the round leaves takes the place of what the last one left.
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
    stp_parallel_for(context, t->range_count, 1, number_pieces, t);
    free_blocks(context, r->blocks, r->block_count);
    stp_free(context, r->survivors);
    r->blocks = t->blocks;
    r->block_count = t->range_count;
    r->survivors = t->survivors;
    r->slot_count = slots;
    r->live = first;
    r->merge_count = merges;
    t->blocks = NULL;
    t->survivors = NULL;
    stp_kd_tree_destroy(context, &r->tree);
    stp_free(context, r->order);
    stp_free(context, r->reverse);
    r->order = NULL;
    r->reverse = NULL;
    r->reverse_count = 0;
    r->round += 1;
    return keep_histories(t);
}

/// Merges each piece up to the limit.
static stp_result run_pass(stp_psp_rounds* r, float limit, const range* ranges, uint32_t count)
{
    stp_context* context = r->shared.context;
    uint32_t threads = stp_context_thread_count(context);
    pass t = {.rounds = r, .limit = limit, .ranges = ranges, .range_count = count};
    t.pieces = STP_NEW_ZEROED(context, stp_psp_piece, threads);
    t.blocks = STP_NEW_ZEROED(context, stp_psp_block, t.range_count);
    t.histories = STP_NEW_ZEROED(context, stp_psp_history, t.range_count);
    t.survivors = STP_NEW_ARRAY(context, uint32_t, (size_t)r->live + 1);
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
    free_blocks(context, t.blocks, t.range_count);
    stp_free(context, t.pieces);
    stp_free(context, t.histories);
    stp_free(context, t.survivors);
    stp_free(context, t.failed);
    return made ? STP_OK : stp_fail_memory(context);
}

static void read_centers(size_t begin, size_t end, uint32_t worker, void* user)
{
    stp_psp_rounds* r = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        const stp_psp_block* b = &r->blocks[i];
        for (uint32_t s = 0; s < b->count; ++s) {
            stp_vec3 c = b->splats[s].ellipse.center;
            r->order[b->first + s] = (stp_kd_point){{c.x, c.y, c.z}, b->first + s};
        }
    }
}

/// The limit of a round: such that about half of the splats are merged, but fewer than to the target.
static stp_result choose_limit(stp_psp_rounds* r, float* limit)
{
    float* errors = STP_NEW_ARRAY(r->shared.context, float, SAMPLES);
    if (errors == NULL) {
        return stp_fail_memory(r->shared.context);
    }
    uint32_t count = stp_psp_sample_errors(r, errors, SAMPLES);
    double part = (double)(r->live - r->target) / (MERGES_EACH * (double)r->live);
    part = part < PART_MOST ? part : PART_MOST;
    *limit = count > 0 ? errors[(uint32_t)(part * (count - 1))] : FLT_MAX;
    stp_free(r->shared.context, errors);
    return STP_OK;
}

typedef struct numbering {
    stp_psp_rounds* rounds;
    uint32_t* slots; ///< of splats by number
    size_t* starts;  ///< of blocks: where their links across seams go
    uint64_t* reverse;
} numbering;

static void number_slots(size_t begin, size_t end, uint32_t worker, void* user)
{
    const numbering* n = user;
    (void)worker;
    for (size_t slot = begin; slot < end; ++slot) {
        n->slots[n->rounds->order[slot].index] = (uint32_t)slot;
    }
}

static void number_survivors(size_t begin, size_t end, uint32_t worker, void* user)
{
    const numbering* n = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        n->rounds->survivors[i] = n->slots[n->rounds->survivors[i]];
    }
}

static void reverse_links(size_t begin, size_t end, uint32_t worker, void* user)
{
    const numbering* n = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        const stp_psp_block* b = &n->rounds->blocks[i];
        size_t at = n->starts[i];
        for (uint32_t s = 0; s < b->count; ++s) {
            for (uint32_t l = b->begins[s]; l < b->begins[s + 1]; ++l) {
                if ((b->links[l] & STP_PSP_OUTSIDE) != 0) {
                    uint32_t to = n->rounds->survivors[b->links[l] & ~STP_PSP_OUTSIDE];
                    n->reverse[at++] = (uint64_t)to << 32 | n->slots[b->first + s];
                }
            }
        }
    }
}

static void count_links(size_t begin, size_t end, uint32_t worker, void* user)
{
    const numbering* n = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        const stp_psp_block* b = &n->rounds->blocks[i];
        n->starts[i] = 0;
        for (uint32_t l = 0; l < b->begins[b->count]; ++l) {
            n->starts[i] += (b->links[l] & STP_PSP_OUTSIDE) != 0 ? 1 : 0;
        }
    }
}

/// After the first round: a point may be among the nearest of another one across a seam, where only the other knows it.
static bool turn_links(numbering* n)
{
    stp_psp_rounds* r = n->rounds;
    stp_context* context = r->shared.context;
    size_t total = 0;
    n->starts = STP_NEW_ARRAY(context, size_t, (size_t)r->block_count + 1);
    if (n->starts == NULL) {
        return false;
    }
    stp_parallel_for(context, r->block_count, 1, count_links, n);
    for (uint32_t i = 0; i < r->block_count; ++i) {
        size_t count = n->starts[i];
        n->starts[i] = total;
        total += count;
    }
    uint64_t* scratch = STP_NEW_ARRAY(context, uint64_t, total + 1);
    uint64_t* sorted = NULL;
    n->reverse = STP_NEW_ARRAY(context, uint64_t, total + 1);
    if (n->reverse != NULL && scratch != NULL) {
        stp_parallel_for(context, r->block_count, 1, reverse_links, n);
        sorted = stp_parallel_sort_u64(context, n->reverse, scratch, total, 32, 31);
    }
    stp_free(context, sorted != scratch ? scratch : NULL);
    stp_free(context, sorted != n->reverse ? n->reverse : NULL);
    stp_free(context, n->starts);
    r->reverse = sorted;
    r->reverse_count = sorted != NULL ? total : 0;
    return sorted != NULL;
}

/// Puts what the last round left in an order that can be cut.
static stp_result make_order(stp_psp_rounds* r)
{
    stp_context* context = r->shared.context;
    r->order = STP_NEW_ARRAY(context, stp_kd_point, (size_t)r->live + 1);
    if (r->order == NULL) {
        return stp_fail_memory(context);
    }
    stp_parallel_for(context, r->block_count, 1, read_centers, r);
    return STP_OK;
}

/// Slots of the last round become those of the round to come.
static stp_result renumber(stp_psp_rounds* r)
{
    stp_context* context = r->shared.context;
    numbering n = {.rounds = r, .slots = STP_NEW_ARRAY(context, uint32_t, (size_t)r->live + 1)};
    bool made = n.slots != NULL;
    if (made) {
        stp_parallel_for(context, r->live, 1 << 16, number_slots, &n);
        stp_parallel_for(context, r->slot_count, 1 << 16, number_survivors, &n);
        made = r->round != 1 || r->block_count == 1 || turn_links(&n);
    }
    stp_free(context, n.slots);
    return made ? STP_OK : stp_fail_memory(context);
}

/// One round, with pieces of a size or with one piece.
static stp_result run_round(stp_psp_rounds* r, uint32_t piece_size)
{
    range* ranges = NULL;
    uint32_t count = 0;
    float limit = FLT_MAX;
    stp_result result = r->round > 0 ? make_order(r) : STP_OK;
    if (result == STP_OK) {
        result = cut_pieces(r, piece_size, &ranges, &count);
    }
    if (result == STP_OK && r->round > 0) {
        result = renumber(r);
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

/// Links each splat with the nearest ones anew.
static stp_result link_anew(stp_psp_rounds* r)
{
    stp_context* context = r->shared.context;
    stp_psp_block* b = &r->blocks[0]; // one queue ran last
    uint32_t count = b->count, k = r->shared.desc.neighbours;
    float* centers = STP_NEW_ARRAY(context, float, 3 * (size_t)count + 1);
    uint32_t* near = STP_NEW_ARRAY(context, uint32_t, (size_t)k * count + 1);
    uint32_t* survivors = STP_NEW_ARRAY(context, uint32_t, (size_t)count + 1);
    size_t state_bytes = count * r->metric->state_bytes, splat_bytes = count * sizeof(*b->splats);
    stp_psp_block linked = {.count = count};
    stp_result result = STP_ERROR_OUT_OF_MEMORY;
    if (centers != NULL && near != NULL && survivors != NULL) {
        for (size_t i = 0; i < count; ++i) {
            memcpy(centers + 3 * i, &b->splats[i].ellipse.center, 3 * sizeof(float));
            survivors[i] = (uint32_t)i;
        }
        result = stp_find_nearest_points(context, centers, count, k, near);
    }
    if (result == STP_OK) {
        linked.memory =
            stp_alloc(context, splat_bytes + state_bytes +
                                   (count + 1 + 2 * (size_t)k * count) * sizeof(uint32_t));
    }
    if (result == STP_OK && linked.memory == NULL) {
        result = STP_ERROR_OUT_OF_MEMORY;
    }
    if (result == STP_OK) {
        memcpy(linked.memory, b->memory, splat_bytes + state_bytes);
        linked.splats = linked.memory;
        linked.states = (uint8_t*)linked.memory + splat_bytes;
        linked.begins = (uint32_t*)(void*)(linked.states + state_bytes);
        linked.links = linked.begins + count + 1;
        memset(linked.begins, 0, (count + 1) * sizeof(uint32_t));
        // both ways; the piece drops what is there twice
        for (size_t i = 0; i < (size_t)k * count; ++i) {
            if (near[i] != UINT32_MAX) {
                linked.begins[i / k] += 1;
                linked.begins[near[i]] += 1;
            }
        }
        uint32_t total = 0;
        for (uint32_t i = 0; i <= count; ++i) {
            total += i < count ? linked.begins[i] : 0;
            linked.begins[i] = total;
        }
        for (size_t i = (size_t)k * count; i-- > 0;) {
            if (near[i] != UINT32_MAX) {
                linked.links[--linked.begins[i / k]] = near[i];
                linked.links[--linked.begins[near[i]]] = (uint32_t)(i / k);
            }
        }
        stp_free(context, b->memory);
        *b = linked;
        stp_free(context, r->survivors);
        r->survivors = survivors;
        r->slot_count = count;
        survivors = NULL;
        linked.memory = NULL;
    }
    stp_free(context, linked.memory);
    stp_free(context, centers);
    stp_free(context, near);
    stp_free(context, survivors);
    return result == STP_OK ? STP_OK : stp_fail_memory(context);
}

stp_result stp_psp_rounds_run(stp_psp_rounds* r)
{
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
                r->shared.desc.least_cosine = -2.0f;
            }
            result = more ? link_anew(r) : STP_OK;
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
    stp_kd_tree_destroy(context, &r->tree);
    free_blocks(context, r->blocks, r->block_count);
    for (uint32_t i = 0; i < r->history_count; ++i) {
        stp_free(context, r->histories[i].records);
    }
    stp_free(context, r->histories);
    stp_free(context, r->survivors);
    stp_free(context, r->order);
    stp_free(context, r->reverse);
    if (r->metric->close != NULL) {
        r->metric->close(&r->shared);
    }
}
