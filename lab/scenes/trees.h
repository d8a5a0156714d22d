// SPDX-License-Identifier: MIT
//
// Trees as pure geometry: trunk, branches and twigs as tubes, and each leaf (or tuft) as a small
// diamond. Bark and leaves are one mesh, distinguished by vertex colours.
#pragma once

#include "lab/scenes/mesh_builder.h"

enum { TREE_KINDS = 6 };

typedef struct tree_recipe {
    uint32_t kind;      ///< below TREE_KINDS
    uint32_t triangles; ///< exactly; even
    uint64_t seed;
} tree_recipe;

/// "oak", "birch", ...
const char* tree_name(uint32_t kind);
/// Triangles of a kind at full detail: 40k to 70k; TREE_TRIANGLES is the sum over all kinds.
uint32_t tree_triangles(uint32_t kind);
#define TREE_TRIANGLES 347620u

/// A mesh_maker; `parameters` is a tree_recipe. The foot is at the origin. The material should be
/// white and double-sided.
void tree_make(mesh_builder* builder, const void* parameters);
