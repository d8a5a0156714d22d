// SPDX-License-Identifier: MIT
// The whole path from a model to a file, on models written here.
#include "same_files.h"
#include "tests.h"

#include "builder/build_scene.h"
#include "builder/shadings.h"
#include "store/file/store.h"

#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct workshop {
    char folder[64];
    char model[128], points[128], output[128], other[128];
} workshop;

static bool write_text(const char* path, const char* text)
{
    FILE* file = fopen(path, "w");
    bool written = file != NULL && fputs(text, file) >= 0;
    return file != NULL && fclose(file) == 0 && written;
}

// A bumpy sheet of 2 * size * size triangles.
static bool write_sheet(const char* path, int size)
{
    FILE* file = fopen(path, "w");
    if (file == NULL) {
        return false;
    }
    for (int y = 0; y <= size; ++y) {
        for (int x = 0; x <= size; ++x) {
            fprintf(file, "v %d %d %d\n", x, (x * 7 + y * 13) % 3, y);
        }
    }
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
            int a = y * (size + 1) + x + 1, b = a + 1, c = a + size + 1, d = c + 1;
            fprintf(file, "f %d %d %d\nf %d %d %d\n", a, c, b, b, c, d);
        }
    }
    return fclose(file) == 0;
}

static bool open_workshop(workshop* w, int size)
{
    snprintf(w->folder, sizeof(w->folder), "stp_build_XXXXXX");
    if (mkdtemp(w->folder) == NULL) {
        return false;
    }
    snprintf(w->model, sizeof(w->model), "%s/sheet.obj", w->folder);
    snprintf(w->points, sizeof(w->points), "%s/points.ply", w->folder);
    snprintf(w->output, sizeof(w->output), "%s/out.stip", w->folder);
    snprintf(w->other, sizeof(w->other), "%s/other.stip", w->folder);
    return write_sheet(w->model, size);
}

static void close_workshop(const workshop* w)
{
    unlink(w->model);
    unlink(w->points);
    unlink(w->output);
    unlink(w->other);
    rmdir(w->folder); // fails if files were left behind; tests check this
}

static bool folder_is_gone(const workshop* w)
{
    struct stat status;
    return stat(w->folder, &status) != 0;
}

static stp_result build_to(stp_context* context, const workshop* w, const char* output,
                           uint32_t splat_count, stp_build_report* report)
{
    const char* inputs[] = {w->model};
    stp_build_desc desc = {.inputs = inputs,
                           .input_count = 1,
                           .output = output,
                           .blue = {.capture = {.wanted_candidates = 8000}},
                           .splat_rule = {splat_count != 0 ? 1e-9 : 0.0, splat_count},
                           .parameters_json = "{\"method\":\"blue\"}"};
    return stp_build(context, &desc, report);
}

void test_builds_can_be_opened_and_checked(test_state* test)
{
    workshop w;
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL && open_workshop(&w, 30));
    stp_build_report report;
    CHECK_EQUAL(STP_OK, build_to(context, &w, w.output, 0, &report));
    CHECK(report.candidates > 2000 && report.total_s > 0.0);
    CHECK_EQUAL(STP_OK, stp_store_check(context, w.output, false));
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, stp_store_open(context, w.output, &store));
    const stp_store_directory* d = stp_store_get_directory(store);
    CHECK_EQUAL(1800, d->nodes[d->root].triangle_count);
    CHECK_EQUAL(1, d->set_count);
    CHECK_EQUAL(0, d->nodes[d->root].set);
    CHECK(d->shading_count >= 1 && strcmp(d->build_json, "{\"method\":\"blue\"}") == 0);
    CHECK(d->source_count == 1 && strcmp(d->sources[0].path, w.model) == 0);
    stp_splats s;
    CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, 0, &s));
    CHECK_EQUAL(225, s.count);               // one for eight triangles
    for (uint32_t i = 0; i < s.count; ++i) { // within the model's box, up to rounding
        double x = (double)s.origin.x + (double)s.step * s.positions[3 * (size_t)i];
        CHECK(x > -0.01 && x < 30.01);
        CHECK(s.materials[i] < d->shading_count);
    }
    stp_store_close(store);
    stp_context_destroy(context);
    close_workshop(&w);
    CHECK(folder_is_gone(&w));
}

void test_builds_do_not_depend_on_threads(test_state* test)
{
    workshop w;
    CHECK(open_workshop(&w, 30));
    for (uint32_t threads = 1; threads <= 3; ++threads) {
        stp_context* context = test_context(NULL, threads, NULL);
        CHECK(context != NULL);
        CHECK_EQUAL(STP_OK, build_to(context, &w, threads == 1 ? w.output : w.other, 700, NULL));
        CHECK(threads == 1 || same_files(w.output, w.other));
        stp_context_destroy(context);
    }
    close_workshop(&w);
}

static stp_result build_methods(stp_context* context, const workshop* w, const char* output,
                                const stp_method* const* methods, uint32_t count,
                                stp_build_report* report)
{
    const char* inputs[] = {w->model};
    stp_build_desc desc = {.inputs = inputs,
                           .input_count = 1,
                           .output = output,
                           .blue = {.capture = {.wanted_candidates = 8000}},
                           .methods = methods,
                           .method_count = count,
                           .method_options = stp_method_options_default()};
    return stp_build(context, &desc, report);
}

// Sets of several methods: the first one's equal those of a file with it alone. All are checked,
// reused by the next build, and independent of the number of threads.
void test_builds_of_several_methods(test_state* test)
{
    const stp_method* const both[] = {stp_method_by_name("blue"), stp_method_by_name("spt")};
    const stp_method* const turned[] = {both[1], both[0]};
    workshop w;
    stp_context* one = test_context(NULL, 1, NULL);
    stp_context* many = test_context(NULL, 3, NULL);
    CHECK(one != NULL && many != NULL && open_workshop(&w, 30));
    stp_build_report report;
    CHECK_EQUAL(STP_OK, build_methods(one, &w, w.output, both, 2, &report));
    CHECK_EQUAL(2, report.sets_made);
    CHECK_EQUAL(STP_OK, build_methods(many, &w, w.other, both, 2, &report));
    CHECK(same_files(w.output, w.other));
    CHECK_EQUAL(STP_OK, stp_store_check(one, w.output, false));
    CHECK_EQUAL(STP_OK, build_methods(one, &w, w.output, both, 2, &report)); // again
    CHECK(report.sets_found == 2 && report.sets_made == 0);
    CHECK(same_files(w.output, w.other));
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, stp_store_open(one, w.output, &store));
    const stp_store_directory* d = stp_store_get_directory(store);
    CHECK(d->method_count == 2 && d->set_count == 2);
    stp_splats blue, spt;
    CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, stp_store_set_of(d, 0, d->root), &blue));
    CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, stp_store_set_of(d, 1, d->root), &spt));
    CHECK(blue.count == 225 && blue.columns == 0 && blue.ranges == NULL);
    CHECK(spt.count > 225 && spt.columns == stp_method_by_id(STP_METHOD_SPT)->columns &&
          spt.ranges != NULL);
    stp_store_close(store);
    // one of them alone, and in another order: existing results are reused
    CHECK_EQUAL(STP_OK, build_methods(one, &w, w.output, turned, 1, &report));
    CHECK(report.sets_found == 2 && report.sets_made == 0);
    CHECK_EQUAL(STP_OK, stp_store_open(one, w.output, &store));
    d = stp_store_get_directory(store);
    CHECK(d->method_count == 1 && d->methods[0].id == STP_METHOD_SPT);
    CHECK_EQUAL(0, d->nodes[d->root].set);
    stp_store_close(store);
    CHECK_EQUAL(STP_OK, build_methods(one, &w, w.output, both, 1, NULL)); // as for blue alone
    unlink(w.other);
    CHECK_EQUAL(STP_OK, build_methods(one, &w, w.other, NULL, 0, NULL));
    CHECK(same_files(w.output, w.other));
    stp_context_destroy(many);
    stp_context_destroy(one);
    close_workshop(&w);
    CHECK(folder_is_gone(&w));
}

void test_failed_builds_leave_the_former_file(test_state* test)
{
    workshop w;
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL && open_workshop(&w, 4));
    CHECK(write_text(w.output, "previous"));
    CHECK(write_text(w.other, "previous"));
    CHECK(write_text(w.model, "this is no model\nf 1 2 3\n"));
    CHECK(build_to(context, &w, w.output, 0, NULL) != STP_OK);
    CHECK_EQUAL(1, log.errors);
    CHECK(same_files(w.output, w.other));
    unlink(w.model);
    CHECK_EQUAL(STP_ERROR_IO, build_to(context, &w, w.output, 0, NULL));
    CHECK_EQUAL(2, log.errors);
    CHECK(same_files(w.output, w.other));
    // an unwritable output fails before any input is read
    CHECK_EQUAL(STP_ERROR_IO, build_to(context, &w, w.folder, 0, NULL));
    CHECK(strstr(log.text, "regular file") != NULL);
    stp_context_destroy(context);
    close_workshop(&w);
    CHECK(folder_is_gone(&w));
}

static int stop_at_once(const stp_progress_report* report, void* user)
{
    return strcmp(report->stage, (const char*)user) == 0;
}

void test_builds_can_be_stopped_at_every_stage(test_state* test)
{
    static const char* const stages[] = {"import",   "partition", "surfels",
                                         "clusters", "write",     "import"};
    workshop w;
    CHECK(open_workshop(&w, 30));
    CHECK(write_text(w.output, "previous"));
    CHECK(write_text(w.other, "previous"));
    for (int i = 0; i < 6; ++i) {
        test_log log = {0};
        char stage[32];
        snprintf(stage, sizeof(stage), "%s", stages[i]);
        stp_context_desc desc = {.thread_count = 2,
                                 .log = test_log_message,
                                 .log_user = &log,
                                 .progress = stop_at_once,
                                 .progress_user = stage};
        stp_context* context = NULL;
        CHECK_EQUAL(STP_OK, stp_context_create(&context, &desc));
        CHECK_EQUAL(STP_ERROR_CANCELLED, build_to(context, &w, w.output, 0, NULL));
        CHECK_EQUAL(1, log.errors);
        CHECK(same_files(w.output, w.other));
        stp_context_destroy(context);
    }
    // results so far are kept, and removed when a build finishes
    stp_context* context = test_context(NULL, 2, NULL);
    stp_build_report report;
    CHECK_EQUAL(STP_OK, build_to(context, &w, w.output, 0, &report));
    CHECK(report.sets_found == 1 && report.meshes_found == 1);
    CHECK_EQUAL(STP_OK, build_to(context, &w, w.other, 0, NULL));
    CHECK(same_files(w.output, w.other));
    stp_context_destroy(context);
    close_workshop(&w);
    CHECK(folder_is_gone(&w));
}

typedef struct damage {
    char segment[160];
    const char* stage;
    int times; ///< remaining
    int done;
} damage;

// Flips the last byte of a result, before its padding.
static int damage_results(const stp_progress_report* report, void* user)
{
    damage* v = user;
    FILE* file =
        v->times > 0 && strcmp(report->stage, v->stage) == 0 ? fopen(v->segment, "r+b") : NULL;
    int last = 0;
    long at = -1;
    for (long i = 0; file != NULL; ++i) {
        int byte = fgetc(file);
        if (byte == EOF) {
            break;
        }
        last = byte != 0 ? byte : last;
        at = byte != 0 ? i : at;
    }
    if (at > 4096) {
        fseek(file, at - 64, SEEK_SET);
        last = fgetc(file);
        fseek(file, at - 64, SEEK_SET);
        fputc(last ^ 0x40, file);
        v->times -= 1;
        v->done += 1;
    }
    if (file != NULL) {
        fclose(file);
    }
    return 0;
}

void test_builds_notice_results_that_somebody_changed(test_state* test)
{
    static const char* const stages[] = {"clusters", "write"};
    workshop w;
    CHECK(open_workshop(&w, 60));
    stp_context* plain = test_context(NULL, 2, NULL);
    CHECK_EQUAL(STP_OK, build_to(plain, &w, w.other, 0, NULL));
    for (int i = 0; i < 4;
         ++i) { // changed once: everything is made again; always: one message, and no file
        test_log log = {0};
        damage v = {.stage = stages[i % 2], .times = i < 2 ? 1 : 1000000};
        snprintf(v.segment, sizeof(v.segment), "%s.work/segment-000000", w.output);
        stp_context_desc desc = {.thread_count = 2,
                                 .log = test_log_message,
                                 .log_user = &log,
                                 .progress = damage_results,
                                 .progress_user = &v};
        stp_context* context = NULL;
        CHECK_EQUAL(STP_OK, stp_context_create(&context, &desc));
        stp_result result = build_to(context, &w, w.output, 0, NULL);
        CHECK(v.done >= 1 && strstr(log.warning, "starting again") != NULL);
        CHECK_EQUAL(i < 2 ? STP_OK : STP_ERROR_IO, result);
        CHECK(same_files(w.output, w.other) == (i < 2));
        CHECK(i < 2 || strstr(log.text, "keeps changing") != NULL);
        unlink(w.output);
        stp_context_destroy(context);
    }
    stp_context_destroy(plain);
    close_workshop(&w);
    CHECK(folder_is_gone(&w)); // nor are results left
}

// The n-th allocation fails, for n along a geometric series and for each of the first ones.
// No failure leaves files behind. `methods` as for build_methods; 200 surfels if there are
// none.
static void check_failing_allocations(test_state* test, const stp_method* const* methods,
                                      uint32_t count)
{
    workshop w;
    CHECK(open_workshop(&w, 23));
    bool built = false;
    int failures = 0;
    for (int n = 0; !built && n < 4000; n += 1 + n / 40) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        if (context != NULL) {
            stp_result result = count > 0
                                    ? build_methods(context, &w, w.output, methods, count, NULL)
                                    : build_to(context, &w, w.output, 200, NULL);
            built = heap.count <= n; // the failing allocation was not reached
            CHECK(built ? result == STP_OK : log.errors <= 1);
            failures += result != STP_OK;
            stp_context_destroy(context);
        }
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(built && failures > 30);
    close_workshop(&w);
    CHECK(folder_is_gone(&w));
}

void test_builds_survive_failing_allocator(test_state* test)
{
    check_failing_allocations(test, NULL, 0);
}

void test_builds_of_methods_survive_failing_allocator(test_state* test)
{
    const stp_method* const both[] = {stp_method_by_name("spt"), stp_method_by_name("blue")};
    check_failing_allocations(test, both, 2);
}

void test_small_scenes_get_no_splats(test_state* test)
{
    workshop w;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL && open_workshop(&w, 4)); // 32 triangles
    const char* inputs[] = {w.model};
    stp_build_desc desc = {.inputs = inputs, .input_count = 1, .output = w.output};
    for (int i = 0; i < 3; ++i) {
        desc.threshold = i == 0 ? 0 : i == 1 ? 32 : 31; // above this many triangles
        CHECK_EQUAL(STP_OK, stp_build(context, &desc, NULL));
        stp_store* store = NULL;
        CHECK_EQUAL(STP_OK, stp_store_open(context, w.output, &store));
        const stp_store_directory* d = stp_store_get_directory(store);
        CHECK_EQUAL(i == 2, d->set_count);
        CHECK(i != 2 || stp_store_describe_splat_set(store, 0)->count == 4);
        stp_store_close(store);
    }
    stp_context_destroy(context);
    close_workshop(&w);
}

void test_point_clouds_keep_every_point(test_state* test)
{
    enum { COUNT = 2000 };
    workshop w;
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL && open_workshop(&w, 4));
    FILE* file = fopen(w.points, "w");
    CHECK(file != NULL);
    fprintf(file,
            "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
            "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
            "end_header\n",
            COUNT);
    for (int i = 0; i < COUNT; ++i) {
        fprintf(file, "%d %d %d %d 20 30\n", i % 40, i / 40, (i * i) % 5, i % 256);
    }
    CHECK(fclose(file) == 0);
    const char* inputs[] = {w.points};
    stp_build_desc desc = {.inputs = inputs, .input_count = 1, .output = w.output};
    stp_build_report report;
    CHECK_EQUAL(STP_OK, stp_build(context, &desc, &report));
    CHECK_EQUAL(COUNT, report.candidates);
    stp_store* store = NULL;
    stp_splats s;
    CHECK_EQUAL(STP_OK, stp_store_open(context, w.output, &store));
    CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, 0, &s));
    CHECK_EQUAL(COUNT, s.count);
    CHECK(s.candidate_radius > 0.3f && s.candidate_radius < 1.5f); // points are about 1 apart
    stp_store_close(store);
    stp_context_destroy(context);
    close_workshop(&w);
}

// Neighbouring clouds, one of them close to a sheet: nearby content is drawn from all points.
void test_point_clouds_keep_every_point_among_others(test_state* test)
{
    enum { COUNT = 1500 };
    workshop w;
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL && open_workshop(&w, 40));
    FILE* file = fopen(w.points, "w");
    CHECK(file != NULL);
    fprintf(file,
            "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
            "property float z\nend_header\n",
            COUNT);
    for (int i = 0; i < COUNT; ++i) {
        fprintf(file, "%d %d %d\n", i % 40, (i * i) % 5, i / 40);
    }
    CHECK(fclose(file) == 0);
    const char* inputs[] = {w.points, w.model, w.points};
    stp_build_desc desc = {.inputs = inputs, .input_count = 3, .output = w.output};
    CHECK_EQUAL(STP_OK, stp_build(context, &desc, NULL));
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, stp_store_open(context, w.output, &store));
    const stp_store_directory* d = stp_store_get_directory(store);
    uint32_t clouds = 0;
    for (uint32_t i = 0; i < d->node_count; ++i) {
        const stp_store_node* node = &d->nodes[i];
        for (uint32_t k = 0; k < node->part_count; ++k) {
            if (d->parts[node->first_part + k].kind == STP_STORE_PART_POINTS) {
                CHECK(node->set != STP_STORE_NONE && node->triangle_count == 0);
                CHECK_EQUAL(COUNT, stp_store_describe_splat_set(store, node->set)->count);
                clouds += 1;
            }
        }
    }
    CHECK_EQUAL(1, clouds); // the same input twice
    stp_store_close(store);
    stp_context_destroy(context);
    close_workshop(&w);
}

// Scans contain near-duplicate points: the work must not grow as they get closer.
void test_near_duplicates_cost_no_more(test_state* test)
{
    workshop w;
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL && open_workshop(&w, 4));
    FILE* file = fopen(w.points, "w");
    CHECK(file != NULL);
    fprintf(file, "ply\nformat ascii 1.0\nelement vertex 6000\nproperty float x\nproperty float y\n"
                  "property float z\nend_header\n");
    for (int i = 0; i < 6000; ++i) {
        double hair = 1e-3 / (1 + i % 97);
        fprintf(file, "%.9f %.9f %.9f\n", i / 3 % 50 + hair, i / 150 + hair * (i % 3), 2 * hair);
    }
    CHECK(fclose(file) == 0);
    const char* inputs[] = {w.points};
    stp_build_desc desc = {.inputs = inputs, .input_count = 1, .output = w.output};
    stp_build_report report;
    CHECK_EQUAL(STP_OK, stp_build(context, &desc, &report));
    CHECK(report.finish_s < 1.5);
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, stp_store_open(context, w.output, &store));
    const stp_splats* s = stp_store_describe_splat_set(store, 0);
    uint64_t entries = 0;
    for (uint32_t i = 0; i < s->octave_count; ++i) {
        entries += s->octave_ends[i];
    }
    CHECK(entries < 2 * (uint64_t)s->count);
    stp_store_close(store);
    stp_context_destroy(context);
    close_workshop(&w);
}

void test_several_inputs_make_one_scene(test_state* test)
{
    workshop w;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL && open_workshop(&w, 10));
    const char* inputs[] = {w.model, w.model};
    stp_build_desc desc = {.inputs = inputs, .input_count = 2, .output = w.output};
    CHECK_EQUAL(STP_OK, stp_build(context, &desc, NULL));
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, stp_store_open(context, w.output, &store));
    const stp_store_directory* d = stp_store_get_directory(store);
    CHECK_EQUAL(2, d->source_count);
    CHECK_EQUAL(400, d->nodes[d->root].triangle_count);
    stp_store_close(store);
    stp_context_destroy(context);
    close_workshop(&w);
}

void test_built_files_are_not_built_again(test_state* test)
{
    workshop w;
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL && open_workshop(&w, 4));
    CHECK_EQUAL(STP_OK, build_to(context, &w, w.output, 0, NULL));
    CHECK(rename(w.output, w.model) == 0); // the content determines the format
    CHECK_EQUAL(STP_ERROR_UNSUPPORTED, build_to(context, &w, w.output, 0, NULL));
    CHECK_EQUAL(1, log.errors);
    CHECK(strstr(log.text, w.model) != NULL && strstr(log.text, "is a built file") != NULL);
    stp_context_destroy(context);
    close_workshop(&w);
    CHECK(folder_is_gone(&w));
}

void test_shadings_are_exact_up_to_256(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    for (int count = 200; count <= 600; count += 200) {
        stp_scene* scene = NULL;
        CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
        for (int i = 0; i < count; ++i) {
            stp_material material = stp_material_default();
            material.roughness = (float)(i / 2) / (float)count; // each twice
            material.unlit = i / 2 == 7;
            uint32_t index;
            CHECK_EQUAL(STP_OK, stp_scene_add_material(scene, &material, &index));
            stp_mesh mesh = {.material = index};
            CHECK_EQUAL(STP_OK, stp_scene_add_mesh(scene, &mesh, NULL));
        }
        stp_shading_set set;
        CHECK_EQUAL(STP_OK, stp_make_shadings(scene, false, &set));
        CHECK(set.count <= 256 && (int)set.count >= (count < 512 ? count / 2 : 256));
        for (int i = 0; i < count; ++i) {
            const stp_material* m = &scene->materials[i + 1];
            const stp_shading* s = &set.shadings[set.of_material[i + 1]];
            float error = fabsf(m->roughness - s->roughness);
            CHECK(count / 2 <= 256 ? error == 0.0f : error < 0.01f);
            CHECK_EQUAL(m->unlit, (s->flags & STP_SHADING_UNLIT) != 0);
        }
        stp_free(context, set.of_material);
        stp_scene_destroy(scene);
    }
    stp_context_destroy(context);
}

// The shadings of `count` materials without every `without`-th; indices by material number.
static bool place_materials(stp_context* context, int count, int without, bool reversed,
                            int places[], stp_shading_set* set)
{
    stp_scene* scene = NULL;
    bool made = stp_scene_create(context, &scene) == STP_OK;
    int numbers[256];
    for (int k = 0; made && k < count; ++k) {
        int i = reversed ? count - 1 - k : k;
        places[i] = -1;
        if (without != 0 && i % without == 0) {
            continue;
        }
        stp_material material = stp_material_default();
        material.roughness = (float)i / 256.0f;
        uint32_t index = 0;
        made = stp_scene_add_material(scene, &material, &index) == STP_OK &&
               stp_scene_add_mesh(scene, &(stp_mesh){.material = index}, NULL) == STP_OK;
        numbers[index - 1] = i;
    }
    made = made && stp_make_shadings(scene, false, set) == STP_OK;
    for (size_t i = 1; made && i < scene->material_count; ++i) {
        places[numbers[i - 1]] = set->of_material[i];
    }
    if (made) {
        stp_free(context, set->of_material);
    }
    stp_scene_destroy(scene);
    return made;
}

void test_shadings_keep_their_indices_when_others_come_and_go(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    static const int counts[] = {1, 2, 10, 60, 200, 256};
    for (size_t k = 0; k < sizeof(counts) / sizeof(counts[0]); ++k) {
        int count = counts[k], all[256], again[256], fewer[256], moved = 0, left = 0;
        stp_shading_set set, other;
        CHECK(place_materials(context, count, 0, false, all, &set));
        CHECK(place_materials(context, count, 0, true, again, &other));
        CHECK_EQUAL(set.count, other.count); // the order of materials does not matter
        CHECK(memcmp(all, again, (size_t)count * sizeof(int)) == 0);
        CHECK(memcmp(set.shadings, other.shadings, set.count * sizeof(set.shadings[0])) == 0);
        bool taken[256] = {false};
        for (int i = 0; i < count; ++i) {
            CHECK(all[i] >= 0 && all[i] < (int)set.count && !taken[all[i]]);
            taken[all[i]] = true;
            CHECK(set.shadings[all[i]].roughness == (float)i / 256.0f);
        }
        CHECK(taken[set.count - 1]);
        CHECK(place_materials(context, count, 3, false, fewer, &other)); // a third is gone
        for (int i = 0; i < count; ++i) {
            left += fewer[i] >= 0;
            moved += fewer[i] >= 0 && fewer[i] != all[i];
        }
        CHECK(moved * 10 <= left || count > 60);
        CHECK(count > 200 || moved * 2 <= left);
    }
    stp_context_destroy(context);
}

static bool wants_none(const stp_scene* scene, void* user)
{
    *(uint64_t*)user = scene->nodes[scene->root].triangle_count;
    return false;
}

void test_build_without_splats(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    workshop w;
    CHECK(open_workshop(&w, 40));
    CHECK(write_text(w.points,
                     "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
                     "property float z\nend_header\n0 0 0\n1 2 3\n"));
    const char* inputs[] = {w.model, w.points};
    uint64_t asked = 0;
    stp_build_desc desc = {.inputs = inputs,
                           .input_count = 2,
                           .output = w.output,
                           .wants_splats = wants_none,
                           .wants_splats_user = &asked,
                           .parameters_json = "{}"};
    stp_build_report report;
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, stp_build(context, &desc, &report));
    CHECK_EQUAL(3200, asked);
    CHECK_EQUAL(0, report.sets_made + report.sets_found);
    CHECK_EQUAL(STP_OK, stp_store_check(context, w.output, false));
    CHECK_EQUAL(STP_OK, stp_store_open(context, w.output, &store));
    stp_store_figures figures = stp_store_get_summary(store)->figures;
    CHECK_EQUAL(0, figures.surfels);
    CHECK_EQUAL(3200, figures.triangles);
    CHECK_EQUAL(2, figures.points);
    stp_store_close(store);
    stp_context_destroy(context);
    close_workshop(&w);
    CHECK(folder_is_gone(&w));
}
