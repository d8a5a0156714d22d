// SPDX-License-Identifier: MIT
// A mesh decoded by libdraco, behind a C interface: no exception leaves it.
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct stp_draco_mesh stp_draco_mesh;

typedef enum stp_draco_result {
    STP_DRACO_OK,
    STP_DRACO_DAMAGED,
    STP_DRACO_OUT_OF_MEMORY,
} stp_draco_result;

/// Decodes. For damaged data, `reason` receives up to 80 bytes of libdraco's message.
stp_draco_result stp_draco_decode(const void* bytes, size_t size, stp_draco_mesh** mesh,
                                  char reason[80]);
void stp_draco_destroy(stp_draco_mesh* mesh);

uint32_t stp_draco_point_count(const stp_draco_mesh* mesh);
uint32_t stp_draco_face_count(const stp_draco_mesh* mesh);
/// Three a face; each below the point count.
void stp_draco_indices(const stp_draco_mesh* mesh, uint32_t* out);
/// Components of the attribute with that id; 0 if it does not exist.
uint32_t stp_draco_component_count(const stp_draco_mesh* mesh, uint32_t id);
/// Values of all points as stored; integers are not normalised.
void stp_draco_values(const stp_draco_mesh* mesh, uint32_t id, float* out);

#ifdef __cplusplus
}
#endif
