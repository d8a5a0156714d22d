// SPDX-License-Identifier: MIT
// Levels of triangles in built files: the same bytes however they are made, and only where they are
// worth it.
#include "same_files.h"
#include "support_level_scenes.h"
#include "work_helpers.h"

#include "builder/build_levels.h"
#include "builder/stored_levels.h"
#include "lod/support_level_shapes.h"

typedef struct level_folder {
    char folder[64], one[96], other[96];
} level_folder;

static bool open_folder(level_folder* f)
{
    snprintf(f->folder, sizeof(f->folder), "stp_levels_XXXXXX");
    bool made = mkdtemp(f->folder) != NULL;
    snprintf(f->one, sizeof(f->one), "%s/one.stip", f->folder);
    snprintf(f->other, sizeof(f->other), "%s/other.stip", f->folder);
    return made;
}

static bool close_folder(const level_folder* f)
{
    unlink(f->one);
    unlink(f->other);
    return rmdir(f->folder) == 0; // nothing else was left
}

void test_builds_with_levels_do_not_depend_on_threads(test_state* test)
{
    level_scene* const scenes[] = {level_scene_open_ball, level_scene_copies};
    for (int i = 0; i < 2; ++i) {
        const level_build build = {.make = scenes[i], .no_splats = true};
        level_folder f;
        stp_context *one = test_context(NULL, 1, NULL), *many = test_context(NULL, 3, NULL);
        CHECK(open_folder(&f));
        CHECK_EQUAL(STP_OK, level_build_to(one, &build, f.one, NULL));
        CHECK_EQUAL(STP_OK, level_build_to(many, &build, f.other, NULL));
        CHECK(same_files(f.one, f.other));
        CHECK_EQUAL(STP_OK, stp_store_check(one, f.one, false));
        stp_store* store = NULL;
        CHECK_EQUAL(STP_OK, stp_store_open(one, f.one, &store));
        CHECK(stp_store_get_directory(store)->level_count > 0);
        stp_store_close(store);
        stp_context_destroy(many);
        stp_context_destroy(one);
        CHECK(close_folder(&f));
    }
}

static int stop_at(const stp_progress_report* report, void* user)
{
    return strcmp(report->stage, (const char*)user) == 0;
}

// Stopped before, while and after levels are made.
void test_builds_with_levels_can_be_continued(test_state* test)
{
    const level_build build = {.make = level_scene_two_tori};
    level_folder f;
    stp_context* plain = test_context(NULL, 2, NULL);
    CHECK(open_folder(&f));
    CHECK_EQUAL(STP_OK, level_build_to(plain, &build, f.other, NULL));
    static const char* const stages[] = {"levels", "clusters", "write"};
    for (int i = 0; i < 3; ++i) {
        test_log log = {0};
        char stage[32];
        snprintf(stage, sizeof(stage), "%s", stages[i]);
        stp_context_desc desc = {.thread_count = 2,
                                 .log = test_log_message,
                                 .log_user = &log,
                                 .progress = stop_at,
                                 .progress_user = stage};
        stp_context* context = NULL;
        CHECK_EQUAL(STP_OK, stp_context_create(&context, &desc));
        CHECK_EQUAL(STP_ERROR_CANCELLED, level_build_to(context, &build, f.one, NULL));
        CHECK_EQUAL(1, log.errors);
        stp_context_destroy(context);
    }
    CHECK_EQUAL(STP_OK, level_build_to(plain, &build, f.one, NULL));
    CHECK(same_files(f.one, f.other));
    CHECK_EQUAL(STP_OK, level_build_to(plain, &build, f.one, NULL)); // over an existing file
    CHECK(same_files(f.one, f.other));
    stp_context_destroy(plain);
    CHECK(close_folder(&f));
}

/// A finished scene, and the levels of all of its nodes.
typedef struct level_maker {
    stp_context* context;
    stp_scene* scene;
    stp_shading_set shadings;
    stp_build_levels levels;
} level_maker;

static stp_result begin_maker(level_maker* m, stp_context* context, level_scene* make)
{
    *m = (level_maker){.context = context};
    stp_result result = stp_scene_create(context, &m->scene);
    result = result == STP_OK && !make(m->scene) ? STP_ERROR_OUT_OF_MEMORY : result;
    result = result == STP_OK ? stp_scene_finish(m->scene) : result;
    result = result == STP_OK ? stp_scene_partition(m->scene, &(stp_partition_desc){0}) : result;
    return result == STP_OK ? stp_make_shadings(m->scene, false, &m->shadings) : result;
}

static stp_result make_with(level_maker* m, stp_work* work)
{
    const stp_build_levels_desc desc = {.shading_of_material = m->shadings.of_material,
                                        .shadings = m->shadings.shadings,
                                        .shading_count = m->shadings.count,
                                        .work = work};
    return stp_build_levels_make(m->scene, &desc, &m->levels);
}

static void end_maker(level_maker* m)
{
    stp_build_levels_destroy(m->context, &m->levels);
    stp_free(m->context, m->shadings.of_material);
    stp_scene_destroy(m->scene);
}

// Made once, then found in the work folder; made again where they are damaged.
void test_levels_are_found_in_the_work_folder(test_state* test)
{
    work_place place;
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(make_work_place(&place));
    level_maker first;
    uint64_t sources = 0;
    for (int round = 0; round < 3; ++round) {
        level_maker m;
        stp_work* work = NULL;
        stp_work_report report;
        if (round == 2) {
            char segment[128];
            snprintf(segment, sizeof(segment), "%s/segment-000000", place.folder);
            FILE* file = fopen(segment, "r+b");
            CHECK(file != NULL && fseek(file, 5000, SEEK_SET) == 0);
            int byte = fgetc(file);
            CHECK(fseek(file, 5000, SEEK_SET) == 0 && fputc(byte ^ 0x10, file) != EOF);
            CHECK_EQUAL(0, fclose(file));
        }
        CHECK_EQUAL(STP_OK, stp_work_open(context, place.folder, false, &work));
        CHECK_EQUAL(STP_OK, begin_maker(&m, context, level_scene_copies));
        CHECK_EQUAL(STP_OK, make_with(&m, work));
        stp_work_get_report(work, &report);
        sources = round == 0 ? report.stored : sources;
        CHECK_EQUAL(round == 0 ? 0 : sources - (round == 2 ? 1 : 0), report.found);
        CHECK_EQUAL(round == 0 ? sources : round == 2 ? 1 : 0, report.stored);
        if (round == 0) {
            first = m;
            CHECK(sources > 0 && m.levels.level_count > 0);
        } else {
            const stp_build_levels *a = &first.levels, *b = &m.levels;
            CHECK(a->level_count == b->level_count && a->cluster_count == b->cluster_count &&
                  a->group_count == b->group_count && a->material_count == b->material_count);
            CHECK(memcmp(a->clusters, b->clusters, a->cluster_count * sizeof(*a->clusters)) == 0);
            CHECK(memcmp(a->groups, b->groups, a->group_count * sizeof(*a->groups)) == 0);
            end_maker(&m);
        }
        stp_work_close(work, round == 2);
    }
    end_maker(&first);
    CHECK(remove_work_place(&place));
    stp_context_destroy(context);
}

// What a writer would refuse, although its checksums are right: an altered file of a former build.
void test_levels_that_no_writer_takes_are_not_found(test_state* test)
{
    work_place place;
    stp_work* work = NULL;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(make_work_place(&place));
    CHECK_EQUAL(STP_OK, stp_work_open(context, place.folder, false, &work));
    for (uint32_t fault = 0; fault < 8; ++fault) {
        float positions[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
        uint16_t colors[16] = {0};
        uint32_t indices[] = {0, 1, 2, 0, 2, 3};
        stp_node_level_cluster cluster = {.end = 2, .made_by = 0, .used_by = 1, .one_sided = 2};
        stp_level_group groups[2] = {{.radius = 1, .error = 0.125}, {.radius = 1, .error = 0.25}};
        stp_node_level level = {.vertex_count = 4,
                                .triangle_count = 2,
                                .cluster_count = 1,
                                .positions = positions,
                                .colors = colors,
                                .indices = indices,
                                .clusters = &cluster};
        const stp_node_levels levels = {
            .level_count = 1, .group_count = 2, .levels = &level, .groups = groups, .step = 0.5};
        cluster.one_sided = fault == 1 ? 3 : 2;
        cluster.used_by = fault == 2 ? 2 : 1;
        groups[1].error = fault == 3 ? 0.125 : 0.25;
        groups[0].error = fault == 4 ? 0.0 : 0.125;
        groups[1].radius = fault == 5 ? -1.0 : 1.0;
        groups[0].center.y = fault == 6 ? (double)NAN : 0.0;
        level.shading = fault == 7 ? 3 : 2;
        stp_hash key = {7, fault};
        stp_stored_levels found;
        CHECK_EQUAL(STP_OK, stp_work_store_levels(context, work, key, &levels));
        CHECK(stp_work_find_levels(work, key, 3, &found) == (fault == 0));
    }
    stp_work_close(work, true);
    CHECK(remove_work_place(&place));
    stp_context_destroy(context);
}

/// Levels in the file of a scene, without splats.
typedef struct level_counts {
    uint32_t levels;
    uint64_t triangles; ///< stored for levels
    uint64_t unique;    ///< of all other meshes
} level_counts;

static level_counts count_levels(test_state* test, level_scene* make, uint32_t leaf_triangles)
{
    const level_build build = {.make = make, .no_splats = true, .leaf_triangles = leaf_triangles};
    level_counts counts = {0};
    stp_context* context = test_context(NULL, 2, NULL);
    stp_store* store = level_build_open(context, &build);
    CHECK(store != NULL);
    const stp_store_directory* d = stp_store_get_directory(store);
    counts.levels = d->level_count;
    for (uint32_t i = 0; i < d->mesh_count; ++i) {
        counts.unique += stp_store_describe_mesh(store, i)->triangle_count;
    }
    for (uint32_t i = 0; i < d->level_count; ++i) {
        const stp_store_mesh* mesh = stp_store_describe_mesh(store, d->levels[i].mesh);
        counts.triangles += mesh->triangle_count;
        CHECK(d->levels[i].node < d->node_count && d->levels[i].most > d->levels[i].least);
    }
    counts.unique -= counts.triangles;
    stp_store_close(store);
    stp_context_destroy(context);
    return counts;
}

static bool make_few(stp_scene* scene) // 968 triangles
{
    uint32_t red = level_add_material(scene, 0.8f, 0.1f, 0.1f);
    return level_add(scene, level_torus(scene->context, 22, 22, 1.0, 0.4), red,
                     stp_affine_identity()) != STP_NONE;
}

void test_small_scenes_get_no_levels(test_state* test)
{
    CHECK_EQUAL(0, count_levels(test, make_few, 0).levels);
    CHECK(count_levels(test, level_scene_torus, 0).levels > 1);
}

static uint32_t add_glass(stp_scene* scene)
{
    stp_material glass = stp_material_default();
    uint32_t index = STP_NONE;
    glass.base_color[3] = 0.4f;
    glass.alpha_mode = STP_ALPHA_BLEND;
    return stp_scene_add_material(scene, &glass, &index) == STP_OK ? index : STP_NONE;
}

/// A torus of 4,800 triangles, and a sheet of glass of 2 * side * side that crosses it.
static bool make_glazed(stp_scene* scene, uint32_t side)
{
    stp_affine aside = {{{1, 0, 0, -0.5}, {0, 1, 0, 0.1}, {0, 0, 1, -0.5}}};
    uint32_t red = level_add_material(scene, 0.8f, 0.1f, 0.1f);
    return level_add(scene, level_torus(scene->context, 60, 40, 1.0, 0.4), red,
                     stp_affine_identity()) != STP_NONE &&
           level_add(scene, level_sheet(scene->context, side, 1.0, 0.0), add_glass(scene), aside) !=
               STP_NONE;
}

static bool make_little_glass(stp_scene* scene) // 512 triangles
{
    return make_glazed(scene, 16);
}

static bool make_much_glass(stp_scene* scene) // 1,800 triangles
{
    return make_glazed(scene, 30);
}

// Levels do not stand for glass: it is drawn beside them, so much of it makes them useless. A node
// below may have some.
void test_nodes_with_much_glass_get_no_levels(test_state* test)
{
    for (int much = 0; much < 2; ++much) {
        const level_build build = {.make = much != 0 ? make_much_glass : make_little_glass,
                                   .no_splats = true};
        stp_context* context = test_context(NULL, 2, NULL);
        stp_store* store = level_build_open(context, &build);
        CHECK(store != NULL);
        const stp_store_directory* d = stp_store_get_directory(store);
        uint32_t of_root = 0;
        for (uint32_t i = 0; i < d->level_count; ++i) {
            of_root += d->levels[i].node == d->root ? 1 : 0;
            const stp_store_mesh* mesh = stp_store_describe_mesh(store, d->levels[i].mesh);
            CHECK_EQUAL(STP_STORE_OPAQUE, d->materials[mesh->material].alpha);
        }
        CHECK(d->level_count > 0 && (of_root == 0) == (much != 0));
        stp_store_close(store);
        stp_context_destroy(context);
    }
}

// Of 24 uses of two meshes, levels are made for few.
void test_levels_of_shared_nodes_stay_small(test_state* test)
{
    level_counts counts = count_levels(test, level_scene_copies, 0);
    CHECK_EQUAL(4800 + 2400, counts.unique);
    CHECK(counts.levels > 0 && counts.triangles <= 2 * counts.unique);
}

// A mesh that is split into pieces: the node above them has levels.
void test_levels_of_split_meshes(test_state* test)
{
    level_counts counts = count_levels(test, level_scene_torus, 3000);
    CHECK(counts.levels > 1);
    CHECK(counts.triangles > 2000 && counts.triangles <= 15000);
}

void test_levels_survive_failing_allocator(test_state* test)
{
    bool made = false;
    uint32_t failures = 0;
    for (int n = 1; !made && n < 40000; n += 1 + n / 3) {
        work_place place;
        CHECK(make_work_place(&place));
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        if (context != NULL) {
            level_maker m;
            stp_work* work = NULL;
            stp_result result = begin_maker(&m, context, make_little_glass);
            result = result == STP_OK ? stp_work_open(context, place.folder, false, &work) : result;
            result = result == STP_OK ? make_with(&m, work) : result;
            made = result == STP_OK && heap.count <= n;
            CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
            failures += result != STP_OK ? 1 : 0;
            end_maker(&m);
            stp_work_close(work, true);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
        CHECK(remove_work_place(&place));
    }
    CHECK(made && failures > 10);
}
