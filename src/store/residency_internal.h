// SPDX-License-Identifier: MIT
// A residency inside, for the files that make it up: residency.c (from beginning to end, and what is asked of it),
// residency_plan.c (what to load and what to drop), residency_load.c (the threads that read), residency_publish.c (what
// comes and goes in the store's tables).
#pragma once

#include "store/internal.h"
#include "store/residency.h"

#include <pthread.h>
#include <stdatomic.h>

enum { STP_RESIDENCY_CHUNK = 1 << 16, STP_RESIDENCY_LOADS = 256 };

/// A thing that is being read, to be handed to the threads and taken back whole.
typedef struct stp_load {
    struct stp_load* next;
    uint32_t thing;
    uint32_t from, to;   ///< octaves before, and wanted; of others 0 and 1
    uint32_t reached;    ///< how far it came; less than `to`: the block after it is damaged
    void* memory;        ///< where it goes
    uint64_t bytes;      ///< of it, and of what is needed only while it is loaded
    uint64_t read_bytes; ///< from the file
    unsigned char*
        picture;        ///< memory for the encoded bytes of a texture; NULL: it is read as it is
    uint32_t* waiting;  ///< surfels: stp_store_block_source; NULL: there are no operators
    uint64_t transient; ///< bytes of both, and of the decoder
    stp_splats columns; ///< surfels: in `memory`, cut to `to`
    stp_splats before;  ///< and the columns that are resident, of which `from` octaves are copied
    stp_clusters clusters;   ///< a coded mesh, opened
    stp_store_leaves leaves; ///< a set's, opened
} stp_load;

/// A thing of the store, and how much of it is here.
typedef struct stp_resident {
    void* memory;
    uint64_t bytes;
    stp_load* load;   ///< NULL: nothing is under way
    uint64_t used;    ///< number of the update that wanted it last
    uint64_t arrival; ///< of the store's
    float need, octave_need;
    uint8_t level;  ///< octaves, or 1: here
    uint8_t most;   ///< that can come
    uint8_t pinned; ///< that are never dropped
    uint8_t wanted; ///< by that update
} stp_resident;

/// An entry of a heap: least order first, then least thing.
typedef struct stp_rank {
    uint64_t order;
    uint32_t thing;
} stp_rank;

struct stp_residency {
    stp_context* context;
    stp_store* store;
    stp_residency_desc desc;
    stp_resident* things;
    uint32_t firsts[STP_RESIDENT_KINDS + 1]; ///< thing of index 0 of each kind, and their count
    stp_rank* steps;                         ///< heap of what is missing
    stp_rank* victims;                       ///< heap of what may go
    size_t step_count, victim_count;
    bool victims_found;  ///< in this update
    bool dropped_wanted; ///< in this update
    float worth; ///< how much more a step must be needed to take the place of what is wanted
    uint32_t* pins;
    uint32_t pin_count;
    uint32_t first_pins; ///< of these are of the file's first method
    uint64_t updates;    ///< number of the current one
    uint64_t bytes, under_way, limit;
    uint64_t margin; ///< of the context's limit, for others to grow in
    stp_residency_stats stats;
    stp_load* loads; ///< all there are
    stp_load* spare;
    stp_load *first_load, *last_load; ///< to be handed over by this update
    // shared with the threads
    pthread_mutex_t mutex;
    pthread_cond_t work, done;
    stp_load *queue, *queue_end, *arrived;
    uint32_t busy; ///< loads queued or being read
    atomic_bool ending;
    uint32_t thread_count;
    pthread_t* threads;
};

static inline stp_resident_kind stp_residency_kind(const stp_residency* r, uint32_t thing)
{
    uint32_t kind = STP_RESIDENT_SURFELS;
    while (thing >= r->firsts[kind + 1]) {
        kind += 1;
    }
    return (stp_resident_kind)kind;
}

/// The set of a thing that is one.
static inline const stp_splats* stp_residency_surfels(const stp_residency* r, uint32_t thing)
{
    return stp_store_describe_surfels(r->store, thing - r->firsts[STP_RESIDENT_SURFELS]);
}

/// The texture of a thing that is one, as the file describes it.
static inline const stp_store_texture* stp_residency_texture(const stp_residency* r, uint32_t thing)
{
    return stp_store_describe_texture(r->store, thing - r->firsts[STP_RESIDENT_TEXTURE]);
}

/// The block of a thing, or of an octave of it.
const stp_store_block* stp_residency_block(const stp_residency* r, uint32_t thing, uint32_t octave);
/// Memory that so much of a thing takes.
uint64_t stp_residency_bytes(const stp_residency* r, uint32_t thing, uint32_t level);
/// Of point sets, the part that are colours which are not the file's; they lie behind the block.
uint64_t stp_residency_color_bytes(const stp_residency* r, uint32_t thing);
/// What the decoder of a texture's picture takes, as the head of the mapped file tells.
uint64_t stp_residency_decoder_bytes(const stp_residency* r, uint32_t thing);
/// Memory that is needed beside it only while it is loaded: the picture file of a texture, and its decoder; of a set of
/// operators the parents that wait.
uint64_t stp_residency_transient(const stp_residency* r, uint32_t thing, uint32_t level);
/// The need of the octave after `level`.
float stp_residency_need(const stp_residency* r, uint32_t thing, uint32_t level);

static inline void stp_residency_count(stp_residency* r, uint64_t bytes)
{
    r->bytes += bytes;
    r->stats.peak_bytes = r->bytes > r->stats.peak_bytes ? r->bytes : r->stats.peak_bytes;
}

/// Plans an update: notes wants, makes room, prepares loads. They are handed over by stp_residency_start.
void stp_residency_plan(stp_residency* r, const stp_want* wants, size_t count);

/// Drops what is needed least where the limit fell below what is here.
void stp_residency_make_way(stp_residency* r);

/// Memory for a planned load. @return false where there is none
bool stp_residency_prepare(stp_residency* r, stp_load* load);
/// Gives back what was needed only for loading.
void stp_residency_end_load(stp_residency* r, stp_load* load);
/// Takes in what a load brought, and makes the load spare.
void stp_residency_take(stp_residency* r, stp_load* load);
/// Drops a thing to `level`. Sets may be dropped further where memory for the rest cannot be had.
void stp_residency_drop(stp_residency* r, uint32_t thing, uint32_t level);

/// The threads. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged; what was started goes on)
STP_MUST_USE stp_result stp_residency_start_threads(stp_residency* r);
void stp_residency_end_threads(stp_residency* r);
/// Hands the planned loads to the threads.
void stp_residency_start(stp_residency* r);

// Heaps of ranks.
void stp_ranks_sort(stp_rank* ranks, size_t count);
void stp_ranks_sink(stp_rank* ranks, size_t count, size_t at);
/// Removes the first. @return how many are left
size_t stp_ranks_pop(stp_rank* ranks, size_t count);
