// SPDX-License-Identifier: MIT
// What a graphics processor is measured with beside pictures: copying memory, and selecting.
#pragma once

#include "present/headless.h"
#include "select/select.h"

/// Bytes a second that the device copies, from memory to memory: each is read and written. 0: it cannot be told.
double gl_measure_copy(const stp_headless* headless, uint64_t size);

/// Milliseconds that making a list takes: medians.
typedef struct gl_select_times {
    double cpu_ms, gpu_ms;
    size_t items;   ///< of the processor's list
    bool same;      ///< as many are in the other
    uint32_t nodes; ///< looked at
} gl_select_times;

/// @return as stp_select and gl_select_create
STP_MUST_USE stp_result gl_measure_select(stp_context* context, const stp_headless* headless,
                                          const stp_store* store, const stp_view* view,
                                          float splat_size, gl_select_times* times);
