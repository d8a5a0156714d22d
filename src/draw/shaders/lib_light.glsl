// Lighting, the same as in src/draw/cpu/shade_lanes.h.
#include "light_constants.h"
#include "lib_item.glsl"
#include "lib_srgb.glsl"

struct surface_light {
    vec4 surface;  // metallic, rough, a^2, gloss
    vec4 emissive; // and whether it is unlit
};

surface_light make_light(float metallic, float roughness, vec4 emissive)
{
    float a = max(roughness, 0.25), a2 = a * a * a * a;
    return surface_light(vec4(metallic, (a - 0.25) * (1.0 / 0.75), a2, 1.0 / (4.0 * a2 + 0.2)), emissive);
}

vec3 unit(vec3 v)
{
    float square = dot(v, v);
    return square > 0.0 ? v * inversesqrt(square) : vec3(0.0);
}

vec3 smooth_step(vec3 x)
{
    x = clamp(x, 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

// Environment reflected in a direction.
vec3 mirror_light(vec3 r, float rough)
{
    const vec3 horizon = vec3(MIRROR_HORIZON_R, MIRROR_HORIZON_G, MIRROR_HORIZON_B);
    const vec3 ground = vec3(MIRROR_GROUND_R, MIRROR_GROUND_G, MIRROR_GROUND_B);
    float sharp = 1.0 / (MIRROR_BLUR + MIRROR_BLUR_ROUGH * rough), height = dot(r, view.up.xyz);
    vec3 along = vec3(height, dot(r, view.left_box.xyz) - MIRROR_LEFT_EDGE,
                      dot(r, view.right_box.xyz) - MIRROR_RIGHT_EDGE);
    vec3 there = smooth_step(along * sharp + 0.5);
    float fade = 1.0 - (1.0 - MIRROR_ZENITH) * max(height, 0.0);
    float boxes = (MIRROR_BOX_LEFT * there.y + MIRROR_BOX_RIGHT * there.z) * (1.0 - MIRROR_ROUGH_BOX * rough);
    return mix(ground, horizon * fade, there.x) + boxes;
}

// Diffuse light of normals about n: the mean of them has this length.
vec3 diffuse_light(vec3 n, vec3 eye, float facing, float size, float variance)
{
    const vec3 sky = vec3(LIGHT_SKY_R, LIGHT_SKY_G, LIGHT_SKY_B);
    const vec3 ground = vec3(LIGHT_GROUND_R, LIGHT_GROUND_G, LIGHT_GROUND_B);
    const vec3 key = vec3(LIGHT_KEY_R, LIGHT_KEY_G, LIGHT_KEY_B);
    vec3 mean = size * n + (1.0 - size) * SPREAD_TO_EYE * eye;
    float toward = dot(mean, view.light.xyz);
    float lambert = 0.5 * (toward + sqrt(toward * toward + SPREAD_LAMBERT * variance));
    float height = 0.5 + 0.5 * dot(mean, view.up.xyz);
    float fill = LIGHT_FILL * (facing * facing * size * size + SPREAD_FILL * variance);
    return ground + (sky - ground) * height + key * lambert + fill;
}

// `apart`: 1 less the length of the mean of the normals about this one.
vec3 light_surface(vec3 color, vec3 normal, float apart, vec3 eye, surface_light m)
{
    float size = 1.0 - apart, variance = 1.0 - size * size;
    float metallic = m.surface.x, rough = m.surface.y;
    vec3 n = unit(normal);
    float facing = dot(n, eye);
    n = facing < 0.0 ? -n : n;
    facing = abs(facing);
    vec3 mirrored = mirror_light(2.0 * facing * n - eye, min(rough + variance, 1.0));
    float toward = dot(n, view.light.xyz);
    float square = 2.0 + 2.0 * dot(eye, view.light.xyz), along = max(toward + facing, 0.0);
    float squared = square > 0.0 ? along * along / square : 0.0;
    float a2 = min(m.surface.z + SPREAD_GLOSS * variance, 1.0), d = squared * (a2 - 1.0) + 1.0;
    float widest = variance > 0.0 ? 1.0 / (4.0 * a2 + 0.2) : m.surface.w;
    float gloss = max(toward, 0.0) * min(a2 / (d * d) * widest, LIGHT_GLOSS_MAX) * (1.0 - rough);
    float aside = 1.0 - facing, polish = 1.0 - rough;
    vec3 diffuse = diffuse_light(n, eye, facing, size, variance);
    vec3 front = LIGHT_DIELECTRIC + (color - LIGHT_DIELECTRIC) * metallic;
    float aside2 = aside * aside;
    vec3 mirror = front + (1.0 - front) * (aside2 * aside2 * aside * polish * polish * LIGHT_GRAZING);
    vec3 seen = mirrored + (diffuse - mirrored) * rough;
    vec3 lit = color * (1.0 - metallic) * diffuse + mirror * seen + front * gloss + m.emissive.xyz;
    return m.emissive.w > 0.0 ? color + m.emissive.xyz : lit;
}
