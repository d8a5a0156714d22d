// SPDX-License-Identifier: MIT
#include "base/core/gate.h"

#include "base/core/clock.h"
#include "base/core/context_internal.h"

#include <assert.h>

struct stp_gate {
    stp_context* context;
    uint64_t budget;
    pthread_mutex_t mutex;
    pthread_cond_t moved;     ///< a ticket left, or the queue advanced
    stp_gate_ticket* inside;  ///< tickets inside
    uint64_t bytes;           ///< announced by the tickets inside
    uint64_t jobs;            ///< number of tickets inside that loop tasks entered
    uint64_t arrived, called; ///< position in the queue: next to assign, next to enter
};

stp_result stp_gate_create(stp_context* context, uint64_t budget_bytes, stp_gate** gate)
{
    stp_gate* made = STP_NEW_ZEROED(context, stp_gate, 1);
    if (made == NULL) {
        return stp_fail_memory(context);
    }
    made->context = context;
    made->budget = budget_bytes != 0 ? budget_bytes : UINT64_MAX;
    pthread_mutex_init(&made->mutex, NULL);
    stp_condition_init(&made->moved);
    *gate = made;
    return STP_OK;
}

void stp_gate_destroy(stp_gate* gate)
{
    if (gate != NULL) {
        assert(gate->inside == NULL && "a job is still inside");
        assert(gate->arrived == gate->called && "a job still waits");
        assert(gate->bytes == 0 && gate->jobs == 0);
        pthread_cond_destroy(&gate->moved);
        pthread_mutex_destroy(&gate->mutex);
        stp_free(gate->context, gate);
    }
}

static bool is_inside(const stp_gate* gate, pthread_t thread)
{
    const stp_gate_ticket* ticket = gate->inside;
    while (ticket != NULL && !pthread_equal(ticket->holder, thread)) {
        ticket = ticket->next;
    }
    return ticket != NULL;
}

static bool has_room(const stp_gate* gate, const stp_gate_ticket* ticket)
{
    bool fits = ticket->bytes <= gate->budget && gate->bytes <= gate->budget - ticket->bytes;
    // no thread is inside except the thread that started the loop and waits for it
    return fits || gate->jobs == 0;
}

static void admit(stp_gate* gate, stp_gate_ticket* ticket)
{
    ticket->next = gate->inside;
    gate->inside = ticket;
    gate->bytes += ticket->bytes;
    gate->jobs += ticket->in_loop;
}

// Waits in the queue. Call with the mutex held.
static stp_result wait_in_queue(stp_gate* gate, const stp_gate_ticket* ticket)
{
    uint64_t number = gate->arrived++;
    stp_result result = STP_OK;
    // a waiter that gives up keeps its place until it is called, so that the queue advances
    while (number != gate->called || (result == STP_OK && !has_room(gate, ticket))) {
        stp_result wait_result =
            stp_condition_wait_reported(gate->context, &gate->moved, &gate->mutex);
        result = result == STP_OK ? wait_result : result;
    }
    assert(gate->called < gate->arrived);
    gate->called += 1;
    pthread_cond_broadcast(&gate->moved);
    return result;
}

stp_result stp_gate_enter(stp_gate* gate, uint64_t bytes, stp_gate_ticket* ticket)
{
    *ticket = (stp_gate_ticket){
        .bytes = bytes,
        .holder = pthread_self(),
        .in_loop = gate->context->loop != NULL || stp_jobs_running(gate->context->jobs),
    };
    stp_result result = STP_OK;
    pthread_mutex_lock(&gate->mutex);
    if (!is_inside(gate, ticket->holder)) {
        result = wait_in_queue(gate, ticket);
    }
    if (result == STP_OK) {
        admit(gate, ticket);
    }
    pthread_mutex_unlock(&gate->mutex);
    return result;
}

void stp_gate_leave(stp_gate* gate, stp_gate_ticket* ticket)
{
    pthread_mutex_lock(&gate->mutex);
    stp_gate_ticket** at = &gate->inside;
    assert(pthread_equal(ticket->holder, pthread_self()) && "leaves on the thread that entered");
    while (*at != ticket) {
        assert(*at != NULL && "the ticket is not inside");
        at = &(*at)->next;
    }
    *at = ticket->next;
    assert(gate->bytes >= ticket->bytes && gate->jobs >= (ticket->in_loop ? 1u : 0u));
    gate->bytes -= ticket->bytes;
    gate->jobs -= ticket->in_loop;
    pthread_cond_broadcast(&gate->moved);
    pthread_mutex_unlock(&gate->mutex);
}
