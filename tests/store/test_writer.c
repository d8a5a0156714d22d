// SPDX-License-Identifier: MIT
// The writer: order of blocks, sizes, rejected content, failures during writing.
#include "support_sample.h"
#include "tests.h"

#include "base/io/file.h"
#include "store/bytes/format.h"
#include "store/file/block_order.h"

#include <dirent.h>
#include <signal.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

// A new empty folder, and the path of a file in it.
static bool make_folder(char folder[256], char path[300])
{
    const char* parent = getenv("TMPDIR");
    snprintf(folder, 256, "%s/stp_store_XXXXXX", parent != NULL ? parent : "/tmp");
    bool made = mkdtemp(folder) != NULL;
    snprintf(path, 300, "%s/a.stip", folder);
    return made;
}

static int count_files(const char* folder)
{
    DIR* open_folder = opendir(folder);
    int count = 0;
    for (struct dirent* entry; open_folder != NULL && (entry = readdir(open_folder)) != NULL;) {
        count += entry->d_name[0] != '.';
    }
    closedir(open_folder);
    return count;
}

void test_store_writes_an_empty_scene(test_state* test)
{
    char folder[256], path[300];
    CHECK(make_folder(folder, path));
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_store_content empty = {.directory = {.root = STP_STORE_NONE, .up = 'y'}};
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, stp_store_write(context, &empty, path));
    CHECK_EQUAL(STP_OK, stp_store_open(context, path, &store));
    CHECK(sample_difference(&empty, store) == NULL);
    CHECK(stp_store_file_bytes(store) < 2048);
    stp_splats splats;
    CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_store_get_splat_set(store, 0, &splats));
    stp_store_close(store);
    CHECK_EQUAL(STP_OK, stp_store_check(context, path, false));
    unlink(path);
    CHECK_EQUAL(0, rmdir(folder));
    stp_context_destroy(context);
}

void test_store_orders_meshes_by_shown_area(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    // a screw; a wall; a bolt used at twice its size and once at its own; a mesh that is not used
    stp_store_mesh meshes[] = {
        {.vertex_count = 300, .triangle_count = 100, .area = 1.0},
        {.vertex_count = 300, .triangle_count = 100, .area = 90.0},
        {.vertex_count = 300, .triangle_count = 100, .area = 10.0},
        {.vertex_count = 3, .triangle_count = 1, .area = 1000.0},
        {.vertex_count = 30000, .triangle_count = 10000, .area = 300.0},
    };
    stp_store_part parts[] = {{STP_STORE_PART_MESH, 2},
                              {STP_STORE_PART_MESH, 0},
                              {STP_STORE_PART_MESH, 1},
                              {STP_STORE_PART_MESH, 2},
                              {STP_STORE_PART_MESH, 4}};
    stp_store_edge edges[] = {{.node = 0, .transform = stp_affine_identity()}};
    for (int axis = 0; axis < 3; ++axis) {
        edges[0].transform.m[axis][axis] = 2.0;
    }
    stp_store_node nodes[] = {
        {.part_count = 1, .set = STP_STORE_NONE},
        {.edge_count = 1, .first_part = 1, .part_count = 4, .set = STP_STORE_NONE},
    };
    stp_store_content content = {
        .directory = {.nodes = nodes,
                      .node_count = 2,
                      .edges = edges,
                      .edge_count = 1,
                      .parts = parts,
                      .part_count = 5,
                      .mesh_count = 5,
                      .root = 1,
                      .up = 'y'},
        .meshes = meshes,
    };
    static const uint32_t in_order[] = {1, 2, 4, 0,
                                        3}; // 90, 10 + 4 x 10, 300 for 100 times the bytes, 1, none
    stp_store_plan plan;
    CHECK_EQUAL(STP_OK, stp_store_plan_make(context, &content, 4096, &plan));
    CHECK_EQUAL(5, plan.block_count);
    for (uint32_t i = 0; i < 5; ++i) {
        CHECK_EQUAL(in_order[i], plan.blocks[i].owner);
        CHECK_EQUAL(i, plan.mesh_blocks[in_order[i]]);
    }
    stp_store_plan_destroy(context, &plan);
    stp_context_destroy(context);
}

void test_store_survives_failing_allocator(test_state* test)
{
    char folder[256], path[300];
    CHECK(make_folder(folder, path));
    stp_context* plain = test_context(NULL, 1, NULL);
    CHECK(plain != NULL);
    stp_arena arena = stp_arena_create(plain, 1 << 16);
    sample made = sample_make(&arena, 8);
    CHECK_EQUAL(STP_OK, stp_store_write(plain, &made.content, path));
    int failures = 0;
    for (int n = 0;; ++n) { // fail the n-th allocation, until a run succeeds
        test_heap heap = TEST_HEAP(n);
        test_log log = {.errors = 0};
        stp_context* context = test_context(&heap, 1, &log);
        if (context == NULL) {
            CHECK_EQUAL(0, heap.live_bytes);
            continue;
        }
        stp_store* store = NULL;
        const char* difference = "not opened";
        stp_result result = stp_store_write(context, &made.content, path);
        if (result == STP_OK) {
            result = stp_store_open(context, path, &store);
        }
        if (result == STP_OK) {
            difference = sample_difference(&made.content, store);
            stp_store_close(store);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
        CHECK_EQUAL(1, count_files(folder)); // the old file or the new one, and no temporary file
        CHECK_EQUAL(STP_OK, stp_store_check(plain, path, false));
        if (result == STP_OK && difference == NULL) {
            CHECK_EQUAL(0, log.errors);
            if (heap.count <= n) {
                break;
            }
            continue; // only syncing the folder failed
        }
        CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
        CHECK_EQUAL(1, log.errors);
        failures += 1;
    }
    CHECK(failures > 20);
    unlink(path);
    CHECK_EQUAL(0, rmdir(folder));
    stp_arena_destroy(&arena);
    stp_context_destroy(plain);
}

void test_store_write_failures_leave_the_old_file(test_state* test)
{
    char folder[256], path[300], elsewhere[400];
    CHECK(make_folder(folder, path));
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    stp_arena arena = stp_arena_create(context, 1 << 16);
    sample old = sample_make(&arena, 1), made = sample_make(&arena, 8);
    CHECK_EQUAL(STP_OK, stp_store_write(context, &old.content, path));
    snprintf(elsewhere, sizeof(elsewhere), "%s/missing/a.stip", folder);
    CHECK_EQUAL(STP_ERROR_IO, stp_store_write(context, &made.content, elsewhere));
    CHECK_EQUAL(1, log.errors);

    // at most 4 KB per file, as on a full disk
    struct rlimit limit;
    CHECK_EQUAL(0, getrlimit(RLIMIT_FSIZE, &limit));
    struct rlimit low = {.rlim_cur = 4096, .rlim_max = limit.rlim_max};
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    int set = setrlimit(RLIMIT_FSIZE, &low);
    stp_result result = stp_store_write(context, &made.content, path);
    int reset = setrlimit(RLIMIT_FSIZE, &limit);
    (void)signal(SIGXFSZ, handler);
    CHECK_EQUAL(0, set);
    CHECK_EQUAL(0, reset);
    CHECK_EQUAL(STP_ERROR_IO, result);
    CHECK_EQUAL(2, log.errors);
    CHECK_EQUAL(1, count_files(folder));
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, stp_store_open(context, path, &store));
    CHECK(sample_difference(&old.content, store) == NULL);
    stp_store_close(store);
    unlink(path);
    CHECK_EQUAL(0, rmdir(folder));
    stp_arena_destroy(&arena);
    stp_context_destroy(context);
}

// The writer rejects what a reader would reject: each case breaks one property of a valid scene.
static void spoil(stp_store_content* content, int what, stp_store_mesh* mesh, stp_splats* splats,
                  stp_store_node* node, float* positions, uint32_t* indices)
{
    switch (what) {
    case 0:
        indices[1] = mesh->vertex_count;
        break;
    case 1:
        positions[2] = NAN;
        break;
    case 2:
        mesh->material = 1;
        break;
    case 3:
        splats->step = 0.3f;
        break;
    case 4:
        splats->octave_ends[0] = 5;
        break;
    case 5:
        splats->materials[3] = 1;
        break;
    case 6:
        splats->table.radius[1] = 9.0f;
        break;
    case 7:
        node->part_count = 2;
        break;
    case 8:
        node->set = 1;
        break;
    case 9:
        node->bounds.max.x = (double)INFINITY;
        break;
    case 10:
        content->directory.root = 1;
        break;
    case 11:
        content->directory.up = 'a';
        break;
    case 12:
        splats->table.count[0] = 0;
        break;
    case 13:
        splats->candidate_radius = INFINITY;
        break;
    default: // held by a set that does not exist
        content->directory.point_set_count = 1;
        break;
    }
}

void test_store_refuses_to_write_unreadable_content(test_state* test)
{
    char folder[256], path[300];
    CHECK(make_folder(folder, path));
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    for (int what = -1; what < 15; ++what) {
        float positions[9] = {0};
        uint32_t indices[3] = {0, 1, 2};
        uint16_t grid[12] = {0};
        int8_t normals[8] = {0};
        uint8_t materials[4] = {0}, colors[18] = {0}, coverages[6] = {0};
        stp_store_material material = {
            .base_color_texture.texture = STP_STORE_NONE,
            .metallic_roughness_texture.texture = STP_STORE_NONE,
            .emissive_texture.texture = STP_STORE_NONE,
        };
        stp_shading shading = {0};
        stp_store_mesh mesh = {
            .vertex_count = 3, .triangle_count = 1, .positions = positions, .indices = indices};
        stp_splats splats = {
            .count = 4,
            .step = 0.5f,
            .positions = grid,
            .normals = normals,
            .materials = materials,
            .octave_count = 2,
            .octave_ends = {2, 4},
            .colors = colors,
            .coverages = coverages,
            .table = {.size = 2, .count = {1, 4}, .radius = {8.0f, 4.0f}},
        };
        stp_store_node node = {.part_count = 1, .set = 0};
        stp_store_part part = {STP_STORE_PART_MESH, 0};
        stp_store_point_set points = {.point_count = 4, .held_by = 1000000000};
        stp_store_content content = {
            .directory = {.node_count = 1,
                          .part_count = 1,
                          .material_count = 1,
                          .shading_count = 1,
                          .mesh_count = 1,
                          .set_count = 1,
                          .nodes = &node,
                          .parts = &part,
                          .materials = &material,
                          .shadings = &shading,
                          .up = 'y'},
            .meshes = &mesh,
            .point_sets = &points,
            .sets = &splats,
        };
        if (what >= 0) {
            spoil(&content, what, &mesh, &splats, &node, positions, indices);
        }
        log.errors = 0;
        stp_result result = stp_store_write(context, &content, path);
        if (result != (what < 0 ? STP_OK : STP_ERROR_ARGUMENT)) {
            fprintf(stderr, "spoilt %d: %s\n", what, stp_result_string(result));
        }
        CHECK_EQUAL(what < 0 ? STP_OK : STP_ERROR_ARGUMENT, result);
        CHECK_EQUAL(what < 0 ? 0 : 1, log.errors);
        CHECK_EQUAL(1, count_files(folder)); // the first, valid one
    }
    unlink(path);
    CHECK_EQUAL(0, rmdir(folder));
    stp_context_destroy(context);
}

// A set of octaves that grow fourfold, as on a surface; the radius halves with each.
static stp_splats make_octaves(stp_arena* arena, uint32_t first, uint32_t octaves, float radius)
{
    stp_splats s = {.step = 0.5f, .octave_count = octaves};
    size_t entries = 0;
    for (uint32_t k = 0; k < octaves; ++k) {
        s.count = first << 2 * k;
        s.octave_ends[k] = s.count;
        entries += s.count;
        s.table.count[k] = s.count;
        s.table.radius[k] = radius;
        s.table.size = k + 1;
        radius *= 0.5f;
    }
    s.positions = stp_arena_alloc(arena, 6 * (size_t)s.count);
    s.normals = stp_arena_alloc(arena, 2 * (size_t)s.count);
    s.materials = stp_arena_alloc(arena, s.count);
    s.colors = stp_arena_alloc(arena, 3 * entries);
    s.coverages = stp_arena_alloc(arena, entries);
    if (s.positions != NULL && s.normals != NULL && s.materials != NULL && s.colors != NULL &&
        s.coverages != NULL) {
        memset(s.positions, 1, 6 * (size_t)s.count);
        memset(s.normals, 2, 2 * (size_t)s.count);
        memset(s.materials, 0, s.count);
        memset(s.colors, 3, 3 * entries);
        memset(s.coverages, 4, entries);
    }
    return s;
}

void test_store_keeps_splats_within_15_bytes(test_state* test)
{
    char folder[256], path[300];
    CHECK(make_folder(folder, path));
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_arena arena = stp_arena_create(context, 1 << 20);
    stp_splats set = make_octaves(&arena, 3, 8, 64.0f), got; // 49,152 splats
    CHECK(set.coverages != NULL);
    stp_shading shading = {0};
    stp_store_content content = {
        .directory = {.root = STP_STORE_NONE,
                      .shading_count = 1,
                      .shadings = &shading,
                      .set_count = 1,
                      .up = 'y'},
        .sets = &set,
    };
    CHECK_EQUAL(STP_OK, stp_store_write(context, &content, path));
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, stp_store_open(context, path, &store));
    uint64_t before = stp_context_live_bytes(context);
    CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, 0, &got));
    uint64_t memory = stp_context_live_bytes(context) - before;
    CHECK_EQUAL(set.count, got.count);
    CHECK(stp_store_file_bytes(store) < 15 * (uint64_t)set.count);
    CHECK(memory < 15 * (uint64_t)set.count);
    CHECK((uintptr_t)got.positions % 64 == 0 && (uintptr_t)got.colors % 64 == 0);
    stp_store_close(store);
    unlink(path);
    CHECK_EQUAL(0, rmdir(folder));
    stp_arena_destroy(&arena);
    stp_context_destroy(context);
}

void test_store_sorts_blocks_coarse_first_across_the_scene(test_state* test)
{
    char folder[256], path[300];
    CHECK(make_folder(folder, path));
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_arena arena = stp_arena_create(context, 1 << 16);
    // in their own space: set 0 reaches 1, 1/2, 1/4 and is used at scales 6 and 1; set 1 reaches 4,
    // 2, 1
    stp_splats sets[2] = {make_octaves(&arena, 2, 3, 1.0f), make_octaves(&arena, 2, 3, 4.0f)};
    stp_affine scaled = {{{0, 6, 0, 1}, {-6, 0, 0, 0}, {0, 0, 6, 0}}};
    stp_store_edge edges[2] = {{0, stp_affine_identity()}, {0, scaled}};
    stp_store_node nodes[2] = {{.set = 0}, {.edge_count = 2, .set = 1}};
    stp_shading shading = {0};
    stp_store_content content = {
        .directory = {.root = 1,
                      .node_count = 2,
                      .nodes = nodes,
                      .edge_count = 2,
                      .edges = edges,
                      .shading_count = 1,
                      .shadings = &shading,
                      .set_count = 2,
                      .up = 'y'},
        .sets = sets,
    };
    CHECK_EQUAL(STP_OK, stp_store_write(context, &content, path));
    // in scene space: set 0 reaches 6, 3, 1.5; set 1 reaches 4, 2, 1. So blocks of both alternate
    stp_mapped_file file;
    CHECK_EQUAL(STP_OK, stp_file_map(context, path, &file));
    uint32_t order[6][2];
    int seen = 0;
    for (size_t length = 0; length <= file.size; ++length) {
        stp_store* store = NULL;
        stp_store_open_desc desc = {.accept_partial = true};
        if (stp_store_open_memory(context, "cut", file.bytes, length, &desc, &store) == STP_OK) {
            stp_splats given[2];
            CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, 0, &given[0]));
            CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, 1, &given[1]));
            uint32_t octaves[2] = {given[0].octave_count, given[1].octave_count};
            if ((int)(octaves[0] + octaves[1]) > seen) {
                order[seen][0] = octaves[0];
                order[seen][1] = octaves[1];
                seen += 1;
            }
            stp_store_close(store);
        }
    }
    stp_file_unmap(&file);
    unlink(path);
    CHECK_EQUAL(0, rmdir(folder));
    stp_arena_destroy(&arena);
    stp_context_destroy(context);
    CHECK_EQUAL(6, seen);
    static const uint32_t wanted[6][2] = {{1, 0}, {1, 1}, {2, 1}, {2, 2}, {3, 2}, {3, 3}};
    CHECK(memcmp(wanted, order, sizeof(wanted)) == 0);
}
