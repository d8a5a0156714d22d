// SPDX-License-Identifier: MIT
//
// One light, and a sky that is lighter than the ground: enough to read shapes and materials anywhere, with
// nothing to set up. Metals keep half of their diffuse colour, since there is nothing for them to mirror. Most pixels
// are lit by the same arithmetic in vectors (shade_lanes.h).
#include "draw/cpu/cpu.h"

/// Highlight of a rough surface: the distribution of Trowbridge and Reitz, bounded.
static float highlight(float roughness, float cosine)
{
    float a = stp_max(roughness, 0.25f);
    float a2 = a * a * a * a;
    float d = cosine * cosine * (a2 - 1.0f) + 1.0f;
    return stp_min(a2 / (d * d) * (1.0f / (4.0f * a2 + 0.2f)), 2.0f);
}

void cpu_light_surface(const cpu_light* light, stp_vec3 to_eye, const cpu_surface* surface,
                       float out[3])
{
    if (surface->unlit) {
        for (int k = 0; k < 3; ++k) {
            out[k] = surface->color[k] + surface->emissive[k];
        }
        return;
    }
    stp_vec3 n = surface->normal;
    float facing = stp_dot(n, to_eye);
    if (facing < 0.0f) { // whatever is seen has its front towards the eye
        n = stp_scale(n, -1.0f);
        facing = -facing;
    }
    float lambert = stp_max(stp_dot(n, light->toward), 0.0f);
    float height = 0.5f + 0.5f * stp_dot(n, light->up);
    float diffuse = CPU_LIGHT_GROUND + (CPU_LIGHT_SKY - CPU_LIGHT_GROUND) * height +
                    CPU_LIGHT_KEY * lambert + CPU_LIGHT_FILL * facing;
    stp_vec3 half = stp_add(light->toward, to_eye);
    float length = stp_length(half);
    float cosine = length > 0.0f ? stp_max(stp_dot(n, half) / length, 0.0f) : 0.0f;
    float gloss = lambert * highlight(surface->roughness, cosine);
    float kept = 1.0f - 0.5f * surface->metallic;
    for (int k = 0; k < 3; ++k) {
        float mirror = 0.04f + (surface->color[k] - 0.04f) * surface->metallic;
        out[k] = surface->color[k] * kept * diffuse +
                 mirror * (gloss + 0.5f * surface->metallic * diffuse) + surface->emissive[k];
    }
}
