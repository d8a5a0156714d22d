// SPDX-License-Identifier: MIT
#include "builder/draft_content.h"

#include "base/core/saturate.h"
#include "base/math/rng.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

// Limits that keep a draft quick to draw: visited nodes, triangles and points with all instances.
static const double visits_max = 4e6, triangles_max = 2.4e7, points_max = 1e6,
                    own_points_max = 1.6e7;

// How a mesh or point set is exposed: its uses outside the subtrees that splats represent.
typedef struct exposure {
    double uses;    ///< number of uses
    double weight;  ///< total factor on its area
    uint32_t place; ///< index among the draft's meshes or point sets; STP_NONE: not there
    bool as_points;
} exposure;

// Limits the areas: things can be stretched without bound along an axis in which they have no
// extent.
static const double area_max = 1e60;

typedef struct draft_work {
    stp_context* context;
    const stp_draft_state* state;
    stp_scene seen;        ///< the scene, where it is copied unchanged
    double *paths, *areas; ///< by node
    exposure *meshes, *point_sets;
    double visits;
} draft_work;

static bool is_coded(const stp_draft_state* s, size_t mesh)
{
    return s->coded != NULL && s->coded[mesh].bytes != NULL;
}

static bool has_set(const stp_draft_state* s, size_t node)
{
    uint32_t set = s->set_of_node != NULL ? s->set_of_node[node] : STP_NONE;
    return set != STP_NONE && s->sets[set].count != 0;
}

// Counts the paths from the root to each node, and the factors on its areas; not below splats.
static void count_paths(draft_work* w)
{
    const stp_scene* scene = w->state->scene;
    w->paths[scene->root] = w->areas[scene->root] = 1.0;
    for (size_t i = (size_t)scene->root + 1; i-- > 0;) {
        const stp_node* node = &scene->nodes[i];
        w->visits += w->paths[i];
        if (has_set(w->state, i)) {
            continue;
        }
        for (uint32_t e = 0; e < node->edge_count; ++e) {
            const stp_edge* edge = &scene->edges[node->first_edge + e];
            double scale = stp_affine_scale(&edge->transform);
            assert(edge->node < i && "all paths to a node must be known before it is opened");
            w->paths[edge->node] += w->paths[i];
            w->areas[edge->node] += w->areas[i] * scale * scale;
        }
        for (uint32_t p = 0; p < node->part_count; ++p) {
            stp_part part = scene->node_parts[node->first_part + p];
            exposure* x =
                part.kind == STP_PART_MESH ? &w->meshes[part.index] : &w->point_sets[part.index];
            x->uses += w->paths[i];
            x->weight += w->areas[i];
        }
    }
}

// Area of a mesh in all its uses.
static double area_of(const draft_work* w, size_t mesh)
{
    double area = w->meshes[mesh].weight * w->state->scene->meshes[mesh].area;
    return area > 0.0 ? fmin(area, area_max) : 0.0;
}

// A mesh and the area that its triangles show.
typedef struct candidate {
    double area; ///< average area of one triangle
    uint32_t mesh;
} candidate;

static int larger_first(const void* a, const void* b)
{
    const candidate *p = a, *q = b;
    return p->area != q->area ? (p->area > q->area ? -1 : 1) : (p->mesh < q->mesh ? -1 : 1);
}

// Meshes that are not coded, or whose triangles would be too many, become points. Meshes with large
// triangles are kept first. @return false if memory runs out
static bool choose_meshes(draft_work* w)
{
    const stp_scene* scene = w->state->scene;
    size_t count = scene->mesh_count;
    candidate* order = STP_NEW_ARRAY(w->context, candidate, count + 1);
    if (order == NULL) {
        return false;
    }
    for (size_t i = 0; i < count; ++i) {
        const stp_mesh* mesh = &scene->meshes[i];
        double triangles = (double)mesh->triangle_count * (w->meshes[i].uses + 1e-9);
        order[i] = (candidate){triangles > 0.0 ? area_of(w, i) / triangles : 0.0, (uint32_t)i};
    }
    qsort(order, count, sizeof(*order), larger_first);
    double left = triangles_max;
    for (size_t i = 0; i < count; ++i) {
        uint32_t mesh = order[i].mesh;
        exposure* x = &w->meshes[mesh];
        double triangles = x->uses * (double)scene->meshes[mesh].triangle_count;
        x->as_points = !is_coded(w->state, mesh) || triangles > left;
        left -= x->as_points ? 0.0 : triangles;
        assert(left >= 0.0 && "more triangles than a draft may have");
    }
    stp_free(w->context, order);
    uint32_t place = 0;
    for (size_t i = 0; i < count; ++i) {
        w->meshes[i].place = w->meshes[i].as_points ? STP_NONE : place++;
    }
    return true;
}

// Number of points by share of the total area. The fraction rounds up or down at random.
static uint32_t share_of(double points, size_t index)
{
    uint32_t whole = points < 1e9 ? (uint32_t)points : 1000000000u;
    double rest = (double)(stp_rng_hash(7, index) >> 11) * 0x1p-53;
    return whole + (rest < points - (double)whole ? 1 : 0);
}

static stp_result sample_meshes(draft_work* w, stp_arena* arena, stp_store_point_set* sets,
                                uint32_t* set_count)
{
    const stp_scene* scene = &w->seen;
    double all = 0.0;
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        all += w->meshes[i].as_points ? area_of(w, i) : 0.0;
    }
    for (size_t i = 0; i < scene->mesh_count && all > 0.0; ++i) {
        exposure* x = &w->meshes[i];
        if (!x->as_points || !(x->uses > 0.0)) {
            continue;
        }
        double points = points_max * area_of(w, i) / (all * x->uses);
        assert(points >= 0.0 && points < 2.0 * points_max && "a share of all points");
        uint32_t count = share_of(points, i);
        uint64_t maximum = 4 * (uint64_t)scene->meshes[i].triangle_count;
        count =
            count < maximum || scene->meshes[i].triangle_count > 1000 ? count : (uint32_t)maximum;
        if (count == 0) {
            continue;
        }
        if (!stp_preview_mesh(arena, scene, (uint32_t)i, count, &sets[*set_count])) {
            return stp_fail_memory(w->context);
        }
        x->place = (*set_count)++;
    }
    return STP_OK;
}

static stp_result sample_points(draft_work* w, stp_arena* arena, stp_store_point_set* sets,
                                uint32_t* set_count)
{
    const stp_scene* scene = w->state->scene;
    double all = 0.0;
    for (size_t i = 0; i < scene->point_set_count; ++i) {
        all += w->point_sets[i].uses * (double)scene->point_sets[i].point_count;
    }
    double share = all > own_points_max ? own_points_max / all : 1.0;
    for (size_t i = 0; i < scene->point_set_count; ++i) {
        const stp_point_set* from = &scene->point_sets[i];
        uint32_t count = (uint32_t)ceil(share * (double)from->point_count);
        assert(count <= from->point_count);
        if (!stp_preview_points(arena, from, count, &sets[*set_count])) {
            return stp_fail_memory(w->context);
        }
        w->point_sets[i].place = (*set_count)++;
    }
    return STP_OK;
}

// Maps parts to the draft's, and updates the counts below each node. @return false if memory runs
// out
static bool convert_parts(draft_work* w, stp_build_content* c)
{
    const stp_scene* scene = w->state->scene;
    stp_store_directory* d = &c->content.directory;
    stp_store_part* parts = STP_ARENA_ARRAY(&c->arena, stp_store_part, scene->node_part_count + 1);
    stp_store_node* nodes = STP_ARENA_ARRAY(&c->arena, stp_store_node, scene->node_count + 1);
    if (parts == NULL || nodes == NULL) {
        return false;
    }
    uint32_t count = 0;
    for (size_t i = 0; i < scene->node_count; ++i) {
        const stp_node* from = &scene->nodes[i];
        stp_store_node* node = &nodes[i];
        *node = d->nodes[i];
        node->first_part = count;
        node->triangle_count = node->point_count = 0;
        for (uint32_t p = 0; p < from->part_count; ++p) {
            stp_part part = scene->node_parts[from->first_part + p];
            bool is_mesh = part.kind == STP_PART_MESH;
            const exposure* x = is_mesh ? &w->meshes[part.index] : &w->point_sets[part.index];
            if (x->place == STP_NONE) {
                continue;
            }
            bool triangles = is_mesh && !x->as_points;
            parts[count++] =
                (stp_store_part){triangles ? STP_STORE_PART_MESH : STP_STORE_PART_POINTS, x->place};
            node->triangle_count += triangles ? scene->meshes[part.index].triangle_count : 0;
            node->point_count += triangles ? 0 : c->content.point_sets[x->place].point_count;
        }
        node->part_count = count - node->first_part;
        for (uint32_t e = 0; e < node->edge_count; ++e) {
            const stp_store_node* child = &nodes[d->edges[node->first_edge + e].node];
            node->triangle_count = stp_add_saturated(node->triangle_count, child->triangle_count);
            node->point_count = stp_add_saturated(node->point_count, child->point_count);
        }
    }
    assert(count <= scene->node_part_count && "parts are kept or left out, never added");
    d->parts = parts;
    d->part_count = count;
    d->nodes = nodes;
    return true;
}

// Keeps only meshes whose triangles are shown.
static bool convert_meshes(draft_work* w, stp_build_content* c)
{
    size_t all = w->state->scene->mesh_count;
    stp_store_mesh* meshes = STP_ARENA_ARRAY(&c->arena, stp_store_mesh, all + 1);
    stp_coded_mesh* coded = STP_ARENA_ARRAY(&c->arena, stp_coded_mesh, all + 1);
    if (meshes == NULL || coded == NULL) {
        return false;
    }
    uint32_t count = 0;
    for (size_t i = 0; i < all; ++i) {
        if (!w->meshes[i].as_points) {
            assert(w->meshes[i].place == count && "parts refer to this place");
            meshes[count] = c->content.meshes[i];
            coded[count++] = w->state->coded[i];
        }
    }
    c->content.meshes = meshes;
    c->content.coded_meshes = coded;
    c->content.directory.mesh_count = count;
    return true;
}

// Points have the texels' colours, so textures are only needed with triangles.
static bool drop_textures(stp_build_content* c)
{
    stp_store_directory* d = &c->content.directory;
    stp_store_material* materials =
        STP_ARENA_ARRAY(&c->arena, stp_store_material, d->material_count + 1);
    if (materials == NULL) {
        return false;
    }
    memcpy(materials, d->materials, d->material_count * sizeof(*materials));
    for (uint32_t i = 0; i < d->material_count; ++i) {
        materials[i].base_color_texture.texture = STP_STORE_NONE;
        materials[i].metallic_roughness_texture.texture = STP_STORE_NONE;
        materials[i].emissive_texture.texture = STP_STORE_NONE;
        materials[i].normal_scale = 0.0f;
    }
    d->materials = materials;
    d->texture_count = 0;
    return true;
}

static stp_result fill_content(draft_work* w, stp_build_content* c)
{
    const stp_scene* scene = w->state->scene;
    uint32_t set_count = 0;
    stp_store_point_set* sets = STP_ARENA_ARRAY(&c->arena, stp_store_point_set,
                                                scene->mesh_count + scene->point_set_count + 1);
    if (sets == NULL) {
        return stp_fail_memory(w->context);
    }
    stp_result result = sample_meshes(w, &c->arena, sets, &set_count);
    result = result == STP_OK ? sample_points(w, &c->arena, sets, &set_count) : result;
    if (result != STP_OK) {
        return result;
    }
    c->content.point_sets = sets;
    c->content.directory.point_set_count = set_count;
    bool made = convert_parts(w, c) && convert_meshes(w, c) &&
                (c->content.directory.mesh_count > 0 || drop_textures(c));
    return made ? STP_OK : stp_fail_memory(w->context);
}

static stp_result make(draft_work* w, stp_build_content* content)
{
    const stp_draft_state* s = w->state;
    count_paths(w);
    if (!(w->visits <= visits_max)) {
        return STP_ERROR_LIMIT;
    }
    if (!choose_meshes(w)) {
        return stp_fail_memory(w->context);
    }
    stp_result result =
        stp_build_content_create(&w->seen, s->sets, s->set_count, s->set_of_node, NULL, content);
    if (result == STP_OK) {
        result = fill_content(w, content);
        if (result != STP_OK) {
            stp_build_content_destroy(content);
        }
    }
    return result;
}

stp_result stp_draft_content_create(stp_context* context, const stp_draft_state* state,
                                    stp_build_content* content)
{
    const stp_scene* scene = state->scene;
    draft_work w = {.context = context, .state = state, .seen = *scene};
    *content = (stp_build_content){0};
    if (scene->root == STP_NONE) {
        return STP_ERROR_LIMIT;
    }
    w.seen.context = context;   // its memory is not the build's
    w.seen.point_set_count = 0; // converted here, thinned out
    w.paths = STP_NEW_ZEROED(context, double, scene->node_count);
    w.areas = STP_NEW_ZEROED(context, double, scene->node_count);
    w.meshes = STP_NEW_ZEROED(context, exposure, scene->mesh_count + 1);
    w.point_sets = STP_NEW_ZEROED(context, exposure, scene->point_set_count + 1);
    bool room = w.paths != NULL && w.areas != NULL && w.meshes != NULL && w.point_sets != NULL;
    stp_result result = room ? make(&w, content) : stp_fail_memory(context);
    stp_free(context, w.paths);
    stp_free(context, w.areas);
    stp_free(context, w.meshes);
    stp_free(context, w.point_sets);
    return result;
}
