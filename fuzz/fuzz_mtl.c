// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_mtl -max_total_time=60 -max_len=4096 build/corpus/fuzz_mtl
// Seeds: /usr/share/assimp/models/OBJ/*.mtl
//
// Arbitrary bytes as a material library: the values of its materials are in range.
#include "fuzz.h"

#include "import/obj/obj.h"

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
            .context = context, .scene = scene, .path = "input.obj", .alone = true};
        stp_lookup names = {.context = context};
        if (stp_mtl_parse(&import, data, size, &names) == STP_OK) {
            for (size_t i = 0; i < scene->material_count; ++i) {
                const stp_material* material = &scene->materials[i];
                float parts[6] = {material->base_color[0], material->base_color[1],
                                  material->base_color[2], material->base_color[3],
                                  material->metallic,      material->roughness};
                for (int k = 0; k < 6; ++k) {
                    if (!(parts[k] >= 0.0f && parts[k] <= 1.0f)) {
                        abort();
                    }
                }
            }
        }
        stp_lookup_destroy(&names);
        stp_scene_destroy(scene);
    }
    stp_context_destroy(context);
    return 0;
}
