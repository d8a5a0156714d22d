// SPDX-License-Identifier: MIT
//
// Bulk data under a memory limit (docs/algorithms/residency.md). Worker threads read octaves of
// splat sets, meshes, point sets and textures, most needed first, and less needed data is dropped.
// With a residency attached, a store gives only *resident* data and never waits for the disk.
//
// Everything but reading happens in stp_residency_update. The thread that selects and draws calls
// it between frames. Between two calls the resident data does not change, and pointers from the
// store stay valid. So a selection is a pure function of its view and this state, independent of
// thread timing.
#pragma once

#include "store/file/store.h"

typedef enum stp_resident_kind {
    STP_RESIDENT_SPLATS, ///< loaded octave by octave
    STP_RESIDENT_MESH,   ///< with the textures of its material
    STP_RESIDENT_POINTS,
    STP_RESIDENT_TEXTURE, ///< not as part of a mesh
    STP_RESIDENT_LEAVES,  ///< leaves of a set, with their tree
    STP_RESIDENT_KINDS
} stp_resident_kind;

/// What a view would draw, resident or not.
///
/// Needs are relative: the apparent size of the coarser stand-in, in splats of the wanted size.
typedef struct stp_data_request {
    stp_resident_kind kind;
    uint32_t index;
    uint32_t octaves; ///< number of octaves, for splats
    float need;       ///< need while nothing of it is resident
    /// Splats: the need of an octave is this times the radius covered without it.
    float octave_need;
    uint32_t resource; ///< stp_store_resource; ignored here, for callers that keep lists
} stp_data_request;

#define STP_NEED_MAX 1e30f

typedef struct stp_residency stp_residency;

typedef struct stp_residency_desc {
    /// Maximum bytes of bulk data; 0: only the context's own limit. An eighth of the latter (at
    /// least 1 MiB) is reserved for other uses.
    uint64_t limit_bytes;
    uint32_t thread_count; ///< reader threads; default 2
    uint64_t batch_bytes;  ///< maximum bytes in flight, or a single resource; default 16 MiB
    /// Reads a part of the file; called by several threads at once. Returns false on failure. NULL:
    /// the store's own file.
    bool (*read)(void* user, uint64_t offset, void* bytes, size_t size);
    void* read_user;
} stp_residency_desc;

typedef struct stp_residency_stats {
    uint64_t limit_bytes;    ///< limit at the last update
    uint64_t resident_bytes; ///< at the last update, including loads in flight
    uint64_t peak_bytes;
    uint64_t read_bytes;      ///< from the file, since creation
    uint64_t loaded, dropped; ///< octaves and other resources
    uint64_t damaged;         ///< blocks that can never be loaded
    uint32_t missing;         ///< resources wanted in the last update that are not fully resident
    uint32_t loading;         ///< the part of `missing` in flight
} stp_residency_stats;

/// Attaches a residency to a store without one. The store's bulk data leaves memory. The threads
/// first load the coarsest octaves of the topmost sets, which stay: at most 1 MiB beyond the very
/// first. Not for a store opened for its summary. The store must outlive it.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (no threads), STP_ERROR_ARGUMENT;
/// logged
STP_MUST_USE stp_result stp_residency_create(stp_store* store, const stp_residency_desc* desc,
                                             stp_residency** residency);
/// Stops the threads after their current reads and drops everything; the store uses its mapped file
/// again.
void stp_residency_destroy(stp_residency* residency);

/// Call between frames. Publishes finished loads, drops less needed data if memory runs out, and
/// starts loading the missing part of `requests` (each resource at most once), most needed first.
/// Never waits and never fails: without memory, less is resident. A damaged block causes one
/// warning and is never loaded.
void stp_residency_update(stp_residency* residency, const stp_data_request* requests, size_t count);

/// Call between frames if other code ran out of the context's memory. Reserves more of it from now
/// on, and drops the least needed data to free it. @return false if there was nothing to drop
bool stp_residency_yield(stp_residency* residency);

/// Waits for all loads in flight; the next update publishes them. @return false if there were none
bool stp_residency_wait(stp_residency* residency);

void stp_residency_get_stats(const stp_residency* residency, stp_residency_stats* stats);

// Queries of resident data; without a residency, of all data in the file. `index` must be below the
// directory's count.
/// Whether directory entries may lack data: the store has a residency, or a partial file.
bool stp_store_streams(const stp_store* store);
/// Number of a set's first splats that are resident.
uint32_t stp_store_resident_splats(const stp_store* store, uint32_t index);
/// A mesh is resident together with the textures of its material.
bool stp_store_is_mesh_resident(const stp_store* store, uint32_t index);
bool stp_store_are_points_resident(const stp_store* store, uint32_t index);
/// A unique number for each load of a texture. Data derived from its texels becomes invalid when it
/// changes. 0: not resident, or no residency.
uint64_t stp_store_texture_arrival(const stp_store* store, uint32_t index);

/// Numbers all resources of a store consecutively, for tables indexed by resource.
uint32_t stp_store_resource_count(const stp_store* store);
uint32_t stp_store_resource(const stp_store* store, stp_resident_kind kind, uint32_t index);
