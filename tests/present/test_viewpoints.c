// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/core/context.h"
#include "program/present/viewpoints.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define VIEW "{\"name\": \"a\", \"eye\": [0, 0, 5], \"target\": [0, 0, 0]"
#define WHOLE(views) "{\"version\": 1, \"views\": [" views "]}"

static stp_result parse(stp_context* context, const char* text, stp_viewpoints* v)
{
    return stp_viewpoints_parse(context, "v", (const unsigned char*)text, strlen(text), v);
}

static char path_of_wall[] = "house/wall", text_of_crack[] = "a crack",
            long_name[] = "K\xC3\xBC"
                          "che";

/// One of each kind.
static stp_viewpoint make_view(char* name)
{
    static char note[] = "look \"here\"\n";
    static stp_shown_object objects[] = {{STP_SHOWN_HIDDEN, path_of_wall, true, {1, 2, 3}},
                                         {STP_SHOWN_ISOLATED, path_of_wall, false, {0, 0, 0}},
                                         {STP_SHOWN_GHOST, path_of_wall, false, {0, 0, 0}}};
    static stp_annotation annotations[] = {{text_of_crack, {0.1, -4e6, 1e-9}, path_of_wall},
                                           {text_of_crack, {7, 8, 9}, NULL}};
    return (stp_viewpoint){
        .name = name,
        .note = note,
        .eye = {0.1, 1.0 / 3, 5e5},
        .target = {1, 2, 3},
        .up = {0, 0, 1},
        .fov_degrees = 35,
        .ortho_height = 2.5,
        .sections = {.count = 2, .planes = {{{1, 0, 0}, 4}, {{0, -1, 0}, 1.0 / 7}}},
        .objects = objects,
        .object_count = 3,
        .annotations = annotations,
        .annotation_count = 2};
}

static bool same_vector(stp_vec3d a, stp_vec3d b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static bool same_view(const stp_viewpoint* a, const stp_viewpoint* b)
{
    bool same = strcmp(a->name, b->name) == 0 && strcmp(a->note, b->note) == 0 &&
                same_vector(a->eye, b->eye) && same_vector(a->target, b->target) &&
                same_vector(a->up, b->up) && a->fov_degrees == b->fov_degrees &&
                a->ortho_height == b->ortho_height && a->sections.count == b->sections.count &&
                a->object_count == b->object_count && a->annotation_count == b->annotation_count;
    for (uint32_t i = 0; same && i < a->sections.count; ++i) {
        same = same_vector(a->sections.planes[i].normal, b->sections.planes[i].normal) &&
               a->sections.planes[i].distance == b->sections.planes[i].distance;
    }
    for (size_t i = 0; same && i < a->object_count; ++i) {
        const stp_shown_object *x = &a->objects[i], *y = &b->objects[i];
        same = x->as == y->as && strcmp(x->path, y->path) == 0 &&
               x->has_position == y->has_position && same_vector(x->position, y->position);
    }
    for (size_t i = 0; same && i < a->annotation_count; ++i) {
        const stp_annotation *x = &a->annotations[i], *y = &b->annotations[i];
        same = strcmp(x->text, y->text) == 0 && same_vector(x->point, y->point) &&
               (x->object == NULL) == (y->object == NULL) &&
               (x->object == NULL || strcmp(x->object, y->object) == 0);
    }
    return same;
}

void test_viewpoints_are_read_as_written(test_state* test)
{
    char path[] = "stp_views_XXXXXX";
    int file = mkstemp(path);
    CHECK(file >= 0 && close(file) == 0);
    stp_context* context = test_context(NULL, 1, NULL);
    stp_viewpoints views = {0}, back;
    char name[32];
    for (int i = 0; i < 20; ++i) {
        snprintf(name, sizeof(name), "view %d", i);
        stp_viewpoint view = make_view(i == 7 ? long_name : name);
        view.object_count = (size_t)(i % 4);
        view.annotation_count = (size_t)(i % 3);
        CHECK_EQUAL(STP_OK, stp_viewpoints_put(context, &views, &view));
    }
    CHECK_EQUAL(20, views.count);
    CHECK_EQUAL(STP_OK, stp_viewpoints_write(context, path, &views));
    CHECK_EQUAL(STP_OK, stp_viewpoints_read(context, path, &back));
    CHECK_EQUAL(20, back.count);
    for (size_t i = 0; i < 20; ++i) {
        CHECK(same_view(&views.views[i], &back.views[i]));
    }
    const stp_viewpoint* found = stp_viewpoints_find(&back, long_name);
    CHECK(found == &back.views[7]);
    stp_view view = {.width = 5, .fov_degrees = 60, .near_distance = 1};
    stp_viewpoint_get_view(found, &view);
    CHECK(view.fov_degrees == 35 && view.ortho_height == 2.5 && view.sections.count == 2);
    CHECK(view.width == 5 && view.near_distance == 1 && view.up.z == 1);
    // another of the same name replaces it
    stp_viewpoint other = make_view(long_name);
    other.fov_degrees = 0;
    CHECK_EQUAL(STP_OK, stp_viewpoints_put(context, &back, &other));
    CHECK(back.count == 20 && back.views[7].fov_degrees == 0);
    view.fov_degrees = 60;
    stp_viewpoint_get_view(&back.views[7], &view);
    CHECK(view.fov_degrees == 60);
    CHECK(stp_viewpoints_remove(context, &back, long_name));
    CHECK(!stp_viewpoints_remove(context, &back, long_name));
    CHECK(back.count == 19 && same_view(&back.views[7], &views.views[8]));
    stp_viewpoints_destroy(context, &back);
    unlink(path);
    CHECK_EQUAL(STP_OK, stp_viewpoints_read(context, path, &back)); // none yet
    CHECK_EQUAL(0, back.count);
    stp_viewpoints_destroy(context, &views);
    stp_context_destroy(context);
}

void test_viewpoints_are_stored_beside_the_model(test_state* test)
{
    static const char* const paths[][2] = {{"a/b.stip", "a/b.views.json"},
                                           {"plant.v2.glb", "plant.v2.views.json"},
                                           {"a.b/c", "a.b/c.views.json"},
                                           {".hidden", ".hidden.views.json"}};
    stp_context* context = test_context(NULL, 1, NULL);
    for (int i = 0; i < 4; ++i) {
        char* path = stp_viewpoints_path(context, paths[i][0]);
        CHECK(path != NULL && strcmp(path, paths[i][1]) == 0);
        stp_free(context, path);
    }
    stp_context_destroy(context);
}

void test_invalid_viewpoints_are_refused(test_state* test)
{
    static const char* const bad[] = {
        "",
        "[]",
        "{}",
        "{\"views\": 3}",
        "{\"version\": 2, \"views\": []}",
        WHOLE("7"),
        WHOLE("{\"eye\": [0, 0, 5], \"target\": [0, 0, 0]}"),
        WHOLE("{\"name\": \"\", \"eye\": [0, 0, 5], \"target\": [0, 0, 0]}"),
        WHOLE("{\"name\": \"a\", \"eye\": [0, 0], \"target\": [0, 0, 0]}"),
        WHOLE("{\"name\": \"a\", \"eye\": [0, 0, 1e300], \"target\": [0, 0, 0]}"),
        WHOLE("{\"name\": \"a\", \"eye\": [0, 0, 0], \"target\": [0, 0, 0]}"),
        WHOLE(VIEW "}, " VIEW "}"),
        WHOLE(VIEW ", \"fov\": 0}"),
        WHOLE(VIEW ", \"fov\": 1e-160}"),
        WHOLE(VIEW ", \"fov\": 179.95}"),
        WHOLE(VIEW ", \"fov\": \"x\"}"),
        WHOLE(VIEW ", \"note\": 3}"),
        WHOLE(VIEW ", \"up\": 3}"),
        WHOLE(VIEW ", \"sections\": [[0, 0, 0, 1]]}"),
        WHOLE(VIEW ", \"sections\": [[0, 1, 0]]}"),
        WHOLE(VIEW ", \"sections\": {}}"),
        WHOLE(VIEW ", \"hidden\": {}}"),
        WHOLE(VIEW ", \"ghosts\": [3]}"),
        WHOLE(VIEW ", \"isolated\": [{\"path\": \"x\", \"at\": [1, 2]}]}"),
        WHOLE(VIEW ", \"annotations\": [{\"text\": \"x\"}]}"),
        WHOLE(VIEW ", \"annotations\": 1}"),
    };
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_viewpoints v;
    for (size_t i = 0; i < sizeof(bad) / sizeof(bad[0]); ++i) {
        log.errors = 0;
        stp_result result = parse(context, bad[i], &v);
        CHECK(result == STP_ERROR_FORMAT || result == STP_ERROR_VERSION);
        CHECK_EQUAL(1, log.errors);
        CHECK_EQUAL(0, v.count);
    }
    CHECK_EQUAL(STP_OK, parse(context, WHOLE(VIEW ", \"unknown\": [1]}"), &v));
    CHECK(v.count == 1 && v.views[0].up.y == 1 && v.views[0].note == NULL);
    stp_viewpoints_destroy(context, &v);
    stp_context_destroy(context);
}

void test_truncated_viewpoints_are_refused(test_state* test)
{
    static const char text[] = WHOLE(
        VIEW ", \"note\": \"n\", \"sections\": [[1, 0, 0, 2]], \"hidden\": [{\"path\": \"p\"}], "
             "\"annotations\": [{\"text\": \"t\", \"at\": [1, 2, 3]}]}");
    stp_context* context = test_context(NULL, 1, NULL);
    stp_viewpoints v;
    uint64_t live = stp_context_live_bytes(context);
    for (size_t size = 0; size < sizeof(text) - 1; ++size) {
        unsigned char* copy = malloc(size + 1);
        CHECK(copy != NULL);
        memcpy(copy, text, size);
        CHECK(stp_viewpoints_parse(context, "v", copy, size, &v) == STP_ERROR_FORMAT);
        free(copy);
    }
    CHECK_EQUAL(STP_OK, parse(context, text, &v));
    stp_viewpoints_destroy(context, &v);
    CHECK_EQUAL(live, stp_context_live_bytes(context));
    stp_context_destroy(context);
}

void test_viewpoints_survive_any_allocation_failing(test_state* test)
{
    static const char text[] =
        WHOLE(VIEW ", \"note\": \"n\", \"ghosts\": [{\"path\": \"p\"}], "
                   "\"annotations\": [{\"text\": \"t\", \"at\": [1, 2, 3], \"object\": \"o\"}]}");
    test_heap heap = TEST_HEAP(-1);
    test_log log = {0};
    stp_context* context = test_context(&heap, 1, &log);
    size_t live = heap.live_bytes;
    stp_viewpoint view = make_view(long_name);
    bool failed = true;
    for (int n = 0; failed; ++n) {
        stp_viewpoints v = {0};
        heap.count = log.errors = 0;
        heap.fail_at = n;
        stp_result result = parse(context, text, &v);
        result = result == STP_OK ? stp_viewpoints_put(context, &v, &view) : result;
        failed = result != STP_OK;
        CHECK(!failed || (result == STP_ERROR_OUT_OF_MEMORY && log.errors == 1));
        stp_viewpoints_destroy(context, &v);
        CHECK_EQUAL(live, heap.live_bytes);
    }
    stp_context_destroy(context);
}

void test_viewpoints_that_cannot_be_written_leave_the_previous_file(test_state* test)
{
    char folder[] = "stp_views_XXXXXX", path[64], bad_name[] = "\xFF";
    CHECK(mkdtemp(folder) != NULL);
    snprintf(path, sizeof(path), "%s/m.views.json", folder);
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_viewpoints views = {0}, back;
    stp_viewpoint view = make_view(long_name);
    CHECK_EQUAL(STP_OK, stp_viewpoints_put(context, &views, &view));
    CHECK_EQUAL(STP_OK, stp_viewpoints_write(context, path, &views));
    view.name = bad_name;
    CHECK_EQUAL(STP_OK, stp_viewpoints_put(context, &views, &view));
    CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_viewpoints_write(context, path, &views));
    CHECK_EQUAL(1, log.errors);
    CHECK_EQUAL(STP_OK, stp_viewpoints_read(context, path, &back));
    CHECK_EQUAL(1, back.count);
    CHECK_EQUAL(STP_ERROR_IO, stp_viewpoints_write(context, folder, &back));
    stp_viewpoints_destroy(context, &back);
    stp_viewpoints_destroy(context, &views);
    stp_context_destroy(context);
    unlink(path);
    CHECK_EQUAL(0, rmdir(folder)); // no other file is left there
}
