// SPDX-License-Identifier: MIT
#include "import/reading/smooth.h"

#include "base/core/jobs.h"
#include "import/reading/lookup.h"
#include "scene/bulk.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum {
    GRAIN = 4096,       ///< triangles
    CORNERS_MOST = 4096 ///< corners at a smooth position: the work for each is their square
};

typedef struct smoother {
    stp_context* context;
    stp_mesh* mesh;
    float minimum;    ///< cosine of the angle
    stp_vec3* faces;  ///< 1 per triangle: unit normal; zero without area
    float* angles;    ///< 1 per corner, radians
    uint32_t* places; ///< 1 per vertex: vertices at one position share it
    uint32_t place_count;
    uint32_t* begins;  ///< by place: its first corner in `corners`
    uint32_t* corners; ///< sorted by place
    stp_vec3* normals; ///< 1 per corner
    uint32_t* indices; ///< 1 per corner: its new vertex
    uint32_t* origins; ///< by new vertex: the vertex it repeats
    uint32_t vertex_count;
} smoother;

static stp_vec3 position_of(const smoother* s, uint32_t corner)
{
    const float* p = s->mesh->positions + 3 * (size_t)s->mesh->indices[corner];
    return (stp_vec3){p[0], p[1], p[2]};
}

static stp_vec3 unit(stp_vec3 v)
{
    float length = sqrtf(stp_dot(v, v));
    return length > 0.0f && length < HUGE_VALF ? stp_scale(v, 1.0f / length) : (stp_vec3){0, 0, 0};
}

/// The angle of a cosine, to 0.0001: faster than the C library's, and the same on all machines
/// (Abramowitz and Stegun: Handbook of Mathematical Functions. 1964, 4.4.45).
static float angle_of(float cosine)
{
    float x = stp_min(fabsf(cosine), 1.0f);
    float angle =
        sqrtf(1.0f - x) * (1.5707288f + x * (-0.2121144f + x * (0.0742610f + x * -0.0187293f)));
    return cosine < 0.0f ? 3.1415927f - angle : angle;
}

static void measure_faces(size_t begin, size_t end, uint32_t worker, void* user)
{
    const smoother* s = user;
    (void)worker;
    for (size_t t = begin; t < end; ++t) {
        stp_vec3 p[3], side[3];
        for (uint32_t k = 0; k < 3; ++k) {
            p[k] = position_of(s, 3 * (uint32_t)t + k);
        }
        for (int k = 0; k < 3; ++k) { // lengths of 1: no product overflows
            side[k] = unit(stp_sub(p[(k + 1) % 3], p[k]));
        }
        s->faces[t] = unit(stp_cross(side[0], side[1]));
        for (int k = 0; k < 3; ++k) {
            s->angles[3 * t + (size_t)k] = angle_of(-stp_dot(side[k], side[(k + 2) % 3]));
        }
    }
}

/// Numbers the positions.
static stp_result find_places(smoother* s)
{
    stp_lookup known = {.context = s->context};
    stp_result result = STP_OK;
    for (uint32_t i = 0; result == STP_OK && i < s->mesh->vertex_count; ++i) {
        float place[3];
        for (size_t c = 0; c < 3; ++c) {
            place[c] = s->mesh->positions[3 * (size_t)i + c] + 0.0f; // -0 becomes 0
        }
        result = stp_lookup_add(&known, place, sizeof(place), s->place_count, &s->places[i]);
        s->place_count += result == STP_OK && s->places[i] == s->place_count;
    }
    stp_lookup_destroy(&known);
    return result;
}

/// Sorts corners by their places.
static void sort_corners(smoother* s)
{
    const stp_mesh* mesh = s->mesh;
    uint32_t count = 3 * mesh->triangle_count, sum = 0;
    for (uint32_t i = 0; i < count; ++i) {
        s->begins[s->places[mesh->indices[i]]] += 1;
    }
    for (uint32_t i = 0; i <= s->place_count; ++i) { // ends, which filling turns into begins
        sum += s->begins[i];
        s->begins[i] = sum;
    }
    for (uint32_t i = count; i-- > 0;) {
        s->corners[--s->begins[s->places[mesh->indices[i]]]] = i;
    }
    assert(s->begins[s->place_count] == count);
}

static void find_normals(size_t begin, size_t end, uint32_t worker, void* user)
{
    const smoother* s = user;
    (void)worker;
    for (size_t i = 3 * begin; i < 3 * end; ++i) {
        stp_vec3 own = s->faces[i / 3], sum = {0, 0, 0};
        uint32_t place = s->places[s->mesh->indices[i]];
        uint32_t first = s->begins[place], last = s->begins[place + 1];
        for (uint32_t k = first; last - first <= CORNERS_MOST && k < last; ++k) {
            uint32_t corner = s->corners[k];
            stp_vec3 face = s->faces[corner / 3];
            if (stp_dot(face, own) >= s->minimum) {
                sum = stp_add(sum, stp_scale(face, s->angles[corner]));
            }
        }
        sum = unit(sum);
        s->normals[i] = stp_dot(sum, sum) > 0.0f ? sum : own;
    }
}

/// Corners of one vertex with one normal become one vertex.
static stp_result join_corners(smoother* s)
{
    struct {
        uint32_t vertex;
        stp_vec3 normal;
    } key;
    stp_lookup known = {.context = s->context};
    stp_result result = STP_OK;
    uint32_t count = 3 * s->mesh->triangle_count;
    for (uint32_t i = 0; result == STP_OK && i < count; ++i) {
        memset(&key, 0, sizeof(key));
        key.vertex = s->mesh->indices[i];
        key.normal = stp_add(s->normals[i], (stp_vec3){0, 0, 0}); // -0 becomes 0
        result = stp_lookup_add(&known, &key, sizeof(key), s->vertex_count, &s->indices[i]);
        if (result == STP_OK && s->indices[i] == s->vertex_count) {
            s->origins[s->vertex_count++] = key.vertex;
        }
    }
    stp_lookup_destroy(&known);
    return result;
}

/// An array with the values of each new vertex; NULL if the mesh has none, or memory is short.
static void* repeat(const smoother* s, const void* values, size_t size)
{
    unsigned char* repeated =
        values != NULL ? stp_alloc(s->context, s->vertex_count * size + 1) : NULL;
    for (uint32_t i = 0; repeated != NULL && i < s->vertex_count; ++i) {
        memcpy(repeated + i * size, (const unsigned char*)values + s->origins[i] * size, size);
    }
    return repeated;
}

/// Replaces the arrays of the mesh.
static stp_result replace_arrays(smoother* s)
{
    stp_mesh* m = s->mesh;
    stp_mesh made = *m;
    made.vertex_count = s->vertex_count;
    made.normals = STP_NEW_ARRAY(s->context, float, 3 * (size_t)s->vertex_count + 1);
    made.positions = repeat(s, m->positions, 3 * sizeof(float));
    made.colors = repeat(s, m->colors, 4 * sizeof(uint16_t));
    bool enough = made.normals != NULL && made.positions != NULL &&
                  (m->colors == NULL || made.colors != NULL);
    for (int set = 0; set < 2; ++set) {
        made.texcoords[set] = repeat(s, m->texcoords[set], 2 * sizeof(float));
        enough = enough && (m->texcoords[set] == NULL || made.texcoords[set] != NULL);
    }
    stp_mesh* old = enough ? m : &made; // whose arrays are freed
    void* arrays[] = {old->positions, old->colors, old->texcoords[0], old->texcoords[1],
                      enough ? NULL : made.normals};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
        stp_free(s->context, arrays[i]);
    }
    if (!enough) {
        return stp_fail_memory(s->context);
    }
    uint32_t count = 3 * m->triangle_count;
    for (uint32_t i = 0; i < count; ++i) {
        memcpy(made.normals + 3 * (size_t)s->indices[i], &s->normals[i], sizeof(s->normals[i]));
        made.indices[i] = s->indices[i];
    }
    *m = made;
    return STP_OK;
}

static stp_result smooth(smoother* s)
{
    size_t triangles = s->mesh->triangle_count;
    stp_result result = find_places(s);
    if (result != STP_OK) {
        return result;
    }
    s->begins = STP_NEW_ZEROED(s->context, uint32_t, (size_t)s->place_count + 1);
    if (s->begins == NULL) {
        return stp_fail_memory(s->context);
    }
    stp_parallel_for(s->context, triangles, GRAIN, measure_faces, s);
    sort_corners(s);
    stp_parallel_for(s->context, triangles, GRAIN, find_normals, s);
    result = join_corners(s);
    return result == STP_OK ? replace_arrays(s) : result;
}

stp_result stp_smooth_mesh(stp_context* context, double degrees, stp_mesh* mesh)
{
    assert(degrees >= 0.0 && degrees <= 180.0 && mesh->normals == NULL && !mesh->spilled);
    size_t corners = 3 * (size_t)mesh->triangle_count;
    if (corners == 0 || corners > UINT32_MAX) {
        return STP_OK;
    }
    smoother s = {.context = context,
                  .mesh = mesh,
                  .minimum = (float)cos(degrees * (3.14159265358979323846 / 180.0)) - 1e-6f,
                  .faces = STP_NEW_ARRAY(context, stp_vec3, mesh->triangle_count),
                  .angles = STP_NEW_ARRAY(context, float, corners),
                  .places = STP_NEW_ARRAY(context, uint32_t, (size_t)mesh->vertex_count + 1),
                  .corners = STP_NEW_ARRAY(context, uint32_t, corners),
                  .normals = STP_NEW_ARRAY(context, stp_vec3, corners),
                  .indices = STP_NEW_ARRAY(context, uint32_t, corners),
                  .origins = STP_NEW_ARRAY(context, uint32_t, corners)};
    bool enough = s.faces != NULL && s.angles != NULL && s.places != NULL && s.corners != NULL &&
                  s.normals != NULL && s.indices != NULL && s.origins != NULL;
    stp_result result = enough ? smooth(&s) : stp_fail_memory(context);
    void* arrays[] = {s.faces,   s.angles,  s.places,  s.begins,
                      s.corners, s.normals, s.indices, s.origins};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
        stp_free(context, arrays[i]);
    }
    return result;
}

stp_result stp_import_add_mesh(stp_import* import, stp_mesh* mesh, uint32_t* index)
{
    double degrees = import->desc.smooth_degrees;
    stp_result result = degrees > 0.0 && mesh->normals == NULL
                            ? stp_smooth_mesh(import->context, degrees, mesh)
                            : STP_OK;
    if (result != STP_OK) {
        import->scene->bulk_bytes += stp_mesh_bytes(mesh); // freeing counts them down
        stp_mesh_free_arrays(import->scene, mesh);
        return result;
    }
    return stp_scene_add_mesh(import->scene, mesh, index);
}
