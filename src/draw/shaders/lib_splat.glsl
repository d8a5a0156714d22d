// A splat on the screen: src/raster/splats_kernel.h, where the conic is explained.
#include "lib_item.glsl"

struct splat_place {
    vec3 position; // X, Y (pixels, times W), N
    float w;
    vec2 code;     // octahedral normal
    float radius;  // pixels
    uint halvings; // of the radius
};

// All sums are in the processor's order: of many splats in a pixel, the same one is nearest.
float along(vec4 row, vec3 p)
{
    precise float sum = ((row.x * p.x + row.y * p.y) + row.z * p.z) + row.w;
    return sum;
}

// The part of a splat's disk that is drawn, between those of two octaves; of 255.
uint splat_part(const item_block item, uint index)
{
    if (item.kind != KIND_SURFELS) {
        return 255u;
    }
    uint part = fetch(item.colors + index) >> 24;
    if (index < item.low_count) {
        uint low = fetch(item.low_colors + index) >> 24, share = uint(256.0 * (1.0 - item.blend) + 0.5);
        part = (low * share + part * (256u - share) + 128u) >> 8;
    }
    return part;
}

// How often the radius of a disk is halved, of which so little is drawn.
uint splat_halvings(uint coverage)
{
    return uint(coverage < 64u) + uint(coverage < 16u) + uint(coverage < 4u);
}

splat_place place_splat(const record_block record, const item_block item, uint local)
{
    splat_place splat;
    vec3 p;
    splat.code = vec2(0.0);
    if (item.kind == KIND_SURFELS) {
        uint low = fetch(record.address + 2u * local), high = fetch(record.address + 2u * local + 1u);
        p = vec3(float(low & 0xFFFFu), float(low >> 16), float(high & 0xFFFFu));
        int code = int(high);
        splat.code = vec2(float(bitfieldExtract(code, 16, 8)), float(bitfieldExtract(code, 24, 8)));
    } else {
        p = fetch_vec3(record.address + 3u * local);
    }
    splat.position = vec3(along(item.rows[0], p), along(item.rows[1], p), along(item.rows[2], p));
    splat.w = along(item.rows[3], p);
    precise float inverse = 1.0 / splat.w, radius = item.radius_px * inverse;
    uint index = record.first + local, wanted = splat_halvings(splat_part(item, index));
    float least = 1.5 + float(index * 0x9E3779B1u >> 24) * (1.5 / 256.0); // as splat_least: not all shrink at one depth
    splat.halvings = 0u;
    while (splat.halvings < wanted && radius >= least) {
        radius *= 0.5;
        splat.halvings += 1u;
    }
    splat.radius = radius;
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
    precise vec3 turned = vec3((item.turn[0].x * n.x + item.turn[0].y * n.y) + item.turn[0].z * n.z,
                               (item.turn[1].x * n.x + item.turn[1].y * n.y) + item.turn[1].z * n.z,
                               (item.turn[2].x * n.x + item.turn[2].y * n.y) + item.turn[2].z * n.z);
    return turned;
}

// Once its radius was halved so often; 255: no holes.
uint splat_coverage(const item_block item, uint index, uint halvings)
{
    uint coverage = splat_part(item, index) << 2u * halvings;
    return (item.flags & ITEM_GHOST) != 0u ? uint(float(coverage) * view.ghost_splats + 0.5) : coverage;
}
