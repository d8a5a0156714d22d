// SPDX-License-Identifier: MIT
// Arguments that functions of the headers refuse: views, missing pointers, numbers and enums.
#include "support_embed.h"

#include <math.h>
#include <string.h>

enum { SIDE = EMBED_SIDE };

/// A model of the town with a painter; log.errors counts.
typedef struct opened {
    void* bytes;
    test_log log;
    stp_context* context;
    stp_model* model;
    stp_painter* painter;
    uint8_t pixels[SIDE * SIDE * 4];
    stp_image image;
} opened;

static bool open_town(opened* o)
{
    size_t size = 0;
    *o = (opened){.image = {SIDE, SIDE, NULL}};
    o->image.pixels = o->pixels;
    o->bytes = embed_build_town(false, &size);
    o->context = test_context(NULL, 1, &o->log);
    stp_model_desc desc = {.bytes = o->bytes, .size = size};
    return o->bytes != NULL && stp_model_open(o->context, &desc, &o->model) == STP_OK &&
           stp_painter_create(o->model, NULL, &o->painter) == STP_OK;
}

static void close_town(opened* o)
{
    stp_painter_destroy(o->painter);
    stp_model_close(o->model);
    stp_context_destroy(o->context);
    free(o->bytes);
}

#define SECTION(field) (offsetof(stp_view, sections.planes) + offsetof(stp_section_plane, field))

// Numbers of a view that are out of range: of which field, and the number.
static const struct {
    size_t field;
    double value;
} bad_numbers[] = {
    {offsetof(stp_view, fov_degrees), 0.0},
    {offsetof(stp_view, fov_degrees), 1e-160},
    {offsetof(stp_view, fov_degrees), 0.00099},
    {offsetof(stp_view, fov_degrees), 179.95},
    {offsetof(stp_view, fov_degrees), (double)NAN},
    {offsetof(stp_view, fov_degrees), -60.0},
    {offsetof(stp_view, near_distance), (double)NAN},
    {offsetof(stp_view, near_distance), (double)INFINITY},
    {offsetof(stp_view, near_distance), -1.0},
    {offsetof(stp_view, ortho_height), -5.0},
    {offsetof(stp_view, ortho_height), (double)NAN},
    {offsetof(stp_view, ortho_height), (double)INFINITY},
    {offsetof(stp_view, ortho_height), 1e-320},
    {offsetof(stp_view, eye_distance), (double)NAN},
    {offsetof(stp_view, eye_distance), -1.0},
    {offsetof(stp_view, eye_distance), 1e308},
    {offsetof(stp_view, eye.x), 1e200},
    {offsetof(stp_view, target.y), (double)NAN},
    {offsetof(stp_view, up.z), (double)INFINITY},
    {SECTION(normal.y), 0.0},
    {SECTION(normal.y), (double)NAN},
    {SECTION(distance), (double)INFINITY},
};

static stp_view view_with_section(void)
{
    stp_view view = embed_view();
    view.sections.count = 1;
    view.sections.planes[0].normal.y = 1.0;
    view.sections.planes[0].distance = 1e6;
    return view;
}

/// Draws and picks. @return whether both are refused, each with one sentence
static bool is_refused(opened* o, const stp_view* view)
{
    stp_hit hit = {0};
    o->log.errors = 0;
    stp_result drawn = stp_painter_draw(o->painter, view, NULL, &o->image, NULL);
    stp_result picked = stp_model_pick(o->model, view, 48.0, 48.0, &hit);
    return drawn == STP_ERROR_ARGUMENT && picked == STP_ERROR_ARGUMENT && o->log.errors == 2 &&
           strncmp(o->log.text, "view: ", 6) == 0;
}

void test_embed_views_are_checked(test_state* test)
{
    static opened o;
    stp_hit hit = {0};
    CHECK(open_town(&o));
    for (size_t i = 0; i < sizeof(bad_numbers) / sizeof(bad_numbers[0]); ++i) {
        stp_view view = view_with_section();
        memcpy((char*)&view + bad_numbers[i].field, &bad_numbers[i].value, sizeof(double));
        if (!is_refused(&o, &view)) {
            fprintf(stderr, "number %zu: %d errors: %s\n", i, o.log.errors, o.log.text);
            CHECK(false && "refused");
        }
    }
    stp_view many = view_with_section(), still = many, flat = many, narrow = many;
    many.sections.count = 1000;
    still.eye = still.target;
    flat.height = 0;
    narrow.width = 1;
    narrow.eye_distance = 1.0;
    CHECK(is_refused(&o, &many) && is_refused(&o, &still) && is_refused(&o, &flat));
    CHECK(is_refused(&o, &narrow));
    stp_view view = view_with_section();
    view.fov_degrees = STP_FOV_DEGREES_MIN;
    CHECK_EQUAL(STP_OK, stp_painter_draw(o.painter, &view, NULL, &o.image, NULL));
    view.fov_degrees = STP_FOV_DEGREES_MAX;
    CHECK_EQUAL(STP_OK, stp_painter_draw(o.painter, &view, NULL, &o.image, NULL));
    CHECK_EQUAL(STP_OK, stp_model_pick(o.model, &view, 48.0, 48.0, &hit));
    const double nowhere = (double)NAN; // the message names the function that was called
    CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_model_pick(o.model, &view, nowhere, 48.0, &hit));
    CHECK(strncmp(o.log.text, "stp_model_pick: ", 16) == 0);
    CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_model_pick_with(o.model, &view, NULL, nowhere, 48.0, &hit));
    CHECK(strncmp(o.log.text, "stp_model_pick_with: ", 21) == 0);
    close_town(&o);
}

/// Calls everything without its object, which nothing can log.
static bool are_refused_without_object(opened* o)
{
    uint32_t number;
    stp_view view = embed_view();
    stp_hit hit = {0};
    stp_model_info info = {0};
    stp_object_info object = {0};
    stp_method_info method = {0};
    stp_source_info source = {0};
    stp_attribute_info attribute = {0};
    stp_stream_info stream = {0};
    stp_model* model;
    stp_painter* painter;
    stp_builder* builder;
    const float position[3] = {0};
    float depth;
    const stp_result results[] = {
        stp_context_create(NULL, NULL),
        stp_model_open(NULL, NULL, &model),
        stp_model_get_info(NULL, &info),
        stp_model_get_object(NULL, 0, &object),
        stp_model_get_children(NULL, 0, 0, 1, &number, &number),
        stp_model_find_object(NULL, "box", 0, &number),
        stp_model_set_appearance(NULL, 0, STP_APPEARANCE_SHOWN),
        stp_model_get_view(NULL, NULL, &view),
        stp_model_get_method(NULL, 0, &method),
        stp_model_get_source(NULL, 0, &source),
        stp_model_get_attribute(NULL, STP_ATTRIBUTE_CLASS, &attribute),
        stp_model_get_stream(NULL, &stream),
        stp_model_pick(NULL, &view, 1.0, 1.0, &hit),
        stp_model_pick_with(NULL, &view, NULL, 1.0, 1.0, &hit),
        stp_painter_create(NULL, NULL, &painter),
        stp_painter_draw(NULL, &view, NULL, &o->image, NULL),
        stp_painter_get_depths(NULL, &depth, 1),
        stp_builder_create(NULL, NULL, &builder),
        stp_builder_add_file(NULL, "a.obj"),
        stp_builder_add_material(NULL, NULL, &number),
        stp_builder_add_mesh(NULL, NULL, NULL),
        stp_builder_add_points(NULL, NULL, NULL),
        stp_builder_add_object(NULL, NULL, NULL),
        stp_builder_write(NULL, NULL, NULL),
        stp_order_points(NULL, NULL, position, NULL, 1, 1, &number, NULL, &number, NULL, NULL),
    };
    bool refused = true;
    for (size_t i = 0; i < sizeof(results) / sizeof(results[0]); ++i) {
        refused = refused && results[i] == STP_ERROR_ARGUMENT;
    }
    stp_painter_set_stopped(NULL, true);
    size_t size = 1;
    return refused && stp_context_live_bytes(NULL) == 0 && stp_context_peak_bytes(NULL) == 0 &&
           stp_context_thread_count(NULL) == 0 && stp_model_get_view_name(NULL, 0) == NULL &&
           stp_painter_get_texture(NULL) == 0 && stp_builder_get_bytes(NULL, &size) == NULL &&
           size == 0;
}

/// Calls everything without a pointer that it needs. @return whether each logs its name
static bool are_refused_without_pointers(opened* o, stp_builder* builder)
{
    uint32_t number;
    stp_view view = embed_view();
    stp_hit hit = {0};
    const float position[3] = {0};
    const struct {
        stp_result result;
        char says[100];
    } calls[] = {
#define CALL(call) {call, ""}
        CALL(stp_model_open(o->context, NULL, NULL)),
        CALL(stp_model_get_info(o->model, NULL)),
        CALL(stp_model_get_object(o->model, 0, NULL)),
        CALL(stp_model_get_children(o->model, 0, 0, 1, NULL, &number)),
        CALL(stp_model_get_children(o->model, 0, 0, 1, &number, NULL)),
        CALL(stp_model_find_object(o->model, NULL, 0, &number)),
        CALL(stp_model_find_object(o->model, "box", 0, NULL)),
        CALL(stp_model_get_view(o->model, NULL, NULL)),
        CALL(stp_model_get_method(o->model, 0, NULL)),
        CALL(stp_model_get_source(o->model, 0, NULL)),
        CALL(stp_model_get_attribute(o->model, STP_ATTRIBUTE_CLASS, NULL)),
        CALL(stp_model_get_stream(o->model, NULL)),
        CALL(stp_model_pick(o->model, NULL, 1.0, 1.0, &hit)),
        CALL(stp_model_pick(o->model, &view, 1.0, 1.0, NULL)),
        CALL(stp_model_pick_with(o->model, NULL, NULL, 1.0, 1.0, &hit)),
        CALL(stp_painter_create(o->model, NULL, NULL)),
        CALL(stp_painter_draw(o->painter, NULL, NULL, &o->image, NULL)),
        CALL(stp_painter_get_depths(o->painter, NULL, 1)),
        CALL(stp_builder_create(o->context, NULL, NULL)),
        CALL(stp_builder_add_file(builder, NULL)),
        CALL(stp_builder_add_material(builder, NULL, NULL)),
        CALL(stp_order_points(o->context, NULL, NULL, NULL, 1, 1, &number, NULL, &number, NULL,
                              NULL)),
        CALL(stp_order_points(o->context, NULL, position, NULL, 1, 1, NULL, NULL, &number, NULL,
                              NULL)),
        CALL(stp_order_points(o->context, NULL, position, NULL, 1, 1, &number, NULL, NULL, NULL,
                              NULL)),
#undef CALL
    };
    int count = (int)(sizeof(calls) / sizeof(calls[0]));
    bool refused = o->log.errors == count && strstr(o->log.text, " is NULL") != NULL;
    for (int i = 0; i < count; ++i) {
        refused = refused && calls[i].result == STP_ERROR_ARGUMENT;
    }
    return refused;
}

void test_embed_missing_pointers_are_refused(test_state* test)
{
    static opened o;
    stp_builder* builder = NULL;
    CHECK(open_town(&o) && stp_builder_create(o.context, NULL, &builder) == STP_OK);
    CHECK(are_refused_without_object(&o));
    CHECK_EQUAL(0, o.log.errors);
    CHECK(are_refused_without_pointers(&o, builder));
    // these are allowed
    uint32_t number;
    CHECK_EQUAL(STP_OK, stp_model_get_children(o.model, STP_NO_OBJECT, 0, 0, NULL, &number));
    CHECK_EQUAL(STP_OK, stp_order_points(o.context, NULL, NULL, NULL, 0, 0, NULL, NULL, &number,
                                         NULL, NULL));
    CHECK(stp_builder_get_bytes(builder, NULL) == NULL);
    stp_builder_destroy(builder);
    close_town(&o);
}

void test_measures_without_pointers(test_state* test)
{
    const stp_vec3d square[4] = {{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}};
    double around = 1.0;
    char text[16] = "";
    CHECK(stp_measure_area(square, 4, NULL) == 1.0);
    CHECK(stp_measure_area(NULL, 4, &around) == 0.0 && around == 0.0);
    CHECK(stp_measure_coordinates(NULL, square[1]).x == 1.0);
    stp_measure_text(NULL, 1.5, 3, text, sizeof(text));
    CHECK(strcmp(text, "1.5") == 0);
    stp_measure_text(NULL, 1.5, 3, NULL, 5);
}

void test_order_checks_its_options(test_state* test)
{
    const stp_order_desc wrong[] = {{.kind = (stp_order_kind)5},     {.kind = (stp_order_kind)-1},
                                    {.metric = (stp_order_metric)2}, {.drop_factor = NAN},
                                    {.drop_factor = INFINITY},       {.drop_factor = -1.0f}};
    const float positions[6] = {0, 0, 0, 1, 0, 0};
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    int count = (int)(sizeof(wrong) / sizeof(wrong[0]));
    for (int i = 0; i < count; ++i) {
        uint32_t order[2], ordered = 7;
        CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_order_points(context, &wrong[i], positions, NULL, 2, 2,
                                                         order, NULL, &ordered, NULL, NULL));
        CHECK_EQUAL(0, ordered);
        CHECK_EQUAL(i + 1, log.errors);
        CHECK(strncmp(log.text, "stp_order_desc: ", 16) == 0);
    }
    stp_context_destroy(context);
}

void test_embed_builders_check_numbers(test_state* test)
{
    stp_affine bad = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, (double)INFINITY}}};
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_builder* builder = NULL;
    uint32_t number;
    CHECK_EQUAL(STP_OK, stp_builder_create(context, NULL, &builder));
    CHECK_EQUAL(STP_ERROR_ARGUMENT,
                stp_builder_add_object(builder, &(stp_object_desc){.transform = bad}, NULL));
    const stp_object_desc placed = {.instances = &bad, .instance_count = 1};
    CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_builder_add_object(builder, &placed, NULL));
    const stp_material_desc bright = {.base_color = {1, 2, 1, 1}};
    CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_builder_add_material(builder, &bright, &number));
    CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_builder_write(builder, NULL, NULL)); // nothing was added
    CHECK_EQUAL(4, log.errors);
    CHECK_EQUAL(STP_OK, embed_add_town(builder, false)); // and it can still be used
    stp_builder_destroy(builder);
    stp_context_destroy(context);
}
