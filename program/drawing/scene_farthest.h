// SPDX-License-Identifier: MIT
// The content of an imported scene for the search of farthest points (select/farthest.h).
#pragma once

#include "scene/scene.h"
#include "select/farthest.h"

/// The whole content of a finished scene, which must outlive the graph and not be empty.
stp_farthest_graph scene_farthest_graph(const stp_scene* scene);
