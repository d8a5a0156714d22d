// SPDX-License-Identifier: MIT
// Cost of a node in its level switch, from its set to its content: never much more than the more expensive
// of the two.
#include "support_built.h"
#include "tests.h"

#include "base/math/math.h"
#include "base/math/rng.h"
#include "base/splats/prefix_table.h"
#include "builder/build_scene.h"
#include "select/select.h"
#include "select/view_frame.h"

#include <string.h>
#include <unistd.h>

// Work in triangles, as in select_internal.h and docs/notes/2026-11-proportion.md.
#define SPLAT 1.5
#define MOST 1.2

static double uniform(uint64_t seed, uint64_t index, double low, double high)
{
    return low + (high - low) * (double)(stp_rng_hash(seed, index) >> 11) * 0x1p-53;
}

static stp_view random_view(const stp_store* store, uint64_t seed)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    const stp_boxd* box = &d->nodes[d->root].bounds;
    stp_vec3d size = stp_subd(box->max, box->min);
    stp_vec3d center = stp_addd(box->min, stp_scaled(size, 0.5));
    double far = sqrt(stp_dotd(size, size)) * exp(uniform(seed, 0, -0.3, 5.0));
    double turn = uniform(seed, 1, 0.0, 6.3), lift = uniform(seed, 2, -1.2, 1.2);
    stp_vec3d from = {far * cos(turn) * cos(lift), far * sin(lift), far * sin(turn) * cos(lift)};
    return (stp_view){.eye = stp_addd(center, from),
                      .target = center,
                      .up = {0, 1, 0},
                      .fov_degrees = 50,
                      .width = 480,
                      .height = 360};
}

// Nearest depth of a placed node, and the prefix of its set that covers there.
static bool find_wanted(const stp_store* store, const stp_view* view, float splat_size,
                        const stp_store_node* node, const stp_affine* place, double* depth,
                        uint32_t* wanted)
{
    stp_view_frame frame;
    stp_boxd box = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
    for (int i = 0; i < 8; ++i) {
        const stp_boxd* b = &node->bounds;
        stp_vec3d corner = {(i & 1) != 0 ? b->max.x : b->min.x, (i & 2) != 0 ? b->max.y : b->min.y,
                            (i & 4) != 0 ? b->max.z : b->min.z};
        stp_vec3d p = stp_affine_point(place, corner);
        box.min = (stp_vec3d){fmin(box.min.x, p.x), fmin(box.min.y, p.y), fmin(box.min.z, p.z)};
        box.max = (stp_vec3d){fmax(box.max.x, p.x), fmax(box.max.y, p.y), fmax(box.max.z, p.z)};
    }
    double farthest;
    if (!stp_view_frame_make(view, &frame) ||
        !stp_view_frame_depths(&frame, &box, depth, &farthest)) {
        return false;
    }
    double radius = 0.5 * (double)splat_size * stp_view_frame_pixel_size(&frame, *depth);
    const stp_splats* splats = stp_store_describe_splat_set(store, node->set);
    *wanted = stp_prefix_table_count(&splats->table, (float)(radius / stp_affine_scale(place)));
    return true;
}

static double triangles_drawn(const stp_draw_item* item, const stp_store* store, double depth)
{
    double count = (double)stp_store_describe_mesh(store, item->index)->triangle_count;
    return count * (double)stp_draw_share(item, (float)depth);
}

// Number of triangles drawn of a node's own parts at the place of its set.
static double triangles_beside(const stp_store* store, const stp_draw_list* list,
                               const stp_store_node* node, const stp_affine* place, double depth)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    double sum = 0.0;
    for (uint32_t k = 0; k < node->part_count; ++k) {
        for (size_t i = 0; i < list->count; ++i) { // once, although it may be there twice
            const stp_draw_item* item = &list->items[i];
            if (item->kind == STP_DRAW_MESH &&
                item->index == d->parts[node->first_part + k].index &&
                memcmp(&item->transform, place, sizeof(*place)) == 0) {
                sum += triangles_drawn(item, store, depth);
                break;
            }
        }
    }
    return sum;
}

// Whether each part of a node is listed once at the place of its set: other nodes may be opened
// there, or have sets.
static bool stands_alone(const stp_store* store, const stp_draw_list* originals,
                         const stp_store_node* node, const stp_affine* place)
{
    const stp_store_part* parts = stp_store_get_directory(store)->parts + node->first_part;
    for (uint32_t k = 0; k < node->part_count; ++k) {
        uint32_t found = 0;
        for (size_t i = 0; i < originals->count; ++i) {
            const stp_draw_item* item = &originals->items[i];
            found += item->index == parts[k].index &&
                     memcmp(&item->transform, place, sizeof(*place)) == 0;
        }
        if (found != 1) {
            return false;
        }
    }
    return true;
}

// Checks every leaf whose set is listed. @return how many of them are in it; -1: one costs
// too much
static int check_leaves(const stp_store* store, const stp_view* view, float splat_size,
                        const stp_draw_list* list, const stp_draw_list* originals)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    int both = 0;
    for (size_t i = 0; i < list->count; ++i) {
        const stp_draw_item* item = &list->items[i];
        for (uint32_t n = 0; n < d->node_count && item->kind == STP_DRAW_SPLATS; ++n) {
            const stp_store_node* node = &d->nodes[n];
            double depth;
            uint32_t wanted;
            if (node->set != item->index || node->edge_count > 0 || node->point_count > 0 ||
                !stands_alone(store, originals, node, &item->transform) ||
                !find_wanted(store, view, splat_size, node, &item->transform, &depth, &wanted)) {
                continue;
            }
            double splats = SPLAT * (double)item->prefix;
            double triangles = triangles_beside(store, list, node, &item->transform, depth);
            double dearer = fmax(SPLAT * (double)wanted, (double)node->triangle_count);
            if (splats + triangles > MOST * dearer * (1.0 + 1e-6) + SPLAT) {
                fprintf(stderr, "node %u: %u splats beside %.0f triangles; alone %u or %llu\n", n,
                        item->prefix, triangles, wanted, (unsigned long long)node->triangle_count);
                return -1;
            }
            both += triangles > 0.0;
        }
    }
    return both;
}

void test_level_switches_of_random_graphs_cost_little(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    int both = 0;
    for (uint64_t seed = 0; seed < 6; ++seed) {
        stp_store* store = built_open(context, seed, true);
        CHECK(store != NULL);
        stp_draw_list list = {0}, originals = {0};
        for (uint64_t round = 0; round < 150; ++round) {
            stp_view view = random_view(store, 1000 * seed + round);
            stp_quality quality = {.splat_size = (float)(1 + round % 9),
                                   .early_switch = round % 2 == 0 ? 0.0f : 1.0f};
            stp_quality reference = {.splat_size = 1, .reference = true};
            CHECK_EQUAL(STP_OK, stp_select(context, store, &view, &reference, &originals));
            CHECK_EQUAL(STP_OK, stp_select(context, store, &view, &quality, &list));
            int found = check_leaves(store, &view, quality.splat_size, &list, &originals);
            CHECK(found >= 0);
            both += found;
        }
        stp_draw_list_destroy(context, &originals);
        stp_draw_list_destroy(context, &list);
        stp_store_close(store);
    }
    CHECK(both > 100);
    stp_context_destroy(context);
}

enum { SIDE = 48 };

// A model: a wavy sheet of 4,608 triangles, once or many times.
static stp_result generate_model(stp_scene* scene, const char* name, void* user)
{
    uint32_t row = SIDE + 1, mesh_index, uses = *(const uint32_t*)user;
    stp_mesh mesh = {.vertex_count = row * row, .triangle_count = 2 * SIDE * SIDE};
    (void)name;
    mesh.positions = STP_NEW_ARRAY(scene->context, float, (size_t)3 * row * row);
    mesh.indices = STP_NEW_ARRAY(scene->context, uint32_t, (size_t)6 * SIDE * SIDE);
    if (mesh.positions == NULL || mesh.indices == NULL) {
        abort(); // the test has no memory
    }
    for (uint32_t i = 0; i < row * row; ++i) {
        float x = (float)(i % row), z = (float)(i / row);
        const float position[3] = {x, 5.0f * sinf(0.2f * x) * cosf(0.3f * z), z};
        memcpy(mesh.positions + 3 * (size_t)i, position, sizeof(position));
    }
    for (uint32_t i = 0; i < SIDE * SIDE; ++i) {
        uint32_t a = i / SIDE * row + i % SIDE;
        const uint32_t corners[6] = {a, a + row, a + 1, a + 1, a + row, a + row + 1};
        memcpy(mesh.indices + 6 * (size_t)i, corners, sizeof(corners));
    }
    stp_result result = stp_scene_add_mesh(scene, &mesh, &mesh_index);
    for (uint32_t i = 0; i < uses && result == STP_OK; ++i) {
        stp_object object = {.parent = STP_NONE, .transform = stp_affine_identity()};
        object.transform.m[0][3] = 1.3 * SIDE * (i % 5);
        object.transform.m[2][3] = 1.3 * SIDE * (i / 5);
        result = stp_scene_add_object(scene, &object, NULL);
        result = result == STP_OK ? stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh_index})
                                  : result;
    }
    return result;
}

static stp_store* open_model(stp_context* context, uint32_t uses)
{
    char folder[64] = "stp_level_switch_XXXXXX", path[96];
    if (mkdtemp(folder) == NULL) {
        return NULL;
    }
    snprintf(path, sizeof(path), "%s/a.stip", folder);
    const char* inputs[] = {"scene:model"};
    stp_build_desc desc = {.inputs = inputs,
                           .input_count = 1,
                           .output = path,
                           .threshold = 1000,
                           .no_levels = true,
                           .generate = generate_model,
                           .generate_user = &uses};
    stp_store* store = NULL;
    stp_result result = stp_build(context, &desc, NULL);
    result = result == STP_OK ? stp_store_open(context, path, &store) : result;
    unlink(path);
    rmdir(folder);
    return result == STP_OK ? store : NULL;
}

static double work_of(const stp_store* store, const stp_view* view, const stp_draw_list* list)
{
    stp_view_frame frame;
    double work = SPLAT * (double)list->splat_count;
    for (size_t i = 0; i < list->count && stp_view_frame_make(view, &frame); ++i) {
        const stp_draw_item* item = &list->items[i];
        if (item->kind == STP_DRAW_MESH) {
            stp_box b = stp_store_describe_mesh(store, item->index)->bounds;
            stp_vec3d middle =
                stp_scaled(stp_addd(stp_to_double(b.min), stp_to_double(b.max)), 0.5);
            stp_vec3d at = stp_affine_point(&item->transform, middle);
            work += triangles_drawn(item, store, stp_dotd(stp_subd(at, frame.eye), frame.forward));
        }
    }
    return work;
}

// For models built with default options, a whole picture costs at most a fifth more than all of its
// triangles, and much less from afar; triangles are drawn if they are fewer than eight per splat.
void test_level_switches_of_models_cost_little(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    for (uint32_t uses = 1; uses <= 25; uses += 24) {
        stp_store* store = open_model(context, uses);
        CHECK(store != NULL);
        stp_draw_list list = {0}, originals = {0};
        int mixed = 0, splats = 0, triangles = 0;
        for (uint64_t round = 0; round < 400; ++round) {
            stp_view view = random_view(store, round);
            stp_quality quality = {.splat_size = (float)(1 + round % 8)};
            stp_quality reference = {.splat_size = 1, .reference = true};
            CHECK_EQUAL(STP_OK, stp_select(context, store, &view, &reference, &originals));
            double all = (double)originals.triangle_count;
            CHECK_EQUAL(STP_OK, stp_select(context, store, &view, &quality, &list));
            CHECK(check_leaves(store, &view, quality.splat_size, &list, &originals) >= 0);
            CHECK(work_of(store, &view, &list) <= MOST * all + SPLAT);
            bool has_splats = list.splat_count > 0, has_triangles = list.triangle_count > 0;
            CHECK(has_triangles || SPLAT * (double)list.splat_count < 0.25 * all);
            mixed += has_splats && has_triangles;
            splats += !has_triangles;
            triangles += !has_splats;
        }
        CHECK(mixed > 10 && splats > 10 && triangles > 10);
        stp_draw_list_destroy(context, &originals);
        stp_draw_list_destroy(context, &list);
        stp_store_close(store);
    }
    stp_context_destroy(context);
}
