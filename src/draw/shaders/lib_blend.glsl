// Selection and weights of splats blended in a pixel: src/raster/splats_blend.c. Planes are
// nearness at the pixel, and its slopes to the right and down in pixel sides.
#include "interface.h"

// Maximum distance of a splat's plane from the pixel's, in radii, and cosine of the maximum angle
// between them.
#define BLEND_AWAY 1.5
#define BLEND_ALIKE 0.4
#define BLEND_WEIGHT 64.0 // at the centre of a disk; 1 at its rim
// relative distance from the centre at which a one-pixel splat is evaluated
#define BLEND_TINY 0.7

// Kinds of pixels.
#define PLANE_NONE 0.0
#define PLANE_TINY 1.0 // a splat too small for slopes
#define PLANE_DISK 2.0

// Nearness difference of a depth difference of one pixel side.
float find_side(vec2 slope, float nearness)
{
    return abs(nearness * slope.x + slope.y);
}

// Normal, of any length, of a plane with these slopes on the ray (x, y, 1).
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

// `inside`: 1 at the centre of the disk, 0 at its rim.
float blend_weight(float inside)
{
    float inner = max(inside, 0.0); // squared: approximates exp(-2 q), and is 0 at the rim
    return 1.0 + floor((BLEND_WEIGHT - 1.0) * inner * inner);
}
