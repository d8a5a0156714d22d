// SPDX-License-Identifier: MIT
#include "scene_helpers.h"
#include "tests.h"

#include "base/math/rng.h"
#include "scene/partition.h"

// All coordinates are multiples of 1/2 and all transforms exact, so triangles can be compared bit
// for bit.

typedef struct triangles {
    uint64_t* keys; ///< sorted hashes of placed triangles and points
    size_t count;
    stp_boxd box;
} triangles;

static int compare_keys(const void* a, const void* b)
{
    uint64_t x = *(const uint64_t*)a, y = *(const uint64_t*)b;
    return (x > y) - (x < y);
}

static uint64_t add_corners(stp_boxd* box, const stp_affine* at, const float* positions,
                            const uint32_t* indices, size_t count, uint32_t salt)
{
    double corners[10] = {0};
    for (size_t k = 0; k < count; ++k) {
        const float* p = positions + 3 * (size_t)indices[k];
        stp_vec3d v = stp_affine_point(at, (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]});
        stp_boxd_add(box, v);
        corners[3 * k] = v.x + 0.0;
        corners[3 * k + 1] = v.y + 0.0;
        corners[3 * k + 2] = v.z + 0.0;
    }
    corners[9] = salt;
    return stp_hash_bytes((stp_hash){0}, corners, sizeof(corners)).low;
}

static bool list_triangles(const stp_scene* scene, uint32_t node, triangles* t)
{
    stp_placed_part* parts = NULL;
    size_t part_count = 0, capacity = 0;
    *t = (triangles){.box = stp_boxd_empty()};
    if (stp_scene_flatten(scene, node, 1000000, &parts, &part_count) != STP_OK) {
        return false;
    }
    for (size_t i = 0; i < part_count; ++i) {
        stp_part part = parts[i].part;
        const stp_mesh* mesh = part.kind == STP_PART_MESH ? &scene->meshes[part.index] : NULL;
        const stp_point_set* set = mesh == NULL ? &scene->point_sets[part.index] : NULL;
        size_t count = mesh != NULL ? mesh->triangle_count : set->point_count;
        uint32_t salt = 8 * (mesh != NULL ? mesh->material : 1000 + set->material) + parts[i].flags;
        bool room = STP_MAKE_ROOM(scene->context, t->keys, capacity, t->count + count);
        for (uint32_t k = 0; room && k < count; ++k) {
            uint32_t source =
                set != NULL ? ((const uint16_t*)set->attributes[STP_ATTRIBUTE_SOURCE])[k] : 0;
            t->keys[t->count++] = mesh != NULL
                                      ? add_corners(&t->box, &parts[i].transform, mesh->positions,
                                                    mesh->indices + 3 * (size_t)k, 3, salt)
                                      : add_corners(&t->box, &parts[i].transform, set->positions,
                                                    &k, 1, salt + 65536 * source);
        }
    }
    stp_free(scene->context, parts);
    if (t->keys != NULL) {
        qsort(t->keys, t->count, 8, compare_keys);
    }
    return true;
}

static bool same_triangles(const triangles* a, const triangles* b)
{
    return a->count == b->count && (a->count == 0 || memcmp(a->keys, b->keys, 8 * a->count) == 0);
}

static bool box_contains(stp_boxd outer, stp_boxd inner)
{
    return outer.min.x <= inner.min.x && outer.min.y <= inner.min.y && outer.min.z <= inner.min.z &&
           outer.max.x >= inner.max.x && outer.max.y >= inner.max.y && outer.max.z >= inner.max.z;
}

// Invariants of any partitioned scene. NULL: all hold; else the one that fails.
static const char* judge_graph(const stp_scene* scene, const stp_partition_desc* desc)
{
    for (uint32_t i = 0; i < scene->node_count; ++i) {
        const stp_node* node = &scene->nodes[i];
        bool moving = (node->flags & STP_OBJECT_MOVING) != 0;
        if (!moving && node->edge_count + node->part_count > desc->child_count) {
            return "too many children";
        }
        uint64_t direct = 0;
        for (uint32_t k = 0; k < node->part_count; ++k) {
            stp_part part = scene->node_parts[node->first_part + k];
            size_t count = part.kind == STP_PART_MESH ? scene->mesh_count : scene->point_set_count;
            if (part.index >= count) {
                return "a part does not exist";
            }
            uint32_t size = part.kind == STP_PART_MESH ? scene->meshes[part.index].triangle_count
                                                       : scene->point_sets[part.index].point_count;
            if (!moving && size > desc->leaf_triangles) {
                return "a leaf is too large";
            }
            direct += size;
        }
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            const stp_edge* edge = &scene->edges[node->first_edge + k];
            if (edge->node >= i) {
                return "a child comes after its parent";
            }
            direct +=
                scene->nodes[edge->node].triangle_count + scene->nodes[edge->node].point_count;
        }
        triangles t;
        if (!list_triangles(scene, i, &t)) {
            return "out of memory";
        }
        bool counted = t.count == direct && direct == node->triangle_count + node->point_count;
        bool contained = box_contains(node->bounds, t.box);
        stp_free(scene->context, t.keys);
        if (!counted || !contained) {
            return counted ? "bounds do not contain" : "counts are wrong";
        }
    }
    return NULL;
}

typedef struct dice_cup {
    uint64_t seed, rolls;
} dice_cup;

static uint32_t roll(dice_cup* dice, uint32_t bound)
{
    return stp_rng_below(dice->seed, dice->rolls++, bound);
}

static stp_affine make_exact_transform(dice_cup* dice, int reach)
{
    stp_affine a = {{{0}}};
    uint32_t turn = roll(dice, 3); // permuted axes, mirrored or doubled ones
    for (uint32_t r = 0; r < 3; ++r) {
        double sizes[8] = {1, -1, 2, 0.5, 1, 1, -1, 1};
        a.m[r][(r + turn) % 3] = sizes[roll(dice, 8)];
        a.m[r][3] = (double)roll(dice, (uint32_t)reach) - reach / 2;
    }
    return a;
}

// A random tree: layers, copies, instances, prototypes, moving objects, meshes and points of all
// sizes.
static bool make_random_scene(stp_scene* scene, uint64_t seed, uint32_t objects)
{
    dice_cup dice = {.seed = seed};
    enum { MESHES = 9 };
    const uint32_t sizes[MESHES] = {1, 2, 5, 20, 63, 64, 65, 300, 1000};
    uint32_t meshes[MESHES], set;
    for (uint32_t i = 0; i < MESHES; ++i) {
        if (!add_strip(scene, sizes[i], (float)roll(&dice, 20), &meshes[i])) {
            return false;
        }
    }
    stp_point_set points = {.point_count = 200};
    points.positions = STP_NEW_ARRAY(scene->context, float, 600);
    uint16_t* sources = STP_NEW_ARRAY(scene->context, uint16_t, 200);
    points.attributes[STP_ATTRIBUTE_SOURCE] = sources;
    for (uint16_t i = 0; sources != NULL && i < 200; ++i) {
        sources[i] = i;
    }
    for (int i = 0; points.positions != NULL && i < 600; ++i) {
        points.positions[i] = (float)roll(&dice, 16);
    }
    if (points.positions == NULL || sources == NULL) {
        stp_free(scene->context, points.positions);
        stp_free(scene->context, sources);
        return false;
    }
    if (stp_scene_add_point_set(scene, &points, &set) != STP_OK) {
        return false;
    }
    for (uint32_t i = 0; i < objects; ++i) {
        uint32_t kind = roll(&dice, 16);
        uint32_t parent = i == 0 || roll(&dice, 8) == 0 ? STP_NONE
                          : roll(&dice, 2) == 0         ? i - 1
                                                        : roll(&dice, i);
        uint32_t flags = kind == 0 ? STP_OBJECT_MOVING : kind == 1 ? STP_OBJECT_PROTOTYPE : 0u;
        bool made = add_object(scene, parent, make_exact_transform(&dice, 400), flags, NULL);
        for (uint32_t k = roll(&dice, 4); made && k > 0; --k) {
            stp_part part = {STP_PART_MESH, meshes[roll(&dice, MESHES)]};
            made = stp_scene_add_part(scene, kind == 3 ? (stp_part){STP_PART_POINTS, set} : part) ==
                   STP_OK;
        }
        for (uint32_t k = 0; made && kind == 2 && k < 20; ++k) {
            stp_affine at = make_exact_transform(&dice, 4000);
            made = stp_scene_add_instance(scene, &at) == STP_OK;
        }
        if (!made) {
            return false;
        }
    }
    return true;
}

void test_partitions_keep_every_triangle_once(test_state* test)
{
    for (uint32_t seed = 0; seed < 8; ++seed) {
        stp_context* context = test_context(NULL, 2, NULL);
        stp_scene* scene = NULL;
        stp_partition_desc desc = {.leaf_triangles = 64, .child_count = 2 + seed % 5};
        CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
        CHECK(make_random_scene(scene, seed, 10 + 6 * seed));
        CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
        enum { MOST = 200 };
        triangles root, before[MOST], after;
        stp_boxd box = scene->nodes[scene->root].bounds;
        CHECK(list_triangles(scene, scene->root, &root));
        for (size_t i = 0; i < scene->object_count; ++i) {
            CHECK(list_triangles(scene, scene->objects[i].node, &before[i]));
        }
        CHECK_EQUAL(STP_OK, stp_scene_partition(scene, &desc));
        const char* wrong = judge_graph(scene, &desc);
        if (wrong != NULL) {
            fprintf(stderr, "seed %u: %s\n", seed, wrong);
        }
        CHECK(wrong == NULL);
        CHECK(list_triangles(scene, scene->root, &after));
        CHECK(same_triangles(&root, &after));
        CHECK(memcmp(&box, &scene->nodes[scene->root].bounds, sizeof(box)) == 0);
        stp_free(context, after.keys);
        stp_free(context, root.keys);
        for (size_t i = 0; i < scene->object_count; ++i) { // regardless of dissolved layers
            CHECK(list_triangles(scene, scene->objects[i].node, &after));
            CHECK(same_triangles(&before[i], &after));
            stp_free(context, after.keys);
            stp_free(context, before[i].keys);
        }
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

// A grid of many small meshes becomes a shallow tree of compact nodes.
void test_many_children_get_a_hierarchy(test_state* test)
{
    enum { SIDE = 60 };
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    uint32_t mesh, top;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK(add_strip(scene, 2, 0.0f, &mesh));
    CHECK(add_object(scene, STP_NONE, stp_affine_identity(), 0, &top));
    for (uint32_t i = 0; i < SIDE * SIDE; ++i) { // in an order unrelated to position
        uint32_t k = i * 1801 % (SIDE * SIDE);
        CHECK(add_mesh_object(scene, top, make_translation(4 * (k % SIDE), 4 * (k / SIDE), 0), mesh,
                              NULL));
    }
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK_EQUAL(STP_OK, stp_scene_partition(scene, &(stp_partition_desc){0}));
    CHECK(judge_graph(scene, &(stp_partition_desc){.leaf_triangles = 400000, .child_count = 16}) ==
          NULL);
    CHECK(scene->node_count < 700); // with 16 a node, 225 would be enough for the leaves
    CHECK_EQUAL(scene->objects[top].node, scene->root); // it would only repeat it
    double leaves = 0.0;
    for (size_t i = 1; i < scene->node_count; ++i) {
        const stp_node* node = &scene->nodes[i];
        stp_vec3d size = stp_subd(node->bounds.max, node->bounds.min);
        bool leaf = true;
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            leaf = leaf && scene->nodes[scene->edges[node->first_edge + k].node].part_count > 0;
        }
        leaves += leaf ? size.x * size.y : 0.0;
    }
    CHECK(leaves <= 1.05 * 240 * 240); // they hardly overlap
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

static bool is_below(const stp_scene* scene, uint32_t top, uint32_t node)
{
    bool found = top == node;
    for (uint32_t i = 0; !found && i < scene->nodes[top].edge_count; ++i) {
        found = is_below(scene, scene->edges[scene->nodes[top].first_edge + i].node, node);
    }
    return found;
}

// Two layers over the same area are sorted by position; a storey stays whole.
void test_layers_are_dissolved(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    uint32_t meshes[2], top, layers[2], storey;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK(add_strip(scene, 2, 0.0f, &meshes[0]) && add_strip(scene, 2, 1.0f, &meshes[1]));
    CHECK(add_object(scene, STP_NONE, stp_affine_identity(), 0, &top));
    for (int layer = 0; layer < 2; ++layer) {
        CHECK(add_object(scene, top, make_translation(0, 0, layer), 0, &layers[layer]));
        for (int i = 0; i < 32; ++i) {
            CHECK(add_mesh_object(scene, layers[layer],
                                  make_translation(16 * (i % 8), 10 * (i % 5), 16 * (i / 8)),
                                  meshes[layer], NULL));
        }
    }
    CHECK(add_object(scene, top, make_translation(0, 40, 0), 0, &storey));
    for (int i = 0; i < 8; ++i) {
        CHECK(add_mesh_object(scene, storey, make_translation(16 * i, 0, 0), meshes[0], NULL));
    }
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    stp_node before = scene->nodes[scene->objects[layers[0]].node];
    CHECK_EQUAL(STP_OK, stp_scene_partition(scene, &(stp_partition_desc){.child_count = 9}));
    CHECK(judge_graph(scene, &(stp_partition_desc){.leaf_triangles = 400000, .child_count = 9}) ==
          NULL);
    CHECK_EQUAL(before.triangle_count, scene->nodes[scene->objects[layers[0]].node].triangle_count);
    CHECK(is_below(scene, scene->root, scene->objects[storey].node));
    CHECK(!is_below(scene, scene->root, scene->objects[layers[0]].node)); // it is still a node
    uint32_t mixed = 0; // nodes with items of both layers
    for (size_t i = 0; i < scene->node_count; ++i) {
        const stp_node* node = &scene->nodes[i];
        bool has[2] = {false, false};
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            const stp_node* child = &scene->nodes[scene->edges[node->first_edge + k].node];
            uint32_t part = child->part_count > 0 ? scene->node_parts[child->first_part].index : 2;
            has[0] = has[0] || part == meshes[0];
            has[1] = has[1] || part == meshes[1];
        }
        mixed += has[0] && has[1];
    }
    CHECK(mixed >= 4);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// A layer: items all over an area of 8 x 4 squares, in shuffled order.
static bool add_layer(stp_scene* scene, uint32_t parent, uint32_t mesh, uint32_t count,
                      uint32_t flags, uint32_t* layer)
{
    bool made = add_object(scene, parent, make_translation(0, 0, mesh), flags, layer);
    for (uint32_t i = 0; made && i < count; ++i) {
        made = add_mesh_object(scene, *layer,
                               make_translation(16 * (i % 8), 10 * (i % 5), 16 * (i / 8 % 4)), mesh,
                               NULL);
    }
    return made;
}

static bool add_use(stp_scene* scene, uint32_t parent, uint32_t used, double z)
{
    return add_object(scene, parent, make_translation(0, 0, z), 0, NULL) &&
           stp_scene_add_use(scene, used) == STP_OK;
}

// Build results are cached by content: other users of the same items must not
// change a split, because it would invalidate the cached results.
void test_partition_of_a_subtree_is_a_function_of_its_content(test_state* test)
{
    stp_hash contents[3];
    for (uint32_t variant = 0; variant < 3; ++variant) {
        stp_context* context = test_context(NULL, 1, NULL);
        stp_scene* scene = NULL;
        uint32_t meshes[3], storey, layers[2];
        CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
        for (uint32_t i = 0; i < 3; ++i) {
            CHECK(add_strip(scene, 2 + i, (float)i, &meshes[i]));
        }
        CHECK(add_object(scene, STP_NONE, make_translation(0, 0, 0), 0, &storey));
        CHECK(add_layer(scene, storey, meshes[0], 32, 0, &layers[0]));
        CHECK(add_layer(scene, storey, meshes[1], 25, 0, &layers[1]));
        if (variant > 0) { // the same layer again: alone, or within another storey
            uint32_t parent = STP_NONE;
            CHECK(add_object(scene, STP_NONE, make_translation(900, 0, 0), 0, &parent));
            CHECK(add_use(scene, parent, layers[0], 0.0));
            CHECK(variant == 1 || add_layer(scene, parent, meshes[2], 30, 0, &parent));
        }
        CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
        stp_partition_desc desc = {.leaf_triangles = 400000, .child_count = 9};
        CHECK_EQUAL(STP_OK, stp_scene_partition(scene, &desc));
        CHECK(judge_graph(scene, &desc) == NULL);
        contents[variant] = scene->nodes[scene->objects[storey].node].content;
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
    CHECK(stp_hash_equal(contents[0], contents[1]));
    CHECK(stp_hash_equal(contents[0], contents[2]));
}

// Dissolving shared items duplicates them for each user: not done if they are nearly all its
// content, or if the copies would exceed the whole scene.
void test_dissolving_does_not_undo_sharing(test_state* test)
{
    for (uint32_t variant = 0; variant < 2; ++variant) {
        enum { USES = 200, ITEMS = 300 };
        stp_context* context = test_context(NULL, 1, NULL);
        stp_scene* scene = NULL;
        uint32_t meshes[2], shared, parent;
        CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
        CHECK(add_strip(scene, 2, 0.0f, &meshes[0]) && add_strip(scene, 3, 1.0f, &meshes[1]));
        CHECK(add_layer(scene, STP_NONE, meshes[0], ITEMS, STP_OBJECT_PROTOTYPE, &shared));
        for (uint32_t i = 0; i < USES; ++i) {
            CHECK(add_object(scene, STP_NONE, make_translation(500.0 * i, 0, 0), 0, &parent));
            CHECK(add_use(scene, parent, shared, 0.0));
            for (uint32_t k = 0; k < (variant == 0 ? 2 : ITEMS / 4); ++k) { // all different
                CHECK(add_mesh_object(scene, parent, make_translation(i / 2 + k, k, 32), meshes[1],
                                      NULL));
            }
        }
        CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
        size_t before = scene->edge_count;
        CHECK_EQUAL(STP_OK, stp_scene_partition(scene, &(stp_partition_desc){0}));
        CHECK(scene->edge_count < (variant == 0 ? before + before / 2 : 3 * before));
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

// A mesh with several instances, also mirrored, is split once; a moving one stays whole.
void test_shared_meshes_are_split_once(test_state* test)
{
    stp_context* context = test_context(NULL, 3, NULL);
    stp_scene* scene = NULL;
    uint32_t mesh, still, moving;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    stp_mesh strip = make_strip_mesh(context, 1001, 3.0f);
    size_t vertices = strip.vertex_count;
    strip.name = "strip";
    strip.normals = STP_NEW_ZEROED(context, float, 3 * vertices);
    strip.texcoords[1] = STP_NEW_ZEROED(context, float, 2 * vertices);
    strip.colors = STP_NEW_ZEROED(context, uint16_t, 4 * vertices);
    CHECK(strip.normals != NULL && strip.texcoords[1] != NULL && strip.colors != NULL);
    for (size_t i = 0; i < vertices; ++i) { // attributes tell which vertex they are of
        strip.normals[3 * i + 1] = strip.positions[3 * i];
        strip.texcoords[1][2 * i] = strip.positions[3 * i];
        strip.colors[4 * i + 3] = (uint16_t)(2.0f * strip.positions[3 * i]);
    }
    CHECK_EQUAL(STP_OK, stp_scene_add_mesh(scene, &strip, &mesh));
    for (int i = 0; i < 10; ++i) {
        stp_affine at = {{{i % 2 == 0 ? 1 : -1, 0, 0, 0}, {0, 1 + i % 3, 0, 5 * i}, {0, 0, 1, 0}}};
        CHECK(add_mesh_object(scene, STP_NONE, at, mesh, &still));
    }
    CHECK(add_object(scene, STP_NONE, stp_affine_identity(), STP_OBJECT_MOVING, &moving));
    CHECK_EQUAL(STP_OK, stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh}));
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    double step = scene->meshes[0].grid_step;
    CHECK_EQUAL(STP_OK, stp_scene_partition(scene, &(stp_partition_desc){.leaf_triangles = 100}));
    CHECK_EQUAL(12, scene->mesh_count); // whole, and 11 pieces
    uint32_t minimum = UINT32_MAX, maximum = 0;
    for (size_t i = 1; i < scene->mesh_count; ++i) {
        const stp_mesh* piece = &scene->meshes[i];
        minimum = piece->triangle_count < minimum ? piece->triangle_count : minimum;
        maximum = piece->triangle_count > maximum ? piece->triangle_count : maximum;
        CHECK_EQUAL(piece->triangle_count + 2, piece->vertex_count); // compacted
        CHECK(strcmp(piece->name, "strip") == 0 && piece->grid_step == step);
        CHECK(piece->texcoords[0] == NULL);
        for (size_t v = 0; v < piece->vertex_count; ++v) {
            float x = piece->positions[3 * v];
            CHECK(piece->normals[3 * v + 1] == x && piece->texcoords[1][2 * v] == x);
            CHECK_EQUAL((uint16_t)(2.0f * x), piece->colors[4 * v + 3]);
        }
    }
    CHECK(minimum == 91 && maximum == 91);
    const stp_node* split = &scene->nodes[scene->objects[still].node];
    CHECK_EQUAL(11, split->edge_count);
    CHECK_EQUAL(1, scene->nodes[scene->objects[moving].node].part_count);
    CHECK_EQUAL(0, scene->nodes[scene->objects[moving].node].edge_count);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

void test_degenerate_scenes_are_partitioned(test_state* test)
{
    enum { COUNT = 300 };
    for (int variant = 0; variant < 5; ++variant) {
        stp_context* context = test_context(NULL, 2, NULL);
        stp_scene* scene = NULL;
        uint32_t mesh, top;
        stp_partition_desc desc = {.leaf_triangles = 10, .child_count = 3};
        CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
        stp_mesh strip = make_strip_mesh(context, 64, 0.0f);
        for (uint32_t i = 0; i < 3 * strip.vertex_count; ++i) {
            strip.positions[i] *= variant == 1 ? 0.0f : variant == 2 ? 1e15f : 1.0f;
        }
        for (uint32_t i = 0; variant == 4 && i < 3 * strip.triangle_count; ++i) {
            strip.indices[i] = i % 3; // one triangle, 64 times
        }
        CHECK_EQUAL(STP_OK, stp_scene_add_mesh(scene, &strip, &mesh));
        CHECK(add_object(scene, STP_NONE, stp_affine_identity(), 0, &top));
        for (int i = 0; i < COUNT; ++i) { // all at one place, or ever farther out
            double at =
                variant == 3 ? (double)(UINT64_C(1) << (i % 60)) * (i > 150 ? 1e-30 : 0.5) : 0;
            stp_affine transform = make_translation(at, 0, 0);
            transform.m[1][3] = variant == 2 ? 1e15 * i : 0;
            CHECK(add_mesh_object(scene, top, transform, mesh, NULL));
        }
        CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
        CHECK_EQUAL(STP_OK, stp_scene_partition(scene, &desc));
        CHECK(judge_graph(scene, &desc) == NULL);
        CHECK_EQUAL(64 * COUNT, scene->nodes[scene->root].triangle_count);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* empty = NULL;
    CHECK(context != NULL && stp_scene_create(context, &empty) == STP_OK);
    CHECK_EQUAL(STP_OK, stp_scene_finish(empty));
    CHECK_EQUAL(STP_OK, stp_scene_partition(empty, &(stp_partition_desc){0}));
    CHECK_EQUAL(STP_NONE, empty->root);
    stp_scene_destroy(empty);
    stp_context_destroy(context);
}

// Identity transforms do not get in the way: no node merely contains another.
void test_chains_are_collapsed(test_state* test)
{
    enum { DEPTH = 3000 };
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scene* scene = NULL;
    uint32_t mesh, parent = STP_NONE;
    CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
    CHECK(add_strip(scene, 1, 0.0f, &mesh));
    for (int i = 0; i < DEPTH; ++i) {
        CHECK(add_object(scene, parent, make_translation(0, 1, 0), 0, &parent));
    }
    CHECK_EQUAL(STP_OK, stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh}));
    CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
    CHECK_EQUAL(STP_OK, stp_scene_partition(scene, &(stp_partition_desc){0}));
    const stp_node* root = &scene->nodes[scene->root];
    CHECK_EQUAL(1, root->edge_count);
    CHECK(scene->edges[root->first_edge].transform.m[1][3] == DEPTH);
    CHECK_EQUAL(1, scene->nodes[scene->edges[root->first_edge].node].part_count);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

// A transform of a whole input does not remain between the root and its content.
void test_roots_hold_content_themselves(test_state* test)
{
    for (int variant = 0; variant < 3; ++variant) {
        stp_context* context = test_context(NULL, 1, NULL);
        stp_scene* scene = NULL;
        uint32_t mesh, file, axes;
        CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
        CHECK(add_strip(scene, 1, 0.0f, &mesh));
        stp_affine turn = {{{2, 0, 0, 0}, {0, 0, 2, 0}, {0, -2, 0, 0}}};
        stp_affine transform = variant == 0 ? stp_affine_identity() : turn;
        uint32_t flags = variant == 2 ? STP_OBJECT_MOVING : 0u;
        CHECK(add_object(scene, STP_NONE, transform, flags, &file));
        CHECK(add_object(scene, file, stp_affine_identity(), 0, &axes));
        for (int i = 0; i < 10; ++i) {
            CHECK(add_mesh_object(scene, axes, make_translation(i, i % 2, 0), mesh, NULL));
        }
        CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
        stp_partition_desc desc = {.leaf_triangles = 100, .child_count = 4};
        triangles before, after;
        CHECK(list_triangles(scene, scene->root, &before));
        CHECK_EQUAL(STP_OK, stp_scene_partition(scene, &desc));
        CHECK(judge_graph(scene, &desc) == NULL);
        CHECK(list_triangles(scene, scene->root, &after));
        CHECK(same_triangles(&before, &after));
        const stp_node* root = &scene->nodes[scene->root];
        CHECK_EQUAL(variant == 2, root->edge_count == 1);
        CHECK_EQUAL(variant == 0, scene->objects[file].node == scene->root);
        CHECK_EQUAL(variant != 2, scene->objects[file].node == scene->objects[axes].node);
        stp_free(context, before.keys);
        stp_free(context, after.keys);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

static stp_hash digest(const stp_scene* scene)
{
    stp_hash hash = {0};
    for (size_t i = 0; i < scene->node_count; ++i) {
        const stp_node* node = &scene->nodes[i];
        hash = stp_hash_bytes(hash, &node->content, sizeof(node->content));
        hash = stp_hash_bytes(hash, &node->bounds, sizeof(node->bounds));
        hash = stp_hash_bytes(hash, &node->area, sizeof(node->area));
    }
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        hash = stp_hash_bytes(hash, &scene->meshes[i].content, sizeof(stp_hash));
    }
    return hash;
}

void test_partitions_do_not_depend_on_threads_or_spill(test_state* test)
{
    stp_hash first = {0};
    for (uint32_t variant = 0; variant < 5; ++variant) {
        stp_context* context = test_context(NULL, 1 + variant % 3, NULL);
        stp_scene* scene = NULL;
        stp_spill* spill = NULL;
        CHECK(context != NULL && stp_spill_create(context, ".", &spill) == STP_OK);
        CHECK(stp_scene_create(context, &scene) == STP_OK);
        if (variant >= 3) {
            stp_scene_use_spill(scene, spill, variant == 3 ? 0 : 20000);
        }
        CHECK(make_random_scene(scene, 77, 150));
        CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
        stp_partition_desc desc = {.leaf_triangles = 50, .child_count = 4};
        CHECK_EQUAL(STP_OK, stp_scene_partition(scene, &desc));
        CHECK(variant < 3 || scene->bulk_bytes <= 20000);
        stp_hash hash = digest(scene);
        first = variant == 0 ? hash : first;
        CHECK(stp_hash_equal(first, hash));
        stp_scene_destroy(scene);
        stp_spill_destroy(spill);
        stp_context_destroy(context);
    }
}

void test_partitions_survive_failing_allocator(test_state* test)
{
    bool made = false;
    int failures = 0;
    for (int n = 0; !made && n < 3000; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 2, &log);
        if (context != NULL) {
            stp_scene* scene = NULL;
            stp_partition_desc desc = {.leaf_triangles = 50, .child_count = 4};
            made = stp_scene_create(context, &scene) == STP_OK && make_random_scene(scene, 5, 40) &&
                   stp_scene_finish(scene) == STP_OK && stp_scene_partition(scene, &desc) == STP_OK;
            failures += !made;
            CHECK(log.errors <= 1);
            stp_scene_destroy(scene);
            stp_context_destroy(context);
        }
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made && failures > 100);
}

// Points of a large cloud are split into small pieces; a small cloud stays whole, and so does a
// larger one whose outside must be found.
void test_large_clouds_are_split_finely(test_state* test)
{
    static const struct {
        uint32_t points;
        bool has_normals, finds_signs;
        uint32_t pieces, maximum;
    } cases[] = {{400000, false, false, 1, 400000},
                 {400001, false, false, 17, 25000},
                 {400001, false, true, 1, 1000000},
                 {400001, true, true, 17, 25000},
                 {1000001, false, true, 2, 1000000}};
    for (size_t k = 0; k < sizeof(cases) / sizeof(cases[0]); ++k) {
        size_t count = cases[k].points;
        stp_context* context = test_context(NULL, 2, NULL);
        stp_scene* scene = NULL;
        uint32_t object, index;
        const stp_partition_desc desc = {.finds_signs = cases[k].finds_signs};
        CHECK(context != NULL && stp_scene_create(context, &scene) == STP_OK);
        stp_point_set set = {.point_count = cases[k].points,
                             .positions = STP_NEW_ARRAY(context, float, 3 * count)};
        set.normals = cases[k].has_normals ? STP_NEW_ZEROED(context, float, 3 * count) : NULL;
        CHECK(set.positions != NULL && (set.normals != NULL) == cases[k].has_normals);
        for (uint32_t i = 0; i < count; ++i) {
            set.positions[3 * i] = (float)(i % 400);
            set.positions[3 * i + 1] = 0.0f;
            set.positions[3 * i + 2] = (float)(i / 400);
        }
        CHECK_EQUAL(STP_OK, stp_scene_add_point_set(scene, &set, &index));
        CHECK(add_object(scene, STP_NONE, stp_affine_identity(), 0, &object));
        CHECK_EQUAL(STP_OK, stp_scene_add_part(scene, (stp_part){STP_PART_POINTS, index}));
        CHECK_EQUAL(STP_OK, stp_scene_finish(scene));
        CHECK_EQUAL(STP_OK, stp_scene_partition(scene, &desc));
        uint64_t points = 0;
        uint32_t pieces = 0;
        for (size_t i = 0; i < scene->node_part_count; ++i) {
            uint32_t size = scene->point_sets[scene->node_parts[i].index].point_count;
            CHECK(size <= cases[k].maximum);
            points += size;
            pieces += 1;
        }
        CHECK_EQUAL(count, points);
        CHECK_EQUAL(cases[k].pieces, pieces);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}
