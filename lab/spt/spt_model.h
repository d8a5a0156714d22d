// SPDX-License-Identifier: MIT
// Data drawn by `stipple-lab bench spt`: the sequence of a point tree, the tree's nodes on the same
// grid, and the views.
#pragma once

#include "base/splats/splat_columns.h"
#include "lod/spt/point_tree.h"
#include "raster/splats.h"

#include <stipple/view.h>

/// Size of the picture, and maximum number of points that a traversal draws together.
enum { SPT_WIDTH = 1920, SPT_HEIGHT = 1080, SPT_BLOCK = 4096 };

typedef struct spt_model {
    stp_context* context;
    const stp_point_tree* tree;
    stp_splats set;      ///< the sequence, with groups
    stp_splats directed; ///< the same with split errors
    uint16_t* positions; ///< 3 per node, on the grid of the set
    int8_t* normals;     ///< 2 per node
    uint32_t* shapes;
    uint16_t* bits; ///< one bit per splat of the sequence
} spt_model;

/// Sums over views of the times of selecting and drawing. CPU work besides drawing is also listed
/// separately: traversing and gathering blocks, or testing the sequence.
typedef struct spt_times {
    uint64_t traversal_splats, sequence_splats, group_splats, directed_splats;
    uint64_t traversal_pixels, sequence_pixels, group_pixels, directed_pixels; ///< covered
    uint64_t directed_examined;                   ///< splats of prefixes
    uint64_t sequence_submitted, group_submitted; ///< OpenGL: splats of commands
    uint64_t sequence_commands, group_commands;
    double traversal_ms, sequence_ms, group_ms, directed_ms;
    double gather_ms, test_ms, group_test_ms, directed_test_ms;
} spt_times;

/// A view of the model, and the part of the sequence that it draws.
typedef struct spt_view {
    stp_tree_view tree; ///< as the traversal takes it
    stp_view view;
    stp_raster_camera camera;
    float per_depth; ///< the level at depth 1
    uint32_t prefix, directed_prefix;
} spt_view;

/// @param tree made from `samples`; must outlive the model. The caller destroys the model, also
///         after a failure.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result spt_model_create(stp_context* context, const stp_point_tree* tree,
                                         const stp_splats* samples, spt_model* model);
void spt_model_destroy(spt_model* model);

/// @return false if the eye coincides with the target
bool spt_model_make_view(const spt_model* model, const stp_tree_view* from, stp_vec3d target,
                         spt_view* view);

/// The prefix's splats, or those of a block.
stp_raster_splats spt_model_splats(const stp_splats* set, uint32_t count);

/// How a sequence is drawn.
typedef enum spt_way {
    SPT_PLAIN,    ///< each splat is tested
    SPT_GROUPED,  ///< groups are culled first
    SPT_DIRECTED, ///< with split errors, without groups
} spt_way;

/// The sequence of a way, and the part of it that a view draws.
const stp_splats* spt_model_set(const spt_model* model, spt_way way);
uint32_t spt_view_prefix(const spt_view* view, spt_way way);

/// Sets the model's bits of those splats of the prefix that the view draws.
void spt_model_pick(spt_model* model, const spt_view* view, spt_way way);
/// Number of set bits of the prefix.
uint64_t spt_model_count(const spt_model* model, const spt_view* view, spt_way way);
