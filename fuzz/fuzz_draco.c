// SPDX-License-Identifier: MIT
//
// How to fuzz:
//   cmake --preset fuzz && cmake --build --preset fuzz --target fuzz_draco
//   mkdir -p corpus && cp a few small .drc files into it
//   build/fuzz/fuzz/fuzz_draco -max_len=16384 -rss_limit_mb=4096 -timeout=10 corpus
#include "import/gltf/gltf_draco.h"

#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
    stp_draco_mesh* mesh;
    char reason[80];
    if (stp_draco_decode(bytes, size, &mesh, reason) != STP_DRACO_OK) {
        return 0;
    }
    size_t points = stp_draco_point_count(mesh), faces = stp_draco_face_count(mesh);
    uint32_t* indices = malloc(faces * 3 * sizeof(*indices) + 1);
    if (indices != NULL) {
        stp_draco_indices(mesh, indices);
        for (size_t i = 0; i < faces * 3; ++i) {
            if (indices[i] >= points) {
                abort();
            }
        }
    }
    free(indices);
    for (uint32_t id = 0; id < 8; ++id) {
        size_t components = stp_draco_component_count(mesh, id);
        float* values = components != 0 ? malloc(points * components * sizeof(*values) + 1) : NULL;
        if (values != NULL) {
            stp_draco_values(mesh, id, values);
        }
        free(values);
    }
    stp_draco_destroy(mesh);
    return 0;
}
