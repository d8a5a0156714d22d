// SPDX-License-Identifier: MIT
//
// Shared by the targets of file formats: an import is rejected with one sentence, or gives a valid
// scene.
#pragma once

#include "fuzz.h"

#include "import/import_digest.h"

static inline void fuzz_import(const char* name, const void* bytes, size_t size)
{
    int errors = 0;
    stp_scene* scene = NULL;
    stp_context* context = fuzz_context_create(&errors);
    if (context == NULL) {
        return;
    }
    if (stp_scene_create(context, &scene) == STP_OK) {
        stp_import_desc desc = {0};
        bool good = stp_import_memory(scene, name, bytes, size, &desc) == STP_OK;
        require(errors == !good);
        require(!good || (scene_is_sound(scene) && stp_scene_finish(scene) != STP_ERROR_FORMAT));
        stp_scene_destroy(scene);
    }
    stp_context_destroy(context);
}
