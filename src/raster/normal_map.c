// SPDX-License-Identifier: MIT
#include "raster/normal_map.h"

bool stp_tangents_find(const stp_vec3 edges[2], const float uv[2][2], stp_tangents* tangents)
{
    float turn = uv[0][0] * uv[1][1] - uv[1][0] * uv[0][1];
    float sign = turn < 0.0f ? -1.0f : 1.0f;
    tangents->right =
        stp_sub(stp_scale(edges[0], sign * uv[1][1]), stp_scale(edges[1], sign * uv[0][1]));
    tangents->up =
        stp_sub(stp_scale(edges[0], sign * uv[1][0]), stp_scale(edges[1], sign * uv[0][0]));
    float right = stp_dot(tangents->right, tangents->right);
    float up = stp_dot(tangents->up, tangents->up);
    return fabsf(turn) > 0.0f && right > 0.0f && right <= FLT_MAX && up > 0.0f && up <= FLT_MAX;
}

/// Least cosine between a turned normal and the direction to the eye.
#define LEAST_FACING 0.02f

static stp_vec3 keep_side(stp_vec3 turned, stp_vec3 normal, stp_vec3 eye)
{
    float side = stp_dot(normal, eye) < 0.0f ? -1.0f : 1.0f, facing = side * stp_dot(turned, eye);
    return facing < LEAST_FACING
               ? stp_normalize(stp_add(turned, stp_scale(eye, side * (LEAST_FACING - facing))))
               : turned;
}

stp_vec3 stp_normal_map_apply(const stp_tangents* tangents, stp_vec3 normal, const float texel[3],
                              float scale, stp_vec3 eye)
{
    float x = (2.0f * texel[0] - 1.0f) * scale, y = (2.0f * texel[1] - 1.0f) * scale;
    float z = stp_max(2.0f * texel[2] - 1.0f, 0.0f);
    stp_vec3 right = stp_sub(tangents->right, stp_scale(normal, stp_dot(tangents->right, normal)));
    float square = stp_dot(right, right);
    if (!(square > 0.0f)) {
        return normal;
    }
    right = stp_scale(right, 1.0f / sqrtf(square));
    stp_vec3 up = stp_cross(normal, right);
    y = stp_dot(up, tangents->up) < 0.0f ? -y : y; // mirrored coordinates
    stp_vec3 turned = stp_add(stp_add(stp_scale(right, x), stp_scale(up, y)), stp_scale(normal, z));
    square = stp_dot(turned, turned);
    return square > 0.0f && square <= FLT_MAX
               ? keep_side(stp_scale(turned, 1.0f / sqrtf(square)), normal, eye)
               : normal;
}
