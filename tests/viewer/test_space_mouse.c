// SPDX-License-Identifier: MIT
// A SpaceMouse whose daemon is this test: it speaks spacenavd's protocol of version 0, in which an
// event is eight integers.
#include "tests.h"

#include "program/viewer/model/space_mouse.h"

#include <errno.h>
#include <math.h>
#include <semaphore.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

enum { MOTION = 0, PRESS = 1, RELEASE = 2, DEVICE = 3, FULL = 350, WAIT_SECONDS = 20 };

/// The daemon's side of the connection.
typedef struct fake_daemon {
    int listener, client;
    char folder[64], path[96];
    sem_t woken;
    space_mouse* mouse;
} fake_daemon;

static void wake(void* user)
{
    sem_post(&((fake_daemon*)user)->woken);
}

/// Waits until the window would be woken. @return false after a long time
static bool await(fake_daemon* d)
{
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_sec += WAIT_SECONDS;
    int waited;
    do {
        waited = sem_timedwait(&d->woken, &until);
    } while (waited != 0 && errno == EINTR);
    return waited == 0;
}

static bool listens(fake_daemon* d)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    snprintf(d->folder, sizeof(d->folder), "/tmp/stp_space_mouse_XXXXXX");
    if (mkdtemp(d->folder) == NULL) {
        return false;
    }
    snprintf(d->path, sizeof(d->path), "%s/socket", d->folder);
    snprintf(address.sun_path, sizeof(address.sun_path), "%s", d->path);
    d->listener = socket(AF_UNIX, SOCK_STREAM, 0);
    return d->listener >= 0 &&
           bind(d->listener, (struct sockaddr*)&address, sizeof(address)) == 0 &&
           listen(d->listener, 1) == 0 && setenv("SPNAV_SOCKET", d->path, 1) == 0;
}

/// Accepts the viewer, and refuses newer versions of the protocol.
static bool accepts(fake_daemon* d)
{
    int32_t request = 0;
    d->client = accept(d->listener, NULL, NULL);
    bool asked = d->client >= 0 && read(d->client, &request, sizeof(request)) == sizeof(request);
    request &= ~0xff;
    return asked && write(d->client, &request, sizeof(request)) == sizeof(request);
}

static void hang_up(fake_daemon* d)
{
    close(d->client);
    close(d->listener);
    unlink(d->path);
    rmdir(d->folder);
}

/// @return false if there can be no SpaceMouse here
static bool begin(test_state* test, fake_daemon* d)
{
    *d = (fake_daemon){.client = -1};
    sem_init(&d->woken, 0, 0);
    CHECK(listens(d));
    d->mouse = space_mouse_open(wake, d);
    if (d->mouse == NULL) {
#ifdef STP_HAS_SPNAV
        CHECK(d->mouse != NULL);
#endif
        test->skipped = "built without libspnav";
        hang_up(d);
        return false;
    }
    CHECK(accepts(d));
    return d->client >= 0;
}

static void end(fake_daemon* d)
{
    space_mouse_close(d->mouse);
    hang_up(d);
    sem_destroy(&d->woken);
}

static bool sends(fake_daemon* d, int32_t type, const int32_t values[6])
{
    int32_t event[8] = {type, 0, 0, 0, 0, 0, 0, 8};
    memcpy(event + 1, values, 6 * sizeof(values[0]));
    return write(d->client, event, sizeof(event)) == sizeof(event);
}

static bool presses(fake_daemon* d, int32_t type, int32_t button)
{
    const int32_t values[6] = {button};
    return sends(d, type, values);
}

/// Waits until the viewer has taken all that was sent: it reads an event after it has taken those
/// before. @return what it took
static space_mouse_motion read_all(test_state* test, fake_daemon* d)
{
    const struct timespec pause = {0, 200000};
    int unread = 1;
    CHECK(presses(d, RELEASE, 0));
    for (int i = 0; i < 100000 && unread > 0; ++i) {
        nanosleep(&pause, NULL);
        CHECK(ioctl(d->client, TIOCOUTQ, &unread) == 0);
    }
    CHECK_EQUAL(0, unread);
    return space_mouse_read(d->mouse);
}

static stp_navigator camera(void)
{
    stp_navigator n;
    stp_boxd box = {{-4, -2, -3}, {4, 2, 3}};
    stp_navigator_init(&n, &box, 640, 400);
    (void)stp_navigator_face(&n, "front", &box, NULL);
    return n;
}

void test_viewer_space_mouse_moves_the_camera(test_state* test)
{
    static const int32_t forward[6] = {0, 0, FULL, 0, 0, 0}, left[6] = {0, 0, 0, 0, FULL / 2, 0};
    static const int32_t rest[6] = {0};
    fake_daemon d;
    if (!begin(test, &d)) {
        return;
    }
    stp_navigator n = camera(), before = n;
    CHECK(sends(&d, MOTION, forward));
    space_mouse_motion motion = read_all(test, &d);
    CHECK(space_mouse_is_connected(d.mouse));
    CHECK(motion.moves && motion.axes.moves[2] == 1.0 && motion.pressed == 0);
    stp_navigator_fly_six(&n, &motion.axes, 0.1);
    CHECK(fabs(before.eye.z - n.eye.z - 0.06 * before.reach) < 1e-9 * before.reach);
    CHECK(n.eye.x == before.eye.x && n.azimuth == before.azimuth);
    motion = space_mouse_read(d.mouse); // the cap is held: no news is the same deflection
    CHECK(motion.moves && motion.axes.moves[2] == 1.0);
    CHECK(sends(&d, MOTION, left));
    motion = read_all(test, &d);
    CHECK(motion.axes.turns[1] == 0.5 && motion.axes.moves[2] == 0.0);
    stp_navigator_fly_six(&n, &motion.axes, 0.1);
    CHECK(n.azimuth > before.azimuth); // to the left
    CHECK(sends(&d, MOTION, rest));
    motion = read_all(test, &d);
    CHECK(!motion.moves);
    end(&d);
}

void test_viewer_space_mouse_sums_the_events_of_a_frame(test_state* test)
{
    static const int32_t some[6] = {FULL, 0, 0, 0, 0, -FULL}, less[6] = {0, FULL, 0, 0, 0, -FULL};
    fake_daemon d;
    if (!begin(test, &d)) {
        return;
    }
    CHECK(sends(&d, MOTION, some) && sends(&d, MOTION, less) && presses(&d, PRESS, 0));
    CHECK(presses(&d, RELEASE, 0) && presses(&d, PRESS, 1) && presses(&d, RELEASE, 1));
    CHECK(presses(&d, PRESS, 40) && presses(&d, PRESS, -1)); // no such buttons
    space_mouse_motion motion = read_all(test, &d);
    CHECK_EQUAL(SPACE_MOUSE_FRAME | SPACE_MOUSE_SWITCH, (int)motion.pressed);
    CHECK(motion.axes.moves[0] == 0.5 && motion.axes.moves[1] == 0.5);
    CHECK(motion.axes.turns[2] == -1.0);
    motion = space_mouse_read(d.mouse);
    CHECK(motion.pressed == 0 && motion.axes.moves[0] == 0.0 && motion.axes.moves[1] == 1.0);
    CHECK(await(&d) && sem_trywait(&d.woken) != 0); // one wake for all that waited
    end(&d);
}

void test_viewer_space_mouse_survives_garbage(test_state* test)
{
    static const int32_t wild[6] = {INT32_MAX, INT32_MIN, INT32_MIN, INT32_MAX, INT32_MIN, 1};
    static const int32_t some[6] = {FULL, 0, 0, 0, 0, 0};
    fake_daemon d;
    if (!begin(test, &d)) {
        return;
    }
    stp_navigator n = camera();
    CHECK(sends(&d, 12345, wild) && sends(&d, -1, wild) && sends(&d, MOTION, wild));
    space_mouse_motion motion = read_all(test, &d);
    CHECK(motion.moves && motion.pressed == 0);
    for (int i = 0; i < 3; ++i) {
        CHECK(fabs(motion.axes.moves[i]) <= 4.0 && fabs(motion.axes.turns[i]) <= 4.0);
    }
    stp_navigator_hold_six(&n, &motion.axes, 0.1);
    CHECK(isfinite(n.eye.x) && isfinite(n.eye.y) && isfinite(n.eye.z) && isfinite(n.azimuth));
    CHECK(sends(&d, DEVICE, some)); // an unplugged device sends no rest
    motion = read_all(test, &d);
    CHECK(!space_mouse_read(d.mouse).moves);
    CHECK(sends(&d, MOTION, some));
    motion = read_all(test, &d);
    CHECK(motion.axes.moves[0] == 1.0);
    CHECK(write(d.client, some, 5) == 5); // an event that ends early
    end(&d);
}

static double processor_seconds(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

void test_viewer_space_mouse_rests_when_its_daemon_ends(test_state* test)
{
    static const int32_t some[6] = {FULL, 0, 0, 0, 0, 0};
    const struct timespec pause = {0, 40000000};
    fake_daemon d;
    if (!begin(test, &d)) {
        return;
    }
    CHECK(sends(&d, MOTION, some));
    CHECK(read_all(test, &d).moves && await(&d));
    hang_up(&d);
    CHECK(await(&d)); // the window is told, so that it stops
    (void)space_mouse_read(d.mouse);
    CHECK(!space_mouse_read(d.mouse).moves && !space_mouse_is_connected(d.mouse));
    double before = processor_seconds();
    nanosleep(&pause, NULL);
    CHECK(processor_seconds() - before < 0.02); // nothing spins
    space_mouse_close(d.mouse);
    sem_destroy(&d.woken);
}

void test_viewer_space_mouse_may_have_no_daemon(test_state* test)
{
    fake_daemon d = {.client = -1};
    if (access("/var/run/spnav.sock", F_OK) == 0 || access("/etc/spnavrc", F_OK) == 0) {
        test->skipped = "there may be a daemon";
        return;
    }
    CHECK(setenv("SPNAV_SOCKET", "/nowhere/socket", 1) == 0);
    sem_init(&d.woken, 0, 0);
    space_mouse* mouse = space_mouse_open(wake, &d);
    CHECK(!space_mouse_read(mouse).moves && !space_mouse_is_connected(mouse));
    space_mouse_close(mouse);
    CHECK(sem_trywait(&d.woken) != 0); // silent
    space_mouse_close(NULL);
    CHECK(!space_mouse_read(NULL).moves && !space_mouse_is_connected(NULL));
    sem_destroy(&d.woken);
}
