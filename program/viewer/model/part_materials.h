// SPDX-License-Identifier: MIT
// The materials of a part, for the panel of its properties.
#pragma once

#include "store/file/store.h"

enum { PART_MATERIALS_MAX = 6 };

typedef struct part_materials {
    /// Indices in the store, each once, in the order in which the file's parts use them
    uint32_t materials[PART_MATERIALS_MAX];
    uint32_t count; ///< number of materials
    bool more;      ///< there are more, or the part is too large to search completely
} part_materials;

/// Lists the materials below a node, visiting a bounded number of nodes and meshes. `node` may be
/// STP_STORE_NONE: no materials.
part_materials part_materials_find(const stp_store* store, uint32_t node);
