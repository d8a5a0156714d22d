// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_assimp_stream -max_total_time=60 -max_len=4096
//     build/corpus/fuzz_assimp_stream
//
// Arbitrary bytes as the output of the assimp child process: rejected, or a valid scene.
#include "fuzz.h"

#include "import/assimp/assimp_stream.h"
#include "import/import_digest.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    int errors = 0;
    stp_context* context = fuzz_context_create(&errors);
    if (context == NULL) {
        return 0;
    }
    stp_scene* scene;
    if (stp_scene_create(context, &scene) == STP_OK) {
        stp_import import = {
            .context = context, .scene = scene, .path = "input.fbx", .alone = true};
        stp_object root = {.parent = STP_NONE, .transform = stp_affine_identity()};
        if (stp_scene_add_object(scene, &root, &import.root) == STP_OK &&
            stp_assimp_read_stream(&import, data, size) == STP_OK) {
            if (!scene_is_sound(scene) || stp_scene_finish(scene) == STP_ERROR_FORMAT) {
                abort();
            }
        }
        stp_scene_destroy(scene);
    }
    stp_context_destroy(context);
    return 0;
}
