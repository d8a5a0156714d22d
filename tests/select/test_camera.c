// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/math/rng.h"
#include "select/camera.h"
#include "select/eyes.h"
#include "select/sections.h"
#include "select/view_frame.h"

#include <string.h>

/// Extent of geometry in the picture, as fractions of its width and height.
typedef struct extent {
    double low_x, high_x, low_y, high_y;
    double nearest, size; ///< nearest depth; the diagonal of everything
} extent;

static extent empty_extent(const stp_boxd* box)
{
    stp_vec3d size = stp_subd(box->max, box->min);
    return (extent){HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL, HUGE_VAL, sqrt(stp_dotd(size, size))};
}

static void extent_add(extent* e, const stp_view_frame* frame, stp_vec3d p)
{
    stp_vec3d q = stp_subd(p, frame->eye);
    double w = frame->parallel ? 1.0 : stp_dotd(q, frame->forward);
    double x = (frame->center_x + frame->scale * stp_dotd(q, frame->right) / w) / frame->width;
    double y = (frame->center_y + frame->scale * stp_dotd(q, frame->down) / w) / frame->height;
    bool before = stp_dotd(q, frame->forward) > 0.0;
    e->nearest = fmin(e->nearest, stp_dotd(q, frame->forward));
    e->low_x = before ? fmin(e->low_x, x) : -HUGE_VAL;
    e->high_x = before ? fmax(e->high_x, x) : HUGE_VAL;
    e->low_y = before ? fmin(e->low_y, y) : -HUGE_VAL;
    e->high_y = before ? fmax(e->high_y, y) : HUGE_VAL;
}

static stp_vec3d corner_of(const stp_boxd* b, int corner)
{
    return (stp_vec3d){(corner & 1) != 0 ? b->max.x : b->min.x,
                       (corner & 2) != 0 ? b->max.y : b->min.y,
                       (corner & 4) != 0 ? b->max.z : b->min.z};
}

static extent extent_of_box(const stp_view_frame* frame, const stp_boxd* box)
{
    extent e = empty_extent(box);
    for (int corner = 0; corner < 8; ++corner) {
        extent_add(&e, frame, corner_of(box, corner));
    }
    return e;
}

/// Whether everything is within the margins, opposite ones are equal, and two are touched; or the
/// eye would come too near.
static bool fits(extent e)
{
    const double margin = STP_CAMERA_MARGIN, slack = 1e-6;
    bool within = e.low_x > margin - slack && e.high_x < 1.0 - margin + slack &&
                  e.low_y > margin - slack && e.high_y < 1.0 - margin + slack;
    bool centered =
        fabs(e.low_x + e.high_x - 1.0) < slack && fabs(e.low_y + e.high_y - 1.0) < slack;
    bool touches = e.low_x < margin + slack || e.low_y < margin + slack;
    return within && centered && (touches || e.nearest < 3.5e-4 * e.size);
}

static double random_in(uint64_t seed, uint64_t index, double low, double high)
{
    return low + (high - low) * (double)(stp_rng_hash(seed, index) >> 11) * 0x1p-53;
}

static stp_vec3d random_vector(uint64_t seed, double low, double high)
{
    return (stp_vec3d){random_in(seed, 0, low, high), random_in(seed, 1, low, high),
                       random_in(seed, 2, low, high)};
}

/// A box near the origin or far away, perhaps flat; and a picture of any shape, angle and
/// projection.
static stp_boxd random_case(uint64_t i, stp_view* view)
{
    double far = i % 5 == 0 ? 5e5 : 10.0;
    stp_vec3d low = random_vector(stp_rng_hash(i, 1), -far, far);
    stp_vec3d size = random_vector(stp_rng_hash(i, 2), 0.0, 20.0);
    size.y = i % 7 == 0 ? 0.0 : size.y;
    size.x *= i % 3 == 0 ? 30.0 : 1.0;
    *view = (stp_view){.width = 50 + stp_rng_below(i, 3, 2000),
                       .height = 50 + stp_rng_below(i, 4, 2000),
                       .fov_degrees = random_in(i, 5, 5.0, 130.0),
                       .ortho_height = i % 4 == 0 ? 1.0 : 0.0};
    return (stp_boxd){low, stp_addd(low, size)};
}

void test_camera_fits_every_box(test_state* test)
{
    for (uint64_t i = 0; i < 4000; ++i) {
        stp_view view;
        stp_view_frame frame;
        stp_boxd box = random_case(i, &view);
        if (i % 2 == 0) {
            CHECK(stp_camera_frame(stp_camera_names()[i / 2 % 33], &box, &view));
        } else {
            view.eye = random_vector(stp_rng_hash(i, 6), -1.0, 1.0);
            view.up = random_vector(stp_rng_hash(i, 7), -1.0, 1.0);
            stp_vec3d toward = stp_normalized(view.eye);
            stp_camera_fit(&view, &box);
            stp_vec3d now = stp_normalized(stp_subd(view.eye, view.target));
            CHECK(stp_dotd(toward, now) > 1.0 - 1e-9); // the camera is not turned
        }
        CHECK(stp_view_frame_make(&view, &frame));
        CHECK(fits(extent_of_box(&frame, &box)));
    }
}

void test_camera_fits_both_eyes(test_state* test)
{
    for (uint64_t i = 1; i < 400; i += 2) {
        stp_view view;
        stp_view_frame frame;
        stp_boxd box = random_case(i, &view);
        view.ortho_height = 0.0;
        view.width *= 2;
        view.eye_distance = 0.064;
        CHECK(stp_camera_frame("iso", &box, &view));
        extent both = empty_extent(&box);
        for (uint32_t eye = 0; eye < 2; ++eye) {
            stp_view one = stp_view_of_eye(&view, eye);
            CHECK(stp_view_frame_make(&one, &frame));
            for (int corner = 0; corner < 8; ++corner) {
                extent_add(&both, &frame, corner_of(&box, corner));
            }
        }
        CHECK(fits(both));
    }
}

/// A section keeps the half of a box towards +x: the camera fits it like a whole box.
void test_camera_fits_what_sections_leave(test_state* test)
{
    for (uint64_t i = 0; i < 400; ++i) {
        stp_view view, of_half;
        stp_boxd box = random_case(i, &view), half = box;
        half.min.x = 0.5 * (box.min.x + box.max.x);
        of_half = view;
        CHECK(stp_sections_add_plane(&view.sections, half.min, (stp_vec3d){-2, 0, 0}));
        CHECK(stp_camera_frame("iso", &box, &view));
        CHECK(stp_camera_frame("iso", &half, &of_half));
        stp_vec3d apart = stp_subd(view.eye, of_half.eye);
        stp_vec3d size = stp_subd(box.max, box.min);
        CHECK(stp_dotd(apart, apart) < 1e-12 * stp_dotd(size, size));
        CHECK(fabs(view.ortho_height - of_half.ortho_height) <= 1e-6 * of_half.ortho_height);
    }
    // several oblique sections: random remaining points are in the picture, and some come near its
    // margins
    for (uint64_t i = 0; i < 60; ++i) {
        stp_view view;
        stp_view_frame frame;
        stp_boxd box = random_case(4 * i + 1, &view);
        view.fov_degrees = 25.0; // sharp corners near to the eye would hold few of the points
        stp_vec3d size = stp_subd(box.max, box.min), middle = stp_scaled(size, 0.5);
        middle = stp_addd(box.min, middle);
        for (uint64_t k = 0; k < 1 + i % 8; ++k) {
            stp_vec3d normal = random_vector(stp_rng_hash(i, 20 + k), -1.0, 1.0);
            double reach = 0.3 * (fabs(normal.x) * size.x + fabs(normal.z) * size.z);
            stp_vec3d at =
                stp_addd(middle, stp_scaled(normal, reach * random_in(i, 40 + k, 0.0, 1.0) /
                                                        stp_dotd(normal, normal)));
            CHECK(stp_sections_add_plane(&view.sections, at, normal));
        }
        CHECK(stp_camera_frame("iso", &box, &view) && stp_view_frame_make(&view, &frame));
        extent e = empty_extent(&box);
        uint32_t left = 0;
        for (uint64_t k = 0; k < 20000; ++k) {
            stp_vec3d p = random_vector(stp_rng_hash(i, 100 + k), 0.0, 1.0);
            p = (stp_vec3d){p.x * size.x, p.y * size.y, p.z * size.z};
            p = stp_addd(box.min, p);
            if (!stp_sections_exclude(&view.sections, p)) {
                extent_add(&e, &frame, p);
                left += 1;
            }
        }
        CHECK(e.low_x > 0.0399 && e.high_x < 0.9601 && e.low_y > 0.0399 && e.high_y < 0.9601);
        CHECK(left < 2000 || e.high_x - e.low_x > 0.6 || e.high_y - e.low_y > 0.6);
    }
    // everything is clipped: the sections are ignored
    stp_boxd box = {{0, 0, 0}, {1, 2, 3}};
    stp_view view = {.width = 100, .height = 100}, whole = view;
    CHECK(stp_sections_add_plane(&view.sections, (stp_vec3d){-1, 0, 0}, (stp_vec3d){1, 0, 0}));
    CHECK(stp_camera_frame("iso", &box, &view) && stp_camera_frame("iso", &box, &whole));
    CHECK(memcmp(&view.eye, &whole.eye, sizeof(view.eye)) == 0);
}

void test_camera_directions_match_their_names(test_state* test)
{
    stp_boxd box = {{-1, -2, -3}, {1, 2, 3}};
    const struct {
        const char* name;
        stp_vec3d toward;
    } cases[] = {{"front", {0, 0, 1}}, {"back", {0, 0, -1}}, {"left", {-1, 0, 0}},
                 {"right", {1, 0, 0}}, {"top", {0, 1, 0}},   {"bottom", {0, -1, 0}}};
    for (int i = 0; i < 6; ++i) {
        stp_view view = {.width = 100, .height = 100};
        CHECK(stp_camera_frame(cases[i].name, &box, &view));
        stp_vec3d toward = stp_normalized(stp_subd(view.eye, view.target));
        CHECK(stp_dotd(toward, cases[i].toward) > 0.999999);
        CHECK(view.fov_degrees == STP_CAMERA_FOV);
    }
    stp_view view = {.width = 100, .height = 100, .fov_degrees = 30};
    CHECK(stp_camera_frame("iso", &box, &view) && view.fov_degrees == 30.0);
    stp_vec3d corner = stp_normalized(stp_subd(view.eye, view.target)); // isometric: 35.26 degrees
    CHECK(fabs(corner.y - sqrt(1.0 / 3.0)) < 1e-9 && fabs(corner.x - corner.z) < 1e-9);
    CHECK(!stp_camera_frame("nowhere", &box, &view) && !stp_camera_frame("d26", &box, &view));
    stp_boxd empty = stp_boxd_empty(), point = {{1, 1, 1}, {1, 1, 1}};
    stp_view_frame frame;
    CHECK(stp_camera_frame("iso", &empty, &view) && stp_view_frame_make(&view, &frame));
    CHECK(stp_camera_frame("iso", &point, &view) && stp_view_frame_make(&view, &frame));
}

void test_camera_judging_directions_avoid_what_was_captured(test_state* test)
{
    stp_boxd box = {{-1, -1, -1}, {1, 1, 1}};
    stp_vec3d seen[26];
    for (int i = 0; i < 26; ++i) {
        char name[8];
        snprintf(name, sizeof(name), "d%d", i);
        stp_view view = {.width = 100, .height = 100, .ortho_height = 1};
        CHECK(stp_camera_frame(name, &box, &view));
        seen[i] = stp_normalized(stp_subd(view.eye, view.target));
        for (int code = 0; code < 27; ++code) { // corners, faces and edges of a cube
            stp_vec3d c = {code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1};
            CHECK(stp_dotd(seen[i], stp_normalized(c)) < 0.941); // 19.8 degrees or more
        }
        for (int k = 0; k < i; ++k) {
            CHECK(stp_dotd(seen[i], seen[k]) < 0.94); // 20 degrees apart
        }
    }
}
