// SPDX-License-Identifier: MIT
//
// The output of a former build: what has not changed since is taken from it, by content key.
#pragma once

#include "build/work.h"
#include "store/clusters.h"
#include "store/store.h"

typedef struct stp_previous_output stp_previous_output;

/// Opens `path` where there is a file that holds results; NULL where there is none, or none that can be read: a
/// former output is a help, never a need, so nothing is logged.
stp_previous_output* stp_previous_output_open(const char* path);
void stp_previous_output_close(stp_previous_output* former);

// Each looks a result up and keeps it in the work directory, where `surfels` or `mesh` then points. One thread at a
// time. @return false where there is none, or none whole
bool stp_previous_output_take_surfels(stp_previous_output* former, stp_hash key,
                                      uint32_t shading_count, stp_work* work, stp_splats* surfels);
bool stp_previous_output_take_mesh(stp_previous_output* former, stp_hash key, stp_work* work,
                                   stp_coded_mesh* mesh);
