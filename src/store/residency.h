// SPDX-License-Identifier: MIT
//
// Bulk data under a limit of memory (design.md, section 5): octaves of surfel sets, meshes, point sets and textures are
// read by threads of their own, most needed first, and give way again to what is needed more. While a residency is
// attached to a store, what the store gives of bulk data is what is *resident*: it never waits for the disk.
//
// Everything but reading happens in stp_residency_update, which the thread that selects and draws calls between its
// frames. From one call to the next what is resident does not change, and pointers that the store gave stay valid: a
// selection is a pure function of its view and this state, and which threads read when cannot be seen in it.
#pragma once

#include "store/store.h"

typedef enum stp_resident_kind {
    STP_RESIDENT_SURFELS, ///< comes octave by octave
    STP_RESIDENT_MESH,    ///< with the textures of its material
    STP_RESIDENT_POINTS,
    STP_RESIDENT_TEXTURE, ///< by itself
    STP_RESIDENT_LEAVES,  ///< of a set, with the tree over them
    STP_RESIDENT_KINDS
} stp_resident_kind;

/// What a view would draw, whether it is resident or not.
///
/// Needs are numbers that compare: how large, in splats of the size wanted, what is drawn instead looks.
typedef struct stp_want {
    stp_resident_kind kind;
    uint32_t index;
    uint32_t octaves; ///< of surfels
    float need;       ///< without any of it
    float
        octave_need; ///< surfels: times the radius that is covered without an octave, the need of that octave
    uint32_t thing; ///< for those who make lists of wants: stp_store_thing; not looked at
} stp_want;

#define STP_NEED_MOST 1e30f

typedef struct stp_residency stp_residency;

typedef struct stp_residency_desc {
    /// Most bytes of bulk data; 0: only the context's own limit holds. Of that, an eighth (at least 1 MiB) is left to others.
    uint64_t limit_bytes;
    uint32_t thread_count; ///< that read; default 2
    uint64_t batch_bytes; ///< most that is under way at once, beyond a single thing; default 16 MiB
    /// Reads a part of the file, from several threads at once; false where it cannot. NULL: the store's own file.
    bool (*read)(void* user, uint64_t offset, void* bytes, size_t size);
    void* read_user;
} stp_residency_desc;

typedef struct stp_residency_stats {
    uint64_t limit_bytes;    ///< of the last update
    uint64_t resident_bytes; ///< now, with what is under way
    uint64_t peak_bytes;
    uint64_t read_bytes;      ///< from the file, since the beginning
    uint64_t loaded, dropped; ///< octaves and other things
    uint64_t damaged;         ///< blocks that will never come
    uint32_t
        missing; ///< things that the last update's view wants and that are not, or not wholly, here
    uint32_t loading; ///< of them, those under way
} stp_residency_stats;

/// Attaches a residency to a store without one: its bulk data leaves memory, and the threads begin with the coarsest
/// octaves of what has nothing coarser above it, 1 MiB at most beyond the very first, which stay. Not for a store opened for
/// its summary. The store must outlive it.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (no threads), STP_ERROR_ARGUMENT; logged
STP_MUST_USE stp_result stp_residency_create(stp_store* store, const stp_residency_desc* desc,
                                             stp_residency** residency);
/// Ends the threads, after the reads they are in, and drops everything; the store reads from its mapped file again.
void stp_residency_destroy(stp_residency* residency);

/// Between frames: what was read is resident from now on, what is needed less gives way where memory runs out, and what
/// is missing of `wants` (each thing at most once) begins to be read, most needed first. Returns at once; never fails:
/// without memory, less is resident. A damaged block is said once, as a warning, and never comes.
void stp_residency_update(stp_residency* residency, const stp_want* wants, size_t count);

/// Between frames, where others ran out of the context's memory: leaves them more of it from now on, and drops what is
/// needed least until they have it. @return false where there was nothing to drop
bool stp_residency_yield(stp_residency* residency);

/// Waits until all that is under way was read, for the next update to take in. @return false where nothing was
bool stp_residency_wait(stp_residency* residency);

void stp_residency_get_stats(const stp_residency* residency, stp_residency_stats* stats);

// What is resident; all that the file holds where the store has no residency. `index` must be below the directory's count.
/// Whether some of what the directory lists may not be here: it has a residency, or its file ends early.
bool stp_store_streams(const stp_store* store);
/// How many of a set's first surfels are here.
uint32_t stp_store_resident_surfels(const stp_store* store, uint32_t index);
/// A mesh counts with the textures of its material.
bool stp_store_is_mesh_resident(const stp_store* store, uint32_t index);
bool stp_store_are_points_resident(const stp_store* store, uint32_t index);
/// A number that no other arrival of a texture has; what was made of its texels ends with it. 0: not resident, or the
/// store has no residency.
uint64_t stp_store_texture_arrival(const stp_store* store, uint32_t index);

/// All things of a store in one row, for tables beside it.
uint32_t stp_store_thing_count(const stp_store* store);
uint32_t stp_store_thing(const stp_store* store, stp_resident_kind kind, uint32_t index);
