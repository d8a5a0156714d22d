// Bytes (0..1) to linear light and back.
#include "interface.h"

float to_linear(float srgb)
{
    return srgb <= 0.04045 ? srgb / 12.92 : pow((srgb + 0.055) / 1.055, 2.4);
}

vec3 to_linear(vec3 srgb)
{
    return vec3(to_linear(srgb.x), to_linear(srgb.y), to_linear(srgb.z));
}

// Encodes linear light as an sRGB byte (0..1).
float encode(float linear)
{
    float whole = (floor(clamp(linear, 0.0, 1.0 - 0.5 / float(SRGB_STEPS)) * float(SRGB_STEPS)) + 0.5) / float(SRGB_STEPS);
    return whole <= 0.0031308 ? 12.92 * whole : 1.055 * pow(whole, 1.0 / 2.4) - 0.055;
}

vec3 encode(vec3 linear)
{
    return vec3(encode(linear.x), encode(linear.y), encode(linear.z));
}
