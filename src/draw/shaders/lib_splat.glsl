// A splat on the screen: src/raster/splats_kernel.h, where the conic is explained.
#include "lib_item.glsl"

struct splat_place {
    vec3 position; // X, Y (pixels, times W), N
    float w;
    vec2 code;     // octahedral normal
    float radius;  // pixels
    uint halvings; // of the radius
    uint part;     // what is drawn of the disk: see splat_part
};

// Codes of coverage: src/base/coverage.h.
#define COVERAGE_CHANCES 39u
#define COVERAGE_HALVES 39u
#define COVERAGE_STRIPS 111u
#define COVERAGE_WHOLE 255u

const uint coverage_shares[39] = uint[39](1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u, 9u, 10u, 11u, 12u, 13u, 15u, 17u, 19u, 21u, 23u, 26u,
                                          29u, 32u, 36u, 40u, 45u, 50u, 56u, 63u, 70u, 78u, 87u, 97u, 109u, 122u, 137u,
                                          153u, 171u, 191u, 214u, 240u);
const float cut_cosines[7] = float[7](1.0, 0.96592583, 0.86602540, 0.70710678, 0.5, 0.25881905, 0.0);
const float half_offsets[3] = float[3](0.08, 0.35, 0.65);
const float half_areas[3] = float[3](0.55088, 0.71818, 0.88246);
const vec2 strip_offsets[12] = vec2[12](vec2(-0.05, 0.05), vec2(-0.05, 0.15), vec2(-0.15, 0.05), vec2(-0.15, 0.15),
                                        vec2(-0.05, 0.35), vec2(-0.35, 0.05), vec2(-0.35, 0.15), vec2(-0.15, 0.35),
                                        vec2(-0.35, 0.35), vec2(-0.15, 0.65), vec2(-0.65, 0.15), vec2(-0.5, 0.5));
const float strip_areas[12] = float[12](0.06364, 0.12695, 0.12695, 0.19027, 0.25, 0.25, 0.31331, 0.31331, 0.43636, 0.4776,
                                        0.4776, 0.609);

bool coverage_cuts(uint code)
{
    return code >= COVERAGE_HALVES && code < COVERAGE_WHOLE;
}

uint coverage_share(uint code)
{
    return code < COVERAGE_CHANCES ? coverage_shares[code] : 255u;
}

float cut_cosine(uint direction)
{
    uint turned = direction % 24u;
    turned = turned > 12u ? 24u - turned : turned;
    return turned > 6u ? -cut_cosines[12u - turned] : cut_cosines[turned];
}

// Of a code that cuts: the direction across the lines, and between which distances is drawn.
vec4 coverage_cut(uint code)
{
    bool is_half = code < COVERAGE_STRIPS;
    uint at = code - (is_half ? COVERAGE_HALVES : COVERAGE_STRIPS), offsets = is_half ? 3u : 12u;
    uint direction = at / offsets, offset = at % offsets;
    vec2 range = is_half ? vec2(-2.0, half_offsets[offset % 3u]) : strip_offsets[offset];
    return vec4(cut_cosine(direction), cut_cosine(direction + 18u), range);
}

// Of a code that cuts: the part of the disk's area.
float cut_area(uint code)
{
    return code < COVERAGE_STRIPS ? half_areas[(code - COVERAGE_HALVES) % 3u] : strip_areas[(code - COVERAGE_STRIPS) % 12u];
}

// All sums are in the processor's order: of many splats in a pixel, the same one is nearest.
float along(vec4 row, vec3 p)
{
    precise float sum = ((row.x * p.x + row.y * p.y) + row.z * p.z) + row.w;
    return sum;
}

// What is drawn of a splat's disk, between those of two octaves: a share of 255, or, above SPLAT_CUT, a code that cuts.
#define SPLAT_CUT 256u
uint splat_part(const item_block item, uint index)
{
    if (item.kind != KIND_SURFELS) {
        return 255u;
    }
    uint own = fetch(item.colors + index) >> 24;
    if (index < item.low_count) {
        uint low = fetch(item.low_colors + index) >> 24, share = uint(256.0 * (1.0 - item.blend) + 0.5);
        if (!coverage_cuts(own) && !coverage_cuts(low)) {
            return (coverage_share(low) * share + coverage_share(own) * (256u - share) + 128u) >> 8;
        }
        own = (index * 0x9E3779B1u + 0x7F4A7C15u) >> 24 < share ? low : own;
    }
    return coverage_cuts(own) ? SPLAT_CUT + own : coverage_share(own);
}

// The direction across the lines along which a disk is cut, of unit length in the item's space.
vec3 cut_direction(vec2 code, vec4 cut)
{
    vec3 unfolded = decode_octahedral(code, 127.0);
    precise float inverse = 1.0 / sqrt((unfolded.x * unfolded.x + unfolded.y * unfolded.y) + unfolded.z * unfolded.z);
    precise vec3 n = unfolded * inverse;
    float side = n.z < 0.0 ? -1.0 : 1.0;
    precise float a = -1.0 / (side + n.z), b = (n.x * n.y) * a;
    precise vec3 x = vec3(1.0 + (side * (n.x * n.x)) * a, side * b, -(side * n.x));
    precise vec3 y = vec3(b, side + (n.y * n.y) * a, -n.y);
    precise vec3 direction = cut.x * x + cut.y * y;
    return direction;
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
    uint index = record.first + local;
    splat.part = splat_part(item, index);
    uint wanted = splat_halvings(splat.part);
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

vec3 turn_vector(const item_block item, vec3 n)
{
    precise vec3 turned = vec3((item.turn[0].x * n.x + item.turn[0].y * n.y) + item.turn[0].z * n.z,
                               (item.turn[1].x * n.x + item.turn[1].y * n.y) + item.turn[1].z * n.z,
                               (item.turn[2].x * n.x + item.turn[2].y * n.y) + item.turn[2].z * n.z);
    return turned;
}

// The normal in the view, of any length.
vec3 turn_normal(const item_block item, vec2 code)
{
    return turn_vector(item, decode_octahedral(code, 127.0));
}

// Of a disk's pixels, those that are drawn, of 255; 255: no holes. `single`: of the pixel of its centre alone.
uint splat_coverage(const item_block item, uint part, uint halvings, bool single)
{
    if (part > SPLAT_CUT) {
        part = single ? uint(cut_area(part - SPLAT_CUT) * 255.0 + 0.5) : 255u;
    }
    uint coverage = part << 2u * halvings;
    return (item.flags & ITEM_GHOST) != 0u ? uint(float(coverage) * view.ghost_splats + 0.5) : coverage;
}
