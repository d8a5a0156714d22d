// SPDX-License-Identifier: MIT
// Uploads meshes to the pool: decoded clusters, each with a header.
#include "draw/gl/upload.h"
#include "store/bytes/format.h"

#include <assert.h>
#include <string.h>

/// Attributes of a cluster, and its first triangle in the mesh.
typedef struct cluster_shape {
    uint32_t first_triangle, triangles, vertices, normals;
    stp_box box;
} cluster_shape;

static cluster_shape shape_of(const stp_gl_mesh_source* source, uint32_t index,
                              stp_cluster* cluster)
{
    if (source->clustered) {
        stp_clusters_get(&source->clusters, index, cluster);
        return (cluster_shape){.first_triangle = cluster->first_triangle,
                               .triangles = cluster->triangle_count,
                               .vertices = cluster->vertex_count,
                               .normals = cluster->normal_count,
                               .box = stp_clusters_bounds(&source->clusters, index)};
    }
    uint32_t first = index * UPLOAD_CLUSTER_TRIANGLES, left = source->mesh.triangle_count - first;
    uint32_t count = left < UPLOAD_CLUSTER_TRIANGLES ? left : UPLOAD_CLUSTER_TRIANGLES;
    return (cluster_shape){.first_triangle = first,
                           .triangles = count,
                           .vertices = 3 * count,
                           .normals = source->mesh.normals != NULL ? 3 * count : 0,
                           .box = source->mesh.bounds};
}

static uint64_t words_of(const stp_gl_mesh_source* source, const cluster_shape* shape)
{
    uint64_t vertices = shape->vertices;
    uint64_t sets = (source->reads[0] ? 2u : 0u) + (source->reads[1] ? 2u : 0u);
    return shape->triangles + (3 + sets + (source->colors ? 2u : 0u)) * vertices + shape->normals;
}

static uint32_t* write_float(uint32_t* w, float value)
{
    memcpy(w, &value, sizeof(value));
    return w + 1;
}

/// @return the end of what was written, as all functions here
static uint32_t* write_header(const stp_gl_mesh_source* source, const cluster_shape* shape,
                              uint64_t place, uint32_t* w)
{
    const uint32_t* begin = w;
    uint32_t at = (uint32_t)place, vertices = shape->vertices;
    *w++ = shape->first_triangle;
    *w++ = shape->triangles;
    *w++ = at;
    at += shape->triangles;
    *w++ = at;
    at += 3 * vertices;
    *w++ = at;
    at += shape->normals;
    for (int set = 0; set < 2; ++set) {
        *w++ = source->reads[set] ? at : 0;
        at += source->reads[set] ? 2 * vertices : 0;
    }
    *w++ = source->colors ? at : 0;
    const float box[6] = {shape->box.min.x, shape->box.min.y, shape->box.min.z,
                          shape->box.max.x, shape->box.max.y, shape->box.max.z};
    for (int k = 0; k < 6; ++k) {
        w = write_float(w, box[k]);
    }
    *w++ = vertices;
    *w++ = 0;
    assert(w == begin + CLUSTER_WORDS);
    (void)begin;
    return w;
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

static uint32_t* write_normals(const stp_cluster* cluster, uint32_t* w)
{
    const float scale = 32767.0f / (float)STP_CLUSTER_NORMAL_LIMIT;
    for (uint32_t i = 0; i < cluster->normal_count; ++i) {
        float u = (float)stp_cluster_value(&cluster->runs[STP_CLUSTER_NORMAL_U], i) * scale;
        float v = (float)stp_cluster_value(&cluster->runs[STP_CLUSTER_NORMAL_V], i) * scale;
        u = stp_clamp(u, -32767.0f, 32767.0f);
        v = stp_clamp(v, -32767.0f, 32767.0f);
        *w++ = pack_normal(u + (u < 0.0f ? -0.5f : 0.5f), v + (v < 0.0f ? -0.5f : 0.5f));
    }
    return w;
}

static uint32_t* write_cluster(const stp_gl_mesh_source* source, const stp_cluster* cluster,
                               uint32_t* w)
{
    float positions[3 * STP_CLUSTER_VERTICES];
    uint32_t indices[3 * STP_CLUSTER_TRIANGLES];
    stp_cluster_indices(cluster, 0, indices);
    for (uint32_t i = 0; i < cluster->triangle_count; ++i) {
        uint32_t faces = cluster->smooth_count + cluster->face_count;
        uint32_t lighting = i < cluster->smooth_count ? TRIANGLE_SMOOTH
                            : i < faces               ? TRIANGLE_FACE
                                                      : TRIANGLE_PLAIN;
        *w++ =
            indices[3 * i] | indices[3 * i + 1] << 10 | indices[3 * i + 2] << 20 | lighting << 30;
    }
    stp_cluster_positions(&source->clusters, cluster, positions);
    memcpy(w, positions, 3 * (size_t)cluster->vertex_count * sizeof(*positions));
    w = write_normals(cluster, w + 3 * (size_t)cluster->vertex_count);
    for (uint32_t set = 0; set < 2; ++set) {
        for (uint32_t i = 0; i < cluster->vertex_count && source->reads[set]; ++i) {
            stp_vec2 uv = stp_cluster_texcoord(&source->clusters, cluster, set, i);
            w = write_float(w, uv.x);
            w = write_float(w, uv.y);
        }
    }
    for (uint32_t i = 0; i < cluster->vertex_count && source->colors; ++i) {
        float color[4];
        stp_cluster_color(cluster, i, color);
        for (int k = 0; k < 4; ++k) { // may be any number in a forged file
            color[k] = stp_clamp(color[k], 0.0f, 1.0f);
        }
        *w++ = pack_pair(color[0], color[1]);
        *w++ = pack_pair(color[2], color[3]);
    }
    return w;
}

/// Triangles of columns: corners are not shared.
static uint32_t* write_columns(const stp_gl_mesh_source* source, const cluster_shape* shape,
                               uint32_t* w)
{
    assert(shape->vertices == 3 * shape->triangles && shape->vertices <= 1024 &&
           "10 bits a corner");
    const stp_store_mesh* mesh = &source->mesh;
    size_t first = 3 * (size_t)shape->first_triangle;
    uint32_t lighting = mesh->normals != NULL ? TRIANGLE_SMOOTH : TRIANGLE_PLAIN;
    for (uint32_t i = 0; i < shape->triangles; ++i) {
        *w++ = 3 * i | (3 * i + 1) << 10 | (3 * i + 2) << 20 | lighting << 30;
    }
    for (uint32_t i = 0; i < shape->vertices; ++i, w += 3) {
        memcpy(w, mesh->positions + 3 * (size_t)stp_store_mesh_corner(mesh, first + i),
               3 * sizeof(float));
    }
    for (uint32_t i = 0; i < shape->normals; ++i, ++w) {
        memcpy(w, mesh->normals + 2 * (size_t)stp_store_mesh_corner(mesh, first + i), sizeof(*w));
    }
    for (int set = 0; set < 2; ++set) {
        for (uint32_t i = 0; i < shape->vertices && source->reads[set]; ++i, w += 2) {
            memcpy(w, mesh->texcoords[set] + 2 * (size_t)stp_store_mesh_corner(mesh, first + i),
                   2 * sizeof(float));
        }
    }
    for (uint32_t i = 0; i < shape->vertices && source->colors; ++i, w += 2) {
        memcpy(w, mesh->colors + 4 * (size_t)stp_store_mesh_corner(mesh, first + i),
               2 * sizeof(*w));
    }
    return w;
}

/// `place`: of the first cluster, in the item.
static void write_headers(const stp_gl_source* source, const stp_gl_piece* piece, uint32_t* words)
{
    stp_cluster cluster;
    uint64_t place = piece->place;
    for (size_t i = piece->begin; i < piece->end; ++i) {
        cluster_shape shape = shape_of(&source->of.mesh, (uint32_t)i, &cluster);
        words = write_header(&source->of.mesh, &shape, place, words);
        place += words_of(&source->of.mesh, &shape);
    }
}

/// A file that is overwritten meanwhile may have other clusters now: no more words than the piece
/// has are written.
static void write_clusters(const stp_gl_source* source, const stp_gl_piece* piece, uint32_t* words)
{
    const stp_gl_mesh_source* mesh = &source->of.mesh;
    uint64_t left = piece->words;
    stp_cluster cluster;
    for (size_t i = piece->begin; i < piece->end; ++i) {
        cluster_shape shape = shape_of(mesh, (uint32_t)i, &cluster);
        uint64_t wanted = words_of(mesh, &shape);
        if (wanted > left) {
            break;
        }
        left -= wanted;
        words = mesh->clustered ? write_cluster(mesh, &cluster, words)
                                : write_columns(mesh, &shape, words);
    }
    memset(words, 0, (size_t)left * sizeof(*words));
}

/// Adds pieces of clusters, or of their headers.
static stp_result add_pieces(stp_gl_renderer* r, const stp_gl_mesh_source* source, uint32_t count,
                             bool headers)
{
    stp_cluster cluster;
    stp_gl_piece piece = {.convert = headers ? write_headers : write_clusters,
                          .place = (uint64_t)count * CLUSTER_WORDS};
    uint64_t place = piece.place;
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < count && result == STP_OK; ++i) {
        cluster_shape shape = shape_of(source, i, &cluster);
        uint64_t words = words_of(source, &shape);
        piece.words += headers ? CLUSTER_WORDS : (uint32_t)words;
        piece.end = (size_t)i + 1;
        place += words;
        if ((piece.words >= GL_PIECE_WORDS || i + 1 == count) && piece.words > 0) {
            result = stp_gl_conversions_add(&r->conversions, &r->pool, piece);
            piece.begin = piece.end;
            piece.words = 0;
            piece.place = place;
        }
    }
    return result;
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

/// Finds what is read of a mesh. @return its clusters
static uint32_t describe(const stp_gl_renderer* r, uint32_t mesh, stp_gl_mesh_source* source)
{
    const stp_store_mesh* columns = &source->mesh;
    if (source->clustered) {
        source->mesh = *stp_store_describe_mesh(r->store, mesh);
    }
    choose_texcoords(r, source->mesh.material, source->reads);
    if (source->clustered) {
        uint32_t present = source->clusters.present;
        source->reads[0] = source->reads[0] && (present & STP_COLUMN_TEXCOORDS_0) != 0;
        source->reads[1] = source->reads[1] && (present & STP_COLUMN_TEXCOORDS_1) != 0;
        source->colors = (present & STP_COLUMN_COLORS) != 0;
        return source->clusters.cluster_count;
    }
    source->reads[0] = source->reads[0] && columns->texcoords[0] != NULL;
    source->reads[1] = source->reads[1] && columns->texcoords[1] != NULL;
    source->colors = columns->colors != NULL;
    return (columns->triangle_count + UPLOAD_CLUSTER_TRIANGLES - 1) / UPLOAD_CLUSTER_TRIANGLES;
}

stp_gl_upload stp_gl_upload_mesh(stp_gl_renderer* r, uint32_t mesh)
{
    uint32_t entry = r->entries.meshes + mesh;
    if (stp_gl_pool_has(&r->pool, entry)) {
        stp_gl_pool_use(&r->pool, entry);
        return GL_UPLOAD_THERE;
    }
    stp_gl_mesh_source mesh_source = {.clustered = stp_store_is_clustered(r->store, mesh)};
    r->failure = mesh_source.clustered
                     ? stp_store_get_clusters(r->store, mesh, &mesh_source.clusters)
                     : stp_store_get_mesh(r->store, mesh, &mesh_source.mesh);
    if (r->failure != STP_OK) {
        return GL_UPLOAD_FAILED;
    }
    uint32_t count = describe(r, mesh, &mesh_source);
    uint64_t words = (uint64_t)count * CLUSTER_WORDS;
    stp_cluster cluster;
    for (uint32_t i = 0; i < count; ++i) {
        cluster_shape shape = shape_of(&mesh_source, i, &cluster);
        words += words_of(&mesh_source, &shape);
    }
    stp_gl_source* source;
    stp_gl_upload begun = stp_gl_upload_begin(r, entry, words, true, &source);
    if (begun != GL_UPLOAD_THERE) {
        return begun;
    }
    source->of.mesh = mesh_source;
    stp_result result = add_pieces(r, &mesh_source, count, true);
    result = result == STP_OK ? add_pieces(r, &mesh_source, count, false) : result;
    return stp_gl_upload_end(r, entry, result);
}
