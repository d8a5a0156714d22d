#pragma once
#include "base/context.h"
#include "lod/psp/ellipse.h"
typedef struct stp_decimate_input {
    uint32_t count;
    const float* positions;    ///< 3 a point; finite
    const float* normals;      ///< NULL, or 3 a point: unit, or zero where unknown
    const uint8_t* colors;     ///< NULL: white, or 3 a point, sRGB
    const uint32_t* triangles; ///< NULL, or 3 point indices each; used by `mesh` alone
    uint32_t triangle_count;
} stp_decimate_input;
typedef struct stp_decimate_output { // freed by stp_decimate_output_destroy, also after a failure
    stp_ellipse* ellipses;
    uint8_t* colors;
    uint32_t count;
    float* vertices;
    uint32_t vertex_count;
    uint32_t* triangles;
    uint32_t triangle_count; // of `mesh` alone
} stp_decimate_output;
STP_MUST_USE stp_result stp_decimate_by_subsample(stp_context*, const stp_decimate_input*,
                                                  uint32_t target, stp_decimate_output*);
