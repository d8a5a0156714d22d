// SPDX-License-Identifier: MIT
// The drawn share of each cluster of a frame's meshes, found by all threads before commands are
// made: there may be hundreds of thousands.
#pragma once

#include "select/select.h"

struct stp_gl_renderer;

typedef struct stp_gl_share_item stp_gl_share_item;

typedef struct stp_gl_cluster_shares {
    stp_gl_share_item* items; ///< meshes of the list, in its order
    size_t count, capacity;
    float* shares; ///< drawn share of each of their clusters; 0: not drawn
    size_t share_capacity;
    size_t next; ///< item of the last request; earlier ones are skipped
} stp_gl_cluster_shares;

/// Finds the shares for the renderer's list and placement.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, or as the store's functions; logged
STP_MUST_USE stp_result stp_gl_cluster_shares_find(struct stp_gl_renderer* r);
/// Shares of a mesh of the list that is clustered and not of large triangles. Ask in the list's
/// order.
const float* stp_gl_cluster_shares_get(stp_gl_cluster_shares* shares, size_t item);
void stp_gl_cluster_shares_destroy(stp_context* context, stp_gl_cluster_shares* shares);
