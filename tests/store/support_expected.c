// SPDX-License-Identifier: MIT
#include "support_expected.h"

#include "base/splats/light_normal.h"

#include <stdio.h>
#include <zlib.h>

static json_int_t crc(const void* bytes, size_t size)
{
    return bytes == NULL || size == 0 ? 0 : (json_int_t)crc32_z(0, bytes, size);
}

// NULL becomes null.
static json_t* text(const char* value)
{
    return value != NULL ? json_string(value) : json_null();
}

static json_t* triple(stp_vec3d v)
{
    return json_pack("[fff]", v.x, v.y, v.z);
}

static json_t* expected_nodes(const stp_store_directory* d)
{
    json_t* list = json_array();
    for (uint32_t i = 0; i < d->node_count; ++i) {
        const stp_store_node* n = &d->nodes[i];
        json_array_append_new(
            list,
            json_pack("{s:I s:I s:I s:I s:I s:I s:o s:o}", "first_edge", (json_int_t)n->first_edge,
                      "edge_count", (json_int_t)n->edge_count, "first_part",
                      (json_int_t)n->first_part, "part_count", (json_int_t)n->part_count, "surfels",
                      (json_int_t)n->set, "flags", (json_int_t)n->flags, "bounds_min",
                      triple(n->bounds.min), "bounds_max", triple(n->bounds.max)));
    }
    return list;
}

static json_t* expected_transform(const stp_affine* t)
{
    json_t* list = json_array();
    for (int i = 0; i < 12; ++i) {
        json_array_append_new(list, json_real(t->m[i / 4][i % 4]));
    }
    return list;
}

static json_t* expected_edges(const stp_store_directory* d)
{
    json_t* list = json_array();
    for (uint32_t i = 0; i < d->edge_count; ++i) {
        json_array_append_new(list,
                              json_pack("{s:I s:o}", "node", (json_int_t)d->edges[i].node,
                                        "transform", expected_transform(&d->edges[i].transform)));
    }
    return list;
}

static json_t* expected_objects(const stp_store_directory* d)
{
    json_t* list = json_array();
    for (uint32_t i = 0; i < d->object_count; ++i) {
        const stp_store_object* o = &d->objects[i];
        json_array_append_new(list, json_pack("{s:o s:o s:I s:I s:o}", "name", text(o->name), "id",
                                              text(o->id), "parent", (json_int_t)o->parent, "node",
                                              (json_int_t)o->node, "transform",
                                              expected_transform(&o->transform)));
    }
    return list;
}

static json_t* expected_materials(const stp_store_directory* d)
{
    json_t* list = json_array();
    for (uint32_t i = 0; i < d->material_count; ++i) {
        const stp_store_material* m = &d->materials[i];
        const float* c = m->base_color;
        json_array_append_new(
            list,
            json_pack("{s:o s:I s:I s:f s:[ffff] s:f s:f s:[fff]}", "name", text(m->name), "flags",
                      (json_int_t)m->flags, "alpha", (json_int_t)m->alpha, "alpha_cutoff",
                      (double)m->alpha_cutoff, "base_color", (double)c[0], (double)c[1],
                      (double)c[2], (double)c[3], "metallic", (double)m->metallic, "roughness",
                      (double)m->roughness, "emissive", (double)m->emissive[0],
                      (double)m->emissive[1], (double)m->emissive[2]));
    }
    return list;
}

typedef struct corner_sums {
    json_int_t corners, normals, texcoords[2], colors;
} corner_sums;

static json_int_t add_values(json_int_t sum, const stp_cluster* cluster, int channel, int count,
                             uint32_t vertex)
{
    for (int k = 0; k < count; ++k) {
        int32_t value = stp_cluster_value(&cluster->runs[channel + k], vertex);
        sum = (json_int_t)crc32_z((uLong)sum, (const void*)&value, sizeof(value));
    }
    return sum;
}

// Checksums over the numbers of all triangle corners.
static corner_sums sum_corners(const stp_clusters* clusters)
{
    corner_sums sums = {0};
    for (uint32_t i = 0; i < clusters->cluster_count; ++i) {
        stp_cluster c;
        stp_clusters_get(clusters, i, &c);
        for (uint32_t k = 0; k < 3 * c.triangle_count; ++k) {
            uint32_t lit = c.smooth_count + c.face_count, t = k / 3, corners[3];
            stp_cluster_corners(&c, t, corners);
            uint32_t v = corners[k % 3];
            sums.corners = add_values(sums.corners, &c, STP_CLUSTER_X, 3, v);
            if (t < lit) {
                uint32_t from = t < c.smooth_count ? v : corners[0];
                sums.normals = add_values(sums.normals, &c, STP_CLUSTER_NORMAL_U, 2, from);
            }
            for (int set = 0; set < 2; ++set) {
                bool has = (clusters->present >> (2 + set) & 1) != 0;
                sums.texcoords[set] = add_values(sums.texcoords[set], &c,
                                                 STP_CLUSTER_TEXCOORDS + 2 * set, has ? 2 : 0, v);
            }
            bool colored = (clusters->present >> 1 & 1) != 0;
            sums.colors = add_values(sums.colors, &c, STP_CLUSTER_COLORS, colored ? 4 : 0, v);
        }
    }
    return sums;
}

static json_t* expected_clusters(const stp_store_mesh* mesh, const stp_coded_mesh* coded)
{
    stp_clusters clusters;
    if (stp_clusters_open(coded->bytes, coded->size, &clusters) != NULL) {
        return NULL;
    }
    corner_sums sums = sum_corners(&clusters);
    json_t* columns = json_pack("{s:I s:I s:I s:I s:I}", "corners", sums.corners, "normals",
                                sums.normals, "texcoords_0", sums.texcoords[0], "texcoords_1",
                                sums.texcoords[1], "colors", sums.colors);
    return json_pack("{s:o s:I s:I s:I s:I s:f s:o}", "name", text(mesh->name), "vertex_count",
                     (json_int_t)coded->vertex_count, "triangle_count",
                     (json_int_t)coded->triangle_count, "material", (json_int_t)mesh->material,
                     "cluster_count", (json_int_t)coded->cluster_count, "step",
                     (double)clusters.step, "columns", columns);
}

static json_t* expected_meshes(const stp_store_content* content)
{
    json_t* list = json_array();
    for (uint32_t i = 0; i < content->directory.mesh_count; ++i) {
        const stp_store_mesh* m = &content->meshes[i];
        if (content->coded_meshes != NULL && content->coded_meshes[i].bytes != NULL) {
            json_array_append_new(list, expected_clusters(m, &content->coded_meshes[i]));
            continue;
        }
        size_t n = m->vertex_count;
        json_t* columns =
            json_pack("{s:I s:I s:I s:I s:I s:I}", "positions", crc(m->positions, 12 * n),
                      "normals", crc(m->normals, 4 * n), "texcoords_0", crc(m->texcoords[0], 8 * n),
                      "texcoords_1", crc(m->texcoords[1], 8 * n), "colors", crc(m->colors, 8 * n),
                      "indices", crc(m->indices, 12 * (size_t)m->triangle_count));
        json_array_append_new(list, json_pack("{s:o s:I s:I s:I s:o}", "name", text(m->name),
                                              "vertex_count", (json_int_t)n, "triangle_count",
                                              (json_int_t)m->triangle_count, "material",
                                              (json_int_t)m->material, "columns", columns));
    }
    return list;
}

static json_t* expected_points(const stp_store_content* content)
{
    json_t* list = json_array();
    for (uint32_t i = 0; i < content->directory.point_set_count; ++i) {
        const stp_store_point_set* p = &content->point_sets[i];
        size_t n = p->point_count;
        json_array_append_new(
            list, json_pack("{s:o s:I s:I s:{s:I s:I s:I}}", "name", text(p->name), "point_count",
                            (json_int_t)n, "material", (json_int_t)p->material, "columns",
                            "positions", crc(p->positions, 12 * n), "normals",
                            crc(p->normals, 4 * n), "colors", crc(p->colors, 4 * n)));
    }
    return list;
}

static json_t* expected_textures(const stp_store_content* content)
{
    json_t* list = json_array();
    for (uint32_t i = 0; i < content->directory.texture_count; ++i) {
        const stp_store_texture* t = &content->textures[i];
        json_array_append_new(
            list, json_pack("{s:I s:I s:I s:I s:I s:{s:I}}", "width", (json_int_t)t->width,
                            "height", (json_int_t)t->height, "wrap_u", (json_int_t)t->wrap_u,
                            "wrap_v", (json_int_t)t->wrap_v, "nearest", (json_int_t)t->nearest,
                            "columns", t->encoded != NULL ? "picture" : "texels",
                            t->encoded != NULL ? crc(t->encoded, t->encoded_size)
                                               : crc(t->texels, 4 * (size_t)t->width * t->height)));
    }
    return list;
}

static json_t* expected_methods(const stp_store_directory* d)
{
    const stp_store_method blue = {
        .name = "blue", .id = STP_METHOD_BLUE, .set_count = d->set_count};
    json_t* list = json_array();
    for (uint32_t i = 0; i == 0 || i < d->method_count; ++i) {
        const stp_store_method* m = d->method_count != 0 ? &d->methods[i] : &blue;
        json_t* method =
            json_pack("{s:s s:I s:I s:I s:I}", "name", m->name, "id", (json_int_t)m->id, "columns",
                      (json_int_t)m->columns, "first_set", (json_int_t)m->first_set, "set_count",
                      (json_int_t)m->set_count);
        json_t* nodes = json_array();
        for (uint32_t set = m->first_set; m->sets != NULL && set < m->first_set + m->set_count;
             ++set) {
            for (uint32_t k = 0; k < d->node_count; ++k) {
                if (m->sets[k] == set) {
                    json_array_append_new(nodes, json_integer(k));
                }
            }
        }
        if (m->sets != NULL) {
            json_object_set(method, "nodes", nodes);
        }
        json_decref(nodes);
        json_array_append_new(list, method);
    }
    return list;
}

static json_t* expected_splat_sets(const stp_store_content* content)
{
    json_t* list = json_array();
    for (uint32_t i = 0; i < content->directory.set_count; ++i) {
        const stp_splats* s = &content->sets[i];
        json_t* ends = json_array();
        json_t* breakpoints = json_array();
        size_t n = s->count, entries = 0;
        for (uint32_t k = 0; k < s->octave_count; ++k) {
            bool flat = (s->columns & STP_SPLATS_FLAT_COLORS) != 0;
            entries = flat ? s->octave_ends[k] : entries + s->octave_ends[k];
            json_array_append_new(ends, json_integer(s->octave_ends[k]));
        }
        for (uint32_t k = 0; k < s->table.size; ++k) {
            json_array_append_new(breakpoints, json_pack("[If]", (json_int_t)s->table.count[k],
                                                         (double)s->table.radius[k]));
        }
        json_t* columns = json_object();
        if (n != 0) { // a set without octaves has no blocks, hence no columns
            json_object_set_new(columns, "positions", json_integer(crc(s->positions, 6 * n)));
            json_object_set_new(columns, "normals", json_integer(crc(s->normals, 2 * n)));
            json_object_set_new(columns, "materials", json_integer(crc(s->materials, n)));
            json_object_set_new(columns, "colors", json_integer(crc(s->colors, 3 * entries)));
            json_object_set_new(columns, "coverages", json_integer(crc(s->coverages, entries)));
            if (s->shapes != NULL) {
                json_object_set_new(columns, "shapes", json_integer(crc(s->shapes, 4 * n)));
            }
            if (s->ranges != NULL) {
                json_object_set_new(columns, "ranges", json_integer(crc(s->ranges, 4 * n)));
            }
            if (s->errors != NULL) {
                json_object_set_new(columns, "errors", json_integer(crc(s->errors, 4 * n)));
            }
            size_t lights = (size_t)stp_light_normals_begin(s, s->octave_count);
            if (lights > 0) {
                json_object_set_new(columns, "turns", json_integer(crc(s->turns, 2 * lights)));
                json_object_set_new(columns, "spreads", json_integer(crc(s->spreads, lights)));
            }
        }
        json_t* set = json_pack("{s:I s:f s:o s:o s:o s:I s:f s:f}", "count", (json_int_t)n, "step",
                                (double)s->step, "origin", triple(stp_to_double(s->origin)),
                                "octave_ends", ends, "breakpoints", breakpoints, "paper_count",
                                (json_int_t)s->paper_count, "paper_radius", (double)s->paper_radius,
                                "candidate_radius", (double)s->candidate_radius);
        if (n != 0) {
            json_object_set(set, "columns", columns);
        }
        json_decref(columns);
        json_array_append_new(list, set);
    }
    return list;
}

static json_t* expected_views(const stp_store_directory* d)
{
    json_t* list = json_array();
    for (uint32_t i = 0; i < d->view_count; ++i) {
        const stp_store_view* v = &d->views[i];
        json_array_append_new(list, json_pack("{s:o s:o s:o s:o s:f}", "name", text(v->name), "eye",
                                              triple(v->eye), "target", triple(v->target), "up",
                                              triple(v->up), "fov_degrees", v->fov_degrees));
    }
    return list;
}

static json_t* expected_sources(const stp_store_directory* d)
{
    json_t* list = json_array();
    for (uint32_t i = 0; i < d->source_count; ++i) {
        json_array_append_new(list, json_pack("{s:o s:o}", "path", text(d->sources[i].path),
                                              "format", text(d->sources[i].format)));
    }
    return list;
}

static json_t* expected_figures(const stp_store_figures* figures)
{
    json_t* json = json_object();
#define X(name) (void)json_object_set_new(json, #name, json_integer((json_int_t)figures->name));
    STP_STORE_FIGURES(X)
#undef X
    return json;
}

static json_t* expected_scene_parts(const stp_store_summary* summary)
{
    json_t* list = json_array();
    for (uint32_t i = 0; i < summary->part_count; ++i) {
        json_t* part = expected_figures(&summary->parts[i].figures);
        (void)json_object_set_new(part, "name", text(summary->parts[i].name));
        (void)json_object_set_new(part, "object", json_integer(summary->parts[i].object));
        (void)json_array_append_new(list, part);
    }
    return list;
}

static json_t* expected_keys(const stp_store_content* content)
{
    json_t* list = json_array();
    uint32_t sets = content->directory.set_count;
    uint32_t count = sets + content->directory.mesh_count;
    bool keyed = content->set_keys != NULL || content->mesh_keys != NULL;
    for (uint32_t i = 0; keyed && i < count; ++i) {
        const stp_hash* keys = i < sets ? content->set_keys : content->mesh_keys;
        stp_hash key = keys != NULL ? keys[i < sets ? i : i - sets] : (stp_hash){0};
        char digits[33];
        snprintf(digits, sizeof(digits), "%016llx%016llx", (unsigned long long)key.high,
                 (unsigned long long)key.low);
        (void)json_array_append_new(list, json_string(digits));
    }
    return list;
}

// Of files with levels.
static void add_levels(json_t* json, const stp_store_directory* d)
{
    json_t* levels = json_array();
    json_t* clusters = json_array();
    json_t* groups = json_array();
    for (uint32_t i = 0; i < d->level_count; ++i) {
        json_array_append_new(levels,
                              json_pack("{s:I s:I s:I}", "node", (json_int_t)d->levels[i].node,
                                        "flags", (json_int_t)d->levels[i].flags, "mesh",
                                        (json_int_t)stp_store_first_level_mesh(d) + i));
    }
    for (uint32_t i = 0; i < d->level_cluster_count; ++i) {
        const stp_store_level_cluster* c = &d->level_clusters[i];
        json_array_append_new(
            clusters, json_pack("{s:I s:I s:I}", "made_by", (json_int_t)c->made_by, "used_by",
                                (json_int_t)c->used_by, "one_sided", (json_int_t)c->one_sided));
    }
    for (uint32_t i = 0; i < d->level_group_count; ++i) {
        const stp_store_level_group* g = &d->level_groups[i];
        json_array_append_new(groups,
                              json_pack("{s:[fff] s:f s:f}", "center", (double)g->center[0],
                                        (double)g->center[1], (double)g->center[2], "radius",
                                        (double)g->radius, "error", (double)g->error));
    }
    (void)json_object_set_new(json, "levels", levels);
    (void)json_object_set_new(json, "level_clusters", clusters);
    (void)json_object_set_new(json, "level_groups", groups);
}

static int expected_minor(const stp_store_content* content)
{
    int minor = content->directory.level_count != 0 ? 3 : 2;
    for (uint32_t i = 0; i < content->directory.set_count; ++i) {
        minor = content->sets[i].light_octaves != 0 ? 6 : minor;
    }
    return minor;
}

json_t* sample_expected_json(const stp_store_content* content, const stp_store_summary* summary)
{
    json_t* head = expected_figures(&summary->figures);
    (void)json_object_set_new(head, "bounds_min", triple(summary->bounds.min));
    (void)json_object_set_new(head, "bounds_max", triple(summary->bounds.max));
    (void)json_object_set_new(head, "mesh_count", json_integer(summary->mesh_count));
    const stp_store_directory* d = &content->directory;
    char up[2] = {d->up, '\0'};
    json_t* json = json_pack(
        "{s:[ii] s:I s:f s:s s:o s:o s:o s:o s:o s:o s:o s:o s:o s:o s:o s:[o] s:o s:o s:o}",
        "version", 1, expected_minor(content), "root", (json_int_t)d->root, "unit_metres",
        d->unit_metres, "up", up, "build", text(d->build_json), "nodes", expected_nodes(d), "edges",
        expected_edges(d), "objects", expected_objects(d), "materials", expected_materials(d),
        "meshes", expected_meshes(content), "point_sets", expected_points(content), "textures",
        expected_textures(content), "surfels", expected_splat_sets(content), "views",
        expected_views(d), "sources", expected_sources(d), "summary", head, "scene_parts",
        expected_scene_parts(summary), "keys", expected_keys(content), "methods",
        expected_methods(d));
    if (json != NULL && d->level_count != 0) {
        add_levels(json, d);
    }
    return json;
}
