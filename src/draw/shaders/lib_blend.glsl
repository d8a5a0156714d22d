// Which splats are blended in a pixel, and how much each counts: src/raster/splats_blend.c. Planes are nearness at the
// pixel, and its change to the right and down in sides of a pixel.
#include "interface.h"

// How far from a pixel's plane a splat's may lie there, in radii, and the cosine of how far it may be turned.
#define BLEND_AWAY 1.5
#define BLEND_ALIKE 0.4
#define BLEND_WEIGHT 64.0 // in the middle of a disk; at its rim 1
#define BLEND_TINY 0.7    // of how far to the middle a splat of one pixel counts

// Kinds of pixels.
#define PLANE_NONE 0.0
#define PLANE_TINY 1.0 // a splat too small to have slopes
#define PLANE_DISK 2.0

// The step of nearness that is a pixel's side of depth.
float find_side(vec2 slope, float nearness)
{
    return abs(nearness * slope.x + slope.y);
}

// The normal of a plane with these slopes that is met by a ray (x, y, 1), of any length.
vec3 slope_normal(vec2 slopes, vec2 ray)
{
    return vec3(slopes, 1.0 - dot(slopes, ray));
}

bool is_turned(vec3 a, vec3 b)
{
    float both = dot(a, b);
    return both < 0.0 || both * both < BLEND_ALIKE * BLEND_ALIKE * dot(a, a) * dot(b, b);
}

float weight_of_opacity(float opacity)
{
    return 1.0 + floor((BLEND_WEIGHT - 1.0) * opacity);
}

// `inside`: 1 in the middle of the disk, 0 at its rim.
float blend_weight(float inside)
{
    float inner = max(inside, 0.0); // squared: nearly exp(-2 q), and 0 at the rim
    return 1.0 + floor((BLEND_WEIGHT - 1.0) * inner * inner);
}
