// SPDX-License-Identifier: MIT
// Life cycle of a residency, and queries.
#include "store/bytes/chunks.h"
#include "store/file/block_table.h"
#include "store/file/texture_images.h"
#include "store/residency/residency_internal.h"
#include "store/sets/sets_internal.h"

#include <assert.h>
#include <string.h>

enum { ALLOCATION_BYTES = 64 }; ///< context overhead per allocation

static const uint64_t batch_bytes = 16 << 20, max_pinned = 1 << 20;

/// The block of a resource, or of one octave.
static const stp_store_block* block_of(const stp_store* store, stp_resident_kind kind,
                                       uint32_t index, uint32_t octave)
{
    assert(kind < STP_RESIDENT_KINDS);
    uint32_t block = 0;
    switch (kind) {
    case STP_RESIDENT_SPLATS: {
        const stp_store_set_record* sets = store->tables[STP_SECTION_SPLAT_SETS];
        const stp_store_octave* octaves = store->tables[STP_SECTION_OCTAVES];
        block = octaves[sets[index].first_octave + octave].block;
        break;
    }
    case STP_RESIDENT_MESH:
        block = ((const stp_store_mesh_record*)store->tables[STP_SECTION_MESHES])[index].block;
        break;
    case STP_RESIDENT_POINTS:
        block = ((const stp_store_point_record*)store->tables[STP_SECTION_POINT_SETS])[index].block;
        break;
    case STP_RESIDENT_LEAVES:
        return stp_store_leaves_block(store, index);
    case STP_RESIDENT_TEXTURE:
    case STP_RESIDENT_KINDS:
        block = ((const stp_store_texture_record*)store->tables[STP_SECTION_TEXTURES])[index].block;
        break;
    }
    return stp_store_block_at(store, block);
}

// Whether the file has the block of a mesh, point set, texture or leaf table. Points held by a set
// and sets without leaves have no block.
static bool is_in_file(const stp_store* store, stp_resident_kind kind, uint32_t index)
{
    bool held =
        kind == STP_RESIDENT_POINTS && stp_store_describe_point_set(store, index)->held_by != 0;
    const stp_store_block* block = held ? NULL : block_of(store, kind, index, 0);
    return block != NULL && stp_store_is_block_here(store, block);
}

const stp_store_block* stp_residency_block(const stp_residency* r, uint32_t resource,
                                           uint32_t octave)
{
    stp_resident_kind kind = stp_residency_kind(r, resource);
    return block_of(r->store, kind, resource - r->firsts[kind], octave);
}

uint64_t stp_residency_bytes(const stp_residency* r, uint32_t resource, uint32_t level)
{
    if (stp_residency_kind(r, resource) == STP_RESIDENT_SPLATS) {
        return stp_store_columns_bytes(stp_residency_splat_set(r, resource), level) +
               ALLOCATION_BYTES;
    }
    if (stp_residency_kind(r, resource) == STP_RESIDENT_TEXTURE) {
        const stp_store_texture* texture = stp_residency_texture(r, resource);
        return 4 * (uint64_t)texture->width * texture->height + ALLOCATION_BYTES;
    }
    if (stp_residency_kind(r, resource) == STP_RESIDENT_LEAVES) {
        uint32_t set = resource - r->firsts[STP_RESIDENT_LEAVES];
        return stp_store_leaves_bytes(stp_store_leaf_count(r->store, set)) + ALLOCATION_BYTES;
    }
    return stp_residency_block(r, resource, 0)->size + stp_residency_color_bytes(r, resource) +
           ALLOCATION_BYTES;
}

uint64_t stp_residency_color_bytes(const stp_residency* r, uint32_t resource)
{
    bool points = stp_residency_kind(r, resource) == STP_RESIDENT_POINTS;
    uint32_t index = resource - r->firsts[STP_RESIDENT_POINTS];
    return points && stp_store_is_colored(r->store)
               ? 4 * (uint64_t)stp_store_describe_point_set(r->store, index)->point_count
               : 0;
}

uint64_t stp_residency_decoder_bytes(const stp_residency* r, uint32_t resource)
{
    const stp_store_texture* texture = stp_residency_texture(r, resource);
    const stp_store_block* block = stp_residency_block(r, resource, 0);
    stp_image_info info = {.kind = (stp_image_kind)texture->encoding,
                           .width = texture->width,
                           .height = texture->height};
    bool whole = block->offset + block->size <= r->store->file.size;
    return stp_image_decoder_bytes(&info, r->store->file.bytes + (whole ? block->offset : 0),
                                   whole ? (size_t)block->size : 0);
}

uint64_t stp_residency_transient(const stp_residency* r, uint32_t resource, uint32_t level)
{
    if (stp_residency_kind(r, resource) == STP_RESIDENT_SPLATS) {
        const stp_splats* splats = stp_residency_splat_set(r, resource);
        return stp_store_has_operators(r->store, resource - r->firsts[STP_RESIDENT_SPLATS], level)
                   ? stp_store_waiting_bytes(stp_store_octave_begin(splats, level)) +
                         ALLOCATION_BYTES
                   : 0;
    }
    bool decodes = stp_residency_kind(r, resource) == STP_RESIDENT_TEXTURE &&
                   stp_residency_texture(r, resource)->encoding != 0;
    return decodes ? stp_residency_block(r, resource, 0)->size + ALLOCATION_BYTES +
                         stp_residency_decoder_bytes(r, resource)
                   : 0;
}

static void count_resources(const stp_store* store, uint32_t firsts[STP_RESIDENT_KINDS + 1])
{
    const stp_store_directory* directory = &store->directory;
    firsts[STP_RESIDENT_SPLATS] = 0;
    firsts[STP_RESIDENT_MESH] = directory->set_count;
    firsts[STP_RESIDENT_POINTS] = firsts[STP_RESIDENT_MESH] + directory->mesh_count;
    firsts[STP_RESIDENT_TEXTURE] = firsts[STP_RESIDENT_POINTS] + directory->point_set_count;
    firsts[STP_RESIDENT_LEAVES] = firsts[STP_RESIDENT_TEXTURE] + directory->texture_count;
    firsts[STP_RESIDENT_KINDS] = firsts[STP_RESIDENT_LEAVES] + store->counts[STP_SECTION_LEAVES];
}

static stp_result create_tables(stp_residency* r)
{
    uint32_t count = r->firsts[STP_RESIDENT_KINDS];
    uint32_t loads = count < STP_RESIDENCY_LOADS ? count + 1 : STP_RESIDENCY_LOADS;
    r->resources = STP_NEW_ZEROED(r->context, stp_resident, (size_t)count + 1);
    r->steps = STP_NEW_ARRAY(r->context, stp_rank, (size_t)count + 1);
    r->victims = STP_NEW_ARRAY(r->context, stp_rank, (size_t)count + 1);
    r->pins = STP_NEW_ARRAY(r->context, uint32_t, (size_t)r->firsts[STP_RESIDENT_MESH] + 1);
    r->loads = STP_NEW_ARRAY(r->context, stp_load, loads);
    if (r->resources == NULL || r->steps == NULL || r->victims == NULL || r->pins == NULL ||
        r->loads == NULL) {
        return stp_fail_memory(r->context);
    }
    for (uint32_t i = 0; i < loads; ++i) {
        r->loads[i].next = r->spare;
        r->spare = &r->loads[i];
    }
    for (uint32_t i = 0; i < count; ++i) {
        if (i < r->firsts[STP_RESIDENT_MESH]) {
            const stp_store_set_record* sets = r->store->tables[STP_SECTION_SPLAT_SETS];
            r->resources[i].maximum = (uint8_t)sets[i].whole;
        } else {
            stp_resident_kind kind = stp_residency_kind(r, i);
            r->resources[i].maximum = is_in_file(r->store, kind, i - r->firsts[kind]);
        }
    }
    return STP_OK;
}

/// Marks the sets of a method that have no coarser set above them.
static stp_result find_uppermost(stp_residency* r, uint32_t method)
{
    enum { UPPERMOST = 1, BELOW = 2 };
    const stp_store_directory* directory = &r->store->directory;
    uint8_t* reached = STP_NEW_ZEROED(r->context, uint8_t, (size_t)directory->node_count + 1);
    if (reached == NULL) {
        return stp_fail_memory(r->context);
    }
    if (directory->root != STP_STORE_NONE) {
        reached[directory->root] = UPPERMOST;
    }
    for (uint32_t i = directory->node_count; i-- > 0;) { // parents first
        const stp_store_node* node = &directory->nodes[i];
        uint8_t below = reached[i];
        if (below == 0) {
            continue;
        }
        uint32_t set = stp_store_set_of(directory, method, i);
        if (set != STP_STORE_NONE && r->resources[set].maximum > 0) {
            if ((below & UPPERMOST) != 0 && r->resources[set].pinned == 0) {
                r->resources[set].pinned = 1;
                assert(r->pin_count < r->firsts[STP_RESIDENT_MESH] && "each set is pinned once");
                r->pins[r->pin_count++] = set;
            }
            below = BELOW;
        }
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            uint32_t child = directory->edges[node->first_edge + k].node;
            assert(child < i && "the walk meets parents before children");
            bool moves = (directory->nodes[child].flags & 1u) != 0; // no ancestor's set shows it
            reached[child] |= moves ? UPPERMOST : below;
        }
    }
    stp_free(r->context, reached);
    return STP_OK;
}

/// Pins octaves of the first method's topmost sets, one by one, within a small part of the memory.
/// Other methods keep only the first octave.
static void choose_pins(stp_residency* r)
{
    assert(r->first_pins <= r->pin_count);
    uint64_t whole = stp_memory_limit(r->context), limit = r->desc.limit_bytes;
    limit = limit == 0 || (whole != 0 && whole < limit) ? whole : limit;
    uint64_t left = limit != 0 && limit / 16 < max_pinned ? limit / 16 : max_pinned;
    for (uint32_t i = 0; i < r->pin_count; ++i) {
        uint64_t bytes = stp_residency_bytes(r, r->pins[i], 1);
        left = left > bytes ? left - bytes : 0;
    }
    for (uint32_t level = 2; level <= STP_OCTAVE_LIMIT && left > 0; ++level) {
        for (uint32_t i = 0; i < r->first_pins && left > 0; ++i) {
            stp_resident* t = &r->resources[r->pins[i]];
            if (level > t->maximum) {
                continue;
            }
            uint64_t bytes = stp_residency_bytes(r, r->pins[i], level);
            t->pinned = bytes <= left ? (uint8_t)level : t->pinned;
            left = bytes <= left ? left - bytes : 0;
        }
    }
}

static void take_arrived(stp_residency* r)
{
    pthread_mutex_lock(&r->mutex);
    stp_load* load = r->arrived;
    r->arrived = NULL;
    pthread_mutex_unlock(&r->mutex);
    while (load != NULL) {
        stp_load* next = load->next;
        stp_residency_take(r, load);
        load = next;
    }
}

static uint64_t min_margin(const stp_residency* r)
{
    uint64_t part = stp_memory_limit(r->context) / 8;
    return part > 1 << 20 ? part : 1 << 20;
}

bool stp_residency_yield(stp_residency* r)
{
    uint64_t before = r->bytes;
    take_arrived(r);
    r->margin += min_margin(r);
    stp_residency_evict_all(r);
    r->stats.limit_bytes = r->limit;
    r->stats.resident_bytes = r->bytes;
    return r->bytes < before;
}

static bool read_file(void* user, uint64_t offset, void* bytes, size_t size)
{
    const stp_store* store = user;
    if (store->descriptor >= 0) {
        return stp_file_read_at(store->descriptor, offset, bytes, size);
    }
    bool whole = offset <= store->file.size && size <= store->file.size - offset;
    if (whole) {
        memcpy(bytes, store->file.bytes + offset, size);
    }
    return whole;
}

stp_result stp_residency_create(stp_store* store, const stp_residency_desc* desc,
                                stp_residency** residency)
{
    *residency = NULL;
    if (store->only_summary || store->residency != NULL) {
        return stp_fail(store->context, STP_ERROR_ARGUMENT,
                        "%s: cannot load bulk data for this store", store->path);
    }
    stp_residency* r = STP_NEW_ZEROED(store->context, stp_residency, 1);
    if (r == NULL) {
        return stp_fail_memory(store->context);
    }
    r->context = store->context;
    r->store = store;
    r->desc = *desc;
    r->desc.thread_count = desc->thread_count != 0 ? desc->thread_count : 2;
    r->desc.batch_bytes = desc->batch_bytes != 0 ? desc->batch_bytes : batch_bytes;
    if (desc->read == NULL) {
        r->desc.read = read_file;
        r->desc.read_user = store;
    }
    r->worth = 1.0f;
    r->margin = min_margin(r);
    count_resources(store, r->firsts);
    pthread_mutex_init(&r->mutex, NULL);
    pthread_cond_init(&r->work, NULL);
    pthread_cond_init(&r->done, NULL);
    atomic_init(&r->ending, false);
    stp_result result = create_tables(r);
    for (uint32_t m = 0; m < store->directory.method_count && result == STP_OK; ++m) {
        result = find_uppermost(r, m);
        r->first_pins = m == 0 ? r->pin_count : r->first_pins;
    }
    result = result == STP_OK ? stp_residency_start_threads(r) : result;
    if (result != STP_OK) {
        stp_residency_destroy(r);
        return result;
    }
    choose_pins(r);
    for (uint32_t i = 0; i < store->directory.set_count; ++i) {
        stp_store_release_splat_set(store, i);
    }
    stp_store_release_textures(store);
    stp_store_release_leaves(store);
    stp_store_release_points(store);
    store->residency = r;
    *residency = r;
    stp_residency_update(r, NULL, 0);
    return STP_OK;
}

void stp_residency_destroy(stp_residency* r)
{
    if (r == NULL) {
        return;
    }
    stp_residency_end_threads(r);
    take_arrived(r);
    for (stp_load* load = r->queue; load != NULL; load = load->next) { // never started
        stp_residency_end_load(r, load);
        stp_free(r->context, load->memory);
    }
    for (uint32_t i = 0; r->resources != NULL && i < r->firsts[STP_RESIDENT_KINDS]; ++i) {
        if (r->resources[i].memory != NULL) {
            stp_residency_drop(r, i, 0);
        }
    }
    if (r->store->residency == r) {
        r->store->residency = NULL;
    }
    pthread_cond_destroy(&r->done);
    pthread_cond_destroy(&r->work);
    pthread_mutex_destroy(&r->mutex);
    stp_free(r->context, r->loads);
    stp_free(r->context, r->pins);
    stp_free(r->context, r->victims);
    stp_free(r->context, r->steps);
    stp_free(r->context, r->resources);
    stp_free(r->context, r);
}

void stp_residency_update(stp_residency* r, const stp_data_request* requests, size_t count)
{
    r->updates += 1;
    take_arrived(r);
    stp_residency_plan(r, requests, count);
    stp_residency_start(r);
    assert(r->under_way <= r->bytes && "loads in flight are counted");
    r->stats.limit_bytes = r->limit;
    r->stats.resident_bytes = r->bytes;
}

bool stp_residency_wait(stp_residency* r)
{
    pthread_mutex_lock(&r->mutex);
    while (r->busy > 0) {
        pthread_cond_wait(&r->done, &r->mutex);
    }
    bool any = r->arrived != NULL;
    pthread_mutex_unlock(&r->mutex);
    return any;
}

void stp_residency_get_stats(const stp_residency* r, stp_residency_stats* stats)
{
    *stats = r->stats;
}

bool stp_store_streams(const stp_store* store)
{
    return store->residency != NULL || stp_store_is_partial(store);
}

uint32_t stp_store_resident_splats(const stp_store* store, uint32_t index)
{
    const stp_splats* splats = stp_store_describe_splat_set(store, index);
    const stp_store_set_record* sets = store->tables[STP_SECTION_SPLAT_SETS];
    const stp_residency* r = store->residency;
    return stp_store_octave_begin(splats,
                                  r == NULL ? sets[index].whole : r->resources[index].level);
}

/// Whether a resource other than a set is loaded or, without a residency, in the file.
static bool is_resource_here(const stp_store* store, stp_resident_kind kind, uint32_t index)
{
    const stp_residency* r = store->residency;
    return r != NULL ? r->resources[r->firsts[kind] + index].level > 0
                     : is_in_file(store, kind, index);
}

static bool are_textures_here(const stp_store* store, const stp_store_material* material)
{
    const stp_store_texture_use* uses[STP_STORE_MATERIAL_TEXTURES];
    uint32_t count = stp_store_used_textures(material, uses);
    bool here = true;
    for (uint32_t i = 0; i < count && here; ++i) {
        here = is_resource_here(store, STP_RESIDENT_TEXTURE, uses[i]->texture);
    }
    return here;
}

bool stp_store_is_mesh_resident(const stp_store* store, uint32_t index)
{
    if (!stp_store_streams(store)) {
        return true;
    }
    const stp_store_material* material =
        &store->directory.materials[stp_store_describe_mesh(store, index)->material];
    return is_resource_here(store, STP_RESIDENT_MESH, index) && are_textures_here(store, material);
}

bool stp_store_are_points_resident(const stp_store* store, uint32_t index)
{
    const stp_store_point_set* points = stp_store_describe_point_set(store, index);
    if (points->held_by != 0) {
        return stp_store_resident_splats(store, points->held_by - 1) == points->point_count;
    }
    return !stp_store_streams(store) || is_resource_here(store, STP_RESIDENT_POINTS, index);
}

uint64_t stp_store_texture_arrival(const stp_store* store, uint32_t index)
{
    const stp_residency* r = store->residency;
    const stp_resident* t =
        r != NULL ? &r->resources[r->firsts[STP_RESIDENT_TEXTURE] + index] : NULL;
    return t != NULL && t->level > 0 ? t->arrival : 0;
}

uint32_t stp_store_resource_count(const stp_store* store)
{
    uint32_t firsts[STP_RESIDENT_KINDS + 1];
    count_resources(store, firsts);
    return firsts[STP_RESIDENT_KINDS];
}

uint32_t stp_store_resource(const stp_store* store, stp_resident_kind kind, uint32_t index)
{
    uint32_t firsts[STP_RESIDENT_KINDS + 1];
    assert(kind < STP_RESIDENT_KINDS);
    count_resources(store, firsts);
    return firsts[kind] + index;
}
