// SPDX-License-Identifier: MIT
// A priority queue of splats by the error of their best merge: a heap with four children per node
// that tracks the position of each splat.
#pragma once

#include "lod/psp/metric.h"

typedef struct stp_psp_queue_entry {
    float error;
    uint32_t splat;
} stp_psp_queue_entry;

/// On ties, the splat with the lower key comes first.
typedef struct stp_psp_queue {
    stp_psp_queue_entry* heap; ///< capacity for all splats
    uint32_t* places;          ///< position of each splat in the heap; UINT32_MAX: not queued
    const stp_psp_splat* splats;
    uint32_t count;
} stp_psp_queue;

/// Appends an entry of a splat that is not queued. Call stp_psp_queue_order after the last one.
void stp_psp_queue_append(stp_psp_queue* queue, uint32_t splat, float error);
void stp_psp_queue_order(stp_psp_queue* queue);

/// Queues a splat, or moves it to another error.
void stp_psp_queue_set(stp_psp_queue* queue, uint32_t splat, float error);
/// Removes a splat; does nothing if it is not queued.
void stp_psp_queue_remove(stp_psp_queue* queue, uint32_t splat);
