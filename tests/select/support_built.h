// SPDX-License-Identifier: MIT
// Random scenes from the regular build, with everything that separates objects from the graph:
// shared parts, prototypes, instances, mirrors, and layers that partitioning dissolves. Also lists
// every instance by brute force.
#pragma once

#include "tests.h"

#include "store/file/instances.h"
#include "store/outline/outline.h"

/// Builds the scene of a seed into a temporary file and opens it; NULL on failure. With splats,
/// each node has some.
stp_store* built_open(stp_context* context, uint64_t seed, bool splats);

enum { BUILT_PLACES = 4096 };

/// All instances of all parts.
typedef struct built_places {
    uint32_t count;
    stp_instance places[BUILT_PLACES];
} built_places;

/// Adds all instances below a placed node. @return false if the array is full
bool built_unfold(const stp_store* store, uint32_t node, const stp_affine* transform,
                  built_places* out);
/// Whether one of them is the same part at the same place.
bool built_has(const built_places* places, const stp_instance* place);
