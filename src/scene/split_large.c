// SPDX-License-Identifier: MIT
#include "base/core/large_blocks.h"
#include "base/core/sort.h"
#include "base/io/file.h"
#include "scene/bulk.h"
#include "scene/finish_steps.h"
#include "scene/partition_steps.h"
#include "scene/strays.h"

#include <assert.h>
#include <pthread.h>
#include <string.h>

#define GRAIN 65536
#define RELEASE_SIZE ((size_t)128 << 20) // finished pieces, after which their pages are released
#define RELEASE_COUNT (1u << 21)         // elements
#define TOUCHED_MAX ((size_t)16 << 20)   // bytes touched by gathering before they are counted
#define LARGE_SIZE ((size_t)64 << 20)    // larger working data is spilled if the mesh is

// State shared by the jobs. New pieces follow the scene's own items and count only once all are
// made.
typedef struct splitter {
    stp_scene* scene;
    const stp_mesh* mesh; ///< exactly one of them is not NULL
    const stp_point_set* points;
    stp_mesh* mesh_pieces;
    stp_point_set* point_pieces;
    stp_place* places;
    size_t first_place; ///< first place of this batch of find_places
    uint32_t* ends;
    uint32_t piece_count; ///< of the rest and of the strays
    const stp_strays* strays;
    stp_place* stray_places;    ///< grouped
    const uint32_t* group_ends; ///< of each group of strays
    uint32_t group_count;
    bool spilled;
    size_t unreleased; ///< bytes of pieces made since pages of the spill were released
    pthread_mutex_t mutex;
    stp_result result; ///< result of the first failure; I/O errors are already logged
} splitter;

static void find_places(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const splitter* c = user;
    for (size_t i = c->first_place + begin; i < c->first_place + end; ++i) {
        stp_place* place = &c->places[i];
        place->index = (uint32_t)i;
        for (size_t k = 0; k < 3; ++k) {
            if (c->points != NULL) {
                place->at[k] = c->points->positions[3 * i + k];
                continue;
            }
            double sum = 0.0;
            for (size_t corner = 0; corner < 3; ++corner) {
                sum += (double)c->mesh->positions[3 * (size_t)c->mesh->indices[3 * i + corner] + k];
            }
            place->at[k] = (float)(sum / 3.0);
        }
    }
}

// Allocates a piece's arrays, whose sizes are set; false on failure. A failure of the spill is
// logged once.
static bool get_room(splitter* c, stp_bulk_array* arrays, size_t count)
{
    pthread_mutex_lock(&c->mutex);
    bool made = c->result == STP_OK;
    if (made && c->spilled) {
        c->result = stp_bulk_alloc_spilled(c->scene->spill, arrays, count);
        made = c->result == STP_OK;
    }
    pthread_mutex_unlock(&c->mutex);
    for (size_t i = 0; !c->spilled && i < count; ++i) {
        arrays[i].bytes =
            made && arrays[i].size != 0 ? stp_alloc(c->scene->context, arrays[i].size) : NULL;
        made = made && (arrays[i].size == 0 || arrays[i].bytes != NULL);
    }
    return made;
}

// Counts `bytes` more resident bytes. Beyond a limit, releases pages of the spill.
static void note_made(splitter* c, size_t bytes)
{
    pthread_mutex_lock(&c->mutex);
    c->unreleased += bytes;
    bool release = c->spilled && c->unreleased >= RELEASE_SIZE;
    c->unreleased = release ? 0 : c->unreleased;
    pthread_mutex_unlock(&c->mutex);
    if (release) {
        stp_spill_release_pages(c->scene->spill);
    }
}

static void note_memory(splitter* c)
{
    pthread_mutex_lock(&c->mutex);
    c->result = c->result == STP_OK ? STP_ERROR_OUT_OF_MEMORY : c->result;
    pthread_mutex_unlock(&c->mutex);
}

// Copies `size` bytes of each distinct vertex; corners are sorted by vertex.
static void gather(const void* from, void* to, size_t size, const uint64_t* corners, size_t count)
{
    unsigned char* out = to;
    for (size_t i = 0; out != NULL && i < count; ++i) {
        if (i == 0 || corners[i] >> 32 != corners[i - 1] >> 32) {
            memcpy(out, (const unsigned char*)from + (size_t)(corners[i] >> 32) * size, size);
            out += size;
        }
    }
}

// Makes a piece from its corners, sorted by vertex: vertex in the upper half, corner index in the
// lower.
static bool fill_mesh_piece(splitter* c, stp_mesh* piece, const uint64_t* corners)
{
    const stp_mesh* mesh = c->mesh;
    size_t corner_count = 3 * (size_t)piece->triangle_count;
    assert(corner_count > 0 && mesh->triangle_count >= piece->triangle_count);
    uint32_t vertices = 0;
    for (size_t i = 0; i < corner_count; ++i) {
        vertices += i == 0 || corners[i] >> 32 != corners[i - 1] >> 32;
    }
    piece->vertex_count = vertices;
    stp_bulk_array from[STP_MESH_ARRAYS], to[STP_MESH_ARRAYS];
    stp_mesh_get_arrays(mesh, from);
    for (size_t i = 0; i < STP_MESH_ARRAYS; ++i) {
        bool per_vertex = i < STP_MESH_ARRAYS - 1;
        size_t element = from[i].size / (per_vertex ? mesh->vertex_count : mesh->triangle_count);
        to[i] = (stp_bulk_array){
            .size = element * (per_vertex ? piece->vertex_count : piece->triangle_count)};
    }
    bool made = get_room(c, to, STP_MESH_ARRAYS);
    stp_mesh_set_arrays(piece, to);
    if (!made) {
        return false;
    }
    for (size_t i = 0; i < STP_MESH_ARRAYS - 1; ++i) {
        gather(from[i].bytes, to[i].bytes, from[i].size / mesh->vertex_count, corners,
               corner_count);
    }
    uint32_t vertex = 0;
    for (size_t i = 0; i < corner_count; ++i) {
        vertex += i > 0 && corners[i] >> 32 != corners[i - 1] >> 32;
        piece->indices[(uint32_t)corners[i]] = vertex;
    }
    assert(vertex + 1 == piece->vertex_count && "each vertex has a corner");
    stp_mesh_measure(piece);
    // equal triangles with different rounding are different content
    piece->content = stp_hash_bytes(stp_mesh_hash(piece), &piece->grid_step, sizeof(double));
    return true;
}

static void make_mesh_pieces(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    splitter* c = user;
    for (size_t i = begin; i < end; ++i) {
        uint32_t first = i > 0 ? c->ends[i - 1] : 0;
        stp_mesh* piece = &c->mesh_pieces[i];
        *piece = *c->mesh;
        piece->is_piece = true;
        stp_mesh_set_arrays(piece, (stp_bulk_array[STP_MESH_ARRAYS]){{0}});
        piece->triangle_count = c->ends[i] - first;
        piece->spilled = c->spilled;
        size_t count = 3 * (size_t)piece->triangle_count;
        uint64_t* corners = STP_NEW_ARRAY(c->scene->context, uint64_t, 2 * count);
        bool made = corners != NULL;
        for (size_t k = 0; made && k < count; ++k) {
            size_t triangle = c->places[first + k / 3].index;
            corners[k] = (uint64_t)c->mesh->indices[3 * triangle + k % 3] << 32 | k;
        }
        if (made) {
            const uint64_t* sorted = stp_sort_u64(corners, corners + count, count, 32,
                                                  stp_bit_width(c->mesh->vertex_count));
            made = fill_mesh_piece(c, piece, sorted);
        }
        stp_free(c->scene->context, corners);
        if (!made) {
            note_memory(c);
            continue;
        }
        note_made(c, (size_t)stp_mesh_bytes(piece));
    }
}

// Copies one array of a piece. Its points may be scattered over the whole array.
static void gather_points(splitter* c, const stp_bulk_array* from, const stp_bulk_array* to,
                          uint32_t first, uint32_t count)
{
    assert(from->size % c->points->point_count == 0 && to->size >= count);
    size_t element = from->size / c->points->point_count, block = SIZE_MAX, touched = 0;
    for (size_t p = 0; p < count; ++p) {
        size_t at = (size_t)c->places[first + p].index * element;
        touched += at / STP_FAULT_AROUND != block ? STP_FAULT_AROUND : 0;
        block = at / STP_FAULT_AROUND;
        if (touched >= TOUCHED_MAX) {
            note_made(c, touched);
            touched = 0;
        }
        memcpy((unsigned char*)to->bytes + p * element, (const unsigned char*)from->bytes + at,
               element);
    }
    note_made(c, touched);
}

static void make_point_pieces(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    splitter* c = user;
    for (size_t i = begin; i < end; ++i) {
        uint32_t first = i > 0 ? c->ends[i - 1] : 0;
        stp_point_set* piece = &c->point_pieces[i];
        *piece = *c->points;
        piece->point_count = c->ends[i] - first;
        piece->spilled = c->spilled;
        stp_bulk_array from[STP_POINT_ARRAYS], to[STP_POINT_ARRAYS];
        stp_points_get_arrays(c->points, from);
        for (size_t k = 0; k < STP_POINT_ARRAYS; ++k) {
            size_t element = from[k].size / c->points->point_count;
            to[k] = (stp_bulk_array){.size = element * piece->point_count};
        }
        bool made = get_room(c, to, STP_POINT_ARRAYS);
        stp_points_set_arrays(piece, to);
        if (!made) {
            note_memory(c);
            continue;
        }
        for (size_t k = 0; k < STP_POINT_ARRAYS; ++k) {
            if (from[k].size != 0) {
                gather_points(c, &from[k], &to[k], first, piece->point_count);
            }
        }
        piece->bounds = stp_box_empty();
        for (uint32_t p = 0; p < piece->point_count; ++p) {
            const float* at = piece->positions + 3 * (size_t)p;
            stp_box_add(&piece->bounds, (stp_vec3){at[0], at[1], at[2]});
        }
        piece->content = stp_points_hash(piece);
        // places of finished pieces are not needed again: that memory is used by later pieces
        stp_large_discard(c->places + first, piece->point_count * sizeof(stp_place));
        note_made(c, (size_t)stp_points_bytes(piece));
    }
}

// Counts the pieces' memory, and frees all pieces if one failed.
static void finish_pieces(splitter* c)
{
    for (uint32_t i = 0; i < c->piece_count; ++i) {
        if (c->mesh != NULL) {
            stp_mesh* piece = &c->mesh_pieces[i];
            c->scene->bulk_bytes += c->spilled ? 0 : stp_mesh_bytes(piece);
            if (c->result != STP_OK) {
                stp_mesh_free_arrays(c->scene, piece);
            }
        } else {
            stp_point_set* piece = &c->point_pieces[i];
            c->scene->bulk_bytes += c->spilled ? 0 : stp_points_bytes(piece);
            if (c->result != STP_OK) {
                stp_points_free_arrays(c->scene, piece);
            }
        }
    }
}

// Finds places in batches if they are in a file, so that little of it is resident.
static void find_all_places(splitter* c, uint32_t count)
{
    uint32_t maximum = c->spilled ? RELEASE_COUNT : count;
    for (uint32_t first = 0, size; first < count; first += size) {
        size = count - first < maximum ? count - first : maximum;
        c->first_place = first;
        stp_parallel_for(c->scene->context, size, GRAIN, find_places, c);
        if (c->spilled) {
            stp_spill_release_pages(c->scene->spill);
        }
    }
}

// Moves the strays behind the others, group by group.
static void move_strays(splitter* c, uint32_t count)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; ++i) {
        if (!stp_is_stray(c->strays, c->places[i].at)) {
            c->places[kept++] = c->places[i];
        }
        if (c->spilled && i % RELEASE_COUNT == RELEASE_COUNT - 1) {
            stp_spill_release_pages(c->scene->spill);
        }
    }
    assert(kept + c->strays->count == count);
    memcpy(c->places + kept, c->stray_places, c->strays->count * sizeof(*c->places));
    for (uint32_t i = 0; i < c->group_count; ++i) {
        c->ends[c->piece_count - c->group_count + i] = kept + c->group_ends[i];
    }
}

// Divides the elements and makes the pieces.
static stp_result split(splitter* c, uint32_t count, stp_job make_pieces)
{
    stp_context* context = c->scene->context;
    stp_bulk_array places = {.size = count * sizeof(stp_place)};
    bool large = c->spilled && places.size > LARGE_SIZE;
    if (large) {
        c->result = stp_bulk_alloc_spilled(c->scene->spill, &places, 1);
    } else {
        places.bytes = stp_alloc(context, places.size);
        c->result = places.bytes != NULL ? STP_OK : stp_fail_memory(context);
    }
    c->places = places.bytes;
    c->ends = STP_NEW_ARRAY(context, uint32_t, c->piece_count);
    if (c->result == STP_OK && c->ends == NULL) {
        c->result = stp_fail_memory(context);
    }
    if (c->result == STP_OK) {
        uint32_t rest = count - (c->group_count > 0 ? c->strays->count : 0);
        find_all_places(c, count);
        if (c->group_count > 0) {
            move_strays(c, count);
        }
        c->result = stp_split_ranges(context, c->places, rest, count,
                                     c->piece_count - c->group_count, large, c->ends);
    }
    if (c->result == STP_OK) {
        pthread_mutex_init(&c->mutex, NULL);
        stp_parallel_for(context, c->piece_count, 1, make_pieces, c);
        pthread_mutex_destroy(&c->mutex);
        finish_pieces(c);
        if (c->result == STP_ERROR_OUT_OF_MEMORY) {
            (void)stp_fail_memory(context);
        }
    }
    stp_free(context, c->ends);
    stp_free(context, large ? NULL : places.bytes);
    return c->result;
}

static bool should_spill(const stp_scene* scene, bool spilled, uint64_t bytes)
{
    return spilled || (scene->spill != NULL && scene->bulk_bytes + bytes > scene->spill_above);
}

stp_result stp_split_mesh(stp_scene* scene, uint32_t mesh, uint32_t maximum, uint32_t* first_piece,
                          uint32_t* piece_count)
{
    assert(mesh < scene->mesh_count && maximum > 0);
    assert(scene->meshes[mesh].triangle_count > maximum && "needs splitting");
    uint32_t triangles = scene->meshes[mesh].triangle_count;
    uint32_t pieces = triangles / maximum + (triangles % maximum != 0);
    size_t needed = scene->mesh_count + pieces;
    stp_result result =
        STP_SCENE_MAKE_ROOM(scene->context, scene->meshes, scene->mesh_capacity, needed);
    if (result != STP_OK) {
        return result;
    }
    splitter c = {.scene = scene,
                  .mesh = &scene->meshes[mesh],
                  .mesh_pieces = scene->meshes + scene->mesh_count,
                  .piece_count = pieces,
                  .spilled = should_spill(scene, scene->meshes[mesh].spilled,
                                          stp_mesh_bytes(&scene->meshes[mesh]))};
    result = split(&c, triangles, make_mesh_pieces);
    if (result == STP_OK) {
        *first_piece = (uint32_t)scene->mesh_count;
        *piece_count = pieces;
        scene->mesh_count += pieces;
    }
    return result;
}

static stp_result split_points(stp_scene* scene, uint32_t set, uint32_t maximum, splitter* c,
                               uint32_t* first_piece, uint32_t* piece_count)
{
    uint32_t count = scene->point_sets[set].point_count;
    uint32_t rest = count - (c->group_count > 0 ? c->strays->count : 0);
    c->piece_count = rest / maximum + (rest % maximum != 0) + c->group_count;
    size_t needed = scene->point_set_count + c->piece_count;
    stp_result result =
        STP_SCENE_MAKE_ROOM(scene->context, scene->point_sets, scene->point_set_capacity, needed);
    if (result != STP_OK) {
        return result;
    }
    c->points = &scene->point_sets[set];
    c->point_pieces = scene->point_sets + scene->point_set_count;
    c->spilled = should_spill(scene, scene->point_sets[set].spilled,
                              stp_points_bytes(&scene->point_sets[set]));
    result = split(c, count, make_point_pieces);
    if (result == STP_OK) {
        *first_piece = (uint32_t)scene->point_set_count;
        *piece_count = c->piece_count;
        scene->point_set_count += c->piece_count;
    }
    return result;
}

static void list_strays(const stp_point_set* points, const stp_strays* strays, stp_place* places)
{
    uint32_t found = 0;
    for (uint32_t i = 0; i < points->point_count; ++i) {
        const float* p = points->positions + 3 * (size_t)i;
        if (stp_is_stray(strays, p)) {
            places[found++] = (stp_place){.at = {p[0], p[1], p[2]}, .index = i};
        }
    }
    assert(found == strays->count);
}

stp_result stp_split_points(stp_scene* scene, uint32_t set, uint32_t maximum,
                            const stp_strays* strays, uint32_t* first_piece, uint32_t* piece_count)
{
    assert(set < scene->point_set_count && maximum > 0);
    assert((scene->point_sets[set].point_count > maximum || strays->count > 0) &&
           "needs splitting");
    stp_context* context = scene->context;
    splitter c = {.scene = scene, .strays = strays};
    if (strays->count == 0) {
        return split_points(scene, set, maximum, &c, first_piece, piece_count);
    }
    uint32_t* ends = STP_NEW_ARRAY(context, uint32_t, strays->count);
    c.stray_places = STP_NEW_ARRAY(context, stp_place, strays->count);
    c.group_ends = ends;
    stp_result result = STP_OK;
    if (ends == NULL || c.stray_places == NULL) {
        result = stp_fail_memory(context);
    } else {
        list_strays(&scene->point_sets[set], strays, c.stray_places);
        result = stp_strays_group(context, strays, c.stray_places, ends, &c.group_count);
    }
    result =
        result == STP_OK ? split_points(scene, set, maximum, &c, first_piece, piece_count) : result;
    stp_free(context, c.stray_places);
    stp_free(context, ends);
    return result;
}
