// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/core/arena.h"
#include "base/core/processor.h"
#include "base/math/rng.h"
#include "raster/triangles.h"
#include "raster/triangles_internal.h"

#include <string.h>

enum { WIDTH = 96, HEIGHT = 80, PIXELS = WIDTH * HEIGHT };

/// A number in [low, high); deterministic in seed and index.
static float number(uint64_t seed, uint64_t index, float low, float high)
{
    float unit = (float)(stp_rng_hash(seed, index) >> 40) / 16777216.0f;
    return low + (high - low) * unit;
}

static stp_raster_matrix parallel_matrix(void)
{
    return (stp_raster_matrix){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
}

/// The eye at the origin looks along z; x and y are pixels at z = 1.
static stp_raster_matrix perspective_matrix(float scale)
{
    return (stp_raster_matrix){
        {{scale, 0, WIDTH / 2.0f, 0}, {0, scale, HEIGHT / 2.0f, 0}, {0, 0, 0, 0.1f}, {0, 0, 1, 0}}};
}

static void clear(uint64_t* pixels)
{
    memset(pixels, 0xFF, PIXELS * sizeof(*pixels));
}

/// Draws soup or mesh; true on success.
static bool draw(uint64_t* pixels, const stp_raster_matrix* matrix, float limit,
                 const stp_raster_mesh* mesh)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_arena scratch = stp_arena_create(context, 4096);
    stp_raster_target target = {WIDTH, HEIGHT, WIDTH, pixels};
    stp_result result = stp_raster_triangles(&target, 0, HEIGHT, matrix, limit, mesh, 0, &scratch);
    stp_arena_destroy(&scratch);
    stp_context_destroy(context);
    return result == STP_OK;
}

/// Whether a pixel's centre is in a triangle of grid coordinates, by definition.
static bool reference_covers(const int64_t v[3][2], int64_t x, int64_t y)
{
    int64_t cx = x * 256 + 128, cy = y * 256 + 128;
    int64_t area =
        (v[1][0] - v[0][0]) * (v[2][1] - v[0][1]) - (v[1][1] - v[0][1]) * (v[2][0] - v[0][0]);
    if (area == 0) {
        return false;
    }
    for (int k = 0; k < 3; ++k) {
        const int64_t* a = v[area > 0 ? k : (k + 1) % 3];
        const int64_t* b = v[area > 0 ? (k + 1) % 3 : k];
        int64_t dx = b[0] - a[0], dy = b[1] - a[1];
        int64_t e = dx * (cy - a[1]) - dy * (cx - a[0]);
        bool top_left = dy < 0 || (dy == 0 && dx > 0);
        if (e < 0 || (e == 0 && !top_left)) {
            return false;
        }
    }
    return true;
}

/// Corners of a random triangle of about `size` pixels, now and then off the picture or on pixel
/// centres.
static void random_triangle(uint64_t seed, uint64_t t, float size, float out[9])
{
    float x = number(seed, t * 16, -20.0f, WIDTH + 20.0f),
          y = number(seed, t * 16 + 1, -20.0f, HEIGHT + 20.0f);
    for (uint64_t k = 0; k < 3; ++k) {
        out[3 * k] = x + number(seed, t * 16 + 2 + k, -size, size);
        out[3 * k + 1] = y + number(seed, t * 16 + 5 + k, -size, size);
        out[3 * k + 2] = number(seed, t * 16 + 8 + k, 0.1f, 1.0f);
        if (t % 3 == 0) { // on the half-pixel grid: edges meet centres
            out[3 * k] = (float)(int)(out[3 * k] * 2.0f) / 2.0f;
            out[3 * k + 1] = (float)(int)(out[3 * k + 1] * 2.0f) / 2.0f;
        }
    }
}

void test_triangles_match_reference(test_state* test)
{
    static const float sizes[] = {0.3f, 1.0f, 2.0f, 5.0f, 40.0f, 300.0f, 30000.0f};
    static uint64_t pixels[PIXELS];
    for (size_t s = 0; s < sizeof(sizes) / sizeof(sizes[0]); ++s) {
        for (uint64_t t = 0; t < 60; ++t) {
            float corners[9];
            random_triangle(s, t, sizes[s], corners);
            static const uint32_t indices[3] = {0, 1, 2};
            uint64_t fragments = 0, covered = 0;
            stp_raster_mesh mesh = {corners, 3,    indices,    1,    NULL, {0},
                                    NULL,    NULL, &fragments, NULL, 0,    0};
            stp_raster_matrix matrix = parallel_matrix();
            clear(pixels);
            CHECK(draw(pixels, &matrix, INFINITY, &mesh));
            for (int i = 0; i < PIXELS; ++i) {
                covered += pixels[i] != STP_RASTER_EMPTY;
            }
            CHECK_EQUAL(covered, fragments);
            int64_t v[3][2];
            double n[3];
            for (int k = 0; k < 3; ++k) {
                v[k][0] = (int64_t)lrintf(corners[3 * k] * 256.0f);
                v[k][1] = (int64_t)lrintf(corners[3 * k + 1] * 256.0f);
                n[k] = (double)corners[3 * k + 2];
            }
            double area = (double)((v[1][0] - v[0][0]) * (v[2][1] - v[0][1]) -
                                   (v[1][1] - v[0][1]) * (v[2][0] - v[0][0]));
            for (int64_t i = 0; i < PIXELS; ++i) {
                int64_t x = i % WIDTH, y = i / WIDTH;
                CHECK_EQUAL(reference_covers((const int64_t(*)[2])v, x, y),
                            pixels[i] != STP_RASTER_EMPTY);
                if (pixels[i] == STP_RASTER_EMPTY) {
                    continue;
                }
                CHECK_EQUAL(0, stp_raster_id(pixels[i]));
                double cx = (double)(x * 256 + 128), cy = (double)(y * 256 + 128);
                double w1 = ((double)(v[0][0] - v[2][0]) * (cy - (double)v[2][1]) -
                             (double)(v[0][1] - v[2][1]) * (cx - (double)v[2][0])) /
                            area;
                double w2 = ((double)(v[1][0] - v[0][0]) * (cy - (double)v[0][1]) -
                             (double)(v[1][1] - v[0][1]) * (cx - (double)v[0][0])) /
                            area;
                double wanted = n[0] + w1 * (n[1] - n[0]) + w2 * (n[2] - n[0]);
                CHECK(fabs((double)stp_raster_nearness(pixels[i]) - wanted) < 1e-5);
            }
        }
    }
}

/// A grid of jittered vertices that covers the whole picture, each quad cut along a random
/// diagonal, some triangles turned around.
typedef struct test_grid {
    float positions[33 * 33 * 3];
    uint32_t indices[32 * 32 * 6];
} test_grid;

static void make_grid(test_grid* grid, uint64_t seed, float depth)
{
    for (uint64_t i = 0; i < 33 * 33; ++i) {
        uint64_t x = i % 33, y = i / 33;
        float* p = grid->positions + 3 * i;
        bool rim = x == 0 || y == 0 || x == 32 || y == 32;
        float jitter = rim ? 0.0f : 0.6f;
        p[0] = ((float)x / 32.0f * 1.2f - 0.1f) * WIDTH + number(seed, 2 * i, -jitter, jitter);
        p[1] = ((float)y / 32.0f * 1.2f - 0.1f) * HEIGHT + number(seed, 2 * i + 1, -jitter, jitter);
        p[2] = depth;
    }
    for (uint32_t q = 0; q < 32 * 32; ++q) {
        uint32_t a = q / 32 * 33 + q % 32, b = a + 1, c = a + 33, d = a + 34;
        bool cut = stp_rng_hash(seed + 1, q) % 2 == 0, turn = stp_rng_hash(seed + 2, q) % 2 == 0;
        uint32_t* i = grid->indices + 6 * (size_t)q;
        uint32_t first[6] = {a, b, c, b, d, c}, second[6] = {a, b, d, a, d, c};
        memcpy(i, cut ? first : second, sizeof(first));
        if (turn) {
            i[0] = (cut ? first : second)[1];
            i[1] = (cut ? first : second)[0];
        }
    }
}

static bool count_fragment(const void* user, uint32_t triangle, float weight1, float weight2,
                           uint32_t x, uint32_t y)
{
    (void)triangle;
    (void)weight1;
    (void)weight2;
    uint32_t* const* counts = user;
    (*counts)[y * WIDTH + x] += 1;
    return false; // nothing is drawn, so all fragments are seen
}

void test_triangles_are_watertight(test_state* test)
{
    static test_grid grid;
    static uint64_t pixels[PIXELS];
    static uint32_t counts[PIXELS];
    uint32_t* counted = counts;
    for (uint64_t seed = 0; seed < 8; ++seed) {
        make_grid(&grid, seed * 16, 0.5f);
        memset(counts, 0, sizeof(counts));
        clear(pixels);
        stp_raster_mesh mesh = {grid.positions, 33 * 33,  grid.indices, 2048, NULL, {0},
                                count_fragment, &counted, NULL,         NULL, 0,    0};
        stp_raster_matrix matrix = parallel_matrix();
        CHECK(draw(pixels, &matrix, INFINITY, &mesh));
        mesh.keep = NULL;
        CHECK(draw(pixels, &matrix, INFINITY, &mesh));
        for (int i = 0; i < PIXELS; ++i) {
            CHECK(pixels[i] != STP_RASTER_EMPTY);
            CHECK_EQUAL(1, counts[i]); // at this jitter no triangle folds over
        }
    }
}

/// A floor from far behind the eye to the horizon, as one mesh: clipping must not open its edges.
void test_triangles_clipped_at_the_near_plane_have_no_cracks(test_state* test)
{
    static test_grid grid;
    static uint64_t pixels[PIXELS];
    for (uint64_t seed = 0; seed < 8; ++seed) {
        make_grid(&grid, seed, 0.0f);
        for (int i = 0; i < 33 * 33; ++i) {
            float* p = grid.positions + 3 * i;
            float x = (p[0] / WIDTH - 0.5f) * 1e4f, z = (p[1] / HEIGHT - 0.5f) * 1e4f;
            p[0] = x;
            p[1] = 1.0f;
            p[2] = z;
        }
        stp_raster_mesh mesh = {grid.positions, 33 * 33, grid.indices, 2048, NULL, {0},
                                NULL,           NULL,    NULL,         NULL, 0,    0};
        stp_raster_matrix matrix = perspective_matrix(60.0f);
        clear(pixels);
        CHECK(draw(pixels, &matrix, 0.1f / 0.2f, &mesh));
        for (int i = 0; i < PIXELS; ++i) {
            // the floor at z is drawn in row 40 + 60 / z: all rows below the horizon, where z <
            // 5000
            bool floor = i / WIDTH > HEIGHT / 2 + 1;
            CHECK(!floor || pixels[i] != STP_RASTER_EMPTY);
            CHECK(i / WIDTH >= HEIGHT / 2 || pixels[i] == STP_RASTER_EMPTY);
            if (pixels[i] != STP_RASTER_EMPTY) {
                float z = 0.1f / stp_raster_nearness(pixels[i]);
                float expected = 60.0f / ((float)(i / WIDTH) + 0.5f - HEIGHT / 2.0f);
                CHECK(fabsf(z / expected - 1.0f) < 0.02f);
                CHECK(z > 0.199f);
            }
        }
    }
}

void test_triangles_survive_anything(test_state* test)
{
    static const float odd[] = {0.0f,   1e38f, -1e38f, NAN,   INFINITY, -INFINITY,
                                1e-38f, 1e9f,  -1e9f,  40.0f, 3e5f};
    static uint64_t pixels[PIXELS];
    enum { COUNT = 512 };
    static float positions[COUNT * 9];
    static uint32_t indices[COUNT * 3];
    for (uint64_t seed = 0; seed < 8; ++seed) {
        for (uint32_t i = 0; i < COUNT * 9; ++i) {
            uint64_t r = stp_rng_hash(seed, i);
            positions[i] = r % 4 == 0 ? odd[r / 4 % (sizeof(odd) / sizeof(odd[0]))]
                                      : number(seed, i, -1000.0f, 1000.0f);
            indices[i / 3] = i / 3;
        }
        stp_raster_mesh mesh = {positions, COUNT * 3, indices, COUNT, NULL, {0},
                                NULL,      NULL,      NULL,    NULL,  0,    0};
        stp_raster_matrix matrices[2] = {parallel_matrix(), perspective_matrix(100.0f)};
        for (int m = 0; m < 2; ++m) {
            static const float limits[] = {INFINITY, 1.0f, 1e-3f};
            for (int l = 0; l < 3; ++l) {
                clear(pixels);
                CHECK(draw(pixels, &matrices[m], limits[l], &mesh));
                for (int i = 0; i < PIXELS; ++i) {
                    if (pixels[i] != STP_RASTER_EMPTY) {
                        CHECK(stp_raster_id(pixels[i]) < COUNT);
                        CHECK(stp_raster_nearness(pixels[i]) > 0.0f);
                        CHECK(stp_raster_nearness(pixels[i]) <= limits[l]);
                    }
                }
            }
        }
    }
}

/// One large triangle that reaches far beyond the guard band covers what its half planes say.
void test_triangles_huge_fill_the_picture(test_state* test)
{
    static uint64_t pixels[PIXELS];
    static const float corners[9] = {-3e7f, -3e7f, 0.5f, 9e7f, -3e7f, 0.5f, -3e7f, 9e7f, 0.5f};
    static const uint32_t indices[3] = {0, 1, 2};
    stp_raster_mesh mesh = {corners, 3, indices, 1, NULL, {0}, NULL, NULL, NULL, NULL, 0, 0};
    stp_raster_matrix matrix = parallel_matrix();
    clear(pixels);
    CHECK(draw(pixels, &matrix, 1.0f, &mesh));
    for (int i = 0; i < PIXELS; ++i) {
        CHECK(pixels[i] != STP_RASTER_EMPTY);
        CHECK(fabsf(stp_raster_nearness(pixels[i]) - 0.5f) < 1e-6f);
    }
}

static void draw_variant(const stp_triangle_kernels* kernels, uint64_t* pixels, size_t behind,
                         const float* positions, uint32_t triangle_count,
                         const stp_raster_matrix* matrix)
{
    enum { MOST = 300 };
    static int32_t x[3 * MOST + STP_LANES_MAX], y[3 * MOST + STP_LANES_MAX];
    static float nearness[3 * MOST + STP_LANES_MAX];
    static uint32_t indices[3 * MOST], clipped[MOST];
    uint64_t fragments = 0;
    stp_triangle_transform transform = {.nearness_limit = 2.0f};
    memcpy(transform.matrix, matrix->m, sizeof(transform.matrix));
    for (uint32_t i = 0; i < 3 * triangle_count; ++i) {
        indices[i] = i;
    }
    kernels->transform(&transform, positions, 3 * (size_t)triangle_count, x, y, nearness);
    stp_triangle_chunk chunk = {
        .window = {.pixels = pixels,
                   .stride = WIDTH,
                   .width = WIDTH,
                   .row_end = HEIGHT,
                   .behind = behind,
                   .fragments = &fragments},
        .indices = indices,
        .triangle_count = triangle_count,
        .x = x,
        .y = y,
        .nearness = nearness,
        .clipped = clipped,
    };
    kernels->draw_chunk(&chunk);
    for (uint32_t i = 0; i < chunk.clipped_count; ++i) { // records what was handed back
        pixels[i] ^= clipped[i] + 1;
    }
}

void test_triangles_variants_give_the_same_bits(test_state* test)
{
    static uint64_t wanted[2 * PIXELS], got[2 * PIXELS]; // from the front and from behind
    static float positions[300 * 9];
    static const float sizes[] = {0.7f, 2.0f, 6.0f, 60.0f, 600.0f};
    const stp_triangle_kernels* variants[2] = {NULL, NULL};
    stp_processor processor = stp_processor_detect();
    variants[0] = processor >= STP_PROCESSOR_VECTOR ? &STP_VECTOR(stp_triangle_kernels) : NULL;
    variants[1] = processor >= STP_PROCESSOR_WIDE ? &STP_WIDE(stp_triangle_kernels) : NULL;
    if (variants[0] == NULL) {
        SKIP("this processor runs the portable variant only");
    }
    for (uint32_t s = 0; s < 5; ++s) {
        for (uint32_t count = 1; count <= 300; count = count < 40 ? count + 1 : count + 65) {
            for (uint64_t t = 0; t < count; ++t) {
                random_triangle(s + 100, t, sizes[s], positions + 9 * t);
            }
            positions[4] = s == 3 ? NAN : positions[4];
            stp_raster_matrix matrix = parallel_matrix();
            matrix.m[3][2] = s == 4 ? 0.7f : 0.0f; // some perspective
            memset(wanted, 0xFF, sizeof(wanted));
            draw_variant(&stp_triangle_kernels_portable, wanted, PIXELS, positions, count, &matrix);
            for (int v = 0; v < 2; ++v) {
                if (variants[v] != NULL) {
                    memset(got, 0xFF, sizeof(got));
                    draw_variant(variants[v], got, PIXELS, positions, count, &matrix);
                    CHECK(memcmp(wanted, got, sizeof(got)) == 0);
                    clear(got);
                    draw_variant(variants[v], got, 0, positions, count, &matrix);
                    CHECK(memcmp(wanted, got, sizeof(got) / 2) == 0);
                }
            }
        }
    }
}

// Seen from behind, what is far is near.
void test_triangles_from_behind_are_those_of_the_other_side(test_state* test)
{
    enum { COUNT = 400 };
    static uint64_t both[2 * PIXELS], front[PIXELS], back[PIXELS];
    static float positions[COUNT * 9];
    static uint32_t indices[3 * COUNT];
    static const float sizes[] = {0.7f, 2.0f, 6.0f, 60.0f, 600.0f};
    for (uint32_t i = 0; i < 3 * COUNT; ++i) {
        indices[i] = i;
    }
    for (uint64_t t = 0; t < COUNT; ++t) {
        random_triangle(7, t, sizes[t % 5], positions + 9 * t);
    }
    stp_raster_mesh mesh = {.positions = positions,
                            .vertex_count = 3 * COUNT,
                            .indices = indices,
                            .triangle_count = COUNT};
    stp_raster_matrix matrix = parallel_matrix(), turned = parallel_matrix();
    turned.m[2][2] = -1.0f;
    turned.m[2][3] = 1.5f;
    clear(front);
    clear(back);
    memset(both, 0xFF, sizeof(both));
    CHECK(draw(front, &matrix, INFINITY, &mesh) && draw(back, &turned, INFINITY, &mesh));
    mesh.behind = PIXELS;
    CHECK(draw(both, &matrix, INFINITY, &mesh));
    CHECK(memcmp(both, front, sizeof(front)) == 0);
    int differing = 0;
    for (size_t i = 0; i < PIXELS; ++i) {
        uint64_t pixel = both[PIXELS + i];
        CHECK((pixel == STP_RASTER_EMPTY) == (back[i] == STP_RASTER_EMPTY));
        differing += stp_raster_id(pixel) != stp_raster_id(back[i]) ? 1 : 0;
        CHECK(pixel == STP_RASTER_EMPTY || fabsf(stp_raster_nearness(pixel ^ UINT64_MAX << 32) +
                                                 stp_raster_nearness(back[i]) - 1.5f) < 1e-4f);
    }
    CHECK(differing < PIXELS / 100); // rounding
}

void test_triangles_in_bands_give_the_same_picture(test_state* test)
{
    static test_grid grid;
    static uint64_t whole[PIXELS], banded[PIXELS];
    make_grid(&grid, 5, 0.3f);
    for (int i = 0; i < 33 * 33; ++i) {
        grid.positions[3 * i + 2] = number(9, (uint64_t)i, 0.1f, 0.9f);
    }
    stp_raster_mesh mesh = {grid.positions, 33 * 33, grid.indices, 2048, NULL, {0},
                            NULL,           NULL,    NULL,         NULL, 0,    0};
    stp_raster_matrix matrix = parallel_matrix();
    clear(whole);
    clear(banded);
    CHECK(draw(whole, &matrix, 2.0f, &mesh));
    stp_context* context = test_context(NULL, 1, NULL);
    stp_arena scratch = stp_arena_create(context, 4096);
    stp_raster_target target = {WIDTH, HEIGHT, WIDTH, banded};
    for (uint32_t row = 0; row < HEIGHT; row += 7) {
        CHECK_EQUAL(STP_OK,
                    stp_raster_triangles(&target, row, row + 7, &matrix, 2.0f, &mesh, 0, &scratch));
    }
    CHECK(memcmp(whole, banded, sizeof(whole)) == 0);
    clear(banded);
    for (uint32_t row = 0; row < HEIGHT; row += 20) {
        stp_raster_target band = {WIDTH, 20, WIDTH, banded + (size_t)row * WIDTH};
        CHECK_EQUAL(STP_OK,
                    stp_raster_triangles_in_band(&band, row, &matrix, 2.0f, &mesh, 0, &scratch));
    }
    CHECK(memcmp(whole, banded, sizeof(whole)) == 0);
    stp_arena_destroy(&scratch);
    stp_context_destroy(context);
}

/// Indices that span a large mesh take the path without shared vertices: same picture.
void test_triangles_in_any_order_give_the_same_picture(test_state* test)
{
    static test_grid grid;
    static uint64_t wanted[PIXELS], got[PIXELS];
    enum { VERTICES = 200000 };
    make_grid(&grid, 11, 0.4f);
    stp_raster_mesh mesh = {grid.positions, 33 * 33, grid.indices, 2048, NULL, {0},
                            NULL,           NULL,    NULL,         NULL, 0,    0};
    stp_raster_matrix matrix = parallel_matrix();
    clear(wanted);
    CHECK(draw(wanted, &matrix, 2.0f, &mesh));
    float* spread = calloc(VERTICES, 3 * sizeof(float));
    CHECK(spread != NULL);
    static uint32_t indices[2048 * 3];
    for (uint32_t i = 0; i < 2048 * 3; ++i) {
        uint32_t place = grid.indices[i] * 181;
        memcpy(spread + 3 * (size_t)place, grid.positions + 3 * (size_t)grid.indices[i],
               3 * sizeof(float));
        indices[i] = place;
    }
    mesh =
        (stp_raster_mesh){spread, VERTICES, indices, 2048, NULL, {0}, NULL, NULL, NULL, NULL, 0, 0};
    clear(got);
    bool drawn = draw(got, &matrix, 2.0f, &mesh);
    free(spread);
    CHECK(drawn);
    CHECK(memcmp(wanted, got, sizeof(got)) == 0);
}

static bool keep_near_corner1(const void* user, uint32_t triangle, float weight1, float weight2,
                              uint32_t x, uint32_t y)
{
    (void)user;
    (void)triangle;
    (void)weight2;
    (void)x;
    (void)y;
    return weight1 > 0.5f;
}

void test_triangles_keep_asks_with_perspective_weights(test_state* test)
{
    static uint64_t pixels[PIXELS];
    // a floor triangle; half the way along an edge in space is not half the way on the screen
    static const float corners[9] = {-4, 1, 2, 4, 1, 10, 4, 1, 2};
    static const uint32_t indices[3] = {0, 1, 2};
    stp_raster_mesh mesh = {corners,           3,    indices, 1,    NULL, {0},
                            keep_near_corner1, NULL, NULL,    NULL, 0,    0};
    stp_raster_matrix matrix = perspective_matrix(40.0f);
    clear(pixels);
    CHECK(draw(pixels, &matrix, INFINITY, &mesh));
    int kept = 0;
    for (int i = 0; i < PIXELS; ++i) {
        if (pixels[i] != STP_RASTER_EMPTY) { // weight 1 is above a half where z is beyond 6
            kept += 1;
            CHECK(0.1f / stp_raster_nearness(pixels[i]) > 5.8f);
        }
    }
    CHECK(kept > 20);
}

void test_triangles_offset_keeps_precision(test_state* test)
{
    static uint64_t near_pixels[PIXELS], far_pixels[PIXELS];
    float near_corners[9] = {10.25f, 10.5f, 0.5f, 80.75f, 20.0f, 0.5f, 30.0f, 70.25f, 0.5f},
          far_corners[9];
    for (int i = 0; i < 9; ++i) {
        far_corners[i] = near_corners[i] + (i % 3 == 2 ? 0.0f : 1048576.0f);
    }
    static const uint32_t indices[3] = {0, 1, 2};
    stp_raster_matrix matrix = parallel_matrix();
    stp_raster_mesh mesh = {near_corners, 3, indices, 1, NULL, {0}, NULL, NULL, NULL, NULL, 0, 0};
    clear(near_pixels);
    CHECK(draw(near_pixels, &matrix, 1.0f, &mesh));
    mesh = (stp_raster_mesh){far_corners, 3,    indices, 1,    NULL, {1048576.0f, 1048576.0f, 0},
                             NULL,        NULL, NULL,    NULL, 0,    0};
    clear(far_pixels);
    CHECK(draw(far_pixels, &matrix, 1.0f, &mesh));
    CHECK(memcmp(near_pixels, far_pixels, sizeof(near_pixels)) == 0);
}

void test_triangles_survive_failing_allocator(test_state* test)
{
    static test_grid grid;
    static uint64_t pixels[PIXELS];
    make_grid(&grid, 3, 0.5f);
    for (int n = 0;; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        if (context == NULL) {
            continue;
        }
        stp_arena scratch = stp_arena_create(context, 64);
        stp_raster_target target = {WIDTH, HEIGHT, WIDTH, pixels};
        stp_raster_mesh mesh = {grid.positions, 33 * 33, grid.indices, 2,    NULL, {0},
                                NULL,           NULL,    NULL,         NULL, 0,    0};
        stp_raster_matrix matrix = parallel_matrix();
        stp_result result =
            stp_raster_triangles(&target, 0, HEIGHT, &matrix, 1.0f, &mesh, 0, &scratch);
        stp_arena_destroy(&scratch);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
        CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
        if (result == STP_OK) {
            CHECK(n >= 2);
            return;
        }
    }
}

// Triangles with numbers get the same ids as when drawn one by one.
void test_triangles_have_numbers_of_their_own(test_state* test)
{
    enum { TRIANGLES = 700 };
    static uint64_t together[PIXELS], apart[PIXELS];
    static float corners[9 * TRIANGLES];
    static uint32_t indices[3 * TRIANGLES], numbers[TRIANGLES];
    for (uint32_t t = 0; t < TRIANGLES; ++t) {
        random_triangle(5, t, t % 7 == 0 ? 200.0f : 6.0f, corners + 9 * (size_t)t);
        for (uint32_t k = 0; k < 3; ++k) {
            indices[3 * t + k] = 3 * t + k;
        }
        numbers[t] = (t * 37u) % 5003u;
    }
    stp_raster_matrix matrix = parallel_matrix();
    stp_raster_mesh mesh = {.positions = corners,
                            .vertex_count = 3 * TRIANGLES,
                            .indices = indices,
                            .triangle_count = TRIANGLES,
                            .numbers = numbers};
    clear(together);
    clear(apart);
    CHECK(draw(together, &matrix, INFINITY, &mesh));
    for (uint32_t t = 0; t < TRIANGLES; ++t) {
        stp_raster_mesh one = {.positions = corners + 9 * (size_t)t,
                               .vertex_count = 3,
                               .indices = indices,
                               .triangle_count = 1,
                               .numbers = numbers + t};
        CHECK(draw(apart, &matrix, INFINITY, &one));
    }
    CHECK(memcmp(together, apart, sizeof(apart)) == 0);
    // same as with the ids of their places
    mesh.numbers = NULL;
    clear(apart);
    CHECK(draw(apart, &matrix, INFINITY, &mesh));
    int covered = 0;
    for (int i = 0; i < PIXELS; ++i) {
        bool there = apart[i] != STP_RASTER_EMPTY;
        CHECK_EQUAL(there, together[i] != STP_RASTER_EMPTY);
        CHECK(!there || stp_raster_id(apart[i]) < TRIANGLES);
        covered += there ? 1 : 0;
    }
    CHECK(covered > PIXELS / 4);
}
