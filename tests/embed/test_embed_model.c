// SPDX-License-Identifier: MIT
// A scene built in memory, opened in every possible way, described and drawn.
#include "support_embed.h"

#include "draw/enlarge.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

enum { PIXELS = EMBED_SIDE * EMBED_SIDE * 4 };

typedef struct file_in_memory {
    const unsigned char* bytes;
    size_t size;
    uint64_t fails_from; ///< reads beyond it fail
} file_in_memory;

static int read_memory(void* user, uint64_t offset, void* bytes, size_t size)
{
    const file_in_memory* file = user;
    if (offset > file->size || size > file->size - offset || offset + size > file->fails_from) {
        return -1;
    }
    memcpy(bytes, file->bytes + offset, size);
    return 0;
}

static bool write_file(const char* path, const void* bytes, size_t size)
{
    FILE* file = fopen(path, "wb");
    bool written = file != NULL && fwrite(bytes, 1, size, file) == size;
    return file != NULL && fclose(file) == 0 && written;
}

static int covered(const uint8_t* pixels)
{
    int count = 0;
    for (int i = 0; i < PIXELS; i += 4) {
        count += pixels[i + 3] != 0;
    }
    return count;
}

/// Opens, draws a view completely, and closes.
static stp_result draw_opened(const stp_model_desc* desc, const stp_paint_desc* paint,
                              uint8_t* pixels)
{
    stp_context* context = test_context(NULL, 2, NULL);
    stp_model* model = NULL;
    stp_result result = stp_model_open(context, desc, &model);
    result = result == STP_OK ? embed_draw(model, paint, pixels) : result;
    stp_model_close(model);
    stp_context_destroy(context);
    return result;
}

void test_embed_every_source_gives_the_same_picture(test_state* test)
{
    static uint8_t first[PIXELS], other[PIXELS];
    char path[] = "stp_embed_XXXXXX";
    size_t size = 0;
    unsigned char* bytes = embed_build_town(true, &size);
    unsigned char* shifted = malloc(size + 65);
    int descriptor = mkstemp(path);
    bool ready =
        bytes != NULL && shifted != NULL && descriptor >= 0 && write_file(path, bytes, size);
    size_t odd = ready ? 65 - (uintptr_t)shifted % 64 : 0; // never aligned
    if (ready) {
        memcpy(shifted + odd % 64 + (odd % 64 == 0), bytes, size);
    }
    file_in_memory file = {.bytes = bytes, .size = size, .fails_from = UINT64_MAX};
    const stp_model_desc ways[] = {
        {.bytes = bytes, .size = size},
        {.path = path},
        {.bytes = ready ? shifted + odd % 64 + (odd % 64 == 0) : NULL, .size = size},
        {.read = read_memory, .read_user = &file, .size = size},
        {.path = path, .stream = true},
        {.bytes = bytes, .size = size, .stream = true},
        {.read = read_memory, .read_user = &file, .size = size, .stream = true},
    };
    bool alike = ready;
    stp_paint_desc paint = {.complete = true};
    for (size_t i = 0; i < sizeof(ways) / sizeof(ways[0]) && alike; ++i) {
        alike = draw_opened(&ways[i], &paint, i == 0 ? first : other) == STP_OK &&
                (i == 0 || memcmp(first, other, PIXELS) == 0);
        if (!alike) {
            fprintf(stderr, "way %zu differs\n", i);
        }
    }
    close(descriptor);
    unlink(path);
    free(shifted);
    free(bytes);
    CHECK(ready && alike);
    CHECK(covered(first) > EMBED_SIDE * EMBED_SIDE / 10);
}

void test_embed_failed_reads_are_errors(test_state* test)
{
    static uint8_t pixels[PIXELS];
    size_t size = 0;
    unsigned char* bytes = embed_build_town(false, &size);
    CHECK(bytes != NULL);
    file_in_memory file = {.bytes = bytes, .size = size};
    stp_model_desc desc = {.read = read_memory, .read_user = &file, .size = size};
    stp_result whole, streamed, cut, both, none;
    file.fails_from = size - 1;
    whole = draw_opened(&desc, NULL, pixels);
    file.fails_from = 100; // within the directory
    desc.stream = true;
    streamed = draw_opened(&desc, NULL, pixels);
    file.fails_from = UINT64_MAX;
    desc.size = size / 2;
    cut = draw_opened(&desc, NULL, pixels);
    both = draw_opened(&(stp_model_desc){.path = "x", .bytes = bytes, .size = size}, NULL, pixels);
    none = draw_opened(&(stp_model_desc){0}, NULL, pixels);
    free(bytes);
    CHECK_EQUAL(STP_ERROR_IO, whole);
    CHECK_EQUAL(STP_ERROR_IO, streamed);
    CHECK(cut == STP_ERROR_TRUNCATED || cut == STP_ERROR_FORMAT);
    CHECK_EQUAL(STP_ERROR_ARGUMENT, both);
    CHECK_EQUAL(STP_ERROR_ARGUMENT, none);
}

void test_embed_draws_partial_downloads(test_state* test)
{
    static uint8_t pixels[PIXELS];
    size_t size = 0;
    void* bytes = embed_build_town(false, &size);
    stp_context* context = test_context(NULL, 1, NULL);
    stp_model* model = NULL;
    stp_model_info info = {0};
    stp_model_desc desc = {.bytes = bytes, .size = size - size / 4, .accept_prefix = true};
    stp_result opened = stp_model_open(context, &desc, &model);
    stp_result asked = opened == STP_OK ? stp_model_get_info(model, &info) : opened;
    stp_result drawn = opened == STP_OK ? embed_draw(model, NULL, pixels) : opened;
    stp_model_close(model);
    desc.accept_prefix = false;
    stp_result refused = stp_model_open(context, &desc, &model);
    stp_context_destroy(context);
    free(bytes);
    CHECK(opened == STP_OK && asked == STP_OK && drawn == STP_OK);
    CHECK(info.file_bytes == size && info.present_bytes == size - size / 4);
    CHECK(covered(pixels) > 0);
    CHECK_EQUAL(STP_ERROR_TRUNCATED, refused);
}

/// An open town.
typedef struct opened_town {
    void* bytes;
    test_log log;
    stp_context* context;
    stp_model* model;
} opened_town;

static bool open_town(opened_town* town, const stp_model_desc* options)
{
    size_t size = 0;
    stp_model_desc desc = *options;
    *town = (opened_town){.bytes = embed_build_town(true, &size)};
    town->context = test_context(NULL, 2, &town->log);
    desc.bytes = town->bytes;
    desc.size = size;
    return town->bytes != NULL && stp_model_open(town->context, &desc, &town->model) == STP_OK;
}

static void close_town(opened_town* town)
{
    stp_model_close(town->model);
    stp_context_destroy(town->context);
    free(town->bytes);
}

static const char* fault_of_info(const stp_model* model)
{
    stp_model_info info = {0};
    stp_method_info method = {0};
    stp_source_info source = {0};
    stp_attribute_info intensity = {0};
    stp_view view = {.width = 100, .height = 50};
    uint32_t both =
        stp_attribute_bit(STP_ATTRIBUTE_INTENSITY) | stp_attribute_bit(STP_ATTRIBUTE_CLASS);
    if (stp_model_get_info(model, &info) != STP_OK || info.point_count != EMBED_POINTS ||
        info.triangle_count != 12 + 3 * 1152 || info.stored_triangle_count != 12 + 1152) {
        fprintf(stderr, "%llu triangles, %llu stored\n", (unsigned long long)info.triangle_count,
                (unsigned long long)info.stored_triangle_count);
        return "counts";
    }
    if (info.attributes != both || info.up != 'y' || info.unit_metres != 0.0 ||
        info.file_bytes != info.present_bytes || info.bounds.max.y < 4.9) {
        return "figures";
    }
    if (stp_model_get_method(model, 0, &method) != STP_OK || strcmp(method.name, "blue") != 0 ||
        stp_model_get_method(model, info.method_count, &method) != STP_ERROR_ARGUMENT) {
        return "methods";
    }
    if (stp_model_get_source(model, 0, &source) != STP_OK || strcmp(source.path, "memory") != 0 ||
        stp_model_get_source(model, 1, &source) != STP_ERROR_ARGUMENT) {
        return "sources";
    }
    if (stp_model_get_attribute(model, STP_ATTRIBUTE_INTENSITY, &intensity) != STP_OK ||
        intensity.count != EMBED_POINTS || intensity.high != 40.0 * (EMBED_POINTS - 1) ||
        stp_model_get_attribute(model, STP_ATTRIBUTE_TIME, &intensity) != STP_ERROR_ARGUMENT) {
        return "attributes";
    }
    if (stp_model_get_view_name(model, 0) != NULL ||
        stp_model_get_view(model, NULL, &view) != STP_OK || view.fov_degrees != 40.0 ||
        stp_model_get_view(model, "nowhere", &view) != STP_ERROR_ARGUMENT) {
        return "views";
    }
    return NULL;
}

void test_embed_describes_a_model(test_state* test)
{
    opened_town town;
    bool opened = open_town(&town, &(stp_model_desc){0});
    const char* fault = opened ? fault_of_info(town.model) : "not opened";
    if (fault != NULL) {
        fprintf(stderr, "%s: %s\n", fault, town.log.text);
    }
    close_town(&town);
    CHECK(fault == NULL);
}

static const char* fault_of_tree(stp_model* model)
{
    stp_object_info info = {0};
    uint32_t town, balls, children[8], count;
    if (stp_model_find_object(model, "town", 0, &town) != STP_OK || town == STP_NO_OBJECT ||
        stp_model_get_object(model, town, &info) != STP_OK || strcmp(info.name, "town") != 0 ||
        strcmp(info.id, "{\"key\":7}") != 0 || info.child_count != 2 || !info.placed) {
        return "town";
    }
    if (stp_model_get_children(model, town, 0, 8, children, &count) != STP_OK || count != 2 ||
        stp_model_get_children(model, town, 1, 8, children, &count) != STP_OK || count != 1) {
        return "children";
    }
    if (stp_model_find_object(model, "town/balls", 0, &balls) != STP_OK || balls != children[0] ||
        stp_model_get_object(model, balls, &info) != STP_OK || info.parent != town ||
        info.bounds.min.y < 2.9 || info.bounds.max.x < 3.9) {
        return "balls";
    }
    if (stp_model_find_object(model, "balls", balls + 1, &balls) != STP_OK ||
        balls != STP_NO_OBJECT || stp_model_get_object(model, 1000, &info) != STP_ERROR_ARGUMENT) {
        return "what is not there";
    }
    if (stp_model_get_object(model, STP_NO_OBJECT, &info) != STP_OK || info.name != NULL ||
        info.point_count != EMBED_POINTS || info.parent != STP_NO_OBJECT) {
        return "the whole";
    }
    return NULL;
}

void test_embed_lists_objects(test_state* test)
{
    opened_town town;
    bool opened = open_town(&town, &(stp_model_desc){0});
    const char* fault = opened ? fault_of_tree(town.model) : "not opened";
    if (fault != NULL) {
        fprintf(stderr, "%s: %s\n", fault, town.log.text);
    }
    close_town(&town);
    CHECK(fault == NULL);
}

void test_embed_hides_objects(test_state* test)
{
    static uint8_t all[PIXELS], less[PIXELS], again[PIXELS];
    opened_town town;
    uint32_t balls = STP_NO_OBJECT;
    stp_paint_desc solid = {.triangles_only = true};
    bool drawn =
        open_town(&town, &(stp_model_desc){0}) &&
        stp_model_find_object(town.model, "balls", 0, &balls) == STP_OK &&
        embed_draw(town.model, &solid, all) == STP_OK &&
        stp_model_set_appearance(town.model, balls, STP_APPEARANCE_HIDDEN) == STP_OK &&
        embed_draw(town.model, &solid, less) == STP_OK &&
        stp_model_set_appearance(town.model, STP_NO_OBJECT, STP_APPEARANCE_SHOWN) == STP_OK &&
        embed_draw(town.model, &solid, again) == STP_OK;
    close_town(&town);
    CHECK(drawn);
    CHECK(covered(less) < covered(all) - 100);
    CHECK(memcmp(all, again, PIXELS) == 0);
}

void test_embed_colors_points_and_hides_classes(test_state* test)
{
    static uint8_t plain[PIXELS], colored[PIXELS], half[PIXELS];
    stp_model_desc by_intensity = {
        .point_coloring = {.by_attribute = true, .attribute = STP_ATTRIBUTE_INTENSITY}};
    stp_model_desc without = {.point_coloring = {.class_hidden = {[6] = 1}}};
    stp_model_desc wrong = {
        .point_coloring = {.by_attribute = true, .attribute = STP_ATTRIBUTE_TIME}};
    opened_town town;
    bool drawn =
        open_town(&town, &(stp_model_desc){0}) && embed_draw(town.model, NULL, plain) == STP_OK;
    close_town(&town);
    drawn =
        open_town(&town, &by_intensity) && embed_draw(town.model, NULL, colored) == STP_OK && drawn;
    close_town(&town);
    drawn = open_town(&town, &without) && embed_draw(town.model, NULL, half) == STP_OK && drawn;
    close_town(&town);
    bool refused = !open_town(&town, &wrong) && town.log.errors == 1;
    close_town(&town);
    CHECK(drawn && refused);
    CHECK(memcmp(plain, colored, PIXELS) != 0 && covered(plain) == covered(colored));
    CHECK(covered(half) < covered(plain) - 100);
}

void test_embed_picks_and_measures(test_state* test)
{
    opened_town town;
    stp_view view = embed_view();
    stp_hit on_box = {0}, on_ball = {0}, on_point = {0}, nothing = {0};
    uint32_t box = 0, balls = 0;
    view.eye = (stp_vec3d){0, 0, 11};
    view.target = (stp_vec3d){0, 0, 0};
    double middle = EMBED_SIDE / 2.0;
    bool picked = open_town(&town, &(stp_model_desc){0}) &&
                  stp_model_find_object(town.model, "box", 0, &box) == STP_OK &&
                  stp_model_find_object(town.model, "balls", 0, &balls) == STP_OK &&
                  stp_model_pick(town.model, &view, middle, middle, &on_box) == STP_OK &&
                  stp_model_pick(town.model, &view, 0.5, EMBED_SIDE - 0.5, &nothing) == STP_OK;
    view.eye = (stp_vec3d){0, 4, 11};
    view.target = (stp_vec3d){0, 4, 0};
    picked = picked && stp_model_pick(town.model, &view, middle, middle, &on_ball) == STP_OK;
    view.eye = (stp_vec3d){3.0, 2.0, 0.0};
    view.target = (stp_vec3d){3.0, 2.0, -6.0};
    picked = picked && stp_model_pick(town.model, &view, middle, middle, &on_point) == STP_OK;
    char text[32];
    stp_distance distance = stp_measure_distance(on_box.position, on_ball.position);
    stp_measure_text(&(stp_measuring){.unit_metres = 1.0, .up = 'y'}, distance.height, 3, text,
                     sizeof(text));
    close_town(&town);
    CHECK(picked && on_box.hit && on_ball.hit && on_point.hit && !nothing.hit);
    CHECK(on_box.distance > 9.999 && on_box.distance < 10.001 && on_box.object == box);
    CHECK(on_box.placed_object == box && on_box.normal.z > 0.99 && !on_box.is_point);
    CHECK_EQUAL(balls, on_ball.object);
    CHECK(on_ball.position.z > 0.98 && on_ball.position.z < 1.001);
    CHECK(on_point.is_point && on_point.values[STP_ATTRIBUTE_CLASS] == 6.0);
    CHECK(on_point.values[STP_ATTRIBUTE_INTENSITY] > 0.0);
    CHECK(strcmp(text, "4 m") == 0);
}

static const char* fault_of_options(opened_town* town, uint8_t* pixels)
{
    const stp_paint_desc wrong[] = {{.splat_size = 0.5f},
                                    {.budget_ms = -1.0},
                                    {.method = "none"},
                                    {.ghost = 2.0f},
                                    {.samples = 65},
                                    {.eye_dome = -1.0f},
                                    {.splat_size = 1e30f * 1e30f},
                                    {.pixel_filter = (stp_pixel_filter)3}};
    for (size_t i = 0; i < sizeof(wrong) / sizeof(wrong[0]); ++i) {
        int before = town->log.errors;
        if (embed_draw(town->model, &wrong[i], pixels) != STP_ERROR_ARGUMENT ||
            town->log.errors != before + 1) {
            fprintf(stderr, "options %zu: ", i);
            return town->log.text;
        }
    }
    const stp_paint_desc right[] = {{.samples = 2},
                                    {.smooth = true},
                                    {.eye_dome = 1.0f},
                                    {.splat_count = 500},
                                    {.caps = true},
                                    {.background = true},
                                    {.ambient_occlusion = 0.1f},
                                    {.headlight = true},
                                    {.method = "blue"},
                                    {.coloring = STP_PIXELS_NORMALS},
                                    {.coloring = STP_PIXELS_ELEVATION},
                                    {.accumulate = true},
                                    {.pixel_filter = STP_PIXEL_FILTER_ON},
                                    {.budget_ms = 10.0}};
    for (size_t i = 0; i < sizeof(right) / sizeof(right[0]); ++i) {
        if (embed_draw(town->model, &right[i], pixels) != STP_OK) {
            fprintf(stderr, "options %zu: ", i);
            return town->log.text;
        }
    }
    return NULL;
}

void test_embed_checks_options(test_state* test)
{
    static uint8_t pixels[PIXELS];
    opened_town town;
    bool opened = open_town(&town, &(stp_model_desc){0});
    const char* fault = opened ? fault_of_options(&town, pixels) : "not opened";
    if (fault != NULL) {
        fprintf(stderr, "%s\n", fault);
    }
    close_town(&town);
    CHECK(fault == NULL);
}

/// Draws without a budget at the least resolution, with smaller splats, and enlarges.
static stp_result draw_enlarged(stp_model* model, stp_paint_desc desc, uint8_t* pixels)
{
    static uint8_t small_pixels[PIXELS];
    stp_view view = embed_view();
    stp_painter* painter = NULL;
    stp_context* context = test_context(NULL, 1, NULL);
    stp_enlargement e = {0};
    view.width = view.height = EMBED_SIDE / 4;
    desc.splat_size *= 0.25f;
    stp_image small = {EMBED_SIDE / 4, EMBED_SIDE / 4, small_pixels};
    stp_image image = {EMBED_SIDE, EMBED_SIDE, pixels};
    stp_result result = stp_painter_create(model, NULL, &painter);
    result = result == STP_OK ? stp_painter_draw(painter, &view, &desc, &small, NULL) : result;
    result = result == STP_OK ? stp_enlarge_picture(context, &e, &small, 1, &image) : result;
    stp_enlargement_destroy(context, &e);
    stp_context_destroy(context);
    stp_painter_destroy(painter);
    return result;
}

// A budget that nothing meets leaves effects out, then three quarters of rows and columns.
void test_embed_budget_leaves_effects_out(test_state* test)
{
    static uint8_t plain[PIXELS], dark[PIXELS], budgeted[PIXELS], resting[PIXELS];
    const stp_paint_desc none = {.splat_size = 24.0f, .pixel_filter = STP_PIXEL_FILTER_ON};
    const stp_paint_desc occlusion = {.splat_size = 24.0f, .ambient_occlusion = 0.1f};
    stp_paint_desc budget = {
        .budget_ms = 1e-6, .splat_size = 24.0f, .ambient_occlusion = 0.1f, .samples = 2};
    stp_paint_report report = {.struct_size = sizeof(report)};
    const stp_view view = embed_view();
    opened_town town;
    stp_painter* painter = NULL;
    CHECK(open_town(&town, &(stp_model_desc){0}));
    CHECK(draw_enlarged(town.model, none, plain) == STP_OK);
    CHECK(draw_enlarged(town.model, occlusion, dark) == STP_OK);
    CHECK_EQUAL(STP_OK, stp_painter_create(town.model, NULL, &painter));
    for (int i = 0; i < 9; ++i) { // three frames find out what they take
        stp_image image = {.width = EMBED_SIDE, .height = EMBED_SIDE, .pixels = budgeted};
        CHECK_EQUAL(STP_OK, stp_painter_draw(painter, &view, &budget, &image, &report));
    }
    CHECK_EQUAL(1, report.samples);
    CHECK(report.resolution == 0.25f && fabsf(report.splat_size - 24.0f) < 1e-3f);
    budget.accumulate = true;
    stp_image image = {.width = EMBED_SIDE, .height = EMBED_SIDE, .pixels = resting};
    CHECK_EQUAL(STP_OK, stp_painter_draw(painter, &view, &budget, &image, &report));
    CHECK(report.resolution == 1.0f && fabsf(report.splat_size - 24.0f) < 1e-3f);
    stp_painter_destroy(painter);
    close_town(&town);
    CHECK(memcmp(plain, dark, sizeof(plain)) != 0);
    CHECK_EQUAL(0, memcmp(plain, budgeted, sizeof(plain)));
    CHECK(memcmp(plain, resting, sizeof(plain)) != 0);
}
