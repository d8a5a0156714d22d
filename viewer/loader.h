// SPDX-License-Identifier: MIT
//
// Finds or builds what a file looks like, on a thread of its own: the viewer never waits.
//
// A model grows while it is built: drafts of what is there already (build/draft.h) come one after another, each at the same
// path and with another serial, and the finished scene after them. What another process builds already is waited for.
#pragma once

#include "scene_file.h"

#include "base/context.h"

#include <limits.h>

typedef struct loader loader;

typedef enum loader_state {
    LOADER_IDLE,     ///< nothing was asked for
    LOADER_WORKING,  ///< before anything can be seen
    LOADER_REFINING, ///< what can be seen already is made better
    LOADER_DONE,
    LOADER_FAILED,
} loader_state;

/// How far loading is. Text is for people.
typedef struct loader_news {
    loader_state state;
    char file[PATH_MAX]; ///< what was asked for
    char stage[64];
    double fraction, overall; ///< of the stage; of the whole, negative: not known
    uint64_t done, total;
    char unit[32];
    char message[512];    ///< why it failed; else the last warning
    char store[PATH_MAX]; ///< the .stip to be shown; empty: none yet
    bool complete;        ///< nothing better comes after it
    uint32_t serial;      ///< of `store`: another one, another number
} loader_news;

typedef struct loader_desc {
    uint32_t thread_count;
    uint64_t memory_limit;
    scene_use use;            ///< SCENE_FOR_METHODS or SCENE_FOR_SPLATS
    void (*wake)(void* user); ///< called from the thread where there is news
    void* user;
} loader_desc;

/// @return NULL where there is no thread or memory
loader* loader_create(const loader_desc* desc);
/// Stops what is being done, and waits for that.
void loader_destroy(loader* l);
/// Begins with a file; what was begun before is stopped.
void loader_start(loader* l, const char* path);
void loader_get_news(loader* l, loader_news* news);
/// The finished scene is shown: its drafts are not looked at any more.
void loader_drop_drafts(loader* l);
