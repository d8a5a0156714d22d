// SPDX-License-Identifier: MIT
#include "lab/measure/ray_cast.h"

#include <assert.h>
#include <stdatomic.h>

#define ROUNDED 1e-6f ///< relative to the largest coordinate: margin of boxes

struct stp_caster {
    const stp_cast_mesh* meshes;
    const stp_cast_part* parts;
    uint32_t mesh_count, part_count;
    stp_box_tree* trees;  ///< one per mesh
    stp_affine* inverses; ///< one per part
    stp_box_tree top;     ///< over parts, relative to `center`
    stp_vec3d center;
    stp_boxd bounds;
};

/// Temporary state while a caster is created.
typedef struct maker {
    stp_context* context;
    stp_caster* caster;
    atomic_bool failed;
} maker;

static stp_vec3d vertex_of(const stp_cast_mesh* mesh, uint32_t triangle, uint32_t corner)
{
    assert(triangle < mesh->triangle_count && corner < 3);
    size_t at = 3 * (size_t)triangle + corner;
    const float* p = mesh->positions + 3 * (mesh->indices != NULL ? (size_t)mesh->indices[at] : at);
    return (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]};
}

static stp_box box_of_triangle(const stp_cast_mesh* mesh, uint32_t triangle)
{
    stp_box box = stp_box_empty();
    for (uint32_t k = 0; k < 3; ++k) {
        stp_box_add(&box, stp_to_float(vertex_of(mesh, triangle, k)));
    }
    return box;
}

static void make_trees(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    maker* m = user;
    for (size_t i = begin; i < end; ++i) {
        const stp_cast_mesh* mesh = &m->caster->meshes[i];
        stp_box* boxes = STP_NEW_ARRAY(m->context, stp_box, (size_t)mesh->triangle_count + 1);
        for (uint32_t k = 0; boxes != NULL && k < mesh->triangle_count; ++k) {
            boxes[k] = box_of_triangle(mesh, k);
        }
        if (boxes == NULL || stp_box_tree_create(m->context, boxes, mesh->triangle_count,
                                                 &m->caster->trees[i]) != STP_OK) {
            atomic_store_explicit(&m->failed, true, memory_order_relaxed);
        }
        stp_free(m->context, boxes);
        stp_progress_add(m->context, 1);
    }
}

/// @return false if the transform is singular
static bool invert(const stp_affine* a, stp_affine* out)
{
    double determinant = stp_affine_determinant(a);
    if (!(fabs(determinant) > 0.0) || !isfinite(1.0 / determinant)) {
        return false;
    }
    for (int r = 0; r < 3; ++r) {
        int r1 = (r + 1) % 3, r2 = (r + 2) % 3;
        for (int c = 0; c < 3; ++c) {
            int c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            out->m[r][c] =
                (a->m[c1][r1] * a->m[c2][r2] - a->m[c1][r2] * a->m[c2][r1]) / determinant;
        }
    }
    for (int r = 0; r < 3; ++r) {
        out->m[r][3] =
            -(out->m[r][0] * a->m[0][3] + out->m[r][1] * a->m[1][3] + out->m[r][2] * a->m[2][3]);
    }
    return true;
}

static stp_boxd box_of_part(const stp_caster* c, uint32_t part)
{
    assert(part < c->part_count && c->parts[part].mesh < c->mesh_count);
    const stp_box_tree* tree = &c->trees[c->parts[part].mesh];
    if (tree->count == 0) {
        return stp_boxd_empty();
    }
    const stp_box_node* root = &tree->nodes[0];
    stp_boxd box = {{(double)root->low[0], (double)root->low[1], (double)root->low[2]},
                    {(double)root->high[0], (double)root->high[1], (double)root->high[2]}};
    return stp_affine_box(&c->parts[part].transform, box);
}

static void join(stp_boxd* box, const stp_boxd* other)
{
    if (!stp_boxd_is_empty(*other)) {
        stp_boxd_add(box, other->min);
        stp_boxd_add(box, other->max);
    }
}

/// The box in floats, relative to the centre and rounded outwards.
static stp_box narrow(const stp_caster* c, const stp_boxd* box)
{
    stp_box out = {stp_to_float(stp_subd(box->min, c->center)),
                   stp_to_float(stp_subd(box->max, c->center))};
    stp_vec3d size = stp_subd(c->bounds.max, c->bounds.min);
    float margin = ROUNDED * (float)(size.x + size.y + size.z) + FLT_MIN;
    stp_vec3 wider = {margin, margin, margin};
    return (stp_box){stp_sub(out.min, wider), stp_add(out.max, wider)};
}

// Builds the tree over parts. Empty and singular parts become a point at the centre, which no ray
// hits.
static stp_result make_top(stp_context* context, stp_caster* c)
{
    c->bounds = stp_boxd_empty();
    for (uint32_t i = 0; i < c->part_count; ++i) {
        stp_boxd box = box_of_part(c, i);
        join(&c->bounds, &box);
    }
    if (!stp_boxd_is_empty(c->bounds)) {
        c->center = stp_scaled(stp_addd(c->bounds.min, c->bounds.max), 0.5);
    }
    c->inverses = STP_NEW_ARRAY(context, stp_affine, (size_t)c->part_count + 1);
    stp_box* boxes = STP_NEW_ARRAY(context, stp_box, (size_t)c->part_count + 1);
    bool good = c->inverses != NULL && boxes != NULL;
    for (uint32_t i = 0; good && i < c->part_count; ++i) {
        stp_boxd box = box_of_part(c, i);
        bool met = !stp_boxd_is_empty(box) && invert(&c->parts[i].transform, &c->inverses[i]);
        if (!met) {
            c->inverses[i] = (stp_affine){0};
            box = (stp_boxd){c->center, c->center};
        }
        boxes[i] = narrow(c, &box);
    }
    good = good && stp_box_tree_create(context, boxes, c->part_count, &c->top) == STP_OK;
    stp_free(context, boxes);
    return good ? STP_OK : stp_fail_memory(context);
}

static stp_result make(stp_context* context, stp_caster* c)
{
    c->trees = STP_NEW_ZEROED(context, stp_box_tree, (size_t)c->mesh_count + 1);
    if (c->trees == NULL) {
        return stp_fail_memory(context);
    }
    maker m = {.context = context, .caster = c};
    const stp_loop_report report = {.stage = "index", .unit = "meshes", .total = c->mesh_count};
    stp_result result =
        stp_parallel_for_reported(context, c->mesh_count, 1, make_trees, &m, &report);
    if (result != STP_OK) {
        return result;
    }
    return atomic_load_explicit(&m.failed, memory_order_relaxed) ? stp_fail_memory(context)
                                                                 : make_top(context, c);
}

stp_result stp_caster_create(stp_context* context, const stp_cast_mesh* meshes, uint32_t mesh_count,
                             const stp_cast_part* parts, uint32_t part_count, stp_caster** caster)
{
    *caster = NULL;
    bool many = part_count > INT32_MAX;
    for (uint32_t i = 0; i < mesh_count; ++i) {
        many = many || meshes[i].triangle_count > INT32_MAX;
    }
    if (many) {
        return stp_fail(context, STP_ERROR_LIMIT,
                        "rays: expected fewer than 2147483648 parts, and triangles of a mesh");
    }
    stp_caster* c = STP_NEW_ZEROED(context, stp_caster, 1);
    if (c == NULL) {
        return stp_fail_memory(context);
    }
    c->meshes = meshes;
    c->parts = parts;
    c->mesh_count = mesh_count;
    c->part_count = part_count;
    stp_result result = make(context, c);
    if (result != STP_OK) {
        stp_caster_destroy(context, c);
        return result;
    }
    *caster = c;
    return STP_OK;
}

void stp_caster_destroy(stp_context* context, stp_caster* caster)
{
    if (caster == NULL) {
        return;
    }
    for (uint32_t i = 0; caster->trees != NULL && i < caster->mesh_count; ++i) {
        stp_box_tree_destroy(context, &caster->trees[i]);
    }
    stp_box_tree_destroy(context, &caster->top);
    stp_free(context, caster->trees);
    stp_free(context, caster->inverses);
    stp_free(context, caster);
}

stp_boxd stp_caster_bounds(const stp_caster* caster)
{
    return caster->bounds;
}

void stp_caster_corners(const stp_caster* caster, uint32_t part, uint32_t triangle,
                        stp_vec3d corners[3])
{
    assert(part < caster->part_count);
    const stp_cast_part* p = &caster->parts[part];
    for (uint32_t k = 0; k < 3; ++k) {
        corners[k] =
            stp_affine_point(&p->transform, vertex_of(&caster->meshes[p->mesh], triangle, k));
    }
}

/// A ray being traced.
typedef struct cast {
    const stp_caster* caster;
    const stp_cast_ray* ray;
    bool (*keeps)(const stp_cast_hit* hit, void* user);
    void* user;
    stp_cast_hit* hit;
    double farthest;
    bool met;
    // within the current part
    const stp_cast_mesh* mesh;
    uint32_t part;
    double origin[3], shear[2], stretch; ///< align the ray with axis `along`
    int along, across, off;
} cast;

static stp_vec3d turn(const stp_affine* a, stp_vec3d v)
{
    const double(*m)[4] = a->m;
    return (stp_vec3d){m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z,
                       m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
                       m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
}

/// A corner in ray space: x and y beside the ray, z along it.
static stp_vec3d sheared(const cast* c, uint32_t triangle, uint32_t corner)
{
    stp_vec3d v = vertex_of(c->mesh, triangle, corner);
    const double p[3] = {v.x - c->origin[0], v.y - c->origin[1], v.z - c->origin[2]};
    double z = p[c->along];
    return (stp_vec3d){p[c->across] - c->shear[0] * z, p[c->off] - c->shear[1] * z, c->stretch * z};
}

static void intersect_triangle(uint32_t triangle, void* user)
{
    cast* c = user;
    stp_vec3d a = sheared(c, triangle, 0), b = sheared(c, triangle, 1);
    stp_vec3d d = sheared(c, triangle, 2);
    double u = b.x * d.y - b.y * d.x, v = d.x * a.y - d.y * a.x, w = a.x * b.y - a.y * b.x;
    double sum = u + v + w;
    if (((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) || sum == 0.0) {
        return;
    }
    double t = (u * a.z + v * b.z + w * d.z) / sum;
    if (!(t >= c->ray->nearest && t < c->farthest)) {
        return;
    }
    const stp_cast_hit hit = {t, c->part, triangle, {u / sum, v / sum, w / sum}};
    if (c->keeps == NULL || c->keeps(&hit, c->user)) {
        *c->hit = hit;
        c->farthest = t;
        c->met = true;
    }
}

static void intersect_part(uint32_t part, void* user)
{
    cast* c = user;
    const stp_affine* inverse = &c->caster->inverses[part];
    uint32_t mesh = c->caster->parts[part].mesh;
    stp_vec3d origin = stp_affine_point(inverse, c->ray->origin);
    stp_vec3d direction = turn(inverse, c->ray->direction);
    const double d[3] = {direction.x, direction.y, direction.z};
    double x = fabs(d[0]), y = fabs(d[1]), z = fabs(d[2]);
    int along = x > y && x > z ? 0 : y > z ? 1 : 2;
    if (!(fabs(d[along]) > 0.0)) { // the part is flattened
        return;
    }
    c->mesh = &c->caster->meshes[mesh];
    c->part = part;
    c->along = along;
    c->across = (along + 1) % 3;
    c->off = (along + 2) % 3;
    c->stretch = 1.0 / d[along];
    c->shear[0] = d[c->across] * c->stretch;
    c->shear[1] = d[c->off] * c->stretch;
    c->origin[0] = origin.x;
    c->origin[1] = origin.y;
    c->origin[2] = origin.z;
    stp_box_ray ray = stp_box_ray_make(origin, direction);
    stp_box_tree_walk(&c->caster->trees[mesh], &ray, c->ray->nearest, &c->farthest,
                      intersect_triangle, c);
}

bool stp_caster_intersect(const stp_caster* caster, const stp_cast_ray* ray,
                          bool (*keeps)(const stp_cast_hit* hit, void* user), void* user,
                          stp_cast_hit* hit)
{
    cast c = {.caster = caster,
              .ray = ray,
              .keeps = keeps,
              .user = user,
              .hit = hit,
              .farthest = ray->farthest};
    stp_box_ray box_ray = stp_box_ray_make(stp_subd(ray->origin, caster->center), ray->direction);
    stp_box_tree_walk(&caster->top, &box_ray, ray->nearest, &c.farthest, intersect_part, &c);
    return c.met;
}
