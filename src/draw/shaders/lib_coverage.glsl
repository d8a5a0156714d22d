// Codes of coverage: src/base/splats/coverage.h.
#define COVERAGE_CHANCES 39u
#define COVERAGE_HALVES 39u
#define COVERAGE_STRIPS 111u
#define COVERAGE_WHOLE 255u

const uint coverage_shares[39] = uint[39](1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u, 9u, 10u, 11u, 12u, 13u, 15u, 17u, 19u, 21u, 23u, 26u,
                                          29u, 32u, 36u, 40u, 45u, 50u, 56u, 63u, 70u, 78u, 87u, 97u, 109u, 122u, 137u,
                                          153u, 171u, 191u, 214u, 240u);
const float clip_cosines[7] = float[7](1.0, 0.96592583, 0.86602540, 0.70710678, 0.5, 0.25881905, 0.0);
const float half_offsets[3] = float[3](0.08, 0.35, 0.65);
const float half_areas[3] = float[3](0.55088, 0.71818, 0.88246);
const vec2 strip_offsets[12] = vec2[12](vec2(-0.05, 0.05), vec2(-0.05, 0.15), vec2(-0.15, 0.05), vec2(-0.15, 0.15),
                                        vec2(-0.05, 0.35), vec2(-0.35, 0.05), vec2(-0.35, 0.15), vec2(-0.15, 0.35),
                                        vec2(-0.35, 0.35), vec2(-0.15, 0.65), vec2(-0.65, 0.15), vec2(-0.5, 0.5));
const float strip_areas[12] = float[12](0.06364, 0.12695, 0.12695, 0.19027, 0.25, 0.25, 0.31331, 0.31331, 0.43636, 0.4776,
                                        0.4776, 0.609);

bool coverage_clips(uint code)
{
    return code >= COVERAGE_HALVES && code < COVERAGE_WHOLE;
}

uint coverage_share(uint code)
{
    return code < COVERAGE_CHANCES ? coverage_shares[code] : 255u;
}

float clip_cosine(uint direction)
{
    uint turned = direction % 24u;
    turned = turned > 12u ? 24u - turned : turned;
    return turned > 6u ? -clip_cosines[12u - turned] : clip_cosines[turned];
}

// For a clip code: direction across the clip lines, and the interval of distances that is drawn.
vec4 coverage_clip(uint code)
{
    bool is_half = code < COVERAGE_STRIPS;
    uint at = code - (is_half ? COVERAGE_HALVES : COVERAGE_STRIPS), offsets = is_half ? 3u : 12u;
    uint direction = at / offsets, offset = at % offsets;
    vec2 range = is_half ? vec2(-2.0, half_offsets[offset % 3u]) : strip_offsets[offset];
    return vec4(clip_cosine(direction), clip_cosine(direction + 18u), range);
}

// For a clip code: share of the disk's area.
float clip_area(uint code)
{
    return code < COVERAGE_STRIPS ? half_areas[(code - COVERAGE_HALVES) % 3u] : strip_areas[(code - COVERAGE_STRIPS) % 12u];
}
