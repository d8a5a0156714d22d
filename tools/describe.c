// SPDX-License-Identifier: MIT
#include "describe.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// A node's sums over everything below it, each use counted.
typedef struct node_sums {
    uint64_t nodes, instances, surfels;
} node_sums;

// Both ways to ask for counts.
typedef struct source {
    const stp_store* store;
    const stp_store_content* content;
    const stp_store_directory* directory;
} source;

static uint64_t add(uint64_t a, uint64_t b)
{
    return a > UINT64_MAX - b ? UINT64_MAX : a + b;
}

static const stp_store_mesh* mesh_at(const source* s, uint32_t i)
{
    return s->store != NULL ? stp_store_describe_mesh(s->store, i) : &s->content->meshes[i];
}

static const stp_store_point_set* points_at(const source* s, uint32_t i)
{
    return s->store != NULL ? stp_store_describe_point_set(s->store, i)
                            : &s->content->point_sets[i];
}

static const stp_store_texture* texture_at(const source* s, uint32_t i)
{
    return s->store != NULL ? stp_store_describe_texture(s->store, i) : &s->content->textures[i];
}

static const stp_surfels* surfels_at(const source* s, uint32_t i)
{
    return s->store != NULL ? stp_store_describe_surfels(s->store, i) : &s->content->surfels[i];
}

static uint64_t surfel_bytes(const stp_surfels* s)
{
    uint64_t entries = 0;
    for (uint32_t i = 0; i < s->octave_count; ++i) {
        entries += s->octave_ends[i];
    }
    return (uint64_t)s->count * (6 + 2 + 1) +
           entries * (3 + 1); // positions, normals, materials; pyramids
}

static void sum_tables(const source* s, scene_figures* f)
{
    const stp_store_directory* d = s->directory;
    for (uint32_t i = 0; i < d->mesh_count; ++i) {
        const stp_store_mesh* m = mesh_at(s, i);
        uint64_t vertex = 12 + (m->normals != NULL ? 4u : 0u) +
                          (m->texcoords[0] != NULL ? 8u : 0u) +
                          (m->texcoords[1] != NULL ? 8u : 0u) + (m->colors != NULL ? 8u : 0u);
        f->unique_triangles += m->triangle_count;
        f->triangle_bytes += s->store != NULL
                                 ? stp_store_mesh_bytes(s->store, i)
                                 : m->vertex_count * vertex + m->triangle_count * (uint64_t)12;
    }
    for (uint32_t i = 0; i < d->point_set_count; ++i) {
        const stp_store_point_set* p = points_at(s, i);
        uint64_t point = 12 + (p->normals != NULL ? 4u : 0u) + (p->colors != NULL ? 4u : 0u);
        f->unique_points += p->point_count;
        f->point_bytes += p->point_count * point;
    }
    for (uint32_t i = 0; i < d->texture_count; ++i) {
        const stp_store_texture* t = texture_at(s, i);
        f->texture_bytes += (uint64_t)t->width * t->height * 4;
    }
    for (uint32_t i = 0; i < d->surfels_count; ++i) {
        f->unique_surfels += surfels_at(s, i)->count;
        f->splat_bytes += surfel_bytes(surfels_at(s, i));
    }
}

static void sum_nodes(const source* s, node_sums* sums)
{
    const stp_store_directory* d = s->directory;
    for (uint32_t i = 0; i < d->node_count; ++i) { // children come first
        const stp_store_node* node = &d->nodes[i];
        sums[i] = (node_sums){.nodes = 1, .instances = node->part_count};
        sums[i].surfels = node->surfels != STP_STORE_NONE ? surfels_at(s, node->surfels)->count : 0;
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            const node_sums* child = &sums[d->edges[node->first_edge + k].node];
            sums[i].nodes = add(sums[i].nodes, child->nodes);
            sums[i].instances = add(sums[i].instances, child->instances);
            sums[i].surfels = add(sums[i].surfels, child->surfels);
        }
    }
}

// One entry for each object without a parent; what is below counts for it.
static bool sum_parts(const source* s, const node_sums* sums, scene_figures* f)
{
    const stp_store_directory* d = s->directory;
    uint32_t* part_of = malloc(((size_t)d->object_count + 1) * sizeof(*part_of));
    f->parts = malloc(((size_t)d->object_count + 1) * sizeof(*f->parts));
    if (part_of == NULL || f->parts == NULL) {
        free(part_of);
        return false;
    }
    for (uint32_t i = 0; i < d->object_count; ++i) {
        const stp_store_object* object = &d->objects[i];
        if (object->parent != STP_STORE_NONE) {
            part_of[i] = part_of[object->parent];
            f->parts[part_of[i]].objects += 1;
            continue;
        }
        part_of[i] = (uint32_t)f->part_count;
        part_figures* part = &f->parts[f->part_count++];
        *part = (part_figures){.name = object->name, .objects = 1};
        if (object->node != STP_STORE_NONE) {
            part->instances = sums[object->node].instances;
            part->triangles = d->nodes[object->node].triangle_count;
            part->points = d->nodes[object->node].point_count;
        }
    }
    free(part_of);
    return true;
}

static bool describe(const source* s, scene_figures* f)
{
    const stp_store_directory* d = s->directory;
    f->directory = d;
    f->unique_nodes = d->node_count;
    f->objects = d->object_count;
    sum_tables(s, f);
    node_sums* sums = malloc(((size_t)d->node_count + 1) * sizeof(*sums));
    bool made = sums != NULL;
    if (made) {
        sum_nodes(s, sums);
        if (d->root != STP_STORE_NONE) {
            f->nodes = sums[d->root].nodes;
            f->instances = sums[d->root].instances;
            f->surfels = sums[d->root].surfels;
            f->triangles = d->nodes[d->root].triangle_count;
            f->points = d->nodes[d->root].point_count;
        }
        made = sum_parts(s, sums, f);
    }
    free(sums);
    return made;
}

bool describe_store(const stp_store* store, scene_figures* figures)
{
    *figures = (scene_figures){.file_bytes = stp_store_file_bytes(store),
                               .format_version = stp_store_format_version(store)};
    return describe(&(source){.store = store, .directory = stp_store_get_directory(store)},
                    figures);
}

bool describe_content(const stp_store_content* content, scene_figures* figures)
{
    *figures = (scene_figures){0};
    for (uint32_t i = 0; i < content->directory.source_count; ++i) {
        figures->file_bytes += content->directory.sources[i].bytes;
    }
    return describe(&(source){.content = content, .directory = &content->directory}, figures);
}

void describe_destroy(scene_figures* figures)
{
    free(figures->parts);
    *figures = (scene_figures){0};
}

const char* describe_unit(double metres)
{
    static const struct {
        double metres;
        const char* name;
    } units[] = {{1.0, "m"},
                 {0.001, "mm"},
                 {0.01, "cm"},
                 {0.0254, "in"},
                 {0.3048, "ft"},
                 {1000.0, "km"},
                 {1200.0 / 3937.0, "us-ft"}};
    for (size_t i = 0; i < sizeof(units) / sizeof(units[0]); ++i) {
        if (fabs(metres - units[i].metres) <= 1e-9 * units[i].metres) {
            return units[i].name;
        }
    }
    return NULL;
}
