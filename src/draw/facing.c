// SPDX-License-Identifier: MIT
#include "draw/facing.h"

#include "store/file/store.h"

#include <string.h>

bool stp_find_item_eye(const stp_view_frame* frame, const stp_affine* transform,
                       const float offset[3], float eye[3])
{
    double normal[3][3], size = fabs(stp_affine_determinant(transform));
    stp_vec3d middle = {(double)offset[0], (double)offset[1], (double)offset[2]};
    stp_vec3d sight = frame->parallel ? stp_scaled(frame->forward, -1.0)
                                      : stp_subd(frame->eye, stp_affine_point(transform, middle));
    if (!(size > 0.0)) {
        return false;
    }
    stp_affine_normal_matrix(transform, normal); // transposed, over the size: the inverse
    for (int c = 0; c < 3; ++c) {
        eye[c] =
            (float)((normal[0][c] * sight.x + normal[1][c] * sight.y + normal[2][c] * sight.z) /
                    size);
    }
    return true;
}

stp_front_only stp_front_only_of_shadings(const stp_store_directory* directory,
                                          uint8_t front_only[256])
{
    uint32_t used = 0, count = 0;
    memset(front_only, 0, 256);
    for (uint32_t i = 0; i < directory->shading_count && i < 256; ++i) {
        front_only[i] = (directory->shadings[i].flags & STP_SHADING_FRONT_ONLY) != 0;
        used += 1;
        count += front_only[i];
    }
    return count == 0      ? STP_FRONT_ONLY_NONE
           : count == used ? STP_FRONT_ONLY_ALL
                           : STP_FRONT_ONLY_SOME;
}
