// SPDX-License-Identifier: MIT
// Shared by the tests of formats: importing text, a digest of a scene, files in a scratch folder.
#pragma once

#include "import_digest.h"
#include "tests.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

/// Imports bytes under a name. @return the scene, or NULL with the result in *result
static inline stp_scene* import_bytes(stp_context* context, const char* name, const void* bytes,
                                      size_t size, stp_result* result)
{
    stp_scene* scene = NULL;
    *result = stp_scene_create(context, &scene);
    if (*result == STP_OK) {
        *result = stp_import_memory(scene, name, bytes, size, &(stp_import_desc){0});
        if (*result == STP_OK) {
            return scene;
        }
        stp_scene_destroy(scene);
    }
    return NULL;
}

/// Tests every truncation of the bytes: gives a valid scene, or an error with exactly one message.
static inline int survives_truncation(const char* name, const void* bytes, size_t size)
{
    for (size_t cut = 0; cut < size; ++cut) {
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_result result;
        stp_scene* scene = import_bytes(context, name, bytes, cut, &result);
        int good = scene != NULL ? scene_is_sound(scene) && log.errors == 0 : log.errors == 1;
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        if (!good) {
            fprintf(stderr, "%s: cut to %zu bytes: result %d, %d errors, last \"%s\"\n", name, cut,
                    result, log.errors, log.text);
            return 0;
        }
    }
    return 1;
}

/// Fails the n-th allocation, for every n until an import succeeds: no leak, no crash, one
/// sentence.
static inline int survives_failing_allocator(const char* name, const void* bytes, size_t size)
{
    for (int n = 0; n < 100000; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        if (context == NULL) {
            continue;
        }
        stp_result result;
        stp_scene* scene = import_bytes(context, name, bytes, size, &result);
        int done = scene != NULL;
        int good = done ? log.errors == 0 : result == STP_ERROR_OUT_OF_MEMORY && log.errors == 1;
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        if (!good || heap.live_bytes != 0) {
            fprintf(stderr, "%s: allocation %d: result %d, %d errors, %zu bytes left\n", name, n,
                    result, log.errors, heap.live_bytes);
            return 0;
        }
        if (done) {
            return n > 0;
        }
    }
    return 0;
}

/// Writes a file into the folder for temporary files; `path` receives its path. Its name has the
/// process id, so that processes do not meet. @return whether all was written
static inline int write_scratch(char path[256], const char* name, const void* bytes, size_t size)
{
    const char* folder = getenv("TMPDIR");
    snprintf(path, 256, "%s/stp-test-%ld-%s", folder != NULL ? folder : "/tmp", (long)getpid(),
             name);
    FILE* file = fopen(path, "wb");
    if (file == NULL) {
        return 0;
    }
    size_t written = fwrite(bytes, 1, size, file);
    return fclose(file) == 0 && written == size;
}
