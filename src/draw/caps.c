// SPDX-License-Identifier: MIT
#include "draw/caps.h"

#include "base/core/context.h"
#include "base/math/color.h"
#include "draw/caps_internal.h"
#include "draw/shaders/light_constants.h"
#include "draw/shading_setup.h"
#include "select/sections.h"
#include "store/file/instances.h"

#include <assert.h>
#include <string.h>

static const uint64_t visit_limit = UINT64_C(1) << 22;    // limit on visited node instances
static const float base_color[3] = {0.75f, 0.30f, 0.13f}; // linear; an unusual colour

struct stp_caps {
    stp_context* context;
    stp_store* store;
    stp_cap_solids* solids;
    // inputs of the outlines
    bool known;
    stp_sections sections;
    const stp_visibility* visibility;
    uint64_t version;
    stp_vec3d origin;
    stp_cap_outline outlines[STP_SECTION_PLANES];
    // the picture
    size_t capacity; ///< size of `winding`
    float* nearness;
    uint8_t* pixels; ///< RGBA
    int32_t* winding;
};

stp_result stp_caps_create(stp_context* context, stp_store* store, stp_caps** caps)
{
    stp_caps* c = STP_NEW_ZEROED(context, stp_caps, 1);
    *caps = NULL;
    if (c == NULL) {
        return stp_fail_memory(context);
    }
    c->context = context;
    c->store = store;
    stp_result result = stp_cap_solids_create(context, store, &c->solids);
    if (result != STP_OK) {
        stp_free(context, c);
        return result;
    }
    *caps = c;
    return STP_OK;
}

void stp_caps_destroy(stp_caps* c)
{
    if (c == NULL) {
        return;
    }
    for (int i = 0; i < STP_SECTION_PLANES; ++i) {
        stp_free(c->context, c->outlines[i].segments);
    }
    stp_free(c->context, c->nearness);
    stp_free(c->context, c->pixels);
    stp_free(c->context, c->winding);
    stp_cap_solids_destroy(c->solids);
    stp_free(c->context, c);
}

/// A mesh instance crossed by some planes.
typedef struct crossed_mesh {
    stp_caps* caps;
    stp_affine transform;
    uint32_t planes; ///< bits of the planes
    bool turned;     ///< triangles face inwards
    double rows[STP_SECTION_PLANES][4];
} crossed_mesh;

static bool crosses(void* user, const stp_box* box)
{
    const crossed_mesh* mesh = user;
    const float low[3] = {box->min.x, box->min.y, box->min.z};
    const float high[3] = {box->max.x, box->max.y, box->max.z};
    for (uint32_t bits = mesh->planes; bits != 0; bits &= bits - 1) {
        const double* row = mesh->rows[__builtin_ctz(bits)];
        double minimum = row[3], maximum = row[3];
        for (int k = 0; k < 3; ++k) {
            double a = row[k] * (double)low[k], b = row[k] * (double)high[k];
            minimum += fmin(a, b);
            maximum += fmax(a, b);
        }
        double slack = 1e-6 * (fabs(minimum) + fabs(maximum) + fabs(row[3]));
        if (minimum <= slack && maximum >= -slack) {
            return true;
        }
    }
    return false;
}

static int compare_corners(const float* a, const float* b)
{
    for (int k = 0; k < 3; ++k) {
        if (a[k] != b[k]) {
            return a[k] < b[k] ? -1 : 1;
        }
    }
    return 0;
}

/// Intersection of an edge with the plane: bit-identical for both triangles that share the edge.
static void cross_edge(const crossed_mesh* mesh, const float* a, double da, const float* b,
                       double db, float out[3])
{
    if (compare_corners(a, b) > 0) {
        const float* corner = a;
        double d = da;
        a = b;
        da = db;
        b = corner;
        db = d;
    }
    double t = da / (da - db);
    stp_vec3d p = {(double)a[0] + t * ((double)b[0] - (double)a[0]),
                   (double)a[1] + t * ((double)b[1] - (double)a[1]),
                   (double)a[2] + t * ((double)b[2] - (double)a[2])};
    p = stp_subd(stp_affine_point(&mesh->transform, p), mesh->caps->origin);
    out[0] = (float)p.x;
    out[1] = (float)p.y;
    out[2] = (float)p.z;
}

static double beyond(const double row[4], const float* p)
{
    return row[0] * (double)p[0] + row[1] * (double)p[1] + row[2] * (double)p[2] + row[3];
}

static stp_result cross_triangle(void* user, const float* const corners[3])
{
    crossed_mesh* mesh = user;
    stp_result result = STP_OK;
    for (uint32_t bits = mesh->planes; bits != 0 && result == STP_OK; bits &= bits - 1) {
        uint32_t number = (uint32_t)__builtin_ctz(bits);
        double d[3];
        float out[3], in[3]; // where the border leaves the kept side, and where it returns
        int found = 0;
        for (int k = 0; k < 3; ++k) {
            d[k] = beyond(mesh->rows[number], corners[k]);
        }
        for (int k = 0; k < 3; ++k) {
            int next = (k + 1) % 3;
            if ((d[k] > 0.0) != (d[next] > 0.0)) {
                cross_edge(mesh, corners[k], d[k], corners[next], d[next], d[k] > 0.0 ? in : out);
                found += 1;
            }
        }
        assert((found == 0 || found == 2) && "a plane leaves a triangle as often as it enters");
        if (found == 2) {
            const float *from = mesh->turned ? out : in, *to = mesh->turned ? in : out;
            result =
                stp_cap_outline_add(mesh->caps->context, &mesh->caps->outlines[number], from, to);
        }
    }
    return result;
}

static stp_result cross_part(stp_caps* caps, uint32_t mesh, const stp_affine* transform,
                             uint32_t planes)
{
    static const float none[3] = {0};
    int side;
    assert((planes & ~stp_sections_all(&caps->sections)) == 0 && "planes of the current sections");
    stp_result result = stp_cap_solids_side(caps->solids, mesh, &side);
    if (result != STP_OK || side == 0) {
        return result;
    }
    crossed_mesh crossed = {.caps = caps, .transform = *transform, .planes = planes};
    crossed.turned = (side < 0) != (stp_affine_determinant(transform) < 0.0);
    for (uint32_t bits = planes; bits != 0; bits &= bits - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(bits);
        stp_section_row(&caps->sections.planes[i], transform, none, crossed.rows[i]);
    }
    stp_cap_visitor visitor = {crosses, cross_triangle, &crossed};
    return stp_cap_visit(caps->store, mesh, &visitor);
}

/// A traversal of the shown nodes.
typedef struct cap_walk {
    stp_caps* caps;
    uint64_t visits; ///< remaining steps
    stp_result result;
} cap_walk;

static uint32_t state_below(const cap_walk* w, uint32_t state, uint32_t slot)
{
    return stp_show_of(state) == STP_SHOW_MIXED
               ? stp_visibility_below(w->caps->visibility, state, slot)
               : state;
}

static void walk_node(cap_walk* w, uint32_t node, const stp_affine* transform, uint32_t state,
                      uint32_t depth);

static void walk_below(cap_walk* w, const stp_store_node* n, const stp_affine* transform,
                       uint32_t state, uint32_t depth)
{
    const stp_store_directory* d = stp_store_get_directory(w->caps->store);
    for (uint32_t i = 0; i < n->part_count && w->result == STP_OK; ++i) {
        stp_store_part part = d->parts[n->first_part + i];
        if (part.kind != STP_STORE_PART_MESH ||
            state_below(w, state, n->edge_count + i) != STP_SHOW) {
            continue;
        }
        stp_instance spot = stp_instance_of_part(w->caps->store, part, transform);
        stp_boxd box = stp_affine_box(transform, spot.bounds);
        uint32_t planes = stp_sections_all(&w->caps->sections);
        if (stp_sections_test(&w->caps->sections, &box, 0.0, &planes) && planes != 0) {
            w->result = cross_part(w->caps, part.index, transform, planes);
        }
    }
    for (uint32_t i = 0; i < n->edge_count && w->result == STP_OK; ++i) {
        const stp_store_edge* edge = &d->edges[n->first_edge + i];
        stp_affine below = stp_affine_multiply(*transform, edge->transform);
        walk_node(w, edge->node, &below, state_below(w, state, i), depth + 1);
    }
}

static void walk_node(cap_walk* w, uint32_t node, const stp_affine* transform, uint32_t state,
                      uint32_t depth)
{
    const stp_store_node* n = &stp_store_get_directory(w->caps->store)->nodes[node];
    stp_boxd box = stp_affine_box(transform, n->bounds);
    uint32_t planes = stp_sections_all(&w->caps->sections);
    bool hidden = stp_show_of(state) == STP_SHOW_NOT || stp_show_of(state) == STP_SHOW_GHOST;
    if (hidden || w->visits == 0 || depth >= STP_INSTANCE_DEPTH || stp_boxd_is_empty(box) ||
        !stp_sections_test(&w->caps->sections, &box, 0.0, &planes) || planes == 0) {
        return;
    }
    w->visits -= 1;
    walk_below(w, n, transform, state, depth);
}

static bool are_known(const stp_caps* c, const stp_sections* sections,
                      const stp_visibility* visibility)
{
    bool same = c->known && c->sections.count == sections->count && c->visibility == visibility &&
                (visibility == NULL || c->version == stp_visibility_version(visibility));
    for (uint32_t i = 0; i < sections->count && same; ++i) {
        const stp_section_plane *a = &c->sections.planes[i], *b = &sections->planes[i];
        same = a->normal.x == b->normal.x && a->normal.y == b->normal.y &&
               a->normal.z == b->normal.z && a->distance == b->distance;
    }
    return same;
}

stp_result stp_caps_find(stp_caps* c, const stp_sections* sections,
                         const stp_visibility* visibility)
{
    const stp_store_directory* d = stp_store_get_directory(c->store);
    assert(sections->count <= STP_SECTION_PLANES);
    if (are_known(c, sections, visibility)) {
        return STP_OK;
    }
    c->known = false;
    c->sections = *sections;
    c->visibility = visibility;
    c->version = visibility != NULL ? stp_visibility_version(visibility) : 0;
    for (int i = 0; i < STP_SECTION_PLANES; ++i) {
        c->outlines[i].count = 0;
    }
    cap_walk walk = {.caps = c, .visits = visit_limit};
    if (d->root != STP_STORE_NONE && sections->count > 0) {
        stp_boxd box = d->nodes[d->root].bounds;
        stp_affine identity = stp_affine_identity();
        c->origin = stp_scaled(stp_addd(box.min, box.max), 0.5);
        uint32_t state = visibility != NULL ? stp_visibility_root(visibility) : STP_SHOW;
        walk_node(&walk, d->root, &identity, state, 0);
    }
    for (uint32_t i = 0; i < sections->count && walk.result == STP_OK; ++i) {
        walk.result = stp_cap_outline_close(c->context, &c->outlines[i]);
    }
    c->known = walk.result == STP_OK;
    return walk.result;
}

static stp_result make_room(stp_caps* c, size_t places)
{
    if (places <= c->capacity) {
        return STP_OK;
    }
    c->capacity = 0;
    stp_free(c->context, c->nearness);
    stp_free(c->context, c->pixels);
    stp_free(c->context, c->winding);
    c->nearness = STP_NEW_ARRAY(c->context, float, places);
    c->pixels = STP_NEW_ARRAY(c->context, uint8_t, 4 * places);
    c->winding = STP_NEW_ARRAY(c->context, int32_t, places);
    if (c->nearness == NULL || c->pixels == NULL || c->winding == NULL) {
        return stp_fail_memory(c->context);
    }
    c->capacity = places;
    return STP_OK;
}

/// Position in view axes, relative to the eye.
static stp_vec3d turn(const stp_view_frame* f, stp_vec3d p)
{
    return (stp_vec3d){stp_dotd(f->right, p), stp_dotd(f->down, p), stp_dotd(f->forward, p)};
}

/// End of a segment on the screen. In perspective, clips it to depth `minimum`.
static void project(const stp_view_frame* f, stp_vec3d p, stp_vec3d other, double minimum,
                    double out[2])
{
    if (!f->parallel && p.z < minimum) {
        p = stp_addd(p, stp_scaled(stp_subd(other, p), (minimum - p.z) / (other.z - p.z)));
        p.z = minimum;
    }
    double w = f->parallel ? 1.0 : p.z;
    out[0] = f->center_x + f->scale * p.x / w;
    out[1] = f->center_y + f->scale * p.y / w;
}

/// Records where a segment crosses each row: rows have one entry more than the picture has columns.
static void add_crossings(const stp_caps* c, const stp_view_frame* f, const stp_cap_segment* s,
                          int32_t* winding)
{
    const float* points[2] = {s->from, s->to};
    double minimum = f->parallel ? 0.0 : 1e-3 * f->near_distance, on[2][2];
    size_t stride = (size_t)f->width + 1;
    stp_vec3d ends[2];
    for (int i = 0; i < 2; ++i) {
        stp_vec3d p = {(double)points[i][0], (double)points[i][1], (double)points[i][2]};
        ends[i] = turn(f, stp_subd(stp_addd(p, c->origin), f->eye));
    }
    if (!f->parallel && ends[0].z < minimum && ends[1].z < minimum) {
        return;
    }
    project(f, ends[0], ends[1], minimum, on[0]);
    project(f, ends[1], ends[0], minimum, on[1]);
    int top = on[1][1] > on[0][1] ? 0 : 1;
    const double *a = on[top], *b = on[1 - top];
    double begin = fmax(ceil(a[1] - 0.5), 0.0), end = fmin(ceil(b[1] - 0.5), f->height);
    assert(begin >= 0.0 && end <= f->height && "rows of the picture");
    for (double row = begin; row < end; row += 1.0) {
        double x = a[0] + (b[0] - a[0]) * ((row + 0.5 - a[1]) / (b[1] - a[1]));
        double column = fmin(fmax(ceil(x - 0.5), 0.0), f->width);
        assert(column >= 0.0 && column <= f->width && "a row has an entry behind its last pixel");
        winding[(size_t)row * stride + (size_t)column] += top == 0 ? 1 : -1;
    }
}

/// A plane in view axes, relative to the eye: normal . p = distance.
typedef struct view_plane {
    stp_vec3d normal;
    double distance;
} view_plane;

/// Parameters of a fill.
typedef struct cap_fill {
    stp_caps* caps;
    const stp_view_frame* frame;
    const stp_cap_depth* depth;
    view_plane planes[STP_SECTION_PLANES];
    uint32_t plane;
    uint8_t color[4];
} cap_fill;

/// Fills a pixel that shows a point of the plane inside a solid, unless another plane cuts it away.
static bool fill_pixel(const cap_fill* fill, size_t x, size_t y)
{
    const stp_view_frame* f = fill->frame;
    const view_plane* p = &fill->planes[fill->plane];
    double u = ((double)x + 0.5 - f->center_x) / f->scale;
    double v = ((double)y + 0.5 - f->center_y) / f->scale;
    double across = p->normal.x * u + p->normal.y * v;
    double z =
        f->parallel ? (p->distance - across) / p->normal.z : p->distance / (across + p->normal.z);
    stp_vec3d at = f->parallel ? (stp_vec3d){u, v, z} : (stp_vec3d){u * z, v * z, z};
    if (!isfinite(z) || !(z > f->near_distance)) {
        return false;
    }
    for (uint32_t k = 0; k < fill->caps->sections.count; ++k) {
        if (k != fill->plane && stp_dotd(fill->planes[k].normal, at) > fill->planes[k].distance) {
            return false;
        }
    }
    size_t pixel = y * (size_t)f->width + x;
    const stp_cap_depth* d = fill->depth;
    float near = (float)(d->offset + (f->parallel ? d->scale * z : d->scale / z));
    if (!(near > fill->caps->nearness[pixel])) {
        return false;
    }
    fill->caps->nearness[pixel] = near;
    memcpy(fill->caps->pixels + 4 * pixel, fill->color, 4);
    return true;
}

/// Fills a row's pixels with a positive winding number. Counts the crossings on the side on which
/// the plane recedes from the eye, since no part of it is behind the eye there.
static bool fill_row(const cap_fill* fill, size_t y)
{
    const view_plane* p = &fill->planes[fill->plane];
    size_t width = (size_t)fill->frame->width;
    const int32_t* row = fill->caps->winding + y * (width + 1);
    bool from_left = fill->frame->parallel || p->normal.x / p->distance >= 0.0, any = false;
    int32_t around = 0;
    for (size_t i = 0; i < width; ++i) {
        size_t x = from_left ? i : width - 1 - i;
        around += from_left ? row[x] : -row[x + 1];
        if (around > 0) {
            any = fill_pixel(fill, x, y) || any;
        }
    }
    return any;
}

static bool fill_plane(const cap_fill* fill)
{
    stp_caps* c = fill->caps;
    const stp_cap_outline* o = &c->outlines[fill->plane];
    size_t height = (size_t)fill->frame->height, stride = (size_t)fill->frame->width + 1;
    bool any = false;
    assert(height * stride <= c->capacity);
    memset(c->winding, 0, height * stride * sizeof(*c->winding));
    for (size_t i = 0; i < o->count; ++i) {
        add_crossings(c, fill->frame, &o->segments[i], c->winding);
    }
    for (size_t y = 0; y < height; ++y) {
        any = fill_row(fill, y) || any;
    }
    return any;
}

/// Lights the cap as a rough surface in the plane, seen from the picture's centre.
static void find_color(const stp_view_frame* f, bool headlight, stp_vec3d normal, uint8_t out[4])
{
    static const float sky[3] = {LIGHT_SKY_R, LIGHT_SKY_G, LIGHT_SKY_B};
    static const float ground[3] = {LIGHT_GROUND_R, LIGHT_GROUND_G, LIGHT_GROUND_B};
    static const float key[3] = {LIGHT_KEY_R, LIGHT_KEY_G, LIGHT_KEY_B};
    stp_lighting light = stp_lighting_make(f, headlight);
    stp_vec3 n = stp_to_float(stp_normalized(normal));
    float lambert = stp_max(stp_dot(n, light.key), 0.0f);
    float height = 0.5f + 0.5f * stp_dot(n, light.up);
    float facing = -stp_dot(n, stp_to_float(f->forward));
    for (int k = 0; k < 3; ++k) {
        float diffuse = ground[k] + (sky[k] - ground[k]) * height + key[k] * lambert +
                        LIGHT_FILL * facing * facing;
        out[k] = stp_linear_to_srgb8(base_color[k] * diffuse);
    }
    out[3] = 255;
}

stp_result stp_caps_fill(stp_caps* c, const stp_view_frame* frame, bool headlight,
                         const stp_cap_depth* depth, stp_cap_picture* picture)
{
    size_t width = (size_t)frame->width, height = (size_t)frame->height;
    cap_fill fill = {.caps = c, .frame = frame, .depth = depth};
    assert(c->known && "outlines are found first");
    *picture = (stp_cap_picture){0};
    bool any = false;
    for (uint32_t i = 0; i < c->sections.count; ++i) {
        const stp_section_plane* s = &c->sections.planes[i];
        fill.planes[i].normal = turn(frame, s->normal);
        fill.planes[i].distance = s->distance - stp_dotd(s->normal, frame->eye);
        any = any || c->outlines[i].count > 0;
    }
    if (!any) {
        return STP_OK;
    }
    stp_result result = make_room(c, (width + 1) * height);
    if (result != STP_OK) {
        return result;
    }
    memset(c->nearness, 0, width * height * sizeof(*c->nearness));
    for (uint32_t i = 0; i < c->sections.count; ++i) {
        const view_plane* p = &fill.planes[i];
        bool seen = frame->parallel ? p->normal.z < 0.0 : p->distance < 0.0; // facing the cut side
        fill.plane = i;
        if (seen && c->outlines[i].count > 0) {
            find_color(frame, headlight, c->sections.planes[i].normal, fill.color);
            picture->any = fill_plane(&fill) || picture->any;
        }
    }
    picture->nearness = c->nearness;
    picture->pixels = c->pixels;
    return STP_OK;
}
