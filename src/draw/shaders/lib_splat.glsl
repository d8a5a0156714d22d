// A projected splat: see src/raster/splats_kernel.h, which explains the conic.
#include "lib_chunk.glsl"
#include "lib_coverage.glsl"
#include "lib_glass.glsl"

struct splat_place {
    vec3 position; // X, Y (pixels, times W), N
    float w;
    vec2 code;     // normal as stored in the set, octahedral
    float radius;  // pixels
    uint halvings; // how often the radius was halved
    uint part;     // drawn part of the disk: see splat_part
    bool glass;    // transparent
    bool there;    // its range contains the level, and it does not face away
    float own;     // its own radius, relative to the item's
    uint shape;    // code of its radii and direction; 0: none
};

// Sums use the same order as the CPU, so that the same splat is nearest in a pixel.
float along(vec4 row, vec3 p)
{
    precise float sum = ((row.x * p.x + row.y * p.y) + row.z * p.z) + row.w;
    return sum;
}

// Drawn part of a splat's disk, interpolated between two octaves: a share of 255, or, above
// SPLAT_CLIP, a clip code. 0: not drawn.
#define SPLAT_CLIP 256u
uint splat_part(const item_block item, uint index)
{
    if (item.kind != KIND_SPLATS) {
        return 255u;
    }
    uint own = fetch(item.colors + index) >> 24;
    if (own == 0u && view.hides != 0u) {
        return 0u;
    }
    if ((item.flags & ITEM_FIXED) != 0u) {
        return 255u;
    }
    if (index < item.low_count) {
        uint low = fetch(item.low_colors + index) >> 24, share = uint(256.0 * (1.0 - item.blend) + 0.5);
        if (!coverage_clips(own) && !coverage_clips(low)) {
            return (coverage_share(low) * share + coverage_share(own) * (256u - share) + 128u) >> 8;
        }
        own = (index * 0x9E3779B1u + 0x7F4A7C15u) >> 24 < share ? low : own;
    }
    return coverage_clips(own) ? SPLAT_CLIP + own : coverage_share(own);
}

// Unit direction across a disk's clip lines, in item space.
vec3 clip_direction(vec2 code, vec4 clip)
{
    vec3 unfolded = decode_octahedral(code, 127.0);
    precise float inverse = 1.0 / sqrt((unfolded.x * unfolded.x + unfolded.y * unfolded.y) + unfolded.z * unfolded.z);
    precise vec3 n = unfolded * inverse;
    float side = n.z < 0.0 ? -1.0 : 1.0;
    precise float a = -1.0 / (side + n.z), b = (n.x * n.y) * a;
    precise vec3 x = vec3(1.0 + (side * (n.x * n.x)) * a, side * b, -(side * n.x));
    precise vec3 y = vec3(b, side + (n.y * n.y) * a, -n.y);
    precise vec3 direction = clip.x * x + clip.y * y;
    return direction;
}

// How often the radius of a disk with little coverage is halved.
uint splat_halvings(uint coverage)
{
    return uint(coverage < 64u) + uint(coverage < 16u) + uint(coverage < 4u);
}

// Whether a splat belongs to a transparent surface.
bool is_glass(const item_block item, uint index)
{
#ifdef GLASS
    if (item.kind == KIND_SPLATS && (item.flags & ITEM_FIXED) == 0u && coverage_share(fetch(item.colors + index) >> 24) < 255u) {
        uint shading = find_shading(item, index);
        return (view.glass_shadings[shading >> 7][(shading >> 5) & 3u] >> (shading & 31u) & 1u) != 0u;
    }
#endif
    return false;
}

// A radius in size steps of its set.
float shape_radius(uint code)
{
    return uintBitsToFloat(((code & 0xFFFu) << 16) + SHAPE_BIAS);
}

// Additional weight of a squared offset along the smaller radius: 0 for disks.
float shape_stretch(uint code)
{
    precise float ratio = shape_radius(code) / shape_radius(code >> 12), stretch = ratio * ratio - 1.0;
    return stretch;
}

// Unit direction of the smaller radius, in item space.
vec3 shape_smaller(vec2 code, uint shape)
{
    float turn = float(shape >> 24) * (3.14159265 / 256.0);
    return clip_direction(code, vec4(-sin(turn), cos(turn), 0.0, 0.0));
}

// Share of a level that remains in a view, from two codes of shares (base/splats/splat_codes.h).
float error_share(uint along_plane, uint along_normal, vec3 n, vec3 sight)
{
    precise float along = abs((n.x * sight.x + n.y * sight.y) + n.z * sight.z);
    precise float square = ((n.x * n.x + n.y * n.y) + n.z * n.z) *
                           ((sight.x * sight.x + sight.y * sight.y) + sight.z * sight.z);
    precise float cosine = square > 0.0 ? min(along / sqrt(square), 1.0) : 1.0;
    precise float sine = sqrt(1.0 - cosine * cosine);
    precise float steps = float(along_plane + ERROR_SHARE_FIRST) * sine + float(along_normal + ERROR_SHARE_FIRST) * cosine;
    precise float share = steps * (1.0 / ERROR_STEPS);
    return min(share, 1.0);
}

// Whether a level is in the range of the splat at p, as the view direction lowers it.
bool is_within(const item_block item, float level, uint range, uint errors, vec2 code, vec3 p)
{
    precise vec3 sight = vec3(item.eye[0], item.eye[1], item.eye[2]) - (view.parallel != 0u ? vec3(0.0) : p);
    vec2 parent = vec2(float(bitfieldExtract(int(errors), 16, 8)), float(bitfieldExtract(int(errors), 24, 8)));
    float own = error_share(errors & 15u, errors >> 4 & 15u, decode_octahedral(code, 127.0), sight);
    float above = error_share(errors >> 8 & 15u, errors >> 12 & 15u, decode_octahedral(parent, 127.0), sight);
    precise float lowest = own * uintBitsToFloat((range & 0xFFFFu) << 15);
    precise float highest = above * uintBitsToFloat(range >> 16 << 15);
    return level >= lowest && level <= highest;
}

// Shape and range of a splat at p, and depth w.
void find_options(const record_block record, const item_block item, uint local, vec3 p, inout splat_place splat)
{
    bool shapes = (item.flags & ITEM_SHAPES) != 0u, ranges = (item.flags & ITEM_RANGES) != 0u;
    bool errors = (item.flags & ITEM_ERRORS) != 0u;
    uint at = record.options + local * (uint(shapes) + uint(ranges) + uint(errors));
    splat.there = true;
    splat.own = 1.0;
    splat.shape = 0u;
    if ((item.flags & ITEM_GROWTHS) != 0u) {
        uint byte = uint(record.share) + local, word = fetch(record.options + byte / 4u);
        uint shading = word >> (8u * (byte & 3u)) & 255u;
        precise float larger = 1.0 + view.growths[shading >> 2][shading & 3u] * item.growth_share;
        splat.own = larger;
    }
    if (shapes) {
        splat.shape = fetch(at);
        splat.own = shape_radius(splat.shape);
        bool disk = (splat.shape & 0xFFFu) == (splat.shape >> 12 & 0xFFFu);
        splat.there = (item.flags & ITEM_BESIDE) == 0u || !disk || (splat.shape & SHAPE_REPLACED) == 0u;
        at += 1u;
    }
    if (ranges) {
        uint range = fetch(at);
        precise float level = max(item.level_per_depth * splat.w, item.level_min);
        // bits of floats that are not negative sort like the floats
        int bits = floatBitsToInt(record.first + local < item.divide ? item.level_below : level);
        bool within = bits >= int((range & 0xFFFFu) << 15) && bits <= int(range >> 16 << 15);
        if (errors && item.level_min == 0.0) { // else the level is a cut of the whole ranges
            within = is_within(item, level, range, fetch(at + 1u), splat.code, p);
        }
        splat.there = splat.there && within;
    }
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

// Whether a splat of a single-sided material faces away.
bool is_back(const record_block record, const item_block item, uint local, const splat_place splat)
{
    if (item.kind != KIND_SPLATS || (item.flags & (ITEM_FACING | ITEM_SIDELESS)) != 0u) {
        return false;
    }
    if (!(splat.w > 0.0)) { // behind the eye, and so close that it is drawn as large
        return false;
    }
    vec2 screen = splat.position.xy / splat.w;
    vec3 sight = vec3((screen - vec2(item.center_x, item.center_y)) * item.inverse_scale, 1.0);
    vec3 n = turn_normal(item, splat.code);
    float along = dot(n, sight);
    if (along < 0.0 || along * along <= BACK_SINE * BACK_SINE * dot(n, n) * dot(sight, sight)) {
        return false;
    }
    if (view.front_only == FRONT_ONLY_ALL) {
        return true;
    }
    uint shading = find_shading(item, record.first + local);
    return (view.front_shadings[shading >> 7][(shading >> 5) & 3u] >> (shading & 31u) & 1u) != 0u;
}

splat_place place_splat(const record_block record, const item_block item, uint local)
{
    splat_place splat;
    vec3 p;
    splat.glass = is_glass(item, record.first + local);
    splat.code = vec2(0.0);
    if (item.kind == KIND_SPLATS) {
        uint low = fetch(record.address + 2u * local), high = fetch(record.address + 2u * local + 1u);
        p = vec3(float(low & 0xFFFFu), float(low >> 16), float(high & 0xFFFFu));
        int code = int(high);
        splat.code = vec2(float(bitfieldExtract(code, 16, 8)), float(bitfieldExtract(code, 24, 8)));
    } else {
        p = fetch_vec3(record.address + 3u * local);
    }
    bool hidden = item.kind == KIND_POINTS && p.x >= HIDDEN_PLACE;
    splat.position = vec3(along(item.rows[0], p), along(item.rows[1], p), along(item.rows[2], p));
    splat.w = along(item.rows[3], p);
    find_options(record, item, local, p, splat);
    splat.there = splat.there && !(view.front_only != FRONT_ONLY_NONE && is_back(record, item, local, splat));
    precise float inverse = 1.0 / splat.w, radius = (item.radius_px * inverse + item.pixels) * splat.own;
    uint index = record.first + local;
    splat.part = hidden ? 0u : splat_part(item, index);
    uint wanted = splat.glass ? 0u : splat_halvings(splat.part);
    // same as splat_min_diameter: splats shrink at different depths
    float minimum = 1.5 + float(index * 0x9E3779B1u >> 24) * (1.5 / 256.0);
    splat.halvings = 0u;
    while (splat.halvings < wanted && radius >= minimum) {
        radius *= 0.5;
        splat.halvings += 1u;
    }
    splat.radius = radius;
    return splat;
}

bool is_wanted(const record_block record, const item_block item, const splat_place splat)
{
#ifdef LAYER
    if (!splat.glass) {
        return false;
    }
#elif defined(GLASS)
    if (splat.glass && view.glass == GLASS_LAYERS) {
        return false;
    }
#endif
    return splat.there && splat.part != 0u && splat.w >= record.nearest && splat.w <= record.farthest &&
           !(item.sections != 0u && is_beyond_section(item, to_view(item, vec4(splat.position, splat.w))));
}

bool is_close(const item_block item, const splat_place splat)
{
    return view.parallel == 0u && splat.w < item.near_w * splat.own && splat.w > item.far_w * splat.own;
}

// Drawn share of a disk's pixels, of 255; 255: no holes. `single`: for the centre's pixel only.
uint splat_coverage(const item_block item, uint part, uint halvings, bool single)
{
    if (part > SPLAT_CLIP) {
        part = single ? uint(clip_area(part - SPLAT_CLIP) * 255.0 + 0.5) : 255u;
    }
    uint coverage = part << 2u * halvings;
    return (item.flags & ITEM_GHOST) != 0u ? uint(float(coverage) * view.ghost_splats + 0.5) : coverage;
}

// Inputs of a fragment's coverage test: id, hash key, coverage or opacity. `single`: as for
// splat_coverage.
uvec3 splat_hash(const record_block record, const item_block item, uint local, const splat_place splat, uint halvings,
                 bool single)
{
    uint index = record.first + local, id = item.first_id + index;
#ifdef LAYER
    return uvec3(id, 0u, 255u);
#elif defined(GLASS)
    if (splat.glass) {
        uint low = fetch(record.address + 2u * local), high = fetch(record.address + 2u * local + 1u);
        int code = int(high);
        vec3 n = abs(decode_octahedral(vec2(float(bitfieldExtract(code, 16, 8)), float(bitfieldExtract(code, 24, 8))), 127.0));
        uint axis = n.x >= n.y && n.x >= n.z ? 0u : n.y >= n.z ? 1u : 2u;
        uint place = axis == 0u ? low & 0xFFFFu : axis == 1u ? low >> 16 : high & 0xFFFFu;
        float opacity = glass_opacity(min(splat.part, 255u)) * ((item.flags & ITEM_GHOST) != 0u ? view.ghost : 1.0);
        uint key = find_glass_key(item.seed - view.pattern * 0x9E3779B1u, axis, int(place >> GLASS_CELL_SHIFT));
        return uvec3(id, key, GLASS_HASHED | uint(opacity * 65535.0 + 0.5));
    }
#endif
    return uvec3(id, item.seed + index, splat_coverage(item, splat.part, halvings, single));
}
