// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/core/processor.h"
#include "base/math/rng.h"
#include "base/splats/coverage.h"
#include "base/splats/octahedral.h"
#include "raster/splats_levels_kernel.h"
#include "store/sets/sets_internal.h"

#include <stipple/order.h>

enum { WIDTH = 96, HEIGHT = 72, SPLATS = 400 };

typedef struct splat_scene {
    uint16_t positions[3 * SPLATS];
    int8_t normals[2 * SPLATS];
    uint8_t coverages[SPLATS];
    uint32_t shapes[SPLATS];
    uint32_t ranges[SPLATS];
    uint64_t pixels[WIDTH * HEIGHT];
    stp_raster_target target;
    stp_raster_splats splats;
    stp_raster_camera camera;
} splat_scene;

static double uniform(uint64_t seed, uint64_t index, double low, double high)
{
    return low + (high - low) * ((double)(stp_rng_hash(seed, index) >> 11) * 0x1p-53);
}

static void clear(splat_scene* s)
{
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        s->pixels[i] = STP_RASTER_EMPTY;
    }
}

// A camera at `distance` from the middle of the unit cube, turned about y and x, perhaps mirrored.
static void place_camera(splat_scene* s, double turn, double distance, double focal, bool parallel,
                         bool mirror)
{
    double c = cos(turn), d = sin(turn), e = cos(0.4), f = sin(0.4);
    double rotation[3][3] = {{c, 0, d}, {f * d, e, -f * c}, {-e * d, f, e * c}};
    for (int k = 0; k < 3; ++k) {
        rotation[0][k] *= mirror ? -1.0 : 1.0;
    }
    s->camera = (stp_raster_camera){
        .pixel_scale = (float)focal, .parallel = parallel, .nearness_limit = 1.0f};
    double view[3][4];
    for (int r = 0; r < 3; ++r) {
        view[r][3] = r == 2 ? distance : 0.0;
        for (int k = 0; k < 3; ++k) {
            view[r][k] = 2.0 * rotation[r][k]; // scaled by two, to test that the scale is removed
            view[r][3] -= view[r][k] * 0.5;
        }
        for (int k = 0; k < 4; ++k) {
            s->camera.view[r][k] = (float)view[r][k];
        }
    }
    for (int k = 0; k < 4; ++k) {
        double one = k == 3 ? 1.0 : 0.0, z = view[2][k], w = parallel ? one : z;
        s->camera.matrix.m[0][k] = (float)(focal * view[0][k] + 0.5 * WIDTH * w);
        s->camera.matrix.m[1][k] = (float)(focal * view[1][k] + 0.5 * HEIGHT * w);
        s->camera.matrix.m[2][k] = parallel ? (float)(0.9 * one - 0.05 * z) : (float)(0.05 * one);
        s->camera.matrix.m[3][k] = (float)w;
    }
}

static void make_scene(splat_scene* s, uint64_t seed, double radius)
{
    for (uint64_t i = 0; i < 3 * SPLATS; ++i) {
        s->positions[i] = (uint16_t)uniform(seed, i, 0, 65535);
    }
    for (uint64_t i = 0; i < SPLATS; ++i) {
        stp_vec3 n = {(float)uniform(seed + 1, 3 * i, -1, 1),
                      (float)uniform(seed + 1, 3 * i + 1, -1, 1),
                      (float)uniform(seed + 1, 3 * i + 2, -1, 1)};
        stp_octahedral_encode(n, s->normals + 2 * i);
        s->coverages[i] = (uint8_t)(stp_rng_hash(seed + 2, i) & 255);
        float larger = (float)exp2(uniform(seed + 3, i, -1.5, 1.5));
        float smaller = larger * (float)uniform(seed + 4, i, 0.1, 1.2);
        s->shapes[i] = stp_shape_code(larger) |
                       stp_shape_code(smaller < larger ? smaller : larger) << 12 |
                       (uint32_t)(stp_rng_hash(seed + 5, i) & 255) << 24;
        float low = (float)exp2(uniform(seed + 6, i, -6, 2));
        s->ranges[i] = stp_range_code(low, low * (float)exp2(uniform(seed + 7, i, 0, 3)));
    }
    s->target = (stp_raster_target){WIDTH, HEIGHT, WIDTH, s->pixels};
    s->splats = (stp_raster_splats){.positions = s->positions,
                                    .normals = s->normals,
                                    .end = SPLATS,
                                    .step = 1.0f / 65536.0f,
                                    .radius = (float)radius};
    clear(s);
}

// The larger radius of a splat, in units of the call's radius.
static double own_radius(const splat_scene* s, uint32_t index)
{
    return s->splats.shapes != NULL ? (double)stp_shape_radius(s->shapes[index] & 0xFFFu) : 1.0;
}

// The plane of a splat in view units.
typedef struct splat_plane {
    double center[3], normal[3];
    double direction[3], stretch; ///< direction of the smaller radius, and its extra weight
} splat_plane;

static void find_direction(const splat_scene* s, uint32_t index, splat_plane* plane)
{
    if (s->splats.shapes == NULL) {
        return;
    }
    uint32_t code = s->shapes[index];
    const int8_t* normal = s->normals + 2 * index;
    stp_disk_axes axes = stp_disk_axes_of((float)normal[0], (float)normal[1]);
    double turn = STP_PI * (double)(code >> 24) / 256.0;
    const float x[3] = {axes.x.x, axes.x.y, axes.x.z}, y[3] = {axes.y.x, axes.y.y, axes.y.z};
    for (int r = 0; r < 3; ++r) {
        for (int k = 0; k < 3; ++k) { // the view is scaled by two
            double direction = cos(turn) * (double)y[k] - sin(turn) * (double)x[k];
            plane->direction[r] += 0.5 * (double)s->camera.view[r][k] * direction;
        }
    }
    double ratio = own_radius(s, index) / (double)stp_shape_radius(code >> 12 & 0xFFFu);
    plane->stretch = ratio * ratio - 1.0;
}

/// Uses only the camera, in double.
static splat_plane find_plane(const splat_scene* s, uint32_t index)
{
    splat_plane plane = {.center = {0}};
    stp_vec3 normal = stp_octahedral_decode(s->normals[2 * index], s->normals[2 * index + 1]);
    const double raw[3] = {(double)normal.x, (double)normal.y, (double)normal.z};
    for (uint32_t r = 0; r < 3; ++r) {
        plane.center[r] = (double)s->camera.view[r][3];
        for (uint32_t k = 0; k < 3; ++k) {
            double at = (double)s->positions[3 * index + k] * (double)s->splats.step;
            plane.center[r] += (double)s->camera.view[r][k] * at;
            plane.normal[r] += (double)s->camera.view[r][k] * raw[k];
        }
    }
    find_direction(s, index, &plane);
    return plane;
}

// Distance from the splat's centre, in its own radii, at which the ray through a screen point meets
// its plane, in view units, and the nearness there; HUGE_VAL if it misses. Uses only the camera, in
// double.
static double visit_plane(const splat_scene* s, uint32_t index, const splat_plane* plane, double x,
                          double y, double* nearness)
{
    const double *n = plane->normal, *center = plane->center;
    double dir[3], from[3] = {0};
    double focal = (double)s->camera.pixel_scale;
    double u = (x - 0.5 * WIDTH) / focal, v = (y - 0.5 * HEIGHT) / focal;
    dir[0] = s->camera.parallel ? 0 : u;
    dir[1] = s->camera.parallel ? 0 : v;
    dir[2] = 1;
    from[0] = s->camera.parallel ? u : 0;
    from[1] = s->camera.parallel ? v : 0;
    double above = 0.0, along = 0.0;
    for (int k = 0; k < 3; ++k) {
        above += n[k] * (center[k] - from[k]);
        along += n[k] * dir[k];
    }
    double t = above / along, square = 0.0, aside = 0.0;
    if (!(fabs(along) > 1e-12) || (!s->camera.parallel && t <= 0.0)) {
        return HUGE_VAL;
    }
    for (int k = 0; k < 3; ++k) {
        double offset = from[k] + t * dir[k] - center[k];
        square += offset * offset;
        aside += offset * plane->direction[k];
    }
    square += plane->stretch * aside * aside;
    *nearness = s->camera.parallel ? 0.9 - 0.05 * t : 0.05 / t;
    return sqrt(square) / own_radius(s, index);
}

/// The same for one point of a splat, and its centre.
static double visit_object(const splat_scene* s, uint32_t index, double x, double y,
                           double center[3], double* nearness)
{
    splat_plane plane = find_plane(s, index);
    memcpy(center, plane.center, sizeof(plane.center));
    return visit_plane(s, index, &plane, x, y, nearness);
}

// Distance of the disk's nearest edge from the pixel, in steps of 0.05 pixels: within that distance
// the pixel may be either way.
static bool near_edge(const splat_scene* s, uint32_t index, const splat_plane* plane, double x,
                      double y, double radius, bool inside)
{
    for (int k = 0; k < 8; ++k) {
        double angle = k * (STP_PI / 4), nearness;
        double d =
            visit_plane(s, index, plane, x + 0.05 * cos(angle), y + 0.05 * sin(angle), &nearness);
        if ((d <= radius) != inside) {
            return true;
        }
    }
    return false;
}

// Wrong pixels of one splat drawn alone, against the ray-plane test in double precision.
static int count_wrong(splat_scene* s, uint32_t index)
{
    clear(s);
    s->splats.begin = index;
    s->splats.end = index + 1;
    stp_raster_draw_splats(&s->target, 0, HEIGHT, &s->camera, &s->splats, 7);
    double radius = 2.0 * (double)s->splats.radius; // the view is scaled by two
    int wrong = 0;
    const splat_plane plane = find_plane(s, index);
    const double* center = plane.center;
    for (uint32_t at = 0; at < WIDTH * HEIGHT; ++at) {
        double x = at % WIDTH + 0.5, y = at / WIDTH + 0.5, nearness = 0.0;
        double distance = visit_plane(s, index, &plane, x, y, &nearness);
        double z = s->camera.parallel ? 1.0 : center[2], focal = (double)s->camera.pixel_scale;
        bool ahead = s->camera.parallel || center[2] > 0.0;
        double sx = 0.5 * WIDTH + focal * center[0] / z, sy = 0.5 * HEIGHT + focal * center[1] / z;
        bool is_center = ahead && floor(sx) == floor(x) && floor(sy) == floor(y);
        double aside = s->camera.parallel ? 0.0 : hypot(center[0], center[1]) / z;
        double reach = radius * own_radius(s, index) * focal / z *
                       hypot(1.0, aside); // up to half a pixel: only the centre's pixel
        bool dot = ahead && reach * reach <= 0.24;
        bool expected = dot ? is_center : distance <= radius && nearness <= 1.0;
        bool got = s->pixels[at] != STP_RASTER_EMPTY;
        bool near_border = fabs(sx - round(sx)) < 1e-3 || fabs(sy - round(sy)) < 1e-3;
        if (got != expected && !(dot && near_border) && fabs(reach * reach - 0.24) > 1e-4 &&
            !near_edge(s, index, &plane, x, y, radius, distance <= radius)) {
            wrong += 1;
        }
        if (got && stp_raster_id(s->pixels[at]) != 7 + index) {
            wrong += 1;
        }
        if (got && distance <= radius &&
            !near_edge(s, index, &plane, x, y, radius, true)) { // the plane's depth
            double error = fabs((double)stp_raster_nearness(s->pixels[at]) - nearness);
            double per_unit = s->camera.parallel ? 0.05 : nearness * nearness / 0.05;
            double own = radius * own_radius(s, index);
            bool tiny = own * focal / z < 0.5; // drawn as its centre's pixel, at its centre's depth
            wrong += error > (tiny ? 1.0 : 0.02) * own * per_unit + 1e-6 && nearness < 0.999;
        }
    }
    return wrong;
}

void test_splats_agree_with_rays(test_state* test)
{
    static splat_scene s;
    const double radii[] = {0.0005, 0.004, 0.012, 0.03, 0.1, 0.4};
    for (int round = 0; round < 24; ++round) {
        bool parallel = round % 2 == 1;
        double distance =
            parallel || round % 3 != 0 ? 3.0 : 0.7; // 0.7: some behind the eye, some around it
        make_scene(&s, (uint64_t)round, radii[round / 4]);
        place_camera(&s, 0.7 * round, distance, parallel ? 30.0 : 80.0, parallel, round % 5 == 4);
        int wrong = 0;
        for (uint32_t i = (uint32_t)round; i < SPLATS; i += 40) {
            wrong += count_wrong(&s, i);
        }
        CHECK_EQUAL(0, wrong);
    }
}

void test_splats_with_shapes_agree_with_rays(test_state* test)
{
    static splat_scene s;
    const double radii[] = {0.0005, 0.004, 0.012, 0.03, 0.1, 0.4};
    for (int round = 0; round < 24; ++round) {
        bool parallel = round % 2 == 1;
        double distance = parallel || round % 3 != 0 ? 3.0 : 0.7;
        make_scene(&s, 50 + (uint64_t)round, radii[round / 4]);
        s.splats.shapes = s.shapes;
        place_camera(&s, 0.7 * round, distance, parallel ? 30.0 : 80.0, parallel, round % 5 == 4);
        int wrong = 0;
        for (uint32_t i = (uint32_t)round; i < SPLATS; i += 40) {
            wrong += count_wrong(&s, i);
        }
        CHECK_EQUAL(0, wrong);
    }
}

// Bits of splats whose ranges contain the level at their depth: each variant against double
// precision.
void test_splats_within_levels(test_state* test)
{
    static splat_scene s;
    for (int round = 0; round < 20; ++round) {
        make_scene(&s, 700 + (uint64_t)round, 0.01);
        bool parallel = round % 4 == 3;
        place_camera(&s, 0.4 * round, round % 3 == 0 ? 0.8 : 2.5, 60.0, parallel, false);
        stp_raster_levels levels = {.per_depth = (float)uniform(5, (uint64_t)round, 0.05, 0.6),
                                    .minimum = round % 2 == 0 ? 0.0f : 0.4f};
        uint16_t wanted[SPLATS / 16], bits[SPLATS / 16] = {0};
        for (int i = 0; i < SPLATS / 16; ++i) {
            wanted[i] = (uint16_t)stp_rng_hash(9, (uint64_t)i);
        }
        s.splats.begin = 16 * ((uint32_t)round % 5);
        s.splats.end = SPLATS - (uint32_t)round % 13;
        s.splats.wanted = round % 3 == 1 ? wanted : NULL;
        bool any = stp_raster_pick_levels(&s.camera, &s.splats, s.ranges, &levels, bits);
        int wrong = 0, count = 0;
        for (uint32_t i = s.splats.begin; i < s.splats.end; ++i) {
            double depth = (double)s.camera.matrix.m[3][3];
            for (uint32_t c = 0; c < 3; ++c) {
                depth += (double)s.camera.matrix.m[3][c] *
                         ((double)s.positions[3 * i + c] * (double)s.splats.step);
            }
            double level = fmax((double)levels.per_depth * depth, (double)levels.minimum);
            double low = (double)stp_range_level(s.ranges[i] & 0xFFFFu);
            double high = (double)stp_range_level(s.ranges[i] >> 16);
            bool expected = level >= low && level <= high &&
                            (s.splats.wanted == NULL || (wanted[i / 16] >> i % 16 & 1) != 0);
            bool edge = fabs(level - low) < 1e-5 * low || fabs(level - high) < 1e-5 * high;
            bool got = (bits[i / 16] >> i % 16 & 1) != 0;
            wrong += got != expected && !edge;
            count += got;
        }
        CHECK_EQUAL(0, wrong);
        CHECK_EQUAL(count > 0, any);
        CHECK(round % 3 == 1 || count > 0);
    }
}

// Culled groups face away, or lie outside the picture with all their disks.
void test_splats_that_groups_leave_out_cannot_be_seen(test_state* test)
{
    static splat_scene s;
    static stp_splat_group groups[(SPLATS + STP_GROUP_SPLATS - 1) / STP_GROUP_SPLATS];
    int dropped = 0, beside = 0;
    for (int round = 0; round < 60; ++round) {
        make_scene(&s, 1000 + (uint64_t)round, 0.01);
        for (uint32_t i = 0; i < SPLATS; ++i) { // patches of a sphere
            uint64_t patch = i / STP_GROUP_SPLATS + 10 * (uint64_t)round;
            double offset[3];
            for (uint64_t k = 0; k < 3; ++k) {
                offset[k] = uniform(31, 3 * patch + k, -1, 1) +
                            0.15 * uniform(32 + (uint64_t)round, 3 * (uint64_t)i + k, -1, 1);
            }
            stp_vec3 n =
                stp_normalize((stp_vec3){(float)offset[0], (float)offset[1], (float)offset[2]});
            const float parts[3] = {n.x, n.y, n.z};
            for (uint32_t k = 0; k < 3; ++k) {
                s.positions[3 * i + k] = (uint16_t)(32768.0 + 30000.0 * (double)parts[k]);
            }
            stp_octahedral_encode(n, s.normals + 2 * i);
        }
        bool parallel = round % 4 == 3;
        place_camera(&s, 0.4 * round, 0.4 + 0.1 * (round % 20), 60.0, parallel, round % 5 == 0);
        s.splats.shapes = s.shapes;
        for (uint32_t i = 0; i < SPLATS; ++i) { // the normals they represent face like their own
            s.shapes[i] = stp_shape_disk(stp_shape_radius(s.shapes[i] & 0xFFFu), 0, false);
        }
        stp_splats set = {.count = SPLATS,
                          .positions = s.positions,
                          .normals = s.normals,
                          .shapes = s.shapes,
                          .groups = groups};
        stp_store_make_groups(&set, 0, SPLATS);
        for (uint32_t i = 0; i < SPLATS; ++i) {
            s.ranges[i] = (uint32_t)STP_RANGE_ANY;
        }
        uint16_t bits[SPLATS / 16 + 1] = {0};
        stp_raster_levels levels = {.minimum = 0.1f,
                                    .groups = groups,
                                    .one_sided = round % 3 != 0,
                                    .width = WIDTH,
                                    .height = HEIGHT};
        (void)stp_raster_pick_levels(&s.camera, &s.splats, s.ranges, &levels, bits);
        for (uint32_t i = 0; i < SPLATS; ++i) {
            if ((bits[i / 16] >> i % 16 & 1) != 0) {
                continue;
            }
            dropped += 1;
            double center[3], towards = 0.0, nearness;
            (void)visit_object(&s, i, 0.0, 0.0, center, &nearness);
            stp_vec3 n = stp_octahedral_decode(s.normals[2 * i], s.normals[2 * i + 1]);
            for (int r = 0; r < 3; ++r) {
                double turned = 0.0;
                const float parts[3] = {n.x, n.y, n.z};
                for (int k = 0; k < 3; ++k) {
                    turned += (double)s.camera.view[r][k] * (double)parts[k];
                }
                towards += turned * (parallel ? (r == 2 ? 1.0 : 0.0) : center[r]);
            }
            uint64_t drawn = 0;
            clear(&s);
            s.splats.begin = i;
            s.splats.end = i + 1;
            drawn = stp_raster_draw_splats(&s.target, 0, HEIGHT, &s.camera, &s.splats, 0);
            s.splats.begin = 0;
            s.splats.end = SPLATS;
            beside += drawn == 0;
            CHECK(drawn == 0 || (levels.one_sided && towards >= 0.0));
        }
    }
    CHECK(dropped > 60 * SPLATS / 5 && beside > dropped / 10 && beside < dropped);
}

void test_splats_within_levels_by_all_variants(test_state* test)
{
    static splat_scene s;
    stp_processor processor = stp_processor_detect();
    for (int round = 0; round < 12; ++round) {
        make_scene(&s, 800 + (uint64_t)round, 0.01);
        place_camera(&s, 0.4 * round, 1.5, 60.0, round % 4 == 3, false);
        s.splats.end = SPLATS - (uint32_t)round;
        levels_frame frame = {.splats = &s.splats,
                              .ranges = s.ranges,
                              .levels = {.per_depth = 0.2f, .minimum = 0.1f * (float)(round % 3)}};
        stp_splats_fold_row(s.camera.matrix.m[3], &s.splats, frame.w);
        uint16_t expected[SPLATS / 16 + 1] = {0}, bits[SPLATS / 16 + 1] = {0};
        bool any = stp_splats_pick_portable(&frame, expected);
        if (processor >= STP_PROCESSOR_VECTOR) {
            CHECK_EQUAL(any, STP_VECTOR(stp_splats_pick)(&frame, bits));
            CHECK(memcmp(expected, bits, sizeof(bits)) == 0);
        }
        if (processor == STP_PROCESSOR_WIDE) {
            memset(bits, 0, sizeof(bits));
            CHECK_EQUAL(any, STP_WIDE(stp_splats_pick)(&frame, bits));
            CHECK(memcmp(expected, bits, sizeof(bits)) == 0);
        }
    }
}

static void draw_variant(splat_scene* s, splat_kernel kernel, uint64_t* hash, uint64_t* fragments)
{
    stp_splat_frame frame;
    clear(s);
    *fragments = 0;
    if (stp_splats_make_frame(&frame, &s->target, 0, HEIGHT, &s->camera, &s->splats, 0)) {
        *fragments = kernel(&frame);
    }
    *hash = 0;
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        *hash = stp_rng_hash(*hash, s->pixels[i]);
    }
}

void test_splats_variants_give_the_same_bits(test_state* test)
{
    static splat_scene s;
    stp_processor processor = stp_processor_detect();
    if (processor == STP_PROCESSOR_BASELINE) {
        SKIP("this processor has no vectors");
    }
    float growths[256];
    for (int i = 0; i < 256; ++i) {
        growths[i] = (float)(i % 9) * 0.5f - 0.75f;
    }
    for (int round = 0; round < 36; ++round) {
        double radius = 0.0004 * (double)(1u << (round % 9));
        make_scene(&s, 100 + (uint64_t)round, radius);
        s.splats.rim_depth = (float)(round % 3) * 2.0f;
        s.splats.back_depth = (float)(round % 2) * 1.5f;
        place_camera(&s, 0.3 * round, round % 3 == 0 ? 0.8 : 2.5, 60.0, round % 4 == 3,
                     round % 5 == 0);
        s.splats.coverages = round % 2 == 0 ? s.coverages : NULL;
        s.splats.normals = round % 7 == 6 ? NULL : s.normals;
        s.splats.shapes = round % 4 < 2 ? s.shapes : NULL;
        s.splats.materials = round % 4 == 2 ? s.coverages : NULL; // any bytes
        s.splats.growths = growths;
        s.splats.growth_share = 0.5f;
        s.splats.pixels = round % 6 == 5 ? 0.4f * (float)round : 0.0f;
        s.splats.begin = (uint32_t)round % 17;
        s.splats.end = SPLATS - (uint32_t)round % 13;
        s.target.width = round % 9 == 8 ? 5 : WIDTH; // narrower than a vector
        uint16_t wanted[SPLATS / 16 + 1];
        for (size_t i = 0; i < sizeof(wanted) / sizeof(wanted[0]); ++i) {
            uint64_t bits = stp_rng_hash((uint64_t)round, i);
            wanted[i] = i % 5 == 2 ? 0xFFFF : (uint16_t)(bits & bits >> 16);
        }
        s.splats.wanted = round % 3 == 2 ? wanted : NULL;
        s.splats.begin = s.splats.wanted != NULL ? 16 * (uint32_t)(round % 4) : s.splats.begin;
        uint64_t expected, hash, expected_fragments, fragments;
        draw_variant(&s, stp_splats_draw_portable, &expected, &expected_fragments);
        draw_variant(&s, STP_VECTOR(stp_splats_draw), &hash, &fragments);
        CHECK_EQUAL(expected, hash);
        CHECK_EQUAL(expected_fragments, fragments);
        if (processor == STP_PROCESSOR_WIDE) {
            draw_variant(&s, STP_WIDE(stp_splats_draw), &hash, &fragments);
            CHECK_EQUAL(expected, hash);
            CHECK_EQUAL(expected_fragments, fragments);
        }
    }
}

void test_splats_bands_and_ranges_join_without_a_seam(test_state* test)
{
    static splat_scene s;
    static uint64_t whole[WIDTH * HEIGHT];
    for (int round = 0; round < 12; ++round) {
        make_scene(&s, 300 + (uint64_t)round, 0.001 * (double)(1u << (round % 10)));
        place_camera(&s, 0.5 * round, round % 3 == 0 ? 0.8 : 2.5, 60.0, round % 4 == 3, false);
        s.splats.coverages = s.coverages;
        uint64_t fragments = stp_raster_draw_splats(&s.target, 0, HEIGHT, &s.camera, &s.splats, 5);
        memcpy(whole, s.pixels, sizeof(whole));
        clear(&s);
        uint64_t parts = 0;
        const uint32_t rows[] = {0, 1, 7, 40, 41, HEIGHT}, ranges[] = {0, 3, 200, SPLATS};
        for (int b = 0; b < 5; ++b) {
            for (int k = 0; k < 3; ++k) {
                stp_raster_splats part = s.splats;
                part.begin = ranges[k];
                part.end = ranges[k + 1];
                parts +=
                    stp_raster_draw_splats(&s.target, rows[b], rows[b + 1], &s.camera, &part, 5);
            }
        }
        CHECK_EQUAL(0, memcmp(whole, s.pixels, sizeof(whole)));
        CHECK_EQUAL(fragments, parts);
    }
}

void test_splats_coverage_is_the_share_of_fragments(test_state* test)
{
    static splat_scene s;
    const double levels[] = {0.0, 0.25, 0.5, 0.8, 1.0};
    const double radii[] = {0.0004, 0.02, 0.06};
    for (int k = 0; k < 3; ++k) {
        uint64_t full = 0;
        for (int level = 4; level >= 0; --level) {
            make_scene(&s, 9, radii[k]);
            place_camera(&s, 0.3, 3.0, 60.0, false, false);
            uint8_t code = stp_coverage_of_share(levels[level]);
            memset(s.coverages, code, sizeof(s.coverages));
            s.splats.coverages = s.coverages;
            uint64_t fragments =
                stp_raster_draw_splats(&s.target, 0, HEIGHT, &s.camera, &s.splats, 0);
            full = level == 4 ? fragments : full;
            double expected = (double)full * (double)stp_coverage_area(code);
            CHECK(fabs((double)fragments - expected) <=
                  3.0 * sqrt((double)full) * (level == 4 ? 0 : 1));
        }
    }
}

// Between two octaves, coverages are interpolated; splats beyond the lower octave have their own.
void test_splats_coverage_goes_from_octave_to_octave(test_state* test)
{
    static splat_scene s;
    static uint64_t blended[WIDTH * HEIGHT];
    static uint8_t low[SPLATS], between[SPLATS];
    const uint32_t shares[] = {0, 1, 100, 255, 256};
    for (int round = 0; round < 10; ++round) {
        uint32_t share = shares[round % 5], low_count = round < 5 ? SPLATS / 3 : SPLATS;
        make_scene(&s, 400 + (uint64_t)round, round < 5 ? 0.02 : 0.2);
        place_camera(&s, 0.5 * round, 2.5, 60.0, round % 4 == 3, false);
        for (uint32_t i = 0; i < SPLATS; ++i) {
            // a share and a clip: the hash selects one of both
            s.coverages[i] = (uint8_t)(s.coverages[i] % STP_COVERAGE_CHANCES);
            low[i] = (uint8_t)(STP_COVERAGE_HALVES + (s.coverages[i] * 7 + i) % 216);
            bool takes_low = i < low_count && (i * 0x9E3779B1u + 0x7F4A7C15u) >> 24 < share;
            between[i] = takes_low ? low[i] : s.coverages[i];
        }
        s.splats.coverages = s.coverages;
        s.splats.low_coverages = low;
        s.splats.low_count = low_count;
        s.splats.low_share = share;
        uint64_t fragments = stp_raster_draw_splats(&s.target, 0, HEIGHT, &s.camera, &s.splats, 5);
        memcpy(blended, s.pixels, sizeof(blended));
        clear(&s);
        s.splats.coverages = between;
        s.splats.low_coverages = NULL;
        s.splats.low_count = 0;
        CHECK_EQUAL(fragments,
                    stp_raster_draw_splats(&s.target, 0, HEIGHT, &s.camera, &s.splats, 5));
        CHECK(fragments > 100 && memcmp(blended, s.pixels, sizeof(blended)) == 0);
    }
}

static void find_columns(const splat_scene* s, int32_t* left, int32_t* right)
{
    *left = WIDTH;
    *right = -1;
    for (int32_t i = 0; i < WIDTH * HEIGHT; ++i) {
        if (s->pixels[i] != STP_RASTER_EMPTY) {
            *left = i % WIDTH < *left ? i % WIDTH : *left;
            *right = i % WIDTH > *right ? i % WIDTH : *right;
        }
    }
}

// Disks drawn by less than a quarter become smaller instead of thinner, but not smaller than a
// pixel.
void test_splats_of_which_little_is_drawn_are_smaller(test_state* test)
{
    static splat_scene s;
    const int levels[] = {2, 3, 5, 15, 21, 63}, halvings[] = {3, 3, 2, 2, 1, 1};
    const double focal = 40.0;
    for (int level = 0; level < 6; ++level) {
        double area = 0.0, drawn = 0.0, maximum = 0.0;
        make_scene(&s, 15, 8.0 / focal); // the view is twice as large: sixteen pixels
        place_camera(&s, 0.3, 4.0, focal, true, false);
        s.splats.normals = NULL;
        for (uint32_t i = 0; i < SPLATS; ++i) {
            clear(&s);
            memset(s.coverages, 255, sizeof(s.coverages));
            s.splats.coverages = s.coverages;
            s.splats.plain_coverages = true;
            s.splats.begin = i;
            s.splats.end = i + 1;
            uint64_t whole = stp_raster_draw_splats(&s.target, 0, HEIGHT, &s.camera, &s.splats, 0);
            int32_t left, right, inner_left, inner_right;
            find_columns(&s, &left, &right);
            if (left <= 0 || right >= WIDTH - 1 || right < left || whole < 795) {
                continue;
            }
            clear(&s);
            s.coverages[i] = (uint8_t)levels[level];
            area += (double)whole * levels[level] / 255.0;
            drawn += (double)stp_raster_draw_splats(&s.target, 0, HEIGHT, &s.camera, &s.splats, 0);
            find_columns(&s, &inner_left, &inner_right);
            double width = (double)(inner_right - inner_left + 1) / (right - left + 1);
            maximum = width > maximum ? width : maximum;
        }
        double size = 1.0 / (1 << halvings[level]);
        CHECK(area > 100.0 && fabs(drawn - area) < 0.05 * area);
        CHECK(maximum > 0.8 * size && maximum < 1.2 * size);
    }
}

void test_splats_keep_their_center_pixel(test_state* test)
{
    static splat_scene s;
    make_scene(&s, 77, 0.0);
    place_camera(&s, 0.9, 4.0, 40.0, false, false);
    for (uint32_t i = 0; i < SPLATS; ++i) {
        clear(&s);
        s.splats.begin = i;
        s.splats.end = i + 1;
        CHECK_EQUAL(1, stp_raster_draw_splats(&s.target, 0, HEIGHT, &s.camera, &s.splats, 0));
    }
    float points[3] = {0.5f, 0.5f, 0.5f}; // as floats, without normals
    stp_raster_splats one = {.points = points, .end = 1, .radius = 0.2f};
    clear(&s);
    CHECK(stp_raster_draw_splats(&s.target, 0, HEIGHT, &s.camera, &one, 3) > 9);
    CHECK_EQUAL(3, stp_raster_id(s.pixels[HEIGHT / 2 * WIDTH + WIDTH / 2]));
}

// Many disks one by one, at random positions and orientations: on average they cover as many pixels
// as their area. Nothing grows, but disks smaller than a pixel cover their centre's pixel.
void test_splats_cover_their_area(test_state* test)
{
    static splat_scene s;
    const double radii[] = {0.3, 0.6, 1.0, 2.3, 4.7};
    const double focal = 40.0;
    for (int k = 0; k < 5; ++k) {
        double area = 0.0, added = 0.0, covered = 0.0;
        for (uint64_t seed = 0; seed < 4; ++seed) {
            make_scene(&s, 100 * seed + 7, radii[k] / focal / 2.0); // the view is twice as large
            place_camera(&s, 0.3 + (double)seed, 4.0, focal / 2.0, true, false);
            s.splats.radius *= 2.0f;
            for (uint32_t i = 0; i < SPLATS; ++i) {
                s.splats.begin = i;
                s.splats.end = i + 1;
                covered +=
                    (double)stp_raster_draw_splats(&s.target, 0, HEIGHT, &s.camera, &s.splats, 0);
                double center[3], nearness, facing = 0.0, length = 0.0;
                double sx = 0.0, sy = 0.0;
                visit_object(&s, i, 0.0, 0.0, center, &nearness);
                sx = 0.5 * WIDTH + 0.5 * focal * center[0];
                sy = 0.5 * HEIGHT + 0.5 * focal * center[1];
                stp_vec3 n = stp_octahedral_decode(s.normals[2 * i], s.normals[2 * i + 1]);
                const double normal[3] = {(double)n.x, (double)n.y, (double)n.z};
                for (int a = 0; a < 3; ++a) {
                    double axis = (double)s.camera.view[2][a];
                    facing += axis * normal[a];
                    length += axis * axis;
                }
                area += STP_PI * radii[k] * radii[k] * fabs(facing) / sqrt(length);
                double distance =
                    visit_object(&s, i, floor(sx) + 0.5, floor(sy) + 0.5, center, &nearness);
                added += k == 0 && distance * 0.5 * focal > radii[k] ? 1.0 : 0.0;
            }
        }
        double share = (covered - added) / area;
        CHECK(fabs(share - 1.0) < (k == 0 ? 0.06 : 0.03));
    }
}

// A surface of many ordered candidates; its prefixes are drawn at the radius to which they cover.
typedef struct surface {
    uint32_t count;
    float positions[3 * 6000], normals[3 * 6000];
    uint16_t grid[3 * 6000];
    int8_t codes[2 * 6000];
    uint32_t order[6000];
    float radii[6000];
    float final_radius;
} surface;

static bool order_surface(surface* f)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_order_desc desc = {.metric = STP_METRIC_EUCLIDEAN};
    uint32_t ordered = 0;
    stp_result result = context == NULL ? STP_ERROR_OUT_OF_MEMORY
                                        : stp_order_points(context, &desc, f->positions, f->normals,
                                                           f->count, f->count, f->order, f->radii,
                                                           &ordered, &f->final_radius, NULL);
    for (uint32_t i = 0; i < ordered; ++i) {
        for (uint32_t k = 0; k < 3; ++k) {
            f->grid[3 * i + k] = (uint16_t)(f->positions[3 * f->order[i] + k] * 65536.0f + 0.5f);
        }
        const float* n = f->normals + 3 * (size_t)f->order[i];
        stp_octahedral_encode((stp_vec3){n[0], n[1], n[2]}, f->codes + 2 * (size_t)i);
    }
    f->count = ordered;
    stp_context_destroy(context);
    return result == STP_OK;
}

static void draw_prefix(splat_scene* s, const surface* f, uint32_t prefix, double candidate_radius)
{
    double covered = prefix < f->count ? (double)f->radii[prefix] : (double)f->final_radius;
    make_scene(s, 1, 0.0);
    s->splats.positions = f->grid;
    s->splats.normals = f->codes;
    s->splats.end = prefix;
    s->splats.radius = (float)(covered + candidate_radius);
}

void test_splats_cover_a_plane_without_holes(test_state* test)
{
    static surface f;
    static splat_scene s;
    const int side = 64;
    f.count = 0;
    for (int i = 0; i < side * side;
         ++i, ++f.count) { // the plane z = 0.5, jittered within its cells
        f.positions[3 * i] = (float)((i % side + uniform(5, (uint64_t)i, 0, 1)) / side);
        f.positions[3 * i + 1] = (float)((i / side + uniform(6, (uint64_t)i, 0, 1)) / side);
        f.positions[3 * i + 2] = 0.5f;
        f.normals[3 * i] = f.normals[3 * i + 1] = 0.0f;
        f.normals[3 * i + 2] = 1.0f;
    }
    CHECK(order_surface(&f));
    const uint32_t prefixes[] = {20, 90, 400, 1500, 4000};
    for (int round = 0; round < 15; ++round) {
        draw_prefix(&s, &f, prefixes[round % 5], sqrt(2.0) / side);
        place_camera(&s, 0.25 * round, 2.0 + round, 70.0, round % 2 == 1, false);
        stp_raster_draw_splats(&s.target, 0, HEIGHT, &s.camera, &s.splats, 0);
        // the plane itself, as one splat with the largest extent: pixels that meet it inside the
        // square
        for (uint32_t at = 0; at < WIDTH * HEIGHT; ++at) {
            double center[3], nearness = 0.0, x = at % WIDTH + 0.5, y = at / WIDTH + 0.5;
            if (visit_object(&s, 0, x, y, center, &nearness) == HUGE_VAL ||
                s.pixels[at] != STP_RASTER_EMPTY) {
                continue;
            }
            // an empty pixel must not see the square: four corners, all on one side of some edge
            double corner[4][2];
            for (int c = 0; c < 4; ++c) {
                double p[4] = {c == 1 || c == 2 ? 1.0 : 0.0, c >= 2 ? 1.0 : 0.0, 0.5, 1.0},
                       q[3] = {0};
                const int rows[3] = {0, 1, 3};
                for (int r = 0; r < 3; ++r) {
                    for (int k = 0; k < 4; ++k) {
                        q[r] += (double)s.camera.matrix.m[rows[r]][k] * p[k];
                    }
                }
                corner[c][0] = q[0] / q[2];
                corner[c][1] = q[1] / q[2];
            }
            int sides[2] = {0, 0};
            for (int c = 0; c < 4; ++c) {
                const double *a = corner[c], *b = corner[(c + 1) % 4];
                double cross = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
                sides[cross > 0.0] += 1;
            }
            CHECK(sides[0] > 0 && sides[1] > 0);
        }
    }
}

void test_splats_cover_a_sphere_without_holes(test_state* test)
{
    static surface f;
    static splat_scene s;
    f.count = 6000;
    for (uint32_t i = 0; i < f.count; ++i) { // a spiral from pole to pole
        double z = 1.0 - (2.0 * i + 1.0) / f.count, angle = 2.399963229728653 * i,
               r = sqrt(1.0 - z * z);
        const double n[3] = {r * cos(angle), r * sin(angle), z};
        for (uint32_t k = 0; k < 3; ++k) {
            f.normals[3 * i + k] = (float)n[k];
            f.positions[3 * i + k] = (float)(0.5 + 0.4 * n[k]);
        }
    }
    CHECK(order_surface(&f));
    const double candidate_radius = 0.4 * 1.1 * sqrt(4.0 * STP_PI / 6000.0);
    for (int round = 0; round < 12; ++round) {
        draw_prefix(&s, &f, round % 2 == 0 ? 1200 : 5000, candidate_radius);
        double distance = 1.6 + 0.7 * round;
        place_camera(&s, 0.6 * round, distance, 60.0, false, false);
        stp_raster_draw_splats(&s.target, 0, HEIGHT, &s.camera, &s.splats, 0);
        for (uint32_t at = 0; at < WIDTH * HEIGHT; ++at) {
            double u = (at % WIDTH + 0.5 - 0.5 * WIDTH) / 60.0,
                   v = (at / WIDTH + 0.5 - 0.5 * HEIGHT) / 60.0;
            // distance of the ray from the centre; the view is twice as large as the sphere's space
            double square = distance * distance * (1.0 - 1.0 / (1.0 + u * u + v * v));
            if (square < 0.795 * 0.795) {
                CHECK(s.pixels[at] != STP_RASTER_EMPTY);
                CHECK((double)stp_raster_nearness(s.pixels[at]) >
                      0.05 / distance * 0.98); // the front
            } else if (square > pow(0.8 + 2.1 * (double)s.splats.radius + distance / 60.0, 2.0)) {
                CHECK(s.pixels[at] == STP_RASTER_EMPTY);
            }
        }
    }
}

// Two disks facing the eye, one slightly nearer, half a radius apart; counts which of them each
// pixel shows.
static int count_of_second(splat_scene* s, float rim, float back, bool away)
{
    make_scene(s, 1, 0.2);
    place_camera(s, 0.0, 6.0, 150.0, true, false);
    static const uint16_t positions[6] = {26000, 32768, 32768, 39000, 32768, 32768};
    memcpy(s->positions, positions, sizeof(positions));
    const float* gaze = s->camera.view[2];
    stp_vec3 normal = {-gaze[0], -gaze[1], -gaze[2]}, other = {gaze[0], gaze[1], gaze[2]};
    stp_octahedral_encode(normal, s->normals);
    stp_octahedral_encode(away ? other : normal, s->normals + 2);
    // the second is nearer, by a tenth of a radius
    for (int k = 0; k < 3; ++k) {
        s->positions[3 + k] = (uint16_t)((float)s->positions[3 + k] - gaze[k] * 0.005f * 65536.0f);
    }
    s->splats.end = 2;
    s->splats.rim_depth = rim;
    s->splats.back_depth = back;
    clear(s);
    stp_raster_draw_splats(&s->target, 0, HEIGHT, &s->camera, &s->splats, 0);
    int count = 0;
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        count += s->pixels[i] != STP_RASTER_EMPTY && stp_raster_id(s->pixels[i]) == 1;
    }
    return count;
}

void test_splats_that_overlap_share_the_ground(test_state* test)
{
    static splat_scene s;
    int plain = count_of_second(&s, 0.0f, 0.0f, false); // the nearer one takes all it covers
    int shared = count_of_second(&s, 4.0f, 0.0f, false);
    CHECK(plain > 200);
    CHECK(shared < plain * 95 / 100 && shared > plain * 60 / 100);
    CHECK_EQUAL(plain, count_of_second(&s, 0.0f, 0.0f, true)); // sides do not matter unless asked
    int behind = count_of_second(&s, 0.0f, 2.0f, true);
    CHECK(behind < plain * 80 / 100 && behind > 0); // it remains only where no disk faces the eye
    CHECK_EQUAL(plain, count_of_second(&s, 0.0f, 2.0f, false));
}

// Draws with one of the kernels.
static uint64_t draw_by(splat_scene* s, splat_kernel kernel, uint32_t first_id)
{
    stp_splat_frame frame;
    bool any =
        stp_splats_make_frame(&frame, &s->target, 0, HEIGHT, &s->camera, &s->splats, first_id);
    return any ? kernel(&frame) : 0;
}

// A depth range keeps splats whose centres are within it, and pixel radii apply at a splat's own
// depth.
void test_splats_within_depths_are_as_each_alone(test_state* test)
{
    static splat_scene s;
    static uint64_t whole[WIDTH * HEIGHT];
    const splat_kernel kernels[] = {stp_splats_draw_portable, STP_VECTOR(stp_splats_draw),
                                    STP_WIDE(stp_splats_draw)};
    int count = 1 + (int)stp_processor_detect(); // as many as this processor has
    for (int round = 0; round < 24; ++round) {
        make_scene(&s, 900 + (uint64_t)round, 0.001 * (double)(1u << (round % 8)));
        bool parallel = round % 6 == 5;
        place_camera(&s, 0.4 * round, round % 4 == 0 ? 0.8 : 2.5, 60.0, parallel, false);
        s.splats.coverages = round % 2 == 0 ? s.coverages : NULL;
        float nearest = (float)uniform(77, (uint64_t)round, 0.2, 2.5), farthest = nearest + 0.8f;
        for (int k = 0; k < count; ++k) {
            s.splats.begin = 0;
            s.splats.end = SPLATS;
            s.splats.nearest = nearest;
            s.splats.farthest = farthest;
            clear(&s);
            draw_by(&s, kernels[k], 3);
            memcpy(whole, s.pixels, sizeof(whole));
            clear(&s);
            for (uint32_t i = 0; i < SPLATS; ++i) {
                double depth = (double)s.camera.matrix.m[3][3];
                for (uint32_t c = 0; c < 3; ++c) {
                    depth += (double)s.camera.matrix.m[3][c] *
                             ((double)s.positions[3 * i + c] * (double)s.splats.step);
                }
                s.splats.begin = i;
                s.splats.end = i + 1;
                s.splats.nearest = s.splats.farthest = 0.0f;
                if (depth >= (double)nearest && depth <= (double)farthest) {
                    draw_by(&s, kernels[k], 3);
                }
            }
            int different = 0;
            for (int i = 0; i < WIDTH * HEIGHT; ++i) {
                different += stp_raster_id(whole[i]) != stp_raster_id(s.pixels[i]);
            }
            CHECK_EQUAL(0, different);
        }
    }
}
