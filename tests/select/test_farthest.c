// SPDX-License-Identifier: MIT
#include "support_built.h"

#include "base/math/rng.h"
#include "draw/support_store.h"
#include "select/camera.h"
#include "select/sections.h"
#include "select/view_frame.h"

#include <math.h>

/// Extent in the picture, as shares of its width and height.
typedef struct extent {
    double low[2], high[2];
    uint32_t vertices;
} extent;

static void add_vertex(extent* e, const stp_view* view, const stp_view_frame* frame, stp_vec3d p)
{
    stp_vec3d q = stp_subd(p, frame->eye);
    double depth = frame->parallel ? 1.0 : stp_dotd(q, frame->forward);
    const double at[2] = {
        (frame->center_x + frame->scale * stp_dotd(q, frame->right) / depth) / frame->width,
        (frame->center_y + frame->scale * stp_dotd(q, frame->down) / depth) / frame->height};
    bool counts = !stp_sections_exclude(&view->sections, p);
    for (int k = 0; k < 2 && counts; ++k) {
        e->low[k] = depth > 0.0 ? fmin(e->low[k], at[k]) : -HUGE_VAL;
        e->high[k] = depth > 0.0 ? fmax(e->high[k], at[k]) : HUGE_VAL;
    }
    e->vertices += counts ? 1 : 0;
}

/// The extent of all vertices of some places, but for those of others.
static bool measure(stp_context* context, stp_store* store, const built_places* places,
                    const built_places* hidden, const stp_view* view, extent* e)
{
    stp_view_frame frame;
    *e = (extent){{HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL}, 0};
    if (!stp_view_frame_make(view, &frame)) {
        return false;
    }
    for (uint32_t i = 0; i < places->count; ++i) {
        const stp_instance* place = &places->places[i];
        stp_clusters clusters;
        stp_decoded_mesh mesh;
        if (hidden != NULL && built_has(hidden, place)) {
            continue;
        }
        if (stp_store_get_clusters(store, place->part.index, &clusters) != STP_OK ||
            stp_clusters_decode(context, &clusters, &mesh) != STP_OK) {
            return false;
        }
        for (size_t k = 0; k < 3 * (size_t)mesh.triangle_count; ++k) {
            const float* p = mesh.positions + 3 * k;
            stp_vec3d own = {(double)p[0], (double)p[1], (double)p[2]};
            add_vertex(e, view, &frame, stp_affine_point(&place->transform, own));
        }
        stp_decoded_mesh_destroy(context, &mesh);
    }
    return e->vertices > 0;
}

/// Whether everything is in the picture, in its middle, and touches the margins.
static bool fits(const extent* e)
{
    const double margin = STP_CAMERA_MARGIN, slack = 4e-3;
    bool inside = true, touches = false, centered = true;
    for (int k = 0; k < 2; ++k) {
        inside = inside && e->low[k] > margin - slack && e->high[k] < 1.0 - margin + slack;
        touches = touches || e->high[k] - e->low[k] > 1.0 - 2.0 * (margin + slack);
        centered = centered && fabs(e->low[k] + e->high[k] - 1.0) < 2.0 * slack;
    }
    return inside && touches && centered;
}

static stp_view view_of_case(uint64_t i)
{
    static const char* const names[] = {"iso", "front", "d3", "top", "d17"};
    stp_view view = {.width = 100 + 37 * (uint32_t)(i % 9),
                     .height = 120,
                     .fov_degrees = i % 4 == 0 ? 0.0 : 20.0 * (double)(i % 4),
                     .ortho_height = i % 3 == 2 ? 1.0 : 0.0};
    (void)stp_camera_face(names[i % 5], &view);
    return view;
}

void test_camera_fits_the_content_of_a_file(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_store* store = context != NULL ? built_open(context, 41, false) : NULL;
    static built_places all;
    stp_affine identity = stp_affine_identity();
    CHECK(store != NULL);
    const stp_store_directory* d = stp_store_get_directory(store);
    const stp_farthest_store content = {context, store, NULL};
    all.count = 0;
    CHECK(built_unfold(store, d->root, &identity, &all));
    uint32_t looser = 0;
    for (uint64_t i = 0; i < 15; ++i) {
        stp_view view = view_of_case(i), of_box = view;
        extent e;
        stp_camera_fit_store(&content, NULL, &view);
        CHECK(measure(context, store, &all, NULL, &view, &e) && fits(&e));
        stp_camera_fit(&of_box, &d->nodes[d->root].bounds);
        CHECK(measure(context, store, &all, NULL, &of_box, &e));
        looser += fits(&e) ? 0 : 1;
    }
    CHECK(looser > 10); // the corners of the bounds lie beside the content
    stp_store_close(store);
    stp_context_destroy(context);
}

void test_camera_fits_what_is_visible(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_store* store = context != NULL ? built_open(context, 42, false) : NULL;
    static built_places all, own;
    stp_affine identity = stp_affine_identity();
    stp_visibility* visibility;
    stp_outline* outline;
    bool ready;
    CHECK(store != NULL);
    const stp_store_directory* d = stp_store_get_directory(store);
    CHECK_EQUAL(STP_OK, stp_outline_create(context, store, &outline));
    CHECK_EQUAL(STP_OK, stp_outline_prepare(outline, 0, &ready));
    CHECK_EQUAL(STP_OK, stp_visibility_create(context, store, &visibility));
    const stp_farthest_store content = {context, store, visibility};
    all.count = 0;
    CHECK(built_unfold(store, d->root, &identity, &all));
    uint32_t measured = 0;
    for (uint32_t object = 5; object < 20; ++object) {
        stp_outline_item item;
        extent e;
        CHECK_EQUAL(STP_OK, stp_outline_item_of(outline, object, &item));
        own.count = 0;
        if (item.node == STP_STORE_NONE || !built_unfold(store, item.node, &item.transform, &own) ||
            own.count == 0) {
            continue;
        }
        // of the object alone, and of all others
        stp_placed_node placed = {item.node, item.transform};
        stp_view view = view_of_case(object), others = view;
        stp_camera_fit_store(&content, &placed, &view);
        CHECK(measure(context, store, &own, NULL, &view, &e) && fits(&e));
        stp_visibility_reset(visibility, STP_SHOW);
        CHECK_EQUAL(STP_OK, stp_visibility_set(visibility, &placed, STP_SHOW_NOT));
        stp_camera_fit_store(&content, NULL, &others);
        CHECK(measure(context, store, &all, &own, &others, &e) && fits(&e));
        measured += 1;
    }
    CHECK(measured > 5);
    // nothing visible: any valid view
    stp_visibility_reset(visibility, STP_SHOW_NOT);
    stp_view view = view_of_case(0);
    stp_view_frame frame;
    stp_camera_fit_store(&content, NULL, &view);
    CHECK(stp_view_frame_make(&view, &frame));
    stp_visibility_destroy(visibility);
    stp_outline_destroy(outline);
    stp_store_close(store);
    stp_context_destroy(context);
}

void test_camera_fits_content_that_sections_leave(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_store* store = context != NULL ? built_open(context, 43, false) : NULL;
    static built_places all;
    stp_affine identity = stp_affine_identity();
    CHECK(store != NULL);
    const stp_store_directory* d = stp_store_get_directory(store);
    const stp_farthest_store content = {context, store, NULL};
    stp_boxd box = d->nodes[d->root].bounds;
    stp_vec3d middle = stp_scaled(stp_addd(box.min, box.max), 0.5);
    all.count = 0;
    CHECK(built_unfold(store, d->root, &identity, &all));
    for (uint64_t i = 0; i < 12; ++i) {
        stp_view view = view_of_case(i), whole = view;
        extent e, cut;
        CHECK(stp_sections_add_plane(&view.sections, middle,
                                     (stp_vec3d){i % 3 == 0, i % 3 == 1, i % 3 == 2}));
        CHECK(stp_sections_add_plane(&view.sections, middle, (stp_vec3d){-1, -2, (double)i}));
        stp_camera_fit_store(&content, NULL, &view);
        // what the planes leave is in the picture, and larger than in a picture of everything
        CHECK(measure(context, store, &all, NULL, &view, &e));
        CHECK(fmin(e.low[0], e.low[1]) > 0.03 && fmax(e.high[0], e.high[1]) < 0.97);
        stp_camera_fit_store(&content, NULL, &whole);
        whole.sections = view.sections;
        CHECK(measure(context, store, &all, NULL, &whole, &cut));
        CHECK(fmax(e.high[0] - e.low[0], e.high[1] - e.low[1]) >
              fmax(cut.high[0] - cut.low[0], cut.high[1] - cut.low[1]));
    }
    // planes that leave nothing are ignored
    stp_view nothing = view_of_case(0), whole = nothing;
    CHECK(stp_sections_add_plane(&nothing.sections, stp_addd(box.max, stp_subd(box.max, box.min)),
                                 (stp_vec3d){-1, 0, 0}));
    stp_camera_fit_store(&content, NULL, &nothing);
    stp_camera_fit_store(&content, NULL, &whole);
    CHECK(stp_lengthd(stp_subd(nothing.eye, whole.eye)) < 1e-9);
    stp_store_close(store);
    stp_context_destroy(context);
}
