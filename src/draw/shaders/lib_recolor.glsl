// Colours of heights and normals: src/draw/shading_setup.h. The colour scale is stored after the lighting
// materials.

// Index of a pixel's colour in the scale.
uint height_place(vec2 at, float nearness)
{
    float depth = view.parallel != 0u ? (nearness - view.nearness_offset) / view.nearness_scale
                                      : view.nearness_scale / nearness;
    float part = (view.height_place.x + view.height_place.y * at.x + view.height_place.z * at.y) +
                 depth * (view.height_along.x + view.height_along.y * at.x + view.height_along.z * at.y);
    return uint(clamp(part, 0.0, 1.0) * 255.0 + 0.5);
}

// Moves a pixel and its depth to the centre of its splat, whose rim lies behind its plane.
void move_to_center(const item_block item, uint id, inout vec2 at, inout float depth)
{
    if (view.recolors != RECOLORS_HEIGHT || item.kind != KIND_SPLATS) {
        return;
    }
    uint index = id - item.first_id;
    chunk_block chunk = find_chunk(item, index);
    uint place = chunk.address + 2u * (index - chunk.begin), low = fetch(place), high = fetch(place + 1u);
    vec4 p = vec4(float(low & 0xFFFFu), float(low >> 16), float(high & 0xFFFFu), 1.0);
    float w = dot(item.rows[3], p);
    at = vec2(dot(item.rows[0], p), dot(item.rows[1], p)) / w;
    depth = item.near_factor * (dot(item.rows[2], p) / w) + item.near_shift;
}

void recolor(inout surface s, vec2 at, float nearness)
{
    if (view.recolors == RECOLORS_HEIGHT) {
        s.color = light_materials[view.scale_first + height_place(at, nearness)].surface.rgb;
        s.light = make_light(0.0, 1.0, vec4(0.0, 0.0, 0.0, s.light.emissive.w));
    } else if (view.recolors == RECOLORS_NORMAL) {
        vec3 n = unit(s.normal), eye = to_eye(at);
        vec3 color = 0.5 + 0.5 * (dot(n, eye) < 0.0 ? -n : n);
        s.color = color * color;
        s.light = make_light(0.0, 1.0, vec4(0.0, 0.0, 0.0, 1.0));
    }
}
