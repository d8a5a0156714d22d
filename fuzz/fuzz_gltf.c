// SPDX-License-Identifier: MIT
//
// How to fuzz:
//   cmake --preset fuzz && cmake --build --preset fuzz --target fuzz_gltf
//   mkdir -p corpus && cp a few small .glb and .gltf files into it
//   build/fuzz/fuzz/fuzz_gltf -max_len=65536 -rss_limit_mb=4096 -timeout=10 corpus
// Seeds: /usr/share/assimp/models/glTF2/*/*.gl* /usr/share/assimp/models/glTF2/*/*/*.gl*
#include "import/reading/import.h"

#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size);

static void count_errors(stp_log_level level, const char* message, void* user)
{
    (void)message;
    int* errors = user;
    *errors += level == STP_LOG_ERROR;
}

// Invariants that the rest of the library relies on.
static void check_scene(const stp_scene* scene)
{
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        const stp_mesh* mesh = &scene->meshes[i];
        for (size_t k = 0; k < (size_t)mesh->triangle_count * 3; ++k) {
            if (mesh->indices[k] >= mesh->vertex_count) {
                abort();
            }
        }
        for (size_t k = 0; k < (size_t)mesh->vertex_count * 3; ++k) {
            if (!isfinite(mesh->positions[k])) {
                abort();
            }
        }
        if (mesh->material >= scene->material_count) {
            abort();
        }
    }
    for (size_t i = 0; i < scene->object_count; ++i) {
        if (scene->objects[i].parent != STP_NONE && scene->objects[i].parent >= i) {
            abort();
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
    int errors = 0;
    stp_context* context;
    stp_scene* scene;
    const stp_import_desc desc = {0};
    const stp_context_desc context_desc = {.thread_count = 1,
                                           .log = count_errors,
                                           .log_user = &errors,
                                           .memory_limit_bytes = (uint64_t)1 << 30};
    if (stp_context_create(&context, &context_desc) != STP_OK) {
        return 0;
    }
    if (stp_scene_create(context, &scene) == STP_OK) {
        stp_result result = stp_import_memory(scene, "fuzz.gltf", bytes, size, &desc);
        if (errors != (result == STP_OK ? 0 : 1)) {
            abort(); // a failure is logged once, a success never
        }
        if (result == STP_OK) {
            check_scene(scene);
        }
        stp_scene_destroy(scene);
    }
    stp_context_destroy(context);
    return 0;
}
