// SPDX-License-Identifier: MIT
#include "loader.h"

#include "store/store.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct loader {
    loader_desc desc;
    pthread_t thread;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    bool quits;
    uint32_t wanted, begun; ///< numbers of loads
    char path[PATH_MAX];    ///< of the load that is wanted
    loader_news news;
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

/// Whether the file at `path` lacks surfels that a build would give it.
static bool is_coarse(stp_context* context, const char* path)
{
    stp_store* store = NULL;
    if (stp_store_open_with(context, path, &(stp_store_open_desc){.defer_objects = true}, &store) !=
        STP_OK) {
        return false;
    }
    bool coarse = stp_store_get_directory(store)->surfels_count == 0;
    stp_store_close(store);
    return coarse;
}

static void tell(loader* l, loader_state state, const char* store, bool complete)
{
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

static void load(loader* l, const char* path)
{
    char found[PATH_MAX];
    uint32_t threads = l->desc.thread_count;
    stp_context* context = NULL;
    stp_context_desc desc = {.log = on_log,
                             .log_user = l,
                             .progress = on_progress,
                             .progress_user = l,
                             .thread_count = threads,
                             .memory_limit_bytes = l->desc.memory_limit};
    if (stp_context_create(&context, &desc) != STP_OK) {
        on_log(STP_LOG_ERROR, "there is no memory to load anything", l);
        tell(l, LOADER_FAILED, NULL, false);
        return;
    }
    threads = stp_context_thread_count(context);
    stp_result result = tool_locate_scene(context, path, SCENE_FOR_A_PICTURE, found);
    bool coarse = result == STP_OK && strcmp(found, path) != 0 && is_coarse(context, found);
    stp_context_destroy(context);
    if (result != STP_OK || !coarse) {
        tell(l, result != STP_OK ? LOADER_FAILED : LOADER_DONE, result == STP_OK ? found : NULL,
             true);
        return;
    }
    tell(l, LOADER_REFINING, found, false);
    desc.thread_count = threads > 1 ? threads / 2 : 1; // the others draw
    if (stp_context_create(&context, &desc) != STP_OK) {
        tell(l, LOADER_DONE, NULL, false);
        return;
    }
    result = tool_locate_scene(context, path, SCENE_FOR_SPLATS, found);
    stp_context_destroy(context);
    tell(l, result == STP_OK ? LOADER_DONE : LOADER_FAILED, result == STP_OK ? found : NULL, true);
}

static void* run(void* user)
{
    loader* l = user;
    char path[PATH_MAX];
    pthread_mutex_lock(&l->mutex);
    while (!l->quits) {
        if (l->begun == l->wanted) {
            pthread_cond_wait(&l->changed, &l->mutex);
            continue;
        }
        l->begun = l->wanted;
        copy_text(path, sizeof(path), l->path);
        uint32_t serial = l->news.serial;
        l->news = (loader_news){.state = LOADER_WORKING, .overall = -1.0, .serial = serial};
        copy_text(l->news.file, sizeof(l->news.file), path);
        pthread_mutex_unlock(&l->mutex);
        load(l, path);
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
    pthread_mutex_destroy(&l->mutex);
    pthread_cond_destroy(&l->changed);
    free(l);
}

void loader_start(loader* l, const char* path)
{
    pthread_mutex_lock(&l->mutex);
    l->wanted += 1;
    copy_text(l->path, sizeof(l->path), path);
    copy_text(l->news.file, sizeof(l->news.file), path);
    l->news.state = LOADER_WORKING;
    l->news.stage[0] = 0;
    l->news.message[0] = 0;
    l->news.store[0] = 0;
    l->news.fraction = 0.0;
    l->news.overall = -1.0;
    pthread_cond_signal(&l->changed);
    pthread_mutex_unlock(&l->mutex);
}

void loader_get_news(loader* l, loader_news* news)
{
    pthread_mutex_lock(&l->mutex);
    *news = l->news;
    pthread_mutex_unlock(&l->mutex);
}
