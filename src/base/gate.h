// SPDX-License-Identifier: MIT
//
// A gate that lets jobs begin while the memory they announce fits a budget. Who comes first goes in first, so a large
// job is not passed by small ones for ever; one larger than the budget runs alone.
//
// Nothing waits for what waits for it: a thread that is inside goes in again at once, and a loop begun by a thread
// inside has at least one job going. Whoever is inside must not wait for a job that is still to go in.
#pragma once

#include "base/context.h"

#include <pthread.h>

typedef struct stp_gate stp_gate;

/// One passage; the caller's, from entering to leaving.
typedef struct stp_gate_ticket {
    uint64_t bytes;
    pthread_t holder;
    bool in_loop; ///< entered from a piece of a parallel loop
    struct stp_gate_ticket* next;
} stp_gate_ticket;

/// `budget_bytes` 0: everyone goes in. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_gate_create(stp_context* context, uint64_t budget_bytes,
                                        stp_gate** gate);
void stp_gate_destroy(stp_gate* gate);

/// Waits until there is room for `bytes`. Any thread; the one that reports the loop goes on reporting.
/// @return STP_OK; STP_ERROR_CANCELLED: the loop was stopped meanwhile, and the ticket is not to be given back
STP_MUST_USE stp_result stp_gate_enter(stp_gate* gate, uint64_t bytes, stp_gate_ticket* ticket);
/// From the thread that entered.
void stp_gate_leave(stp_gate* gate, stp_gate_ticket* ticket);

/// The most bytes that were inside at once.
uint64_t stp_gate_peak_bytes(stp_gate* gate);
