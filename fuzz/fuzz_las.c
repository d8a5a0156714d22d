// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_las -max_total_time=60 -max_len=4096 build/corpus/fuzz_las
// Seeds: build/corpus/las/*
//
// STP_LAS_SEEDS=build/corpus/las stp_tests las_writes_seeds makes the seeds.
// Any bytes as LAS: refused, or a sound scene.
#include "../tests/import/import_digest.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    stp_context_desc desc = {.thread_count = 1, .memory_limit_bytes = (uint64_t)1 << 28};
    stp_context* context;
    if (stp_context_create(&context, &desc) != STP_OK) {
        return 0;
    }
    stp_scene* scene;
    if (stp_scene_create(context, &scene) == STP_OK) {
        stp_import_desc import = {0};
        if (stp_import_memory(scene, "input.laz", data, size, &import) == STP_OK) {
            if (!scene_is_sound(scene) || stp_scene_finish(scene) == STP_ERROR_FORMAT) {
                abort();
            }
        }
        stp_scene_destroy(scene);
    }
    stp_context_destroy(context);
    return 0;
}
