// Texture sampling, same as on the CPU (src/raster/texture.c): averages in linear light, weighted
// by alpha.
#include "lib_srgb.glsl"
#include "lib_triangle.glsl"

layout(std430, binding = BINDING_MATERIALS) readonly buffer Materials { material_block materials[]; };

int wrap(int i, int size, uint how)
{
    if (how == 1u) {
        return clamp(i, 0, size - 1);
    }
    int period = how == 2u ? 2 * size : size;
    int r = i >= 0 ? i % period : period - 1 - (-1 - i) % period; // % of negative numbers is undefined
    return r < size ? r : period - 1 - r;
}

struct texel_square {
    uint texels;
    ivec2 x, y;
    vec2 share;
    uint width;
};

texel_square find_square(uint texture, uint level, vec2 uv, bool nearest)
{
    texel_square square;
    uint flags = fetch(texture + TEXTURE_FLAGS), at = texture + TEXTURE_SIZES + 3u * level;
    ivec2 size = ivec2(int(fetch(at)), int(fetch(at + 1u)));
    vec2 place = uv * vec2(size) - (nearest ? 0.0 : 0.5);
    place = mix(place, vec2(0.0), not(lessThan(abs(place), vec2(1e9))));
    vec2 whole = floor(place);
    square.share = nearest ? vec2(0.0) : place - whole;
    uint wrap_u = flags / TEXTURE_WRAP_U & 3u, wrap_v = flags / TEXTURE_WRAP_V & 3u;
    square.x = ivec2(wrap(int(whole.x), size.x, wrap_u), wrap(int(whole.x) + 1, size.x, wrap_u));
    square.y = ivec2(wrap(int(whole.y), size.y, wrap_v), wrap(int(whole.y) + 1, size.y, wrap_v));
    square.texels = texture + fetch(at + 2u);
    square.width = uint(size.x);
    return square;
}

struct texel_sum {
    vec4 weighted; // colour times alpha, and alpha
    vec3 plain;
};

void add_texel(inout texel_sum sum, uint word, bool linear, float weight)
{
    vec4 texel = unpackUnorm4x8(word);
    vec3 color = linear ? texel.rgb : to_linear(texel.rgb);
    sum.weighted += weight * texel.a * vec4(color, 1.0);
    sum.plain += weight * color;
}

// Samples a footprint in texels of level 0.
vec4 sample_texture(uint texture, vec2 uv, float footprint)
{
    uint flags = fetch(texture + TEXTURE_FLAGS), last = fetch(texture + TEXTURE_LEVELS) - 1u;
    bool linear = (flags & TEXTURE_LINEAR) != 0u, nearest = (flags & TEXTURE_NEAREST) != 0u;
    uint level = 0u;
    float blend = 0.0;
    if (footprint > 1.0) {
        for (; level < last && footprint >= 2.0; footprint *= 0.5) {
            level += 1u;
        }
        nearest = false;
        blend = level < last ? footprint - 1.0 : 0.0;
    }
    texel_sum sum = texel_sum(vec4(0.0), vec3(0.0));
    uint taps = blend > 0.0 ? 8u : 4u;
    texel_square square;
    // four of each level; in a loop, since unrolling makes compilers take seconds
    for (uint i = 0u; i < taps; ++i) {
        if ((i & 3u) == 0u) {
            square = find_square(texture, level + i / 4u, uv, nearest);
        }
        vec2 share = vec2((i & 1u) != 0u ? square.share.x : 1.0 - square.share.x,
                          (i & 2u) != 0u ? square.share.y : 1.0 - square.share.y);
        uint x = uint((i & 1u) != 0u ? square.x.y : square.x.x);
        uint y = uint((i & 2u) != 0u ? square.y.y : square.y.x);
        add_texel(sum, fetch(square.texels + y * square.width + x), linear,
                  (i < 4u ? 1.0 - blend : blend) * share.x * share.y);
    }
    vec3 color = sum.weighted.a > 0.0 ? sum.weighted.rgb / sum.weighted.a : sum.plain;
    return min(vec4(color, sum.weighted.a), vec4(1.0));
}

// Alpha alone, of one level.
float sample_alpha_at(uint texture, vec2 uv, uint level)
{
    uint flags = fetch(texture + TEXTURE_FLAGS);
    texel_square s = find_square(texture, level, uv, level == 0u && (flags & TEXTURE_NEAREST) != 0u);
    uint above = s.texels + uint(s.y.x) * s.width, below = s.texels + uint(s.y.y) * s.width;
    vec4 alpha = vec4(fetch(above + uint(s.x.x)) >> 24, fetch(above + uint(s.x.y)) >> 24,
                      fetch(below + uint(s.x.x)) >> 24, fetch(below + uint(s.x.y)) >> 24);
    vec2 rows = mix(alpha.xz, alpha.yw, s.share.x);
    return mix(rows.x, rows.y, s.share.y) / 255.0;
}

// The same from the level nearest to the footprint.
float sample_alpha(uint texture, vec2 uv, float footprint)
{
    uint last = fetch(texture + TEXTURE_LEVELS) - 1u, level = 0u;
    for (; level < last && footprint >= 1.5; footprint *= 0.5) {
        level += 1u;
    }
    return sample_alpha_at(texture, uv, level);
}

// Whether a fragment of a cutout is drawn (src/raster/cutout.c). own: alpha of material and
// vertices.
bool keeps_cutout(uint texture, vec2 uv, float footprint, float own, float cutoff)
{
    uint flags = fetch(texture + TEXTURE_FLAGS), count = fetch(texture + TEXTURE_LEVELS), level = 0u;
    bool tested = (flags & TEXTURE_CUTOUT) != 0u;
    uint end = flags >> TEXTURE_CUTOFF_SHIFT;
    for (; level + 1u < end && footprint >= 1.5; footprint *= 0.5) {
        level += 1u;
    }
    float alpha = sample_alpha_at(texture, uv, level);
    if (!tested || (level == 0u && (flags & TEXTURE_REDUCED) == 0u)) {
        return own * alpha >= cutoff;
    }
    if (!(cutoff > 0.0)) {
        return true;
    }
    float step = cutoff / own * 255.0;
    if (!(step <= 255.0)) {
        return false;
    }
    uint below = min(uint(step), uint(TEXTURE_CUTOFFS) - 2u);
    uint last = texture + TEXTURE_SIZES + 3u * (count - 1u);
    uint table = texture + fetch(last + 2u) + fetch(last) * fetch(last + 1u) + uint(TEXTURE_CUTOFFS) * level + below;
    float low = fetch_float(table), high = fetch_float(table + 1u);
    return alpha >= low + (high - low) * (step - float(below));
}

// Coordinates in a material's n-th texture (0 base colour, 1 metallic and roughness, 2 emissive, 3
// normals) at a point of a triangle.
vec2 find_uv(const triangle_place t, uint material, uint n, vec3 weight)
{
    vec4 first = materials[material].uses[2u * n], second = materials[material].uses[2u * n + 1u];
    uint set = uint(first.w);
    if (!has_texcoords(t, set)) {
        return vec2(0.0);
    }
    vec3 uv = vec3(weight.x * corner_texcoord(t, set, t.corner.x) +
                   weight.y * corner_texcoord(t, set, t.corner.y) +
                   weight.z * corner_texcoord(t, set, t.corner.z), 1.0);
    return vec2(dot(first.xyz, uv), dot(second.xyz, uv));
}

// Texels of a texture per item unit along a triangle.
float find_density(const triangle_place t, uint material, uint n, uint texture)
{
    vec4 first = materials[material].uses[2u * n], second = materials[material].uses[2u * n + 1u];
    uint set = uint(first.w);
    if (!has_texcoords(t, set)) {
        return 0.0;
    }
    vec2 a = corner_texcoord(t, set, t.corner.x);
    vec2 ab = corner_texcoord(t, set, t.corner.y) - a, ac = corner_texcoord(t, set, t.corner.z) - a;
    float turned = abs(first.x * second.y - first.y * second.x);
    float uv_area = abs(ab.x * ac.y - ab.y * ac.x) * turned;
    float texels = uv_area * float(fetch(texture + TEXTURE_SIZES)) * float(fetch(texture + TEXTURE_SIZES + 1u));
    vec3 p = corner_position(t, t.corner.x);
    float area = length(cross(corner_position(t, t.corner.y) - p, corner_position(t, t.corner.z) - p));
    return area > 0.0 ? sqrt(min(texels / area, 3e38)) : 0.0;
}
