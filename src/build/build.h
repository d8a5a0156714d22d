// SPDX-License-Identifier: MIT
//
// The offline driver: import, order, write.
#pragma once

#include "import/import.h"
#include "lod/blue.h"

typedef struct stp_build_desc {
    const char* const* inputs;
    size_t input_count;
    const char* output;
    stp_import_desc import;
    stp_blue_desc blue;
    uint64_t
        threshold; ///< a node of triangles gets surfels above so many; default 1,000 (5.2); 1: always
    /// Adds a named scene; NULL: "scene:" inputs are unknown.
    stp_result (*generate)(stp_scene* scene, const char* name, void* user);
    void* generate_user;
    const char* parameters_json; ///< written into the file: what the user asked for
} stp_build_desc;

typedef struct stp_build_report {
    double import_s, partition_s, capture_s, order_s, finish_s, write_s, total_s;
    uint64_t candidates;
} stp_build_report;

/// Builds one scene from the inputs and writes it. @return STP_OK or what the stages return (logged)
STP_MUST_USE stp_result stp_build(stp_context* context, const stp_build_desc* desc,
                                  stp_build_report* report);
