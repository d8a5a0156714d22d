// SPDX-License-Identifier: MIT
// Decides what to load, and what to drop (evict) for it. Loads and drops are steps: one octave of a
// set, or a whole resource of another kind. The most needed step comes first, of any resource. Data
// is dropped in this order: not wanted for longest, finer than wanted, much less needed than the
// new data.
#include "base/splats/prefix_table.h"
#include "store/residency/residency_internal.h"

#include <assert.h>
#include <math.h>
#include <string.h>

// Minimum ratio of a step's need to the need of wanted data that it replaces. Without it, they
// would replace each other in turns. The wanted data depends on the resident data, so that can
// still happen: each update that drops wanted data raises the factor.
static const float min_worth = 2.0f, max_worth = 1e6f, worth_rises = 1.25f, worth_falls = 0.99f;
static const uint64_t smallest_batch = 1 << 16; ///< smaller octaves are read together

enum {
    SKIPS = 64, ///< steps that do not fit before an update gives up
    /// 1/SHORTENS of the limit stays free, for the copies made when sets are shortened
    SHORTENS = 16,
};

static uint64_t bits_of(float need)
{
    float bounded = need > 0.0f ? (need < STP_NEED_MAX ? need : STP_NEED_MAX) : 0.0f;
    uint32_t bits;
    memcpy(&bits, &bounded, sizeof(bits));
    return bits; // compares like the floats
}

/// The need of the octave after `level`.
static float need_after(const stp_residency* r, uint32_t resource, uint32_t level)
{
    const stp_resident* t = &r->resources[resource];
    if (level < t->pinned) {
        return STP_NEED_MAX;
    }
    if (level == 0 || stp_residency_kind(r, resource) != STP_RESIDENT_SPLATS) {
        return t->need;
    }
    const stp_splats* splats = stp_residency_splat_set(r, resource);
    return t->octave_need * stp_prefix_table_radius(&splats->table, splats->octave_ends[level - 1]);
}

/// Level of a resource that this update's view, or its pin, needs.
static uint32_t find_target(const stp_residency* r, const stp_resident* t)
{
    uint32_t wanted = t->used == r->updates ? t->wanted : 0;
    wanted = wanted > t->pinned ? wanted : t->pinned;
    return wanted < t->maximum ? wanted : t->maximum;
}

static void note(stp_residency* r, uint32_t resource, uint32_t wanted, float need,
                 float octave_need)
{
    stp_resident* t = &r->resources[resource];
    if (t->used != r->updates) {
        t->used = r->updates;
        t->wanted = 0;
        t->need = t->octave_need = 0.0f;
        if (t->pinned == 0) { // else it is among the steps already
            assert(r->step_count < r->firsts[STP_RESIDENT_KINDS] && "each resource once");
            r->steps[r->step_count++].resource = resource;
        }
    }
    t->wanted = (uint8_t)(wanted > t->wanted ? wanted : t->wanted);
    t->need = need > t->need ? need : t->need;
    t->octave_need = octave_need > t->octave_need ? octave_need : t->octave_need;
}

static void note_textures(stp_residency* r, uint32_t mesh, float need)
{
    const stp_store_directory* directory = &r->store->directory;
    const stp_store_material* material =
        &directory->materials[stp_store_describe_mesh(r->store, mesh)->material];
    const stp_store_texture_use* uses[STP_STORE_MATERIAL_TEXTURES];
    uint32_t count = stp_store_used_textures(material, uses);
    for (uint32_t i = 0; i < count; ++i) {
        note(r, r->firsts[STP_RESIDENT_TEXTURE] + uses[i]->texture, 1, need, 0.0f);
    }
}

static void note_requests(stp_residency* r, const stp_data_request* requests, size_t count)
{
    for (uint32_t i = 0; i < r->pin_count; ++i) {
        r->steps[r->step_count++].resource = r->pins[i];
    }
    for (size_t i = 0; i < count; ++i) {
        const stp_data_request* request = &requests[i];
        uint32_t resource = r->firsts[request->kind] + request->index;
        assert(request->kind < STP_RESIDENT_KINDS && resource < r->firsts[request->kind + 1]);
        bool splats = request->kind == STP_RESIDENT_SPLATS;
        uint32_t octaves =
            request->octaves < STP_OCTAVE_LIMIT ? request->octaves : STP_OCTAVE_LIMIT;
        note(r, resource, splats ? octaves : 1, request->need, request->octave_need);
        if (request->kind == STP_RESIDENT_MESH) {
            note_textures(r, request->index, request->need);
        }
    }
}

/// Collects missing resources without a load in flight in `steps`, most needed first.
static void sort_steps(stp_residency* r)
{
    size_t kept = 0;
    r->stats.missing = r->stats.loading = 0;
    for (size_t i = 0; i < r->step_count; ++i) {
        uint32_t resource = r->steps[i].resource;
        const stp_resident* t = &r->resources[resource];
        if (t->level >= find_target(r, t)) {
            continue;
        }
        r->stats.missing += 1;
        if (t->load != NULL) {
            r->stats.loading += 1;
            continue;
        }
        float need = need_after(r, resource, t->level);
        r->steps[kept++] = (stp_rank){.order = UINT64_MAX - bits_of(need), .resource = resource};
    }
    r->step_count = kept;
    stp_ranks_sort(r->steps, kept);
}

static uint64_t order_of_victim(const stp_residency* r, uint32_t resource)
{
    const stp_resident* t = &r->resources[resource];
    assert(t->level >= 1);
    uint32_t target = find_target(r, t);
    if (target == 0) {
        return t->used;
    }
    uint64_t kind = t->level > target ? UINT64_C(1) << 62 : UINT64_C(1) << 63;
    return kind | bits_of(need_after(r, resource, t->level - 1u));
}

static void find_victims(stp_residency* r)
{
    uint32_t count = r->firsts[STP_RESIDENT_KINDS];
    r->victim_count = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const stp_resident* t = &r->resources[i];
        if (t->level > t->pinned && t->load == NULL) {
            r->victims[r->victim_count++] =
                (stp_rank){.order = order_of_victim(r, i), .resource = i};
        }
    }
    stp_ranks_sort(r->victims, r->victim_count);
    r->victims_found = true;
}

/// Drops one step of the least needed resource, or several if it is not wanted at all.
static void drop_victim(stp_residency* r)
{
    uint32_t resource = r->victims[0].resource;
    const stp_resident* t = &r->resources[resource];
    assert(r->victim_count > 0 && t->load == NULL && t->level > t->pinned);
    uint32_t target = find_target(r, t);
    bool splats = stp_residency_kind(r, resource) == STP_RESIDENT_SPLATS;
    r->dropped_wanted = r->dropped_wanted || (target > 0 && t->level <= target);
    uint32_t level = target == 0 ? t->pinned : splats ? t->level - 1u : 0;
    assert(level < t->level && "make_room makes progress");
    stp_residency_drop(r, resource, level);
    if (t->level > t->pinned) {
        r->victims[0].order = order_of_victim(r, resource);
        stp_ranks_sink(r->victims, r->victim_count, 0);
    } else {
        r->victim_count = stp_ranks_pop(r->victims, r->victim_count);
    }
}

/// Makes room for `bytes` bytes of a step. @return false if nothing less needed is left to drop
static bool make_room(stp_residency* r, uint64_t bytes, float need, uint64_t limit)
{
    uint64_t max_given = UINT64_C(1) << 63 | bits_of(need / r->worth);
    while (bytes > limit || r->bytes > limit - bytes) {
        if (bytes > limit) {
            return false;
        }
        if (!r->victims_found) {
            find_victims(r);
        }
        if (r->victim_count == 0 || r->victims[0].order >= max_given) {
            return false;
        }
        // planned after the victims were found
        if (r->resources[r->victims[0].resource].load != NULL) {
            r->victim_count = stp_ranks_pop(r->victims, r->victim_count);
        } else {
            drop_victim(r);
        }
    }
    return true;
}

/// The limit for bulk data: the context's limit minus other uses and a reserve.
static uint64_t find_limit(const stp_residency* r)
{
    uint64_t limit = r->desc.limit_bytes != 0 ? r->desc.limit_bytes : UINT64_MAX;
    uint64_t whole = stp_memory_limit(r->context);
    if (whole != 0) {
        uint64_t live = stp_context_live_bytes(r->context);
        uint64_t others = live > r->bytes ? live - r->bytes : 0;
        uint64_t left = whole > others ? whole - others : 0;
        left = left > r->margin ? left - r->margin : 0;
        limit = left < limit ? left : limit;
    }
    return limit;
}

/// The level that a step from level `from` reaches: small octaves are loaded together.
static uint32_t find_next(const stp_residency* r, uint32_t resource, uint32_t from, uint32_t target)
{
    uint32_t to = from + 1;
    while (to < target && stp_residency_bytes(r, resource, to + 1) <= smallest_batch) {
        to += 1;
    }
    return to;
}

static stp_load* new_load(stp_residency* r, uint32_t resource)
{
    stp_load* load = r->spare;
    if (load != NULL) {
        assert(r->resources[resource].load == NULL && "one load at a time");
        r->spare = load->next;
        load->next = NULL;
        load->resource = resource;
        load->from = load->to = r->resources[resource].level;
        load->bytes = 0;
        load->memory = NULL;
        load->picture = NULL;
        load->waiting = NULL;
        load->transient = 0;
        r->resources[resource].load = load;
        *(r->first_load == NULL ? &r->first_load : &r->last_load->next) = load;
        r->last_load = load;
    }
    return load;
}

/// Plans the first step of the heap. @return false if no further step is worth trying
static bool plan_step(stp_residency* r, uint32_t* skips)
{
    uint32_t resource = r->steps[0].resource;
    stp_resident* t = &r->resources[resource];
    stp_load* load = t->load;
    uint32_t target = find_target(r, t), from = load != NULL ? load->to : t->level;
    uint32_t to = stp_residency_kind(r, resource) == STP_RESIDENT_SPLATS
                      ? find_next(r, resource, from, target)
                      : 1;
    assert(from < target && to <= t->maximum);
    uint64_t transient = stp_residency_transient(r, resource, to);
    uint64_t bytes =
        stp_residency_bytes(r, resource, to) + transient - (load != NULL ? load->bytes : 0);
    if (r->under_way > 0 && r->under_way + bytes > r->desc.batch_bytes) {
        return false;
    }
    if (load == NULL && r->spare == NULL) {
        return false;
    }
    float need = need_after(r, resource, from);
    // a load must not drop its own resource
    load = load != NULL ? load : new_load(r, resource);
    bool fits = make_room(r, bytes, need, r->limit - r->limit / SHORTENS);
    if (fits) {
        load->to = to;
        load->bytes += bytes;
        load->transient = transient;
        stp_residency_count(r, bytes);
        r->under_way += bytes;
    }
    if (fits && to < target) {
        r->steps[0].order = UINT64_MAX - bits_of(need_after(r, resource, to));
        stp_ranks_sink(r->steps, r->step_count, 0);
    } else {
        r->step_count = stp_ranks_pop(r->steps, r->step_count);
    }
    *skips += fits ? 0 : 1;
    return *skips < SKIPS;
}

/// Allocates memory for the planned loads. Loads without memory are cancelled for this update.
static void prepare_loads(stp_residency* r)
{
    stp_load* load = r->first_load;
    r->first_load = r->last_load = NULL;
    while (load != NULL) {
        stp_load* next = load->next;
        load->next = NULL;
        if (load->to > load->from && stp_residency_prepare(r, load)) {
            *(r->first_load == NULL ? &r->first_load : &r->last_load->next) = load;
            r->last_load = load;
            r->stats.loading += 1;
        } else {
            assert(load->bytes <= r->under_way && load->bytes <= r->bytes);
            r->bytes -= load->bytes;
            r->under_way -= load->bytes;
            r->resources[load->resource].load = NULL;
            load->next = r->spare;
            r->spare = load;
        }
        load = next;
    }
}

void stp_residency_evict_all(stp_residency* r)
{
    r->limit = find_limit(r);
    r->victims_found = false;
    (void)make_room(r, 0, INFINITY, r->limit);
}

void stp_residency_plan(stp_residency* r, const stp_data_request* requests, size_t count)
{
    uint32_t skips = 0;
    r->step_count = 0;
    note_requests(r, requests, count);
    sort_steps(r);
    stp_residency_evict_all(r); // other uses may have grown
    r->dropped_wanted = false;
    while (r->step_count > 0 && plan_step(r, &skips)) {
    }
    float worth = r->worth * (r->dropped_wanted ? worth_rises : worth_falls);
    r->worth = fminf(fmaxf(worth, min_worth), max_worth);
    prepare_loads(r);
}
