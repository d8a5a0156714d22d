// SPDX-License-Identifier: MIT
//
// What to draw for a view: a pure function of scene, view and quality (design.md, section 5).
#pragma once

#include "store/store.h"

#include <stipple/view.h>

typedef enum stp_policy {
    STP_POLICY_INSERTION, ///< prefixes by insertion radius: no hole, with a guarantee
    STP_POLICY_PAPER,     ///< prefixes by the estimate p(r) = p_m (r_m / r)^2 (Brandt 4.1)
    STP_POLICY_SWITCH,    ///< insertion, without blending between levels
} stp_policy;

typedef struct stp_quality {
    float splat_size;     ///< pixels, at least 1; default 1
    uint64_t splat_count; ///< exactly so many splats instead, in all; 0: by size
    stp_policy policy;
    bool reference; ///< original triangles and points only
} stp_quality;

typedef enum stp_draw_kind { STP_DRAW_SURFELS, STP_DRAW_MESH, STP_DRAW_POINTS } stp_draw_kind;

/// One thing to draw. Ids in the visibility buffer are frame-local: first_id + splat or triangle.
typedef struct stp_draw_item {
    stp_draw_kind kind;
    uint32_t index;  ///< surfel set, mesh or point set of the store
    uint32_t prefix; ///< surfels or points drawn
    float radius;    ///< of each splat, in the space of the item
    uint32_t first_id;
    stp_affine transform; ///< to scene space
} stp_draw_item;

typedef struct stp_draw_list {
    stp_draw_item* items;
    size_t count, capacity;
    uint64_t splat_count, triangle_count;
    uint32_t node_count;            ///< nodes looked at
    float splat_size;               ///< the size in effect
    struct stp_select_stack* stack; ///< kept between calls
    size_t stack_capacity;
    uint8_t* moving; ///< a byte a node: bit 0 it moves, bit 1 something below it does
    size_t moving_capacity;
} stp_draw_list;

/// Fills `list`; its memory is kept from call to call (stp_draw_list_destroy; all zero at first). Items
/// outside the view are left out. A node whose surfels cannot cover at the wanted size, and one that contains
/// the eye, is opened: its own triangles and points are drawn, and its children looked at. Points
/// whose surfels are all of them are never opened. Surfels show nothing that moves below their node: what does
/// is looked at by itself, with its own surfels where it has some, also below a node that is drawn.
/// @return STP_OK, STP_ERROR_ARGUMENT (a view that is none), STP_ERROR_LIMIT (more than 2^32 - 2 splats and
/// triangles), STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_select(stp_context* context, const stp_store* store,
                                   const stp_view* view, const stp_quality* quality,
                                   stp_draw_list* list);
void stp_draw_list_destroy(stp_context* context, stp_draw_list* list);
