// SPDX-License-Identifier: MIT
#include "program/viewer/model/loader.h"

#include "program/viewer/model/path_list.h"

#include <assert.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

struct loader {
    loader_desc desc;
    pthread_t thread;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    bool quits;
    uint32_t wanted, begun; ///< numbers of the requested and of the current load
    path_list inputs;       ///< files of the requested load
    char up;                ///< scene_input
    double unit_metres;
    loader_news news;
    char draft[PATH_MAX]; ///< path of the last build's drafts; empty: none
};

static void copy_text(char* out, size_t size, const char* text)
{
    snprintf(out, size, "%s", text != NULL ? text : "");
}

static int on_progress(const stp_progress_report* report, void* user)
{
    loader* l = user;
    pthread_mutex_lock(&l->mutex);
    bool stops = l->quits || l->wanted != l->begun;
    double before = l->news.fraction;
    bool other = strcmp(l->news.stage, report->stage) != 0;
    copy_text(l->news.stage, sizeof(l->news.stage), report->stage);
    copy_text(l->news.unit, sizeof(l->news.unit), report->unit);
    l->news.fraction = report->fraction;
    l->news.overall = report->overall;
    l->news.done = report->done;
    l->news.total = report->total;
    pthread_mutex_unlock(&l->mutex);
    if (other || report->fraction - before > 0.005) {
        l->desc.wake(l->desc.user);
    }
    return stops;
}

static void on_log(stp_log_level level, const char* message, void* user)
{
    loader* l = user;
    if (level != STP_LOG_NOTICE) {
        pthread_mutex_lock(&l->mutex);
        copy_text(l->news.message, sizeof(l->news.message), message);
        pthread_mutex_unlock(&l->mutex);
    }
}

static void set_state(loader* l, loader_state state, const char* store, bool complete)
{
    assert((state == LOADER_REFINING) == (store != NULL && !complete) && "a draft is refined");
    pthread_mutex_lock(&l->mutex);
    if (l->wanted == l->begun) {
        l->news.state = state;
        if (store != NULL) {
            copy_text(l->news.store, sizeof(l->news.store), store);
            l->news.complete = complete;
            l->news.serial += 1;
        }
    }
    pthread_mutex_unlock(&l->mutex);
    l->desc.wake(l->desc.user);
}

static void on_grown(const char* store, void* user)
{
    set_state(user, LOADER_REFINING, store, false);
}

void loader_drop_drafts(loader* l)
{
    pthread_mutex_lock(&l->mutex);
    if (l->draft[0] != 0) {
        (void)unlink(l->draft);
        l->draft[0] = 0;
    }
    pthread_mutex_unlock(&l->mutex);
}

/// Waits until another process may have finished the build. @return false if it is no longer wanted
static bool wait_for_another(loader* l)
{
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_sec += 1;
    pthread_mutex_lock(&l->mutex);
    copy_text(l->news.stage, sizeof(l->news.stage), "waiting for another window");
    l->news.message[0] = 0;
    int waited = 0;
    while (!l->quits && l->wanted == l->begun && waited == 0) {
        waited = pthread_cond_timedwait(&l->changed, &l->mutex, &until);
    }
    bool goes_on = !l->quits && l->wanted == l->begun;
    pthread_mutex_unlock(&l->mutex);
    l->desc.wake(l->desc.user);
    return goes_on;
}

static void load(loader* l, const scene_input* input)
{
    char found[PATH_MAX], draft[PATH_MAX];
    stp_context* context = NULL;
    stp_context_desc desc = {.log = on_log,
                             .log_user = l,
                             .progress = on_progress,
                             .progress_user = l,
                             .thread_count = l->desc.thread_count,
                             .memory_limit_bytes = l->desc.memory_limit};
    loader_drop_drafts(l);
    if (stp_context_create(&context, &desc) != STP_OK) {
        on_log(STP_LOG_ERROR, "not enough memory to load the file", l);
        set_state(l, LOADER_FAILED, NULL, false);
        return;
    }
    scene_watcher watcher = {.grown = on_grown, .user = l};
    stp_result result;
    do {
        result = tool_locate_watched(context, input, l->desc.use, &watcher, found, draft);
    } while (result == STP_ERROR_BUSY && wait_for_another(l));
    stp_context_destroy(context);
    pthread_mutex_lock(&l->mutex);
    copy_text(l->draft, sizeof(l->draft), draft);
    pthread_mutex_unlock(&l->mutex);
    set_state(l, result == STP_OK ? LOADER_DONE : LOADER_FAILED, result == STP_OK ? found : NULL,
              true);
}

/// Lowers the priority of building below that of drawing. On Linux this affects the calling thread
/// and the threads that it starts.
static void yield_to_drawing(void)
{
    enum { LESS = 10 };
    (void)setpriority(PRIO_PROCESS, 0, LESS);
}

static void* run(void* user)
{
    loader* l = user;
    yield_to_drawing();
    pthread_mutex_lock(&l->mutex);
    while (!l->quits) {
        if (l->begun == l->wanted) {
            pthread_cond_wait(&l->changed, &l->mutex);
            continue;
        }
        l->begun = l->wanted;
        path_list inputs = l->inputs; // another request brings its own
        l->inputs = (path_list){0};
        scene_input input = {(const char* const*)inputs.paths, inputs.count, l->up, l->unit_metres};
        uint32_t serial = l->news.serial;
        l->news = (loader_news){.state = LOADER_WORKING, .overall = -1.0, .serial = serial};
        copy_text(l->news.file, sizeof(l->news.file), inputs.paths[0]);
        pthread_mutex_unlock(&l->mutex);
        load(l, &input);
        path_list_destroy(&inputs);
        pthread_mutex_lock(&l->mutex);
    }
    pthread_mutex_unlock(&l->mutex);
    return NULL;
}

loader* loader_create(const loader_desc* desc)
{
    loader* l = calloc(1, sizeof(*l));
    if (l == NULL) {
        return NULL;
    }
    l->desc = *desc;
    pthread_mutex_init(&l->mutex, NULL);
    pthread_cond_init(&l->changed, NULL);
    if (pthread_create(&l->thread, NULL, run, l) != 0) {
        pthread_mutex_destroy(&l->mutex);
        pthread_cond_destroy(&l->changed);
        free(l);
        return NULL;
    }
    return l;
}

void loader_destroy(loader* l)
{
    if (l == NULL) {
        return;
    }
    pthread_mutex_lock(&l->mutex);
    l->quits = true;
    pthread_cond_signal(&l->changed);
    pthread_mutex_unlock(&l->mutex);
    pthread_join(l->thread, NULL);
    loader_drop_drafts(l);
    path_list_destroy(&l->inputs);
    pthread_mutex_destroy(&l->mutex);
    pthread_cond_destroy(&l->changed);
    free(l);
}

bool loader_start(loader* l, const scene_input* input)
{
    path_list inputs = {0};
    for (size_t i = 0; i < input->count; ++i) {
        if (!path_list_add(&inputs, input->paths[i])) {
            path_list_destroy(&inputs);
            return false;
        }
    }
    pthread_mutex_lock(&l->mutex);
    l->wanted += 1;
    path_list_destroy(&l->inputs);
    l->inputs = inputs;
    l->up = input->up;
    l->unit_metres = input->unit_metres;
    copy_text(l->news.file, sizeof(l->news.file), input->paths[0]);
    l->news.state = LOADER_WORKING;
    l->news.stage[0] = 0;
    l->news.message[0] = 0;
    l->news.store[0] = 0;
    l->news.fraction = 0.0;
    l->news.overall = -1.0;
    pthread_cond_signal(&l->changed);
    pthread_mutex_unlock(&l->mutex);
    return true;
}

void loader_get_news(loader* l, loader_news* news)
{
    pthread_mutex_lock(&l->mutex);
    *news = l->news;
    pthread_mutex_unlock(&l->mutex);
}
