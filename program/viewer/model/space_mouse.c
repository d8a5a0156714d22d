// SPDX-License-Identifier: MIT
#include "program/viewer/model/space_mouse.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

#ifdef STP_HAS_SPNAV
#include <spnav.h>
#endif

struct space_mouse {
    void (*wake)(void* user);
    void* user;
    pthread_t thread;
    pthread_mutex_t mutex; ///< protects what follows
    bool quits;
    int socket; ///< to the daemon; -1: not connected
    double last[6];
    double sum[6]; ///< of `count` events that were not read yet
    double count;
    uint32_t pressed;
};

#ifdef STP_HAS_SPNAV

static const double full_deflection = 350.0; // of devices at the usual sensitivity
static const double most_deflection = 4.0;   // bounds what a damaged event can do

/// Whether the window has been woken for something that it has not read yet.
static bool has_news(const space_mouse* m)
{
    return m->count > 0.0 || m->pressed != 0;
}

static void add_deflection(space_mouse* m, const double axes[6])
{
    memcpy(m->last, axes, sizeof(m->last));
    for (int i = 0; i < 6; ++i) {
        m->sum[i] += axes[i];
    }
    m->count += 1.0;
}

static void add_event(space_mouse* m, const spnav_event* event)
{
    double axes[6] = {0};
    if (event->type == SPNAV_EVENT_MOTION) {
        const int counts[6] = {event->motion.x,  event->motion.y,  event->motion.z,
                               event->motion.rx, event->motion.ry, event->motion.rz};
        for (int i = 0; i < 6; ++i) {
            double value = (double)counts[i] / full_deflection;
            axes[i] = stp_clampd(value, -most_deflection, most_deflection);
        }
        add_deflection(m, axes);
    } else if (event->type == SPNAV_EVENT_BUTTON) {
        bool counts =
            event->button.press != 0 && event->button.bnum >= 0 && event->button.bnum < 32;
        m->pressed |= counts ? UINT32_C(1) << event->button.bnum : 0;
    } else if (event->type == SPNAV_EVENT_DEV) {
        add_deflection(m, axes); // a device that is unplugged sends no rest
    }
}

/// Handles an event, and wakes the window if it has read all earlier ones. NULL: the daemon is gone.
static void take_event(space_mouse* m, const spnav_event* event)
{
    static const double rest[6] = {0};
    pthread_mutex_lock(&m->mutex);
    bool had_news = has_news(m);
    if (event != NULL) {
        add_event(m, event);
    } else {
        m->socket = -1;
        add_deflection(m, rest);
    }
    if (!had_news && has_news(m) && !m->quits) {
        m->wake(m->user);
    }
    pthread_mutex_unlock(&m->mutex);
}

/// After an event that libspnav does not know, or the end of the connection: waits for more.
/// @return false at the end
static bool goes_on(int socket)
{
    char byte;
    ssize_t got;
    do {
        got = recv(socket, &byte, 1, MSG_PEEK);
    } while (got < 0 && errno == EINTR);
    return got > 0;
}

static void* run(void* user)
{
    space_mouse* m = user;
    sigset_t pipe;
    sigemptyset(&pipe);
    sigaddset(&pipe, SIGPIPE); // libspnav writes to a daemon that may just have ended
    (void)pthread_sigmask(SIG_BLOCK, &pipe, NULL);
    errno = 0; // spnav_open looks at it when a read ends early
    if (spnav_open() != 0) {
        return NULL;
    }
    int socket = spnav_fd();
    (void)fcntl(socket, F_SETFD, FD_CLOEXEC); // not for the processes that read foreign formats
    pthread_mutex_lock(&m->mutex);
    bool quits = m->quits;
    m->socket = socket;
    pthread_mutex_unlock(&m->mutex);
    spnav_event event;
    while (!quits) {
        if (spnav_wait_event(&event) != 0) {
            take_event(m, &event);
        } else {
            quits = !goes_on(socket);
        }
    }
    take_event(m, NULL);
    (void)spnav_close();
    return NULL;
}

#endif

space_mouse* space_mouse_open(void (*wake)(void* user), void* user)
{
#ifdef STP_HAS_SPNAV
    space_mouse* m = calloc(1, sizeof(*m));
    if (m == NULL) {
        return NULL;
    }
    m->wake = wake;
    m->user = user;
    m->socket = -1;
    pthread_mutex_init(&m->mutex, NULL);
    if (pthread_create(&m->thread, NULL, run, m) != 0) {
        pthread_mutex_destroy(&m->mutex);
        free(m);
        return NULL;
    }
    return m;
#else
    (void)wake;
    (void)user;
    return NULL;
#endif
}

void space_mouse_close(space_mouse* m)
{
    if (m == NULL) {
        return;
    }
    pthread_mutex_lock(&m->mutex);
    m->quits = true;
    if (m->socket >= 0) {
        (void)shutdown(m->socket, SHUT_RDWR); // ends the thread's wait
    }
    pthread_mutex_unlock(&m->mutex);
    pthread_join(m->thread, NULL);
    pthread_mutex_destroy(&m->mutex);
    free(m);
}

space_mouse_motion space_mouse_read(space_mouse* m)
{
    space_mouse_motion motion = {.moves = false};
    if (m == NULL) {
        return motion;
    }
    pthread_mutex_lock(&m->mutex);
    for (int i = 0; i < 6; ++i) {
        double value = m->count > 0.0 ? m->sum[i] / m->count : m->last[i];
        *(i < 3 ? &motion.axes.moves[i] : &motion.axes.turns[i - 3]) = value;
        motion.moves = motion.moves || value != 0.0;
        m->sum[i] = 0.0;
    }
    m->count = 0.0;
    motion.pressed = m->pressed;
    m->pressed = 0;
    pthread_mutex_unlock(&m->mutex);
    return motion;
}

bool space_mouse_is_connected(space_mouse* m)
{
    if (m == NULL) {
        return false;
    }
    pthread_mutex_lock(&m->mutex);
    bool connected = m->socket >= 0;
    pthread_mutex_unlock(&m->mutex);
    return connected;
}
