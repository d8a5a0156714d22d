// SPDX-License-Identifier: MIT
//
// What the work directory keeps of a build: surfels of nodes and coded meshes, as bytes that can be used where they
// lie. What is found points into the mapping: it must neither be written to nor freed, and lives until the directory
// is closed.
//
//   surfels:     head 704 | positions | normals | materials | colours | coverages | shapes | ranges | each attribute | leaves
//                each padded to 64
//   coded mesh:  head 64 | bytes
#pragma once

#include "build/work.h"
#include "store/clusters.h"

#include <stipple/surfels.h>

/// Looks a set up; `candidates` is what it was chosen from. One that makes no sense, or names a shading beyond
/// `shading_count`, is forgotten. Any thread.
bool stp_work_find_surfels(stp_work* work, stp_hash key, uint32_t shading_count,
                           stp_splats* surfels, uint32_t* candidates);

/// Stores a set; `stored` (may be NULL) is the same set in the mapping, so that `surfels` may be freed. Any thread.
/// @return STP_OK, or what stp_work_store returns
STP_MUST_USE stp_result stp_work_store_surfels(stp_work* work, stp_hash key,
                                               const stp_splats* surfels, uint32_t candidates,
                                               stp_splats* stored);

// The same for meshes coded to clusters.
bool stp_work_find_mesh(stp_work* work, stp_hash key, stp_coded_mesh* mesh);
STP_MUST_USE stp_result stp_work_store_mesh(stp_work* work, stp_hash key,
                                            const stp_coded_mesh* mesh, stp_coded_mesh* stored);
