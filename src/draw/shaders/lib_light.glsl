// Light, as src/draw/cpu/shade_lanes.h.
#include "lib_srgb.glsl"

struct surface_light {
    vec4 surface;  // metallic, share of diffuse light kept, a^2, gloss
    vec4 emissive; // and whether it is unlit
};

surface_light make_light(float metallic, float roughness, vec4 emissive)
{
    float a = max(roughness, 0.25), a2 = a * a * a * a;
    return surface_light(vec4(metallic, 1.0 - 0.5 * metallic, a2, 1.0 / (4.0 * a2 + 0.2)), emissive);
}

vec3 unit(vec3 v)
{
    float square = dot(v, v);
    return square > 0.0 ? v * inversesqrt(square) : vec3(0.0);
}

vec3 light_surface(vec3 color, vec3 normal, vec3 eye, vec3 toward_light, vec3 up, surface_light m)
{
    vec3 n = unit(normal);
    float facing = dot(n, eye);
    n = facing < 0.0 ? -n : n;
    facing = abs(facing);
    float toward = dot(n, toward_light), lambert = max(toward, 0.0);
    float height = 0.5 + 0.5 * dot(n, up);
    float diffuse = 0.12 + (0.28 - 0.12) * height + 0.62 * lambert + 0.08 * facing;
    float square = 2.0 + 2.0 * dot(eye, toward_light), along = max(toward + facing, 0.0);
    float squared = square > 0.0 ? along * along / square : 0.0;
    float d = squared * (m.surface.z - 1.0) + 1.0;
    float gloss = lambert * min(m.surface.z / (d * d) * m.surface.w, 2.0);
    vec3 mirror = 0.04 + (color - 0.04) * m.surface.x;
    vec3 lit = color * m.surface.y * diffuse + mirror * (gloss + 0.5 * m.surface.x * diffuse) + m.emissive.xyz;
    return m.emissive.w > 0.0 ? color + m.emissive.xyz : lit;
}
