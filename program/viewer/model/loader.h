// SPDX-License-Identifier: MIT
//
// Finds or builds the .stip of a file on a separate thread, so that the viewer never waits.
//
// A model can be seen while it is built: drafts (builder/draft.h) appear one after another at the
// same path with increasing serials, then the finished scene. If another process builds the same
// model, the loader waits for it.
#pragma once

#include "base/core/context.h"
#include "program/files/scene_file.h"

#include <limits.h>

typedef struct loader loader;

typedef enum loader_state {
    LOADER_IDLE,     ///< no request
    LOADER_WORKING,  ///< nothing can be shown yet
    LOADER_REFINING, ///< a draft is shown, a better one is in progress
    LOADER_DONE,
    LOADER_FAILED,
} loader_state;

/// Loading progress. Texts are for people.
typedef struct loader_news {
    loader_state state;
    char file[PATH_MAX]; ///< the requested file, or the first one
    char stage[64];
    double fraction, overall; ///< progress of the stage; of the whole, negative if unknown
    uint64_t done, total;
    char unit[32];
    char message[512];    ///< the error if it failed; else the last warning
    char store[PATH_MAX]; ///< the .stip to show; empty: none yet
    bool complete;        ///< no better version follows
    uint32_t serial;      ///< changes with each version of `store`
} loader_news;

typedef struct loader_desc {
    uint32_t thread_count;
    uint64_t memory_limit;
    scene_use use;            ///< SCENE_FOR_METHODS or SCENE_FOR_SPLATS
    void (*wake)(void* user); ///< called on any thread of the build when there is news
    void* user;
} loader_desc;

/// @return NULL if a thread or memory is not available
loader* loader_create(const loader_desc* desc);
/// Cancels the current work and waits for the thread to end.
void loader_destroy(loader* l);
/// Starts loading files, of which it keeps copies of the paths; cancels the previous load. @return
/// false if memory runs out: the previous load goes on
bool loader_start(loader* l, const scene_input* input);
void loader_get_news(loader* l, loader_news* news);
/// Releases the drafts: the finished scene is shown.
void loader_drop_drafts(loader* l);
