// A splat on the screen: src/raster/splats_kernel.h, where the conic is explained.
#include "lib_item.glsl"

struct splat_place {
    vec3 position; // X, Y (pixels, times W), N
    float w;
    vec2 code;     // octahedral normal
    float radius;  // pixels
};

splat_place place_splat(const record_block record, const item_block item, uint local)
{
    splat_place splat;
    vec4 p;
    splat.code = vec2(0.0);
    if (item.kind == KIND_SURFELS) {
        uint low = fetch(record.address + 2u * local), high = fetch(record.address + 2u * local + 1u);
        p = vec4(float(low & 0xFFFFu), float(low >> 16), float(high & 0xFFFFu), 1.0);
        int code = int(high);
        splat.code = vec2(float(bitfieldExtract(code, 16, 8)), float(bitfieldExtract(code, 24, 8)));
    } else {
        p = vec4(fetch_vec3(record.address + 3u * local), 1.0);
    }
    splat.position = vec3(dot(item.rows[0], p), dot(item.rows[1], p), dot(item.rows[2], p));
    splat.w = dot(item.rows[3], p);
    splat.radius = item.radius_px / splat.w + item.pixel_radius;
    return splat;
}

bool is_wanted(const record_block record, const item_block item, const splat_place splat)
{
    return splat.w >= record.nearest && splat.w <= record.farthest &&
           !(item.sections != 0u && is_cut(item, to_view(item, vec4(splat.position, splat.w))));
}

bool is_close(const item_block item, float w)
{
    return view.parallel == 0u && w < item.near_w && w > item.far_w;
}

// The normal in the view, of any length.
vec3 turn_normal(const item_block item, vec2 code)
{
    vec3 n = decode_octahedral(code, 127.0);
    return vec3(dot(item.turn[0].xyz, n), dot(item.turn[1].xyz, n), dot(item.turn[2].xyz, n));
}

// 255: no holes.
uint splat_coverage(const item_block item, uint index)
{
    uint coverage = item.kind == KIND_SURFELS ? fetch(item.colors + index) >> 24 : 255u;
    return (item.flags & ITEM_GHOST) != 0u ? uint(float(coverage) * view.ghost_splats + 0.5) : coverage;
}
