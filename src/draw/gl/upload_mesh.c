// SPDX-License-Identifier: MIT
// Uploads meshes to the pool: decoded clusters, each with a header.
#include "draw/gl/upload.h"
#include "store/bytes/format.h"

#include <assert.h>

typedef struct mesh_source {
    const stp_clusters* clusters; ///< NULL: mesh of columns
    const stp_store_mesh* mesh;
    bool reads[2]; ///< texture coordinates that the material uses
    bool colors;
} mesh_source;

/// Attributes of a cluster, and its first triangle in the mesh.
typedef struct cluster_shape {
    uint32_t first_triangle, triangles, vertices, normals;
    stp_box box;
} cluster_shape;

static cluster_shape shape_of(const mesh_source* source, uint32_t index, stp_cluster* cluster)
{
    if (source->clusters != NULL) {
        stp_clusters_get(source->clusters, index, cluster);
        return (cluster_shape){.first_triangle = cluster->first_triangle,
                               .triangles = cluster->triangle_count,
                               .vertices = cluster->vertex_count,
                               .normals = cluster->normal_count,
                               .box = stp_clusters_bounds(source->clusters, index)};
    }
    uint32_t first = index * UPLOAD_CLUSTER_TRIANGLES, left = source->mesh->triangle_count - first;
    uint32_t count = left < UPLOAD_CLUSTER_TRIANGLES ? left : UPLOAD_CLUSTER_TRIANGLES;
    return (cluster_shape){.first_triangle = first,
                           .triangles = count,
                           .vertices = 3 * count,
                           .normals = source->mesh->normals != NULL ? 3 * count : 0,
                           .box = source->mesh->bounds};
}

static uint64_t words_of(const mesh_source* source, const cluster_shape* shape)
{
    uint64_t vertices = shape->vertices;
    uint64_t sets = (source->reads[0] ? 2u : 0u) + (source->reads[1] ? 2u : 0u);
    return shape->triangles + (3 + sets + (source->colors ? 2u : 0u)) * vertices + shape->normals;
}

static void write_header(const mesh_source* source, const cluster_shape* shape, uint64_t place,
                         stp_gl_writer* w)
{
    uint32_t at = (uint32_t)place, vertices = shape->vertices;
    stp_gl_write(w, shape->first_triangle);
    stp_gl_write(w, shape->triangles);
    stp_gl_write(w, at);
    at += shape->triangles;
    stp_gl_write(w, at);
    at += 3 * vertices;
    stp_gl_write(w, at);
    at += shape->normals;
    for (int set = 0; set < 2; ++set) {
        stp_gl_write(w, source->reads[set] ? at : 0);
        at += source->reads[set] ? 2 * vertices : 0;
    }
    stp_gl_write(w, source->colors ? at : 0);
    const float box[6] = {shape->box.min.x, shape->box.min.y, shape->box.min.z,
                          shape->box.max.x, shape->box.max.y, shape->box.max.z};
    for (int k = 0; k < 6; ++k) {
        stp_gl_write_float(w, box[k]);
    }
    stp_gl_write(w, vertices);
    stp_gl_write(w, 0);
}

static uint32_t pack_normal(float u, float v)
{
    assert(fabsf(u) < 32768.0f && fabsf(v) < 32768.0f && "16 bits each");
    return (uint32_t)(uint16_t)(int16_t)u | (uint32_t)(uint16_t)(int16_t)v << 16;
}

static uint32_t pack_pair(float low, float high)
{
    return (uint32_t)(low * 65535.0f + 0.5f) | (uint32_t)(high * 65535.0f + 0.5f) << 16;
}

static void write_normals(const stp_cluster* cluster, stp_gl_writer* w)
{
    const float scale = 32767.0f / (float)STP_CLUSTER_NORMAL_LIMIT;
    for (uint32_t i = 0; i < cluster->normal_count; ++i) {
        float u = (float)stp_cluster_value(&cluster->runs[STP_CLUSTER_NORMAL_U], i) * scale;
        float v = (float)stp_cluster_value(&cluster->runs[STP_CLUSTER_NORMAL_V], i) * scale;
        u = stp_clamp(u, -32767.0f, 32767.0f);
        v = stp_clamp(v, -32767.0f, 32767.0f);
        stp_gl_write(w, pack_normal(u + (u < 0.0f ? -0.5f : 0.5f), v + (v < 0.0f ? -0.5f : 0.5f)));
    }
}

static void write_cluster(const mesh_source* source, const stp_cluster* cluster, stp_gl_writer* w)
{
    float positions[3 * STP_CLUSTER_VERTICES];
    uint32_t indices[3 * STP_CLUSTER_TRIANGLES];
    stp_cluster_indices(cluster, 0, indices);
    for (uint32_t i = 0; i < cluster->triangle_count; ++i) {
        uint32_t faces = cluster->smooth_count + cluster->face_count;
        uint32_t lighting = i < cluster->smooth_count ? TRIANGLE_SMOOTH
                            : i < faces               ? TRIANGLE_FACE
                                                      : TRIANGLE_PLAIN;
        stp_gl_write(w, indices[3 * i] | indices[3 * i + 1] << 10 | indices[3 * i + 2] << 20 |
                            lighting << 30);
    }
    stp_cluster_positions(source->clusters, cluster, positions);
    for (uint32_t i = 0; i < 3 * cluster->vertex_count; ++i) {
        stp_gl_write_float(w, positions[i]);
    }
    write_normals(cluster, w);
    for (uint32_t set = 0; set < 2; ++set) {
        for (uint32_t i = 0; i < cluster->vertex_count && source->reads[set]; ++i) {
            stp_vec2 uv = stp_cluster_texcoord(source->clusters, cluster, set, i);
            stp_gl_write_float(w, uv.x);
            stp_gl_write_float(w, uv.y);
        }
    }
    for (uint32_t i = 0; i < cluster->vertex_count && source->colors; ++i) {
        float color[4];
        stp_cluster_color(cluster, i, color);
        for (int k = 0; k < 4; ++k) { // may be any number in a forged file
            color[k] = stp_clamp(color[k], 0.0f, 1.0f);
        }
        stp_gl_write(w, pack_pair(color[0], color[1]));
        stp_gl_write(w, pack_pair(color[2], color[3]));
    }
}

/// Triangles of columns: corners are not shared.
static void write_columns(const mesh_source* source, const cluster_shape* shape, stp_gl_writer* w)
{
    assert(shape->vertices == 3 * shape->triangles && shape->vertices <= 1024 &&
           "10 bits a corner");
    const stp_store_mesh* mesh = source->mesh;
    size_t first = 3 * (size_t)shape->first_triangle;
    uint32_t lighting = mesh->normals != NULL ? TRIANGLE_SMOOTH : TRIANGLE_PLAIN;
    for (uint32_t i = 0; i < shape->triangles; ++i) {
        stp_gl_write(w, 3 * i | (3 * i + 1) << 10 | (3 * i + 2) << 20 | lighting << 30);
    }
    for (uint32_t i = 0; i < shape->vertices; ++i) {
        for (size_t c = 0; c < 3; ++c) {
            stp_gl_write_float(
                w, mesh->positions[3 * (size_t)stp_store_mesh_corner(mesh, first + i) + c]);
        }
    }
    for (uint32_t i = 0; i < shape->normals; ++i) {
        uint32_t word;
        memcpy(&word, mesh->normals + 2 * (size_t)stp_store_mesh_corner(mesh, first + i),
               sizeof(word));
        stp_gl_write(w, word);
    }
    for (int set = 0; set < 2; ++set) {
        for (uint32_t i = 0; i < shape->vertices && source->reads[set]; ++i) {
            stp_gl_write_float(
                w, mesh->texcoords[set][2 * (size_t)stp_store_mesh_corner(mesh, first + i)]);
            stp_gl_write_float(
                w, mesh->texcoords[set][2 * (size_t)stp_store_mesh_corner(mesh, first + i) + 1]);
        }
    }
    for (uint32_t i = 0; i < shape->vertices && source->colors; ++i) {
        uint32_t words[2];
        memcpy(words, mesh->colors + 4 * (size_t)stp_store_mesh_corner(mesh, first + i),
               sizeof(words));
        stp_gl_write(w, words[0]);
        stp_gl_write(w, words[1]);
    }
}

static void write_mesh(const mesh_source* source, uint32_t count, stp_gl_writer* w)
{
    stp_cluster cluster;
    uint64_t place = (uint64_t)count * CLUSTER_WORDS;
    for (uint32_t i = 0; i < count; ++i) {
        cluster_shape shape = shape_of(source, i, &cluster);
        write_header(source, &shape, place, w);
        place += words_of(source, &shape);
    }
    for (uint32_t i = 0; i < count; ++i) {
        cluster_shape shape = shape_of(source, i, &cluster);
        if (source->clusters != NULL) {
            write_cluster(source, &cluster, w);
        } else {
            write_columns(source, &shape, w);
        }
    }
}

/// Texture coordinates that the material's textures read.
static void choose_texcoords(const stp_gl_renderer* r, uint32_t material, bool reads[2])
{
    const stp_store_material* m = &r->directory->materials[material];
    const stp_store_texture_use* uses[STP_STORE_MATERIAL_TEXTURES];
    uint32_t count = stp_store_used_textures(m, uses);
    reads[0] = reads[1] = false;
    for (uint32_t i = 0; i < count; ++i) {
        reads[uses[i]->texcoord != 0 ? 1 : 0] = true;
    }
}

stp_gl_upload stp_gl_upload_mesh(stp_gl_renderer* r, uint32_t mesh)
{
    uint32_t entry = r->entries.meshes + mesh;
    if (stp_gl_pool_has(&r->pool, entry)) {
        stp_gl_pool_use(&r->pool, entry);
        return GL_UPLOAD_THERE;
    }
    stp_clusters clusters;
    stp_store_mesh columns;
    bool clustered = stp_store_is_clustered(r->store, mesh);
    stp_result found = clustered ? stp_store_get_clusters(r->store, mesh, &clusters)
                                 : stp_store_get_mesh(r->store, mesh, &columns);
    if (found != STP_OK) {
        r->failure = found;
        return GL_UPLOAD_FAILED;
    }
    mesh_source source = {.clusters = clustered ? &clusters : NULL,
                          .mesh = clustered ? stp_store_describe_mesh(r->store, mesh) : &columns};
    choose_texcoords(r, source.mesh->material, source.reads);
    uint32_t count;
    if (clustered) {
        source.reads[0] = source.reads[0] && (clusters.present & STP_COLUMN_TEXCOORDS_0) != 0;
        source.reads[1] = source.reads[1] && (clusters.present & STP_COLUMN_TEXCOORDS_1) != 0;
        source.colors = (clusters.present & STP_COLUMN_COLORS) != 0;
        count = clusters.cluster_count;
    } else {
        source.reads[0] = source.reads[0] && columns.texcoords[0] != NULL;
        source.reads[1] = source.reads[1] && columns.texcoords[1] != NULL;
        source.colors = columns.colors != NULL;
        count = (columns.triangle_count + UPLOAD_CLUSTER_TRIANGLES - 1) / UPLOAD_CLUSTER_TRIANGLES;
    }
    uint64_t words = (uint64_t)count * CLUSTER_WORDS;
    stp_cluster cluster;
    for (uint32_t i = 0; i < count; ++i) {
        cluster_shape shape = shape_of(&source, i, &cluster);
        words += words_of(&source, &shape);
    }
    stp_gl_upload result = stp_gl_upload_begin(r, entry, words, true);
    if (result != GL_UPLOAD_THERE) {
        return result;
    }
    stp_gl_writer writer = stp_gl_writer_begin(r, entry, words);
    write_mesh(&source, count, &writer);
    return stp_gl_upload_end(r, entry, &writer, true);
}
