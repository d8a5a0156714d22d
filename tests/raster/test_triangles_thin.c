// SPDX-License-Identifier: MIT
// Triangles of all shapes, especially thin ones, pixel by pixel against the coverage rule.
#include "tests.h"

#include "base/core/processor.h"
#include "base/math/rng.h"
#include "raster/triangles_internal.h"

#include <string.h>

enum { WIDTH = 300, HEIGHT = 170, PIXELS = WIDTH * HEIGHT, EACH = 40 };

static int32_t number(uint64_t seed, uint64_t index, int64_t maximum)
{
    uint64_t range = (uint64_t)(2 * maximum + 1);
    return (int32_t)((int64_t)(stp_rng_hash(seed, index) % range) - maximum);
}

/// A triangle in sub-pixels that touches the picture: its longest edge, and the distance of the
/// third corner from it.
static void make_triangle(uint64_t seed, int64_t length, int64_t thickness,
                          stp_screen_vertex corners[3])
{
    int64_t x = (int64_t)(stp_rng_hash(seed, 0) % (WIDTH * STP_SUBPIXEL));
    int64_t y = (int64_t)(stp_rng_hash(seed, 1) % (HEIGHT * STP_SUBPIXEL));
    int64_t dx = number(seed, 2, length), dy = number(seed, 3, length);
    dx = seed % 7 == 0 ? 0 : dx;
    dy = seed % 7 == 1 ? 0 : dy;
    if (seed % 5 == 0) { // edges meet centres
        x = x / 128 * 128;
        y = y / 128 * 128;
        dx = dx / 128 * 128;
        dy = dy / 128 * 128;
    }
    int64_t part = (int64_t)(stp_rng_hash(seed, 4) % 257);
    corners[0] = (stp_screen_vertex){(int32_t)(x - dx / 2), (int32_t)(y - dy / 2), 0.25f};
    corners[1] = (stp_screen_vertex){(int32_t)(x + dx / 2), (int32_t)(y + dy / 2), 0.75f};
    corners[2] = (stp_screen_vertex){
        (int32_t)(x - dx / 2 + dx * part / 256) + number(seed, 5, thickness),
        (int32_t)(y - dy / 2 + dy * part / 256) + number(seed, 6, thickness), 0.5f};
}

/// Coverage by the rule, and nearness by the functions that all variants follow.
static uint64_t draw_by_rule(const stp_triangle_window* window, const stp_screen_vertex corners[3],
                             uint32_t id)
{
    stp_triangle_setup setup;
    uint64_t fragments = 0;
    if (!stp_triangle_set_up(window, corners, &setup)) {
        return 0;
    }
    stp_triangle_edge edges[3];
    for (int k = 0; k < 3; ++k) {
        edges[k] = stp_triangle_edge_make(setup.corner[(k + 1) % 3], setup.corner[(k + 2) % 3]);
    }
    stp_triangle_plane plane = stp_triangle_plane_make(&setup);
    for (int32_t y = setup.top; y <= setup.bottom; ++y) {
        for (int32_t x = setup.left; x <= setup.right; ++x) {
            int64_t value[3];
            bool inside = true;
            for (int k = 0; k < 3; ++k) {
                value[k] = stp_triangle_edge_at(&edges[k], x, y);
                inside = inside && value[k] + edges[k].bias >= 0;
            }
            if (inside) {
                float nearness =
                    setup.small ? stp_triangle_small_nearness(&setup, 1.0f / (float)setup.area,
                                                              (int32_t)value[1], (int32_t)value[2])
                                : stp_triangle_plane_at(&plane, stp_triangle_plane_row(&plane, y),
                                                        x, setup.low, setup.high);
                uint64_t* place = stp_triangle_row(window, y) + x;
                uint64_t pixel = stp_raster_pixel(nearness, id);
                *place = pixel < *place ? pixel : *place;
                uint64_t* other = place + window->behind;
                bool farther =
                    *other == STP_RASTER_EMPTY || nearness < stp_raster_nearness(~*other) ||
                    (!(nearness > stp_raster_nearness(~*other)) && id < stp_raster_id(*other));
                *other = farther ? ~stp_raster_pixel(nearness, ~id) : *other;
                fragments += 1;
            }
        }
    }
    return fragments;
}

void test_triangles_of_any_shape_follow_the_rule(test_state* test)
{
    static uint64_t wanted[2 * PIXELS], got[2 * PIXELS]; // from the front and from behind
    static const int64_t lengths[] = {3, 12, 60, 127, 129, 400, 2040, 2060, 1 << 20};
    static const int64_t thicknesses[] = {0, 1, 4, 40, 400};
    const stp_triangle_kernels* variants[3] = {&stp_triangle_kernels_portable, NULL, NULL};
    stp_processor processor = stp_processor_detect();
    variants[1] = processor >= STP_PROCESSOR_VECTOR ? &STP_VECTOR(stp_triangle_kernels) : NULL;
    variants[2] = processor >= STP_PROCESSOR_WIDE ? &STP_WIDE(stp_triangle_kernels) : NULL;
    for (uint64_t shape = 0; shape < 9 * 5; ++shape) {
        stp_screen_vertex corners[EACH][3];
        uint64_t fragments = 0, expected = 0;
        stp_triangle_window window = {.pixels = wanted,
                                      .stride = WIDTH,
                                      .width = WIDTH,
                                      .row_end = HEIGHT,
                                      .behind = PIXELS,
                                      .fragments = &fragments};
        memset(wanted, 0xFF, sizeof(wanted));
        for (uint32_t t = 0; t < EACH; ++t) {
            make_triangle(shape * EACH + t, lengths[shape / 5] * STP_SUBPIXEL,
                          thicknesses[shape % 5] * STP_SUBPIXEL / 4, corners[t]);
            expected += draw_by_rule(&window, (const stp_screen_vertex*)corners[t], t);
        }
        window.pixels = got;
        for (int v = 0; v < 3; ++v) {
            memset(got, 0xFF, sizeof(got));
            fragments = 0;
            for (uint32_t t = 0; t < EACH && variants[v] != NULL; ++t) {
                variants[v]->draw_one(&window, (const stp_screen_vertex*)corners[t], t);
            }
            CHECK(variants[v] == NULL || fragments == expected);
            CHECK(variants[v] == NULL || memcmp(wanted, got, sizeof(got)) == 0);
        }
        CHECK(lengths[shape / 5] < 60 || shape % 5 < 3 || expected > 0);
    }
}
