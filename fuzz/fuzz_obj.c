// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_obj -max_total_time=60 -max_len=4096 build/corpus/fuzz_obj
// Seeds: /usr/share/assimp/models/OBJ/*.obj
//
// Arbitrary bytes as an OBJ file. Split into chunks of any size, it must give the same scene, or
// fail the same way.
#include "import/import_digest.h"
#include "import/obj/obj.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

static stp_result read_scene(stp_context* context, const uint8_t* data, size_t size,
                             size_t chunk_size, stp_hash* digest)
{
    stp_scene* scene;
    stp_result result = stp_scene_create(context, &scene);
    if (result != STP_OK) {
        return result;
    }
    stp_import import = {.context = context,
                         .scene = scene,
                         .path = "input.obj",
                         .file = {data, size},
                         .alone = true};
    stp_object root = {.parent = STP_NONE, .transform = stp_affine_identity()};
    result = stp_scene_add_object(scene, &root, &import.root);
    if (result == STP_OK) {
        result = stp_obj_read(&import, chunk_size);
    }
    if (result == STP_OK && !scene_is_sound(scene)) {
        abort();
    }
    *digest = result == STP_OK ? digest_scene(scene) : (stp_hash){0};
    if (result == STP_OK) {
        result = stp_scene_finish(scene);
    }
    stp_scene_destroy(scene);
    return result;
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    stp_context_desc desc = {.thread_count = 1, .memory_limit_bytes = (uint64_t)1 << 28};
    stp_context* context;
    if (size == 0 || stp_context_create(&context, &desc) != STP_OK) {
        return 0;
    }
    stp_hash whole, cut;
    stp_result result = read_scene(context, data + 1, size - 1, (size_t)1 << 20, &whole);
    if (result != read_scene(context, data + 1, size - 1, (size_t)data[0] + 1, &cut) ||
        !stp_hash_equal(whole, cut)) {
        abort();
    }
    stp_context_destroy(context);
    return 0;
}
