// SPDX-License-Identifier: MIT
// Internals of a residency, shared by residency.c (life cycle, queries), residency_plan.c (what to
// load and drop), residency_load.c (reader threads) and residency_publish.c (changes to the store's
// tables).
#pragma once

#include "store/file/store_state.h"
#include "store/residency/residency.h"

#include <assert.h>
#include <pthread.h>
#include <stdatomic.h>

enum { STP_RESIDENCY_CHUNK = 1 << 16, STP_RESIDENCY_LOADS = 256 };

/// A load in flight. It is handed to the threads and back as a whole.
typedef struct stp_load {
    struct stp_load* next;
    uint32_t resource;
    uint32_t from, to;       ///< octaves resident and wanted; for other resources 0 and 1
    uint32_t reached;        ///< result; less than `to`: the next block is damaged
    void* memory;            ///< destination
    uint64_t bytes;          ///< size of `memory` plus temporary buffers
    uint64_t read_bytes;     ///< from the file
    unsigned char* picture;  ///< buffer for a texture's image file; NULL: read directly
    uint32_t* waiting;       ///< splats: stp_store_block_source; NULL: no operators
    uint64_t decoder;        ///< bytes reserved for the decoder of `picture`
    uint64_t transient;      ///< part of `bytes` that only loading needs
    stp_splats columns;      ///< splats: in `memory`, truncated to `to`
    stp_splats before;       ///< the resident columns; `from` octaves are copied from them
    stp_clusters clusters;   ///< a coded mesh, opened
    stp_store_leaves leaves; ///< leaves of a set, opened
} stp_load;

/// A resource of the store and how much of it is resident.
typedef struct stp_resident {
    void* memory;
    uint64_t bytes;
    stp_load* load;   ///< NULL: no load in flight
    uint64_t used;    ///< number of the update that last wanted it
    uint64_t arrival; ///< number of its last load among all of the store
    float need, octave_need;
    uint8_t level;   ///< resident octaves; of other resources 0 or 1
    uint8_t maximum; ///< maximum possible level
    uint8_t pinned;  ///< octaves that are never dropped
    uint8_t wanted;  ///< level that update `used` wanted
} stp_resident;

/// A heap entry: smallest order first, then smallest resource.
typedef struct stp_rank {
    uint64_t order;
    uint32_t resource;
} stp_rank;

struct stp_residency {
    stp_context* context;
    stp_store* store;
    stp_residency_desc desc;
    stp_resident* resources;
    uint32_t firsts[STP_RESIDENT_KINDS + 1]; ///< index of the first of each kind, then the total
    stp_rank* steps;                         ///< heap of missing resources
    stp_rank* victims;                       ///< heap of candidates for dropping
    size_t step_count, victim_count;
    bool victims_found;  ///< in this update
    bool dropped_wanted; ///< in this update
    float worth; ///< minimum ratio of a step's need to the need of wanted data that it replaces
    uint32_t* pins;
    uint32_t pin_count;
    uint32_t first_pins; ///< number of pins of the file's first method
    uint64_t updates;    ///< number of the current one
    uint64_t bytes, under_way, limit;
    uint64_t margin; ///< reserve of the context's limit for other uses
    stp_residency_stats stats;
    stp_load* loads; ///< all load records
    stp_load* spare;
    stp_load *first_load, *last_load; ///< planned by this update
    // Shared with the threads:
    pthread_mutex_t mutex;
    pthread_cond_t work, done;
    stp_load *queue, *queue_end, *arrived;
    uint32_t busy; ///< loads queued or being read
    atomic_bool ending;
    uint32_t thread_count;
    pthread_t* threads;
};

static inline stp_resident_kind stp_residency_kind(const stp_residency* r, uint32_t resource)
{
    assert(resource < r->firsts[STP_RESIDENT_KINDS] && "or the loop would not end");
    uint32_t kind = STP_RESIDENT_SPLATS;
    while (resource >= r->firsts[kind + 1]) {
        kind += 1;
    }
    return (stp_resident_kind)kind;
}

/// The set of a resource of that kind.
static inline const stp_splats* stp_residency_splat_set(const stp_residency* r, uint32_t resource)
{
    assert(stp_residency_kind(r, resource) == STP_RESIDENT_SPLATS);
    return stp_store_describe_splat_set(r->store, resource - r->firsts[STP_RESIDENT_SPLATS]);
}

/// The texture of a resource of that kind, as described by the file.
static inline const stp_store_texture* stp_residency_texture(const stp_residency* r,
                                                             uint32_t resource)
{
    assert(stp_residency_kind(r, resource) == STP_RESIDENT_TEXTURE);
    return stp_store_describe_texture(r->store, resource - r->firsts[STP_RESIDENT_TEXTURE]);
}

/// The block of a resource, or of one octave.
const stp_store_block* stp_residency_block(const stp_residency* r, uint32_t resource,
                                           uint32_t octave);
/// Memory for a resource at a level.
uint64_t stp_residency_bytes(const stp_residency* r, uint32_t resource, uint32_t level);
/// Replacement colours of a point set; stored after its block.
uint64_t stp_residency_color_bytes(const stp_residency* r, uint32_t resource);
/// Memory for decoding a texture's picture, from the header in the mapped file.
uint64_t stp_residency_decoder_bytes(const stp_residency* r, uint32_t resource);
/// Extra memory during loading: the image file of a texture and its decoder; for operators, the
/// queue of parents.
uint64_t stp_residency_transient(const stp_residency* r, uint32_t resource, uint32_t level);

static inline void stp_residency_count(stp_residency* r, uint64_t bytes)
{
    r->bytes += bytes;
    r->stats.peak_bytes = r->bytes > r->stats.peak_bytes ? r->bytes : r->stats.peak_bytes;
}

/// Plans an update: registers requests, makes room, prepares loads for stp_residency_start.
void stp_residency_plan(stp_residency* r, const stp_data_request* requests, size_t count);

/// Drops the least needed data if the limit fell below the resident size.
void stp_residency_evict_all(stp_residency* r);

/// Allocates the memory of a planned load. @return false if there is none
bool stp_residency_prepare(stp_residency* r, stp_load* load);
/// Frees the memory that only loading needed.
void stp_residency_end_load(stp_residency* r, stp_load* load);
/// Publishes a finished load and recycles its record.
void stp_residency_take(stp_residency* r, stp_load* load);
/// Drops a resource to `level`. A set may be dropped further if there is no memory for
/// the remaining copy.
void stp_residency_drop(stp_residency* r, uint32_t resource, uint32_t level);

/// Starts the threads. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged; started
/// threads go on)
STP_MUST_USE stp_result stp_residency_start_threads(stp_residency* r);
void stp_residency_end_threads(stp_residency* r);
/// Hands the planned loads to the threads.
void stp_residency_start(stp_residency* r);

// Heaps of ranks.
void stp_ranks_sort(stp_rank* ranks, size_t count);
void stp_ranks_sink(stp_rank* ranks, size_t count, size_t at);
/// Removes the first. @return the number left
size_t stp_ranks_pop(stp_rank* ranks, size_t count);
