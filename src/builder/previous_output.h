// SPDX-License-Identifier: MIT
//
// The output of a previous build. Unchanged results are taken from it by content key.
#pragma once

#include "builder/work.h"
#include "store/clusters/clusters.h"
#include "store/file/store.h"

typedef struct stp_previous_output stp_previous_output;

/// Opens `path`. NULL if there is no regular file, it is not a readable `.stip` file, or memory
/// runs out. Logs nothing, because a previous output is optional.
stp_previous_output* stp_previous_output_open(const char* path);
void stp_previous_output_close(stp_previous_output* previous);

// Each function looks a result up and keeps it in the work directory; `splats` or `mesh` then
// points there. One thread at a time. @return false if there is no intact result, or it cannot be
// stored
bool stp_previous_output_take_splat_set(stp_previous_output* previous, stp_hash key,
                                        uint32_t shading_count, stp_work* work, stp_splats* splats);
bool stp_previous_output_take_mesh(stp_previous_output* previous, stp_hash key, stp_work* work,
                                   stp_coded_mesh* mesh);
