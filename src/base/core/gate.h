// SPDX-License-Identifier: MIT
//
// Admits jobs while the memory they announce fits a budget. First come, first served, so small jobs
// cannot starve a large one. A job larger than the budget runs alone.
//
// Deadlock-free: a thread that is inside may enter again without waiting, and a loop started by a
// thread inside always has at least one job running. A thread inside must not wait for a job that
// has not entered yet.
#pragma once

#include "base/core/context.h"

#include <pthread.h>

typedef struct stp_gate stp_gate;

/// One passage. The caller owns it from enter to leave.
typedef struct stp_gate_ticket {
    uint64_t bytes;
    pthread_t holder;
    bool in_loop; ///< entered from a task of a parallel loop
    struct stp_gate_ticket* next;
} stp_gate_ticket;

/// `budget_bytes` 0: no limit. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_gate_create(stp_context* context, uint64_t budget_bytes,
                                        stp_gate** gate);
void stp_gate_destroy(stp_gate* gate);

/// Waits until `bytes` fit. Any thread; the reporting thread keeps reporting.
/// @return STP_OK; STP_ERROR_CANCELLED if the loop was stopped: do not leave with this ticket
STP_MUST_USE stp_result stp_gate_enter(stp_gate* gate, uint64_t bytes, stp_gate_ticket* ticket);
/// Call on the thread that entered.
void stp_gate_leave(stp_gate* gate, stp_gate_ticket* ticket);
