// SPDX-License-Identifier: MIT
// A small scene with levels.
#pragma once

#include "support_mesh.h"

#include "store/writer/writer.h"

#include <stdlib.h>

enum {
    LEVELS_NODES = 3,
    LEVELS_OWN = 2, ///< meshes that are parts of nodes: one of floats, one of clusters
    LEVELS_LEVELS = 3,
    LEVELS_MESHES = LEVELS_OWN + LEVELS_LEVELS,
    LEVELS_CLUSTERS = 7,
    LEVELS_GROUPS = 2,
    LEVELS_MATERIALS = 4, ///< 0 of parts, 1 unused, 2 and 3 of levels alone
};

/// Node 0 has a coarse and a middle level, the root one of three clusters; node 1 has none.
typedef struct levels_fixture {
    stp_context* context;
    made_mesh sheets[LEVELS_MESHES];
    stp_coded_mesh coded[LEVELS_MESHES];
    stp_store_mesh meshes[LEVELS_MESHES];
    stp_hash keys[LEVELS_MESHES];
    stp_store_material materials[LEVELS_MATERIALS];
    stp_store_node nodes[LEVELS_NODES];
    stp_store_edge edges[2];
    stp_store_part parts[2];
    stp_store_level levels[LEVELS_LEVELS];
    stp_store_level_cluster clusters[LEVELS_CLUSTERS];
    stp_store_level_group groups[LEVELS_GROUPS];
    stp_store_content content;
    unsigned char* bytes; ///< the last file written; NULL: none
    size_t size;
} levels_fixture;

/// Do not move `f`. @return false if memory runs out; tear down in either case
bool levels_set_up(levels_fixture* f, stp_context* context);
void levels_tear_down(levels_fixture* f);

/// The same content without its levels and the materials that they alone use.
stp_store_content levels_without(const levels_fixture* f);

/// Writes content to a scratch file and reads its bytes into `f`.
stp_result levels_write(levels_fixture* f, const stp_store_content* content);
/// Opens the bytes, of which the first `prefix` are there (0: all).
stp_result levels_open(levels_fixture* f, uint64_t prefix, stp_store** store);
