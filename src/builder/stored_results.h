// SPDX-License-Identifier: MIT
//
// Results of a build in the work directory: splats of nodes and coded meshes, in a form that is
// used in place. Results point into the mapping: do not write to or free them. They are valid until
// the directory is closed.
//
//   splats:     header 704 | positions | normals | materials | colours | coverages | shapes |
//                ranges | each attribute | leaves
//                each padded to 64
//   coded mesh:  header 64 | bytes
#pragma once

#include "base/splats/splat_columns.h"
#include "builder/work.h"
#include "store/clusters/clusters.h"

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
