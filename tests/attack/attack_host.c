// SPDX-License-Identifier: MIT
// A clumsy host of the library, for scripts/attack: missing pointers, wrong counts, numbers and
// orders of calls, allocators and readers that fail, several threads.
//
//   attack_host arguments|allocator|reader|threads FILE.stip SEED
//
// Each failed call must log one sentence, or none if its object is missing, and leave no memory.
// Exits with 0, or with 1 and a sentence.
#include <stipple/stipple.h>

#include <math.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 96, ROW = 4 * SIDE + 12, CALLS = 1500, POINTS = 300, THREADS = 3 };

static void* file_bytes;
static size_t file_size;

_Noreturn static void fail(const char* format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("stipple: attack_host: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    exit(1);
}

static void read_file(const char* path)
{
    FILE* file = fopen(path, "rb");
    long size = file != NULL && fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    if (size <= 0 || fseek(file, 0, SEEK_SET) != 0) {
        fail("%s cannot be read", path);
    }
    file_size = (size_t)size;
    file_bytes = aligned_alloc(64, (file_size + 63) / 64 * 64);
    if (file_bytes == NULL || fread(file_bytes, 1, file_size, file) != file_size) {
        fail("%s cannot be read", path);
    }
    fclose(file);
}

// Random choices.

static uint64_t state;

static uint32_t below(uint32_t end)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (uint32_t)(state >> 32) % end;
}

static double number(void)
{
    static const double numbers[] = {0,           -0.0,
                                     1,           -1,
                                     0.5,         2,
                                     1e-320,      1e-160,
                                     1e-3,        1e3,
                                     1e18,        1e24,
                                     1e30,        3.4e38,
                                     1e300,       -1e300,
                                     179.9,       359.0,
                                     60.0,        60.0,
                                     1e-300,      (double)INFINITY,
                                     (double)NAN, -(double)INFINITY};
    return numbers[below(sizeof(numbers) / sizeof(numbers[0]))];
}

static size_t count(void)
{
    static const size_t counts[] = {0, 1, 2, 3, 6, 6, SIZE_MAX, SIZE_MAX / 12, UINT32_MAX};
    return counts[below(sizeof(counts) / sizeof(counts[0]))];
}

static uint32_t small(void)
{
    static const uint32_t numbers[] = {0, 0,    1,          1,          2,         3,
                                       7, 1000, 0x7FFFFFFF, 0xFFFFFFFE, 0xFFFFFFFF};
    return numbers[below(sizeof(numbers) / sizeof(numbers[0]))];
}

/// Mostly the pointer; sometimes NULL.
static void* maybe(void* pointer)
{
    return below(10) == 0 ? NULL : pointer;
}

static char* text(void)
{
    static const char* const texts[] = {
        "",   "box",      "blue",  "spt,psp", "stochastic", "blue,blue", "iso", "front",
        "#0", "#9999999", "a/b/c", "x",       "\x1b",       "nowhere/",  ",",   "psp"};
    static char copy[32];
    strcpy(copy, texts[below(sizeof(texts) / sizeof(texts[0]))]);
    return copy;
}

// A context that counts errors.

static void log_message(stp_log_level level, const char* message, void* user)
{
    if (level == STP_LOG_ERROR) {
        atomic_fetch_add((atomic_int*)user, 1);
        if (message[0] == '\0') {
            fail("an empty message");
        }
    }
}

/// Checks how a call ended. `there`: it had its object.
static void check(const char* call, stp_result result, int errors, bool there)
{
    if (result == STP_OK ? errors != 0 : errors != (there ? 1 : 0)) {
        fail("%s: %s, with %d messages", call, stp_result_string(result), errors);
    }
}

typedef struct host {
    stp_context* context;
    atomic_int errors;
    stp_model* model;
    stp_painter* painter;
    stp_builder* builder;
    uint8_t pixels[ROW * SIDE];
    float depths[SIDE * SIDE];
} host;

#define CALL(h, object, call)                                                                      \
    do {                                                                                           \
        atomic_store(&(h)->errors, 0);                                                             \
        const void* object_ = (object);                                                            \
        stp_result result_ = (call);                                                               \
        check(#call, result_, atomic_load(&(h)->errors), object_ != NULL);                         \
    } while (0)

static stp_view random_view(host* h)
{
    static const uint32_t sizes[] = {SIDE, SIDE, SIDE, SIDE, 0, 1, 7, 65537, 0xFFFFFFFF};
    stp_view view = {.width = SIDE, .height = SIDE};
    if (stp_model_get_view(h->model, "iso", &view) != STP_OK) {
        fail("no standard view");
    }
    double* numbers[] = {&view.eye.x,         &view.eye.y,       &view.target.z,
                         &view.up.x,          &view.fov_degrees, &view.ortho_height,
                         &view.near_distance, &view.eye_distance};
    if (below(3) > 0) {
        *numbers[below(8)] = number();
    }
    if (below(6) == 0) {
        view.width = sizes[below(9)];
        view.height = sizes[below(9)];
    }
    if (below(4) == 0) {
        view.sections.count = small();
        view.sections.planes[0] = (stp_section_plane){{number(), 1, number()}, number()};
    }
    return view;
}

static void draw(host* h)
{
    static const uint32_t samples[] = {0, 1, 2, 65, 0xFFFFFFFF};
    static const size_t strides[] = {0, 0, 4 * SIDE, ROW, 4 * SIDE - 1, 1};
    stp_view view = random_view(h);
    stp_image image = {SIDE, SIDE, maybe(h->pixels)};
    stp_paint_desc paint = {.splat_size = (float)number(),
                            .samples = samples[below(5)],
                            .smooth = below(4) == 0,
                            .triangles_only = below(4) == 0,
                            .splats_only = below(4) == 0,
                            .accumulate = below(4) == 0,
                            .caps = below(4) == 0,
                            .coloring = (stp_pixel_coloring)(below(6) < 5 ? below(3) : small()),
                            .stride = strides[below(6)]};
    switch (below(8)) {
    case 0:
        paint.budget_ms = number();
        break;
    case 1:
        paint.eye_dome = (float)number();
        break;
    case 2:
        paint.ambient_occlusion = (float)number();
        break;
    case 3:
        paint.ghost = (float)number();
        break;
    case 4:
        paint.elevation[0] = number();
        paint.elevation[1] = number();
        break;
    case 5:
        paint.method = text();
        break;
    case 6:
        paint.splat_count = small();
        break;
    default:
        paint.splat_size = 1.0f;
    }
    stp_painter* painter = maybe(h->painter);
    CALL(h, painter, stp_painter_draw(painter, maybe(&view), maybe(&paint), maybe(&image), NULL));
    CALL(h, painter,
         stp_painter_get_depths(painter, maybe(h->depths), below(2) ? SIDE * SIDE : small()));
    stp_painter_set_stopped(painter, below(2) == 0);
    (void)stp_painter_get_texture(painter);
}

static void query(host* h)
{
    stp_model* model = maybe(h->model);
    stp_view view = random_view(h);
    stp_hit hit = {0};
    stp_model_info info = {0};
    stp_object_info object = {0};
    stp_method_info method = {0};
    stp_source_info source = {0};
    stp_attribute_info attribute = {0};
    stp_stream_info stream = {0};
    uint32_t found, children[3];
    stp_hit_desc how = {.back_faces = small() % 2 == 0};
    CALL(h, model, stp_model_pick(model, maybe(&view), number(), number(), maybe(&hit)));
    CALL(h, model,
         stp_model_pick_with(model, maybe(&view), maybe(&how), number(), number(), maybe(&hit)));
    CALL(h, model, stp_model_get_info(model, maybe(&info)));
    CALL(h, model, stp_model_get_object(model, small(), maybe(&object)));
    CALL(h, model,
         stp_model_get_children(model, small(), small(), 3, maybe(children), maybe(&found)));
    CALL(h, model, stp_model_find_object(model, maybe(text()), small(), maybe(&found)));
    CALL(h, model, stp_model_set_appearance(model, small(), (stp_appearance)small()));
    CALL(h, model, stp_model_get_view(model, maybe(text()), maybe(&view)));
    CALL(h, model, stp_model_get_method(model, small(), maybe(&method)));
    CALL(h, model, stp_model_get_source(model, small(), maybe(&source)));
    CALL(h, model, stp_model_get_attribute(model, (stp_attribute)small(), maybe(&attribute)));
    CALL(h, model, stp_model_get_stream(model, maybe(&stream)));
    (void)stp_model_get_view_name(model, small());
}

static void add(host* h, bool clumsy)
{
    static float positions[3 * POINTS];
    static const uint32_t indices[6] = {0, 1, 2, 1, 2, 3};
    for (int i = 0; i < 3 * POINTS; ++i) {
        positions[i] = (float)below(1000) / 100.0f;
    }
    positions[5] = clumsy ? (float)number() : 1.0f;
    stp_builder* builder = clumsy ? maybe(h->builder) : h->builder;
    uint32_t part = 0, material = 0, object;
    uint8_t texels[16] = {255};
    stp_image picture = {2, clumsy ? small() % 3 : 2, clumsy ? maybe(texels) : texels};
    stp_material_desc surface = {.picture = &picture,
                                 .metallic = clumsy ? (float)number() : 0.0f,
                                 .alpha_cutoff = clumsy ? (float)number() : 0.0f};
    stp_mesh_desc mesh = {.positions = positions,
                          .vertex_count = clumsy ? count() : 6,
                          .indices = indices,
                          .triangle_count = clumsy ? count() % 3 : 2,
                          .material = clumsy ? small() : 0};
    stp_points_desc points = {.positions = clumsy ? maybe(positions) : positions,
                              .point_count = clumsy ? count() : POINTS};
    stp_object_desc placed = {.parts = &part,
                              .part_count = clumsy ? below(2) : 1,
                              .parent = clumsy ? small() : 0,
                              .transform.m = {{1, 0, 0, clumsy ? number() : 0}, {0, 1}, {0, 0, 1}}};
    CALL(h, builder,
         stp_builder_add_material(builder, &surface, clumsy ? maybe(&material) : &material));
    CALL(h, builder, stp_builder_add_mesh(builder, &mesh, &part));
    CALL(h, builder, stp_builder_add_points(builder, &points, NULL));
    CALL(h, builder, stp_builder_add_object(builder, &placed, clumsy ? maybe(&object) : &object));
    if (clumsy && below(8) == 0) {
        CALL(h, builder, stp_builder_add_file(builder, maybe(text())));
    }
}

static void build(host* h)
{
    stp_builder_desc desc = {.up = below(8) ? 'z' : 'q', .unit_metres = below(4) ? 1 : number()};
    CALL(h, h->context, stp_builder_create(h->context, maybe(&desc), &h->builder));
    for (uint32_t i = 0, adds = h->builder != NULL ? 1 + below(4) : 0; i < adds; ++i) {
        add(h, true);
    }
    stp_write_desc write = {.methods = below(2) ? NULL : text(),
                            .path = below(8) ? NULL : "nowhere/a.stip",
                            .folder = below(8) ? NULL : text(),
                            .splat_limit = small() % 1001, // more take long
                            .threshold = small()};
    for (int i = 0; i < 2; ++i) {
        CALL(h, h->builder, stp_builder_write(h->builder, &write, NULL));
    }
    size_t size;
    (void)stp_builder_get_bytes(h->builder, maybe(&size));
    stp_builder_destroy(h->builder);
    h->builder = NULL;
}

static void order(host* h)
{
    float positions[30];
    uint32_t places[10], ordered;
    for (int i = 0; i < 30; ++i) {
        positions[i] = (float)below(7);
    }
    positions[4] = below(4) == 0 ? (float)number() : 1.0f;
    stp_order_desc desc = {.kind = (stp_order_kind)(below(6)),
                           .metric = (stp_order_metric)below(3),
                           .samples = small() % 1001,
                           .interval = small(),
                           .drop_factor = below(2) ? 0.0f : (float)number(),
                           .thread_count = small()};
    stp_context* context = maybe(h->context);
    CALL(h, context,
         stp_order_points(context, maybe(&desc), maybe(positions), below(2) ? NULL : positions, 10,
                          below(11), maybe(places), NULL, maybe(&ordered), NULL, NULL));
}

static void open_all(host* h)
{
    stp_model_desc desc = {.bytes = file_bytes, .size = file_size, .stream = below(2) == 0};
    stp_context_desc own = {
        .log = log_message, .log_user = &h->errors, .thread_count = 1 + below(3)};
    if (stp_context_create(&h->context, &own) != STP_OK) {
        fail("no context");
    }
    CALL(h, h->context, stp_model_open(h->context, &desc, &h->model));
    CALL(h, h->model, stp_painter_create(h->model, NULL, &h->painter));
}

// Debug builds assert that nothing is left.
static void close_all(host* h)
{
    stp_builder_destroy(h->builder);
    stp_painter_destroy(h->painter);
    stp_model_close(h->model);
    stp_context_destroy(h->context);
}

static void attack_arguments(void)
{
    static host h;
    open_all(&h);
    for (int i = 0; i < CALLS; ++i) {
        switch (below(8)) {
        case 0:
            if (below(4) == 0) {
                build(&h);
            }
            break;
        case 1:
            order(&h);
            break;
        case 2:
        case 3:
            query(&h);
            break;
        default:
            draw(&h);
        }
    }
    stp_measuring measuring = {number(), number(), 'z'};
    char shown[8];
    stp_measure_text(maybe(&measuring), number(), (int)small(), maybe(shown), sizeof(shown));
    close_all(&h);
}

// An allocator that fails.

typedef struct heap {
    atomic_long allocations, live;
    long fails_at; ///< 0: never
    bool forever;
} heap;

static void* heap_alloc(size_t size, size_t alignment, void* user)
{
    heap* h = user;
    long n = atomic_fetch_add(&h->allocations, 1) + 1;
    if (h->fails_at != 0 && (n == h->fails_at || (h->forever && n > h->fails_at))) {
        return NULL;
    }
    void* memory = aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
    atomic_fetch_add(&h->live, memory != NULL);
    return memory;
}

static void heap_free(void* memory, size_t size, void* user)
{
    (void)size;
    atomic_fetch_sub(&((heap*)user)->live, memory != NULL);
    free(memory);
}

static stp_result use_model(host* h, bool stream)
{
    stp_view view = {.width = SIDE, .height = SIDE};
    stp_image image = {SIDE, SIDE, h->pixels};
    stp_model_desc desc = {.bytes = file_bytes, .size = file_size, .stream = stream};
    stp_paint_desc paint = {.complete = true, .smooth = stream};
    stp_hit hit = {0};
    uint32_t object;
    stp_result result = stp_model_open(h->context, &desc, &h->model);
    result = result == STP_OK ? stp_painter_create(h->model, NULL, &h->painter) : result;
    result = result == STP_OK ? stp_model_get_view(h->model, "iso", &view) : result;
    result = result == STP_OK ? stp_painter_draw(h->painter, &view, &paint, &image, NULL) : result;
    result = result == STP_OK ? stp_model_pick(h->model, &view, 48, 48, &hit) : result;
    return result == STP_OK ? stp_model_find_object(h->model, "x", 0, &object) : result;
}

static stp_result use_builder(host* h, const char* methods)
{
    static float positions[3 * POINTS];
    static const uint32_t indices[6] = {0, 1, 2, 1, 2, 3};
    for (uint32_t i = 0; i < 3 * POINTS; ++i) {
        positions[i] = (float)(i * 2654435761u >> 8 & 1023) / 100.0f;
    }
    stp_mesh_desc mesh = {
        .positions = positions, .vertex_count = 6, .indices = indices, .triangle_count = 2};
    stp_points_desc points = {.positions = positions, .point_count = POINTS};
    stp_write_desc write = {.methods = methods, .threshold = 1, .splat_limit = 50, .folder = "."};
    stp_result result = stp_builder_create(h->context, NULL, &h->builder);
    result = result == STP_OK ? stp_builder_add_mesh(h->builder, &mesh, NULL) : result;
    result = result == STP_OK ? stp_builder_add_points(h->builder, &points, NULL) : result;
    return result == STP_OK ? stp_builder_write(h->builder, &write, NULL) : result;
}

static void attack_allocator(void)
{
    static const char* const methods[] = {"blue", "spt", "psp", "stochastic"};
    static host h;
    uint32_t what = below(6), threads = 1 + below(2);
    long n = 1;
    for (bool complete = false; !complete; n += 1 + (n > 50 ? (long)below(60) : 0)) {
        heap memory = {.fails_at = n, .forever = below(2) == 0};
        stp_context_desc desc = {.allocator = {heap_alloc, heap_free, &memory},
                                 .log = log_message,
                                 .log_user = &h.errors,
                                 .thread_count = threads};
        memset(&h, 0, sizeof(h));
        stp_result result = stp_context_create(&h.context, &desc);
        if (result == STP_OK) {
            result = what < 2 ? use_model(&h, what == 1) : use_builder(&h, methods[what - 2]);
            check("a use with a failing allocator", result, atomic_load(&h.errors), true);
            close_all(&h);
        }
        complete = atomic_load(&memory.allocations) < n;
        if (atomic_load(&memory.live) != 0 || (complete && result != STP_OK)) {
            fail("allocation %ld: %ld blocks are left, %s", n, atomic_load(&memory.live),
                 stp_result_string(result));
        }
    }
}

// A reader that fails or gives other bytes.

typedef struct reader {
    atomic_long reads;
    long fails_at;
    uint32_t spoils; ///< 0: nothing; else the kind of damage
} reader;

static int read_file_part(void* user, uint64_t offset, void* bytes, size_t size)
{
    reader* r = user;
    long n = atomic_fetch_add(&r->reads, 1);
    if (offset > file_size || size > file_size - offset || (r->spoils == 0 && n >= r->fails_at)) {
        return -1;
    }
    memcpy(bytes, (const unsigned char*)file_bytes + offset, size);
    if (r->spoils == 1 && size > 0) {
        ((unsigned char*)bytes)[(size_t)n * 7919 % size] ^= 1u << n % 8;
    } else if (r->spoils > 1 && n >= r->fails_at) {
        memset(bytes, r->spoils == 2 ? 0 : 0xFF, size / r->spoils);
    }
    return 0;
}

static void attack_reader(void)
{
    static host h;
    for (long n = 0; n < 40; ++n) {
        reader r = {.fails_at = n, .spoils = below(5)};
        stp_context_desc desc = {.log = log_message, .log_user = &h.errors, .thread_count = 2};
        stp_model_desc opening = {
            .read = read_file_part, .read_user = &r, .size = file_size, .stream = below(2) == 0};
        memset(&h, 0, sizeof(h));
        if (stp_context_create(&h.context, &desc) != STP_OK) {
            fail("no context");
        }
        CALL(&h, h.context, stp_model_open(h.context, &opening, &h.model));
        if (h.model != NULL) {
            stp_view view = {.width = SIDE, .height = SIDE};
            stp_image image = {SIDE, SIDE, h.pixels};
            stp_paint_desc paint = {.complete = below(2) == 0};
            stp_hit hit = {0};
            CALL(&h, h.model, stp_painter_create(h.model, NULL, &h.painter));
            CALL(&h, h.model, stp_model_get_view(h.model, "iso", &view));
            CALL(&h, h.painter, stp_painter_draw(h.painter, &view, &paint, &image, NULL));
            CALL(&h, h.model, stp_model_pick(h.model, &view, 48, 48, &hit));
        }
        close_all(&h);
    }
}

// Threads with a context each, and one that stops their pictures.

typedef struct worker {
    host h;
    atomic_bool ready, done;
    const char* methods;
} worker;

static void* work(void* user)
{
    worker* w = user;
    host* h = &w->h;
    stp_view view = {.width = SIDE, .height = SIDE};
    stp_image image = {SIDE, SIDE, h->pixels};
    stp_model_desc desc = {.bytes = file_bytes, .size = file_size, .stream = true};
    stp_context_desc own = {.log = log_message, .log_user = &h->errors, .thread_count = 2};
    if (stp_context_create(&h->context, &own) != STP_OK ||
        stp_model_open(h->context, &desc, &h->model) != STP_OK ||
        stp_painter_create(h->model, &(stp_painter_desc){.can_stop = true}, &h->painter) !=
            STP_OK ||
        stp_model_get_view(h->model, "iso", &view) != STP_OK) {
        fail("no painter");
    }
    atomic_store(&w->ready, true);
    for (int i = 0; i < 60; ++i) {
        stp_result result = stp_painter_draw(h->painter, &view, NULL, &image, NULL);
        if (result != STP_OK && result != STP_ERROR_CANCELLED) {
            fail("a picture of a thread: %s", stp_result_string(result));
        }
    }
    atomic_store(&h->errors, 0);
    check("a build of a thread", use_builder(h, w->methods), atomic_load(&h->errors), true);
    atomic_store(&w->done, true);
    return NULL;
}

static void attack_threads(void)
{
    static const char* const methods[THREADS] = {"blue", "psp", "stochastic"};
    static worker workers[THREADS];
    pthread_t threads[THREADS];
    for (int i = 0; i < THREADS; ++i) {
        workers[i].methods = methods[i];
        if (pthread_create(&threads[i], NULL, work, &workers[i]) != 0) {
            fail("no thread");
        }
    }
    for (int left = THREADS; left > 0;) {
        worker* w = &workers[below(THREADS)];
        if (atomic_load(&w->ready)) {
            stp_painter_set_stopped(w->h.painter, below(2) == 0);
        }
        left = 0;
        for (int i = 0; i < THREADS; ++i) {
            left += !atomic_load(&workers[i].done);
        }
    }
    for (int i = 0; i < THREADS; ++i) {
        pthread_join(threads[i], NULL);
        close_all(&workers[i].h);
    }
}

int main(int argc, char** argv)
{
    static const struct {
        const char* name;
        void (*run)(void);
    } attacks[] = {{"arguments", attack_arguments},
                   {"allocator", attack_allocator},
                   {"reader", attack_reader},
                   {"threads", attack_threads}};
    if (argc != 4) {
        fail("needs arguments|allocator|reader|threads FILE.stip SEED");
    }
    read_file(argv[2]);
    state = strtoull(argv[3], NULL, 10) * 0x9E3779B97F4A7C15u + 1;
    for (size_t i = 0; i < sizeof(attacks) / sizeof(attacks[0]); ++i) {
        if (strcmp(argv[1], attacks[i].name) == 0) {
            attacks[i].run();
            free(file_bytes);
            return 0;
        }
    }
    fail("%s is no attack", argv[1]);
}
