// SPDX-License-Identifier: MIT
// Clouds are stored once: the set of splats with all points of a node holds them.
#include "tests.h"

#include "builder/build_scene.h"
#include "select/pick_ray.h"
#include "store/file/store.h"
#include "store/residency/residency.h"

#include <string.h>
#include <unistd.h>

enum { COUNT = 3000, TWICE = 10 }; ///< every tenth point repeats the previous one

typedef struct cloud {
    char points[64], output[64];
    float positions[3 * COUNT];
} cloud;

// Points of a bumpy sheet; colours encode their indices.
static bool write_cloud(cloud* c)
{
    snprintf(c->points, sizeof(c->points), "stp_held_%d.ply", (int)getpid());
    snprintf(c->output, sizeof(c->output), "stp_held_%d.stip", (int)getpid());
    FILE* file = fopen(c->points, "w");
    if (file == NULL) {
        return false;
    }
    fprintf(file,
            "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
            "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
            "end_header\n",
            COUNT);
    for (int i = 0; i < COUNT; ++i) {
        int k = i % TWICE == TWICE - 1 ? i - 1 : i;
        float* p = c->positions + 3 * (size_t)i;
        p[0] = (float)(k % 60) + (float)(k * 37 % 11) * 0.03125f;
        p[1] = (float)(k * k % 7) * 0.25f;
        p[2] = (float)(k / 60) + (float)(k * 53 % 13) * 0.03125f;
        fprintf(file, "%.5f %.5f %.5f %d %d 7\n", (double)p[0], (double)p[1], (double)p[2], i % 256,
                i / 256);
    }
    return fclose(file) == 0;
}

static const char* const holding_methods[] = {"blue", "stochastic"};
enum { HOLDING_METHODS = 2 };

static bool build_cloud_by(stp_context* context, const cloud* c, const char* name)
{
    const char* inputs[] = {c->points};
    const stp_method* method = stp_method_by_name(name);
    stp_build_desc desc = {.inputs = inputs,
                           .input_count = 1,
                           .output = c->output,
                           .methods = &method,
                           .method_count = 1,
                           .method_options = {.leaves = stp_leaf_desc_default()}};
    return stp_build(context, &desc, NULL) == STP_OK;
}

static bool build_cloud(stp_context* context, const cloud* c)
{
    return build_cloud_by(context, c, "blue");
}

static void remove_cloud(const cloud* c)
{
    unlink(c->points);
    unlink(c->output);
}

static void check_all_there_once(test_state* test, const char* method)
{
    static cloud c;
    static bool met[COUNT];
    memset(met, 0, sizeof(met));
    stp_context* context = test_context(NULL, 2, NULL);
    stp_store* store = NULL;
    stp_store_point_set points;
    CHECK(context != NULL && write_cloud(&c) && build_cloud_by(context, &c, method));
    CHECK_EQUAL(STP_OK, stp_store_open(context, c.output, &store));
    CHECK_EQUAL(1, stp_store_get_directory(store)->point_set_count);
    CHECK_EQUAL(0, stp_store_get_summary(store)->figures.point_bytes);
    CHECK_EQUAL(STP_OK, stp_store_get_point_set(store, 0, &points));
    CHECK(points.held_by != 0 && points.point_count == COUNT && points.normals != NULL);
    double step = (double)stp_store_describe_splat_set(store, points.held_by - 1)->step;
    for (uint32_t i = 0; i < points.point_count; ++i) {
        const uint8_t* color = points.colors + 4 * (size_t)i;
        uint32_t number = color[0] + 256u * color[1];
        CHECK(color[2] == 7 && color[3] == 255 && number < COUNT && !met[number]);
        met[number] = true;
        for (size_t k = 0; k < 3; ++k) {
            double off = (double)points.positions[3 * (size_t)i + k] -
                         (double)c.positions[3 * (size_t)number + k];
            CHECK(off <= 0.5001 * step && off >= -0.5001 * step);
        }
    }
    stp_store_close(store);
    CHECK_EQUAL(STP_OK, stp_store_check(context, c.output, false));
    remove_cloud(&c);
    stp_context_destroy(context);
}

void test_held_points_are_all_there_once(test_state* test)
{
    for (int m = 0; m < HOLDING_METHODS; ++m) {
        check_all_there_once(test, holding_methods[m]);
    }
}

static bool pick_from_above(stp_context* context, stp_store* store, const float* at, stp_pick* pick)
{
    stp_pick_desc desc = {.ray = {.origin = {(double)at[0], 100.0, (double)at[2]},
                                  .direction = {0, -1, 0},
                                  .farthest = 1000.0},
                          .point_base = 0.01};
    return stp_pick_ray(context, store, &desc, pick) == STP_OK;
}

static void check_picked(test_state* test, const char* method)
{
    static cloud c;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL && write_cloud(&c) && build_cloud_by(context, &c, method));
    for (int streamed = 0; streamed < 2; ++streamed) {
        stp_store* store = NULL;
        stp_residency* residency = NULL;
        stp_pick pick;
        CHECK_EQUAL(STP_OK, stp_store_open(context, c.output, &store));
        if (streamed == 1) { // nothing is resident yet
            stp_residency_desc desc = {.limit_bytes = 64u << 20};
            CHECK_EQUAL(STP_OK, stp_residency_create(store, &desc, &residency));
        }
        for (size_t i = 0; i < COUNT; i += 211) {
            CHECK(pick_from_above(context, store, c.positions + 3 * i, &pick));
            CHECK_EQUAL(streamed == 0, pick.hit);
            CHECK_EQUAL(streamed == 1, pick.incomplete);
            double high = pick.position.y - (double)c.positions[3 * i + 1];
            CHECK(streamed == 1 || high >= -0.01); // the lower level, or one above it
        }
        stp_residency_destroy(residency);
        stp_store_close(store);
    }
    remove_cloud(&c);
    stp_context_destroy(context);
}

void test_held_points_are_picked(test_state* test)
{
    for (int m = 0; m < HOLDING_METHODS; ++m) {
        check_picked(test, holding_methods[m]);
    }
}

void test_held_points_of_partial_files_are_refused(test_state* test)
{
    static cloud c;
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_store* store = NULL;
    stp_store_point_set points;
    CHECK(context != NULL && write_cloud(&c) && build_cloud(context, &c));
    CHECK_EQUAL(STP_OK, stp_store_open(context, c.output, &store));
    uint64_t bytes = stp_store_get_summary(store) != NULL ? stp_store_file_bytes(store) : 0;
    stp_store_close(store);
    CHECK(bytes > 1 && truncate(c.output, (off_t)(bytes - 1)) == 0);
    CHECK_EQUAL(STP_OK, stp_store_open_partial(context, c.output, &store));
    CHECK(!stp_store_are_points_resident(store, 0));
    CHECK_EQUAL(STP_ERROR_TRUNCATED, stp_store_get_point_set(store, 0, &points));
    CHECK(strstr(log.text, "ends before the last octave") != NULL);
    stp_store_close(store);
    remove_cloud(&c);
    stp_context_destroy(context);
}

void test_held_points_survive_failing_allocator(test_state* test)
{
    static cloud c;
    stp_context* plain = test_context(NULL, 1, NULL);
    CHECK(plain != NULL && write_cloud(&c) && build_cloud(plain, &c));
    bool read = false;
    for (int n = 0; !read && n < 200; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        stp_store* store = NULL;
        stp_store_point_set points;
        if (context != NULL && stp_store_open(context, c.output, &store) == STP_OK) {
            read = stp_store_get_point_set(store, 0, &points) == STP_OK;
            stp_store_close(store);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(read);
    stp_context_destroy(plain);
    remove_cloud(&c);
}
