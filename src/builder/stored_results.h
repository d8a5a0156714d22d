// SPDX-License-Identifier: MIT
// Results of earlier builds: in the work folder and in the previous output.
#pragma once

#include "base/io/hash.h"
#include "base/splats/splat_columns.h"
#include "builder/work.h"
#include "store/clusters/clusters.h"
#include "store/file/store.h"

#include <stdbool.h>
#include <stddef.h>

// Results of a build in the work folder: splats of nodes and coded meshes, in a form that is used
// in place. Results point into the mapping: do not write to or free them. They are valid until the
// folder is closed.
//
//   splats:     header 704 | positions | normals | materials | colours | coverages | shapes |
//                ranges | each attribute | leaves | split errors | turns | spreads
//                each padded to 64
//   coded mesh:  header 64 | bytes

/// Looks a set up; `candidates` is the number of points it was chosen from. Drops it if it is
/// invalid or has shading indices of `shading_count` or more. Any thread.
bool stp_work_find_splat_set(stp_work* work, stp_hash key, uint32_t shading_count,
                             stp_splats* splats, uint32_t* candidates);

/// Stores a set. `stored` (may be NULL) receives the mapped copy, so that `splats` may be freed.
/// Any thread. @return STP_OK, STP_ERROR_FORMAT if the set is invalid (logged), or as
/// stp_work_store
STP_MUST_USE stp_result stp_work_store_splat_set(stp_work* work, stp_hash key,
                                                 const stp_splats* splats, uint32_t candidates,
                                                 stp_splats* stored);

// The same for coded meshes.
bool stp_work_find_mesh(stp_work* work, stp_hash key, stp_coded_mesh* mesh);
STP_MUST_USE stp_result stp_work_store_mesh(stp_work* work, stp_hash key,
                                            const stp_coded_mesh* mesh, stp_coded_mesh* stored);

// Counts the results that a build found and made. Items with equal content share one result in the
// work folder: the first one makes it and the others find it, and with several threads it varies
// which is first. Only results from before the build count as found.

typedef struct stp_build_result {
    stp_hash key;
    bool made; ///< made by this build; else it existed when looked up
} stp_build_result;

/// Number of entries whose key no entry made. Sorts the entries.
size_t stp_build_count_found(stp_build_result* origins, size_t count);

// The output of a previous build. Unchanged results are taken from it by content key.

typedef struct stp_previous_output stp_previous_output;

/// Opens `path`. NULL if there is no regular file, it is not a readable `.stip` file, or memory
/// runs out. Logs nothing, because a previous output is optional.
stp_previous_output* stp_previous_output_open(const char* path);
void stp_previous_output_close(stp_previous_output* previous);

// Each function looks a result up and keeps it in the work folder; `splats` or `mesh` then points
// there. One thread at a time. @return false if there is no intact result, or it cannot be stored
bool stp_previous_output_take_splat_set(stp_previous_output* previous, stp_hash key,
                                        uint32_t shading_count, stp_work* work, stp_splats* splats);
bool stp_previous_output_take_mesh(stp_previous_output* previous, stp_hash key, stp_work* work,
                                   stp_coded_mesh* mesh);
