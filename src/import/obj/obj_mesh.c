// SPDX-License-Identifier: MIT
//
// Converts faces of one group and material to a mesh. Corners are gathered by position; within one
// position, corners of equal texture coordinate and normal share a vertex. Vertices follow the
// order of positions, so the result does not depend on the assignment to threads. Tables of large
// meshes are stored like the file's arrays.
#include "base/core/sort.h"
#include "import/obj/obj.h"
#include "import/reading/surface.h"
#include "import/reading/triangulate.h"

#include <assert.h>
#include <stdatomic.h>
#include <string.h>

#define GRAIN ((size_t)1 << 14)

typedef struct builder {
    stp_obj* obj;
    stp_context* context;
    const stp_obj_corner* corners;
    const uint32_t* polygon_ends;
    size_t corner_count, polygon_count;
    uint32_t first_position;
    uint32_t* ranks;           ///< per corner: rank of its position among those used; NULL: dense
    size_t bucket_count;       ///< positions used, or from the first to the last one used
    _Atomic uint32_t* buckets; ///< where each position's corners end in `sorted`
    uint32_t* sorted;          ///< corners, gathered by position
    uint32_t* first_vertex;    ///< per bucket; until the sum, its number of vertices
    uint32_t* vertices;        ///< per corner; at first counted within its bucket
    bool has_texcoords, has_normals;
    bool large; ///< built alone
    atomic_bool out_of_memory;
    stp_mesh mesh;
} builder;

static void find_range(builder* b)
{
    assert(b->corner_count > 0 && b->corner_count <= UINT32_MAX);
    uint32_t low = UINT32_MAX, high = 0;
    for (size_t i = 0; i < b->corner_count; ++i) {
        const stp_obj_corner* corner = &b->corners[i];
        low = corner->position < low ? corner->position : low;
        high = corner->position > high ? corner->position : high;
        b->has_texcoords |= corner->texcoord != STP_OBJ_ABSENT;
        b->has_normals |= corner->normal != STP_OBJ_ABSENT;
    }
    assert(low <= high && high < b->obj->position_count && "indices were checked");
    b->first_position = low;
    b->bucket_count = (size_t)(high - low) + 1;
}

static void* alloc_table(builder* b, size_t count, size_t size)
{
    return b->large ? stp_obj_alloc(b->obj, count, size) : stp_alloc_array(b->context, count, size);
}

static void free_table(const builder* b, void* table)
{
    if (b->large) {
        stp_obj_free(b->obj, table);
    } else {
        stp_free(b->context, table);
    }
}

// For a mesh that uses few positions of a wide range: sorts the positions instead of allocating the
// range.
static bool rank_positions(builder* b)
{
    size_t count = b->corner_count;
    uint64_t* items = alloc_table(b, count, sizeof(uint64_t));
    uint64_t* scratch = alloc_table(b, count, sizeof(uint64_t));
    b->ranks = alloc_table(b, count, sizeof(uint32_t));
    bool ready = items != NULL && scratch != NULL && b->ranks != NULL;
    if (ready) {
        for (size_t i = 0; i < count; ++i) {
            items[i] = (uint64_t)b->corners[i].position << 32 | i;
        }
        const uint64_t* sorted = stp_sort_u64(items, scratch, count, 32, 32);
        uint32_t rank = 0;
        for (size_t i = 0; i < count; ++i) {
            rank += i > 0 && sorted[i] >> 32 != sorted[i - 1] >> 32;
            b->ranks[(uint32_t)sorted[i]] = rank;
        }
        assert(rank < count);
        b->bucket_count = (size_t)rank + 1;
    }
    free_table(b, items);
    free_table(b, scratch);
    return ready;
}

static inline _Atomic uint32_t* bucket_of(const builder* b, size_t corner)
{
    return &b->buckets[b->ranks != NULL ? b->ranks[corner]
                                        : b->corners[corner].position - b->first_position];
}

static void count_corners(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    builder* b = user;
    for (size_t i = begin; i < end; ++i) {
        atomic_fetch_add_explicit(bucket_of(b, i), 1, memory_order_relaxed);
    }
}

static void scatter_corners(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    builder* b = user;
    for (size_t i = begin; i < end; ++i) {
        uint32_t slot = atomic_fetch_add_explicit(bucket_of(b, i), 1, memory_order_relaxed);
        assert(slot < b->corner_count);
        b->sorted[slot] = (uint32_t)i;
    }
}

static uint64_t attributes(const builder* b, uint32_t corner)
{
    return (uint64_t)b->corners[corner].texcoord << 32 | b->corners[corner].normal;
}

static void sift_down(const builder* b, uint32_t* heap, size_t root, size_t count)
{
    for (size_t child; (child = 2 * root + 1) < count; root = child) {
        child += child + 1 < count && attributes(b, heap[child + 1]) > attributes(b, heap[child]);
        if (attributes(b, heap[root]) >= attributes(b, heap[child])) {
            return;
        }
        uint32_t swap = heap[root];
        heap[root] = heap[child];
        heap[child] = swap;
    }
}

// Sorts by attributes. Threads fill a bucket in any order, but equal attributes give one vertex
// anyway.
static void sort_bucket(const builder* b, uint32_t* corners, size_t count)
{
    if (count > 32) {
        for (size_t i = count / 2; i-- > 0;) {
            sift_down(b, corners, i, count);
        }
        for (size_t i = count; i-- > 1;) {
            uint32_t swap = corners[0];
            corners[0] = corners[i];
            corners[i] = swap;
            sift_down(b, corners, 0, i);
        }
        return;
    }
    for (size_t i = 1; i < count; ++i) {
        uint32_t corner = corners[i];
        uint64_t key = attributes(b, corner);
        size_t k = i;
        for (; k > 0 && attributes(b, corners[k - 1]) > key; --k) {
            corners[k] = corners[k - 1];
        }
        corners[k] = corner;
    }
}

#ifndef NDEBUG
static bool is_sorted(const builder* b, const uint32_t* corners, size_t count)
{
    for (size_t i = 1; i < count; ++i) {
        if (attributes(b, corners[i - 1]) > attributes(b, corners[i])) {
            return false;
        }
    }
    return true;
}
#endif

static size_t bucket_begin(const builder* b, size_t bucket)
{
    return bucket > 0 ? atomic_load_explicit(&b->buckets[bucket - 1], memory_order_relaxed) : 0;
}

static size_t bucket_end(const builder* b, size_t bucket)
{
    return atomic_load_explicit(&b->buckets[bucket], memory_order_relaxed);
}

static void number_variants(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    builder* b = user;
    for (size_t bucket = begin; bucket < end; ++bucket) {
        size_t first = bucket_begin(b, bucket), last = bucket_end(b, bucket);
        assert(first <= last && last <= b->corner_count);
        sort_bucket(b, b->sorted + first, last - first);
        assert(is_sorted(b, b->sorted + first, last - first));
        uint32_t variants = 0;
        for (size_t i = first; i < last; ++i) {
            bool same = i > first && attributes(b, b->sorted[i]) == attributes(b, b->sorted[i - 1]);
            variants += !same;
            b->vertices[b->sorted[i]] = variants - 1;
        }
        b->first_vertex[bucket] = variants;
    }
}

static void write_vertex(const builder* b, uint32_t vertex, const stp_obj_corner* corner)
{
    const stp_obj* obj = b->obj;
    size_t v = vertex, p = corner->position;
    assert(vertex < b->mesh.vertex_count && p < obj->position_count);
    assert(corner->texcoord == STP_OBJ_ABSENT || corner->texcoord < obj->texcoord_count);
    assert(corner->normal == STP_OBJ_ABSENT || corner->normal < obj->normal_count);
    memcpy(b->mesh.positions + 3 * v, obj->positions + 3 * p, 3 * sizeof(float));
    if (b->mesh.texcoords[0] != NULL) {
        // OBJ's v starts at the bottom of the picture
        bool has = corner->texcoord != STP_OBJ_ABSENT;
        const float* in = obj->texcoords + 2 * (size_t)corner->texcoord;
        b->mesh.texcoords[0][2 * v] = has ? in[0] : 0.0f;
        b->mesh.texcoords[0][2 * v + 1] = has ? 1.0f - in[1] : 0.0f;
    }
    if (b->mesh.normals != NULL) {
        stp_vec3 normal = {0};
        if (corner->normal != STP_OBJ_ABSENT) {
            const float* in = obj->normals + 3 * (size_t)corner->normal;
            normal = stp_normalize((stp_vec3){in[0], in[1], in[2]});
        }
        memcpy(b->mesh.normals + 3 * v, &normal, sizeof(normal));
    }
    if (b->mesh.colors != NULL) {
        for (size_t i = 0; i < 3; ++i) {
            float value = stp_srgb_to_linear(stp_obj_color(obj, 3 * p + i));
            b->mesh.colors[4 * v + i] = stp_unorm16(value);
        }
        b->mesh.colors[4 * v + 3] = 65535;
    }
}

static void write_vertices(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    builder* b = user;
    for (size_t bucket = begin; bucket < end; ++bucket) {
        uint32_t first = b->first_vertex[bucket], last = UINT32_MAX;
        for (size_t i = bucket_begin(b, bucket); i < bucket_end(b, bucket); ++i) {
            uint32_t corner = b->sorted[i];
            uint32_t variant = b->vertices[corner];
            if (variant != last) {
                write_vertex(b, first + variant, &b->corners[corner]);
                last = variant;
            }
            b->vertices[corner] = first + variant;
        }
    }
}

static void write_triangles(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    builder* b = user;
    for (size_t polygon = begin; polygon < end; ++polygon) {
        size_t first = polygon > 0 ? b->polygon_ends[polygon - 1] : 0;
        uint32_t count = (uint32_t)(b->polygon_ends[polygon] - first);
        assert(first <= b->polygon_ends[polygon] && count >= 3);
        assert(first - 2 * polygon + count - 2 <= b->mesh.triangle_count);
        // every polygon before had two triangles fewer than corners
        uint32_t* triangles = b->mesh.indices + 3 * (first - 2 * polygon);
        if (!stp_triangulate(b->context, b->mesh.positions, b->vertices + first, count,
                             triangles)) {
            atomic_store(&b->out_of_memory, true);
        }
    }
}

// Prefix sums in place: counts become starts. @return the total
static size_t sum_buckets(builder* b)
{
    uint32_t sum = 0;
    for (size_t i = 0; i < b->bucket_count; ++i) {
        uint32_t count = atomic_load_explicit(&b->buckets[i], memory_order_relaxed);
        atomic_store_explicit(&b->buckets[i], sum, memory_order_relaxed);
        sum += count;
    }
    assert(sum == b->corner_count);
    return sum;
}

static size_t sum_vertices(builder* b)
{
    uint32_t sum = 0;
    for (size_t i = 0; i < b->bucket_count; ++i) {
        uint32_t count = b->first_vertex[i];
        b->first_vertex[i] = sum;
        sum += count;
    }
    assert(sum > 0 && sum <= b->corner_count);
    return sum;
}

static bool alloc_mesh(builder* b, size_t vertex_count)
{
    stp_mesh* mesh = &b->mesh;
    mesh->vertex_count = (uint32_t)vertex_count;
    mesh->triangle_count = (uint32_t)(b->corner_count - 2 * b->polygon_count);
    mesh->positions = STP_NEW_ARRAY(b->context, float, 3 * vertex_count);
    mesh->indices = STP_NEW_ARRAY(b->context, uint32_t, 3 * (size_t)mesh->triangle_count);
    mesh->texcoords[0] =
        b->has_texcoords ? STP_NEW_ARRAY(b->context, float, 2 * vertex_count) : NULL;
    mesh->normals = b->has_normals ? STP_NEW_ARRAY(b->context, float, 3 * vertex_count) : NULL;
    mesh->colors =
        b->obj->has_colors ? STP_NEW_ARRAY(b->context, uint16_t, 4 * vertex_count) : NULL;
    return mesh->positions != NULL && mesh->indices != NULL &&
           b->has_texcoords == (mesh->texcoords[0] != NULL) &&
           b->has_normals == (mesh->normals != NULL) &&
           b->obj->has_colors == (mesh->colors != NULL);
}

static bool merge_corners(builder* b)
{
    find_range(b);
    if (b->bucket_count / 8 > b->corner_count && !rank_positions(b)) {
        return false;
    }
    b->buckets = alloc_table(b, b->bucket_count, sizeof(*b->buckets));
    b->sorted = alloc_table(b, b->corner_count, sizeof(uint32_t));
    b->vertices = alloc_table(b, b->corner_count, sizeof(uint32_t));
    b->first_vertex = alloc_table(b, b->bucket_count, sizeof(uint32_t));
    if (b->buckets == NULL || b->sorted == NULL || b->vertices == NULL || b->first_vertex == NULL) {
        return false;
    }
    memset((void*)(uintptr_t)b->buckets, 0, b->bucket_count * sizeof(*b->buckets));
    stp_parallel_for(b->context, b->corner_count, GRAIN, count_corners, b);
    (void)sum_buckets(b);
    stp_parallel_for(b->context, b->corner_count, GRAIN, scatter_corners, b);
    stp_parallel_for(b->context, b->bucket_count, GRAIN, number_variants, b);
    if (!alloc_mesh(b, sum_vertices(b))) {
        return false;
    }
    stp_parallel_for(b->context, b->bucket_count, GRAIN, write_vertices, b);
    stp_parallel_for(b->context, b->polygon_count, GRAIN, write_triangles, b);
    return !atomic_load(&b->out_of_memory);
}

void stp_obj_free_mesh(stp_context* context, const stp_mesh* mesh)
{
    stp_free(context, mesh->positions);
    stp_free(context, mesh->normals);
    stp_free(context, mesh->texcoords[0]);
    stp_free(context, mesh->colors);
    stp_free(context, mesh->indices);
}

stp_result stp_obj_build_mesh(stp_obj* obj, const stp_obj_mesh* in, stp_mesh* out)
{
    assert(in->first_corner + in->corner_count <= obj->corner_count);
    assert(in->polygon_count > 0 && in->first_polygon + in->polygon_count <= obj->polygon_count);
    assert(obj->polygons[in->first_polygon + in->polygon_count - 1] == in->corner_count);
    builder b = {.obj = obj,
                 .context = obj->context,
                 .corners = obj->corners + in->first_corner,
                 .polygon_ends = obj->polygons + in->first_polygon,
                 .corner_count = in->corner_count,
                 .polygon_count = in->polygon_count,
                 .large = in->corner_count > STP_OBJ_SMALL_MESH,
                 .mesh = {.material = in->material}};
    atomic_init(&b.out_of_memory, false);
    bool good = merge_corners(&b);
    free_table(&b, b.ranks);
    free_table(&b, (void*)(uintptr_t)b.buckets);
    free_table(&b, b.sorted);
    free_table(&b, b.first_vertex);
    free_table(&b, b.vertices);
    if (!good) {
        stp_obj_free_mesh(b.context, &b.mesh);
    }
    *out = good ? b.mesh : (stp_mesh){0};
    return good ? STP_OK : b.large && obj->scratch_full ? STP_ERROR_IO : STP_ERROR_OUT_OF_MEMORY;
}
