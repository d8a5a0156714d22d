// SPDX-License-Identifier: MIT
// Drafts: the visible part of a scene during its build.
#define _GNU_SOURCE // unshare
#include "same_files.h"
#include "tests.h"

#include "builder/build_scene.h"
#include "draw/draw.h"
#include "import/las_points.h"
#include "lab/scenes/scenes.h"
#include "program/measure/image_compare.h"
#include "scene/scene_helpers.h"
#include "select/camera.h"
#include "store/file/point_attributes.h"
#include "store/file/store.h"

#include <fcntl.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

enum { SAMPLE = 640 }; // points of a scan
enum { DRAFTS = 64, WIDTH = 128, HEIGHT = 96, PIXELS = WIDTH * HEIGHT };

// A draft as a viewer sees it.
typedef struct seen_draft {
    bool whole; ///< it can be opened, checked and drawn
    uint32_t meshes, point_sets, sets, objects, unknown_signs;
    uint64_t attributes; ///< a bit for each that any point has
    uint64_t triangles, points;
    char first_name[64]; ///< name of the first object
    uint8_t pixels[4 * PIXELS];
} seen_draft;

typedef struct draft_reader {
    const char* path;
    seen_draft* drafts; ///< DRAFTS entries
    uint32_t count;
    bool only_counts; ///< no pictures, which are slow
} draft_reader;

static bool draw(stp_context* context, stp_store* store, uint8_t* pixels)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    stp_view view = {.width = WIDTH, .height = HEIGHT, .fov_degrees = 40};
    stp_renderer* renderer = NULL;
    stp_draw_list list = {0};
    stp_draw_stats stats;
    stp_draw_style style = {.headlight = true, .supersample = 2};
    stp_quality quality = {.splat_size = 1.0f};
    stp_image image = {.width = WIDTH, .height = HEIGHT, .pixels = pixels};
    bool drawn = stp_camera_frame("iso", &d->nodes[d->root].bounds, &view) &&
                 stp_draw_cpu_create(context, store, &renderer) == STP_OK &&
                 stp_renderer_draw_selected(renderer, &view, &quality, &style, &list, &image,
                                            &stats) == STP_OK;
    stp_draw_list_destroy(context, &list);
    if (renderer != NULL) {
        stp_renderer_destroy(renderer);
    }
    return drawn;
}

static void look_at(const char* path, bool draws, seen_draft* seen)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_store* store = NULL;
    if (context != NULL && stp_store_check(context, path, false) == STP_OK &&
        stp_store_open(context, path, &store) == STP_OK) {
        const stp_store_directory* d = stp_store_get_directory(store);
        *seen = (seen_draft){.meshes = d->mesh_count,
                             .point_sets = d->point_set_count,
                             .sets = d->set_count,
                             .objects = d->object_count,
                             .triangles = d->nodes[d->root].triangle_count,
                             .points = d->nodes[d->root].point_count};
        for (uint32_t i = 0; i < d->attribute_count; ++i) {
            seen->attributes |= UINT64_C(1) << d->attributes[i].attribute;
        }
        for (uint32_t i = 0; i < d->set_count; ++i) {
            seen->unknown_signs += stp_store_describe_splat_set(store, i)->unknown_signs;
        }
        snprintf(seen->first_name, sizeof(seen->first_name), "%s",
                 d->object_count > 0 && d->objects[0].name != NULL ? d->objects[0].name : "");
        seen->whole = !draws || draw(context, store, seen->pixels);
        stp_store_close(store);
    }
    stp_context_destroy(context);
}

static void on_draft(void* user)
{
    draft_reader* o = user;
    if (o->count < DRAFTS) {
        look_at(o->path, !o->only_counts, &o->drafts[o->count]);
    }
    o->count += 1;
}

static stp_result build_with(uint32_t threads, const char* input, const char* output,
                             draft_reader* o)
{
    stp_context* context = test_context(NULL, threads, NULL);
    stp_build_desc desc = {.inputs = &input,
                           .input_count = 1,
                           .output = output,
                           .generate = scene_make_input,
                           .threshold = 1,
                           .blue = {.capture = {.wanted_candidates = 4000}},
                           .splat_rule = {1e-9, 500},
                           .draft = o != NULL ? o->path : NULL,
                           .draft_sample = SAMPLE,
                           .draft_always = true,
                           .drafted = on_draft,
                           .drafted_user = o};
    stp_build_report report;
    stp_result result = stp_build(context, &desc, &report);
    stp_context_destroy(context);
    return result;
}

static stp_result build_scene(const char* input, const char* output, draft_reader* o)
{
    return build_with(1, input, output, o);
}

// Some bumpy sheets beside each other, one object each.
static bool write_sheets(const char* path)
{
    enum { SHEETS = 6, SIZE = 20, CORNERS = (SIZE + 1) * (SIZE + 1) };
    FILE* file = fopen(path, "w");
    for (int s = 0; file != NULL && s < SHEETS; ++s) {
        fprintf(file, "o sheet%d\n", s);
        for (int i = 0; i < CORNERS; ++i) {
            int x = i % (SIZE + 1), z = i / (SIZE + 1);
            fprintf(file, "v %d %d %d\n", x + 24 * s, (x * 7 + z * (11 + s)) % 5, z);
        }
        for (int i = 0; i < SIZE * SIZE; ++i) {
            int a = s * CORNERS + i / SIZE * (SIZE + 1) + i % SIZE + 1, b = a + 1, c = a + SIZE + 1;
            fprintf(file, "f %d %d %d\nf %d %d %d\n", a, c, b, b, c, c + 1);
        }
    }
    return file != NULL && fclose(file) == 0;
}

static double distance(const uint8_t* a, const uint8_t* b)
{
    double sum = 0.0;
    for (size_t i = 0; i < 4 * (size_t)PIXELS; ++i) {
        sum += abs((int)a[i] - (int)b[i]);
    }
    return sum / (4.0 * PIXELS);
}

void test_drafts_grow_to_the_finished_scene(test_state* test)
{
    char folder[] = "stp_draft_XXXXXX", draft[64], output[64], plain[64], model[64];
    CHECK(mkdtemp(folder) != NULL);
    snprintf(draft, sizeof(draft), "%s/draft.stip", folder);
    snprintf(output, sizeof(output), "%s/output.stip", folder);
    snprintf(plain, sizeof(plain), "%s/plain.stip", folder);
    snprintf(model, sizeof(model), "%s/model.obj", folder);
    CHECK(write_sheets(model));
    draft_reader o = {.path = draft, .drafts = calloc(DRAFTS + 1, sizeof(*o.drafts))};
    CHECK(o.drafts != NULL);
    CHECK_EQUAL(STP_OK, build_scene(model, output, &o));
    CHECK_EQUAL(STP_OK, build_scene(model, plain, NULL));
    CHECK(same_files(output, plain)); // drafts do not change the result
    seen_draft* last = &o.drafts[DRAFTS];
    look_at(output, true, last);
    CHECK(last->whole && last->triangles > 1000);
    CHECK(o.count > 3);
    uint32_t known = o.count < DRAFTS ? o.count : DRAFTS;
    const seen_draft* first = &o.drafts[0];
    CHECK(first->triangles == 0 && first->points > 1000 && first->points < 2000000);
    for (uint32_t i = 0; i < known; ++i) {
        const seen_draft* d = &o.drafts[i];
        CHECK(d->whole && d->objects == last->objects);
        CHECK(strcmp(d->first_name, last->first_name) == 0);
        CHECK(i == 0 || d->triangles >= o.drafts[i - 1].triangles);
        CHECK(i == 0 || d->sets >= o.drafts[i - 1].sets);
    }
    // the first draft is recognisable, and later ones come closer
    uint8_t* nothing = calloc(4, PIXELS);
    double empty = distance(nothing, last->pixels), sketch = distance(first->pixels, last->pixels);
    uint32_t triangles = 0; // index of the first draft with all triangles
    while (triangles + 1 < known && o.drafts[triangles].triangles < last->triangles) {
        triangles += 1;
    }
    CHECK(sketch < 0.7 * empty);
    CHECK(o.drafts[triangles].triangles == last->triangles && o.drafts[triangles].points == 0);
    CHECK(distance(o.drafts[triangles].pixels, last->pixels) < 0.3 * sketch);
    CHECK(o.drafts[known - 1].sets == last->sets);
    free(nothing);
    free(o.drafts);
    unlink(draft);
    unlink(output);
    unlink(plain);
    unlink(model);
    CHECK(rmdir(folder) == 0); // nothing else is left
}

void test_drafts_show_scans_before_they_are_read(test_state* test)
{
    enum { POINTS = 4000 };
    static las_point points[POINTS];
    char folder[] = "stp_draft_XXXXXX", draft[64], output[64], plain[64], model[64];
    CHECK(mkdtemp(folder) != NULL);
    snprintf(draft, sizeof(draft), "%s/draft.stip", folder);
    snprintf(output, sizeof(output), "%s/out.stip", folder);
    snprintf(plain, sizeof(plain), "%s/plain.stip", folder);
    snprintf(model, sizeof(model), "%s/scan.laz", folder);
    las_make_points(points, POINTS, 2, 7);
    las_buffer file = las_write(&(las_desc){
        .points = points, .count = POINTS, .format = 2, .coding = LAZ_CHUNKED, .chunk_size = 500});
    FILE* out = fopen(model, "wb");
    CHECK(out != NULL && fwrite(file.bytes, 1, file.size, out) == file.size && fclose(out) == 0);
    free(file.bytes);
    draft_reader o = {
        .path = draft, .only_counts = true, .drafts = calloc(DRAFTS, sizeof(*o.drafts))};
    CHECK(o.drafts != NULL);
    CHECK_EQUAL(STP_OK, build_scene(model, output, &o));
    CHECK_EQUAL(STP_OK, build_scene(model, plain, NULL));
    CHECK(o.count > 1 && o.drafts[0].whole && o.drafts[1].whole);
    CHECK_EQUAL(SAMPLE, o.drafts[0].points);
    CHECK_EQUAL(POINTS, o.drafts[1].points);
    seen_draft done;
    look_at(output, false, &done);
    CHECK(done.attributes != 0 && done.sets > 0 && done.unknown_signs == done.sets);
    uint32_t known = o.count < DRAFTS ? o.count : DRAFTS;
    for (uint32_t i = 0; i < known; ++i) { // the same colours and shading as in the end
        CHECK_EQUAL(done.attributes, o.drafts[i].attributes);
        CHECK_EQUAL(o.drafts[i].sets, o.drafts[i].unknown_signs);
    }
    CHECK(o.drafts[known - 1].sets > 0);
    CHECK(strcmp(o.drafts[0].first_name, o.drafts[1].first_name) == 0);
    CHECK(same_files(output, plain));
    free(o.drafts);
    const char* const all[] = {draft, output, plain, model};
    for (size_t i = 0; i < sizeof(all) / sizeof(all[0]); ++i) {
        unlink(all[i]);
    }
    rmdir(folder);
}

void test_drafts_stay_drawable_however_large_the_scene(test_state* test)
{
    char folder[] = "stp_draft_XXXXXX", draft[64], output[64];
    CHECK(mkdtemp(folder) != NULL);
    snprintf(draft, sizeof(draft), "%s/draft.stip", folder);
    snprintf(output, sizeof(output), "%s/output.stip", folder);
    draft_reader o = {
        .path = draft, .only_counts = true, .drafts = calloc(DRAFTS, sizeof(*o.drafts))};
    CHECK(o.drafts != NULL);
    CHECK_EQUAL(STP_OK, build_scene("scene:spheres", output, &o)); // 1.3 G triangles
    CHECK(o.count >= 2);
    for (uint32_t i = 0; i < o.count && i < DRAFTS; ++i) {
        const seen_draft* d = &o.drafts[i];
        CHECK(d->whole);
        CHECK(d->sets > 0 || (d->triangles == 0 && d->points < 4000000));
    }
    free(o.drafts);
    unlink(draft);
    unlink(output);
    CHECK(rmdir(folder) == 0);
}

void test_drafts_that_cannot_be_written_harm_nothing(test_state* test)
{
    char folder[] = "stp_draft_XXXXXX", output[64];
    CHECK(mkdtemp(folder) != NULL);
    snprintf(output, sizeof(output), "%s/output.stip", folder);
    draft_reader o = {.path = "/nowhere/there/draft.stip"};
    CHECK_EQUAL(STP_OK, build_scene("scene:boxes", output, &o));
    CHECK_EQUAL(0, o.count);
    unlink(output);
    CHECK(rmdir(folder) == 0);
}

void test_drafts_of_many_threads_change_nothing(test_state* test)
{
    char folder[] = "stp_draft_XXXXXX", draft[64], output[64], plain[64], model[64];
    CHECK(mkdtemp(folder) != NULL);
    snprintf(draft, sizeof(draft), "%s/draft.stip", folder);
    snprintf(output, sizeof(output), "%s/output.stip", folder);
    snprintf(plain, sizeof(plain), "%s/plain.stip", folder);
    snprintf(model, sizeof(model), "%s/model.obj", folder);
    CHECK(write_sheets(model));
    draft_reader o = {
        .path = draft, .only_counts = true, .drafts = calloc(DRAFTS, sizeof(*o.drafts))};
    CHECK(o.drafts != NULL);
    CHECK_EQUAL(STP_OK, build_with(4, model, output, &o));
    CHECK_EQUAL(STP_OK, build_scene(model, plain, NULL));
    CHECK(same_files(output, plain));
    CHECK(o.count > 1);
    for (uint32_t i = 0; i < o.count && i < DRAFTS; ++i) {
        CHECK(o.drafts[i].whole);
    }
    free(o.drafts);
    unlink(draft);
    unlink(output);
    unlink(plain);
    unlink(model);
    CHECK(rmdir(folder) == 0);
}

// A temporary file of a killed build: a name that the writer uses, with the id of a process that
// has ended.
void test_drafts_leave_nothing_of_those_before(test_state* test)
{
    char folder[] = "stp_draft_XXXXXX", draft[64], output[64], stale[96];
    CHECK(mkdtemp(folder) != NULL);
    snprintf(draft, sizeof(draft), "%s/draft.stip", folder);
    snprintf(output, sizeof(output), "%s/output.stip", folder);
    pid_t child = fork();
    if (child == 0) {
        _exit(0);
    }
    CHECK(child > 0 && waitpid(child, NULL, 0) == child);
    snprintf(stale, sizeof(stale), "%s.tmp-%ld-0", draft, (long)child);
    int file = open(stale, O_CREAT | O_WRONLY, 0666);
    CHECK(file >= 0 && close(file) == 0);
    draft_reader o = {
        .path = draft, .only_counts = true, .drafts = calloc(DRAFTS, sizeof(*o.drafts))};
    CHECK(o.drafts != NULL);
    CHECK_EQUAL(STP_OK, build_scene("scene:boxes", output, &o));
    CHECK(access(stale, F_OK) != 0);
    free(o.drafts);
    unlink(stale);
    unlink(draft);
    unlink(output);
    CHECK(rmdir(folder) == 0);
}

// Flat objects, stretched without bound along the axis in which they have no extent.
static stp_result make_stretched(stp_scene* scene, const char* name, void* user)
{
    (void)name;
    (void)user;
    const stp_affine stretched = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1e200, 0}}};
    uint32_t mesh;
    bool added = add_strip(scene, 2000, 0.0f, &mesh) &&
                 add_mesh_object(scene, STP_NONE, stretched, mesh, NULL);
    return added ? STP_OK : STP_ERROR_OUT_OF_MEMORY;
}

void test_drafts_of_endless_areas_have_few_points(test_state* test)
{
    char folder[] = "stp_draft_XXXXXX", draft[64], output[64];
    CHECK(mkdtemp(folder) != NULL);
    snprintf(draft, sizeof(draft), "%s/draft.stip", folder);
    snprintf(output, sizeof(output), "%s/output.stip", folder);
    draft_reader o = {
        .path = draft, .only_counts = true, .drafts = calloc(DRAFTS, sizeof(*o.drafts))};
    CHECK(o.drafts != NULL);
    const char* input = "scene:stretched";
    stp_context* context = test_context(NULL, 1, NULL);
    stp_build_desc desc = {.inputs = &input,
                           .input_count = 1,
                           .output = output,
                           .generate = make_stretched,
                           .memory_bytes = 2ull << 30,
                           .draft = draft,
                           .draft_always = true,
                           .drafted = on_draft,
                           .drafted_user = &o};
    stp_build_report report;
    CHECK_EQUAL(STP_OK, stp_build(context, &desc, &report));
    stp_context_destroy(context);
    CHECK(o.count > 0 && o.drafts[0].whole);
    CHECK(o.drafts[0].points > 100 && o.drafts[0].points < 2000000);
    free(o.drafts);
    unlink(draft);
    unlink(output);
    CHECK(rmdir(folder) == 0);
}

enum { NOT_ALLOWED = 77 };

// On a small separate disk that is just large enough for a build: whether drafts leave enough
// space. In a separate process.
static int fill_disk(const char* folder, const char* model)
{
    char options[64], output[80], draft[80];
    snprintf(output, sizeof(output), "%s/output.stip", folder);
    snprintf(draft, sizeof(draft), "%s/draft.stip", folder);
    if (unshare(CLONE_NEWNS | (geteuid() != 0 ? CLONE_NEWUSER : 0)) != 0 ||
        mount("none", "/", NULL, MS_REC | MS_PRIVATE, NULL) != 0) {
        return NOT_ALLOWED;
    }
    for (unsigned kilobytes = 64; kilobytes < 4096; kilobytes += 64) {
        snprintf(options, sizeof(options), "size=%uk", kilobytes);
        if (mount("none", folder, "tmpfs", 0, options) != 0) {
            return NOT_ALLOWED;
        }
        draft_reader o = {
            .path = draft, .only_counts = true, .drafts = calloc(DRAFTS, sizeof(*o.drafts))};
        bool fits = build_scene(model, output, NULL) == STP_OK && unlink(output) == 0;
        bool with_drafts = fits && o.drafts != NULL && build_scene(model, output, &o) == STP_OK;
        free(o.drafts);
        if (umount(folder) != 0) {
            return NOT_ALLOWED;
        }
        if (fits) {
            return with_drafts ? 0 : 1;
        }
    }
    return 1;
}

void test_drafts_leave_room_for_the_build(test_state* test)
{
    char folder[] = "stp_draft_XXXXXX", model[64];
    CHECK(mkdtemp(folder) != NULL);
    snprintf(model, sizeof(model), "%s.obj", folder);
    CHECK(write_sheets(model));
    int status = 0;
    pid_t child = fork();
    if (child == 0) {
        _exit(fill_disk(folder, model));
    }
    CHECK(child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status));
    bool allowed = WEXITSTATUS(status) != NOT_ALLOWED;
    if (!allowed) {
        SKIP("no disk can be mounted here");
    } else {
        CHECK_EQUAL(0, WEXITSTATUS(status));
    }
    unlink(model);
    CHECK(rmdir(folder) == 0);
}
