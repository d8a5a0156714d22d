// A pixel of a large disk: intersects its ray with the plane.
#include "lib_holes.glsl"
#include "lib_item.glsl"
#include "lib_layer.glsl"

layout(location = 0) out uint id;

flat in vec4 middle;
flat in vec4 normal;
flat in vec4 depths;
flat in vec4 screen;
flat in vec3 across;
flat in vec2 range;
flat in vec4 smaller;
flat in uvec3 hashed;

// Squared length of an offset, in the ellipse's metric.
float squared(vec3 from)
{
    float along = dot(smaller.xyz, from);
    return dot(from, from) + smaller.w * (along * along);
}

bool is_kept(vec3 from)
{
    float at = dot(across, from);
    return at >= range.x && at <= range.y;
}

bool meet_parallel(out float nearness, out ivec2 center)
{
    vec2 at = gl_FragCoord.xy - middle.xy;
    float z = -dot(normal.xy, at) / normal.z, limit = middle.w * middle.w;
    float square = squared(vec3(at, z));
    center = ivec2(floor(middle.xy));
    nearness = depths.x + depths.y * (z + depths.z + depths.w * (square / limit));
    return square <= limit && is_kept(vec3(at, z));
}

bool meet_perspective(out float nearness, out ivec2 center)
{
    vec3 ray = vec3((gl_FragCoord.xy - screen.xy) * screen.z, 1.0);
    float t = dot(normal.xyz, middle.xyz) / dot(normal.xyz, ray), limit = middle.w * middle.w;
    vec3 from = t * ray - middle.xyz;
    float square = squared(from);
    center = middle.z > 0.0 ? ivec2(floor(screen.xy + middle.xy / (middle.z * screen.z))) : ivec2(-1);
    nearness = depths.x / (t + depths.z + depths.w * (square / limit));
    return t > 0.0 && square <= limit && is_kept(from);
}

void main()
{
    float nearness;
    ivec2 center;
    bool met = view.parallel != 0u ? meet_parallel(nearness, center) : meet_perspective(nearness, center);
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    if (!met || !(nearness > 0.0) || nearness > screen.w) {
        discard;
    }
    if (!is_drawn(hashed, pixel, pixel - center)) {
        discard;
    }
#ifdef LAYER
    if (!is_splat_between(pixel, nearness, hashed.x)) {
        discard;
    }
#endif
    gl_FragDepth = nearness;
    id = hashed.x;
}
